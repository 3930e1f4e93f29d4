# Shared by all rules: the study, its plan, and the environment of the jobs.

import sys
from pathlib import Path

from snakemake.io import IOFile

# The package lies beside the workflow in the repository, and around it once installed.
FOLDERS = Path(workflow.snakefile).parents
ROOT = next(folder for folder in FOLDERS if (folder / "sim" / "__main__.py").exists())
sys.path.insert(0, str(ROOT))

from sim.base.additions import codes
from sim.base.errors import InputError
from sim.base.files import write_start
from sim.base.program import files_hash, room_hash
from sim.dataset.rounds import read_round, require_start_files
from sim.engine import shared_runs, stored_run
from sim.engine.identity import numerics_mark
from sim.engine.states import checkpoint_interval
from sim.parameters import SYSTEMS, amounts
from sim.study.command import job_environment, study_path
from sim.study.load import load_study
from sim.study.plan import Plan

try:
    # Report errors that would stop every run now, not in the log of the first run.
    checkpoint_interval()
    settings = workflow.config_settings
    STUDY = load_study(study_path(settings.configfiles, settings.config_args))
    require_start_files(STUDY)
    if STUDY.plugins and workflow.is_main_process:
        # Their files are read before anything runs.
        from sim.claims.sources import require_plugins

        require_plugins(STUDY.plugins)
    RESULTS = f"results/{STUDY.name}"
    # The main process takes runs of other studies before jobs start.
    others = shared_runs if workflow.is_main_process else None
    PLAN = Plan(STUDY, Path(RESULTS), stored_run, read_round, others)
    if workflow.is_main_process:
        PLAN.require_engines()
except (InputError, OSError) as error:
    print(f"error: {error}", file=sys.stderr)
    sys.exit(2 if isinstance(error, InputError) else 1)


def local_cores():
    """Return the number of cores that jobs share on this machine, ``None`` on a cluster."""
    try:
        return workflow.cores if workflow.is_main_process else None
    except WorkflowError:
        return None


def as_written(value):
    """Return a value as a parameter of a rule in which Snakemake looks for no wildcards.

    What a person writes may contain braces, in a title or in the path of a plug-in.
    """
    return lambda wildcards: value


def run_files(rounds):
    """Return the inputs of what reads the runs of the study and of its first ``rounds`` rounds.

    Rounds end with one that adds no point. Until the file of a round is up to date,
    ``checkpoints.refine.get`` raises an exception.
    """
    refine = (checkpoints.refine.get(round=number) for number in range(1, rounds + 1))
    return PLAN.files_to_gather((Path(job.output[0]) for job in refine), forget())


def forget():
    """Return what removes Snakemake's record of a file, ``None`` where nothing is to be written.

    While rules are read, Snakemake does not know yet whether this is a dry run.
    """
    if workflow.is_main_process and workflow.executor_plugin and not workflow.dryrun:
        return lambda path: workflow.persistence.cleanup_metadata(IOFile(path))
    return None


def take_shared():
    """Take the runs of other studies, unless this is a dry run."""
    if forget():
        PLAN.take_shared(forget())


def run_files_of(points):
    """Return the run files of points, in a dry run those that would be taken."""
    take_shared()
    return list(map(PLAN.readable_file, points))


def run_inputs(point):
    """Return the inputs of a run.

    A run file from elsewhere that is large enough needs no compiled engine. If it did, compiling
    for the other points would rerun its point.
    """
    take_shared()
    is_from_elsewhere = workflow.persistence.metadata(IOFile(PLAN.run_file(point))) is None
    is_there = is_from_elsewhere and not PLAN.needs_run(point)
    return ([] if is_there else [*rules.warm.output, START_FILE]) + PLAN.origin_files(point)


def room_code(name, kind=""):
    """Return the hash of the room that a rule uses, with the hashes of additions of a ``kind``."""
    return f"{room_hash(ROOT / 'sim', name)} {codes(kind)}".rstrip()
