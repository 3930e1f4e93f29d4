"""Figures and animations as the report shows them."""

import pandas as pd
import pytest

from sim.base.errors import InputError
from sim.report.gallery import (
    data_uri,
    describe_ranges,
    figure_entry,
    headline_figures,
    relative_link,
)
from sim.study.catalogue import FIGURES
from tests.made.report import register_animation


def test_an_animation_has_its_first_picture_and_no_figure(tmp_path):
    with register_animation(tmp_path) as name:
        entry = figure_entry(FIGURES[name], tmp_path, data_uri)
        assert entry["group"] == "Animations"
        assert entry["picture"].startswith("data:image/png;base64,")
        assert entry["animation"].startswith("data:image/gif;base64,")
        (tmp_path / f"{name}.gif").unlink()
        with pytest.raises(InputError, match=rf"{name}\.gif: no such animation"):
            figure_entry(FIGURES[name], tmp_path, data_uri)


@pytest.mark.parametrize(("box", "broad"), [("0 0 460 320", False), ("0 0 900 320", True)])
def test_broad_pictures_are_told_from_others(tmp_path, box, broad):
    for suffix, text in ((".csv", "a\n1\n"), (".caption.txt", "Words."), (".svg", svg(box))):
        (tmp_path / f"walton_2{suffix}").write_text(text)
    assert figure_entry(FIGURES["walton_2"], tmp_path, relative_link)["broad"] is broad


def svg(box: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}"/>'


def test_words_for_a_table_tell_what_was_measured():
    table = pd.DataFrame({name: [1.0, 2.5] for name in ("a [σ]", "b", "c", "d")})
    table["constant"] = 3.0
    table["mean velocity [m s-1]"] = [0.1, float("nan")]
    assert (
        describe_ranges(table)
        == "2 rows of data, a [σ] from 1 to 2.5, b from 1 to 2.5, c from 1 to 2.5"
    )
    table["mean velocity [m s-1]"] = [0.1, 0.4]
    assert describe_ranges(table).endswith("mean velocity [m s-1] from 0.1 to 0.4")
    assert describe_ranges(table.head(0)) == "0 rows of data"


def test_the_first_screen_has_the_main_figures_or_the_first():
    entries = [{"name": name} for name in ("belt_onset", "gallas_1a", "walton_2")]
    assert [entry["name"] for entry in headline_figures(entries)] == ["gallas_1a", "walton_2"]
    assert headline_figures(entries[:1]) == entries[:1]
    assert headline_figures([]) == []
