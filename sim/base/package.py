"""Folders of the package: beside it in the repository, inside it once installed."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def module_names(package: str) -> tuple[str, ...]:
    """Return the names of the modules of a package of Talus, sorted."""
    folder = PACKAGE.joinpath(*package.split(".")[1:])
    return tuple(sorted(path.stem for path in folder.glob("*.py") if path.stem != "__init__"))


def package_folder(name: str) -> Path:
    """Return the folder ``workflow`` or ``config`` of this package."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name
