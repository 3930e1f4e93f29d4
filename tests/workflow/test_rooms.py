"""An edit reruns the rules of its room and of the rooms above it, but no run."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from sim.base.program import room_hash
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from tests.made.project import copy_tree, planned_jobs, snakemake

STUDY = """\
study: rooms
series:
  - {name: flows, system: chute, grid: {depth: [1, 2]}, figures: [walton_2]}
  - {name: beds, system: belt, grid: {frequency: [20, 50]}, figures: [gallas_1a]}
plots:
  - {name: own, x: frequency, system: belt}
"""
FIGURE_JOBS = {"figures": 1, "report": 1}
DATASET_JOBS = {"dataset": 1, "claims": 1, **FIGURE_JOBS}
ALL_JOBS = {"warm": 1, "run": 2, "batch": 1, **DATASET_JOBS}


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a copy of the project with empty files as up-to-date results of a study."""
    tree = copy_tree(tmp_path_factory.mktemp("rooms"))
    (tree / "rooms.yaml").write_text(STUDY)
    study = load_study(tree / "rooms.yaml")
    results = tree / "results" / "rooms"
    outputs = ["runs/.warm", "dataset.nc", "claims.json", "claims.csv", "report.html"]
    outputs += [f"runs/{point}.nc" for point in study.points]
    outputs += [
        f"figures/{name}{end}" for name, one in study.entries.items() for end in one.suffixes
    ]
    for name in outputs:
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).touch()
    process = snakemake(tree, "--touch", "--forceall", study="rooms.yaml")
    assert process.returncode == 0, process.stderr
    return tree


@pytest.fixture
def edit(tree) -> Iterator:
    """Return a function that replaces or adds text in a file of the tree; undone afterwards."""
    originals: dict[Path, str] = {}

    def replace_text(name: str, old: str = "", new: str = "\n# edited\n") -> None:
        path = tree / name
        originals[path] = text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1) if old else text + new)

    yield replace_text
    for path, text in originals.items():
        path.write_text(text)


@pytest.mark.parametrize(
    ("name", "old"),
    [
        ("sim/parameters/words.py", DATASET_JOBS),
        ("sim/engine/contact/damping.py", {}),
        ("sim/figures/caption.py", FIGURE_JOBS),
        ("sim/papers/walton/claims.yaml", {"claims": 1, "report": 1}),
        ("sim/report/templates/report.html.j2", {"report": 1}),
    ],
)
def test_an_edit_makes_old_what_its_room_has_made(tree, edit, name, old):
    edit(name)
    assert planned_jobs(tree, study="rooms.yaml") == old


ROOMS = {"dataset", "surrogates", "figures", "papers", "report"}


@pytest.mark.parametrize(
    ("name", "rooms"),
    [
        ("base/errors.py", ROOMS),
        ("parameters/words.py", ROOMS),
        ("study/load.py", ROOMS),
        ("papers/walton/figures.yaml", {"report"}),
        ("engine/contact/damping.py", set()),
        ("engine/stored_run.py", ROOMS),
        ("dataset/gather.py", ROOMS),
        ("surrogates/process.py", {"surrogates", "figures", "report"}),
        ("figures/caption.py", {"figures", "report"}),
        ("claims/judge.py", {"papers", "report"}),
        ("papers/walton/judges/flows.py", {"papers", "report"}),
        ("report/page.py", {"report"}),
    ],
)
def test_the_hash_of_a_room_follows_what_it_may_import_but_kernels(tree, edit, name, rooms):
    def hashes() -> dict[str, str]:
        room_hash.cache_clear()
        return {room: room_hash(tree / "sim", room) for room in ROOMS}

    before = hashes()
    edit(f"sim/{name}")
    after = hashes()
    assert {room for room in ROOMS if after[room] != before[room]} == rooms


def test_an_edit_of_an_entry_of_the_catalogue_redraws_its_figure(tree, edit):
    title = FIGURES["walton_2"].title
    edit("sim/papers/walton/figures.yaml", title, f"{title}, edited")
    assert planned_jobs(tree, study="rooms.yaml") == FIGURE_JOBS


def test_a_changed_plot_of_the_study_leaves_its_dataset(tree, edit):
    edit("rooms.yaml", "x: frequency", "x: frequency, y: backflow")
    assert planned_jobs(tree, study="rooms.yaml") == FIGURE_JOBS


def test_other_numerics_make_everything_old(tree, edit):
    edit("sim/engine/identity.py", "NUMERICS = 1", "NUMERICS = 2")
    assert planned_jobs(tree, study="rooms.yaml") == ALL_JOBS
