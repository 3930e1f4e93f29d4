"""A surrogate is called with values of its parameters, and read as it was written."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import read_summary
from sim.study.design import Axis
from sim.study.load import load_study
from sim.surrogates.storage import find_surrogate, load_surrogate, save_surrogate
from sim.surrogates.surrogate import Surrogate
from tests.made.netcdf import edit_file
from tests.made.processes import restore_plugins
from tests.made.surrogates import AXES, asked, design, made_sample, made_surrogate, smooth

LAW = Axis("law", 0, 1, choices=("walton_braun", "hertz"))


@pytest.fixture(scope="module")
def surrogate():
    return made_surrogate()


@pytest.fixture(scope="module")
def mixed():
    """A surrogate of three regimes and two laws, whose mean is of flows that are surely steady."""
    x = design(40, 3)
    words = np.where(x[:, 0] < 0.3, "arrested", "steady").astype(object)
    words[:3], mean = "undetermined", smooth(x) + (x[:, 2] >= 0.5)
    spec = asked((*AXES[:2], LAW), regimes=["steady"])
    return Surrogate.fit(spec, made_sample(x, mean, spec.axes, error=0.01, regime=words))


def test_a_call_gives_mean_half_width_and_probabilities(surrogate):
    answer = surrogate(friction=0.5, depth=6.0)
    exact = smooth(np.array([[0.5, 0.5]]))[0]
    assert float(answer["mean"]) == pytest.approx(exact, rel=0.02)
    assert abs(float(answer["mean"]) - exact) < float(answer["half_width"])
    assert answer["probability"].sel(regime="steady") == 1
    assert answer["mean"].attrs["units"] == "m s-1" and not answer["mean"].dims
    rough = made_surrogate(lambda x: 2 + np.sin(40 * x[:, 0]) * np.cos(37 * x[:, 1]))
    assert answer.attrs["error"] == surrogate.error < 0.02 < 0.2 < rough.error
    assert not answer.attrs["caveats"]
    mean, error = surrogate.predict(np.array([[0.5, 6.0], [0.6, 3.0]]))
    assert (surrogate.parameters, surrogate.scales) == (("friction", "depth"), ("linear", "linear"))
    assert surrogate.bounds.tolist() == [[0.2, 0.8], [2.0, 10.0]]
    assert float(answer["mean"]) == pytest.approx(mean[0], rel=1e-8)
    assert float(answer["half_width"]) == pytest.approx(1.96 * error[0], rel=1e-3)
    # Parameters of all points may be given.
    same = surrogate(friction=0.5, depth=6.0, restitution=0.85, law="walton_braun")
    assert same["mean"] == answer["mean"]


def test_arrays_are_labelled_dimensions(surrogate):
    answer = surrogate(friction=[0.3, 0.4, 0.5], depth=[4.0, 6.0])
    assert answer["mean"].dims == ("friction", "depth") and answer["mean"].shape == (3, 2)
    assert answer["probability"].dims == ("regime", "friction", "depth")
    one = surrogate(friction=0.4, depth=6.0)
    assert float(answer["mean"].sel(friction=0.4, depth=6)) == pytest.approx(float(one["mean"]))
    along = xr.DataArray([0.3, 0.5], dims="case")
    paired = surrogate(friction=along, depth=xr.DataArray([4.0, 6.0], dims="case"))
    assert paired["mean"].dims == ("case",)
    assert float(paired["mean"][1]) == pytest.approx(
        float(answer["mean"].sel(friction=0.5, depth=6))
    )
    # Columns of a table share its index.
    table = pd.DataFrame({"friction": [0.3, 0.5], "depth": [4.0, 6.0]}, index=[7, 9])
    columns = surrogate(friction=table["friction"], depth=table["depth"])
    assert columns["mean"].values.tolist() == paired["mean"].values.tolist()
    assert columns["mean"].to_series().index.tolist() == [7, 9]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"friction": 0.9}, "speed: friction: got 0.9; allowed: a number in [0.2, 0.8]"),
        ({"depth": [3.0, 11.0]}, "speed: depth: got 11; allowed: a number in [2, 10]"),
        ({"frction": 0.5}, "did you mean friction? allowed: one of friction, depth"),
        ({"friction": "high"}, "speed: friction: got 'high'; allowed: a number in"),
        ({"friction": np.nan}, "speed: friction: got nan; allowed: a number in"),
        ({"friction": [[0.5]]}, "a number, a list of numbers, or an array of xarray"),
        ({"restitution": 0.9}, "restitution: got 0.9; allowed: 0.85, as"),
    ],
)
def test_what_it_cannot_predict_is_refused(surrogate, values, message):
    given = {"friction": 0.5, "depth": 5.0} | values
    with pytest.raises(InputError) as error:
        surrogate(**given)
    assert message in str(error.value)


def test_extrapolation_says_how_far(surrogate):
    answer = surrogate(friction=0.86, depth=5.0, extrapolate=True)
    outside = "friction = 0.86 is 10 % of its range outside [0.2, 0.8]"
    assert answer.attrs["caveats"].startswith(outside)
    inside = surrogate(friction=0.8, depth=5.0)
    assert float(answer["half_width"]) > float(inside["half_width"])
    log = made_surrogate(axes=AXES[1:])
    with pytest.raises(InputError, match="stiffness: got 0;"):
        log(depth=5.0, stiffness=0.0, extrapolate=True)


def test_other_regimes_are_left_out_of_the_mean_and_counted(mixed):
    assert mixed.omissions == "12 arrested, 3 undetermined"
    assert len(mixed.process.y) == 25 and set(mixed.regimes.names) == {"arrested", "steady"}
    answer = mixed(friction=[0.22, 0.7], depth=5.0, law="hertz")
    low, high = answer["probability"].sel(regime="arrested").values
    assert low > 0.9 and high < 0.1


def test_a_large_error_is_called_too_large_to_rely_on(mixed):
    assert re.fullmatch(r"mean of 25 of 40 points, error [0-9.]+ %", mixed.basis)
    x = design(8, 2)
    scattered = np.random.default_rng(1).choice([0.1, 10.0], 8)
    spec = asked()
    weak = Surrogate.fit(spec, made_sample(x, scattered))
    assert re.fullmatch(r"mean of 8 of 8 points, error \d+ %", weak.basis)
    assert re.fullmatch(r"its error of \d+ % is too large to rely on", weak.caveats[0])


def test_words_are_chosen(mixed):
    assert mixed.choices == {"law": ("walton_braun", "hertz")}
    means = [float(mixed(friction=0.6, depth=5.0, law=law)["mean"]) for law in LAW.choices]
    assert means[1] - means[0] == pytest.approx(1, abs=0.25)
    one_law = mixed.at(law="hertz")
    assert one_law.predict(np.array([[0.6, 5.0]]))[0][0] == pytest.approx(means[1])
    with pytest.raises(InputError, match="law: got nothing; allowed: one of walton_braun, hertz"):
        mixed(friction=0.6, depth=5.0)
    with pytest.raises(InputError, match="law: got 'hooke'; allowed: one of walton_braun, hertz"):
        mixed.at(law="hooke")


@pytest.mark.parametrize(("parameters", "fewest"), [(1, 4), (3, 9)])
def test_the_fewest_points_grow_with_the_parameters(parameters, fewest):
    axes = tuple(Axis(f"x{number}", 0.0, 1.0) for number in range(parameters))
    spec, x = asked(axes), design(fewest, parameters)
    values = 1 + x[:, 0]
    assert len(Surrogate.fit(spec, made_sample(x, values, axes)).process.y) == fewest
    with pytest.raises(InputError, match=f"and {fewest} are needed"):
        Surrogate.fit(spec, made_sample(x[1:], values[1:], axes))


def test_a_form_that_fits_is_found_told_and_kept(tmp_path):
    """A belt's velocity as physics has it: a share of that of the belt, 0 below its onset."""
    axes = (Axis("frequency", 15, 100), Axis("amplitude", 0.5, 1.5))
    x = design(32, 2)
    frequency, amplitude = 15 + 85 * x[:, 0], (0.5 + x[:, 1]) * 1e-3
    speed, strength = amplitude * 2 * np.pi * frequency, amplitude * (2 * np.pi * frequency) ** 2
    values = speed * (1 - 1 / np.maximum(strength / 10, 1))
    sample = made_sample(x, values, axes, 1e-4)
    sample.attrs["fixed"] = {"diameter": 1e-3, "gravity": 10.0, "vibration_angle": 45.0}
    surrogate = Surrogate.fit(asked(axes, "belt"), sample)
    assert surrogate.process.frame.form.name == "efficiency_of_shaking"
    assert "as a share of the belt's velocity" in surrogate.basis
    save_surrogate(surrogate, tmp_path / "speed.nc")
    fresh = np.column_stack([np.linspace(15, 100, 9), np.linspace(1.5, 0.5, 9)])
    loaded = load_surrogate(tmp_path / "speed.nc")
    for one, other in zip(surrogate.predict(fresh), loaded.predict(fresh), strict=True):
        assert one == pytest.approx(other, rel=1e-9)
    truth = 1e-3 * fresh[:, 1] * 2 * np.pi * fresh[:, 0]
    truth *= 1 - 1 / np.maximum(1e-4 * fresh[:, 1] * (2 * np.pi * fresh[:, 0]) ** 2, 1)
    assert surrogate.predict(fresh)[0] == pytest.approx(truth, abs=2e-3)


