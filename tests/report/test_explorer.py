"""Numbers that the explorer of a report shows."""

import gzip
import json
from base64 import b64decode

import numpy as np
import pytest

from sim.dataset.results import load_results
from sim.report.explorer import compressed, drawing_program, explorer_data
from sim.report.runs import run_rows, varied_parameters
from sim.study.plottable import numbers
from tests.made.figures import make_figures
from tests.made.surrogates import made_surrogate


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
