"""JSON schema and parameter reference: derived from the models, written to ``config/``."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from sim.base.errors import InputError
from sim.parameters import SYSTEMS, FieldRow, field_info
from sim.study.design_file import DesignFile, Distribution
from sim.study.entries import RANGE, RANGE_SCHEMA
from sim.study.figure_spec import FIGURES
from sim.study.file import QUESTIONS, BoundaryFile
from sim.study.plot_file import BesideFile, PlotFile
from sim.study.plottable import shown_by
from sim.study.validate import file_models

BEGIN = "<!-- reference: begin; written by `talus job schema --write`, do not edit -->"
END = "<!-- reference: end -->"


def schema() -> dict[str, Any]:
    """Return the JSON schema of study files and point files.

    A file with ``system`` at its top level is a point; any other file is a study.
    """
    models: tuple[type[BaseModel], ...] = (file_models()[0], *SYSTEMS.values())
    _, definitions = models_json_schema([(model, "validation") for model in models])
    references: list[dict[str, Any]] = [{"$ref": f"#/$defs/{model.__name__}"} for model in models]
    parameters = {f"{one.capitalize()}{kind}" for one in SYSTEMS for kind in ("Some", "Lists")}
    for name in parameters | {model.__name__ for model in SYSTEMS.values()}:
        _allow_units(definitions["$defs"][name])
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
        "$defs": definitions["$defs"]
        | {RANGE: RANGE_SCHEMA, _NUMBER: {"type": ["number", "string"], "pattern": r"^[-+]?\d"}},
    }


#: Name of a number with or without a unit in the JSON schema.
_NUMBER = "Number"


def _allow_units(node: Any) -> None:
    """Let a schema of parameters allow texts such as ``2 mm`` where it has numbers."""
    if isinstance(node, dict) and node.get("type") == "number":
        node["$ref"] = f"#/$defs/{_NUMBER}"
        del node["type"]
    for child in node.values() if isinstance(node, dict) else node:
        if isinstance(child, dict | list):
            _allow_units(child)


def schema_text() -> str:
    """Return the JSON schema as the text of ``config/schema.json``."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def reference_text() -> str:
    """Return the reference of all keys and parameters as Markdown."""
    # The entries have the same keys in every system, so the first one stands for all.
    study, systems = file_models()
    entries = next(iter(systems.values()))
    models: dict[str, type[BaseModel]] = {
        "a study": study,
        "a series": entries.series,
        "a design": DesignFile,
        "the values of a parameter in a design": Distribution,
        "a boundary": entries.boundary or BoundaryFile,
        **{f"a {one.noun()}": one for one in QUESTIONS.values()},
        "a plot": PlotFile,
        "data beside a plot's own": BesideFile,
        "an override": entries.override,
    }
    parts = [*_keys(models), *_observables(), *_figures(), *_parameters()]
    return "\n\n".join(parts) + "\n"


