"""Answer the questions of a study from its dataset: fit its surrogates and write them."""

from pathlib import Path

from sim.dataset.results import load_results
from sim.study.load import load_study
from sim.surrogates.sample import sample_points
from sim.surrogates.storage import save, summary_line
from sim.surrogates.surrogate import fit_surrogate


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write ``results/<study>/surrogates/<name>.nc`` for each surrogate of a study.

    Returns
    -------
    list of str
        A line for each: its points, its error, its core hours.

    Raises
    ------
    InputError
        When the dataset is missing, or has too few points for a surrogate.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    for spec in study.surrogates:
        save(fit_surrogate(spec, sample_points(dataset, spec)), folder / spec.file)
    return [summary_line(folder / spec.file) for spec in study.surrogates]
