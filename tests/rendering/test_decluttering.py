"""Labels never lie on one another."""

from __future__ import annotations

import time

import numpy as np

from vomstudio.rendering.decluttering import LabelGrid, place_labels


def placed_boxes(n: int) -> tuple[dict[int, tuple[float, float]], np.ndarray, float]:
    rng = np.random.default_rng(0)
    anchors = rng.uniform(0, 1, (n, 2)) * [1400.0, 900.0]
    sizes = np.stack([rng.uniform(60, 130, n), np.full(n, 19.0)], axis=1)
    grid = LabelGrid(1400.0, 900.0)
    grid.block(1200.0, 840.0, 200.0, 60.0)
    started = time.perf_counter()
    placed = place_labels(grid, anchors, sizes, np.arange(n))
    return placed, sizes, time.perf_counter() - started


def test_no_two_labels_overlap_and_none_leaves_the_view() -> None:
    placed, sizes, _ = placed_boxes(1000)
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


def test_the_first_in_order_gets_its_place() -> None:
    anchors = np.array([[100.0, 100.0], [101.0, 100.0]])
    sizes = np.full((2, 2), 400.0)
    placed = place_labels(LabelGrid(520.0, 520.0), anchors, sizes, np.array([1, 0]))
    assert list(placed) == [1]


def test_points_that_cannot_be_projected_get_no_label() -> None:
    anchors = np.array([[np.nan, np.nan], [50.0, 90.0]])
    placed = place_labels(LabelGrid(300.0, 200.0), anchors, np.full((2, 2), 20.0), np.arange(2))
    assert list(placed) == [1]
