"""A project whose journal takes long to read is read beside the window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QTimer

from tests.ui.conftest import add_bed, save_beds
from vomstudio.studio import projects


@pytest.fixture
def large(studio, tmp_path, monkeypatch):
    """A saved project that counts as large, and another one open."""
    path = save_beds(studio, tmp_path / "large.vom", 3)
    monkeypatch.setattr(projects, "LARGE_JOURNAL_BYTES", 1)
    return path


@pytest.mark.full
def test_large_project_is_read_while_the_window_stays_responsive(window, studio, large):
    there: list[bool] = []
    beat = QTimer()
    beat.timeout.connect(lambda: there.append(studio.project.folder == large))
    beat.start(0)
    window.open_path(large)
    beat.stop()
    # Events were handled before it was there.
    assert False in there
    assert studio.project.folder == large
    ids = [f.id for f in studio.session.features()]
    assert len(ids) == 3
    ready = studio.workspace.projects.measurements
    assert ready is not None
    assert studio.workspace.derived.measurements is ready
    assert all(m.plane is not None for m in studio.measured(ids).values())
    # From now on the window's thread writes the journal.
    add_bed(studio, "b9", dip=0.9)
    studio.workspace.history.undo()
    assert len(studio.session.features()) == 3


def test_second_project_is_not_opened_during_loading(window, studio, large, tmp_path):
    codes: list[str] = []
    studio.workspace.notices.posted.connect(lambda notice: codes.append(notice.code))
    QTimer.singleShot(0, lambda: studio.workspace.projects.open(tmp_path / "other.vom"))
    window.open_path(large)
    assert studio.project.folder == large
    assert "project.opening" in codes


def test_unreadable_project_leaves_the_current_one_open(window, studio, large):
    present = studio.project.folder
    journal = large / "journal.sqlite"
    journal.write_bytes(b"no database" * 1000)
    codes: list[str] = []
    studio.workspace.notices.posted.connect(lambda notice: codes.append(notice.code))
    window.open_path(large)
    assert studio.project.folder == present
    assert codes == ["journal.damaged"]
