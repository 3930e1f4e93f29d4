"""Answer the questions of a study from its dataset, and write the answers."""

from pathlib import Path

from sim.base.seals import read_summary
from sim.study.load import Study, load_study
from sim.surrogates import tables
from sim.surrogates.caveats import answer_name, caveats_in, sentence
from sim.surrogates.refusals import Refusal, refusal_in, save_refusal


def build(study_path: str | Path, results: str | Path = "results") -> list[str]:
    """Write the file of each question of a study, in ``results/<study>/``.

    ``surrogates/<name>.nc``, ``sensitivity/<name>.csv``, ``calibration/<name>.nc``. Where the runs
    cannot answer a question, its file says why.

    Returns
    -------
    list of str
        Lines with the answers in short.

    Raises
    ------
    InputError
        When the dataset is missing or damaged.
    """
    # Imported here, as `summary_lines` needs none of it.
    from sim.dataset.results import load_results
    from sim.surrogates.inquiries import answer

    study = load_study(study_path, results)
    folder = Path(results) / study.name
    dataset = load_results(folder / "dataset.nc")
    for question in study.questions:
        try:
            answer(question, dataset, folder)
        except Refusal as refusal:
            save_refusal(refusal, folder / question.file)
    return summary_lines(study, folder)


def summary_lines(study: Study, folder: Path) -> list[str]:
    """Return what the answers in the results of a study say of themselves, a line for each."""
    paths = [path for question in study.questions if (path := folder / question.file).is_file()]
    return list(filter(None, (refusal_in(path) or _summary_line(path) for path in paths)))


def _summary_line(path: Path) -> str:
    """Return what an answer says of itself, and what is doubtful about it."""
    if path.suffix == ".csv":
        line = tables.summary_line(path)
        line = line and f"{answer_name(path)}: {line}"
    else:
        line = str((read_summary(path) or {}).get("line", ""))
    caveats = caveats_in(path)
    return f"{line.removesuffix('.')}. {sentence(caveats)}" if caveats else line