FORM = """\
import sim
sim.form(
    "kinked", system="chute", observable="velocity", meaning="with a kink at a depth of 5",
    scale=lambda p: 1 + abs(p["depth"] - 5),
)
"""


def form_study(folder, text=FORM):
    """Return the path of a study that asks for a surrogate, with a plug-in that declares a form."""
    (folder / "kink.py").write_text(text)
    path = folder / "study.yaml"
    path.write_text(
        "study: s\nplugins: [kink.py]\nsurrogate: [{name: speed, series: wide}]\nseries:\n"
        "  - {name: wide, system: chute, design: {kind: sobol, points: 16,"
        " over: {friction: [0.3, 0.8], depth: [2, 10]}}}\n"
    )
    return path


def test_a_form_of_a_plugin_is_found_and_needed_again(tmp_path):
    with restore_plugins():
        (spec,) = load_study(form_study(tmp_path), None).surrogates
        x = design(16, 2)
        values = (1 + x[:, 1]) * (1 + np.abs(8 * x[:, 0] - 3))
        surrogate = Surrogate.fit(spec, made_sample(x, values, spec.axes))
        assert surrogate.basis.endswith(", with a kink at a depth of 5")
        save_surrogate(surrogate, tmp_path / "speed.nc")
        fresh = np.array([[0.5, 4.0]])
        assert (
            load_surrogate(tmp_path / "speed.nc").predict(fresh)[0] == surrogate.predict(fresh)[0]
        )
    with pytest.raises(InputError, match="no plug-in that is loaded declares its form kinked"):
        load_surrogate(tmp_path / "speed.nc")


