"""The folder of compiled code: its own, whoever else can write where it is looked for."""

import os
import stat
from pathlib import Path
from unittest.mock import Mock

import pytest
from numba.core.caching import IndexDataCacheFile

from sim.base.errors import InputError
from sim.engine import compile as engine
from sim.engine import identity
from sim.engine.identity import COMPILED_PARTS, source_hash

NAME = source_hash(COMPILED_PARTS)


@pytest.fixture(autouse=True)
def temporary(tmp_path, monkeypatch) -> Path:
    """The system's folder of temporary files; nothing is named and there is no home."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    for name in ("TALUS_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)

    def unknown():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", unknown)
    identity._temporary_folder.cache_clear()
    yield folder
    identity._temporary_folder.cache_clear()


def test_it_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    assert identity.cache_directory() == tmp_path / "shared" / "talus" / NAME
    monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path / "mine"))
    folder = identity.cache_directory()
    assert folder == tmp_path / "mine" / NAME
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("home", ["unknown", "empty", "not writable"])
def test_without_a_home_it_is_a_temporary_one_of_the_user_and_said_once(
    home, tmp_path, temporary, monkeypatch, caplog
):
    if home == "empty":
        monkeypatch.setattr(Path, "home", lambda: Path("/"))
        monkeypatch.setenv("HOME", "")
    elif home == "not writable":
        (tmp_path / "file").write_text("in the way")
        monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path / "file"))
    folders = {identity.cache_directory() for _ in range(3)}
    assert folders == {temporary / f"talus-{os.geteuid()}" / NAME}
    assert len(caplog.messages) == 1 and str(*folders) in caplog.text


def plant(folder: Path, how: str, monkeypatch) -> None:
    """Make a folder as somebody else would, before it is looked for."""
    if how == "link":
        (folder.parent / "elsewhere").mkdir()
        folder.symlink_to(folder.parent / "elsewhere")
    elif how == "file":
        folder.write_text("in the way")
    else:
        folder.mkdir()
        folder.chmod(0o777 if how == "open" else 0o700)
    if how == "other":
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)


@pytest.mark.parametrize("how", ["link", "file", "open", "other"])
def test_a_folder_that_others_have_planted_is_not_used(how, temporary, monkeypatch):
    owner = os.geteuid() + (how == "other")
    predictable = temporary / f"talus-{owner}"
    plant(predictable, how, monkeypatch)
    folder = identity.cache_directory()
    assert folder.parent == temporary and folder != predictable
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize(
    ("how", "message"),
    [("link", "is a link"), ("open", "others can write"), ("other", "belongs to user")],
)
def test_a_folder_that_is_named_and_not_ones_own_is_refused(how, message, tmp_path, monkeypatch):
    plant(tmp_path / NAME, how, monkeypatch)
    monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path))
    with pytest.raises(InputError, match=rf"environment: TALUS_CACHE_DIR: .*{message}.*allowed: "):
        identity.cache_directory()


def test_a_folder_that_others_could_replace_is_refused(tmp_path, monkeypatch):
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    monkeypatch.setenv("TALUS_CACHE_DIR", str(shared))
    with pytest.raises(InputError, match=f"others can write {shared}; allowed: "):
        identity.cache_directory()
    # Where only the owner may rename, as in the system's temporary folder, nobody can.
    shared.chmod(0o1777)
    assert identity.cache_directory() == shared / NAME


def test_a_full_disk_keeps_no_code_and_stops_no_run(caplog, monkeypatch):
    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(engine, "_save_code", full)
    IndexDataCacheFile.save(Mock(), "spheres", "code of spheres")
    IndexDataCacheFile.save(Mock(), "disks", "code of disks")
    assert caplog.messages == ["compiled code is not kept: No space left on device"]


def test_code_that_two_processes_store_at_once_is_never_loaded_as_the_others(tmp_path):
    first, second, third = (IndexDataCacheFile(str(tmp_path), "kernel", "stamp") for _ in range(3))
    # Both have read the index before either writes, and the first writes its code last.
    second._load_index = dict
    save_data = first._save_data

    def save_data_last(*arguments):
        second.save("disks", "code of disks")
        save_data(*arguments)

    first._save_data = save_data_last
    first.save("spheres", "code of spheres")
    assert third.load("disks") == "code of disks"
    assert third.load("spheres") in ("code of spheres", None)
