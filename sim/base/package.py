"""Folders of the package: beside it in the repository, inside it once installed."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def package_folder(name: str) -> Path:
    """Return the folder ``workflow`` or ``config`` of this package."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name
