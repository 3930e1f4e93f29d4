"""The studies whose share of processor time is measured are studies."""

import pytest
import yaml

from benchmarks.share import SWEEPS, study
from sim.study.load import load_study


@pytest.mark.parametrize("system", SWEEPS)
def test_the_studies_can_be_run(system, tmp_path):
    path = tmp_path / "share.yaml"
    path.write_text(yaml.safe_dump(study(system, 4)))
    found = load_study(path, tmp_path)
    assert len(found.points) == 4
    assert {point.parameters.system for point in found.points.values()} == {system}
