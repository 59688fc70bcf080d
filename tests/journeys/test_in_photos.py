"""The outcrop seen in its photos, with mouse and keyboard, in the window that people use."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import click, drag, key, look_at, move, wait
from tests.io.photos.camera_files import colmap_itself
from tests.messages import shown_codes
from vomstudio.core.paths import resource
from vomstudio.geometry.frusta import frusta
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.io.photos.cameras_file import write_cameras
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.sample import read_picks, read_true_cameras
from vomstudio.studio.tools.trace import TraceTool

TRUE = read_true_cameras()


@pytest.fixture
def sample(tmp_path) -> Path:
    """The sample outcrop with the cameras of its photos beside it."""
    folder = tmp_path / "models"
    folder.mkdir()
    for file in resource("sample").iterdir():
        if file.name.startswith(("sample.", "face_")):
            shutil.copy(file, folder)
    write_cameras(folder / "cameras.json", TRUE)
    return folder / "sample.obj"


@pytest.fixture
def traced(window, sample):
    """The sample with one of its beds, one joint and the fault."""
    window.resize(1400, 900)
    window.open_path(sample)
    model_id = driver.settled(window)
    model, picks = window.studio.records[model_id], read_picks()
    for i, name in enumerate(picks.names):
        if name in ("B05", "B14", "F01", "J2-02"):
            points = tuple(map(tuple, picks.of(i)[:: max(1, len(picks.of(i)) // 40)].tolist()))
            trace = Trace(name, name, picks.kinds[i], model_id, model.content_hash, points)
            assert window.studio.attempt(edits.add_trace, trace)
    return window


def points_of(window, name: str) -> np.ndarray:
    return window.studio.measured([name])[name].points


def spot(canvas, panel, world: np.ndarray) -> QPoint:
    """Where a World point is on the canvas."""
    photos = panel.feature_photo.photos.views
    x, y = canvas.to_widget(photos.pixels(panel.feature_photo.view, world[None]))[0]
    return QPoint(round(float(x)), round(float(y)))


def shown(window) -> None:
    """The dock is open and its picture is there."""
    panel = window.in_photos
    wait(lambda: panel.names, "a list of photos", 60.0)
    wait(lambda: panel.canvas._picture is not None, "the photo", 30.0)


@pytest.mark.full
def test_bed_is_shown_in_its_photos_and_another_is_picked_there(traced):
    window, studio, panel = traced, traced.studio, traced.in_photos
    canvas = panel.canvas
    studio.selection.set(["B05"])
    window.actions_table.run("show_in_photos")
    shown(window)
    wait(lambda: "B05: visible in" in panel.summary.text(), "the photos that show it")
    wait(lambda: any(d.id == "B05" for d in canvas._drawn_features), "the bed on the photo")
    points = points_of(window, "B05")
    views = panel.feature_photo.photos.views
    # The list holds those photos that truly show it, and the panel one of the best of them.
    for name in panel.names:
        assert views.shows(views.row(name), points).any()
    best = max(views.shows(i, points).mean() for i in range(12))
    assert views.shows(panel.feature_photo.view, points).mean() >= best - 0.2
    assert canvas.contains_pixels(
        views.pixels(panel.feature_photo.view, points).mean(axis=0)[None]
    ), "it is in sight"
    driver.pause(200)
    driver.keep_picture(window, "in-photos-1-selected")

    # The wheel looks closer at what is under the cursor, a drag moves the photo.
    at = spot(canvas, panel, points[len(points) // 2])
    before = canvas.pixel_at(at)
    for _ in range(5):
        wheel(canvas, at, 120)
    assert np.allclose(canvas.pixel_at(at), before, atol=1e-6)
    drag(canvas, at, at + QPoint(37, -21))
    assert np.allclose(canvas.pixel_at(at + QPoint(37, -21)), before, atol=1e-6)
    driver.pause(100)
    driver.keep_picture(window, "in-photos-2-closer")

    # A trace that is picked in the photo lands on the model.
    window.viewport.setFocus()
    key(window, Qt.Key.Key_T)
    chosen = points_of(window, "B14")
    studio.selection.set(["B14"])
    wait(lambda: "B14: visible in" in panel.summary.text(), "the other bed")
    wait(lambda: canvas._picture is not None, "its photo")
    name, inside = panel.photo, views.shows(panel.feature_photo.view, chosen, 0.02)
    places = chosen[inside][:: max(1, inside.sum() // 6)]
    on = [spot(canvas, panel, p) for p in places]
    on = [p for p in on if canvas.rect().adjusted(4, 4, -4, -4).contains(p)]
    assert len(on) >= 4
    for place in on:
        click(canvas, place)
        QTest.qWait(450)
    assert len(studio.get_tool(TraceTool).vertices) == len(on)
    gsd = 0.014
    for place, vertex in zip(on, studio.get_tool(TraceTool).vertices, strict=True):
        seen = views.pick(panel.feature_photo.view, canvas.pixel_at(place))
        assert np.abs(seen.position - vertex).max() < 1e-9
        there = canvas.to_widget(views.pixels(panel.feature_photo.view, np.array(vertex)[None]))[0]
        assert np.hypot(there[0] - place.x(), there[1] - place.y()) < 1e-3
    assert np.linalg.norm(chosen[:, None] - studio.get_tool(TraceTool).vertices, axis=2).min(
        axis=0
    ).max() < (3 * gsd / canvas._scale + 0.05)
    move(canvas, on[0] + QPoint(9, 14))
    assert window.viewport.preview.rubber is not None, "the band follows in the outcrop"
    driver.keep_picture(window, "in-photos-3-picking")

    # A vertex is taken by its handle.
    vertices = studio.get_tool(TraceTool).vertices
    drag(canvas, on[1], on[1] + QPoint(0, 8))
    changed = [a != b for a, b in zip(vertices, studio.get_tool(TraceTool).vertices, strict=True)]
    assert changed == [i == 1 for i in range(len(on))]
    canvas.setFocus()
    key(window, Qt.Key.Key_Return)
    made = [t for t in studio.session.of(Trace) if t.id not in ("B05", "B14", "F01", "J2-02")]
    assert len(made) == 1
    wait(
        lambda: any(d.id == made[0].id for d in canvas._drawn_features),
        "the new trace on the photo",
    )
    assert panel.photo == name, "who works in a photo stays in it"
    driver.keep_picture(window, "in-photos-4-made")


@pytest.mark.full
def test_a_click_on_the_outcrop_finds_its_photos_and_a_click_in_a_photo_selects(traced):
    window, studio, panel = traced, traced.studio, traced.in_photos
    canvas = panel.canvas
    window.actions_table.run("show_in_photos")
    shown(window)
    assert len(panel.names) == 12
    # Bare rock, away from every feature.
    points = points_of(window, "F01")
    look_at(window, points, 20.0)
    middle = window.viewport.rect().center()
    free = next(
        at
        for at in (middle + QPoint(dx, dy) for dx in (150, -150, 90) for dy in (60, -60, 0))
        if window.viewport.pick(at.x(), at.y()) is not None
        and window.viewport.features.at(at.x(), at.y()) is None
    )
    click(window.viewport, free)
    wait(lambda: "Clicked position" in panel.summary.text(), "photos of the place")
    world = window.viewport.world_position(window.viewport.pick(free.x(), free.y()))
    views = panel.feature_photo.photos.views
    assert panel.names
    for name in panel.names:
        assert views.shows(views.row(name), world[None]).all()
    move(window.viewport, free + QPoint(12, 12))
    move(window.viewport, free)

    def off() -> float:
        """Pixels between the cursor in the photo and where the photo shows its place."""
        if canvas._cross is None:
            return np.inf
        return float(
            np.hypot(*(canvas._cross - views.pixels(panel.feature_photo.view, world[None])[0]))
        )

    # The first place that the mouse was at may come before the last.
    wait(lambda: off() < 2.0, "the cursor in the photo")
    driver.keep_picture(window, "in-photos-5-place")

    # The fault is selected where the photo shows it.
    studio.selection.set(["F01"])
    wait(lambda: "F01: visible in" in panel.summary.text(), "the fault's photos")
    wait(lambda: any(d.id == "F01" for d in canvas._drawn_features), "the fault on the photo")
    drawn = next(d for d in canvas._drawn_features if d.id == "F01")
    on = canvas.to_widget(drawn.pixels[drawn.is_visible])
    x, y = on[len(on) // 2]
    studio.selection.set([])
    driver.pause(150)
    name = panel.photo
    click(canvas, QPoint(round(x), round(y)))
    assert studio.selection.ids == ("F01",)
    driver.pause(200)
    assert panel.photo == name, "what is selected in a photo is looked at in this photo"


@pytest.mark.full
def test_a_patch_is_painted_in_a_photo(traced):
    window, studio, panel = traced, traced.studio, traced.in_photos
    canvas = panel.canvas
    studio.selection.set(["J2-02"])
    window.actions_table.run("show_in_photos")
    shown(window)
    wait(lambda: "J2-02: visible in" in panel.summary.text(), "the joint's photos")
    wait(lambda: canvas._picture is not None, "the photo")
    window.viewport.setFocus()
    key(window, Qt.Key.Key_P)
    assert studio.tool_name == "plane"
    before = canvas.pixel_at(QPoint(5, 5))
    middle = canvas.rect().center()
    move(canvas, middle + QPoint(3, 0))
    move(canvas, middle)
    drag(canvas, middle, middle + QPoint(60, 25))
    assert canvas.pixel_at(QPoint(5, 5)) == before, "the left button paints"
    key(window, Qt.Key.Key_Return)
    (patch,) = studio.session.of(Patch)
    assert patch.n > 5
    # All of it lies under the brush's way through the photo.
    mesh = studio.models[patch.model_id].data
    painted = mesh.vertices[mesh.faces[runs_to_ids(patch.runs)]].mean(axis=1)
    on = canvas.to_widget(
        panel.feature_photo.photos.views.pixels(panel.feature_photo.view, painted)
    )
    assert np.abs(on - [middle.x() + 30, middle.y() + 12]).max() < 150
    wait(
        lambda: any(d.id == patch.id for d in canvas._drawn_features),
        "the patch's edge on the photo",
    )
    driver.keep_picture(window, "in-photos-8-patch")


@pytest.mark.full
def test_moved_photos_are_found_by_selecting_their_folder(window, sample, tmp_path):
    away = tmp_path / "elsewhere"
    from dataclasses import replace

    write_cameras(sample.parent / "cameras.json", replace(TRUE, photos=away), force=True)
    window.open_path(sample)
    driver.settled(window)
    window.actions_table.run("show_in_photos")
    panel = window.in_photos
    wait(lambda: panel.names, "the list", 60.0)
    assert "photo.none-found" in shown_codes(panel.canvas.message)
    button = panel._help_buttons["find_photos"]
    assert button.isVisible()
    driver.keep_picture(window, "in-photos-6-moved")
    window.photo_links.find_photos(
        panel.feature_photo.photos.model_id, resource("sample", "photos")
    )
    wait(lambda: panel.canvas._picture is not None, "the photo")


@pytest.mark.full
def test_cameras_of_other_programs_show_a_model_in_its_photos(window, sample):
    """By themselves if they lie beside the model, or chosen in the menu."""
    photos = resource("sample", "photos")
    shutil.copytree(photos, sample.parent / "photos")
    (sample.parent / "cameras.json").unlink()
    origin = np.array(TRUE.origin, np.float64)
    views = [view.moved(1.0, np.eye(3), origin) for view in TRUE.views]
    cameras = colmap_itself(sample.parent / "sparse", views)
    window.open_path(sample)
    driver.settled(window)
    window.actions_table.run("show_in_photos")
    panel = window.in_photos
    wait(lambda: panel.canvas._picture is not None, "the photo", 60.0)
    assert len(panel.names) == len(views)
    window.studio.display.set_cameras(True)
    wait(window.cameras.visible_frusta, "the cameras")
    drawn = window.cameras.visible_frusta()
    assert len(drawn) == len(views)
    own = frusta(TRUE.views, np.zeros(3))[0].transform(np.eye(4), TRUE.origin)
    assert np.abs(drawn[0].tip - own.tip).max() < 1e-3
    other = cameras.rename(sample.parent / "elsewhere")
    window.photo_links.open_cameras(panel.feature_photo.photos.model_id, other / "images.bin")
    wait(lambda: not window.photo_links.busy(), "the cameras", 60.0)
    assert len(panel.names) == len(views)
    # Cameras that look elsewhere are reported.
    shifted = [view.moved(1.0, np.eye(3), np.array([1000.0, 0.0, 0.0])) for view in views]
    wrong = colmap_itself(sample.parent / "wrong", shifted)
    window.photo_links.open_cameras(panel.feature_photo.photos.model_id, wrong / "images.bin")
    wait(lambda: "cameras.not-looking" in shown_codes(window.message_bar.text), "the warning", 60.0)


@pytest.mark.full
def test_model_without_cameras_shows_what_to_do(window, outcrop):
    driver.open_outcrop(window, outcrop)
    window.actions_table.run("show_in_photos")
    panel = window.in_photos
    wait(lambda: panel._help_buttons["open_cameras"].isVisible(), "what is missing")
    assert panel.canvas.message
    assert not panel.names
    driver.keep_picture(window, "in-photos-7-none")


def wheel(widget, at: QPoint, delta: int) -> None:
    from PySide6.QtGui import QWheelEvent
    from PySide6.QtWidgets import QApplication

    event = QWheelEvent(
        QPointF(at),
        QPointF(widget.mapToGlobal(at)),
        QPoint(),
        QPoint(0, delta),
        Qt.MouseButton.NoButton,
        driver.NONE,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)


@pytest.mark.full
def test_the_cross_of_the_cursor_leaves_the_photo_with_the_cursor(traced):
    window, panel = traced, traced.in_photos
    window.studio.selection.set(["B05"])
    window.actions_table.run("show_in_photos")
    shown(window)
    wait(lambda: "B05: visible in" in panel.summary.text(), "the photos that show it")
    points = points_of(window, "B05")
    look_at(window, points, *window.viewport.moves.view_direction())
    views = panel.feature_photo.photos.views
    seen = points[views.shows(panel.feature_photo.view, points, 0.02)]

    def crossed() -> bool:
        move(window.viewport, driver.pixel(window, seen[len(seen) // 2]))
        move(window.viewport, driver.pixel(window, seen[len(seen) // 2]) + QPoint(3, 3))
        return panel.canvas._cross is not None

    wait(crossed, "the cross of the cursor in the photo")
    QApplication.sendEvent(window.viewport, QEvent(QEvent.Type.Leave))
    assert panel.canvas._cross is None
