"""Commands ``init`` (write a study file) and ``study`` (run it), and what its Snakemake needs."""

import getpass
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import (
    NotPrivateError,
    cache_folder,
    private_folder,
    require_writable,
    user_temporary_folder,
)
from sim.base.messages import one_of
from sim.base.plugins import VARIABLE, module_names
from sim.base.program import package_folder, program
from sim.study.entries import ALLOWED_NAME, NAME
from sim.study.load import DEFAULT_STUDY, folder_of_results, load_study
from sim.study.model import Study
from sim.study.papers import OWN, SHIPPED

#: Suffixes of study files.
YAML_SUFFIXES = (".yaml", ".yml")

#: Pattern of the name of a paper, with which names of claims begin.
_PAPER_NAME = r"[a-z][a-z0-9_]{0,29}"


def init(target: Path, model: str, paper: str = "") -> str:
    """Write a copy of a shipped study for the user to edit; return a line with the next command.

    ``target`` is the file, which gives the study its name, or a folder for a file named after the
    ``model``, the study to copy. With ``paper``, its name, the files of a paper of one's own are
    written, and a study of it. Raises ``InputError`` if there is no such study, the name cannot be
    one of a study or a paper, or a file exists.
    """
    if paper:
        return _init_paper(target, paper)
    files = sorted(package_folder("config").glob("*.yaml"))
    texts = {path.stem: path.read_text("utf-8") for path in files}
    texts = {name: text for name, text in texts.items() if "\nparts:" not in text}
    if model not in texts:
        raise InputError.of_value("--from", "", model, one_of(model, texts))
    is_file = target.name.lower().endswith(YAML_SUFFIXES)
    path = target if is_file else target / f"{model}.yaml"
    if path.suffix not in YAML_SUFFIXES or not re.match(NAME, path.stem) or len(path.stem) > 60:
        raise InputError.of_value("init", "", str(path), f"{ALLOWED_NAME['allowed']}, then .yaml")
    require_writable(path.parent, "init")
    path.parent.mkdir(parents=True, exist_ok=True)
    named = rf"(?<=^study: ){model}\b|\b{model}(?=\.yaml)|(?<=results/){model}\b"
    text = re.sub(named, path.stem, texts[model], flags=re.M)
    schema = f"$schema={package_folder('config') / 'schema.json'}"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text.replace("$schema=schema.json", schema))
    except FileExistsError:
        raise InputError(f"{path}: is there already, and stays as it is") from None
    return f"{path}: written; {program()} study {path} runs it"


def _init_paper(target: Path, name: str) -> str:
    """Write the folder of a paper, and its study beside it; nothing is written if one is there."""
    if not re.fullmatch(_PAPER_NAME, name) or name in (*module_names(SHIPPED), OWN):
        allowed = "up to 30 letters a-z, digits and _, a letter first, no paper of Talus"
        raise InputError.of_value("--paper", "", name, allowed)
    require_writable(target, "init")
    model = package_folder("config") / "paper"
    own = {path: path.relative_to(model).as_posix() for path in sorted(model.rglob("*.*"))}
    files = {path: target / re.sub("^mine", name, place) for path, place in own.items()}
    for path in (target / name, *files.values()):
        if os.path.lexists(path):
            raise InputError(f"{path}: is there already, and stays as it is")
    (target / name).mkdir(parents=True)
    for path, place in files.items():
        text = re.sub(r"\bmine(?![a-z])", name, path.read_text("utf-8"))
        place.write_text(text, encoding="utf-8")
    written = target / f"{name}.yaml"
    return f"{written} and {target / name}: written; {program()} study {written} runs them"


def study(
    study_path: Path, cores: int | None, profile: str | None, dry_run: bool, extra: Sequence[str]
) -> int:
    """Check a study, then replace this process by the Snakemake that runs it.

    It runs in the current folder, or in that of the study file where its results are there alone.
    Signals and exit code are therefore Snakemake's own. ``cores`` are by default the number in the
    profile, else all. ``profile`` is the folder of a Snakemake profile, or the name of one that
    comes with Talus; ``extra`` are further arguments for Snakemake.
    """
    if cores is not None and cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    if str(study_path) == "-":
        raise InputError.of_value("study", "", "-", "a file: Snakemake reads it again and again")
    loaded = load_study(study_path)
    if dry_run:
        extra = ["--dry-run", *extra]
    if profile:
        own = [package_folder("workflow") / "profiles" / profile, Path(profile).absolute()]
        folder = next((one for one in own if one.is_dir()), profile)
        extra = ["--profile", str(folder), *extra]
    study_path = go_to_results(loaded)
    # With a profile, the number of cores would limit the jobs on a cluster, too.
    command = snakemake_command(study_path, cores or (None if profile else "all"), extra)
    sys.stdout.flush()
    os.execve(command[0], command, environment())


