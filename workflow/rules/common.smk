# Shared by all rules: the study, its folder, the environment of the jobs.

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
from sim.base.files import atomic_write, read_regular
from sim.base.plugins import VARIABLE
from sim.base.rooms import files_hash, room_hash
from sim.parameters import RUN_FILE, SYSTEMS, amounts, canonical_json
from sim.engine.stored_run import has_enough, needs_growth, planned_amounts
from sim.engine.identity import numerics_mark
from sim.dataset.adopted import AdoptedPoints
from sim.dataset.rounds import read_round
from sim.dataset.run_file import require_start_files
from sim.study.batches import plan_batches
from sim.study.load import DEFAULT_STUDY, estimate, load_study


def study_path():
    """Return the path of the one study file that --configfile names, or of the default one.

    Snakemake merges a configfile into the one that a workflow declares. A study must be exactly
    the named file, so the workflow declares none and reads the file by its path.
    """
    if workflow.config_settings.config_args:
        raise InputError("--config: not used by Talus; edit a study file and give --configfile")
    files = [Path(path) for path in workflow.config_settings.configfiles]
    if len(files) > 1:
        raise InputError("--configfile: several files given; a study is one file")
    path = files[0] if files else DEFAULT_STUDY
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def parameters(point):
    """Return the parameters of a point of the study, from any round of refinement."""
    if point in STUDY.points:
        return STUDY.points[point].parameters
    for path in filter(Path.is_file, map(round_file, range(1, STUDY.rounds + 1))):
        if point_parameters := read_round(path).get(point):
            return point_parameters
    raise WorkflowError(f"{point}: no point of {STUDY.path}")


def run_file(point):
    return f"{RESULTS}/runs/{point}.nc"


def estimates(points):
    """Return the estimated costs of points of the study."""
    return [estimate(parameters(point)) for point in points]


def core_seconds(points):
    return sum(cost.core_seconds for cost in estimates(points))


def job_memory(megabytes):
    """Return the memory (MB) of a job: on a cluster, it is two Snakemakes besides its command."""
    return 400 + len(STUDY.points) // 50 + megabytes


def job_minutes(points):
    """Return the run time (min) of a job: 10 min plus three times the estimate of its points."""
    return 10 + int(core_seconds(points) / 20)


def local_cores():
    """Return the number of cores that jobs share on this machine, ``None`` if it is unknown.

    It is unknown to the Snakemake of a single job, and where jobs run on a cluster.
    """
    return workflow.resource_settings.cores if workflow.is_main_process else None


def origin_file(point):
    """Return a list with the run file that a point starts from; for most points it is empty."""
    start = parameters(point).start_from
    return [start if start.endswith(RUN_FILE) else run_file(start)] if start else []


def points_json(points):
    """Return the parameters of points as a JSON list."""
    return f"[{','.join(canonical_json(parameters(point)) for point in points)}]"


@cache
def planned_amount_text(point):
    """Return a text with the amounts that the run file of a point has, or will have after its run.

    A run file with large enough amounts keeps its text, so Snakemake only reruns those to extend.
    """
    return json.dumps(planned_amounts(Path(run_file(point)), parameters(point)), sort_keys=True)


def needs_run(point):
    """True where a point lacks a run file with the present numerics and large enough amounts.

    A file with smaller amounts is dated back until they suffice. Snakemake records the parameters
    of a killed job as if it were done, so they cannot show that the file must still be extended.
    """
    path, point_parameters = Path(run_file(point)), parameters(point)
    is_enough = has_enough(path, point_parameters)
    age(path, not is_enough and needs_growth(path, point_parameters))
    return not is_enough


def batches_to_run():
    """Return a map from names of batches to their points: short points to run or to continue.

    The points of a batch have the same planned amounts, which are a parameter of the rule. None
    starts from the end of another point. A job with a Snakemake of its own, as on a cluster, reads
    the batches that the main Snakemake has planned.
    """
    if not workflow.is_main_process:
        return json.loads(read_regular(BATCHES_FILE))
    points_by_amount = defaultdict(dict)
    for point in STUDY.points:
        if point not in SOURCES and needs_run(point) and not origin_file(point):
            points_by_amount[planned_amount_text(point)][point] = parameters(point)
    return {
        name: members
        for points in points_by_amount.values()
        for name, members in plan_batches(points, local_cores()).items()
    }


