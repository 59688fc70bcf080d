"""Fields, colour bar and clipping box in the widget, under real mouse events."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest
from matplotlib import colormaps
from PySide6.QtCore import QRectF
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from tests.rendering.test_viewport import UTM, Stage, wall
from vomstudio.geometry.cloud import PointCloud
from vomstudio.rendering.qt import compass_and_scale
from vomstudio.rendering.qt.bar_painting import ColorBar, lay_out_bars
from vomstudio.rendering.view.clipping import BOX_FACES, ClipBox
from vomstudio.rendering.view.scalars import ELEVATION, FieldStyle, Scale, make_scale

MOVE = QMouseEvent.Type.MouseMove


@pytest.fixture
def stage(qapp: QApplication) -> Iterator[Stage]:
    made = Stage()
    yield made
    made.window.close()
    made.view.shutdown()
    made.window.deleteLater()
    QApplication.processEvents()


def at_rest(stage: Stage) -> None:
    scene = stage.view.scene
    assert scene is not None
    stage.settle(0.1)
    stage.wait(lambda: stage.view.is_still)
    stage.settle(0.05)


def show_field(stage: Stage, style: FieldStyle) -> Scale:
    told: list[str] = []
    stage.view.field_shown.connect(told.append)
    stage.view.display.set_mode("field")
    stage.view.display.set_field("w", style)
    stage.wait(lambda: bool(told))
    at_rest(stage)
    scale = stage.view.display.color_scale("w")
    assert scale is not None
    return scale


def test_field_is_shown_with_its_colour_bar(stage: Stage) -> None:
    stage.show("w", wall())
    scale = show_field(stage, FieldStyle(ELEVATION, percentiles=(0.0, 100.0)))
    assert [scale.low, scale.high] == pytest.approx([UTM[2], UTM[2] + 8.0])
    picture = stage.picture()
    pixels, _ = stage.view.project(UTM + np.array([[4.0, 0.0, 2.0], [4.0, 0.0, 6.0]]))
    for (x, y), height in zip(pixels, (2.0, 6.0), strict=True):
        expected = np.array(colormaps["viridis"](height / 8.0, bytes=True)[:3], int)
        assert np.abs(picture[round(y), round(x)] - expected).max() < 12
    (bar,) = stage.view.overlays.bars
    right = picture[round(bar.box.center().y()), int(bar.box.left()) : int(bar.box.right())]
    middle = np.array(colormaps["viridis"](0.5, bytes=True)[:3], int)
    assert np.abs(right - middle).max(axis=1).min() < 12


def test_field_range_can_be_changed_and_textured_mode_removes_the_field(stage: Stage) -> None:
    stage.show("w", wall())
    show_field(stage, FieldStyle(ELEVATION))
    low, high = UTM[2] + 1.0, UTM[2] + 2.0
    scale = show_field(stage, FieldStyle(ELEVATION, low, high))
    assert (scale.low, scale.high) == (low, high)
    stage.view.display.set_mode("textured")
    at_rest(stage)
    assert stage.view.display.color_scale("w") is None
    assert not stage.view.overlays.bars
    scene = stage.view.scene
    assert scene is not None
    assert scene.models["w"].field is None


def test_field_selected_before_loading_is_shown_with_the_model(stage: Stage) -> None:
    told: list[str] = []
    stage.view.field_shown.connect(told.append)
    stage.view.display.set_mode("field")
    stage.view.models.add("w", wall(), np.eye(4), frame_camera=True)
    stage.view.display.set_field("w", FieldStyle(ELEVATION))
    stage.wait(lambda: bool(told))
    at_rest(stage)
    assert stage.view.overlays.bars


def test_elevation_follows_the_model_transform(stage: Stage) -> None:
    stage.show("w", wall())
    first = show_field(stage, FieldStyle(ELEVATION))
    told: list[str] = []
    stage.view.field_shown.connect(told.append)
    raised = np.eye(4)
    raised[2, 3] = 50.0
    stage.view.models.set_to_world("w", raised)
    stage.wait(lambda: bool(told))
    scale = stage.view.display.color_scale("w")
    assert scale is not None
    assert scale.low == pytest.approx(first.low + 50.0)


def bars_of(
    kinds: str, width: float, height: float, covered: QRectF | None = None
) -> list[ColorBar]:
    count = 4000
    rng = np.random.default_rng(0)
    fields = {
        "s": rng.gamma(2.0, 1000.0, count),
        "d": rng.normal(0.0, 1e-3, count),
        "classification": rng.integers(0, 19, count).astype(np.uint8),
        "azimuth": rng.uniform(0, 360, count),
    }
    names = {"s": "s", "d": "d", "c": "classification", "a": "azimuth"}
    cloud = PointCloud(rng.normal(0, 1, (count, 3)), fields=fields)
    scales = [make_scale(cloud, FieldStyle(names[k]), np.eye(4)) for k in kinds]
    shown = [(s, (s.title, "a model with rather a long name")) for s in scales]
    return lay_out_bars(shown, width, height, covered)


@pytest.mark.parametrize("kinds", ["s", "d", "c", "a", "scda"])
@pytest.mark.parametrize("size", [(760, 600), (1600, 1000), (420, 330)])
def test_colour_bars_do_not_overlap_scale_bar_compass_or_each_other(
    qapp: QApplication, kinds: str, size: tuple[int, int]
) -> None:
    width, height = size
    bars = bars_of(kinds, width, height)
    assert bars
    taken = [compass_and_scale.compass_box(height), compass_and_scale.scale_bar_box(width, height)]
    for bar in bars:
        assert bar.box.left() >= 0
        assert bar.box.right() <= width
        assert bar.box.top() >= 0
        assert not any(bar.box.intersects(other) for other in taken), (kinds, size)
        taken.append(bar.box)


def test_colour_bars_avoid_a_widget_over_the_view(qapp: QApplication) -> None:
    widget = QRectF(1600.0 - 290.0, 10.0, 280.0, 280.0)
    bars = bars_of("scda", 1600, 1000, widget)
    assert len(bars) > 1
    for bar in bars:
        assert bar.box.left() >= 0
        assert not bar.box.intersects(widget)
    elsewhere = QRectF(10.0, 10.0, 280.0, 280.0)
    assert bars_of("s", 1600, 1000, elsewhere)[0].box == bars_of("s", 1600, 1000)[0].box


def test_colour_bar_labels_do_not_overlap(qapp: QApplication) -> None:
    for kinds in "sda":
        (bar,) = bars_of(kinds, 760, 420)
        places = sorted(place * bar._inner_height for place, _ in bar._ticks(bar._inner_height))
        assert len(places) >= 3
        assert np.diff(places).min() >= 0.9 * bar._line


# -- clipping box


def clip(stage: Stage, handles: bool = True) -> ClipBox:
    scene = stage.view.scene
    assert scene is not None
    box = ClipBox.from_points(scene.corners())
    stage.view.clip.set_box(box, handles=handles)
    at_rest(stage)
    return box


def test_dragging_a_handle_moves_the_box_face_and_clips_the_model(stage: Stage) -> None:
    stage.show("w", wall())
    box = clip(stage)
    told: list[ClipBox] = []
    stage.view.clip_changed.connect(told.append)
    before = json.dumps(stage.view.moves.camera_state())
    face = BOX_FACES.index((0, 1))
    x, y = stage.view.clip.places()[1][face]
    goal = box.face_centre(0, 1)
    goal[0] = UTM[0] + 6.0
    (gx, gy), _ = (v[0] for v in stage.view.project(goal[None]))
    path = [(x + k / 5 * (gx - x), y + k / 5 * (gy - y)) for k in range(6)]
    stage.drag(path)
    at_rest(stage)
    assert told
    now = stage.view.clip.box
    assert now is not None
    assert now.high[0] == pytest.approx(goal[0], abs=0.1)
    assert (now.low, now.high[1:]) == (box.low, box.high[1:])
    assert json.dumps(stage.view.moves.camera_state()) == before, "the view has turned"
    assert not stage.events, "a handle is no click on the model"
    pixels, _ = stage.view.project(UTM + np.array([[5.0, 0, 6.5], [7.0, 0, 6.5]]))
    assert stage.view.pick(*pixels[0]) is not None
    assert stage.view.pick(*pixels[1]) is None


def test_drag_without_handles_rotates_the_view(stage: Stage) -> None:
    stage.show("w", wall())
    box = clip(stage, handles=False)
    before = stage.view.moves.camera_state()
    stage.view.clip.set_box(box, handles=True)
    x, y = stage.view.clip.places()[1][0]
    stage.view.clip.set_box(box, handles=False)
    stage.drag([(x, y), (x + 20, y), (x + 40, y)])
    assert stage.view.moves.camera_state() != before
    assert stage.view.clip.box == box


def test_face_seen_head_on_cannot_be_dragged(stage: Stage) -> None:
    stage.show("w", wall())
    clip(stage)
    stage.view.moves.set_orthographic(True)
    stage.view.moves.set_standard_view("north")
    at_rest(stage)
    _, places, usable = stage.view.clip.places()
    for k, (axis, _side) in enumerate(BOX_FACES):
        assert usable[k] == (axis != 1)
    assert stage.view.clip.face_at(*places[BOX_FACES.index((1, 0))]) is None
    assert stage.view.clip.face_at(*places[BOX_FACES.index((2, 1))]) == BOX_FACES.index((2, 1))


def test_removing_the_clipping_box_restores_the_whole_model(stage: Stage) -> None:
    stage.show("w", wall())
    at_rest(stage)
    before = stage.picture()
    stage.view.clip.set_box(ClipBox(tuple(UTM), tuple(UTM + [2.0, 1.0, 2.0])), handles=False)  # type: ignore[arg-type]
    at_rest(stage)
    cut = stage.picture()
    assert (np.abs(cut - before).max(axis=2) > 20).mean() > 0.1
    stage.view.clip.set_box(None)
    at_rest(stage)
    assert np.array_equal(stage.picture(), before)
