# What all rules share: the study, its folder, the environment of the jobs.

import json
import os
import shlex
import sys
from collections import defaultdict
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

WORKFLOW = Path(workflow.current_basedir.get_path_or_uri(secret_free=True)).parent
# The package lies beside this folder in the repository, and around it once installed.
ROOT = next(folder for folder in WORKFLOW.parents if (folder / "sim" / "__main__.py").exists())
sys.path[:0] = [str(ROOT), str(WORKFLOW)]

from helpers import age, correct_future_times, release_stale_lock, write_start

from sim.engine.states import checkpoint_interval
from sim.base.additions import codes
from sim.base.errors import InputError
from sim.base.files import read_regular, replacing
from sim.base.plugins import VARIABLE
from sim.base.rooms import files_hash, room_hash
from sim.parameters import RUN_FILE, SYSTEMS, amounts, canonical_json
from sim.engine.stored_run import holds, is_to_grow, planned_amounts
from sim.engine.identity import numerics_mark
from sim.dataset.adopted import Adopted
from sim.dataset.rounds import read_round
from sim.dataset.starts import require_start_files
from sim.study.batches import batches
from sim.study.load import DEFAULT_STUDY, estimate, load_study


def study_path():
    """Return the one study file that --configfile names, or the default.

    Snakemake merges a configfile into the one that a workflow declares. A study must be exactly
    the file named, so none is declared and the file is read by path.
    """
    if workflow.config_settings.config_args:
        raise InputError("--config: not used by Talus; edit a study file and give --configfile")
    files = [Path(path) for path in workflow.config_settings.configfiles]
    if len(files) > 1:
        raise InputError("--configfile: several files given; a study is one file")
    path = files[0] if files else DEFAULT_STUDY
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def parameters(point):
    """Return the parameters of a point of the study, of whichever round of refinement."""
    if point in STUDY.points:
        return STUDY.points[point].parameters
    for path in filter(Path.is_file, map(round_file, range(1, STUDY.rounds + 1))):
        if found := read_round(path).get(point):
            return found
    raise WorkflowError(f"{point}: no point of {STUDY.path}")


def run_file(point):
    return f"{RESULTS}/runs/{point}.nc"


def costs(points):
    """Return the estimated costs of points of the study."""
    return [estimate(parameters(point)) for point in points]


def seconds(points):
    return sum(cost.core_seconds for cost in costs(points))


def memory(megabytes):
    """Return the memory (MB) to ask for: on a cluster a job is two Snakemakes besides its command."""
    return 400 + len(STUDY.points) // 50 + megabytes


def minutes(points):
    """Return the run time (min) to ask for, three times what points are estimated to take."""
    return 10 + int(seconds(points) / 20)


def cores_here():
    """Return the cores that jobs share on this machine; none where they run on a cluster."""
    return workflow.resource_settings.cores if workflow.is_main_process else None


def origin_file(point):
    """Return the run file that a point starts from, as a list, which is empty for most."""
    start = parameters(point).start_from
    return [start if start.endswith(RUN_FILE) else run_file(start)] if start else []


def in_json(points):
    """Return the parameters of points as a JSON list."""
    return f"[{','.join(canonical_json(parameters(point)) for point in points)}]"


@cache
def amount(point):
    """Return how much the run file of a point holds, or will once it has been run, as a text.

    A run file that holds enough keeps its text, so only those that are to grow become old.
    """
    return json.dumps(planned_amounts(Path(run_file(point)), parameters(point)), sort_keys=True)


def is_wanted(point):
    """Return whether a point of the study has no run file of the present numerics with enough.

    One with less becomes old until less is wanted: Snakemake notes the parameters of a job that was
    killed as if it had been done, so these cannot tell that the file is still to grow.
    """
    path, wanted = Path(run_file(point)), parameters(point)
    is_enough = holds(path, wanted)
    age(path, not is_enough and is_to_grow(path, wanted))
    return not is_enough