def test_the_observable_of_a_form_is_one_of_its_system(tmp_path):
    path = form_study(tmp_path, FORM.replace('"velocity"', '"transport_efficiency"'))
    message = r"plug-in kink.py \(\w+\): form kinked: observable is one of .*: got 'transport_eff"
    with restore_plugins(), pytest.raises(InputError, match=message):
        load_study(path, None)


def test_a_file_gives_the_same_predictions(mixed, tmp_path):
    path = tmp_path / "surrogates" / "speed.nc"
    save_surrogate(mixed, path)
    again = load_surrogate(path)
    x = np.random.default_rng(1).random((50, 2)) * [0.6, 8] + [0.2, 2]
    first, second = (one.at(law="hertz") for one in (mixed, again))
    for ours, theirs in zip(first.predict(x), second.predict(x), strict=True):
        assert theirs == pytest.approx(ours, rel=1e-9)
    assert second.probability(x) == pytest.approx(first.probability(x), rel=1e-9)
    assert (again.error, again.coverage, again.axes) == (mixed.error, mixed.coverage, mixed.axes)
    assert read_summary(path)["line"].startswith(
        "surrogate speed: 25 points (12 arrested, 3 undetermined left"
    )
    assert find_surrogate(tmp_path, "speed").name == find_surrogate(tmp_path, "velocity").name


def test_foreign_files_are_refused(surrogate, tmp_path):
    path = tmp_path / "speed.nc"
    with pytest.raises(InputError, match="no such surrogate"):
        load_surrogate(path)
    save_surrogate(surrogate, path)
    with edit_file(path) as file:
        file.format = "another"
    with pytest.raises(InputError, match="damaged or not a surrogate"):
        load_surrogate(path)
    path.write_text("a text")
    with pytest.raises(InputError, match="damaged or not a surrogate") as error:
        load_surrogate(path)
    assert "\n" not in str(error.value) and path.exists()


def test_places_without_a_run_near_them_are_told():
    """Points on a diagonal: a process knows nothing of the corners beside it, and does not know."""
    line = np.linspace(0, 1, 16)
    spec = asked()
    surrogate = Surrogate.fit(spec, made_sample(np.column_stack([line, line]), 1 + line))
    assert not surrogate(friction=0.5, depth=6.0).attrs["caveats"]
    told = surrogate(friction=[0.2, 0.5], depth=10.0).attrs["caveats"]
    assert told.startswith("at 2 of 2 places no run is near")
    assert made_surrogate()(friction=[0.2, 0.8], depth=[2.0, 10.0]).attrs["caveats"] == ""


def test_points_that_do_not_tell_of_each_other_are_told():
    """The error is small beside the mean size, not beside what varies."""
    x = design(32, 2)
    values = 5 + 0.2 * np.sin(40 * x[:, 0]) * np.cos(37 * x[:, 1])
    spec = asked()
    surrogate = Surrogate.fit(spec, made_sample(x, values))
    assert surrogate.error < 0.1 and surrogate.process.unexplained_share > 0.5
    assert "of the variance of each other" in surrogate.caveats[0]


def test_a_word_with_few_points_is_told():
    x = design(16, 3)
    x[:, 2] = 0.9 * (np.arange(16) == 15)
    spec = asked((*AXES[:2], LAW))
    surrogate = Surrogate.fit(spec, made_sample(x, smooth(x), spec.axes))
    assert "law = hertz has 1 point" in surrogate.caveats
