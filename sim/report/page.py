"""The report as a whole: its sources, its summary and its template."""

import base64
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from math import nan
from mimetypes import guess_type
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pandas as pd
import xarray as xr

from sim.base.errors import upper_first
from sim.base.files import atomic_write
from sim.base.program import __version__
from sim.base.seals import checked_read
from sim.dataset.replicates import CLOSED_SHARE
from sim.dataset.results import Results, load_current
from sim.figures.caption import parted, unit_of
from sim.figures.pictures import require_unchanged
from sim.report.claims import (
    REPORTED,
    VERDICTS,
    claim_rows,
    count_verdicts,
    has_tested_claims,
    is_on_flows,
    model_checks,
    papers_of,
    protocols_of,
    read_claims,
    reading_tables,
    tests_a_paper,
)
from sim.report.compare import opinions_of
from sim.report.explorer import compressed, drawing_program, explorer_data
from sim.report.numbers import template
from sim.report.runs import (
    boundary_rows,
    parameter_rows,
    run_rows,
    state_of,
    varied_columns,
    varied_parameters,
)
from sim.study.figure_spec import FigureSpec
from sim.study.load import Study, load_study
from sim.study.papers import paper_values, papers
from sim.surrogates.answers import answer_name, caveats_in, refusal_in, sentence
from sim.surrogates.storage import load_surrogate

#: What the files of a figure are, by suffix.
_KINDS = {".svg": "picture", ".png": "picture", ".gif": "animation", ".csv": "table of a figure"}

#: Ratio of width to height above which pictures get the whole width of the page.
_BROAD_ASPECT = 1.8

#: Number of columns whose ranges an alternative text gives.
_RANGES_SHOWN = 3

#: Kinds with pictures of shaded spheres, which a dark page shows as they are, but darker.
_SHADED = ("row",)

#: Heading of the plots that the study file itself defines.
OWN_GROUP = "Plots of the study"

#: Returns the address under which a page finds a file.
Address = Callable[[Path], str]


def figure_entry(
    spec: FigureSpec,
    folder: Path,
    address: Address,
    claims: Sequence[Mapping[str, Any]] = (),
    quote: str = "",
) -> dict[str, Any]:
    """Return title, caption, details and addresses of the files of one figure in the report.

    The ``picture`` of an animation is its first frame, and ``animation`` is its address.
    ``folder`` has the files; ``address`` is `data_uri`, which puts them into the page, or
    `relative_link`, which links them. Of ``claims``, the entry has the ids of those with the
    figure. A plot with data beside it stands with the figures of the paper that is quoted so.
    `InputError` names a file that is missing or damaged.
    """
    name = spec.name
    files = {suffix: folder / f"{name}{suffix}" for suffix in (*_KINDS, ".caption.txt")}
    with checked_read(files[".caption.txt"], "caption", replaceable=True):
        caption, details = parted(files[".caption.txt"].read_text(encoding="utf-8"))
    with checked_read(files[".csv"], _KINDS[".csv"], replaceable=True):
        data_text = describe_ranges(pd.read_csv(files[".csv"]))
    group = spec.paper.partition(",")[0] or (spec.foreign and quote) or OWN_GROUP
    moving = "first picture of an animation, " if spec.animated else ""
    return {
        "name": name,
        "title": spec.title,
        "paper": spec.paper,
        "own": not spec.paper,
        "inverts": not spec.animated and spec.kind not in _SHADED,
        "caption": caption,
        "details": details,
        "data": address(files[".csv"]),
        "claims": [one["id"] for one in claims if name in (own["name"] for own in one["figures"])],
        "group": "Animations" if spec.animated else group,
        "alt": f"{spec.title}: {moving}{data_text}.",
        "broad": not spec.animated and _is_broad(files[".svg"]),
        "picture": address(files[".png" if spec.animated else ".svg"]),
        "animation": address(files[".gif"]) if spec.animated else "",
    }


def _is_broad(svg: Path) -> bool:
    with checked_read(svg, _KINDS[".svg"], replaceable=True):
        box = ElementTree.parse(svg).getroot().attrib["viewBox"]
        width, height = map(float, box.split()[2:])
    return width > _BROAD_ASPECT * height


