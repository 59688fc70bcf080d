"""Outlines of poor planes, labels with marks, the hovered feature, and the legend of colours."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter

from vomstudio.rendering.qt import annotations as annotations_module
from vomstudio.rendering.qt.annotations import Annotations
from vomstudio.rendering.qt.legend_painting import ColorEntry, ColorLegend
from vomstudio.rendering.qt.painting import VERDICT_COLORS, LabelCache
from vomstudio.rendering.scene.feature_runs import FeatureRuns
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import FeatureDrawing, Symbol

RING = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
LINE = np.array([[0.0, 0, 0], [2, 0, 0]])
ROOM = QRectF(0.0, 0.0, 300.0, 120.0)


def drawing(**more) -> FeatureDrawing:
    return FeatureDrawing("f", LINE, RING, (0.0, 0.4, 0.7), "B01  318/39 ± 2.4°", LINE[0], **more)


@pytest.fixture
def image(qapp) -> QImage:
    made = QImage(300, 120, QImage.Format.Format_RGB32)
    made.fill(Qt.GlobalColor.gray)
    return made


def has_color(image: QImage, color: str) -> bool:
    wanted = QColor(color).rgb()
    pixels = ((x, y) for x in range(image.width()) for y in range(image.height()))
    return any(image.pixel(x, y) == wanted for x, y in pixels)


# --- poor planes --------------------------------------------------------------------------------
@pytest.mark.parametrize("outlined", [False, True])
def test_outlined_disc_is_drawn_as_a_closed_line(outlined: bool) -> None:
    runs = FeatureRuns()
    runs.change({"f": drawing(is_outlined=outlined)})
    assert runs.discs().sizes.tolist() == ([] if outlined else [4])
    assert runs.lines().sizes.tolist() == ([2, 5] if outlined else [2])
    if outlined:
        np.testing.assert_array_equal(runs.lines().points[2], runs.lines().points[-1])


# --- labels -------------------------------------------------------------------------------------
def test_label_with_a_verdict_shows_its_mark(qapp) -> None:
    labels = LabelCache()
    plain, marked = labels.size("B01"), labels.size("B01", "poor")
    assert marked[0] > plain[0]
    assert marked[1] == plain[1]
    picture = labels.picture("B01", (0.0, 0.0, 1.0), False, 1.0, "poor").toImage()
    assert picture.width() == marked[0]
    assert has_color(picture, VERDICT_COLORS["poor"])
    assert not has_color(labels.picture("B01", (0.0, 0.0, 1.0), False, 1.0).toImage(), "#e0402a")


@pytest.mark.parametrize(
    ("mode", "labelled", "is_painted"),
    [
        ("auto", False, True),
        ("selected", False, True),
        ("none", False, False),
        ("all", True, False),
    ],
)
def test_the_hovered_feature_is_labelled_once(image, mode, labelled, is_painted) -> None:
    annotations = Annotations()
    annotations.label_mode = mode
    annotations.label_boxes = [("f", ROOM)] if labelled else []
    before = image.copy()
    painter = QPainter(image)
    annotations.paint_hovered(painter, drawing(verdict="good"), 10.0, 60.0, ROOM)
    painter.end()
    assert (image != before) == is_painted
    assert has_color(image, VERDICT_COLORS["good"]) == is_painted


def test_label_of_a_hovered_feature_stays_inside_the_view(image) -> None:
    corners = Annotations()
    painter = QPainter(image)
    for x, y in ((0.0, 0.0), (299.0, 119.0)):
        corners.paint_hovered(painter, drawing(verdict="poor"), x, y, ROOM)
    painter.end()
    left = image.copy(0, 0, 150, 60)
    right = image.copy(150, 60, 150, 60)
    assert has_color(right, VERDICT_COLORS["poor"])
    assert any(
        left.pixel(x, y) != QColor(Qt.GlobalColor.gray).rgb() for x in range(150) for y in range(60)
    )


def test_moving_view_moves_existing_labels_and_adds_none(image, monkeypatch) -> None:
    monkeypatch.setattr(annotations_module, "MAX_PLACED_IN_MOTION", 3)
    points = {name: (30.0 + 60.0 * i, 20.0 + 18.0 * i) for i, name in enumerate("abcd")}
    drawings = {
        name: FeatureDrawing(name, LINE[:0], None, (0.0, 0.4, 0.7), name, np.array([*at, 0.0]))
        for name, at in points.items()
    }
    hidden = {"d"}
    shift = np.zeros(2)

    def project(world):
        is_visible = np.ones(len(world), bool)
        for name in hidden:
            is_visible &= ~(world[:, :2] == points[name]).all(axis=1)
        return world[:, :2] + shift, is_visible

    annotations = Annotations()

    def labels(*, moving: bool) -> dict[str, float]:
        painter = QPainter(image)
        size = (float(image.width()), float(image.height()))
        annotations.paint(painter, drawings, frozenset(), Camera(), project, size, is_moving=moving)
        painter.end()
        return {id_: box.x() for id_, box in annotations.label_boxes}

    before = labels(moving=False)
    assert set(before) == {"a", "b", "c"}
    hidden.clear()
    shift += 5.0
    assert labels(moving=True) == {name: x + 5.0 for name, x in before.items()}
    assert set(labels(moving=False)) == set("abcd")


@pytest.mark.parametrize(
    ("selected", "mode", "labelled"),
    [(0, "auto", 0), (3, "auto", 3), (3, "none", 0), (0, "all", 40), (3, "selected", 3)],
)
def test_only_features_eligible_for_labels_are_projected(image, selected, mode, labelled) -> None:
    drawings = {
        str(i): FeatureDrawing(str(i), LINE, None, (0.0, 0.4, 0.7), str(i), LINE[0])
        for i in range(40)
    }
    projected: list[int] = []

    def project(world):
        projected.append(len(world))
        return world[:, :2], np.ones(len(world), bool)

    annotations = Annotations()
    annotations.label_mode = mode
    painter = QPainter(image)
    for moving in (False, True):
        annotations.paint(
            painter,
            drawings,
            frozenset(list(drawings)[:selected]),
            Camera(),
            project,
            (300.0, 120.0),
            is_moving=moving,
        )
    painter.end()
    assert projected == [5 * labelled] * 2


def test_labels_after_changes_equal_those_of_a_fresh_layout(image) -> None:
    symbol = Symbol("line", LINE[0], LINE[1], LINE[1], "30", 1.0)

    def at(name: str, x: float, **more) -> FeatureDrawing:
        place = np.array([x, 60.0, 0.0])
        return FeatureDrawing(name, LINE[:0], None, (0.0, 0.4, 0.7), f"B {name}", place, **more)

    def labels(annotations: Annotations, drawings, selected) -> dict[str, tuple[float, ...]]:
        painter = QPainter(image)
        annotations.paint(
            painter,
            drawings,
            selected,
            Camera(),
            lambda world: (world[:, :2], np.ones(len(world), bool)),
            (300.0, 120.0),
        )
        painter.end()
        return {id_: box.getRect() for id_, box in annotations.label_boxes}

    drawings = {name: at(name, 20.0 + 70.0 * i) for i, name in enumerate("abcd")}
    selected = frozenset("ab")
    annotations = Annotations()
    labels(annotations, drawings, selected)
    for changes in (
        {"a": at("a", 40.0)},
        {"b": None},
        {"a": at("a", 30.0), "c": at("c", 150.0, visible=False)},
        {"b": at("b", 100.0), "d": at("d", 240.0, symbol=symbol)},
        {"d": None, "a": at("a", 60.0)},
    ):
        for name, drawing in changes.items():
            drawings.pop(name, None)
            if drawing is not None:
                drawings[name] = drawing
        annotations.change(changes)
        for mode in ("all", "selected"):
            fresh = Annotations()
            fresh.label_mode = annotations.label_mode = mode
            assert labels(annotations, drawings, selected) == labels(fresh, drawings, selected)


# --- legend -------------------------------------------------------------------------------------
def test_legend_without_entries_is_not_drawn(image) -> None:
    before = image.copy()
    legend = ColorLegend("Type")
    assert legend.box().isEmpty()
    painter = QPainter(image)
    legend.paint(painter)
    painter.end()
    assert image == before


def test_a_legend_shows_its_colours_and_marks(image) -> None:
    entries = [ColorEntry("#123456", "A"), ColorEntry(VERDICT_COLORS["poor"], "poor", "poor")]
    legend = ColorLegend("Set", entries)
    painter = QPainter(image)
    legend.paint(painter)
    painter.end()
    assert has_color(image, "#123456")
    assert has_color(image, VERDICT_COLORS["poor"])
    assert QRectF(image.rect()).contains(legend.box())
