"""Lines, dimensions and intersections with mouse and keyboard, in the window that people use."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from tests import driver
from tests.driver import click, drag, key, look_at, move, pixel, wait
from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.geometry import transform
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.trace import Trace
from vomstudio.rendering.view.first_view import first_view
from vomstudio.studio.tools.line import LineTool
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.measure import MeasurePanel

OTHER = "B07"
"""A plane at an angle with B01; a fault for once."""

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def picked(window, outcrop, picks):
    """The outcrop with three planes on it."""
    model_id = driver.open_outcrop(window, outcrop)
    model = window.studio.records[model_id]
    back = transform.invert(model.to_world)
    for name, kind in (("B01", "bedding"), ("B04", "bedding"), (OTHER, "fault")):
        points = transform.apply(back, picks[name])
        trace = Trace(
            name, name, kind, model_id, model.content_hash, tuple(map(tuple, points.tolist()))
        )
        assert window.studio.attempt(edits.add_trace, trace)
    return window


def reading(window) -> tuple[str, ...]:
    preview = window.viewport.preview
    return () if preview is None else preview.reading


def spots(window, points: np.ndarray) -> list[QPoint]:
    """Pixels in a row across the middle of what is looked at, all on the outcrop."""
    look_at(window, points, 0.0, 10.0)
    middle = window.viewport.rect().center()
    found = [middle + QPoint(dx, dx // 4) for dx in (-90, -45, 0, 45, 90)]
    assert all(window.viewport.pick(p.x(), p.y()) is not None for p in found)
    return found


@pytest.mark.full
def test_line_is_picked_edited_stored_and_undone(picked, picks):
    window, studio, viewport = picked, picked.studio, picked.viewport
    at = spots(window, picks["B01"])
    key(window, Qt.Key.Key_L)
    assert studio.tool_name == "line"
    assert not driver.tool_panel(window, LinePanel).visibleRegion().isEmpty(), (
        "its panel came forward"
    )
    click(viewport, at[0])
    move(viewport, at[1])
    assert "/" in reading(window)[0], "the direction to the cursor"
    click(viewport, at[1])
    assert reading(window)[1] == "n 2"
    for spot in at[2:]:
        click(viewport, spot)
    assert len(studio.get_tool(LineTool).vertices) == 5
    key(window, Qt.Key.Key_Backspace)
    assert len(studio.get_tool(LineTool).vertices) == 4
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert len(studio.get_tool(LineTool).vertices) == 3
    before = studio.get_tool(LineTool).vertices
    drag(viewport, at[1], at[1] + QPoint(0, 9))
    assert [a == b for a, b in zip(before, studio.get_tool(LineTool).vertices, strict=True)] == [
        True,
        False,
        True,
    ]
    driver.keep_picture(window, "lines-1-picking")
    key(window, Qt.Key.Key_Return)
    (made,) = studio.session.of(Lineation)
    assert made.type_id == "lineation"
    world = studio.measured([made.id])[made.id].points
    truth = [viewport.world_position(viewport.pick(p.x(), p.y())) for p in (at[0], at[2])]
    assert world[[0, 2]] == pytest.approx(np.array(truth), abs=1e-9)
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Lineation) == []
    key(window, Qt.Key.Key_Z, driver.CTRL | SHIFT)
    assert studio.session.of(Lineation) == [made]
    click(viewport, at[3])
    key(window, Qt.Key.Key_Escape)
    assert not studio.get_tool(LineTool).is_open
    assert len(studio.session.of(Lineation)) == 1


@pytest.mark.full
def test_a_double_click_ends_a_line_and_a_drag_orbits_while_it_is_picked(picked, picks):
    from PySide6.QtTest import QTest

    window, studio, viewport = picked, picked.studio, picked.viewport
    at = spots(window, picks["B01"])
    key(window, Qt.Key.Key_L)
    click(viewport, at[0])
    click(viewport, at[2])
    camera = viewport.moves.camera_state()
    drag(viewport, at[4], at[4] + QPoint(40, 30))
    assert viewport.moves.camera_state() != camera
    assert len(studio.get_tool(LineTool).vertices) == 2
    QTest.qWait(20)
    QTest.mouseDClick(viewport, driver.LEFT, driver.NONE, at[3])
    assert not studio.get_tool(LineTool).is_open
    (made,) = studio.session.of(Lineation)
    assert len(made.vertices) >= 2


@pytest.mark.full
def test_distances_and_areas_are_measured_with_the_mouse(picked, picks):
    window, studio, viewport = picked, picked.studio, picked.viewport
    at = spots(window, picks["B01"])
    key(window, Qt.Key.Key_M)
    click(viewport, at[0])
    move(viewport, at[3])
    assert reading(window)[0].startswith("Distance ")
    click(viewport, at[4])
    (first,) = studio.session.of(Dimension)
    ends = [viewport.world_position(viewport.pick(p.x(), p.y())) for p in (at[0], at[4])]
    assert studio.measured([first.id])[first.id].dimension["distance_m"] == pytest.approx(
        np.linalg.norm(ends[1] - ends[0]), abs=1e-9
    )
    driver.tool_panel(window, MeasurePanel).kind_box.setCurrentIndex(
        driver.tool_panel(window, MeasurePanel).kind_box.findData("area")
    )
    driver.tool_panel(window, MeasurePanel).kind_box.activated.emit(
        driver.tool_panel(window, MeasurePanel).kind_box.currentIndex()
    )
    driver.focus(window)
    for spot in (at[0], at[3], at[3] + QPoint(0, 40), at[0] + QPoint(0, 40)):
        click(viewport, spot)
    driver.keep_picture(window, "lines-2-area")
    key(window, Qt.Key.Key_Return)
    assert [d.kind for d in studio.session.of(Dimension)] == ["distance", "area"]
    area = studio.session.of(Dimension)[1]
    assert studio.measured([area.id])[area.id].dimension["area_m2"] > 0.0
    key(window, Qt.Key.Key_N)
    studio.selection.set([first.id])
    key(window, Qt.Key.Key_Delete)
    assert studio.session.of(Dimension) == [area]
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert len(studio.session.of(Dimension)) == 2


@pytest.mark.full
def test_view_can_look_along_an_intersection(picked, picks):
    window, studio = picked, picked.studio
    studio.selection.set(["B01", OTHER])
    window.actions_table.all["keep_intersection"].trigger()
    (made,) = studio.session.of(Intersection)
    line = studio.measured([made.id])[made.id].line
    driver.focus(window)
    key(window, Qt.Key.Key_I)
    wait(lambda: window.viewport.moves.orthographic, "the orthographic view")
    trend, plunge = window.viewport.moves.view_direction()
    seen = lines_to_vectors(trend, plunge)
    assert abs(seen @ line.vector()) == pytest.approx(1.0, abs=1e-6)
    model = driver.model(window)
    facing = first_view(studio.models[model.id].data, transform.matrix(model.to_world))
    assert seen @ lines_to_vectors(*facing) > 0.0, "onto the rock, not from behind it"
    start, end = studio.measured([made.id])[made.id].points
    one, other = pixel(window, start), pixel(window, end)
    assert (one - other).manhattanLength() <= 1, "the line is seen end on"
