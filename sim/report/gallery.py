"""Entries of figures and animations for the report."""

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pandas as pd

from sim.base.seals import checked_read
from sim.figures.caption import parted
from sim.study.figure_spec import FigureSpec
from sim.study.papers import papers

_MEDIA = {
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".gif": "image/gif",
    ".csv": "text/csv",
}

_KINDS = {".svg": "picture", ".png": "picture", ".gif": "animation", ".csv": "table of a figure"}

#: Ratio of width to height above which pictures get the whole width of the page.
_BROAD_ASPECT = 1.8

#: Number of columns whose ranges an alternative text gives.
_RANGES_SHOWN = 3


#: Kinds with pictures of shaded spheres, which a dark page shows as they are, but darker.
_SHADED = ("row",)

#: Heading of the plots that the study file itself defines.
OWN_GROUP = "Plots of the study"

#: Returns the address under which a page finds a file.
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
        The specifications of the figures.
    folder : Path
        Folder of their files.
    claims : sequence of mapping
        Claims with their ``id`` and the names of their ``figures``.
    address : callable
        `data_uri`, which puts the files into the page, or `relative_link`, which links them.

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
    """Return title, caption, details and addresses of the files of one figure.

    The ``picture`` of an animation is its first frame, and ``animation`` is its address.
    """
    name = spec.name
    files = {suffix: folder / f"{name}{suffix}" for suffix in (*_MEDIA, ".caption.txt")}
    with checked_read(files[".caption.txt"], "caption", replaceable=True):
        caption, details = parted(files[".caption.txt"].read_text(encoding="utf-8"))
    with checked_read(files[".csv"], _KINDS[".csv"], replaceable=True):
        data_text = describe_ranges(pd.read_csv(files[".csv"]))
    entry = {
        "name": name,
        "title": spec.title,
        "paper": spec.paper,
        "own": not spec.paper,
        "inverts": not spec.animated and spec.kind not in _SHADED,
        "caption": caption,
        "details": details,
        "data": address(files[".csv"]),
    }
    if spec.animated:
        return entry | {
            "group": "Animations",
            "alt": f"{spec.title}: first picture of an animation, {data_text}.",
            "broad": False,
            "picture": address(files[".png"]),
            "animation": address(files[".gif"]),
        }
    return entry | {
        "group": spec.paper.partition(",")[0] or OWN_GROUP,
        "alt": f"{spec.title}: {data_text}.",
        "broad": _is_broad(files[".svg"]),
        "picture": address(files[".svg"]),
    }


def _is_broad(svg: Path) -> bool:
    with checked_read(svg, _KINDS[".svg"], replaceable=True):
        box = ElementTree.parse(svg).getroot().attrib["viewBox"]
        width, height = map(float, box.split()[2:])
    return width > _BROAD_ASPECT * height


def headline_figures(entries: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the figures of the first screen: headlines of papers, or else the first figure."""
    names = {name for paper in papers().values() for name in paper.headline}
    return [entry for entry in entries if entry["name"] in names] or list(entries[:1])


def describe_ranges(table: pd.DataFrame) -> str:
    """Write how many rows a table of data has, and the ranges of its first numbers.

    >>> describe_ranges(pd.DataFrame({"depth [σ]": [1, 40], "law": ["a", "b"]}))
    '2 rows of data, depth [σ] from 1 to 40'
    """
    numbers = table.select_dtypes("number")
    varying = [name for name in numbers if numbers[name].nunique() > 1]
    # The mean velocity follows the parameters and is always included.
    names = dict.fromkeys(
        [*varying[:_RANGES_SHOWN], *(name for name in varying if name.startswith("mean velocity"))]
    )
    parts = [f"{name} from {table[name].min():.3g} to {table[name].max():.3g}" for name in names]
    return ", ".join([f"{len(table)} rows of data", *parts])


def data_uri(path: Path) -> str:
    """Return a file as a data URI."""
    with checked_read(path, _KINDS[path.suffix], replaceable=True):
        content = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{_MEDIA[path.suffix]};base64,{content}"


def relative_link(path: Path) -> str:
    """Return the link from a page to a file in the folder ``figures`` beside it."""
    return f"figures/{path.name}"
