"""Mistakes of users, all those of mistakes.yaml: one line that names file and key, exit code 2."""

import copy
import re
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import yaml

from sim.__main__ import main
from tests.made.processes import ROOT, restore_plugins

TABLE = Path(__file__).with_name("mistakes.yaml").read_text(encoding="utf-8")
GROUPS = yaml.load(TABLE, yaml.CSafeLoader)["mistakes"]

#: How a message begins: the file, and the key, the line or the column of a mistake in it.
PLACE = re.compile(
    r"error: [\w./-]+\.(yaml|csv): "
    r"(([\w.\[\]-]+|line \d+.*|(unit of )?column \w+): |no such file)"
)


def shipped_text(name: str) -> str:
    """Return the text of a file of docs/examples, tests/data, or of the paper that init writes."""
    folders = [ROOT / folder for folder in ("docs/examples", "tests/data", "config/paper")]
    (path,) = (folder / name for folder in folders if (folder / name).exists())
    return path.read_text(encoding="utf-8")


def with_mistake(text: Any, edit: list, before: str = "") -> Any:
    """Return a file with another text, with a piece replaced, or with keys set (null: removed)."""
    match edit:
        case [str(other)]:
            return before + other
        case [str(old), str(new)]:
            assert old in text
            return text.replace(old, new, 1)
    tree = copy.deepcopy(text)
    for path, value in edit[0].items():
        node, keys = tree, re.findall(r"\w+", path)
        *way, last = [int(key) if key.isdigit() else key for key in keys]
        for key in way:
            node = node[key]
        node[last] = value
        if value is None:
            del node[last]
    return tree


def outcome(files: dict[str, Any], command: str, capsys) -> tuple[int, str]:
    """Write files, mappings as YAML; return exit code and message of a command on them."""
    for name, text in files.items():
        text = text if isinstance(text, str) else yaml.dump(text, Dumper=yaml.CSafeDumper)
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(text, encoding="utf-8")
    has_plugin = any(name.endswith(".py") for name in files)
    with restore_plugins() if has_plugin else nullcontext():
        code = main(command.split())
    lines = capsys.readouterr().err.splitlines()
    lines = [line for line in lines if not line.startswith("plug-in ")]
    return code, "".join(lines).replace(f"{Path.cwd()}/", "")


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group["of"])
def test_a_mistake_is_one_line_that_names_file_and_key(group, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = group.get("command", "points study.yaml")
    files = {name: text or shipped_text(name) for name, text in group["files"].items()}
    edited, at = group.get("edit", "study.yaml"), group.get("at", "")
    if command.startswith("points"):
        assert outcome(files, command, capsys)[0] == 0
    wrong = {}
    for *edit, message in group["rows"]:
        if at and isinstance(edit[0], dict):
            edit = [{f"{at}.{path}": value for path, value in edit[0].items()}]
        text = with_mistake(files[edited], edit, group.get("before", ""))
        own = "" if re.match(r"\w+\.(yaml|csv): ", message) else f"{edited}: {at and at + '.'}"
        start = "error: " + group.get("start", own)
        code, line = outcome(files | {edited: text}, command, capsys)
        is_found = message in line if "start" in group else line.startswith(start + message)
        is_placed = bool(PLACE.match(line)) or "whole" in group
        if not (
            code == 2 and line.startswith(start) and is_found and is_placed and len(line) < 900
        ):
            wrong[str(edit)] = line
    assert not wrong
    assert {path.name for path in tmp_path.iterdir()} <= {Path(name).parts[0] for name in files}
