"""What was open lately is written after the picture; that a project is open, at once."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from vomstudio.io.settings import Settings, read_settings, settings_path
from vomstudio.studio.notices import Notices
from vomstudio.studio.owner_thread import Call
from vomstudio.studio.preferences import Preferences


class Clock:
    """Its time never comes by itself."""

    def __init__(self, call: Call) -> None:
        self.call, self.is_active = call, False

    def start(self, seconds: float | None = None) -> None:
        self.is_active = True

    def stop(self) -> None:
        self.is_active = False


@pytest.fixture
def clocks() -> list[Clock]:
    return []


@pytest.fixture
def preferences(own_folders: Path, clocks: list[Clock]) -> Preferences:
    def later(seconds: float, call: Call) -> Clock:
        clocks.append(Clock(call))
        return clocks[-1]

    return Preferences(Settings(), Notices(), lambda call: call(), later)


def written() -> Settings:
    for thread in threading.enumerate():
        if thread.name == "settings":
            thread.join(10.0)
    return read_settings()[0]


def test_recent_file_is_written_after_a_delay(preferences, clocks) -> None:
    preferences.remember(Path("/data/cliff.obj"))
    assert not settings_path().exists() or not written().recent
    assert clocks[0].is_active
    clocks[0].call()
    assert written().recent == ["/data/cliff.obj"]
    assert not clocks[0].is_active


def test_open_project_is_recorded_immediately(preferences, clocks, tmp_path) -> None:
    preferences.mark_open(tmp_path, True)
    preferences.remember(tmp_path / "cliff.obj")
    assert written().unclosed == [str(tmp_path)]
    clocks[0].call()
    assert written().recent == [str(tmp_path / "cliff.obj")]


def test_final_save_includes_pending_recent_files(preferences, clocks) -> None:
    preferences.remember(Path("/data/cliff.obj"))
    preferences.keep()
    assert written().recent == ["/data/cliff.obj"]
    assert not clocks[0].is_active
