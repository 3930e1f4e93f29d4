"""Commands ``init`` (write a study file to start from) and ``study`` (run a study)."""

import getpass
import os
import re
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import (
    NotPrivateError,
    cache_folder,
    private_folder,
    require_writable,
    user_temporary_folder,
)
from sim.base.program import package_folder, program
from sim.study.entries import ALLOWED_NAME, NAME
from sim.study.load import load_study

#: Suffixes of study files.
YAML_SUFFIXES = (".yaml", ".yml")


def init(target: Path, model: str) -> str:
    """Write a copy of a shipped study for the user to edit; return a line with the next command.

    Parameters
    ----------
    target : Path
        The file, which gives the study its name; or a folder, for a file named after the model.
    model : str
        Name of the study to copy, one of those that come with Talus.

    Raises
    ------
    InputError
        If there is no such study, the file's name cannot name a study, or the file exists.
    """
    texts = _template_texts()
    if model not in texts:
        raise InputError.of_value("--from", "", model, "one of " + ", ".join(texts))
    is_file = target.name.lower().endswith(YAML_SUFFIXES)
    path = target if is_file else target / f"{model}.yaml"
    if path.suffix not in YAML_SUFFIXES or not re.match(NAME, path.stem) or len(path.stem) > 60:
        raise InputError.of_value("init", "", str(path), f"{ALLOWED_NAME['allowed']}, then .yaml")
    require_writable(path.parent, "init")
    path.parent.mkdir(parents=True, exist_ok=True)
    name_pattern = re.compile(
        rf"(?<=^study: ){model}\b|\b{model}(?=\.yaml)|(?<=results/){model}\b", re.M
    )
    schema = f"$schema={package_folder('config') / 'schema.json'}"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(
                name_pattern.sub(path.stem, texts[model]).replace("$schema=schema.json", schema)
            )
    except FileExistsError:
        raise InputError(f"{path}: is there already, and stays as it is") from None
    return f"{path}: written; {program()} study {path} runs it"


def _template_texts() -> dict[str, str]:
    """Return the texts of the studies that come with Talus by name, except those with parts."""
    texts = {path.stem: path.read_text("utf-8") for path in package_folder("config").glob("*.yaml")}
    return {name: texts[name] for name in sorted(texts) if "\nparts:" not in texts[name]}


def study(study_path: Path, cores: int | None, profile: str | None, extra: Sequence[str]) -> int:
    """Check a study, then replace this process by the Snakemake that runs it in the current folder.

    Signals and exit code are therefore Snakemake's own.

    Parameters
    ----------
    study_path : Path
        The study file.
    cores : int, optional
        Number of cores to use; by default the number in the profile, else all cores.
    profile : str, optional
        Folder of a Snakemake profile, or the name of one that comes with Talus.
    extra : sequence of str
        Further arguments for Snakemake.

    Raises
    ------
    InputError
        For any mistake that prevents the study from being run as written.
    """
    if cores is not None and cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    if str(study_path) == "-":
        raise InputError.of_value("study", "", "-", "a file: Snakemake reads it again and again")
    load_study(study_path)
    if profile:
        own = package_folder("workflow") / "profiles" / profile
        extra = ["--profile", str(own if own.is_dir() else profile), *extra]
    # With a profile, the number of cores would limit the jobs on a cluster, too.
    command = snakemake_command(study_path, cores or (None if profile else "all"), extra)
    sys.stdout.flush()
    os.execve(command[0], command, os.environ | _missing_environment())


def snakemake_command(
    study_path: Path, cores: int | str | None, extra: Sequence[str] = ()
) -> list[str]:
    """Return the command that runs a study with the workflow of this package."""
    options = [] if cores is None else ["--cores", str(cores)]
    path = str(study_path)
    # A path that begins with a hyphen would be read as an option.
    options += ["--configfile", f"./{path}" if path.startswith("-") else path]
    # --configfile takes all names that follow it, so another option must come next.
    options += ["--snakefile", str(package_folder("workflow") / "Snakefile")]
    # -P: Python must import no module from the current folder.
    return [sys.executable, "-P", "-m", "snakemake", *options, *extra]


def _missing_environment() -> dict[str, str]:
    """Return the environment variables that Snakemake needs and that many containers lack."""
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
    return missing