def planned_batches():
    """Return the batches of short points that are to be run, or run on.

    Those of a batch are wanted in equal amounts, which are a parameter of the rule, and start from
    no other's end. Jobs that start a Snakemake of their own, as on a cluster, have the batches of the one that planned.
    """
    if not workflow.is_main_process:
        return json.loads(read_regular(PLANNED))
    alike = defaultdict(dict)
    for point in STUDY.points:
        if point not in SOURCES and is_wanted(point) and not origin_file(point):
            alike[amount(point)][point] = parameters(point)
    return {
        name: each
        for points in alike.values()
        for name, each in batches(points, cores_here()).items()
    }


def round_file(number):
    """Return the file with the points that a round of refinement adds."""
    return Path(RESULTS) / "rounds" / f"{number}.json"


def run_files(rounds):
    """Return the run files of the study and of its first rounds of refinement, and adopted datasets.

    Points that are taken from these need no run file.

    Snakemake evaluates this again after each round: until its file is up to date, asking for it
    raises.
    """
    points = [point for point in STUDY.points if point not in SOURCES]
    for number in range(1, rounds + 1):
        added = read_round(Path(checkpoints.refine.get(round=number).output[0]))
        to_run = [point for point in added if not ADOPTED.source(point, added[point])]
        for point in to_run:
            is_wanted(point)
        points += to_run
    return [*map(run_file, points), *map(str, ADOPTED.files)]


def figure_files():
    """Return the files of the figures of the study, pictures and data to stand in reports."""
    shown = {
        ".csv": ("../report/data.rst", "data"),
        ".svg": ("../report/figure.rst", "picture"),
        ".gif": ("../report/figure.rst", "animation"),
    }
    files = []
    for name, spec in STUDY.entries.items():
        for suffix in spec.suffixes:
            path = f"{RESULTS}/figures/{name}{suffix}"
            if suffix in shown and not (suffix == ".csv" and spec.animated):
                caption, kind = shown[suffix]
                labels = {"figure": name, "file": kind}
                path = report(path, caption=caption, category="Figures", labels=labels)
            files.append(update(path))
    return files


def asked():
    """Return what is asked of the boundaries of the study, for rules to rerun when it changes."""
    return [
        (one.name, one.of, one.along, one.low, one.high, one.tolerance)
        + (canonical_json(one.at(one.low)), one.figures)
        for one in STUDY.boundaries
    ]


def warn_of_namesake():
    """Say so when another study file has its results in the same folder.

    Runs are named by what their points are, so the two studies share those they have in common and
    keep the others; the rest of the folder follows whichever study file was run last.
    """
    # A damaged note names no study; the workflow writes it anew.
    with suppress(OSError, InputError, ValueError):
        other = load_study(read_regular(OWNER).decode("utf-8"), plugins=False)
        if other.name == STUDY.name and set(other.points) != set(STUDY.points):
            print(
                f"warning: {STUDY.path}: study: {STUDY.name} is also the name of {other.path}; "
                "dataset, figures and report will be those of the former",
                file=sys.stderr,
            )


def watch():
    """Start to show how the study goes; return what shows it."""
    from sim.report.failed_jobs import FailedJobs, is_news
    from sim.report.watch import Watch

    here = {key: one for key, one in STUDY.points.items() if key not in SOURCES}
    started = Watch(replace(STUDY, points=here), Path(RESULTS))
    started.start()
    logger.addFilter(is_news)
    logger.addHandler(FailedJobs(started.write))
    return started


def wake_when_jobs_end():
    """Have the scheduler look for the next job when one has ended, and not every second as well.

    Its usual limit, 100 starts in a second, leaves a timer behind for each job that has ended, which
    wakes it once a second from then on. A limit that somebody has asked for stays.
    """
    limit = workflow.scheduling_settings.max_jobs_per_timespan
    if limit and (limit.max_jobs, limit.timespan) == (100, 1):
        workflow.scheduler.job_rate_limiter = None


