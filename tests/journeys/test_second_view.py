"""The second view beside the outcrop, with the mouse: its camera, models, features and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from tests import driver
from tests.driver import CTRL, LEFT, NONE, click, wait
from vomstudio.geometry.transform import apply
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.rendering.qt.second_view import SecondView
from vomstudio.ui.panels.view.second_view_panel import SecondViewPanel
from vomstudio.ui.shell.main_window import MainWindow

pytestmark = pytest.mark.full

STEPS = 20


@dataclass
class Beside:
    """A window with the outcrop, and the second view beside it."""

    window: MainWindow
    model_id: str
    panel: SecondViewPanel

    @property
    def view(self) -> SecondView:
        assert self.panel.view is not None
        return self.panel.view

    def rest(self) -> None:
        viewport = self.window.viewport
        wait(lambda: viewport.is_still, "the rest of the outcrop")
        wait(lambda: self.view.is_still, "the rest of the second view")

    def frames(self) -> int:
        return self.view.scene.canvas.frames

    def drag(self, widget: QWidget, by: QPoint) -> None:
        """Drag with the left button from the middle, in steps that are drawn."""
        start = widget.rect().center()

        def send(kind: QEvent.Type, at: QPoint, held: Qt.MouseButton) -> None:
            button = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else LEFT
            place = QPointF(widget.mapToGlobal(at))
            event = QMouseEvent(kind, QPointF(at), place, button, held, NONE)
            QApplication.sendEvent(widget, event)

        send(QEvent.Type.MouseButtonPress, start, LEFT)
        for step in range(1, STEPS + 1):
            send(QEvent.Type.MouseMove, start + by * step / STEPS, LEFT)
            driver.pause(5)
        send(QEvent.Type.MouseButtonRelease, start + by, Qt.MouseButton.NoButton)

    def pixel(self, point: np.ndarray) -> QPoint:
        """Where a World point is in the second view; it must be in sight."""
        pixels, visible = self.view.project(np.asarray(point, float)[None])
        assert visible.all()
        return QPoint(*(round(float(v)) for v in pixels[0]))


@pytest.fixture
def beside(window, outcrop, picks) -> Beside:
    """The outcrop with two of its traces, and the second view."""
    model_id = driver.open_outcrop(window, outcrop)
    record = window.studio.records[model_id]
    for name, points in list(picks.items())[:2]:
        vertices = tuple(tuple(p) for p in points.tolist())
        trace = Trace(name, name, "bedding", model_id, record.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, trace)
    window.actions_table.run("second_view")
    return begun(window, model_id)


def begun(window, model_id: str) -> Beside:
    page = window.docks["second_view"].widget()
    wait(lambda: isinstance(page.widget(), SecondViewPanel), "the page")
    panel = page.widget()
    wait(lambda: panel.view is not None, "the libraries", 60.0)
    wait(lambda: panel.view.is_still, "the picture", 60.0)
    made = Beside(window, model_id, panel)
    made.rest()
    return made


def directions(beside: Beside) -> tuple[np.ndarray, np.ndarray]:
    return beside.view.camera.direction.copy(), beside.window.viewport.camera.direction.copy()


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def test_a_drag_turns_both_views_only_while_they_are_linked(beside):
    viewport, plotter = beside.window.viewport, beside.view.plotter
    before = directions(beside)[1]
    beside.drag(plotter, QPoint(60, 15))
    second, first = directions(beside)
    assert not np.allclose(first, before, atol=1e-3)
    np.testing.assert_allclose(second, first)
    beside.drag(viewport, QPoint(-30, 10))
    second, first = directions(beside)
    np.testing.assert_allclose(second, first)

    press(beside.panel.link)
    beside.drag(plotter, QPoint(60, 15))
    second, still = directions(beside)
    np.testing.assert_allclose(still, first)
    assert not np.allclose(second, first, atol=1e-3)
    beside.drag(viewport, QPoint(25, 5))
    np.testing.assert_allclose(directions(beside)[0], second)

    press(beside.panel.link)
    second, first = directions(beside)
    np.testing.assert_allclose(second, first)


def test_drag_is_drawn_once_per_step_and_idle_view_is_not_redrawn(beside):
    begin = beside.frames()
    beside.drag(beside.view.plotter, QPoint(120, 30))
    assert beside.frames() - begin <= STEPS + 1
    beside.rest()
    drawn = beside.frames()
    # A busy computer draws a simpler model while it moves, and then the model and the features.
    assert STEPS <= drawn - begin <= STEPS + 3
    driver.pause(700)
    driver.move(beside.view.plotter, beside.view.plotter.rect().center())
    beside.window.grab()
    driver.pause(200)
    assert beside.frames() == drawn


def test_a_click_selects_in_both_views(beside, picks):
    studio = beside.window.studio
    (first, points), (second, others) = list(picks.items())[:2]
    beside.view.moves.frame(np.concatenate([points, others]))
    beside.rest()
    studio.selection.set(())
    beside.rest()
    click(beside.view.plotter, beside.pixel(points[len(points) // 2]))
    assert studio.selection.ids == (first,)
    beside.rest()
    assert beside.view.scene.features.selected == {first}
    assert beside.window.viewport.features.selected == {first}
    click(beside.view.plotter, beside.pixel(others[len(others) // 2]), CTRL)
    assert set(studio.selection.ids) == {first, second}
    driver.keep_picture(beside.window, "second-view-selected")


def test_a_trace_is_drawn_in_the_second_view(beside, picks):
    window, studio = beside.window, beside.window.studio
    points = list(picks.values())[2]
    beside.view.moves.frame(points)
    beside.rest()
    before = len(driver.traces(window))
    window.actions_table.run("trace")
    driver.pause()
    places = points[beside.view.project(points)[1]]
    places = places[:: max(1, len(places) // 6)]
    for place in places:
        click(beside.view.plotter, beside.pixel(place))
    assert beside.view.preview is not None
    window.viewport.setFocus()
    driver.key(window, Qt.Key.Key_Return)
    wait(lambda: len(driver.traces(window)) == before + 1, "the trace")
    trace = driver.traces(window)[-1]
    vertices = apply(studio.records[trace.model_id].to_world, trace.vertices)
    assert len(vertices) == len(places)
    assert np.linalg.norm(vertices - places, axis=1).max() < 0.1


def test_second_view_follows_edits_undo_visibility_and_project_changes(beside, picks):
    window, studio, view = beside.window, beside.window.studio, beside.view
    names = list(picks)
    assert set(view.scene.features.drawings) == set(names[:2])
    studio.undo()
    beside.rest()
    assert set(view.scene.features.drawings) == set(names[:1])
    studio.redo()
    beside.rest()
    assert set(view.scene.features.drawings) == set(names[:2])
    studio.set_visible([names[0]], False)
    beside.rest()
    assert not view.scene.features.drawings[names[0]].visible

    middle = view.plotter.rect().center()
    assert view.pick(middle.x(), middle.y()) is not None
    studio.set_visible([beside.model_id], False)
    beside.rest()
    assert not view.scene.models[beside.model_id].visible
    assert view.pick(middle.x(), middle.y()) is None
    # A model that is chosen here stays, whatever the outcrop shows.
    beside.panel.show_models({beside.model_id})
    beside.rest()
    assert view.pick(middle.x(), middle.y()) is not None
    studio.set_visible([beside.model_id], True)

    window.actions_table.run("clipping_box")
    beside.rest()
    assert view.scene.clip_box is window.viewport.clip.box
    studio.display.set_mode("plain shaded")
    beside.rest()
    assert view.scene.look.mode == "plain shaded"
    studio.new_project()
    wait(lambda: not view.scene.models, "an empty view")
    beside.rest()
    assert not view.scene.features.drawings


def test_models_shown_side_by_side_share_their_data(window, outcrop, beside):
    studio, view = window.studio, beside.view
    text = outcrop.read_text()
    later = Path(outcrop).with_name("later.obj")
    later.write_text(f"# later\n{text}")
    studio.open_model(later, reference_id=beside.model_id)
    wait(lambda: len(studio.models) == 2, "the later model")
    (later_id,) = set(studio.models) - {beside.model_id}
    wait(lambda: later_id in view.scene.models, "the later model in the view")
    studio.set_visible([later_id], False)
    beside.panel.show_models({later_id})
    beside.rest()
    middle, centre = view.plotter.rect().center(), window.viewport.rect().center()
    assert view.pick(middle.x(), middle.y()).model_id == later_id
    assert window.viewport.pick(centre.x(), centre.y()).model_id == beside.model_id
    for id_, model in window.viewport.scene.models.items():
        shared = view.scene.models[id_]
        assert shared.data is model.data
        for part, source in zip(shared.parts, model.parts, strict=True):
            assert part.actor.GetMapper().GetInput() is source.actor.GetMapper().GetInput()
        for material, skin in shared.gpu_textures.items():
            assert skin.texture is model.gpu_textures[material].texture
    driver.keep_picture(window, "second-view-two-models")
    assert studio.attempt(edits.remove_model, later_id)
    wait(lambda: later_id not in view.scene.models, "a view without it")


def test_second_view_floats_docks_and_closes(beside):
    window, view = beside.window, beside.view
    dock = window.docks["second_view"]
    dock.setFloating(True)
    wait(lambda: view.plotter is not None and view.is_still, "the floating picture")
    beside.drag(view.plotter, QPoint(40, 0))
    second, first = directions(beside)
    np.testing.assert_allclose(second, first)
    beside.rest()

    window.actions_table.run("reset_panels")
    wait(lambda: view.plotter is not None and view.is_still, "the picture in its place")
    assert not dock.isFloating()
    assert dock.isVisible()
    window.actions_table.run("page_in_center")
    driver.pause(100)
    window.actions_table.run("page_in_center")
    driver.pause(100)

    window.actions_table.run("second_view")
    assert dock.isHidden()
    assert view.plotter is None
    assert view.scene is None
    window.actions_table.run("second_view")
    wait(lambda: view.plotter is not None and view.is_still, "the picture again")
    assert beside.frames() > 0


def test_standard_directions_turn_the_view(beside):
    press(beside.panel.link)
    names = {action.text(): action for action in beside.panel.direction.menu().actions()}
    first = directions(beside)[1]
    names["Looking east"].trigger()
    beside.rest()
    second, still = directions(beside)
    np.testing.assert_allclose(second, [1.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(still, first)
    names["Same as outcrop"].trigger()
    np.testing.assert_allclose(directions(beside)[0], first)
