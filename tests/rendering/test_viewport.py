"""The widget under real mouse events."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPoint, QPointF, QRect, Qt
from PySide6.QtGui import QImage, QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMainWindow

from tests.messages import figures
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.geometry.plane_discs import disc
from vomstudio.rendering.qt import compass_and_scale, painting
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.symbols import disc_symbol, plane_symbol
from vomstudio.studio.tools.interaction_types import Button, Pointer, PointerEvent, Preview

UTM = np.array([576_712.0, 5_188_140.0, 183.0])
NONE = Qt.KeyboardModifier.NoModifier
LEFT = Qt.MouseButton.LeftButton


def wall(n: int = 40, texture: Path | None = None, shift: float = 0.0) -> Mesh:
    """10 m wide and 8 m high, facing south, at UTM coordinates."""
    x, z = np.meshgrid(np.linspace(0, 10, n + 1), np.linspace(0, 8, n + 1))
    y = 0.3 * np.sin(2.0 * x) * np.cos(z) + shift
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)]
    ).astype(np.int32)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3) + UTM
    if texture is None:
        return Mesh(vertices, faces)
    uv = np.stack([x / 10, z / 8], -1).reshape(-1, 2).astype(np.float32)
    offsets = np.array([0, len(faces)], np.int64)
    return Mesh(vertices, faces, (Material("m", texture),), offsets, uv)


class Stage:
    """A window with a viewport, and what the viewport has said."""

    def __init__(self, size: tuple[int, int] = (700, 500)) -> None:
        self.window = QMainWindow()
        self.view = Viewport()
        self.window.setCentralWidget(self.view)
        self.window.resize(*size)
        self.events: list[PointerEvent] = []
        self.stages: list[tuple[str, str]] = []
        self.problems: list[Finding] = []
        self.first: list[float] = []
        self.view.pointer.connect(self.events.append)
        self.view.model_stage.connect(lambda m, s: self.stages.append((m, s)))
        self.view.problem.connect(self.problems.append)
        self.view.first_frame.connect(lambda: self.first.append(time.perf_counter()))
        self.window.show()
        self.wait(lambda: bool(self.first))

    def wait(self, until: Callable[[], bool], seconds: float = 10.0) -> None:
        end = time.perf_counter() + seconds
        while not until():
            assert time.perf_counter() < end, "it did not happen in time"
            QApplication.processEvents()
            time.sleep(0.001)

    def settle(self, seconds: float = 0.4) -> None:
        end = time.perf_counter() + seconds
        self.wait(lambda: time.perf_counter() > end)

    def show(self, model_id: str, data: Mesh | PointCloud) -> None:
        self.view.models.add(model_id, data, np.eye(4), frame_camera=True)
        self.wait(
            lambda: {(model_id, s) for s in ("shown", "complete", "pickable")} <= set(self.stages)
        )
        self.settle()

    def send(
        self,
        kind: QMouseEvent.Type,
        x: float,
        y: float,
        button: Qt.MouseButton = LEFT,
        buttons: Qt.MouseButton = LEFT,
        modifiers: Qt.KeyboardModifier = NONE,
    ) -> None:
        at = QPointF(x, y)
        event = QMouseEvent(kind, at, self.view.mapToGlobal(at), button, buttons, modifiers)
        QApplication.sendEvent(self.view, event)

    def drag(
        self,
        path: list[tuple[float, float]],
        button: Qt.MouseButton = LEFT,
        modifiers: Qt.KeyboardModifier = NONE,
    ) -> None:
        self.send(QMouseEvent.Type.MouseButtonPress, *path[0], button, button, modifiers)
        for x, y in path[1:]:
            none = Qt.MouseButton.NoButton
            self.send(QMouseEvent.Type.MouseMove, x, y, none, button, modifiers)
            QApplication.processEvents()
        none = Qt.MouseButton.NoButton
        self.send(QMouseEvent.Type.MouseButtonRelease, *path[-1], button, none, modifiers)

    @property
    def frames(self) -> int:
        assert self.view.scene is not None
        return self.view.scene.canvas.frames

    def picture(self) -> np.ndarray:
        image = self.window.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
        raw = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
        return raw[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


@pytest.fixture
def stage(qapp: QApplication) -> Iterator[Stage]:
    made = Stage()
    yield made
    made.window.close()
    made.view.shutdown()
    made.window.deleteLater()
    QApplication.processEvents()


def test_pick_projects_back_to_its_pixel(stage: Stage) -> None:
    mesh = wall()
    stage.show("w", mesh)
    rng = np.random.default_rng(0)
    hits = 0
    for x, y in rng.uniform(0.25, 0.75, (30, 2)) * (stage.view.width(), stage.view.height()):
        hit = stage.view.pick(x, y)
        if hit is None:
            continue
        hits += 1
        pixels, seen = stage.view.project(stage.view.world_position(hit)[None])
        np.testing.assert_allclose(pixels[0], (x, y), atol=0.01)
        assert seen[0]
        origin, direction = stage.view.ray(x, y)
        off = np.cross(np.array(hit.position) - origin, direction)
        assert np.linalg.norm(off) < 1e-4
    assert hits > 20


def test_a_grab_of_the_window_shows_the_outcrop(stage: Stage, tmp_path: Path) -> None:
    path = tmp_path / "t.png"
    Image.new("RGB", (8, 8), (200, 80, 20)).save(path)
    stage.show("w", wall(texture=path))
    near = np.abs(stage.picture() - (200, 80, 20)).max(axis=2) <= 3
    assert near.mean() > 0.3
    assert stage.problems == []


def test_each_drag_step_draws_once_and_idle_view_does_not_draw(stage: Stage) -> None:
    stage.show("w", wall())
    before = stage.frames
    path = [(350.0, 250.0), (360.0, 250.0)] + [(360.0 + 4 * i, 250.0) for i in range(1, 11)]
    stage.drag(path)
    assert stage.frames - before == len(path) - 1
    stage.settle(0.6)
    resting = stage.frames
    stage.settle(0.5)
    assert stage.frames == resting


def test_several_moves_before_a_paint_are_drawn_once(stage: Stage) -> None:
    stage.show("w", wall())
    before = stage.frames
    for i in range(8):
        stage.view.moves.look_along(10.0 * i, 20.0)
    QApplication.processEvents()
    assert stage.frames - before == 1


def test_moving_the_preview_does_not_redraw_the_outcrop(stage: Stage) -> None:
    stage.show("w", wall())
    before, plain = stage.frames, stage.picture()
    line = UTM + np.array([[2.0, -0.2, 3.0], [6.0, -0.2, 5.0], [8.0, -0.2, 5.0]])
    for k in range(5):
        stage.view.set_preview(Preview(line, line[-1] + 0.1 * k, line, reading=("132/41",)))
        QApplication.processEvents()
    assert stage.frames == before
    assert (np.abs(stage.picture() - plain).max(axis=2) > 30).sum() > 500
    stage.view.set_preview(None)
    QApplication.processEvents()
    assert np.abs(stage.picture() - plain).max() == 0


def test_click_reports_its_hit_and_keeps_the_camera(stage: Stage) -> None:
    stage.show("w", wall())
    state = stage.view.moves.camera_state()
    QTest.mouseClick(stage.view, LEFT, NONE, QPoint(340, 240))
    clicks = [e for e in stage.events if e.kind is Pointer.CLICK]
    assert len(clicks) == 1
    assert (clicks[0].x, clicks[0].y, clicks[0].button) == (340.0, 240.0, Button.LEFT)
    assert clicks[0].hit is not None
    assert stage.view.moves.camera_state() == state


def test_press_moved_by_three_pixels_is_a_click_and_by_ten_a_drag(stage: Stage) -> None:
    stage.show("w", wall())
    state = stage.view.moves.camera_state()
    stage.drag([(340.0, 240.0), (342.0, 241.0), (343.0, 240.0)])
    assert [e.kind for e in stage.events if e.kind is not Pointer.MOVE] == [Pointer.CLICK]
    assert stage.view.moves.camera_state() == state
    stage.events.clear()
    stage.drag([(340.0, 240.0), (350.0, 240.0)])
    assert [e for e in stage.events if e.kind is not Pointer.MOVE] == []
    assert stage.view.moves.camera_state() != state


def test_orbiting_turns_about_the_point_under_the_cursor(stage: Stage) -> None:
    stage.show("w", wall())
    hit = stage.view.pick(300.0, 200.0)
    assert hit is not None
    point = stage.view.world_position(hit)
    stage.drag([(300.0, 200.0), (320.0, 215.0), (360.0, 230.0)])
    pixels, _ = stage.view.project(point[None])
    np.testing.assert_allclose(pixels[0], (300.0, 200.0), atol=1e-3)
    assert abs(stage.view.camera.frame[0, 2]) < 1e-9


@pytest.mark.parametrize(
    ("button", "modifiers"),
    [
        (Qt.MouseButton.MiddleButton, NONE),
        (LEFT, Qt.KeyboardModifier.ShiftModifier),
    ],
)
def test_panning_carries_the_point_with_the_cursor(
    stage: Stage, button: Qt.MouseButton, modifiers: Qt.KeyboardModifier
) -> None:
    stage.show("w", wall())
    hit = stage.view.pick(300.0, 200.0)
    assert hit is not None
    direction = stage.view.moves.view_direction()
    stage.drag([(300.0, 200.0), (320.0, 215.0), (361.0, 233.0)], button, modifiers)
    pixels, _ = stage.view.project(stage.view.world_position(hit)[None])
    np.testing.assert_allclose(pixels[0], (361.0, 233.0), atol=1e-3)
    assert stage.view.moves.view_direction() == direction


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_wheel_zooms_to_the_cursor(stage: Stage, orthographic: bool) -> None:
    stage.show("w", wall())
    stage.view.moves.set_orthographic(orthographic)
    QApplication.processEvents()
    at = QPointF(250.0, 180.0)
    hit = stage.view.pick(at.x(), at.y())
    assert hit is not None
    scale = stage.view.moves.metres_per_pixel()
    wheel = QWheelEvent(
        at,
        stage.view.mapToGlobal(at),
        QPoint(),
        QPoint(0, 240),
        Qt.MouseButton.NoButton,
        NONE,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(stage.view, wheel)
    pixels, _ = stage.view.project(stage.view.world_position(hit)[None])
    np.testing.assert_allclose(pixels[0], (250.0, 180.0), atol=1e-3)
    assert stage.view.moves.metres_per_pixel() < 0.8 * scale


def test_double_click_is_reported_once_and_sets_the_pivot(stage: Stage) -> None:
    stage.show("w", wall())
    QTest.mouseDClick(stage.view, LEFT, NONE, QPoint(340, 240))
    kinds = [e.kind for e in stage.events if e.kind is not Pointer.MOVE]
    assert kinds.count(Pointer.DOUBLE_CLICK) == 1
    assert kinds.count(Pointer.CLICK) <= 1
    hit = stage.view.pick(340.0, 240.0)
    assert hit is not None
    np.testing.assert_allclose(
        stage.view.moves.camera_state()["pivot"], stage.view.world_position(hit), atol=1e-6
    )


def test_hovering_reports_the_point_under_the_cursor(stage: Stage) -> None:
    stage.show("w", wall())
    none = Qt.MouseButton.NoButton
    for k in range(20):
        stage.send(QMouseEvent.Type.MouseMove, 300.0 + k, 220.0, none, none)
    stage.settle(0.1)
    moves = [e for e in stage.events if e.kind is Pointer.MOVE]
    assert 1 <= len(moves) < 20
    assert moves[-1].x == 319.0
    assert moves[-1].hit is not None


def test_dragging_a_handle_is_left_to_the_tool(stage: Stage) -> None:
    stage.show("w", wall())
    line = []
    for x in (250.0, 350.0, 450.0):
        hit = stage.view.pick(x, 240.0)
        assert hit is not None
        line.append(stage.view.world_position(hit))
    stage.view.set_preview(Preview(np.array(line)))
    state = stage.view.moves.camera_state()
    stage.drag([(351.0, 241.0), (360.0, 241.0), (380.0, 250.0)])
    kinds = [e.kind for e in stage.events if e.kind is not Pointer.MOVE]
    assert kinds == [Pointer.DRAG_START, Pointer.DRAG_MOVE, Pointer.DRAG_MOVE, Pointer.DRAG_END]
    dragged = [e for e in stage.events if e.kind is not Pointer.MOVE]
    assert {e.handle for e in dragged} == {1}
    assert dragged[-1].hit is not None
    assert stage.view.moves.camera_state() == state


def test_feature_under_the_cursor_is_identified(stage: Stage) -> None:
    stage.show("w", wall())
    ends = [stage.view.pick(200.0, 200.0), stage.view.pick(500.0, 300.0)]
    line = np.array([stage.view.world_position(h) for h in ends if h is not None])
    assert len(line) == 2
    ring = UTM + np.array([[4.0, -0.5, 1.0], [6.0, -0.5, 1.0], [5.0, -0.5, 2.5]])
    drawings = {
        "trace": FeatureDrawing("trace", line, None, (0.9, 0.6, 0.0), "B01", line[0]),
        "disc": FeatureDrawing("disc", line[:0], ring, (0.0, 0.6, 0.5), "", ring[0]),
    }
    stage.view.features.change(drawings)
    QApplication.processEvents()
    pixels, _ = stage.view.project(np.concatenate([line, ring]))
    middle = pixels[:2].mean(axis=0)
    assert stage.view.features.at(middle[0], middle[1] + 2.0) == "trace"
    assert stage.view.features.at(*pixels[2:].mean(axis=0)) == "disc"
    assert stage.view.features.at(5.0, 5.0) is None
    label = stage.view.overlays.annotations.label_boxes[0]
    assert stage.view.features.at(label[1].center().x(), label[1].center().y()) == "trace"
    stage.view.features.change({"trace": None})
    QApplication.processEvents()
    assert stage.view.features.at(middle[0], middle[1]) is None


def test_selecting_does_not_change_the_feature_colour(stage: Stage) -> None:
    stage.show("w", wall())
    stage.view.moves.look_along(0.0, 0.0)
    line = UTM + np.array([[1.0, -0.6, 4.0], [9.0, -0.6, 4.0]])
    color = np.array([230, 153, 0])
    stage.view.features.change(
        {"f": FeatureDrawing("f", line, None, tuple(color / 255.0), "", line[0])}
    )
    stage.settle()
    plain = (np.abs(stage.picture() - color).max(axis=2) <= 6).sum()
    stage.view.features.select(["f"])
    stage.settle(0.1)
    picture = stage.picture()
    assert (np.abs(picture - color).max(axis=2) <= 6).sum() > 1.4 * plain > 0
    assert (picture.min(axis=2) > 245).sum() > plain


@pytest.mark.parametrize("kind", ["good", "doubtful", "poor"])
def test_verdict_marks_differ_in_shape_as_well_as_colour(qapp: QApplication, kind: str) -> None:
    from PySide6.QtCore import QRectF
    from PySide6.QtGui import QPainter

    image = QImage(40, 40, QImage.Format.Format_RGB888)
    image.fill(Qt.GlobalColor.black)
    painter = QPainter(image)
    painting.draw_verdict_shape(painter, QRectF(4.0, 4.0, 32.0, 32.0), kind)
    painter.end()
    raw = np.frombuffer(image.constBits(), np.uint8).reshape(40, -1)[:, :120].reshape(40, 40, 3)
    filled = raw.max(axis=2) > 60
    share = filled[4:36, 4:36].mean()
    corners = filled[6, 6], filled[6, 33]
    if kind == "good":
        assert 0.7 < share < 0.9
    elif kind == "doubtful":
        assert share < 0.65
        assert not any(corners)
    else:
        assert share > 0.85
        assert all(corners)


def test_scale_bar_length_is_correct_in_the_orthographic_view(stage: Stage) -> None:
    stage.show("w", wall())
    stage.view.moves.set_orthographic(True)
    stage.view.moves.look_along(37.0, 12.0)
    QApplication.processEvents()
    length, pixels = compass_and_scale.scale_bar(
        stage.view.moves.metres_per_pixel(), stage.view.width()
    )
    assert length in {m * 10.0**e for m in (1.0, 2.0, 5.0) for e in range(-3, 3)}
    right = stage.view.camera.frame[0]
    for start in UTM + np.array([[0.0, 0.0, 0.0], [8.0, 5.0, 3.0]]):
        marks, _ = stage.view.project(np.stack([start, start + length * right]))
        assert np.hypot(*(marks[1] - marks[0])) == pytest.approx(pixels, abs=0.01)
    picture = stage.picture()
    row = picture[stage.view.height() - round(compass_and_scale.MARGIN) - 4]
    white = np.flatnonzero(row.min(axis=1) > 200)
    assert np.ptp(white) + 1 == pytest.approx(pixels, abs=2.5)


@pytest.mark.full
def test_scale_bar_shows_its_depth_only_in_perspective_if_not_covered(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage.show("w", wall())
    notes: list[str] = []
    draw = compass_and_scale.draw_scale_bar

    def draw_and_record(*arguments: object, note: str, **more: object) -> None:
        notes.append(note)
        draw(*arguments, note=note, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(compass_and_scale, "draw_scale_bar", draw_and_record)
    box = compass_and_scale.scale_bar_box(stage.view.width(), stage.view.height()).toRect()

    def picture_of_the_bar(widget: QRect) -> np.ndarray:
        stage.view.set_covered(widget)
        stage.settle(0.1)
        return stage.picture()[box.top() : box.bottom(), box.left() : box.right()]

    for is_orthographic in (True, False):
        stage.view.moves.set_orthographic(is_orthographic)
        stage.wait(lambda: stage.view.is_still)
        free, free_note = picture_of_the_bar(QRect()), notes[-1]
        covered, covered_note = picture_of_the_bar(box), notes[-1]
        assert (free == covered).all() == is_orthographic
        # The note names a place, not a distance.
        assert bool(free_note) != is_orthographic
        assert figures(free_note) == []
        assert covered_note == ""


def test_view_direction_is_read_back(stage: Stage) -> None:
    stage.view.moves.look_along(125.3, 26.1)
    assert stage.view.moves.view_direction() == pytest.approx((125.3, 26.1))
    stage.view.moves.set_standard_view("top")
    assert stage.view.moves.view_direction()[1] == pytest.approx(90.0)
    stage.view.moves.set_standard_view("west")
    assert stage.view.moves.view_direction() == pytest.approx((270.0, 0.0), abs=1e-9)


def test_models_added_and_removed_leave_nothing_behind(stage: Stage) -> None:
    for k in range(15):
        stage.view.models.add(f"m{k}", wall(20), np.eye(4), frame_camera=True)
        if k % 3:
            stage.settle(0.03)
        stage.view.models.remove(f"m{k}")
    stage.settle(0.3)
    assert stage.view.scene is not None
    assert stage.view.scene.models == {}
    assert stage.view.scene.canvas.surface.GetActors().GetNumberOfItems() == 0
    stage.show("last", wall())
    assert stage.view.pick(350.0, 250.0) is not None


def test_a_model_can_be_hidden_and_moved(stage: Stage) -> None:
    stage.show("w", wall())
    hit = stage.view.pick(350.0, 250.0)
    assert hit is not None
    stage.view.models.set_visible("w", False)
    assert stage.view.pick(350.0, 250.0) is None
    stage.view.models.set_visible("w", True)
    redraw = np.eye(4)
    redraw[:3, 3] = (0.0, 0.0, 1.0)
    stage.view.models.set_to_world("w", redraw)
    again = stage.view.pick(350.0, 250.0)
    assert again is not None
    assert abs(again.position[2] - hit.position[2] + 1.0) < 0.05


def test_missing_texture_is_reported_once(stage: Stage, tmp_path: Path) -> None:
    stage.show("w", wall(texture=tmp_path / "absent.jpg"))
    assert len(stage.problems) == 1
    assert stage.problems[0].code == "display.texture-unreadable"
    assert stage.problems[0].values["file"].endswith("absent.jpg")


@pytest.mark.full
def test_windows_opened_and_closed_many_times_leave_no_thread(qapp: QApplication) -> None:
    before = set(threading.enumerate())
    for k in range(12):
        made = Stage((300, 200))
        made.view.models.add("w", wall(30), np.eye(4), frame_camera=True)
        if k % 2:
            made.settle(0.05)
        made.window.close()
        made.view.shutdown()
        made.view.shutdown()
        made.window.deleteLater()
        QApplication.processEvents()
    assert set(threading.enumerate()) <= before


def test_requests_before_the_window_is_shown_are_executed_afterwards(qapp: QApplication) -> None:
    window, view = QMainWindow(), Viewport()
    assert view.pick(1.0, 1.0) is None
    stages: list[str] = []
    view.model_stage.connect(lambda _, s: stages.append(s))
    view.models.add("w", wall(), np.eye(4), frame_camera=True)
    view.display.set_mode("plain shaded")
    line = UTM + np.array([[1.0, -0.6, 4.0], [9.0, -0.6, 4.0]])
    view.features.change({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "F", line[0])})
    view.features.select(["f"])
    window.setCentralWidget(view)
    window.resize(500, 400)
    window.show()
    end = time.perf_counter() + 20.0
    while "complete" not in stages and time.perf_counter() < end:
        QApplication.processEvents()
        time.sleep(0.001)
    assert view.pick(250.0, 200.0) is not None
    assert view.features.at(*view.project(line.mean(axis=0)[None])[0][0]) == "f"
    window.close()
    view.shutdown()
    window.deleteLater()
    QApplication.processEvents()


def test_a_real_cloud_is_shown_and_picked(stage: Stage, data_dir: Path) -> None:
    from vomstudio.io.models.opening import read_model

    loaded = read_model(data_dir / "compass_outcrop" / "outcrop.laz")
    stage.show("c", loaded.data)
    picture = stage.picture()
    drawn = np.abs(picture - picture[5, 350]).max(axis=2) > 12
    assert drawn.mean() > 0.05
    rows, columns = np.nonzero(drawn[100:400, 150:550])
    middle = len(rows) // 2
    hit = stage.view.pick(150.0 + columns[middle], 100.0 + rows[middle])
    assert hit is not None
    assert isinstance(loaded.data, PointCloud)
    np.testing.assert_array_equal(hit.position, loaded.data.points[hit.index])


def test_symbol_keeps_its_size_and_can_be_clicked(stage: Stage) -> None:
    stage.show("w", wall())
    stage.view.moves.look_along(0.0, 0.0)
    place = UTM + np.array([5.0, -0.4, 4.0])
    color = (0.9, 0.6, 0.0)
    symbol = plane_symbol(180.0, 45.0, place, 2.0)
    drawing = FeatureDrawing("s", np.zeros((0, 3)), None, color, "", place, symbol=symbol)
    stage.view.features.change({"s": drawing})
    widths = []
    for zoom in (1.0, 2.0):
        stage.view.camera.zoom(zoom, place)
        stage.view.moves.redraw()
        stage.settle()
        shown = np.abs(stage.picture() - 255.0 * np.array(color)).max(axis=2) <= 12
        columns = np.flatnonzero(shown.any(axis=0))
        widths.append(columns.max() - columns.min())
        (x, y), *_ = stage.view.project(place[None])[0]
        assert stage.view.features.at(x + 14.0, y) == "s"
        assert stage.view.features.at(x, y + 8.0) == "s"
        assert stage.view.features.at(x, y - 20.0) is None
    assert widths[0] == pytest.approx(36.0, abs=4.0)
    assert widths[1] == pytest.approx(widths[0], abs=2.0)


def test_disc_too_small_to_see_is_drawn_as_a_clickable_dot(stage: Stage) -> None:
    stage.show("w", wall())
    stage.view.moves.look_along(0.0, 0.0)
    place = UTM + np.array([5.0, -0.4, 4.0])
    ring = disc(place, [0.0, 1.0, 0.0], 0.01)
    drawing = FeatureDrawing(
        "s",
        np.zeros((0, 3)),
        ring,
        (0.9, 0.6, 0.0),
        "",
        place,
        symbol=disc_symbol(place, 0.02),
        extent=0.02,
    )
    stage.view.features.change({"s": drawing})
    stage.settle()
    (x, y), *_ = stage.view.project(place[None])[0]
    shown = np.abs(stage.picture() - [229.5, 153.0, 0.0]).max(axis=2) <= 30
    assert 20 < shown.sum() < 120
    assert stage.view.features.at(x + 4.0, y) == "s"
    # Large on the screen it is a disc and nothing else.
    stage.view.camera.zoom(0.02, place)
    stage.view.moves.redraw()
    stage.settle()
    assert not len(stage.view.overlays.annotations._strokes)


def test_a_line_on_the_surface_does_not_hide_its_own_points(stage: Stage) -> None:
    """Lines stand before the surface by an offset: without it they would be cut up by it."""
    stage.show("w", wall())
    line = np.array(
        [stage.view.world_position(stage.view.pick(x, 240.0)) for x in np.linspace(200, 500, 40)]
    )
    assert stage.view.project(line)[1].all()
    drawing = FeatureDrawing("f", line, None, (0.9, 0.6, 0.0), "f", line[20])
    stage.view.features.change({"f": drawing})
    stage.view.features.select(["f"])
    stage.settle()
    assert stage.view.project(line)[1].all()


def test_trace_is_labelled_at_its_visible_part(stage: Stage) -> None:
    """Near by, the middle of a long trace is out of the picture."""
    stage.show("w", wall())
    line = np.array(
        [stage.view.world_position(stage.view.pick(x, 240.0)) for x in np.linspace(150, 550, 41)]
    )
    stage.view.features.change(
        {"f": FeatureDrawing("f", line, None, (0.9, 0.6, 0.0), "f", line[20])}
    )
    stage.settle()
    assert stage.view.overlays.annotations.label_boxes
    stage.view.camera.set_pivot(line[10])
    stage.view.camera.zoom(0.2, line[10])
    stage.view.moves.redraw()
    stage.settle()
    pixels, seen = stage.view.project(line[[10, 20]])
    assert seen.tolist() == [True, False]
    ((_, box),) = stage.view.overlays.annotations.label_boxes
    assert abs(box.center().x() - pixels[0, 0]) < 60.0


def test_many_features_are_labelled_only_if_selected_or_requested(stage: Stage) -> None:
    stage.show("w", wall())
    stage.view.moves.look_along(0.0, 0.0)
    stage.settle()

    def labelled(count: int, mode: str) -> set[str]:
        drawings = {
            str(i): FeatureDrawing(
                str(i),
                np.zeros((0, 3)),
                None,
                (0.9, 0.6, 0.0),
                "B",
                UTM + np.array([1.0 + 0.2 * i, -0.6, 1.0 + (i % 5)]),
                extent=1.0,
            )
            for i in range(count)
        }
        stage.view.features.change(drawings)
        stage.view.features.select(frozenset({"3"}))
        stage.view.set_label_mode(mode)
        stage.settle()
        return {key for key, _ in stage.view.overlays.annotations.label_boxes}

    assert len(labelled(20, "auto")) > 5
    assert labelled(20, "selected") == {"3"}
    assert labelled(20, "none") == set()
    assert labelled(40, "auto") == {"3"}
    assert len(labelled(40, "all")) > 5


@pytest.mark.full
def test_labels_are_stable_while_the_view_rotates(stage: Stage) -> None:
    stage.view.set_label_mode("all")
    stage.show("w", wall())
    stage.view.moves.look_along(0.0, 0.0)
    stage.settle()
    rng = np.random.default_rng(5)
    drawings = {}
    for i in range(300):
        place = UTM + np.array([rng.uniform(1, 9), -0.6, rng.uniform(1, 7)])
        drawings[str(i)] = FeatureDrawing(
            str(i),
            np.zeros((0, 3)),
            None,
            (0.9, 0.6, 0.0),
            f"B{i:03d} 132/41",
            place,
            extent=float(rng.uniform(0.5, 5.0)),
        )
    stage.view.features.change(drawings)
    stage.settle()

    def shown() -> set[str]:
        return {key for key, _ in stage.view.overlays.annotations.label_boxes}

    first = last = shown()
    changes = 0
    for _ in range(20):
        stage.view.camera.orbit(0.2, 0.05)
        stage.view.moves.redraw()
        stage.view.repaint()
        changes += len(shown() ^ last)
        last = shown()
    assert len(first) > 15
    # Half a turn of the hand: hardly any label has gone or come, and none has flickered.
    assert changes <= 0.25 * len(first)
    assert len(first & last) >= 0.85 * len(first)
    # At rest there is room for those again that had to wait.
    stage.settle()
    assert len(shown()) >= 0.9 * len(first)
