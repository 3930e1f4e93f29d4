"""The schema and the reference agree with the models, and the guide's examples work."""

import json
import re
from pathlib import Path

import jsonschema
import pytest
import yaml

from sim.__main__ import main
from sim.base.additions import TALUS, AdditionError, attribute_additions_to, shipped
from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.parameters import SYSTEMS, BeltParameters, canonical_values, parse_point
from sim.parameters.choices import extended
from sim.parameters.laws import MOTION, law
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study, parse_study
from sim.study.plottable import study_kinds
from sim.study.reference import BEGIN, END, insert_reference, reference_text, schema, schema_text
from tests.made.processes import restore_plugins

CONFIG = Path(__file__).parents[2] / "config"
GUIDE = (CONFIG / "README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```yaml\n(.*?)```", GUIDE, flags=re.DOTALL)
REMEDY = "run: python -m sim job schema --write"


@pytest.fixture(scope="module")
def validator():
    document = schema()
    jsonschema.Draft202012Validator.check_schema(document)
    return jsonschema.Draft202012Validator(document)


def test_schema_and_reference_are_up_to_date_and_name_every_parameter_and_figure():
    assert (CONFIG / "schema.json").read_text(encoding="utf-8") == schema_text(), REMEDY
    assert insert_reference(GUIDE, "README.md") == GUIDE, REMEDY
    text = reference_text()
    names = {name for model in SYSTEMS.values() for name in model.model_fields} - {"system"}
    assert all(f"| `{name}` |" in text for name in names)
    assert all(f"- `{name}`: " in text for name in FIGURES)
    for table in re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE):
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()}) == 1


def test_shipped_studies_and_points_satisfy_the_schema(validator):
    for path in CONFIG.glob("*.yaml"):
        validator.validate(yaml.safe_load(path.read_text()))
    for system in SYSTEMS:
        validator.validate({"system": system})
        validator.validate(canonical_values(parse_point({"system": system}, "point")))


GRID = {"study": "s", "series": [{"name": "a", "system": "chute", "grid": {"friction": [0.3]}}]}
AT = {"name": "a", "system": "chute", "of": "flow", "along": "angle", "range": [10, 20]}
EDGE = {"study": "s", "boundaries": [AT | {"tolerance": 1}]}


@pytest.mark.parametrize(
    ("study", "change"),
    [
        *(
            (GRID, {"grid": grid})
            for grid in (
                *({"restitution": one} for one in ([0.85, 1.5], [0], [], 0.85, ["high"], [None])),
                *({"restituton": [0.85]}, {"frequency": [20]}, {"angle": [90]}, {}, None),
            )
        ),
        *((EDGE, {"of": "transport"}), (EDGE, {"along": "seed"}), (EDGE, {"range": [1]})),
        *((EDGE, {"range": None}), (EDGE, {"name": "a b"})),
    ],
)
def test_the_schema_refuses_what_the_models_refuse(study, change, validator, tmp_path):
    validator.validate(study)
    parse_study(study, "study", tmp_path)
    ((key, (entry,)),) = ((key, value) for key, value in study.items() if key != "study")
    changed = study | {key: [entry | change]}
    assert not validator.is_valid(changed) and not validator.is_valid({"study": "s"})
    with pytest.raises(InputError):
        parse_study(changed, "study", tmp_path)


def test_examples_of_the_guide_work(tmp_path, monkeypatch):
    study, boundaries = EXAMPLES
    (tmp_path / "study.yaml").write_text(study)
    loaded = load_study(tmp_path / "study.yaml", tmp_path)
    assert len(loaded.points) == 10
    assert list(loaded.figures) == ["walton_2"]
    (tmp_path / "boundaries.yaml").write_text(f"study: limits\n{boundaries}")
    limits = load_study(tmp_path / "boundaries.yaml", tmp_path)
    assert [limit.grid["depth"] for limit in limits.boundaries] == [5, 10, 20]
    assert list(limits.figures) == ["regimes_angle"]
    # The error that the guide shows is the real one.
    monkeypatch.chdir(tmp_path)
    Path("my-study.yaml").write_text(study.replace("0.85]", "1.2]"))
    (guide_error,) = re.findall(r"^error: (my-study.yaml.*)$", GUIDE, flags=re.MULTILINE)
    with pytest.raises(InputError) as caught:
        load_study("my-study.yaml")
    assert str(caught.value) == guide_error


def test_schema_is_printed_and_written(tmp_path, capsys):
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == schema()
    (tmp_path / "README.md").write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    assert main(["schema", "--write", str(tmp_path)]) == 0
    assert (tmp_path / "schema.json").read_text(encoding="utf-8") == schema_text()
    guide = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert guide == f"before\n{BEGIN}\n\n{reference_text()}\n{END}\nafter\n"
    # A guide without markers is left alone.
    (tmp_path / "README.md").write_text("by hand\n")
    for folder in (tmp_path, tmp_path / "nowhere"):
        assert main(["schema", "--write", str(folder)]) == 2
    assert "markers" in capsys.readouterr().err
    assert (tmp_path / "README.md").read_text() == "by hand\n"


def test_the_row_of_the_laws_is_what_each_says_of_itself():
    (row, *_) = [line for line in reference_text().splitlines() if line.startswith("| `law` |")]
    texts = [f"{name} ({one.description})" for name, one in shipped("law").items()]
    assert len(texts) > 3 and all(text in row for text in texts)
    said = schema()["$defs"]["ChuteParameters"]["properties"]["law"]["description"]
    assert said in row and said.startswith("contact law: walton_braun (")
    with (
        pytest.raises(AdditionError, match="one: description: got ''; allowed: text, not empty"),
        attribute_additions_to(TALUS),
    ):
        law("one", **dict.fromkeys(("make", "force", "energy", "collision_time"), print))


def test_the_motions_are_what_each_says_of_itself(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\n"
        "sim.motion('slow', make=dict, state=lambda m, a: (0, 0, 0), description='a slow one')\n"
        "sim.motion('fast', make=dict, state=lambda m, a: (0, 0, 0))\n"
    )
    with restore_plugins():
        load_plugins(path)
        said = extended(BeltParameters, MOTION).model_fields["motion"].description
    usual = shipped("motion")["harmonic"].description
    assert said == f"motion of the base: harmonic ({usual}), slow (a slow one), fast"


def test_every_kind_of_plot_is_told():
    plots = (CONFIG.parent / "docs" / "plots.md").read_text(encoding="utf-8")
    for kind in study_kinds():
        assert f"`{kind}`" in GUIDE and f"`{kind}`" in plots, kind
