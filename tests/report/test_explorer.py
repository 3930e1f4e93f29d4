"""Numbers that the explorer of a report shows, and what ``predict`` prints of a surrogate."""

import gzip
import json
from base64 import b64decode

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.dataset.results import load_results
from sim.report.explorer import compressed, drawing_program, explorer_data
from sim.report.predict import predict
from sim.report.runs import run_rows, varied_parameters
from sim.study.design import Axis
from sim.study.plottable import numbers
from sim.surrogates.storage import save_surrogate
from sim.surrogates.surrogate import Surrogate
from tests.made.figures import make_figures
from tests.made.processes import refusal
from tests.made.surrogates import AXES, asked, design, made_sample, made_surrogate, smooth


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    _, results = make_figures(tmp_path_factory.mktemp("made"))
    return load_results(results / "made" / "dataset.nc").dataset


@pytest.fixture(scope="module")
def systems(dataset):
    return explorer_data(
        dataset, run_rows(dataset, []), varied_parameters(dataset), [made_surrogate()]
    )


def test_observables_are_means_of_completed_replicates_with_their_interval(dataset, systems):
    compared = 0
    for system, table in systems.items():
        rows = dataset.isel(point=(dataset["system"] == system).values)
        is_completed = rows["status"] == "completed"
        shown = [one for one in table["columns"] if one["kind"] == "observable"]
        assert "velocity" in [one["name"] for one in shown if one["half"]]
        for one in shown:
            source = numbers(system)[one["name"]].source
            means = rows[source].where(is_completed).mean("replicate").values
            np.testing.assert_allclose(np.array(one["values"], dtype=float), means, rtol=1e-3)
            compared += 1
    assert compared > 2


def test_parameters_that_do_not_vary_are_left_out(dataset, systems):
    for system, table in systems.items():
        for one in table["columns"]:
            if one["kind"] == "parameter":
                values = dataset[one["name"]].values[(dataset["system"] == system).values]
                assert len(set(values)) > 1, one["name"]


def test_a_surrogate_is_cut_along_each_of_its_parameters(systems):
    assert systems["belt"]["curves"] == []
    curves = {one["x"]: one for one in systems["chute"]["curves"]}
    assert set(curves) == {"friction", "depth"}
    surrogate = made_surrogate()
    assert curves["depth"]["note"] == (
        f"Line and band: surrogate speed and its 95 % interval ({surrogate.basis}). Held: μ = 0.5."
    )
    for row in curves["depth"]["rows"][::40]:
        answer = surrogate(friction=0.5, depth=row["depth"])
        mean, half = answer["mean"].item(), answer["half_width"].item()
        expected = pytest.approx([mean - half, mean, mean + half], rel=2e-3)
        assert [row["low"], row["mean"], row["high"]] == expected
        assert row["likely"]


def test_compressed_data_and_program_can_be_read_again(systems):
    assert json.loads(gzip.decompress(b64decode(compressed(systems)))) == systems
    program = drawing_program()
    assert b"vegaEmbed" in gzip.decompress(b64decode(program))
    assert drawing_program() == program


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of results with one surrogate, of two parameters and a law."""
    folder = tmp_path_factory.mktemp("results")
    law = Axis("law", 0, 1, choices=("walton_braun", "hertz"))
    x = design(24, 3)
    words = np.where(x[:, 0] < 0.3, "arrested", "steady")
    spec = asked((*AXES[:2], law))
    surrogate = Surrogate.fit(spec, made_sample(x, smooth(x), spec.axes, regime=words))
    save_surrogate(surrogate, folder / "surrogates" / "speed.nc")
    return folder


def ask(folder, *at, format="table", extrapolate=False, of=None):
    return predict(folder, at, of, extrapolate, format, folder)


def test_a_table_has_a_row_for_each_value_and_json_has_the_same(folder):
    at = ("depth=5", "law=hertz")
    lines = ask(folder, "friction=0.5,0.6", *at).splitlines()
    heads = "friction depth law velocity (m s-1) ± 95 % arrested steady"
    assert " ".join(lines[0].split()) == heads
    assert [line.split()[:3] for line in lines[1:3]] == [
        ["0.5", "5", "hertz"],
        ["0.6", "5", "hertz"],
    ]
    assert lines[3].startswith("surrogate speed: mean of ") and len(lines) == 4
    (row,) = json.loads(ask(folder, "friction=0.5", *at, format="json", of="velocity"))["rows"]
    assert (row["friction"], row["depth"], row["law"]) == (0.5, 5.0, "hertz")
    assert row["mean"] > 0 < row["half_width"]
    assert sum(row["probability"].values()) == pytest.approx(1)
    assert f"{row['mean']:.4g}" in lines[1]


def test_outside_it_says_by_how_much(folder):
    at = "friction=0.5", "depth=11", "law=hertz"
    with pytest.raises(InputError, match=r"speed: depth: got 11; allowed: a number in \[2, 10\]"):
        ask(folder, *at)
    assert "depth = 11 is 12 % of its range outside" in ask(folder, *at, extrapolate=True)


@pytest.mark.parametrize(
    ("at", "message"),
    [
        (["friction"], "--at: got 'friction'; allowed: PARAMETER=VALUE"),
        (["self=1"], "--at: got 'self'; allowed: one of "),
        (["extrapolate=1"], "--at: got 'extrapolate'; allowed: one of "),
        (["friction=1", "friction=2"], "--at: friction: got '2'; allowed: each parameter once"),
        (["friction=x", "depth=5", "law=hertz"], "speed: friction: got 'x'; allowed: a number"),
        (["friction=0.5", "depth=5"], "speed: law: got nothing; allowed: one of walton_braun"),
    ],
)
def test_values_that_are_none_are_refused(folder, at, message):
    with pytest.raises(InputError) as error:
        ask(folder, *at)
    assert message in str(error.value)


def test_the_command_refuses_in_one_line(folder, capsys):
    assert "surrogate: got 'packing'" in refusal(capsys, "predict", folder, "--of", "packing")
