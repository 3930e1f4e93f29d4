"""The results of a study with its surrogates, as `sim.load` gives them."""

from dataclasses import dataclass
from pathlib import Path

from sim.base.errors import InputError
from sim.dataset import results
from sim.surrogates.storage import load as load_surrogate
from sim.surrogates.surrogate import Surrogate


@dataclass(frozen=True)
class StudyResults(results.Results):
    """The dataset of a study, and its surrogates."""

    def surrogate(self, name: str) -> Surrogate:
        """Return a surrogate of the study by its name, or the only one of an observable.

        Raises
        ------
        InputError
            When the results have no such surrogate, or its file is damaged.
        """
        return find_surrogate(self.runs.parent if self.runs else Path(), name)


def load(path: str | Path) -> StudyResults:
    """Load the results of a study.

    Parameters
    ----------
    path : str or Path
        The folder of the results, or the dataset in it.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged.
    """
    return StudyResults(**vars(results.load(path)))


def find_surrogate(folder: Path, name: str | None = None) -> Surrogate:
    """Return a surrogate in a folder of results, by its name or by its observable.

    ``None`` stands for the only one.

    Raises
    ------
    InputError
        When there is none of that name, or several are of that observable.
    """
    files = {path.stem: path for path in sorted((folder / "surrogates").glob("*.nc"))}
    if name in files:
        return load_surrogate(files[str(name)])
    surrogates = [load_surrogate(path) for path in files.values()]
    fitting = [one for one in surrogates if name in (None, one.observable)]
    if len(fitting) != 1:
        allowed = "one of " + ", ".join(files) if files else "a study with surrogates that has run"
        raise InputError.of_value(folder, "surrogate", name, allowed)
    return fitting[0]
