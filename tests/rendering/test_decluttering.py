"""Labels never lie on one another."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.rendering.view.decluttering import (
    CELL_PIXELS,
    LabelGrid,
    order_by_importance,
    place_labels,
)


def placed_boxes(n: int) -> tuple[dict[int, tuple[float, float]], np.ndarray]:
    rng = np.random.default_rng(0)
    anchors = rng.uniform(0, 1, (n, 2)) * [1400.0, 900.0]
    sizes = np.stack([rng.uniform(60, 130, n), np.full(n, 19.0)], axis=1)
    grid = LabelGrid(1400.0, 900.0)
    grid.block(1200.0, 840.0, 200.0, 60.0)
    return place_labels(grid, anchors, sizes, np.arange(n)), sizes


def test_labels_neither_overlap_nor_leave_the_view() -> None:
    placed, sizes = placed_boxes(1000)
    ids = np.array(list(placed))
    low = np.array([placed[i] for i in ids])
    high = low + sizes[ids]
    assert len(ids) > 100
    assert (low >= 0).all()
    assert (high <= [1400.0, 900.0]).all()
    apart = (low[:, None] >= high[None]) | (low[None] >= high[:, None])
    overlapping = ~apart.any(axis=2)
    np.fill_diagonal(overlapping, False)
    assert not overlapping.any()
    kept_free = ~((low >= [1400.0, 900.0]) | (high <= [1200.0, 840.0])).any(axis=1)
    assert not kept_free.any()


def test_first_label_in_order_is_placed() -> None:
    anchors = np.array([[100.0, 100.0], [101.0, 100.0]])
    sizes = np.full((2, 2), 400.0)
    placed = place_labels(LabelGrid(520.0, 520.0), anchors, sizes, np.array([1, 0]))
    assert list(placed) == [1]


def test_points_that_cannot_be_projected_get_no_label() -> None:
    anchors = np.array([[np.nan, np.nan], [50.0, 90.0]])
    placed = place_labels(LabelGrid(300.0, 200.0), anchors, np.full((2, 2), 20.0), np.arange(2))
    assert list(placed) == [1]


def test_labels_keep_their_corner_while_it_is_free() -> None:
    anchors, sizes = np.array([[200.0, 200.0]]), np.array([[50.0, 20.0]])
    corners = np.array([3])
    there = place_labels(
        LabelGrid(400, 400), anchors, sizes, np.array([0]), position_indices=corners
    )
    assert there[0][0] < 200.0
    assert there[0][1] > 200.0
    assert corners.tolist() == [3]
    taken = LabelGrid(400, 400)
    taken.block(100.0, 200.0, 100.0, 100.0)
    there = place_labels(taken, anchors, sizes, np.array([0]), position_indices=corners)
    assert there[0][0] > 200.0
    assert corners.tolist() == [0]


def test_selected_features_are_labelled_first_then_larger_ones() -> None:
    extents = np.array([1.0, 5.0, 3.0, 2.0])
    none = np.zeros(4, bool)
    chosen = np.array([True, False, False, False])
    assert order_by_importance(chosen, none, extents, is_moving=False).tolist() == [0, 1, 2, 3]
    # What is shown already is not put aside for something hardly larger, nor at all in a drag.
    shown = np.array([False, False, False, True])
    assert order_by_importance(none, shown, extents, is_moving=False).tolist() == [1, 2, 3, 0]
    shown = np.array([False, False, True, True])
    assert order_by_importance(none, shown, extents, is_moving=True).tolist() == [2, 3, 1, 0]
    assert order_by_importance(none, ~chosen, np.zeros(4), is_moving=True).tolist() == [1, 2, 3, 0]


def test_bit_grid_is_equivalent_to_a_cell_grid() -> None:
    rng = np.random.default_rng(3)
    grid = LabelGrid(300.0, 200.0)
    taken = np.zeros((200 // CELL_PIXELS + 2, 300 // CELL_PIXELS + 2), bool)
    for x, y, w, h in rng.uniform([-10, -10, 3, 3], [310, 210, 60, 30], (400, 4)).tolist():
        cells = taken[
            int(y) // CELL_PIXELS : int(y + h) // CELL_PIXELS + 1,
            int(x) // CELL_PIXELS : int(x + w) // CELL_PIXELS + 1,
        ]
        inside = x >= 0 and y >= 0 and x + w <= 300.0 and y + h <= 200.0
        free = inside and not cells.any()
        assert grid.take(x, y, w, h) == free
        if free:
            cells[...] = True


@pytest.mark.parametrize("moving", [False, True])
def test_bulk_placement_equals_sequential_placement(moving):
    rng = np.random.default_rng(11)
    n, gap, image = 2000, 7.0, (640.0, 401.0)
    anchors = rng.uniform((-40.0, -40.0), (700.0, 460.0), (n, 2))
    anchors[::97] = np.nan
    sizes = rng.uniform((30.0, 14.0), (130.0, 18.0), (n, 2))
    order = rng.permutation(n).astype(np.int64)
    corners = rng.integers(0, 6, n)
    clear = rng.choice([0.0, 10.0], n) if moving else None
    grid, other = LabelGrid(*image), LabelGrid(*image)
    for each in (grid, other):
        each.block(500.0, 300.0, 200.0, 200.0)
    wanted: dict[int, tuple[float, float]] = {}
    for i in order.tolist():
        (x, y), (w, h) = anchors[i].tolist(), sizes[i].tolist()
        if np.isnan(x):
            continue
        right, left, middle = min(x + gap, image[0] - w), max(x - gap - w, 0.0), x - w / 2.0
        rows = (y - gap - h, y + gap)
        places = [(a, b) for a in (right, left, middle) for b in rows]
        first = int(corners[i])
        free = 0.0 if clear is None else clear[i]
        a, b = places[first]
        if free and not other.is_free(a - free, b - free, w + 2 * free, h + 2 * free):
            continue
        for k in (first, *(k for k in range(6) if k != first)):
            if other.take(*places[k], w, h):
                wanted[i] = places[k]
                break
    assert len(wanted) > 30
    assert place_labels(grid, anchors, sizes, order, gap, corners, clear) == wanted