def go_to_results(study: Study) -> Path:
    """Return the path of a study file, in the folder of it if its results are there and not here.

    That becomes the current folder, so that nothing is computed again.
    """
    results = folder_of_results(study, Path("results"))
    if results == Path("results"):
        return study.path
    print(f"{results / study.name}: has results of this study, which go on there", file=sys.stderr)
    os.chdir(study.path.parent)
    return Path(study.path.name)


def snakemake_command(file: Path, cores: int | str | None, extra: Sequence[str] = ()) -> list[str]:
    """Return the command that runs a study with the workflow of this package."""
    options = [] if cores is None else ["--cores", str(cores)]
    path = str(file)
    # A path that begins with a hyphen would be read as an option.
    options += ["--configfile", f"./{path}" if path.startswith("-") else path]
    # --configfile takes all names that follow it, so another option must come next.
    options += ["--snakefile", str(package_folder("workflow") / "Snakefile")]
    # -P: Python must import no module from the current folder.
    return [sys.executable, "-P", "-m", "snakemake", *options, *extra]


def run_with_signals(command: Sequence[str]) -> int:
    """Run a command to its end and return its exit code; signals to end are handed on to it.

    The command has a process group of its own, so that a key of the terminal sends it no second
    signal. As the terminal would, interrupts and hang-ups go to all processes of that group.
    """
    received: list[int] = []
    process = None

    def hand_on(number: int, _: object) -> None:
        received.append(number)
        if process is not None and process.poll() is None:
            send = os.kill if number == signal.SIGTERM else os.killpg
            with suppress(ProcessLookupError):
                send(process.pid, number)

    numbers = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
    handlers = {number: signal.signal(number, hand_on) for number in numbers}
    try:
        process = subprocess.Popen(command, process_group=0)
        for number in list(received):
            # It came while the process was being started.
            hand_on(number, None)
        code = process.wait()
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if received or code < 0:
        return 128 + (received[0] if received else -code)
    return code


def environment() -> dict[str, str]:
    """Return the environment of a Snakemake, with what it cannot do without."""
    missing = {}
    try:
        getpass.getuser()
    except (KeyError, OSError):
        missing["USER"] = f"user{os.geteuid()}"
    try:
        require_writable(cache_folder(), "XDG_CACHE_HOME")
    except (InputError, RuntimeError):
        try:
            missing["XDG_CACHE_HOME"] = str(private_folder(user_temporary_folder()))
        except (OSError, NotPrivateError):
            missing["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="talus-")
    return os.environ | missing


def study_path(files: Sequence[str | Path], assignments: Sequence[str]) -> Path:
    """Return the path of the one study file that --configfile names, or of the default one.

    Snakemake would merge it into one that the workflow declares, so this declares none and reads
    the file by its path. ``assignments`` are those of --config, which are refused.
    """
    if assignments:
        raise InputError("--config: not used by Talus; edit a study file and give --configfile")
    if len(files) > 1:
        raise InputError("--configfile: several files given; a study is one file")
    path = Path(files[0]) if files else DEFAULT_STUDY
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def job_environment(study: Study, package: Path, own_interpreter: bool) -> str:
    """Return the shell command by which jobs find package, study and interpreter.

    The path of a study file is no parameter of its results: a moved or copied study reruns nothing.
    ``package`` is the folder that contains ``sim``. Jobs have their own interpreter with conda
    and in containers.
    """
    # PYTHONSAFEPATH: jobs must not import modules from the folder of the results.
    variables: dict[str, list[str | None]] = {"PYTHONPATH": [str(package)], "PYTHONSAFEPATH": ["1"]}
    variables["TALUS_STUDY"] = [str(study.path)]
    if study.plugins:
        # Jobs of runs get their points only, not the study.
        variables[VARIABLE] = [plugin.pinned_name for plugin in study.plugins]
    if not own_interpreter:
        variables["PATH"] = [str(Path(sys.executable).parent), os.environ.get("PATH")]
        variables["PYTHONPATH"].append(os.environ.get("PYTHONPATH"))
    settings = (
        f"{name}={shlex.quote(':'.join(filter(None, parts)))}" for name, parts in variables.items()
    )
    return f"export {' '.join(settings)}; "
