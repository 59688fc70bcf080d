"""The order in which a cloud is drawn: every beginning of it is a picture of the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vomstudio.geometry.progressive_order import (
    MAX_LEVEL,
    POINTS_PER_NODE,
    ProgressiveOrder,
    _depth,
    arrange,
)

UTM = np.array([576_704.0, 5_188_102.0, 184.0])


def face(n: int, seed: int = 0) -> np.ndarray:
    """A rough wall of 100 x 60 m, three times as dense on its left half."""
    rng = np.random.default_rng(seed)
    x, z = rng.random(n) * 100.0, rng.random(n) * 60.0
    x = np.where(rng.random(n) < 0.5, x / 2.0, x)
    return np.column_stack([x, 2.0 * np.sin(x / 3.0) + 0.1 * rng.random(n), z]) + UTM


def nodes(found: ProgressiveOrder) -> list[np.ndarray]:
    return [found.rows[a:b] for a, b in zip(found.starts[:-1], found.starts[1:], strict=True)]


@pytest.fixture(scope="module")
def points() -> np.ndarray:
    return face(700_000)


@pytest.fixture(scope="module")
def found(points: np.ndarray) -> ProgressiveOrder:
    return arrange(points)


def test_every_point_is_in_one_node(found: ProgressiveOrder, points: np.ndarray) -> None:
    assert np.array_equal(np.sort(found.rows), np.arange(len(points)))
    assert found.is_valid(len(points))
    assert np.diff(found.starts).max() <= POINTS_PER_NODE
    # The coarsest is one, so that a picture of the whole is there at once.
    assert np.flatnonzero(found.parents < 0).tolist() == [0]


def test_node_bounds_contain_their_points_and_parents_are_coarser(
    found: ProgressiveOrder, points: np.ndarray
) -> None:
    for node, rows in enumerate(nodes(found)):
        own = points[rows]
        assert np.array_equal(found.bounds[node], [own.min(axis=0), own.max(axis=0)])
        parent = int(found.parents[node])
        assert parent < node
        if parent >= 0:
            assert found.spacing[node] < found.spacing[parent]
            low, high = found.bounds[parent]
            reach = 3.0 * found.spacing[parent]
            assert ((own >= low - reach) & (own <= high + reach)).mean() > 0.99


@pytest.mark.full
def test_every_prefix_covers_the_whole_evenly(found: ProgressiveOrder, points: np.ndarray) -> None:
    own = nodes(found)
    for spacing in np.unique(found.spacing)[1:]:
        some = np.concatenate([own[k] for k in np.flatnonzero(found.spacing >= spacing)])
        tree = cKDTree(points[some])
        away, _ = tree.query(points[::50])
        assert away.max() < 3.0 * spacing
        # Not much denser where the cloud is: the far from even density does not show.
        nearest, _ = tree.query(points[some[::20]], k=2)
        assert 0.3 * spacing < np.median(nearest[:, 1]) < 1.2 * spacing


def some_points(kind: str) -> np.ndarray:
    rng = np.random.default_rng(3)
    if kind == "line":
        return rng.random((2000, 1)) * [30.0, 2.0, 9.0] + UTM
    if kind == "heaps":
        # Far closer within a heap than the smallest cubes.
        return np.repeat(face(300), 7, axis=0) + 1e-5 * rng.random((2100, 3))
    return face(3000)


@pytest.mark.parametrize("kind", ["wall", "line", "heaps"])
@pytest.mark.parametrize("most", [1, 40, 333])
def test_every_level_has_one_point_per_cube(
    kind: str, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vomstudio.geometry.progressive_order.POINTS_PER_NODE", most)
    points = some_points(kind)
    found, low = arrange(points), points.min(axis=0)
    side = float(np.ptp(points, axis=0).max()) * (1.0 + 1e-9)
    smallest = ((points - low) * (2**MAX_LEVEL / side)).astype(int)
    filled = [len(np.unique(smallest >> down, axis=0)) for down in range(MAX_LEVEL, -1, -1)]
    first = max(1, max(level for level, count in enumerate(filled) if count <= most))
    own, spacings = nodes(found), np.unique(found.spacing)[::-1]
    beginnings = []
    for spacing in spacings:
        rows = np.concatenate([own[k] for k in np.flatnonzero(found.spacing >= spacing)])
        beginnings.append(len(rows))
        if len(rows) in filled:
            cubes = smallest[rows] >> (MAX_LEVEL - filled.index(len(rows)))
            assert len(np.unique(cubes, axis=0)) == len(rows)
        # Of a surface, a quarter of the points are twice as far apart.
        coarser = max((k for k, count in enumerate(filled) if 2 * count <= len(rows)), default=0)
        share = filled[coarser] / len(rows)
        assert spacing == pytest.approx(side / 2.0**coarser * np.sqrt(share))
    assert beginnings == sorted({*filled[first:], len(points)})


@pytest.mark.parametrize("most", [40, 333])
def test_points_below_a_node_are_split_into_fewest_even_nodes(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vomstudio.geometry.progressive_order.POINTS_PER_NODE", most)
    found = arrange(some_points("wall"))
    counts = np.diff(found.starts)
    for parent in np.unique(found.parents):
        below = counts[found.parents == parent]
        assert len(below) == -(-below.sum() // most)
        assert np.ptp(below) <= 1


def test_finest_spacing_matches_the_cloud() -> None:
    side = 900
    x, z = np.meshgrid(np.arange(side), np.arange(side))
    points = np.column_stack([x.ravel(), np.zeros(side**2), z.ravel()]) * 0.02 + UTM
    assert arrange(points).spacing.min() == pytest.approx(0.02, rel=0.3)


@pytest.mark.full
def test_points_of_one_level_are_not_drawn_up_in_a_lattice() -> None:
    side = 2000
    x, z = np.meshgrid(np.arange(side), np.arange(side))
    points = np.column_stack([x.ravel(), np.zeros(side**2), z.ravel()]) * 0.02
    found = arrange(points)
    coarse = points[
        np.concatenate([rows for k, rows in enumerate(nodes(found)) if found.parents[k] < 0])
    ]
    columns = np.bincount(np.rint(coarse[:, 0] / 0.02).astype(int), minlength=side)
    assert (columns > 0).mean() > 0.9


def test_small_degenerate_and_invalid_clouds_have_an_order() -> None:
    for n in (0, 1, 2, 3, 1000):
        some = arrange(face(n))
        assert np.array_equal(np.sort(some.rows), np.arange(n))
        assert len(some) == (n > 0)
        assert some.is_valid(n)
    alike = arrange(np.repeat(UTM[None], 120_000, axis=0))
    assert len(alike.rows) == 120_000
    assert alike.is_valid(120_000)
    holed = face(1000)
    holed[17, 1], holed[400] = np.nan, np.inf
    some = arrange(holed)
    assert np.array_equal(np.sort(some.rows), np.delete(np.arange(1000), [17, 400]))
    assert np.isfinite(some.bounds).all()


def test_ordering_can_be_cancelled() -> None:
    class Enough(Exception):
        pass

    def check() -> None:
        raise Enough

    with pytest.raises(Enough):
        arrange(face(1000), check)


def test_order_of_other_points_is_invalid(found: ProgressiveOrder) -> None:
    n = len(found.rows)
    assert not found.is_valid(n - 1)
    assert not replace(found, starts=found.starts[:-1]).is_valid(n)
    assert not replace(found, parents=found.parents[::-1]).is_valid(n)
    assert not replace(found, rows=found.rows - 1).is_valid(n)
    assert not replace(found, bounds=found.bounds * np.nan).is_valid(n)


def test_depth_leaves_enough_bits_for_row_numbers() -> None:
    for row_bits in range(1, 41):
        depth = _depth(row_bits)
        assert 3 * depth + row_bits <= 64
        assert depth == MAX_LEVEL or 3 * (depth + 1) + row_bits > 64


def test_order_with_any_single_error_is_invalid(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vomstudio.geometry.progressive_order.POINTS_PER_NODE", 40)
    found = arrange(face(500))
    k, n = len(found), 500
    assert found.is_valid(n)
    assert found.is_valid(n + 1)
    nothing = arrange(np.zeros((0, 3)))
    assert nothing.is_valid(0)
    one_wrong = [
        ("starts", 0, 1),
        ("starts", 3, found.starts[2]),
        ("starts", k, n - 1),
        ("rows", 7, -1),
        ("rows", 7, n),
        ("bounds", (2, 1, 0), np.nan),
        ("bounds", (0, 0, 2), -np.inf),
        ("spacing", 4, 0.0),
        ("spacing", k - 1, -1.0),
        ("spacing", 1, np.nan),
        ("parents", 0, 0),
        ("parents", k - 1, k - 1),
        ("parents", 2, 3),
    ]
    for name, place, value in one_wrong:
        array = getattr(found, name).copy()
        array[place] = value
        assert not replace(found, **{name: array}).is_valid(n), (name, place, value)
    for name in ("starts", "bounds", "spacing", "parents", "rows"):
        assert not replace(found, **{name: getattr(found, name)[:-1]}).is_valid(n), name
    assert not replace(found, bounds=found.bounds[:, :, :2]).is_valid(n)
    assert not replace(found, bounds=found.bounds[:, :1]).is_valid(n)
