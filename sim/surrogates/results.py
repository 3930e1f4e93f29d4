"""Find the surrogates in the results of a study."""

from pathlib import Path

from sim.base.errors import InputError
from sim.surrogates.refusals import Refusal, refusal_in
from sim.surrogates.storage import load as load_surrogate
from sim.surrogates.surrogate import Surrogate


def answer_files(folder: Path) -> list[Path]:
    """Return the files of all answers in a folder of results."""
    kinds = ("surrogates/*.nc", "sensitivity/*.csv", "calibration/*.nc")
    return [path for kind in kinds for path in sorted(folder.glob(kind))]


def find_surrogate(folder: Path, name: str | None = None) -> Surrogate:
    """Return a surrogate in a folder of results, by its name or by its observable.

    ``None`` stands for the only one.

    Raises
    ------
    InputError
        When there is none of that name, or several are of that observable.
    Refusal
        When the runs do not give it.
    """
    files = {path.stem: path for path in sorted((folder / "surrogates").glob("*.nc"))}
    if name in files:
        return load_surrogate(files[str(name)])
    reasons = {path: refusal_in(path) for path in files.values()}
    refusals = [text for text in reasons.values() if text]
    surrogates = [load_surrogate(path) for path, text in reasons.items() if not text]
    fitting = [one for one in surrogates if name in (None, one.observable)]
    # One that was refused may be of the observable.
    if len(fitting) + len(refusals) != 1:
        allowed = "one of " + ", ".join(files) if files else "a study with surrogates that has run"
        raise InputError.of_value(folder, "surrogate", name, allowed)
    if refusals:
        raise Refusal(refusals[0])
    return fitting[0]
