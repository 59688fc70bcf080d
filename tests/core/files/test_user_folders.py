"""A user without a home that can be written works, is told, and finds again what a crash left."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from vomstudio.core.files import user_folders

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Rights are those of POSIX.")


@pytest.fixture(autouse=True)
def asked_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    # Not by rights, which the administrator has all of.
    (tmp_path / "a file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "a file" / "state"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    user_folders._first_writable_folder.cache_clear()
    yield
    user_folders._first_writable_folder.cache_clear()


def test_writable_home_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert user_folders.state_folder() == tmp_path / "state" / "vomstudio"
    assert user_folders.is_home_writable()


def test_private_temporary_folder_is_used_without_writable_home(tmp_path: Path) -> None:
    found = user_folders.state_folder()
    assert found == tmp_path / "temporary" / f"vomstudio-{os.getuid()}"
    assert found.stat().st_mode & 0o777 == 0o700
    assert not user_folders.is_home_writable()
    user_folders._first_writable_folder.cache_clear()
    assert user_folders.state_folder() == found


@pytest.mark.parametrize("how", ["link", "open to all", "file"])
def test_temporary_folder_prepared_by_another_user_is_not_used(tmp_path: Path, how: str) -> None:
    mine = tmp_path / "temporary" / f"vomstudio-{os.getuid()}"
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    if how == "link":
        mine.symlink_to(elsewhere)
    elif how == "file":
        mine.touch()
    else:
        mine.mkdir()
        mine.chmod(0o777)
    found = user_folders.state_folder()
    assert found != mine
    assert found.parent == tmp_path / "temporary"
    assert found.stat().st_mode & 0o777 == 0o700
    assert list(elsewhere.iterdir()) == []
