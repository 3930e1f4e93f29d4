"""``init`` and ``study``: a study file to start from, and the workflow that runs a study."""

import getpass
import os
import re
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.packaged import packaged
from sim.base.private import Unfit, caches, own_temporary, private_folder
from sim.base.program import program
from sim.study.entries import ALLOWED_NAME, NAME
from sim.study.load import load_study

#: Endings of study files.
YAML = (".yaml", ".yml")


def init(target: Path, model: str) -> str:
    """Write a study file, to be changed into one's own, and return a line that says what is next.

    Parameters
    ----------
    target : Path
        The file, after which the study is named; or a folder for one named after the model.
    model : str
        Which of the studies that come with Talus is copied.

    Raises
    ------
    InputError
        When there is no such study, the file gives no name to a study, or it is there already.
    """
    texts = _models()
    if model not in texts:
        raise InputError.of_value("--from", "", model, "one of " + ", ".join(texts))
    is_file = target.name.lower().endswith(YAML)
    path = target if is_file else target / f"{model}.yaml"
    if path.suffix not in YAML or not re.match(NAME, path.stem) or len(path.stem) > 60:
        raise InputError.of_value("init", "", str(path), f"{ALLOWED_NAME['allowed']}, then .yaml")
    require_writable(path.parent, "init")
    path.parent.mkdir(parents=True, exist_ok=True)
    named = re.compile(rf"(?<=^study: ){model}\b|\b{model}(?=\.yaml)|(?<=results/){model}\b", re.M)
    schema = f"$schema={packaged('config') / 'schema.json'}"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(named.sub(path.stem, texts[model]).replace("$schema=schema.json", schema))
    except FileExistsError:
        raise InputError(f"{path}: is there already, and stays as it is") from None
    return f"{path}: written; {program()} study {path} runs it"


def _models() -> dict[str, str]:
    """Return the texts of the studies that come with Talus by name, but of those with parts."""
    texts = {path.stem: path.read_text("utf-8") for path in packaged("config").glob("*.yaml")}
    return {name: texts[name] for name in sorted(texts) if "\nparts:" not in texts[name]}


def study(study_path: Path, cores: int | None, profile: str | None, extra: Sequence[str]) -> int:
    """Check a study, then become the Snakemake that runs it in the present folder.

    Signals and exit code are Snakemake's own, as this process turns into it.

    Parameters
    ----------
    study_path : Path
        The study file.
    cores : int, optional
        Cores to use; by default all that there are, or as many as a profile says.
    profile : str, optional
        Folder of a profile of Snakemake, or the name of one that comes with Talus.
    extra : sequence of str
        Further arguments of Snakemake.

    Raises
    ------
    InputError
        For anything that would keep the study from being run as written.
    """
    if cores is not None and cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    if str(study_path) == "-":
        raise InputError.of_value("study", "", "-", "a file: Snakemake reads it again and again")
    load_study(study_path)
    if profile:
        own = packaged("workflow") / "profiles" / profile
        extra = ["--profile", str(own if own.is_dir() else profile), *extra]
    # With a profile it would limit what is asked of a cluster.
    command = snakemake(study_path, cores or (None if profile else "all"), extra)
    sys.stdout.flush()
    os.execve(command[0], command, os.environ | _lacking())


def snakemake(study_path: Path, cores: int | str | None, extra: Sequence[str] = ()) -> list[str]:
    """Return the command that runs a study with the workflow of this package."""
    options = [] if cores is None else ["--cores", str(cores)]
    path = str(study_path)
    # Else it would be an option.
    options += ["--configfile", f"./{path}" if path.startswith("-") else path]
    # Last of the two, as a name that follows --configfile is one more of its files.
    options += ["--snakefile", str(packaged("workflow") / "Snakefile")]
    # What lies in the present folder is none of Python's business.
    return [sys.executable, "-P", "-m", "snakemake", *options, *extra]


def _lacking() -> dict[str, str]:
    """Return what Snakemake needs of the environment and does not have, as in many containers."""
    lacking = {}
    try:
        getpass.getuser()
    except (KeyError, OSError):
        lacking["USER"] = f"user{os.geteuid()}"
    try:
        require_writable(caches(), "XDG_CACHE_HOME")
    except (InputError, RuntimeError):
        try:
            lacking["XDG_CACHE_HOME"] = str(private_folder(own_temporary()))
        except (OSError, Unfit):
            lacking["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="talus-")
    return lacking
