"""Roles of parameters: one declaration takes effect everywhere."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sim.parameters import NUMERICAL, SYSTEMS, parse_point, point_id
from sim.parameters.roles import (
    added_parameters,
    declarations,
    id_parts,
    numerical_parameters,
    reading_parameters,
    start_parameters,
)

ROOT = Path(__file__).parents[2]
STORED_IDS = json.loads(Path(__file__).with_name("ids.json").read_text(encoding="utf-8"))

NEW_PARAMETERS = """
    humidity: Real = declare(
        40,
        symbol="H",
        unit="m s-2",
        description="how wet the air is",
        id_part="humidity",
        ge=0,
    )
    wetting: Literal["none", "full"] = declare(
        "none", description="which beads are wet", role="reading", compiled=True
    )
    patience: int = declare(
        3, unit="1", description="what is waited for", role="numerics", changes_start=True, ge=1
    )
    haste: int = declare(
        3, unit="1", description="what is not waited for", added=True, ge=1
    )

    @property
    def time_unit("""

PARAMETER_PROGRAM = """
import json
from sim.engine.command import variants
from sim.parameters import NUMERICAL, SYSTEMS, BeltParameters, field_info, parse_point, point_id
from sim.parameters import roles
from sim.parameters.words import setting
from sim.study.catalogue import FIGURES
from sim.study.reference import reference_text, schema

def place(**values):
    return repr(FIGURES["gallas_1a"].place(BeltParameters(**values)))

points = [BeltParameters(wetting=w, humidity=h) for w in ("none", "full") for h in (40, 60)]
definitions = schema()["$defs"]
print(json.dumps({
    "schema": definitions["BeltParameters"]["properties"]["humidity"],
    "lists": [name for name in ("humidity", "wetting", "patience")
              if name in definitions["BeltLists"]["properties"]],
    "reference": [line for line in reference_text().splitlines() if "`humidity`" in line],
    "ids": [point_id(point) for point in points],
    "patient": point_id(BeltParameters(patience=9)),
    "hasty": [point_id(BeltParameters(haste=haste)) for haste in (3, 4)],
    "text": [setting("belt", name, value) for name, value in
             (("humidity", 60.0), ("wetting", "full"))],
    "variants": [point.wetting for point in variants(points)],
    "readings": roles.reading_parameters(BeltParameters),
    "start": roles.start_parameters(BeltParameters),
    "numerical": "patience" in NUMERICAL and "humidity" not in NUMERICAL,
    "places": [place(humidity=1) != place(), place(wetting="full") != place(),
               place(patience=9) != place()],
}))
"""

STUDY_PROGRAM = """
import json
import jsonschema
from sim.base.errors import InputError
from sim.parameters import parse_point
from sim.study.cost import estimate
from sim.study.load import parse_study
from sim.study.reference import reference_text, schema

study = {
    "study": "s",
    "defaults": {"drum": {"replicates": 2}},
    "series": [
        {"name": "a", "system": "drum", "grid": {"frequency": [10, 20]},
         "overrides": [{"when": {"frequency": [10]}, "set": {"damping": 10}}]},
        {"name": "b", "system": "chute"},
    ],
    "boundaries": [{"name": "c", "system": "drum", "of": "transport", "along": "frequency",
                    "range": [10, 20], "tolerance": 5}],
}
jsonschema.validate(study, schema())
jsonschema.validate({"system": "drum", "frequency": 30}, schema())
loaded_study = parse_study(study, "study.yaml", None)
messages = []
for entry in ({"depth": [1]}, {"frequency": [-1]}):
    study["series"][0]["grid"] = entry
    try:
        parse_study(study, "study.yaml", None)
    except InputError as error:
        messages.append(str(error))
print(json.dumps({
    "points": {key: point.parameters.damping for key, point in loaded_study.points.items()
               if "a" in point.series},
    "boundaries": len(loaded_study.boundaries),
    "cost": all(estimate(point.parameters).core_seconds > 0
                for point in loaded_study.points.values()),
    "reference": "and drum" in reference_text(),
    "refused": messages,
}))
"""


@pytest.fixture
def package(tmp_path):
    """A copy of the package that may be changed."""
    ignore = shutil.ignore_patterns("__pycache__")
    return shutil.copytree(ROOT / "sim", tmp_path / "sim", ignore=ignore)


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")


def run_in_copy(package: Path, code: str) -> dict:
    """Return the JSON that a program prints which imports this copy of the package."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=package.parent,
        env=os.environ | {"TALUS_CACHE_DIR": str(package.parent / "cache")},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(("values", "name"), STORED_IDS, ids=[name for _, name in STORED_IDS])
def test_points_keep_their_ids(values, name):
    assert point_id(parse_point(values, "point")) == name


@pytest.mark.parametrize("model", SYSTEMS.values())
def test_roles_fit_together(model):
    assert set(start_parameters(model)) <= numerical_parameters(model)
    assert not {*id_parts(model), *reading_parameters(model)} & numerical_parameters(model)
    assert len(set(id_parts(model).values())) == len(id_parts(model))


def test_a_name_has_one_role_in_all_systems():
    for model in SYSTEMS.values():
        assert set(model.model_fields) & NUMERICAL == numerical_parameters(model)


def test_what_is_added_is_no_part_of_every_name_and_has_a_default_of_its_own():
    for model in SYSTEMS.values():
        assert not set(added_parameters(model)) & {*id_parts(model), "system"}
        assert not any(model.model_fields[name].default_factory for name in added_parameters(model))


def test_readings_are_told_choices_first():
    assert reading_parameters(SYSTEMS["chute"]) == (
        "law",
        "overlap_memory",
        "friction_cap",
        "sliding_direction",
        "tangential_ratio",
        "tangential_exponent",
    )


@pytest.mark.parametrize("model", SYSTEMS.values())
def test_the_smallest_point_is_a_point(model):
    point = model(**model.smallest_values)
    assert point.particles <= 5
    assert set(model.smallest_values) <= set(declarations(model))


def test_a_parameter_is_added_in_one_place(package):
    change(
        package / "parameters" / "belt.py", "\n    @property\n    def time_unit(", NEW_PARAMETERS
    )
    output = run_in_copy(package, PARAMETER_PROGRAM)
    assert output["schema"]["unit"] == "m s-2" and output["schema"]["symbol"] == "H"
    assert output["lists"] == ["humidity", "wetting", "patience"]
    (row,) = output["reference"]
    assert row == "| `humidity` | H (m s-2) | >= 0 | 40 | how wet the air is |"
    dry, humid, wet, both = output["ids"]
    usual = "belt-frequency20-amplitude1-angle45-damping50-shear50-humidity"
    assert dry.startswith(f"{usual}40-") and humid.startswith(f"{usual}60-")
    assert wet.startswith(f"{usual}40-wetting-full-") and both.startswith(f"{usual}60-wetting-")
    assert output["patient"].rpartition("-")[0] == dry.rpartition("-")[0]
    assert output["patient"] != dry
    usual, hasty = output["hasty"]
    assert usual == dry and "-haste4-" in hasty
    assert output["text"] == ["H = 60 m/s²", "wetting full"]
    assert output["variants"] == ["none", "full"]
    assert "wetting" in output["readings"] and "humidity" not in output["readings"]
    assert "patience" in output["start"]
    assert output["numerical"]
    assert output["places"] == [True, True, False]


def test_a_system_is_added_to_studies_by_its_parameters(package):
    folder = package / "parameters"
    belt = (folder / "belt.py").read_text(encoding="utf-8")
    drum = belt.replace("BeltParameters", "DrumParameters").replace('"belt"', '"drum"')
    (folder / "drum.py").write_text(drum, encoding="utf-8")
    old = "from sim.parameters.chute import ChuteParameters\n"
    new = f"{old}from sim.parameters.drum import DrumParameters\n"
    change(folder / "points.py", old, new)
    change(
        folder / "points.py",
        '"belt": BeltParameters,\n',
        '"belt": BeltParameters,\n    "drum": DrumParameters,\n',
    )
    output = run_in_copy(package, STUDY_PROGRAM)
    assert sorted(output["points"].values()) == [10, 50]
    assert all(key.startswith("drum-frequency") for key in output["points"])
    assert output["boundaries"] == 1
    assert output["cost"] and output["reference"]
    unknown, low = output["refused"]
    assert "series[0].grid.depth: unknown key" in unknown
    assert "series[0].grid.frequency[0]: got -1; allowed: a number > 0" in low
