"""A made-up study with all contents of a report: verdicts of each kind, an animation."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import pandas as pd
from PIL import Image

from sim.claims.claim import Claim, First, Number
from sim.claims.judgement import Judgement, Variant
from sim.claims.verdict import Check
from sim.claims.verdict_files import write
from sim.dataset.results import load_results
from sim.report.claims import read_claims
from sim.report.page import data_uri, render
from sim.study.figure_spec import FIGURES, FigureSpec
from sim.study.load import load_study
from sim.surrogates.storage import save_surrogate
from tests.made.figures import make_figures
from tests.made.once import once
from tests.made.surrogates import asked, made_surrogate

ANIMATION = "animation_made"

#: Points of the made-up study that its checks name, by system.
DEPTH, FREQUENCY = "depth5-friction0.4", "frequency50-amplitude1-angle30"

BOUNDARY = """\
study: onset
boundaries:
  - {name: onset, system: belt, of: transport, along: frequency, range: [11, 27], tolerance: 0.25}
"""

BOUNDARY_ROW = {"name": "onset", "system": "belt", "along": "frequency", "unit": "Hz"}
BOUNDARY_ROW |= {"low": 15.75, "high": float("nan"), "below": "no transport", "above": "transport"}
BOUNDARY_ROW |= {"verdict": "none", "points": 7}


def made_claims(points: list[str]) -> list[Judgement]:
    """Return judgements of claims; W9 depends on the protocol, G4 on a reading."""
    chute = next(point for point in points if DEPTH in point)
    belt = next(point for point in points if FREQUENCY in point)
    good = Check("ρ of V and n", 0.91, 0.02, 0.5, 1.5, points=(chute,), samples=40.0)
    bad = replace(good, value=0.2)
    open_ = Check("onset at α = 30°", 16.9, 0.4, 15.0, 17.0, "Hz", (belt, chute), 12.0)
    unknown = Check("spread", float("nan"), float("inf"), float("-inf"), 1.0, "Hz", (belt,), 9.0)
    trend = replace(good, half_width=float("nan"), tested=(0.01, 0.99))
    model = Check("error of e", 1e-5, 0.0, float("-inf"), 1e-3)
    strange, small = replace(open_, value=20.0), replace(open_, value=16.0)
    parts = replace(bad, part="a"), replace(good, part="b")
    withheld = replace(good, part="a"), replace(trend, part="b", withheld="too young")
    said = {"parts": {"a": "18 Hz", "b": "Γ = 0.8"}, "contradiction": "18 Hz is not Γ = 0.8"}
    converged, published = partial(Variant, "converged"), partial(Variant, "published")
    return [
        _judged("W1", "Restitution", Variant("model", "default", (model,)), kind="model"),
        _judged(
            "W9",
            "Deeper is faster",
            *(converged("default", (good,)), published("default", (bad, good))),
            figures=["walton_2"],
            instead="Runs of a fixed length do not tell depths apart.",
        ),
        _judged(
            "G3",
            "Onset near 16 Hz",
            converged("default", (open_, unknown)),
            published("default", reason="no boundary at α = 30°"),
            figures=["gallas_1a", "belt_onset"],
        ),
        _judged(
            "G4",
            "Onset whatever γ",
            *(one("default", (strange,)) for one in (converged, published)),
            converged("belt_ghost false", (small,)),
        ),
        _judged("G6", "Onset at a small amplitude", published("default", parts), **said),
        _judged(
            "G13",
            "Stiffness hardly matters",
            published("default", (bad,), checks_by_number={0.1: (good,), 0.15: (bad,), 0.77: ()}),
            number=Number(bound="margin", what="weak", values=[0.1, 0.15, 0.77], headline=0.15),
        ),
        _judged(
            "W21",
            "Stiffer is slower",
            published("default", withheld),
            parts={"a": "shallow", "b": "deep"},
        ),
        _judged(
            "G31",
            "Obstacles slow the flow",
            *(one("default", reason="no obstacle") for one in (converged, published)),
        ),
    ]


def _judged(name: str, title: str, *variants: Variant, **others) -> Judgement:
    claim = Claim(
        id=name,
        title=title,
        statement=f"What the paper says: {title.lower()}.",
        place="Sec. 3",
        criterion="the criterion & its <limits>",
        reason="noise of the proposed one",
        needs="chutes and belts",
        judge=print,
        paper={"W": "walton", "G": "gallas"}[name[0]],
        system={"W": "chute", "G": "belt"}[name[0]],
        first=First(verdict="inconclusive", criterion="another", why="a band of ours"),
        **others,
    )
    return Judgement(claim, variants)


def write_claims(path: Path, points: list[str]) -> None:
    """Write the judgements of the made-up claims as JSON and as CSV."""
    write(made_claims(points), "made", path.parent)


@contextmanager
def register_animation(folder: Path) -> Iterator[str]:
    """Make the files of an animation in ``folder`` and register it; yield its name."""
    pictures = [Image.new("RGB", (64, 48), (shade, 90, 160)) for shade in (40, 120, 200)]
    pictures[0].save(folder / f"{ANIMATION}.png")
    pictures[0].save(
        folder / f"{ANIMATION}.gif", save_all=True, append_images=pictures[1:], duration=80, loop=0
    )
    (folder / f"{ANIMATION}.csv").write_text("point,x [m]\na,1\na,2\n")
    (folder / f"{ANIMATION}.caption.txt").write_text("A made-up animation.\n")
    words = {"title": "A flow that moves", "paper": "Walton (1993), Sec. 3"}
    spec = FigureSpec.model_construct(name=ANIMATION, kind="animation", system="chute", **words)
    with patch.dict(FIGURES, {ANIMATION: spec}):
        yield ANIMATION


@once
def make_page(folder: Path) -> tuple[Path, Path]:
    """Write a report with all that there can be, a surrogate included; return study and report."""
    study_path, results = make_figures(folder)
    made = results / "made"
    study = load_study(study_path, results)
    write_claims(made / "claims.json", list(study.points))
    (folder / "onset.yaml").write_text(BOUNDARY)
    bounds = load_study(folder / "onset.yaml", results)
    with register_animation(made / "figures") as name:
        study = replace(
            study,
            boundaries=bounds.boundaries,
            entries=study.entries | {name: FIGURES[name]},
            questions=(asked(),),
        )
        save_surrogate(made_surrogate(), made / study.surrogates[0].file)
        page = render(
            study,
            replace(load_results(made / "dataset.nc"), boundaries=pd.DataFrame([BOUNDARY_ROW])),
            made / "figures",
            read_claims(made / "claims.json"),
            data_uri,
        )
    path = made / "report.html"
    path.write_text(page, encoding="utf-8")
    return study_path, path
