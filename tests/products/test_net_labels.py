"""Where a label goes, against what the description says, with shapely's boxes and distances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely.geometry import MultiPoint, Point, box

from tests.tiers import first_in_default_tier
from vomstudio.products.net.labels import find_label_position
from vomstudio.products.net.legend import text_width

FONT = 10.0


class Sheet:
    """A figure of 300 x 200 points with a net of 80 a little off its middle."""

    width, height, cx, cy, radius, font = 300.0, 200.0, 140.0, 104.0, 80.0, FONT

    def __init__(self, texts: list[tuple[float, float, float, float]]) -> None:
        self.text_boxes = texts


def plainly(
    sheet: Sheet, mark: np.ndarray, text: str, crowd: np.ndarray, marks: list[np.ndarray]
) -> tuple[float, float] | None:
    """Twelve places about the mark, the words' near end toward it, at 1.1 letters, 1.7, 2.6 and 4
    times as far. To cover a mark is as bad as 30 poles, to lie across the rim or on its ticks
    as 15, to lie outside as 3, and one step further away as 1.5."""
    wide, high = text_width(text, FONT), 1.24 * FONT
    own = Point(mark)
    poles = MultiPoint(crowd)
    net = Point(sheet.cx, sheet.cy).buffer(sheet.radius, quad_segs=4096)
    result = []
    for step in (1.0, 1.7, 2.6, 4.0):
        for turn in np.radians(np.arange(0, 360, 30)):
            way = np.array([math.cos(turn), math.sin(turn)])
            middle = mark + step * 1.1 * FONT * way + [0.5 * wide * way[0], 0.0]
            half = np.array([0.5 * wide + 2.0, 0.5 * high])
            words = box(*(middle - half), *(middle + half))
            inside = box(2.0, 2.0, sheet.width - 2.0, sheet.height - 2.0)
            if not words.within(inside):
                continue
            if any(words.intersects(box(*other)) for other in sheet.text_boxes):
                continue
            if min(words.distance(Point(m)) for m in marks) < words.distance(own):
                continue
            outside = 3.0 if words.distance(net) >= 0.5 * high else 15.0
            bad = 1.5 * step + (0.0 if words.within(net) else outside)
            bad += sum(words.contains(pole) for pole in poles.geoms)
            grown = box(*(middle - half - 0.6 * FONT), *(middle + half + 0.6 * FONT))
            bad += 30.0 * sum(grown.contains(Point(m)) for m in marks)
            result.append((round(bad, 9), len(result), middle - [0.5 * wide, 0.0]))
    if not result:
        return None
    x, y = min(result)[2]
    return float(x), float(y)


@pytest.mark.parametrize("seed", first_in_default_tier(range(40), 6))
def test_label_takes_the_best_candidate_position(seed: int) -> None:
    rng = np.random.default_rng(seed)
    texts = []
    for _ in range(rng.integers(0, 9)):
        low = rng.uniform([0, 0], [280, 190])
        texts.append((*low, *(low + rng.uniform([15, 8], [70, 14]))))
    sheet = Sheet(texts)
    scatter = rng.choice([12.0, 60.0])
    marks = list(rng.uniform([5, 5], [295, 195], (rng.integers(1, 6), 2)))
    if seed % 2:
        marks = list(marks[0] + scatter * 0.4 * rng.normal(size=(4, 2)))
    for mark in marks:
        crowd = mark + scatter * rng.normal(size=(rng.integers(1, 60), 2))
        text = str(rng.choice(["β", "mean 132/41", "042.0/41.0 RHR"]))
        result = find_label_position(sheet, mark, text, crowd, marks)
        expected = plainly(sheet, mark, text, crowd, marks)
        if expected is None:
            assert result is None
        else:
            assert result == pytest.approx(expected)


@pytest.mark.parametrize("side", ["left", "right", "below", "above"])
@pytest.mark.parametrize(("spare", "fits"), [(0.2, True), (-0.2, False)])
def test_a_label_keeps_two_points_from_the_edge_of_the_figure(
    side: str, spare: float, fits: bool
) -> None:
    """All but a slot along the edge is taken, and the mark is where one place leads into it."""
    wide, high = text_width("beta", FONT) + 4.0, 1.24 * FONT
    far = 1e3
    across, up = wide + 2.5, high + 2.5
    taken, at = {
        "left": ((across, -far, far, far), (4.0 + spare - 11.0, 100.0)),
        "right": ((-far, -far, 300.0 - across, far), (300.0 - 4.0 - spare + 11.0, 100.0)),
        "below": ((-far, up, far, far), (150.0, 2.0 + high / 2 + spare - 11.0)),
        "above": ((-far, -far, far, 200.0 - up), (150.0, 200.0 - 2.0 - high / 2 - spare + 11.0)),
    }[side]
    mark = np.array(at)
    result = find_label_position(Sheet([taken]), mark, "beta", np.zeros((0, 2)), [mark])
    assert (result is not None) == fits
