"""What holds for every kind of plot: a kind is tested by being registered."""

import shutil
import struct
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from sim.dataset.build import build
from sim.figures import animation
from sim.figures.render import find_spec, render
from sim.study.figure_spec import FIGURES, FigureSpec
from sim.study.load import load_study
from sim.study.plottable import Keys, kinds, study_kinds
from tests import conformance  # noqa: F401  (loads the plug-ins)
from tests.figures import made_papers
from tests.made.figures import make_built_regimes, make_built_study
from tests.made.netcdf import edit_file
from tests.made.once import once
from tests.made.runs import write_run

#: Most bytes of an animation, for a quick report.
LARGEST = 1.5e6

SVG = "{http://www.w3.org/2000/svg}"

#: Keys of a study's own plots, by the kind of Talus whose they are; and by names of figures, forms
#: of kinds: that of a study's own plots, those of papers by system.
KEYS = {
    "curves": "x: friction, curves: angle",
    "map": "x: friction, y: angle, colour: velocity",
    "profiles": "x: velocity, curves: friction, panels: angle",
    "time_series": "curves: friction, panels: angle",
    "distribution": "x: friction, curves: angle",
    "likelihood": "x: friction, curves: angle",
    "scatter": "x: friction, colour: angle",
    "main_effects": "y: velocity",
}

#: Replicates that have completed: all, one, none.
STATES = {"all": None, "one": 1, "none": 0}


def like(kind: str) -> str:
    """Return the kind of Talus whose keys a kind takes."""
    keys = replace(kinds()[kind].keys, others=())
    return next(one for one in KEYS if replace(kinds()[one].keys, others=()) == keys)


def form(spec: FigureSpec) -> str:
    """Return the kind of a figure, with what else its picture depends on."""
    relative = "relative" * bool(spec.relative)
    return " ".join(filter(None, (spec.kind, spec.system if spec.paper else "own", relative)))


#: Figures of Silbert et al. are drawn as a study's own plots are.
FORMS = sorted({form(one) for one in FIGURES.values() if not one.name.startswith("silbert_")})
FORMS += [f"{kind} own" for kind in study_kinds(own=True)]

#: A form of each kind.
A_FORM = sorted({wanted.split()[0]: wanted for wanted in FORMS}.values())

#: Those of them that a study's own plots have; the others take long to draw.
OWN_FORMS = [wanted for wanted in A_FORM if wanted.endswith(" own")]


@once
def make_own(folder: Path) -> tuple[Path, Path]:
    """Make a study with a plot of each kind of a study's own."""
    path = folder / "own.yaml"
    plots = "\n".join(
        f"  - {{name: {kind}, kind: {kind}, {KEYS[like(kind)]}}}" for kind in study_kinds(own=True)
    )
    path.write_text(
        "study: own\nseries: [{name: flows, system: chute, base: {replicates: 3},\n"
        f"  grid: {{friction: [0.3, 0.4], angle: [16, 17]}}}}]\nplots:\n{plots}\n"
    )
    for number, point in enumerate(load_study(path, folder).points.values()):
        parameters, velocity = point.parameters, (0.4 + number) * np.array([1, 1.1, 1.2])
        arrays = made_papers.chute_profiles(parameters)
        write_run(folder / "own" / "runs", parameters, velocity, arrays=arrays)
    return path, build(path, folder)


MADE = (
    make_own,
    made_papers.make_dataset,
    make_built_study,
    make_built_regimes,
)


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Callable[[str], tuple[FigureSpec, Path]]:
    """Return a function: form -> a figure of it, with a dataset whose points feed it."""
    first: dict[str, tuple[FigureSpec, Path]] = {}
    makers = iter(MADE)

    def find(wanted: str) -> tuple[FigureSpec, Path]:
        while wanted not in first:
            study_path, results = next(makers)(tmp_path_factory.mktemp("made"))
            dataset = results if results.suffix else next(results.glob("*/dataset.nc"))
            study = load_study(study_path, dataset.parent.parent)
            for name in study.figures:
                spec = find_spec(name, study.plots)
                first.setdefault(form(spec), (spec, dataset))
        return first[wanted]

    return find


@pytest.fixture(autouse=True)
def small(monkeypatch) -> None:
    """Let pictures of animations, which take long, be few and small."""
    monkeypatch.setattr(animation, "FRAMES", 3)
    monkeypatch.setattr(animation, "EVERY", 13)


