"""The catalogue of figures: every entry is plain data and complete."""

from collections.abc import Iterator
from typing import Any

import pytest

from sim.claims.table import claims
from sim.figures.kind import KINDS
from sim.figures.style import PATTERNS
from sim.parameters import SYSTEMS
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import FigureSpec
from sim.study.plot_file import OBSERVABLE


def simple_values(value: Any) -> Iterator[Any]:
    """Yield the simple values in tuples and mappings of any depth."""
    if isinstance(value, dict):
        value = (*value, *value.values())
    if isinstance(value, tuple):
        for item in value:
            yield from simple_values(item)
    else:
        yield value


@pytest.mark.parametrize("name", FIGURES)
def test_an_entry_is_plain_data_that_can_be_written_down(name):
    spec = FIGURES[name]
    assert spec.name == name
    assert {type(value) for value in simple_values((*vars(spec).values(),))} <= {str, int, float}
    assert eval(repr(spec), {"FigureSpec": FigureSpec}) == spec


@pytest.mark.parametrize("name", FIGURES)
def test_an_entry_says_what_is_drawn_and_what_the_paper_says(name):
    spec = FIGURES[name]
    assert spec.kind in KINDS
    assert spec.lead.endswith(".")
    assert spec.says.startswith("The paper")
    assert spec.says.endswith(".")
    parameters = {*spec.named, *spec.axes, *spec.curves, *spec.where}
    assert spec.named
    assert parameters <= set(SYSTEMS[spec.system].model_fields)


def styles(spec: FigureSpec) -> Iterator[tuple[str, ...]]:
    options = spec.options
    yield from (*options.get("styles", {}).values(), *options.get("markers", {}).values())
    yield from (item["style"] for item in options.get("quantities", ()) if "style" in item)
    if "fast_start" in options:
        yield options["fast_start"]


@pytest.mark.parametrize("name", FIGURES)
def test_curves_of_a_figure_differ_in_colour_and_have_dashes_that_are_known(name):
    figure_styles = list(styles(FIGURES[name]))
    assert len({colour for colour, *_ in figure_styles}) == len(figure_styles)
    assert {dashes for _, dashes, *_ in figure_styles} <= set(PATTERNS)


def test_every_kind_of_plot_is_that_of_a_figure_or_of_plots_of_a_study():
    own = {f"plot_{kind}" for kind in OBSERVABLE}
    assert {spec.kind for spec in FIGURES.values()} | own == set(KINDS)


def test_levels_in_figures_are_those_of_the_verdicts():
    numbers = {claim.id: claim.number for claim in claims()}
    for name in ("G26", "G27"):
        assert FIGURES["belt_void"].options["levels"] == (numbers[name].headline,)
    for name in ("G3", "G7"):
        levels = FIGURES["onset_acceleration"].options["levels"]
        assert numbers[name].headline in levels and set(levels) <= set(numbers[name].values)
