"""Placement of labels next to their marks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from vomstudio.core.arrays import FloatArray
from vomstudio.products.net.legend import text_width

Box = tuple[float, float, float, float]
"""Left, lower, right and upper edge in points from the lower-left corner of the figure."""


class Sheet(Protocol):
    """Geometry of a figure in points: size, net, font size, and boxes of the existing text."""

    width: float
    height: float
    cx: float
    cy: float
    radius: float
    font: float
    text_boxes: list[Box]


def find_label_position(
    sheet: Sheet, mark: FloatArray, text: str, obstacles: FloatArray, marks: Sequence[FloatArray]
) -> tuple[float, float] | None:
    """Find a position for a label near its mark.

    The label overlaps no other text, lies inside the figure, and is nearest to its own mark.
    Positions that hide few marks and poles are preferred.

    Returns
    -------
    (float, float) or None
        Left end and middle height of the label; None if it does not fit.
    """
    width, half_height = text_width(text, sheet.font), 0.62 * sheet.font
    best_position, cost = None, math.inf
    for distance_factor in (1.0, 1.7, 2.6, 4.0):
        distance = distance_factor * 1.1 * sheet.font
        for i in range(12):
            angle = math.radians(30.0 * i)
            dx, dy = math.cos(angle), math.sin(angle)
            x = float(mark[0]) + distance * dx - width * (0.5 - 0.5 * dx)
            y = float(mark[1]) + distance * dy
            box = (x - 2, y - half_height, x + width + 2, y + half_height)
            if box[0] < 2 or box[2] > sheet.width - 2:
                continue
            if box[1] < 2 or box[3] > sheet.height - 2:
                continue
            if any(_are_overlapping(box, other_box) for other_box in sheet.text_boxes):
                continue
            gaps = [_gap(box, mark) for mark in marks]
            if min(gaps) < _gap(box, mark):  # it would be read as another mark's
                continue
            hit_count = sum(_is_near_box(box, mark, 0.6 * sheet.font) for mark in marks)
            covered_count = (
                ((obstacles > [box[0], box[1]]) & (obstacles < [box[2], box[3]])).all(axis=1).sum()
            )
            corner = max(
                math.hypot(cx - sheet.cx, cy - sheet.cy) for cx in box[::2] for cy in box[1::2]
            )
            is_on_rim = corner > sheet.radius > _gap(box, (sheet.cx, sheet.cy)) - half_height
            # Prefer a place inside, but one outside to one that the rim and its ticks cross.
            rim_cost = 15.0 if is_on_rim else 3.0 if corner > sheet.radius else 0.0
            position_cost = (
                30.0 * hit_count + float(covered_count) + rim_cost + 1.5 * distance_factor
            )
            if position_cost < cost:
                best_position, cost = (x, y), position_cost
    return best_position


def _are_overlapping(first_box: Box, second_box: Box) -> bool:
    return (
        first_box[0] < second_box[2]
        and second_box[0] < first_box[2]
        and first_box[1] < second_box[3]
        and second_box[1] < first_box[3]
    )


def _gap(box: Box, mark: Sequence[float] | FloatArray) -> float:
    """Return the distance between a mark and a box."""
    dx = max(box[0] - float(mark[0]), 0.0, float(mark[0]) - box[2])
    dy = max(box[1] - float(mark[1]), 0.0, float(mark[1]) - box[3])
    return math.hypot(dx, dy)


def _is_near_box(box: Box, mark: FloatArray, margin: float) -> bool:
    x, y = float(mark[0]), float(mark[1])
    return box[0] - margin < x < box[2] + margin and box[1] - margin < y < box[3] + margin
