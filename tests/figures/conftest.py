"""The made-up studies of the belt and of the chute, built once."""

from pathlib import Path

import pytest

from tests.figures import made_belt, made_chute


@pytest.fixture(scope="session")
def belt_dataset(tmp_path_factory) -> Path:
    return made_belt.make_dataset(tmp_path_factory.mktemp("made-belt"))[1]


@pytest.fixture(scope="session")
def chute_dataset(tmp_path_factory) -> Path:
    return made_chute.make_dataset(tmp_path_factory.mktemp("made-chute"))[1]
