"""The note that all kernels are ready holds for this program on this machine, and no other."""

from __future__ import annotations

import platform
from pathlib import Path

import pytest

from vomstudio.geometry.kernels import compilation_state


@pytest.fixture(autouse=True)
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "kernels"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))
    return folder


def test_recorded_compilation_is_detected() -> None:
    assert not compilation_state.is_compilation_recorded()
    compilation_state.record_compilation()
    assert compilation_state.is_compilation_recorded()


def test_record_is_invalid_for_other_machine_or_changed_source(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    package = tmp_path / "package"
    package.mkdir()
    source = package / "some_kernels.py"
    source.write_text("one = 1\n")
    monkeypatch.setattr(compilation_state, "_PACKAGE", package)
    compilation_state.record_compilation()
    assert compilation_state.is_compilation_recorded()
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(platform, "node", lambda: "another")
        assert not compilation_state.is_compilation_recorded()
    assert compilation_state.is_compilation_recorded()
    source.write_text("two = 22\n")
    assert not compilation_state.is_compilation_recorded()


def test_unwritable_folder_is_ignored(kept: Path) -> None:
    kept.write_text("no folder")
    compilation_state.record_compilation()
    assert not compilation_state.is_compilation_recorded()