def summarize():
    """Say how the points of the study ended. What keeps it from that must not fail the workflow."""
    # Not needed for a dry run, which these libraries would slow.
    from sim.report.status import survey
    from sim.report.status_table import as_text

    if not workflow.is_main_process:
        return
    for started in WATCH:
        started.end()
    try:
        print(f"\n{as_text(survey(STUDY))}\n", file=sys.stderr)
    except (InputError, OSError) as error:
        print(f"no summary: {error}", file=sys.stderr)


try:
    # What keeps every run from starting is said at once, not in the log of the first.
    checkpoint_interval()
    STUDY = load_study(study_path())
    require_start_files(STUDY)
    RESULTS = f"results/{STUDY.name}"
    ADOPTED = Adopted(STUDY, Path(RESULTS))
    SOURCES = ADOPTED.sources({key: one.parameters for key, one in STUDY.points.items()})
except InputError as error:
    print(f"error: {error}", file=sys.stderr)
    sys.exit(2)

# An input of every run, older than all runs but those that are to grow.
START = Path(".snakemake") / "talus.start"
LOCK = release_stale_lock() if workflow.is_main_process else None

# What jobs ask for that read all runs, or their dataset.
READING = {
    "mem_mb": memory(700 + len(STUDY.points) // 5),
    "runtime": 20 + len(STUDY.points) // 200,
}

OWNER = Path(RESULTS) / ".study"
WARM = Path(RESULTS) / "runs" / ".warm"
PLANNED = Path(RESULTS) / "runs" / ".batches"
BATCHES = planned_batches()
WATCH = []


def room(name, added=""):
    """Return a hash of the room that a rule uses, with what plug-ins add to it.

    ``added`` is the kind of that.
    """
    return f"{room_hash(ROOT / 'sim', name)} {codes(added)}".rstrip()


if workflow.is_main_process:
    write_start(START)
    warn_of_namesake()
    correct_future_times(Path(RESULTS))


onstart:
    # Not in the Snakemake that a job on a cluster starts.
    if workflow.is_main_process:
        PLANNED.parent.mkdir(parents=True, exist_ok=True)
        for path, text in ((OWNER, str(STUDY.path.resolve())), (PLANNED, json.dumps(BATCHES))):
            with replacing(path) as temporary:
                temporary.write_text(text, encoding="utf-8")
        WATCH.append(watch())
        wake_when_jobs_end()


# Jobs find the interpreter of this Snakemake, the package and the study wherever they run. Where a
# study file lies is no parameter of its results: moved or copied, it makes nothing old.
# Modules that lie in the folder of the results are none of the program's.
ENVIRONMENT = {"PYTHONPATH": [str(ROOT)], "PYTHONSAFEPATH": ["1"]}
ENVIRONMENT["TALUS_STUDY"] = [str(STUDY.path)]
if STUDY.plugins:
    # Runs know their points alone, and not the study.
    ENVIRONMENT[VARIABLE] = [one.pinned for one in STUDY.plugins]
if not workflow.deployment_settings.deployment_method:
    # Conda and containers bring an interpreter of their own.
    ENVIRONMENT["PATH"] = [str(Path(sys.executable).parent), os.environ.get("PATH")]
    ENVIRONMENT["PYTHONPATH"].append(os.environ.get("PYTHONPATH"))
SETTINGS = " ".join(
    f"{name}={shlex.quote(':'.join(filter(None, parts)))}" for name, parts in ENVIRONMENT.items()
)
LITERAL = SETTINGS.replace("{", "{{").replace("}", "}}")
shell.prefix(f"export {LITERAL}; ")


wildcard_constraints:
    # One pattern for all points: a list of thousands would be searched for each. What only looks
    # like a point of the study is refused by `parameters`.
    point=rf"(?:{'|'.join(SYSTEMS)})-[\w.-]+-[0-9a-f]{{8}}",
    round="|".join(map(str, range(1, STUDY.rounds + 1))) or "none",
