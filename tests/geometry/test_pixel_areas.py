"""Drawn shapes as pixels."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path as Outline

from vomstudio.geometry.pixel_areas import (
    PixelArea,
    draw_area,
    polygon_area,
    stroke_area,
    whole_area,
)

WIDE, HIGH = 31, 23
COLUMNS, ROWS = np.meshgrid(np.arange(WIDE) + 0.5, np.arange(HIGH) + 0.5)
CENTRES = np.column_stack([COLUMNS.ravel(), ROWS.ravel()])


def spread(area: PixelArea) -> np.ndarray:
    """As a picture of its own."""
    made = np.zeros((HIGH, WIDE), bool)
    made[area.window] = area.is_inside
    return made


def coordinates(size: int) -> st.SearchStrategy[float]:
    # Shapely 2.1 divides by zero on segments of 1e-183 pixels.
    return st.floats(-8, size + 8).map(lambda value: round(value, 6))


places = st.tuples(coordinates(WIDE), coordinates(HIGH))


@settings(max_examples=40, deadline=None)
@given(st.tuples(places, places, places))
def test_triangle_contains_centres_on_the_same_side_of_all_edges(corners) -> None:
    a, b, c = np.array(corners)
    sides = []
    for p, q in ((a, b), (b, c), (c, a)):
        way, off = q - p, CENTRES - p
        sides.append(way[0] * off[:, 1] - way[1] * off[:, 0])
    signs = np.array(sides)
    clear = np.abs(signs).min(axis=0) > 1e-6
    inside = (signs > 0).all(axis=0) | (signs < 0).all(axis=0)
    drawn = spread(polygon_area(corners, WIDE, HIGH)).ravel()
    assert (drawn == inside)[clear].all()


def test_concave_polygon_matches_matplotlib() -> None:
    corners = np.array([[2.2, 1.1], [28.3, 3.7], [16.1, 9.9], [27.7, 20.2], [4.4, 18.6]])
    outline = Outline(np.vstack([corners, corners[:1]]))
    expected = outline.contains_points(CENTRES).reshape(HIGH, WIDE)
    assert (spread(polygon_area(corners, WIDE, HIGH)) == expected).all()


def test_area_enclosed_twice_by_polygon_is_excluded() -> None:
    """A five-pointed star, drawn in one go."""
    turns = np.radians(90 + 144 * np.arange(5))
    corners = np.column_stack([15.5 + 10 * np.cos(turns), 11.5 - 10 * np.sin(turns)])
    drawn = spread(polygon_area(corners, WIDE, HIGH))
    assert not drawn[11, 15]
    assert drawn[3, 15]


@pytest.mark.parametrize("corners", [[], [[3, 3]], [[3, 3], [9, 9]]])
def test_polygon_with_fewer_than_three_corners_is_empty(corners) -> None:
    assert not spread(polygon_area(corners, WIDE, HIGH)).any()


@settings(max_examples=40, deadline=None)
@given(st.lists(places, min_size=1, max_size=5), st.floats(0.6, 9))
def test_stroke_contains_centres_within_its_radius(course, radius) -> None:
    line = shapely.LineString(course) if len(set(course)) > 1 else shapely.Point(course[0])
    off = shapely.distance(line, shapely.points(CENTRES))
    clear = np.abs(off - radius) > 1e-6
    drawn = spread(stroke_area(course, radius, WIDE, HIGH)).ravel()
    assert (drawn == (off <= radius))[clear].all()


def test_whole_area_contains_every_pixel() -> None:
    assert spread(whole_area(WIDE, HIGH)).all()


def test_drawing_an_area_hides_its_pixels_and_undo_restores_them() -> None:
    rng = np.random.default_rng(3)
    before = rng.random((HIGH, WIDE)) < 0.6
    for hides in (True, False):
        for area in (
            stroke_area([[4.0, 5.0], [20.0, 9.0]], 3.3, WIDE, HIGH),
            polygon_area([[-9.0, -3.0], [12.0, 4.0], [5.0, 40.0]], WIDE, HIGH),
            whole_area(WIDE, HIGH),
        ):
            used = before.copy()
            change = draw_area(used, area, hides)
            assert change is not None
            after = before & ~spread(area) if hides else before | spread(area)
            assert np.array_equal(used, after)
            change.toggle(used)
            assert np.array_equal(used, before)
            change.toggle(used)
            assert np.array_equal(used, after)
            # What is so already is no change.
            assert draw_area(used, area, hides) is None
            assert np.array_equal(used, after)


@pytest.mark.parametrize("place", [(-50.0, 5.0), (5.0, -50.0), (90.0, 5.0), (5.0, 90.0)])
def test_shape_outside_the_image_has_no_pixels_and_changes_nothing(
    place: tuple[float, float],
) -> None:
    triangle = np.array([[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]]) + place
    for area in (
        polygon_area(triangle, WIDE, HIGH),
        stroke_area(triangle, 2.0, WIDE, HIGH),
        stroke_area(np.zeros((0, 2)), 2.0, WIDE, HIGH),
    ):
        assert area.is_inside.size == 0
        assert not spread(area).any()
        assert draw_area(np.ones((HIGH, WIDE), bool), area, True) is None


def test_bounding_box_of_area_fits_its_pixels() -> None:
    """A stroke across a picture of a hundred million pixels must not look at all of them."""
    area = stroke_area([[10.2, 7.9]], 2.5, WIDE, HIGH)
    assert (area.left, area.top, *area.is_inside.shape) == (7, 5, 6, 6)
    area = polygon_area([[3.2, 2.1], [9.9, 2.1], [3.2, 7.4]], WIDE, HIGH)
    assert (area.left, area.top, *area.is_inside.shape) == (3, 2, 6, 7)
    area = stroke_area([[0.0, HIGH], [WIDE, HIGH]], 1.5, WIDE, HIGH)
    assert (area.left, area.top, *area.is_inside.shape) == (0, HIGH - 2, 2, WIDE)


def test_pixel_centre_on_shared_edge_belongs_to_exactly_one_polygon() -> None:
    """Two polygons with slanted and upright edges in common leave no gap and no overlap."""
    shared = np.array([[10.5, 0.5], [10.5, 8.5], [16.5, 8.5], [20.5, 20.5]])
    left = np.vstack([shared, [[1.5, 20.5], [1.5, 0.5]]])
    right = np.vstack([shared, [[29.5, 20.5], [29.5, 0.5]]])
    whole = np.array([[1.5, 0.5], [29.5, 0.5], [29.5, 20.5], [1.5, 20.5]])
    a, b, both = (spread(polygon_area(p, WIDE, HIGH)).astype(int) for p in (left, right, whole))
    assert np.array_equal(a + b, both)
    assert both.sum() == 28 * 20


@pytest.mark.parametrize("end", [(10.5, 10.5), (10.5, 0.5)])
def test_stroke_contains_centres_exactly_at_its_radius(end: tuple[float, float]) -> None:
    """Three columns and four rows from its end make five."""
    for radius, held in ((5.0, True), (np.nextafter(5.0, 0.0), False)):
        drawn = spread(stroke_area([[10.5, 10.5], end], radius, WIDE, HIGH))
        assert drawn[14, 13] == drawn[14, 7] == drawn[10, 15] == held
        assert drawn[13, 13]
        assert not drawn[14, 14]