def round_file(number):
    """Return the path of the file with the points that a round of refinement adds."""
    return Path(RESULTS) / "rounds" / f"{number}.json"


def run_files(rounds):
    """Return the run files of the study and of its first ``rounds`` rounds, and adopted datasets.

    Points from adopted datasets need no run file.

    Snakemake evaluates this again after each round: until the file of a round is up to date,
    ``checkpoints.refine.get`` raises an exception.
    """
    points = [point for point in STUDY.points if point not in SOURCES]
    for number in range(1, rounds + 1):
        added = read_round(Path(checkpoints.refine.get(round=number).output[0]))
        to_run = [point for point in added if not ADOPTED.source(point, added[point])]
        for point in to_run:
            needs_run(point)
        points += to_run
    return [*map(run_file, points), *map(str, ADOPTED.files)]


def figure_files():
    """Return the files of the figures of the study; pictures and data go to Snakemake's report."""
    report_entries = {
        ".csv": ("../report/data.rst", "data"),
        ".svg": ("../report/figure.rst", "picture"),
        ".gif": ("../report/figure.rst", "animation"),
    }
    files = []
    for name, spec in STUDY.entries.items():
        for suffix in spec.suffixes:
            path = f"{RESULTS}/figures/{name}{suffix}"
            if suffix in report_entries and not (suffix == ".csv" and spec.animated):
                caption, kind = report_entries[suffix]
                labels = {"figure": name, "file": kind}
                path = report(path, caption=caption, category="Figures", labels=labels)
            files.append(update(path))
    return files


def boundary_searches():
    """Return the settings of the boundaries of the study; rules rerun when they change."""
    return [
        (boundary.name, boundary.of, boundary.along)
        + (boundary.low, boundary.high, boundary.tolerance)
        + (canonical_json(boundary.parameters_at(boundary.low)), boundary.figures)
        for boundary in STUDY.boundaries
    ]


def warn_of_namesake():
    """Print a warning if another study file has its results in the same folder.

    Names of run files derive from their points. So the two studies share the runs of common points
    and keep all others; the rest of the folder follows the study file that was run last.
    """
    # A damaged note names no study; the workflow rewrites it.
    with suppress(OSError, InputError, ValueError):
        other = load_study(read_regular(OWNER_FILE).decode("utf-8"), plugins=False)
        if other.name == STUDY.name and set(other.points) != set(STUDY.points):
            print(
                f"warning: {STUDY.path}: study: {STUDY.name} is also the name of {other.path}; "
                "dataset, figures and report will be those of the former",
                file=sys.stderr,
            )


def start_watch():
    """Start to show the progress of the study; return the `Watch` that shows it."""
    from sim.report.watch import FailedJobs, Watch, is_news

    points = {key: point for key, point in STUDY.points.items() if key not in SOURCES}
    study_watch = Watch(replace(STUDY, points=points), Path(RESULTS))
    study_watch.start()
    logger.addFilter(is_news)
    logger.addHandler(FailedJobs(study_watch.write))
    return study_watch


def wake_when_jobs_end():
    """Let the scheduler look for the next job only when a job ends, not also once a second.

    Its default limit, 100 starts per second, leaves a timer for each job that ended. Each timer
    then wakes the scheduler once a second. A limit that the user has set stays.
    """
    limit = workflow.scheduling_settings.max_jobs_per_timespan
    if limit and (limit.max_jobs, limit.timespan) == (100, 1):
        workflow.scheduler.job_rate_limiter = None