def describe_ranges(table: pd.DataFrame) -> str:
    """Write how many rows a table of data has, and the ranges of its first numbers.

    >>> describe_ranges(pd.DataFrame({"depth [σ]": [1, 40], "law": ["a", "b"]}))
    '2 rows of data, depth [σ] from 1 to 40'
    """
    numbers = table.select_dtypes("number")
    varying = [name for name in numbers if numbers[name].nunique() > 1]
    # The mean velocity follows the parameters and is always included.
    names = dict.fromkeys(
        [*varying[:_RANGES_SHOWN], *(name for name in varying if name.startswith("mean velocity"))]
    )
    parts = [f"{name} from {table[name].min():.3g} to {table[name].max():.3g}" for name in names]
    return ", ".join([f"{len(table)} rows of data", *parts])


def data_uri(path: Path) -> str:
    """Return a file as a data URI."""
    with checked_read(path, _KINDS[path.suffix], replaceable=True):
        content = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{guess_type(path.name)[0]};base64,{content}"


def relative_link(path: Path) -> str:
    """Return the link from a page to a file in the folder ``figures`` beside it."""
    return f"figures/{path.name}"


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/report.html`` from dataset, figures and verdicts of a study.

    It appears complete or not at all. Without a ``claims.json``, it says that the claims have not
    been judged.

    Raises `InputError` when the dataset, the verdicts or a file of a figure is damaged, when the
    dataset or a file of a figure is missing, or when the study has changed since the dataset was
    made.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    results_of_study = load_current(study, folder)
    require_unchanged(study.entries.values(), folder / "figures")
    output = folder / "report.html"
    with atomic_write(output) as temporary:
        claims = read_claims(folder / "claims.json")
        page = render(study, results_of_study, folder / "figures", claims, data_uri)
        temporary.write_text(page, encoding="utf-8")
    return output


def render(
    study: Study,
    results: Results,
    figures: Path,
    claims: list[dict[str, Any]],
    address: Address,
    left: int = 0,
) -> str:
    """Return the report of a study with its results and the folder of its figures as HTML text.

    ``claims`` are its claims with their verdicts, as `sim.claims.verdict_files` writes them; empty
    if they have not been judged. ``address`` embeds figures in the page or links them. ``left``
    points have not ended yet.
    """
    dataset, folder = results.dataset, figures.parent
    caveats = Counter(str(text) for text in dataset["caveat"].values if text).most_common()
    files = [folder / question.file for question in study.questions]
    refusals = {file: text for file in files if (text := refusal_in(file))}
    doubts = {upper_first(answer_name(file)): sentence(caveats_in(file)) for file in files}
    specs = {
        name: spec
        for name, spec in study.entries.items()
        if folder / spec.answer.file not in refusals
    }
    runs = run_rows(dataset, [text for text, _ in caveats])
    for run in runs:
        run["plots"] = [
            name
            for name, spec in specs.items()
            if name in study.plots and spec.is_fed_by(run["system"], run["series"])
        ]
    parameters = varied_parameters(dataset)
    varied, settings = varied_columns(dataset, parameters)
    all_rows = claim_rows(claims, runs, study.figures)
    of_papers = [row for row in all_rows if row["paper"] in papers()]
    counted = papers_of(of_papers, study)
    rows = [row for row in of_papers if row["paper"] in counted]
    quotes = [one.quote for name, one in papers().items() if name in counted]
    quote = quotes[0] if len(quotes) == 1 else ""
    entries = [figure_entry(spec, figures, address, rows, quote) for spec in specs.values()]
    headlines = {name for paper in papers().values() for name in paper.headline}
    answers = [folder / one.file for one in study.surrogates]
    surrogates = [load_surrogate(path) for path in answers if path not in refusals]
    order, counts = _page_order(study, entries, rows), count_verdicts(rows)
    return template("report.html.j2").render(
        study=study,
        study_files={file.name: file.read_text(encoding="utf-8") for file in study.sources},
        summary=_summary(dataset, runs),
        caveats=caveats,
        refusals=_own_reasons(list(refusals.values())),
        doubts={name: text for name, text in doubts.items() if text},
        own_claims=[row for row in all_rows if row not in of_papers],
        **order,
        verdicts=VERDICTS,
        outcomes=VERDICTS | REPORTED,
        claims=rows,
        statements=[row for row in rows if is_on_flows(row)],
        counts=counts,
        authors={name: papers()[name].author for name in counts},
        reading_tables=reading_tables(rows, results) if "claims" in order["parts"] else [],
        has_tested_claims=has_tested_claims(rows),
        checks=model_checks(rows or of_papers),
        protocols=protocols_of(rows),
        id_width=max((len(piece) for row in rows for piece in row["id"].split("_")), default=0),
        plots=[
            entry | {"points": [run for run in runs if entry["name"] in run["plots"]]}
            for entry in entries
            if entry["own"]
        ],
        headline=[entry for entry in entries if entry["name"] in headlines] or entries[:1],
        state=state_of(runs),
        left=left,
        runs=runs,
        run_numbers={run["point"]: run["number"] for run in runs},
        explorer=compressed(explorer_data(dataset, runs, parameters, surrogates)),
        drawing_program=drawing_program(),
        varied=varied,
        settings=settings,
        parameters=parameter_rows(dataset, study.units),
        written={
            (one.parameters.system, name)
            for one in study.points.values()
            for name in one.parameters.model_fields_set
        },
        velocity_unit=unit_of("m s-1", study.units, str(dataset["system"].values[0])),
        paper_values=paper_values((one.parameters for one in study.points.values()), study.paper),
        boundaries=boundary_rows(study, results.boundaries),
        opinions=opinions_of(study, dataset, folder),
        energy_limit=CLOSED_SHARE,
        is_alone=address is data_uri,
        provenance=_provenance(study, dataset),
    )


