"""The program: its name, version and folders, and the completion of its commands by the shell."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

__version__ = "0.1.0"

PACKAGE = Path(__file__).parents[1]

#: Shells that can complete the commands.
SHELLS = ("bash", "zsh")


def program() -> str:
    """Return the command that started this process: ``talus`` or ``python -m sim``."""
    return "talus" if Path(sys.argv[0]).stem == "talus" else "python -m sim"


def package_folder(name: str) -> Path:
    """Return the folder ``workflow`` or ``config`` of this package."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name


class PrintCompletion(argparse.Action):
    """Print the script that completes the command line in a shell, and end."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        # Imported here, as every command would wait for the import.
        import shtab

        parser.prog = "talus"
        _complete_files(parser)
        print(shtab.complete(parser, str(values)))
        parser.exit()


def _complete_files(parser: argparse.ArgumentParser) -> None:
    """Complete file names for all path arguments of a parser and of its commands."""
    import shtab

    for action in parser._actions:
        if action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _complete_files(command)