def with_completed(dataset: Path, replicates: int | None) -> Path:
    """Return a copy beside a dataset, of which so many replicates have completed at most."""
    if replicates is None:
        return dataset
    copy = dataset.with_name(f"dataset-{replicates}.nc")
    shutil.copy(dataset, copy)
    with edit_file(copy) as file:
        variable = file["status"]
        variable.set_auto_chartostring(False)
        failed = np.array(list("failed".ljust(variable.shape[-1], "\0")), "S1")
        variable[:, replicates:] = failed
    return copy


@pytest.mark.parametrize(
    ("wanted", "state"),
    [
        *product(FORMS, ["all"]),
        *product(OWN_FORMS, ["one"]),
        *product(A_FORM, ["none"]),
        *(
            pytest.param(wanted, "one", marks=pytest.mark.long)
            for wanted in A_FORM
            if wanted not in OWN_FORMS
        ),
    ],
)
def test_a_kind_draws_its_picture_data_and_caption(wanted, state, found, tmp_path):
    spec, dataset = found(wanted)
    files = render(spec, with_completed(dataset, STATES[state]), tmp_path)
    assert [file.name for file in files] == [spec.name + suffix for suffix in spec.suffixes]
    png, other, table, caption = files
    width, _ = struct.unpack(">II", png.read_bytes()[16:24])
    with Image.open(png) as picture:
        assert width >= 900 and picture.info["dpi"][0] >= 149.9
        assert np.ptp(np.asarray(picture.convert("L"))) > 100
    if spec.animated:
        with Image.open(other) as moving:
            assert moving.n_frames > 1 or state == "none"
            assert moving.info.get("loop", 0) == 0 and width > 2 * moving.width
            assert other.stat().st_size < LARGEST
    else:
        root = ElementTree.parse(other).getroot()
        assert root.tag == f"{SVG}svg" and len(list(root.iter(f"{SVG}path"))) > 10
    text, rows = caption.read_text(), pd.read_csv(table)
    assert text.strip() and all(line == line.strip() for line in text.splitlines())
    assert len(rows) or state == "none"
    assert ("Left out because the run failed: " in text) == (state == "none")
    assert len(rows) == 0 or any("[" in heading for heading in rows)
    if state == "all" and wanted == OWN_FORMS[0]:
        again = render(spec, dataset, tmp_path / "again")
        assert [path.read_bytes() for path in again] == [path.read_bytes() for path in files]


@pytest.mark.long
@pytest.mark.parametrize("wanted", sorted({*FORMS} - {OWN_FORMS[0]}))
def test_the_same_data_give_the_same_bytes(wanted, found, tmp_path):
    """Of one form the test above says so."""
    spec, dataset = found(wanted)
    first, second = (render(spec, dataset, tmp_path / name) for name in ("first", "second"))
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


@pytest.mark.parametrize(
    ("wanted", "value"),
    [
        pytest.param(
            wanted, value, marks=[pytest.mark.long] * (value == np.inf or wanted not in OWN_FORMS)
        )
        for wanted, value in product(A_FORM, [1e308, np.inf])
    ],
)
def test_a_number_that_no_axis_holds_is_told(wanted, value, found, tmp_path):
    spec, dataset = found(wanted)
    copy = dataset.with_name("dataset-huge.nc")
    shutil.copy(dataset, copy)
    with edit_file(copy) as file:
        for name in ("velocity", "velocity_half_width", "acceleration"):
            file[name][:] = np.where(np.isfinite(file[name][:]), value, np.nan)
    *_, table, caption = render(spec, copy, tmp_path)
    is_huge = (pd.read_csv(table).select_dtypes("number").abs() > 1e100).any(axis=None)
    assert (
        "Nothing is drawn: a number of its data is beyond 1e+100." in caption.read_text()
    ) == is_huge


def test_every_kind_is_drawn():
    # Kinds of answers have no keys of plots; tests/figures/test_answers.py draws them.
    of_answers = {name for name, kind in kinds().items() if kind.keys == Keys()}
    assert {wanted.split()[0] for wanted in FORMS} == set(kinds()) - of_answers
    assert {"section", "indices", "posterior"} <= of_answers