def insert_reference(guide: str, source: str) -> str:
    """Return the text of a guide with the current reference between its markers."""
    before, begin, rest = guide.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise InputError(f"{source}: the markers of the reference are missing: {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n\n{reference_text()}\n{END}{after}"


def show(folder: Path | None) -> str | None:
    """Return the schema, or write it and the reference in ``README.md`` if a folder is given."""
    if folder is None:
        return schema_text().rstrip()
    guide = folder / "README.md"
    try:
        text = insert_reference(guide.read_text(encoding="utf-8"), str(guide))
        guide.write_text(text, encoding="utf-8")
        (folder / "schema.json").write_text(schema_text(), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{error.filename or folder}: {error.strerror}") from None
    return None


def _keys(models: Mapping[str, type[BaseModel]]) -> list[str]:
    """Return headings and lists of keys; what an earlier entry has, too, is named alone."""
    known, parts = dict[str, str](), list[str]()
    for of, model in models.items():
        lines: dict[str, list[str]] = {of: []}
        for name, field in model.model_fields.items():
            key = f"`{name}`{' (required)' * field.is_required()}"
            line = f"- {key}: {field.description or ''}"
            first = known.setdefault(line, of)
            lines.setdefault(first, []).append(line if first == of else key)
        own = lines.pop(of)
        shared = [f"- {', '.join(keys)}: as of {first}" for first, keys in lines.items()]
        parts += [f"### Keys of {of}", "\n".join(shared + own)]
    return parts


#: Letters of what an observable is, and a kind of plot that shows such.
_SHOWN = {"n": "curves", "p": "profiles", "t": "time_series"}


def _observables() -> list[str]:
    rows: dict[str, list[str]] = {}
    shown = shown_by()
    every = dict(item for kind in shown.values() for each in kind.values() for item in each.items())
    for name, observable in every.items():
        systems = [one for one in SYSTEMS if any(name in kind[one] for kind in shown.values())]
        kinds = [k for k, of in _SHOWN.items() if any(name in one for one in shown[of].values())]
        needs = f", `{observable.asked_by}`" if observable.asked_by else ""
        unit = f", {observable.unit}" if observable.unit != "1" else ""
        meaning = observable.meaning.removesuffix(", mean of all particles") + unit
        rows.setdefault(_of(systems), []).append(f"- `{name}` ({''.join(kinds)}{needs}): {meaning}")
    return _sections("Observables", {of: "\n".join(lines) for of, lines in rows.items()})


def _figures() -> list[str]:
    rows: dict[str, list[str]] = {}
    for name, spec in FIGURES.items():
        fields = field_info(SYSTEMS[spec.system])
        usual = {key: _default(field.default) for key, field in fields.items()}
        other = {key: each for key, each in spec.taken.items() if each != usual.get(key)}
        curves = f" ({', '.join(spec.groups)})" if spec.groups else ""
        vary = f"{', '.join(spec.axes)}{curves}".strip()
        told = [f"- `{name}`: {spec.title}", *[f"over {vary}"] * bool(vary)]
        told += [f"{key} {each}" for key, each in other.items()]
        told += ["any"] * (len(other) == len(spec.taken))
        rows.setdefault(f"the {spec.system}", []).append("; ".join(told))
    return _sections("Figures", {of: "\n".join(lines) for of, lines in rows.items()})


def _parameters() -> list[str]:
    systems: dict[Sequence[str], dict[str, list[str]]] = {}
    for system, model in SYSTEMS.items():
        for name, one in field_info(model).items():
            if name != "system":
                defaults = systems.setdefault(_parameter(one), {})
                defaults.setdefault(_default(one.default), []).append(system)
    rows: dict[str, list[Sequence[str]]] = {}
    for (name, symbol, allowed, meaning), defaults in systems.items():
        each = [f"{value} ({', '.join(those)})" for value, those in defaults.items()]
        default = "; ".join(each if len(each) > 1 else defaults)
        of = _of([system for those in defaults.values() for system in those])
        rows.setdefault(of, []).append((name, symbol, allowed, default, meaning))
    headings = ("parameter", "symbol (unit)", "allowed", "default", "meaning")
    return _sections("Parameters", {of: _table(headings, lines) for of, lines in rows.items()})


def _parameter(row: FieldRow) -> Sequence[str]:
    unit = row.scale or ("" if row.unit == "1" else row.unit)
    # A place in a paper alone tells a user nothing; what stands there does.
    equation = f" ({row.equation})" if ":" in row.equation or "=" in row.equation else ""
    return (
        f"`{row.name}`",
        f"{row.symbol} ({unit})" if row.symbol and unit else row.symbol or unit,
        row.allowed.removeprefix("a number ").removeprefix("an ").removeprefix("one of "),
        row.description + equation,
    )


def _of(systems: Sequence[str]) -> str:
    return "all systems" if len(systems) == len(SYSTEMS) else "the " + " and ".join(systems)


def _sections(what: str, texts: Mapping[str, str]) -> list[str]:
    shared = sorted(texts, key=lambda of: (of != "all systems", " and " not in of))
    return [part for of in shared for part in (f"### {what} of {of}", texts[of])]


def _default(value: Any) -> str:
    if isinstance(value, bool | float):
        return str(value).lower() if isinstance(value, bool) else f"{value:.12g}"
    return "derived" if value is None else str(value)


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
