"""The made-up study of the belt, built once."""

from pathlib import Path

import pytest

from tests.figures.made_belt import make_dataset


@pytest.fixture(scope="session")
def belt_dataset(tmp_path_factory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("made-belt"))
