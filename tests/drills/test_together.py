"""Several processes in one folder of results: two that run, one that looks, one that removes."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from sim.parameters import canonical_values
from sim.study.load import load_study
from tests.golden import digest
from tests.made.processes import ROOT, wait_until

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

STUDY = """\
study: together
defaults: {belt: {beads: 10, width: 5, steps_per_cycle: 1000, transient: 1, average: 20}}
series: [{name: beds, system: belt, grid: {frequency: [20, 30, 40, 50], vibration_angle: [30, 45]}}]
"""


@pytest.fixture
def start(tmp_path, request):
    """Start a command in the folder; its output goes to files of a name."""

    def begin(name: str, *words: str, stdin: str = "") -> subprocess.Popen:
        outputs = [(tmp_path / f"{name}.{kind}").open("w") for kind in ("out", "err")]
        process = subprocess.Popen(
            [sys.executable, "-m", "sim", *words],
            cwd=tmp_path,
            stdin=subprocess.PIPE,
            stdout=outputs[0],
            stderr=outputs[1],
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT), "TALUS_CHECKPOINT_SECONDS": "0"},
        )
        process.stdin.write(stdin)
        process.stdin.close()
        for file in outputs:
            file.close()
        request.addfinalizer(process.kill)
        return process

    return begin


@pytest.mark.parametrize("rounds", [pytest.param(5, marks=pytest.mark.long)])
def test_processes_in_one_folder_end_in_the_bits_of_one_alone(rounds, tmp_path, start):
    (tmp_path / "together.yaml").write_text(STUDY)
    study, chance = load_study(tmp_path / "together.yaml"), random.Random(SEED)
    points = [point.parameters for point in study.points.values()]
    texts = [json.dumps(list(map(canonical_values, order))) for order in (points, points[::-1])]
    results = tmp_path / "results"
    assert start("alone", "batch", "alone/study", stdin=texts[0]).wait() == 0
    runs = results / "together" / "runs"
    for _ in range(rounds):
        shutil.rmtree(results, ignore_errors=True)
        # Another study has some of the runs, which vanish while they are taken.
        others = results / "other" / "runs"
        others.mkdir(parents=True)
        for path in (tmp_path / "alone" / "study" / "runs").iterdir():
            shutil.copy(path, others)
        watch = start("watch", "status", "together.yaml", "--watch", "1")
        pair = [
            start(f"batch{n}", "batch", "results/together", stdin=text)
            for n, text in enumerate(texts)
        ]
        while any(process.poll() is None for process in pair):
            time.sleep(chance.uniform(0, 0.2))
            if left := sorted(others.iterdir()):
                with suppress(FileNotFoundError):
                    chance.choice(left).unlink()
        wait_until(lambda: len(list(runs.glob("belt-*.nc"))) == len(points))
        watch.send_signal(signal.SIGINT)
        assert [*(process.wait() for process in pair)] == [0, 0]
        assert watch.wait() in (0, 130)
        for name in ("batch0", "batch1", "watch"):
            said = Path(tmp_path / f"{name}.err").read_text()
            assert "Traceback" not in said and "error" not in said, said
        logs = (results / "together" / "logs").rglob("*.log")
        assert not any("Traceback" in path.read_text() for path in logs)
        for key in study.points:
            alone = tmp_path / "alone" / "study" / "runs" / f"{key}.nc"
            assert digest(runs / f"{key}.nc") == digest(alone), key
        assert not list(results.rglob("*.damaged*"))
