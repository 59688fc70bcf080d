"""The outcrop's features are drawn by and by after a project was opened."""

from __future__ import annotations

import pytest

from tests.driver import wait
from tests.ui.conftest import add_bed, add_cliff, save_beds
from vomstudio.project import edits
from vomstudio.ui.outcrop import scene_presenter

pytestmark = pytest.mark.full

COUNT = 12


@pytest.fixture
def stored(window, tmp_path, monkeypatch):
    """A saved project with more features than are prepared at once; another one is open."""
    monkeypatch.setattr(scene_presenter, "_STEP_FEATURES", 5)
    return save_beds(window.studio, tmp_path / "many.vom", COUNT)


def test_features_are_drawn_after_opening(window, stored):
    window.open_path(stored)
    assert not window.viewport.features.drawings
    wait(lambda: len(window.viewport.features.drawings) == COUNT, "all features")


def test_edits_while_features_are_being_drawn_apply_to_all(window, stored):
    studio, drawn = window.studio, window.viewport.features
    window.open_path(stored)
    first, *_, last = studio.session.features()
    studio.set_visible([last.id], False)
    assert {f.id: drawn.drawings[f.id].visible for f in studio.session.features()} == {
        f.id: f is not last for f in studio.session.features()
    }
    studio.workspace.projects.new()
    window.open_path(stored)
    studio.attempt(edits.delete, [first.id])
    assert len(drawn.drawings) == COUNT - 1
    assert first.id not in drawn.drawings


def test_pending_features_are_not_drawn_in_next_project(window, stored):
    window.open_path(stored)
    studio = window.studio
    studio.workspace.projects.new()
    add_cliff(studio)
    add_bed(studio, "new")
    wait(lambda: bool(window.viewport.features.drawings), "the only feature")
    assert set(window.viewport.features.drawings) == {f.id for f in studio.session.features()}
