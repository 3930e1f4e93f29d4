"""Figures and animations as the report shows them."""

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pandas as pd

from sim.base.damage import checked_read
from sim.study.catalogue import FigureSpec

#: Figures of the first screen, where a study has them.
HEADLINE = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")

_MEDIA = {
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".gif": "image/gif",
    ".csv": "text/csv",
}

_KINDS = {".svg": "picture", ".png": "picture", ".gif": "animation", ".csv": "table of a figure"}

#: Pictures wider than this, in heights, get the whole width of the page.
_BROAD = 1.8

#: Columns of a table that an alternative text tells the range of.
_TOLD = 3


#: Heading of the plots that the study file itself defines.
OWN = "Plots of the study"

#: Gives the address under which a page finds a file.
Address = Callable[[Path], str]


def figure_entries(
    specs: Iterable[FigureSpec],
    folder: Path,
    claims: Sequence[Mapping[str, Any]],
    address: Address,
) -> list[dict[str, Any]]:
    """Return the entries of figures in the report, each with the ids of its claims.

    Parameters
    ----------
    specs : iterable of FigureSpec
        What they are.
    folder : Path
        Folder of their files.
    claims : sequence of mapping
        Claims with their ``id`` and the names of their ``figures``.
    address : callable
        `data_uri`, which puts the files into the page, or `beside`, which links them.

    Raises
    ------
    InputError
        When a file is missing or damaged, naming it.
    """
    return [
        {
            **figure_entry(spec, folder, address),
            "claims": [
                claim["id"]
                for claim in claims
                if spec.name in (figure["name"] for figure in claim["figures"])
            ],
        }
        for spec in specs
    ]


def figure_entry(spec: FigureSpec, folder: Path, address: Address) -> dict[str, Any]:
    """Return title, caption and addresses of the files of one figure.

    An animation has its first picture in place of the figure, and ``animation`` beside it.
    """
    name = spec.name
    files = {suffix: folder / f"{name}{suffix}" for suffix in (*_MEDIA, ".caption.txt")}
    with checked_read(files[".caption.txt"], "caption", replaceable=True):
        caption = files[".caption.txt"].read_text(encoding="utf-8").strip()
    with checked_read(files[".csv"], _KINDS[".csv"], replaceable=True):
        held = ranges(pd.read_csv(files[".csv"]))
    entry = {
        "name": name,
        "title": spec.title,
        "paper": spec.paper,
        "own": not spec.paper,
        "caption": caption,
        "data": address(files[".csv"]),
    }
    if spec.animated:
        return entry | {
            "group": "Animations",
            "alt": f"{spec.title}: first picture of an animation, {held}.",
            "broad": False,
            "picture": address(files[".png"]),
            "animation": address(files[".gif"]),
        }
    return entry | {
        "group": spec.paper.partition(",")[0] or OWN,
        "alt": f"{spec.title}: {held}.",
        "broad": _is_broad(files[".svg"]),
        "picture": address(files[".svg"]),
    }


def _is_broad(svg: Path) -> bool:
    with checked_read(svg, _KINDS[".svg"], replaceable=True):
        box = ElementTree.parse(svg).getroot().attrib["viewBox"]
        width, height = map(float, box.split()[2:])
    return width > _BROAD * height


def headline(entries: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the figures of the first screen: those of the papers' main results, or the first."""
    return [entry for entry in entries if entry["name"] in HEADLINE] or list(entries[:1])


def ranges(table: pd.DataFrame) -> str:
    """Say in words what a table of data holds: its rows and the ranges of its first numbers.

    >>> ranges(pd.DataFrame({"depth [σ]": [1, 40], "law": ["a", "b"]}))
    '2 rows of data, depth [σ] from 1 to 40'
    """
    numbers = table.select_dtypes("number")
    varying = [name for name in numbers if numbers[name].nunique() > 1]
    # What was measured comes behind the parameters, and must not be missing.
    told = dict.fromkeys(
        [*varying[:_TOLD], *(name for name in varying if name.startswith("mean velocity"))]
    )
    parts = [f"{name} from {table[name].min():.3g} to {table[name].max():.3g}" for name in told]
    return ", ".join([f"{len(table)} rows of data", *parts])


def data_uri(path: Path) -> str:
    """Return a file as a data URI."""
    with checked_read(path, _KINDS[path.suffix], replaceable=True):
        content = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{_MEDIA[path.suffix]};base64,{content}"


def beside(path: Path) -> str:
    """Return where a page finds a file of a figure in the folder ``figures`` beside it."""
    return f"figures/{path.name}"
