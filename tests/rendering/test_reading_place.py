"""The live reading covers neither what is being picked nor the cursor."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, box

from vomstudio.rendering.view.readout_position import PickedPoints, ReadingPosition, _lengths_inside

VIEW = (900.0, 600.0)
SIZE = (210.0, 80.0)


def rectangle(place: tuple[float, float, float, float]):
    x, y, wide, high = place
    return box(x, y, x + wide, y + high)


pixel = st.tuples(st.floats(0, 900), st.floats(0, 600))


@pytest.mark.full
@given(st.lists(pixel, min_size=2, max_size=12), pixel, st.booleans())
@settings(max_examples=200, deadline=None)
def test_reading_covers_nothing_if_free_space_exists(line, cursor, rubber):
    """Judged by Shapely: if the box covers anything, then so would boxes all over the view."""
    drawn = LineString([*line, cursor]) if rubber else LineString(line)
    picked = PickedPoints(np.array(line), cursor, np.array(cursor) if rubber else None)
    _, place = ReadingPosition().choose([SIZE], VIEW, picked)
    shown = rectangle(place)
    x, y, wide, high = place
    assert min(x, y) >= 0
    assert x + wide <= VIEW[0]
    assert y + high <= VIEW[1]
    if not shown.buffer(7.5).intersects(drawn):
        inside = x < cursor[0] < x + wide and y < cursor[1] < y + high
        assert not inside
        return
    at = box(cursor[0] - 10, cursor[1] - 10, cursor[0] + 10, cursor[1] + 10)
    for a in np.linspace(4.0, VIEW[0] - 4.0 - SIZE[0], 16):
        for b in np.linspace(4.0, VIEW[1] - 4.0 - SIZE[1], 16):
            other = box(a, b, a + SIZE[0], b + SIZE[1])
            assert other.buffer(8.5).intersects(drawn) or other.intersects(at)


def test_reading_is_placed_between_lines_along_all_edges() -> None:
    rows = [(0.0, 40.0), (900.0, 40.0), (900.0, 300.0), (0.0, 300.0), (0.0, 560.0), (900.0, 560.0)]
    _, place = ReadingPosition().choose([SIZE], VIEW, PickedPoints(np.array(rows), (4.0, 596.0)))
    assert not rectangle(place).buffer(7.5).intersects(LineString(rows))


@given(st.tuples(pixel, pixel), pixel, st.floats(1, 400), st.floats(1, 300))
@settings(max_examples=200, deadline=None)
def test_covered_length_matches_shapely(ends, corner, wide, high):
    found = _lengths_inside((*corner, wide, high), np.array(ends, float).reshape(1, 4))
    request_photos = LineString(ends).intersection(rectangle((*corner, wide, high))).length
    assert found[0] == pytest.approx(request_photos, abs=1e-6)


@pytest.mark.parametrize("x", [400.0, 560.0, 640.0])
def test_a_widget_over_the_view_is_avoided(x: float) -> None:
    widget = (610.0, 10.0, 280.0, 280.0)
    cursor = (x, 120.0)
    line = np.array([(x - 200.0, 120.0), (x - 100.0, 130.0)])
    _, place = ReadingPosition().choose([SIZE], VIEW, PickedPoints(line, cursor, widget=widget))
    assert not rectangle(place).intersects(rectangle(widget))


def test_reading_is_near_the_cursor_but_not_ahead_of_the_line():
    """Picking to the right and downwards: the place to the right below is where one looks next."""
    line = np.array([[100.0, 100.0], [300.0, 200.0]])
    place = ReadingPosition()
    _, found = place.choose(
        [SIZE], VIEW, PickedPoints(line, (400.0, 250.0), np.array([400.0, 250.0]))
    )
    ahead = LineString([(400.0, 250.0), (500.0, 300.0)])
    assert not rectangle(found).intersects(ahead)
    assert rectangle(found).distance(LineString([(400, 250), (400, 250.1)])) < 40.0


def test_reading_keeps_its_side_while_it_is_free():
    place, sides = ReadingPosition(), set()
    line = np.array([[150.0, 300.0], [300.0, 300.0]])
    for y in np.linspace(280.0, 320.0, 60):
        picked = PickedPoints(line, (450.0, y), np.array([450.0, y]))
        place.choose([SIZE], VIEW, picked)
        sides.add(place.side)
    assert len(sides) == 1


def test_reading_returns_from_the_edge_only_with_ample_space():
    """A comb of lines round the cursor drives it to the edge; as the comb opens it stays there
    longer than it took to drive it off."""

    def comb(gap: float) -> PickedPoints:
        rows = [[(200.0, y), (700.0, y)] for y in (300 - 90 - gap, 300 + 110 + gap)]
        zigzag = [p for row in rows for p in row]
        return PickedPoints(np.array(zigzag), (450.0, 300.0))

    place = ReadingPosition()
    place.choose([SIZE], VIEW, comb(60.0))
    assert place.side < 6
    closing = [g for g in np.arange(60.0, -60.0, -2.0) if step(place, comb(g)) >= 6]
    assert closing
    opening = [g for g in np.arange(-60.0, 120.0, 2.0) if step(place, comb(g)) < 6]
    assert opening
    assert opening[0] > closing[0] + 10.0
    assert opening == [g for g in np.arange(-60.0, 120.0, 2.0) if g >= opening[0]]


def step(place: ReadingPosition, picked: PickedPoints) -> int:
    place.choose([SIZE], VIEW, picked)
    return place.side


def test_only_the_first_line_is_shown_if_the_rest_does_not_fit():
    rows = np.arange(0.0, 600.0, 70.0)
    line = np.array([(x, y) for i, y in enumerate(rows) for x in ((0, 900), (900, 0))[i % 2]])
    line = np.array([(x, y) for x, y in line])
    picked = PickedPoints(line, (450.0, 315.0))
    number, found = ReadingPosition().choose([SIZE, (120.0, 26.0)], VIEW, picked)
    assert number == 1
    assert not rectangle(found).buffer(7.0).intersects(LineString(line))


def test_points_behind_the_viewer_are_ignored():
    line = np.array([[100.0, 100.0], [np.nan, np.nan], [700.0, 500.0]])
    number, found = ReadingPosition().choose([SIZE], VIEW, PickedPoints(line, (400.0, 300.0)))
    assert number == 0
    assert np.isfinite(found).all()


def test_reading_does_not_cover_the_brush_ring():
    picked = PickedPoints(np.zeros((0, 2)), (450.0, 300.0), None, np.zeros((0, 2)), 90.0)
    _, found = ReadingPosition().choose([SIZE], VIEW, picked)
    x, y, wide, high = found
    assert x >= 540.0 or x + wide <= 360.0 or y >= 390.0 or y + high <= 210.0
