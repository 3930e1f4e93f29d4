"""The catalogue of figures: every entry is plain data and complete."""

import subprocess
import sys
from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.claims.claim import claims
from sim.parameters import SYSTEMS
from sim.study import figure_spec
from sim.study.figure_spec import FIGURES, read_figures
from sim.study.papers import Paper
from sim.study.plottable import LARGEST_PORTION
from tests.made.processes import ROOT


@pytest.mark.parametrize("name", FIGURES)
def test_an_entry_says_what_is_drawn_and_what_the_paper_says(name):
    spec = FIGURES[name]
    assert spec.says.startswith("The paper") and spec.says.endswith(".") and spec.lead.endswith(".")
    parameters = {*spec.named, *spec.axes, *spec.groups, *spec.where}
    assert spec.named and parameters <= set(SYSTEMS[spec.system].model_fields)
    # Curves of one entry share its look, all others differ in colour or, of one colour, in dashes.
    styles = [*{style.entry or style.at: style for style in spec.styles}.values()]
    styles += [measure for measure in spec.quantities if measure.colour]
    assert len({(style.colour, style.dashes) for style in styles}) == len(styles)


def test_captions_say_how_much_of_the_cell_pictures_show():
    rows = [spec for spec in FIGURES.values() if spec.kind == "row"]
    assert rows
    for spec in rows:
        shows_half = spec.where["depth"] <= LARGEST_PORTION
        assert ("the half of the periodic cell near the viewer" in spec.details) is shows_half


ENTRY = """\
words: {of_beads: "of all beads below {tallest} d"}
figures:
  - name: one
    kind: curves
    about: Fig. 1
    title: Velocity
    x: frequency
    curves: [damping, shear_damping]
    styles: [{at: [0, 50], colour: red, dashes: solid, entry: none}]
    where: {amplitude: [1, 2], obstacle: 0}
    lead: Velocity {of_beads} around d_o = {obstacle:g}.
    named: [width]
    says: "The paper: it rises."
"""


def paper_in(folder: Path, name: str = "a") -> Paper:
    """Return a paper on the belt whose files lie in a folder."""
    words = {"name": name, "author": "A", "quote": "A (2000)", "system": "belt"}
    return Paper(**words, folder=folder, package=name)


def test_an_entry_becomes_what_its_figure_is(tmp_path):
    (tmp_path / "figures.yaml").write_text(ENTRY)
    (spec,) = read_figures(paper_in(tmp_path))
    assert (spec.name, spec.kind, spec.system, spec.title) == ("one", "curves", "belt", "Velocity")
    assert spec.paper == "A (2000), Fig. 1" and spec.says == "The paper: it rises."
    assert spec.lead == "Velocity of all beads below 24 d around d_o = 0."
    assert (spec.axes, spec.groups) == (("frequency",), ("damping", "shear_damping"))
    assert spec.show == "velocity" and spec.named == ["width"]
    assert spec.where == {"amplitude": (1, 2), "obstacle": 0}
    (style,) = spec.styles
    assert (style.at, style.colour, style.entry) == ((0, 50), "red", "none")

    # Curves of a paper take the keys of a plot.
    keys = "    y: backflow\n    units: natural\n    fit: linear\n    title: Vel"
    (tmp_path / "figures.yaml").write_text(ENTRY.replace("    title: Vel", keys))
    (spec,) = read_figures(paper_in(tmp_path))
    assert (spec.show, spec.units, spec.fit) == ("backflow", "natural", "linear")


def test_figures_of_one_name_are_refused(tmp_path, monkeypatch):
    same = {}
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "figures.yaml").write_text(ENTRY)
        same[name] = paper_in(tmp_path / name, name)
    monkeypatch.setattr(figure_spec, "papers", lambda: same)
    allowed = "a name that no other"
    with pytest.raises(InputError, match=rf"b/figures\.yaml: name: got 'one'; allowed: {allowed}"):
        len(figure_spec.Catalogue())


def test_the_files_are_read_when_a_figure_is_asked_for():
    code = (
        "import sim.study.entries, sim.study.figure_spec as c; assert 'data' not in vars(c.FIGURES)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_levels_in_figures_are_those_of_the_verdicts():
    numbers = {claim.id: claim.number for claim in claims()}
    for name in ("G26", "G27"):
        assert FIGURES["belt_void"].levels == [numbers[name].headline]
    for name in ("G3", "G7"):
        levels = FIGURES["onset_acceleration"].levels
        assert numbers[name].headline in levels and set(levels) <= set(numbers[name].values)
