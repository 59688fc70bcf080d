"""Discontinuities of a set: what is one plane, spacing, persistence, area per volume, against
arrangements that are known by construction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.extraction.planes_by_construction import axes_of, normal_of
from vomstudio.geology.sets.discontinuities import (
    MAX_JOINED_SCATTER,
    Arrangement,
    Discontinuity,
    Pieces,
    arrange_planes,
    describe_faces,
    measure_scanline_spacing,
    split_by_position,
)

Array = np.ndarray


def square(attitude: tuple[float, float], centre: Array, side: float) -> Array:
    u, v = axes_of(*attitude)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2
    return centre + corners @ np.stack([u, v])


def flat_pieces(attitude: tuple[float, float], centres: Array, side: float) -> Pieces:
    """Squares without any scatter out of their planes."""
    u, v = axes_of(*attitude)
    spread = side**2 / 12 * (np.outer(u, u) + np.outer(v, v))
    n = len(centres)
    return Pieces(
        centres,
        np.repeat(spread[None], n, axis=0),
        np.full(n, side**2),
        tuple(square(attitude, c, side) for c in centres),
    )


def arranged(
    attitude: tuple[float, float], pieces: Pieces
) -> tuple[Arrangement, tuple[Discontinuity, ...], list[int]]:
    normal = normal_of(*attitude)
    poles = np.repeat(-normal[None], len(pieces.places), axis=0)
    whole, found, number = arrange_planes("S1", normal, poles, pieces, describe_faces(pieces))
    return whole, found, number.tolist()


def pieces_at(places: Array) -> Pieces:
    """Planes (m, 3) of which nothing but their place is known."""
    m = len(places)
    return Pieces(
        places,
        np.full((m, 3, 3), np.nan),
        np.full(m, np.nan),
        tuple(np.zeros((0, 3)) for _ in range(m)),
    )


@pytest.mark.parametrize("attitude", [(70.0, 60.0), (100.0, 60.0), (310.0, 90.0), (0.0, 0.0)])
def test_parallel_squares_have_expected_spacing_persistence_and_area(
    attitude: tuple[float, float],
) -> None:
    side, gap, n = 2.0, 0.35, 9
    order = np.random.default_rng(1).permutation(n)
    centres = order[:, None] * gap * normal_of(*attitude) + [4e5, 5e6, 300.0]
    whole, found, number = arranged(attitude, flat_pieces(attitude, centres, side))
    assert whole.discontinuities == n
    assert number == order.tolist()
    assert whole.spacing_m == pytest.approx(gap)
    assert whole.spacing_cv == pytest.approx(0.0, abs=1e-6)
    assert whole.spacing_ending_m == pytest.approx(gap)
    assert whole.persistence_dip_m == pytest.approx(side)
    assert whole.persistence_strike_m == pytest.approx(side)
    assert whole.persistence_max_m == pytest.approx(side * math.sqrt(2))
    assert whole.area_m2 == pytest.approx(n * side**2)
    # A volume filled with planes a gap apart has one over the gap of area in it.
    assert whole.p32_1_per_m == pytest.approx(1 / gap)
    assert whole.p32_exposed_1_per_m == pytest.approx(1 / gap)
    assert [one.n for one in found] == [1] * n
    assert found[0].hull_m2 == pytest.approx(side**2)


def test_persistence_is_measured_along_dip_and_strike() -> None:
    attitude = (200.0, 35.0)
    u, v = axes_of(*attitude)
    ring = np.array([-3 * u - v, 3 * u - v, 3 * u + v, -3 * u + v])
    pieces = Pieces(
        np.zeros((1, 3)), np.zeros((1, 3, 3)), np.array([12.0]), (ring + [1e5, 2e5, 10.0],)
    )
    _, found, _ = arranged(attitude, pieces)
    assert found[0].persistence_strike_m == pytest.approx(6.0)
    assert found[0].persistence_dip_m == pytest.approx(2.0)
    assert found[0].persistence_max_m == pytest.approx(math.hypot(6, 2))


def test_pieces_in_one_plane_are_one_discontinuity_that_spans_them() -> None:
    attitude = (20.0, 50.0)
    u, _ = axes_of(*attitude)
    normal = normal_of(*attitude)
    centres = np.array([0 * u, 7 * u, 0.5 * normal, 7 * u + 0.5 * normal])
    whole, found, number = arranged(attitude, flat_pieces(attitude, centres, 1.0))
    assert number == [0, 0, 1, 1]
    assert [one.n for one in found] == [2, 2]
    assert whole.persistence_strike_m == pytest.approx(8.0)
    assert whole.persistence_dip_m == pytest.approx(1.0)
    assert whole.area_m2 == pytest.approx(4.0)
    assert found[0].hull_m2 == pytest.approx(8.0)


def test_pieces_are_joined_within_one_and_a_half_sums_of_their_scatters() -> None:
    # Riquelme et al. (2014): |D1 - D2| <= k (s1 + s2), k = 1.5.
    s = np.array([0.02, 0.01])
    limit = MAX_JOINED_SCATTER * s.sum()
    assert MAX_JOINED_SCATTER == 1.5
    assert split_by_position(np.array([0.0, 0.999 * limit]), s).tolist() == [0, 0]
    assert split_by_position(np.array([0.0, 1.001 * limit]), s).tolist() == [0, 1]


def test_chain_of_small_pieces_does_not_join_distant_planes() -> None:
    offsets = np.arange(12) * 0.05
    found = split_by_position(offsets, np.full(12, 0.02))
    # Each within reach of the next, but the ends half a metre apart.
    assert len(set(found.tolist())) >= 5


def test_spacing_of_ending_planes_uses_nearest_neighbour() -> None:
    # Two stacks side by side, one half a step higher: along the normal planes alternate, but each
    # plane's nearest neighbour is the next of its own stack.
    attitude = (0.0, 0.0)
    low = [[0.0, 0.0, k * 1.0] for k in range(5)]
    high = [[20.0, 0.0, k * 1.0 + 0.5] for k in range(5)]
    whole, _, _ = arranged(attitude, flat_pieces(attitude, np.array(low + high), 2.0))
    assert whole.spacing_m == pytest.approx(0.5)
    # The last of the low stack has but the high one above it.
    assert whole.spacing_ending_m == pytest.approx((8 * 1.0 + 0.5) / 9)


def test_tilted_large_piece_is_joined_by_its_scatter_along_set_normal() -> None:
    # Of two pieces with the same middle distance the one that leans reaches the other.
    normal = normal_of(0.0, 0.0)
    lean = normal_of(90.0, 8.0)
    u = np.array([math.cos(math.radians(8)), 0, -math.sin(math.radians(8))])
    wide = 4.0**2 / 12 * (np.outer(u, u) + np.outer([0, 1, 0], [0, 1, 0]))
    flat = 4.0**2 / 12 * np.diag([1.0, 1.0, 0.0])
    places = np.array([[0, 0, 0.0], [5, 0, 0.2]])
    rings = (np.zeros((0, 3)), np.zeros((0, 3)))
    for scatter, expected in ((flat, 2), (wide, 1)):
        pieces = Pieces(places, np.stack([flat, scatter]), np.full(2, np.nan), rings)
        poles = np.stack([normal, lean if expected == 1 else normal])
        whole, _, _ = arrange_planes("S1", normal, poles, pieces, None)
        assert whole.discontinuities == expected
        assert whole.persistence_dip_m is None
        assert whole.area_m2 is None


def test_apparent_spacing_is_true_spacing_divided_by_cosine() -> None:
    normal = normal_of(130.0, 70.0)
    places = np.arange(-30, 30)[:, None] * 0.4 * normal
    poles = np.repeat(normal[None], 60, axis=0)
    for angle in (0.0, 25.0, 60.0):
        side = axes_of(130.0, 70.0)[0]
        way = math.cos(math.radians(angle)) * normal + math.sin(math.radians(angle)) * side
        found = measure_scanline_spacing(normal, poles, places, np.stack([-3.03 * way, 5.01 * way]))
        assert found.apparent_m == pytest.approx(0.4 / math.cos(math.radians(angle)))
        assert found.true_m == pytest.approx(0.4)
        # Planes k with -3.03 cos <= 0.4 k <= 5.01 cos.
        cosine = math.cos(math.radians(angle))
        assert found.n == math.floor(5.01 * cosine / 0.4) + math.floor(3.03 * cosine / 0.4) + 1
    beside = measure_scanline_spacing(
        normal, poles, places, np.stack([places[0] - 9 * normal] * 2) + [[0], [1]]
    )
    assert beside.n == 0
    assert beside.apparent_m is None


@pytest.mark.full
def test_p32_of_tilted_planes_includes_cosine_correction() -> None:
    # Planes at even distances from a point, one each r metres, have 1 / r of area per volume
    # whatever their attitudes (a plane at distance d cuts a ball in pi (R^2 - d^2)); a line crosses
    # fewer of those that lean (Wang 2005, PhD thesis, Virginia Tech: C13).
    chance = np.random.default_rng(3)
    reach, n = 14.0, 20_000
    d = chance.uniform(-reach, reach, n)
    normals = np.array([0.0, 0.0, 1.0]) + 0.25 * chance.standard_normal((n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    height = d / normals[:, 2]
    on_line = np.abs(height) <= 8.0
    height, normals = height[on_line], normals[on_line]
    m = len(height)
    nothing = tuple(np.zeros((0, 3)) for _ in range(m))
    places = np.column_stack([np.zeros(m), np.zeros(m), height])
    pieces = Pieces(places, np.full((m, 3, 3), np.nan), np.full(m, np.nan), nothing)
    whole, _, _ = arrange_planes("S1", np.array([0.0, 0, 1]), normals, pieces, None)
    assert np.mean(1 / normals[:, 2]) > 1.04
    assert whole.p32_1_per_m == pytest.approx(n / (2 * reach), rel=0.02)


@pytest.mark.full
def test_p32_interval_contains_truth_in_95_percent() -> None:
    # Planes at random along the normal, at one a metre; known exactly for gaps of a Poisson
    # process (Cox & Lewis 1966).
    chance = np.random.default_rng(4)
    attitude, held, runs = (40.0, 55.0), 0, 400
    normal = normal_of(*attitude)
    for _ in range(runs):
        places = np.cumsum(chance.exponential(1.0, 12))[:, None] * normal
        whole, _, _ = arranged(attitude, flat_pieces(attitude, places, 1.0))
        held += whole.p32_low95_1_per_m <= 1.0 <= whole.p32_high95_1_per_m
    # Four standard deviations of a binomial count about 95 %.
    assert abs(held / runs - 0.95) < 4 * math.sqrt(0.95 * 0.05 / runs)


def test_p32_interval_is_reliable_for_planes_tilted_within_set() -> None:
    """Endless planes at one square metre in a cubic metre, each seen in a piece on a wall:
    pieces that lean reach past their neighbours along the normal, and are joined with them."""
    chance = np.random.default_rng(8)
    normal, held, runs = np.array([1.0, 0.0, 0.0]), 0, 300
    for _ in range(runs):
        n = chance.poisson(60)
        lean = np.array([1.0, 0, 0]) + chance.standard_normal((n, 3)) * [0.0, 0.18, 0.18]
        lean /= np.linalg.norm(lean, axis=1)[:, None]
        # Where a plane that is d from the middle meets the wall y = 0, somewhere in its height.
        d, height = chance.uniform(-30.0, 30.0, n), chance.uniform(-6.0, 6.0, n)
        along = (d - height * lean[:, 2]) / lean[:, 0]
        places = np.column_stack([along, 0.0 * d, height])
        seen = np.abs(along) < 10.0
        flat = np.eye(3) - lean[:, :, None] * lean[:, None, :]
        m = int(seen.sum())
        pieces = Pieces(
            places[seen],
            0.5 * flat[seen],
            np.full(m, np.nan),
            tuple(np.zeros((0, 3)) for _ in range(m)),
        )
        whole, _, _ = arrange_planes("S1", normal, lean[seen], pieces, None)
        assert whole.p32_low95_1_per_m <= whole.p32_1_per_m <= whole.p32_high95_1_per_m
        held += whole.p32_low95_1_per_m <= 1.0 <= whole.p32_high95_1_per_m
    assert held / runs > 0.95 - 4 * math.sqrt(0.95 * 0.05 / runs)


def test_picks_possibly_on_one_plane_have_no_interval() -> None:
    """Three on each of ten planes a metre apart count as thirty, which no interval of thirty
    planes at random may hide."""
    chance = np.random.default_rng(6)
    attitude = (100.0, 60.0)
    normal, along = normal_of(*attitude), axes_of(*attitude)[0]
    poles = -normal + math.radians(2.0) * chance.standard_normal((30, 3))
    poles /= np.linalg.norm(poles, axis=1)[:, None]
    on = np.repeat(np.arange(10), 3)[:, None] * normal
    places = on + np.tile([-8.0, 0.0, 8.0], 10)[:, None] * (along + 0.01 * normal)
    whole, found, _ = arrange_planes("S1", normal, poles, pieces_at(places), None)
    assert whole.discontinuities == len(found) == 30
    assert whole.p32_1_per_m is not None
    assert (whole.p32_low95_1_per_m, whole.p32_high95_1_per_m) == (None, None)
    # What is known of the scatter joins them, and one pick on each plane tells it.
    joined, _, _ = arrange_planes("S1", normal, poles, flat_pieces(attitude, places, 1.0), None)
    assert joined.p32_low95_1_per_m is not None
    single, _, _ = arrange_planes("S1", normal, poles[::3], pieces_at(places[::3]), None)
    assert single.spacing_m == pytest.approx(1.0)
    assert single.p32_low95_1_per_m is not None


def test_single_face_is_distinguished_from_several() -> None:
    chance = np.random.default_rng(5)
    wall = np.column_stack(
        [chance.uniform(0, 20, 40), chance.normal(0, 0.3, 40), chance.uniform(0, 8, 40)]
    )
    corner = np.concatenate([wall, wall[:, [1, 0, 2]]])
    nothing = np.full((80, 3, 3), np.nan), np.full(80, np.nan)
    rings = tuple(np.zeros((0, 3)) for _ in range(80))
    assert describe_faces(Pieces(wall, nothing[0][:40], nothing[1][:40], rings[:40])) == "one face"
    assert describe_faces(Pieces(corner, *nothing, rings)) == "several faces"
    assert describe_faces(Pieces(wall[:3], nothing[0][:3], nothing[1][:3], rings[:3])) is None


def test_planes_without_position_belong_to_no_discontinuity() -> None:
    attitude = (40.0, 55.0)
    pieces = flat_pieces(attitude, np.array([[0.0, 0, 0], [np.nan] * 3, [0, 0, 1.0]]), 0.5)
    whole, found, number = arranged(attitude, pieces)
    assert number[1] == -1
    assert whole.discontinuities == len(found) == 2
    nowhere = flat_pieces(attitude, np.full((2, 3), np.nan), 0.5)
    whole, found, number = arranged(attitude, nowhere)
    assert (whole.discontinuities, whole.spacing_m, found, number) == (None, None, (), [-1, -1])
