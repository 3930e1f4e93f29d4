"""JSON schema and parameter reference: derived from the models, written to ``config/``."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from sim.base.errors import InputError
from sim.parameters import SYSTEMS, FieldRow, field_info
from sim.study.calibration import CalibrateFile
from sim.study.catalogue import FIGURES
from sim.study.design import DesignFile, Distribution
from sim.study.entries import RANGE, RANGE_SCHEMA
from sim.study.plot_file import BesideFile, PlotFile
from sim.study.plottable import shown_by
from sim.study.sensitivity import SensitivityFile
from sim.study.surrogate import SurrogateFile
from sim.study.validate import file_models

SCHEMA_NAME = "schema.json"
GUIDE_NAME = "README.md"
BEGIN = "<!-- reference: begin; written by `talus schema --write`, do not edit -->"
END = "<!-- reference: end -->"


def schema() -> dict[str, Any]:
    """Return the JSON schema of study files and point files.

    A file with ``system`` at its top level is a point; any other file is a study.
    """
    models: tuple[type[BaseModel], ...] = (file_models().study, *SYSTEMS.values())
    _, definitions = models_json_schema([(model, "validation") for model in models])
    references: list[dict[str, Any]] = [{"$ref": f"#/$defs/{model.__name__}"} for model in models]
    study, point, *others = references
    for system, other in zip(list(SYSTEMS)[1:], others, strict=True):
        condition = {"properties": {"system": {"const": system}}}
        point = {"if": condition, "then": other, "else": point}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Talus study or point",
        "type": "object",
        "if": {"required": ["system"]},
        "then": point,
        "else": study,
        "$defs": definitions["$defs"] | {RANGE: RANGE_SCHEMA},
    }


def schema_text() -> str:
    """Return the JSON schema as the text of ``config/schema.json``."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def reference_text() -> str:
    """Return the reference of all keys and parameters as Markdown."""
    # The entries have the same keys in every system, so the first one stands for all.
    file = file_models()
    entries = next(iter(file.systems.values()))
    parts = [
        "### Keys of a study",
        _keys_table(file.study),
        "### Keys of a series",
        _keys_table(entries.series),
        "### Keys of a design",
        _keys_table(DesignFile),
        "### Keys of the values of a parameter in a design",
        _keys_table(Distribution),
        "### Keys of a boundary",
        _keys_table(entries.boundary),
        "### Keys of a surrogate",
        _keys_table(SurrogateFile),
        "### Keys of a sensitivity",
        _keys_table(SensitivityFile),
        "### Keys of a calibration",
        _keys_table(CalibrateFile),
        "### Keys of a plot",
        _keys_table(PlotFile),
        "### Keys of data beside a plot's own",
        _keys_table(BesideFile),
        "### Keys of an override",
        _keys_table(entries.override),
        "### Keys of `defaults`",
        _keys_table(file.defaults),
        "### Keys of `readings`",
        _keys_table(file.readings),
    ]
    parts += ["### Observables", _observables_table(), "### Figures", _figures_table()]
    for name, model in SYSTEMS.items():
        rows = [row for row in field_info(model).values() if row.name != "system"]
        parts += [f"### Parameters of the {name}", _parameters_table(rows)]
    return "\n\n".join(parts) + "\n"


def insert_reference(guide: str, source: str) -> str:
    """Return the text of a guide with the current reference between its markers.

    Raises
    ------
    InputError
        If a marker is missing, or they are in the wrong order.
    """
    before, begin, rest = guide.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise InputError(f"{source}: the markers of the reference are missing: {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n\n{reference_text()}\n{END}{after}"


def show(folder: Path | None) -> str | None:
    """Return the schema, or write it and the reference if a folder is given."""
    if folder is None:
        return schema_text().rstrip()
    write(folder)
    return None


def write(folder: Path) -> None:
    """Write ``schema.json`` and the reference in ``README.md`` of ``folder``.

    Raises
    ------
    InputError
        If the guide is missing or has no markers, or a file cannot be written.
    """
    guide = folder / GUIDE_NAME
    try:
        text = insert_reference(guide.read_text(encoding="utf-8"), str(guide))
        guide.write_text(text, encoding="utf-8")
        (folder / SCHEMA_NAME).write_text(schema_text(), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{error.filename or folder}: {error.strerror}") from None


def _keys_table(model: type[BaseModel]) -> str:
    rows = [
        (f"`{name}`", "yes" if field.is_required() else "no", field.description or "")
        for name, field in model.model_fields.items()
    ]
    return _table(("key", "required", "meaning"), rows)


def _observables_table() -> str:
    entries: dict[str, dict[str, Any]] = {}
    for system in SYSTEMS:
        for kind, observables in shown_by().items():
            for observable in observables[system].values():
                entry = entries.setdefault(
                    observable.name, {"observable": observable, "kinds": {}, "systems": {}}
                )
                entry["kinds"][kind] = entry["systems"][system] = True
    rows = [
        (
            f"`{name}`",
            ", ".join(entry["kinds"]),
            ", ".join(entry["systems"]),
            entry["observable"].unit,
            entry["observable"].meaning.removesuffix(", mean of all particles"),
            f"`{entry['observable'].asked_by}`" if entry["observable"].asked_by else "",
        )
        for name, entry in entries.items()
    ]
    return _table(("observable", "shown by", "system", "unit", "meaning", "needs"), rows)


def _figures_table() -> str:
    return _table(
        (
            "figure",
            "shows",
            "of",
            "system",
            "its points must vary",
            "its curves vary",
            "it takes only",
        ),
        [
            (
                f"`{spec.name}`",
                spec.title,
                spec.paper,
                spec.system,
                ", ".join(spec.axes),
                ", ".join(spec.curves),
                "; ".join(f"{name} {values}" for name, values in spec.taken.items()),
            )
            for spec in FIGURES.values()
        ],
    )


def _parameters_table(rows: Iterable[FieldRow]) -> str:
    headings = ("parameter", "symbol", "unit", "allowed", "default", "meaning", "source")
    return _table(
        headings,
        [
            (
                f"`{row.name}`",
                row.symbol,
                row.scale or ("" if row.unit == "1" else row.unit),
                row.allowed,
                _default(row.default),
                row.description,
                row.equation,
            )
            for row in rows
        ],
    )


def _default(value: Any) -> str:
    match value:
        case None:
            return "derived"
        case bool():
            return str(value).lower()
        case float():
            return f"{value:.12g}"
    return str(value)


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
