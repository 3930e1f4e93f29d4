"""The made-up study of belt and chute, built once."""

from pathlib import Path

import pytest

from tests.figures import made_papers


@pytest.fixture(scope="session")
def made_dataset(tmp_path_factory) -> Path:
    return made_papers.make_dataset(tmp_path_factory.mktemp("made-papers"))[1]
