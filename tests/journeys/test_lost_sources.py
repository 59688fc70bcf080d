"""A view whose source disappears empties itself: a model that is hidden, removed or undone, and
another project."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import LEFT, NONE, click, wait
from vomstudio.core.paths import resource
from vomstudio.io.photos.cameras_file import write_cameras
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.project.sample import read_picks, read_true_cameras
from vomstudio.ui.panels.comparison.compare_panel import ComparePanel
from vomstudio.ui.panels.sections.elevation_panel import ElevationPanel
from vomstudio.ui.panels.sections.section_panel import SectionPanel

pytestmark = pytest.mark.full


def photographed(folder: Path, mark: str = "") -> Path:
    """The sample outcrop with its photos, whose names begin with `mark`."""
    folder.mkdir()
    cameras = read_true_cameras()
    for view in cameras.views:
        shutil.copy(cameras.photos / view.name, folder / f"{mark}{view.name}")
    for file in resource("sample").iterdir():
        if file.name.startswith(("sample.", "face_")):
            shutil.copy(file, folder)
    views = tuple(replace(view, name=f"{mark}{view.name}") for view in cameras.views)
    write_cameras(folder / "cameras.json", replace(cameras, views=views, photos=folder))
    path = folder / "sample.obj"
    if mark:
        path.write_text(f"# {mark}\n{path.read_text()}")
    return path


def opened(window, path: Path) -> str:
    before = set(window.studio.models)
    window.open_path(path)
    wait(lambda: set(window.studio.models) - before, "the model")
    (model_id,) = set(window.studio.models) - before
    wait(lambda: "complete" in window.viewport.models.reached_stages(model_id), "the drawn model")
    return model_id


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def test_a_line_is_drawn_while_the_photos_of_another_model_appear(window, tmp_path):
    studio, panel = window.studio, window.in_photos
    first = opened(window, photographed(tmp_path / "first"))
    second = opened(window, photographed(tmp_path / "second", "other_"))
    wait(lambda: window.viewport.is_still, "the camera's rest")
    window.actions_table.run("show_in_photos")
    wait(lambda: panel.names and panel.photo is not None, "the photos of the first", 60.0)
    assert panel.feature_photo.photos.model_id == first

    studio.set_visible([first], False)
    studio.selection.set([second])
    window.actions_table.run("known_line")
    points = read_picks().points[:2]
    at = driver.pixel(window, points[0])
    click(window.viewport, at)
    for step in range(12):
        driver.move(window.viewport, at + driver.QPoint(6 * step, 2 * step))
    wait(lambda: panel.feature_photo.photos is not None, "the photos of the second", 60.0)
    wait(lambda: panel.photo is not None, "one of them")
    assert panel.feature_photo.photos.model_id == second
    studio.cancel_tool()

    studio.set_visible([second], False)
    wait(lambda: not panel.names, "an empty list")
    assert panel.photo is None
    assert panel.canvas.projection is None
    studio.set_visible([first, second], True)
    wait(lambda: panel.photo is not None, "a photo")
    assert studio.attempt(edits.remove_model, second)
    assert studio.attempt(edits.remove_model, first)
    wait(lambda: panel.photo is None and not panel.names, "an empty panel")


def computed(window, tmp_path: Path) -> None:
    """Compute results of the second model of the project in several panels."""
    window.actions_table.run("elevation_model")
    elevation = window.findChild(ElevationPanel)
    wait(elevation.start.isEnabled, "the model")
    elevation.target.setText(str(tmp_path / "heights.tif"))
    elevation.grid.fields["gsd_m"].setValue(0.1)
    press(elevation.start)
    wait(lambda: elevation.picture.picture is not None, "the heights", 60.0)
    window.actions_table.run("compare_models")
    compare = window.findChild(ComparePanel)
    wait(compare.start.isEnabled, "the benchmark")
    press(compare.start)
    wait(lambda: compare.comparison is not None, "the distances", 60.0)
    window.actions_table.run("section")
    section = window.findChild(SectionPanel)
    section.plane.line.setText("090/90")
    wait(lambda: section.result is not None, "the section", 30.0)


def holds_nothing(window) -> None:
    """No panel shows anything of a model; another project has new panels."""
    panels = []
    for name in ("elevation", "compare", "looked_at", "section"):
        window.docks.bring_forward(name)
        panels.append(window.docks[name].widget().widget())
    elevation, compare, coverage, section = panels
    wait(lambda: section.result is None and section.picture.drawing is None, "no section")
    assert elevation.result is None
    assert elevation.picture.picture is None
    assert elevation.figures.text() == ""
    assert compare.comparison is None
    assert not compare.histogram.isVisibleTo(compare)
    assert coverage.result is None
    assert not window.viewport.scene.models
    assert not window.viewport.features.drawings


@pytest.mark.parametrize("way", ["undone", "another project"])
def test_every_panel_is_cleared_with_its_model(window, outcrop, tmp_path, way):
    studio = window.studio
    driver.open_outcrop(window, outcrop)
    text = outcrop.read_text()
    twin = outcrop.with_name("twin.obj")
    twin.write_text(f"# twin\n{text}")
    frame = driver.model(window).frame
    window.studio.open_model(twin, reference_id=driver.model(window).id)
    wait(lambda: len(studio.models) == 2, "the twin")
    assert studio.session.of(Model)[1].frame == frame
    computed(window, tmp_path)
    if way == "undone":
        while studio.session.of(Model):
            studio.undo()
    else:
        studio.new_project()
    wait(lambda: not window.viewport.scene.models, "an empty outcrop")
    holds_nothing(window)
    assert np.isfinite(window.viewport.camera.position).all()
