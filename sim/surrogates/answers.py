"""Answer the questions of a study from its dataset, and write the answers."""

from pathlib import Path

from sim.base.seals import read_summary
from sim.study.load import Study, load_study


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write the file of each question of a study, in ``results/<study>/``.

    ``surrogates/<name>.nc``, ``sensitivity/<name>.csv``, ``calibration/<name>.nc``.

    Returns
    -------
    list of str
        Lines with the answers in short.

    Raises
    ------
    InputError
        When the dataset is missing, or has too few points for an answer.
    """
    # Imported here, as `summary_lines` needs none of it.
    from sim.dataset.results import load_results
    from sim.surrogates import inquiries
    from sim.surrogates.fitting import fit_surrogate
    from sim.surrogates.sample import sample_points
    from sim.surrogates.storage import save

    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    for spec in study.surrogates:
        save(fit_surrogate(spec, sample_points(dataset, spec)), folder / spec.file)
    for sensitivity in study.sensitivities:
        inquiries.answer_sensitivity(sensitivity, dataset, folder)
    for calibration in study.calibrations:
        inquiries.answer_calibration(calibration, folder)
    return summary_lines(study, folder)


def summary_lines(study: Study, folder: Path) -> list[str]:
    """Return what the answers in the results of a study say of themselves, a line for each."""
    files = (folder / question.file for question in study.questions)
    summaries = (read_summary(path) for path in files if path.is_file())
    return [str(summary["line"]) for summary in summaries if summary]