def summarize():
    """Print the final status of the points; an error here must not fail the workflow."""
    # Imported here, as these libraries would slow down a dry run, which does not need them.
    from sim.report.status import survey
    from sim.report.status_table import as_text

    if not workflow.is_main_process:
        return
    for study_watch in WATCH:
        study_watch.end()
    try:
        print(f"\n{as_text(survey(STUDY))}\n", file=sys.stderr)
    except (InputError, OSError) as error:
        print(f"no summary: {error}", file=sys.stderr)


try:
    # Report errors that would stop every run now, not in the log of the first run.
    checkpoint_interval()
    STUDY = load_study(study_path())
    require_start_files(STUDY)
    RESULTS = f"results/{STUDY.name}"
    ADOPTED = AdoptedPoints(STUDY, Path(RESULTS))
    SOURCES = ADOPTED.sources({key: point.parameters for key, point in STUDY.points.items()})
except InputError as error:
    print(f"error: {error}", file=sys.stderr)
    sys.exit(2)

# Input of every run: it is older than all run files except those to extend.
START_FILE = Path(".snakemake") / "talus.start"
LOCK = release_stale_lock() if workflow.is_main_process else None

# Resources of jobs that read all runs or their dataset.
READER_RESOURCES = {
    "mem_mb": job_memory(700 + len(STUDY.points) // 5),
    "runtime": 20 + len(STUDY.points) // 200,
}

OWNER_FILE = Path(RESULTS) / ".study"
WARM_FILE = Path(RESULTS) / "runs" / ".warm"
BATCHES_FILE = Path(RESULTS) / "runs" / ".batches"
BATCHES = batches_to_run()
WATCH = []


def room_code(name, kind=""):
    """Return the hash of the room that a rule uses, with the hashes of additions of a ``kind``."""
    return f"{room_hash(ROOT / 'sim', name)} {codes(kind)}".rstrip()


if workflow.is_main_process:
    write_start(START_FILE)
    warn_of_namesake()
    correct_future_times(Path(RESULTS))


onstart:
    # Not in the Snakemake that a job on a cluster starts.
    if workflow.is_main_process:
        BATCHES_FILE.parent.mkdir(parents=True, exist_ok=True)
        for path, text in (
            (OWNER_FILE, str(STUDY.path.resolve())),
            (BATCHES_FILE, json.dumps(BATCHES)),
        ):
            with atomic_write(path) as temporary:
                temporary.write_text(text, encoding="utf-8")
        WATCH.append(start_watch())
        wake_when_jobs_end()


# Jobs find the interpreter of this Snakemake, the package and the study wherever they run. The
# path of a study file is no parameter of its results: a moved or copied study reruns nothing.
# PYTHONSAFEPATH: jobs must not import modules from the folder of the results.
ENVIRONMENT = {"PYTHONPATH": [str(ROOT)], "PYTHONSAFEPATH": ["1"]}
ENVIRONMENT["TALUS_STUDY"] = [str(STUDY.path)]
if STUDY.plugins:
    # Jobs of runs get their points only, not the study.
    ENVIRONMENT[VARIABLE] = [plugin.pinned_name for plugin in STUDY.plugins]
if not workflow.deployment_settings.deployment_method:
    # Conda and containers have an interpreter of their own.
    ENVIRONMENT["PATH"] = [str(Path(sys.executable).parent), os.environ.get("PATH")]
    ENVIRONMENT["PYTHONPATH"].append(os.environ.get("PYTHONPATH"))
SETTINGS = " ".join(
    f"{name}={shlex.quote(':'.join(filter(None, parts)))}" for name, parts in ENVIRONMENT.items()
)
ESCAPED_SETTINGS = SETTINGS.replace("{", "{{").replace("}", "}}")
shell.prefix(f"export {ESCAPED_SETTINGS}; ")


wildcard_constraints:
    # One pattern for all points, as Snakemake would search a list of thousands for each point.
    # `parameters` refuses names that match but are no point of the study.
    point=rf"(?:{'|'.join(SYSTEMS)})-[\w.-]+-[0-9a-f]{{8}}",
    round="|".join(map(str, range(1, STUDY.rounds + 1))) or "none",