def _own_reasons(refusals: Sequence[str]) -> list[str]:
    """Return refusals without those that repeat another: of a surrogate, which is asked more."""
    return [
        text
        for text in refusals
        if not any(text != other and text.endswith(other) for other in refusals)
    ]


def _page_order(
    study: Study, entries: list[dict[str, Any]], claims: list[dict[str, Any]]
) -> dict[str, Any]:
    """Return whether a study is one's own, its gallery, and the sections after the summary.

    A study is one's own if it defines plots or feeds no figure of the papers, unless it is that of
    a paper: names one whose figures it feeds, or tests most claims of one. Its plots and points
    then come first. Figures of the papers and, if its runs test some, their claims come last.
    """
    has_tested = has_tested_claims(claims)
    of_paper = bool(study.paper and len(study.plots) < len(study.entries)) or tests_a_paper(claims)
    is_own = (bool(study.plots) or not study.figures) and not of_paper
    gallery = [entry for entry in entries if not (is_own and entry["own"])]
    parts = ["claims", "figures"] if has_tested else ["figures", "claims"]
    if is_own:
        has_parts = {"runs": True, "figures": gallery, "claims": gallery and has_tested}
        parts = [part for part, is_there in has_parts.items() if is_there]
    return {"own": is_own, "gallery": gallery, "parts": parts}


def _summary(dataset: xr.Dataset, runs: list[dict[str, Any]]) -> dict[str, Any]:
    is_completed, is_sound = dataset["status"] == "completed", dataset["caveat"] == ""
    # A function has none.
    missing_energy = dataset.get("missing_energy", nan * dataset["steps"]).where(is_completed)
    days = (dataset.attrs[name][:10] for name in ("first_run", "last_run"))
    return {
        "points": len(runs),
        "failed": sum(run["regime"] == "failed" for run in runs),
        "replicates": int((dataset["status"] != "").sum()),
        "completed": int(is_completed.sum()),
        "regimes": Counter(run["regime"] for run in runs).most_common(),
        "steps": int(dataset["steps"].sum()),
        "wall_time": float(dataset["wall_time"].sum()),
        # Not every engine tells it.
        "loop_time": float(dataset["loop_time"].sum()) if "loop_time" in dataset else 0.0,
        "missing_energy": float(missing_energy.where(is_sound).max()),
        "with_caveat": int((~is_sound).sum()),
        "dates": " to ".join(dict.fromkeys(days)),
        "talus": __version__,
    }


def _provenance(study: Study, dataset: xr.Dataset) -> dict[str, str]:
    origin = {
        "Talus": __version__,
        "Engine": dataset.attrs["engine_version"],
        "Hash of the engine's sources": dataset.attrs["source_hash"],
        "Libraries": dataset.attrs["versions"],
    }
    plugins = ", ".join(f"{plugin.name} ({plugin.code})" for plugin in study.plugins)
    return origin | ({"Plug-ins": plugins} if plugins else {})
