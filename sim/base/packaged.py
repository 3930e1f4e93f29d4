"""Where folders of the package lie: beside it in the repository, within it once installed."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def packaged(name: str) -> Path:
    """Return the folder ``workflow`` or ``config`` of this package."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name
