"""Summaries near the end of files, read without the rest of the file."""

from math import inf, nan

import numpy as np
import pytest

from sim.base.seals import append_summary, is_damaged, read_seal, read_summary, seal

SUMMARY = {"attributes": {"status": "completed", "note": "θ = 17°\n"}, "velocity": [0.1, inf]}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"contents\nsummary 1 2\n{}")
    return path


def test_a_summary_is_read_back(path):
    append_summary(path, SUMMARY)
    seal(path)
    assert read_summary(path) == SUMMARY
    assert not is_damaged(path)
    assert path.read_bytes().startswith(b"contents")


def test_numbers_of_numpy_are_numbers(path):
    append_summary(path, {"steps": [np.int64(3)], "velocity": [np.float64(0.1), nan]})
    seal(path)
    (steps,), (velocity, unknown) = read_summary(path).values()
    assert (steps, velocity) == (3, 0.1) and np.isnan(unknown)


@pytest.mark.parametrize("content", [b"", b"text", bytes(500), b"\nsummary 000000000002 00000000"])
def test_files_without_a_summary_have_none(tmp_path, content):
    path = tmp_path / "file"
    path.write_bytes(content)
    assert read_summary(path) is None
    seal(path)
    assert read_summary(path) is None


def test_a_damaged_summary_is_none(path):
    append_summary(path, SUMMARY)
    seal(path)
    whole, first = path.read_bytes(), len(b"contents\nsummary 1 2\n{}\n")
    for place in range(first, len(whole) - 75):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert read_summary(path) is None
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert read_summary(path) is None


def test_a_seal_tells_one_content_from_another(path):
    assert read_seal(path) == ""
    seal(path)
    first = read_seal(path)
    assert len(first) == 64
    path.write_bytes(b"other contents")
    seal(path)
    assert len(read_seal(path)) == 64 and read_seal(path) != first


def test_only_a_sealed_file_is_whole(path):
    for text in (b"", b"some", bytes(200)):
        path.write_bytes(text)
        assert is_damaged(path)
        seal(path)
        assert not is_damaged(path)
        sealed = path.read_bytes()
        path.write_bytes(b"x" + sealed)
        assert is_damaged(path)
