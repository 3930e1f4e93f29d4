"""How LAMMPS is told to work: what changes its speed and no physics."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

CACHE = Path(__file__).parent / ".cache"


@dataclass(frozen=True)
class Settings:
    """Numerical settings of one LAMMPS run.

    ``skin`` and ``bin`` (diameters; bin 0: LAMMPS' own choice) of the neighbor list; ``every``,
    steps between two looks whether it is still valid; ``sort``, steps between two sortings of the
    particles in space (0: never); ``newton``, whether pairs across the cell's border are computed
    once; ``frame``, the velocity that is subtracted from everything, the plane included: ``rest``
    none, ``mean`` the flow's, ``middle`` halfway between slowest and fastest particle; ``omp``,
    whether to use the styles of the package OPENMP, on one thread.
    """

    skin: float = 0.3
    every: int = 1
    newton: bool = True
    frame: str = "rest"
    bin: float = 0.0
    sort: int = 1000
    omp: bool = False

    def arguments(self) -> list[str]:
        """Return the command line of LAMMPS."""
        quiet = ["-screen", "none", "-log", "none", "-nocite"]
        return quiet + (["-sf", "omp", "-pk", "omp", "1"] if self.omp else [])

    def list_commands(self, diameter: float) -> list[str]:
        """Return the commands that set the neighbor list for particles of this size (m)."""
        size = f" binsize {self.bin * diameter:.17g}" if self.bin else ""
        return [
            f"neighbor {self.skin * diameter:.17g} bin",
            f"neigh_modify delay 0 every {self.every} check yes{size}",
        ]

    def __str__(self) -> str:
        return (
            f"skin {self.skin:g}, every {self.every}, newton {'on' if self.newton else 'off'}, "
            f"frame {self.frame}, bin {self.bin:g}, sort {self.sort}{', omp' if self.omp else ''}"
        )


#: What ``tune`` tries, in this order, each on top of the best so far.
CANDIDATES = [
    ("frame", ["rest", "mean", "middle"]),
    ("skin", [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5]),
    ("newton", [True, False]),
    ("omp", [False, True]),
    ("every", [1, 2, 5, 10]),
    ("skin", [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5]),
    ("bin", [0.0, 0.4, 0.8, 1.2]),
    ("sort", [0, 100, 1000]),
]

#: What ``tune`` found where these benchmarks were written; used until it is run again.
BEST = {
    "soft-500": Settings(skin=0.15, every=10, frame="middle"),
    "soft-1000": Settings(skin=0.3, every=10, frame="middle"),
    "soft-4000": Settings(skin=0.3, every=5, frame="middle", sort=100),
    "soft-32000": Settings(skin=0.4, every=10, frame="middle"),
    "hard-500": Settings(skin=0.1, every=5, frame="middle"),
    "hard-1000": Settings(skin=0.15, every=10, frame="middle"),
    "hard-4000": Settings(skin=0.2, every=2, frame="middle", sort=100),
    "hard-32000": Settings(skin=0.2, every=5, frame="middle"),
    "belt": Settings(skin=0.5, every=10),
}

_FOUND = CACHE / "settings.json"


def chosen(flow: str) -> Settings:
    """Return the best settings known for a flow."""
    return Settings(**_found()[flow]) if flow in _found() else BEST[flow]


def store(flow: str, settings: Settings) -> None:
    """Remember the best settings of a flow."""
    CACHE.mkdir(exist_ok=True)
    _FOUND.write_text(json.dumps(_found() | {flow: asdict(settings)}, indent=2))


def _found() -> dict:
    return json.loads(_FOUND.read_text()) if _FOUND.exists() else {}
