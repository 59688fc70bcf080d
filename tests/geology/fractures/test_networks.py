"""Maps of traces whose figures follow from how they were made, and KB11 beside fractopo."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from tests.drawings import read_area, read_lines
from tests.messages import by_code, refused
from vomstudio.core.errors import GeometryError
from vomstudio.geology.fractures.network import SamplingRegion, fracture_network
from vomstudio.geology.fractures.nodes import find_nodes
from vomstudio.geology.fractures.pieces import circle_area, clip_traces

SQUARE = shapely.box(0, 0, 10, 10)


def lines(*rows: list[tuple[float, float]]) -> np.ndarray:
    statistics = np.empty(len(rows), object)
    statistics[:] = [shapely.LineString(row) for row in rows]
    return statistics


def counts(statistics: object) -> tuple[int, int, int]:
    nodes = statistics.nodes  # type: ignore[attr-defined]
    return nodes.I, nodes.Y, nodes.X


def test_grid_of_traces_has_expected_nodes() -> None:
    grid = lines(
        *([(1.0, y), (9.0, y)] for y in (2.0, 4.0, 6.0)),
        *([(x, 1.0), (x, 6.0)] for x in (3.0, 5.0)),  # they abut on the last of the others
    )
    statistics = fracture_network(grid).statistics
    assert counts(statistics) == (8, 2, 4)
    assert statistics.mended == ()
    assert statistics.area_m2 is statistics.P21_1_per_m is statistics.P10_1_per_m is None
    assert statistics.length.mean_m == statistics.length.naive_mean_m == pytest.approx(34 / 5)


def test_pieces_end_at_window_edge_and_not_at_nodes() -> None:
    traces = lines(
        [(-5, 5), (15, 5)],  # through
        [(5, 2), (5, 8)],  # inside, crosses it
        [(8, 8), (12, 8), (12, 9), (8, 9)],  # leaves and comes back
        [(20, 20), (30, 30)],  # elsewhere
    )
    statistics = fracture_network(traces, SamplingRegion(SQUARE)).statistics
    assert (statistics.traces, statistics.pieces) == (4, 4)
    assert statistics.area_m2 == 100.0
    assert statistics.P20_1_per_m2 == pytest.approx(0.04)
    assert statistics.P21_1_per_m == pytest.approx((10 + 6 + 2 + 2) / 100)
    assert counts(statistics) == (4, 0, 1)
    assert statistics.nodes.E == 4
    assert statistics.P20_nodes_1_per_m2 == pytest.approx(4 / 2 / 100)
    assert statistics.length.censored_share == 0.75
    # All length over half of the ends inside.
    assert statistics.length.mean_m == pytest.approx(20 / (4 / 2))


@pytest.mark.parametrize(("snap", "expected"), [(0.0, (6, 0, 1)), (0.1, (4, 2, 0))])
def test_gaps_and_overshoots_are_mended_within_the_tolerance_and_listed(
    snap: float, expected: tuple[int, int, int]
) -> None:
    traces = lines(
        [(0, 0), (10, 0)],
        [(3, 5), (3, 0.05)],  # stops short
        [(6, 5), (6, -0.05)],  # runs past
    )
    statistics = fracture_network(traces, snap_m=snap).statistics
    assert counts(statistics) == expected
    listed = [(m.what, m.trace, m.other, round(m.distance_m, 9)) for m in statistics.mended]
    assert listed == ([("gap", 2, 1, 0.05), ("overshoot", 3, 1, 0.05)] if snap else [])


def test_an_acute_overshoot_is_one_abutment() -> None:
    ran_past = (5 + 0.4, -0.04)
    traces = lines([(0, 0), (10, 0)], [(0, 0.5), ran_past])
    assert counts(fracture_network(traces, snap_m=0.05).statistics) == (3, 1, 0)


def test_end_to_end_and_star_junctions_are_counted_separately() -> None:
    traces = lines(
        [(0, 0), (1, 0)], [(1, 0), (2, 1)], [(5, 0), (5, 2)], [(4, 1), (6, 1)], [(4, 0), (6, 2)]
    )
    statistics = fracture_network(traces).statistics
    assert (statistics.nodes.L, statistics.nodes.other) == (1, 1)
    assert counts(statistics) == (8, 0, 0)
    assert by_code(statistics.warnings)["fractures.other-nodes"] == {"count": 1}


def test_self_crossing_trace_is_one_piece_and_reported() -> None:
    loop = lines([(-2, 3), (6, 3), (6, 6), (3, 6), (3, 1)])
    statistics = fracture_network(loop, SamplingRegion(SQUARE)).statistics
    assert statistics.pieces == 1
    assert statistics.P21_1_per_m == pytest.approx((6 + 3 + 3 + 5) / 100)
    assert by_code(statistics.warnings)["fractures.self-crossing"] == {"count": 1, "rows": (1,)}


def test_a_closed_trace_has_no_ends() -> None:
    statistics = fracture_network(
        lines([(2, 2), (4, 2), (4, 4), (2, 2)]), SamplingRegion(SQUARE)
    ).statistics
    assert (statistics.pieces, counts(statistics)) == (1, (0, 0, 0))


def test_overlapping_traces_are_counted_and_reported() -> None:
    statistics = fracture_network(lines([(0, 0), (4, 0)], [(2, 0), (6, 0)])).statistics
    assert by_code(statistics.warnings)["fractures.overlaps"] == {"count": 1}


def test_circular_window_has_exact_area_and_length() -> None:
    area = circle_area(3.0, -2.0, 5.0)
    assert area.area == pytest.approx(math.pi * 25, rel=1e-12)
    statistics = fracture_network(
        lines([(-10, -2), (10, -2)], [(3, 0), (3, 2)]),
        SamplingRegion(area, circle=(3.0, -2.0, 5.0)),
    ).statistics
    assert statistics.P21_1_per_m == pytest.approx(12 / (math.pi * 25), rel=1e-5)
    # Mauldon and others (2001): n = 2 crossings of the rim, m = 2 ends inside.
    assert statistics.circle is not None
    assert (statistics.circle.n, statistics.circle.m) == (2, 2)
    assert statistics.circle.intensity_1_per_m == pytest.approx(2 / 20)
    assert statistics.circle.density_1_per_m2 == pytest.approx(2 / (2 * math.pi * 25))
    assert statistics.circle.mean_length_m == pytest.approx(math.pi * 5 / 2)


def test_a_hole_in_the_area_is_not_counted() -> None:
    area = SQUARE.difference(shapely.box(4, 4, 6, 6))
    statistics = fracture_network(lines([(1, 5), (9, 5)]), SamplingRegion(area)).statistics
    assert statistics.pieces == 2
    assert statistics.P21_1_per_m == pytest.approx(6 / 96)
    assert (counts(statistics), statistics.nodes.E) == ((2, 0, 0), 2)


def test_empty_window_has_zero_density_and_window_off_map_is_refused() -> None:
    corners = lines([(0, 0), (1, 0)], [(20, 20), (21, 20)])
    statistics = fracture_network(corners, SamplingRegion(shapely.box(8, 8, 12, 12))).statistics
    assert (statistics.pieces, statistics.P21_1_per_m, statistics.length.mean_m) == (0, 0.0, None)
    with refused("fractures.area-elsewhere", GeometryError):
        fracture_network(corners, SamplingRegion(shapely.box(100, 100, 110, 110)))


def test_results_scale_and_rotate_with_traces() -> None:
    """Turned by 30 degrees strikes are 30 degrees more; twice as large, P21 is half."""
    chance = np.random.default_rng(3)
    start = chance.uniform(-2, 12, (80, 2))
    turn = chance.normal(0.6, 0.1, 80)
    end = start + chance.exponential(2.0, 80)[:, None] * np.stack([np.sin(turn), np.cos(turn)], -1)
    traces = shapely.linestrings(np.stack([start, end], axis=1))
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))

    def moved(xy: np.ndarray) -> np.ndarray:
        return 2 * xy @ np.array([[c, -s], [s, c]]) + [4e5, 6e6]

    one = fracture_network(traces, SamplingRegion(SQUARE)).statistics
    two = fracture_network(
        shapely.transform(traces, moved), SamplingRegion(shapely.transform(SQUARE, moved))
    ).statistics
    assert counts(one) == counts(two)
    assert two.sets[0].strike_deg == pytest.approx(one.sets[0].strike_deg + 30, abs=1e-6)
    assert two.P21_1_per_m == pytest.approx(one.P21_1_per_m / 2, rel=1e-6)
    assert two.length.mean_m == pytest.approx(2 * one.length.mean_m, rel=1e-6)
    law = one.length.fits[0].distribution
    assert two.length.fits[0].distribution == law


@pytest.mark.full
def test_fifty_thousand_traces_have_expected_densities() -> None:
    chance = np.random.default_rng(4)
    start = chance.uniform(0, 1000, (50_000, 2))
    turn = chance.uniform(0, math.pi, 50_000)
    end = start + 4.0 * np.stack([np.sin(turn), np.cos(turn)], -1)
    traces = shapely.linestrings(np.stack([start, end], axis=1))
    area = shapely.box(100, 100, 900, 900)
    pieces = clip_traces(traces, area)
    statistics = find_nodes(pieces, 0.0, area).counts
    # A Poisson process: density 0.05, P21 0.2, X = P21^2 / pi per area for all directions.
    assert statistics.I / 2 / area.area == pytest.approx(0.05, rel=0.03)
    assert pieces.lengths().sum() / area.area == pytest.approx(0.2, rel=0.03)
    assert statistics.X / area.area == pytest.approx(0.2**2 / math.pi, rel=0.03)


def test_kb11_matches_fractopo(data_dir) -> None:
    """Nodes of fractopo 0.9 with truncated traces and snap_threshold 0.001: I 476, Y 826, X 268.
    707 traces, 709 pieces and the densities are those that came with the data."""
    drawn = read_lines(data_dir / "fracture_traces" / "KB11_traces.geojson")
    area, _ = read_area(data_dir / "fracture_traces" / "KB11_area.geojson")
    for snap in (0.0, 0.001):
        statistics = fracture_network(drawn.shapes, SamplingRegion(area), snap_m=snap).statistics
        assert (statistics.traces, statistics.pieces) == (707, 709)
        assert counts(statistics) == (476, 826, 268)
        assert statistics.area_m2 == pytest.approx(1237.9, abs=0.05)
        assert statistics.P21_1_per_m == pytest.approx(1.26308754, rel=1e-8)
        assert statistics.P21_unclipped_1_per_m == pytest.approx(1.29, abs=0.005)
        assert statistics.P20_1_per_m2 == pytest.approx(0.57, abs=0.005)
        assert statistics.P20_nodes_1_per_m2 == pytest.approx(0.52589047, rel=1e-7)
        assert statistics.length.naive_mean_m == pytest.approx(2.20532656, rel=1e-8)
        assert statistics.length.longest_m == pytest.approx(33.1085306, rel=1e-8)


def test_area_beyond_traces_is_reported() -> None:
    """Traces over a square of 10 m; the circle about a corner has a quarter of itself on it, that
    about the middle all."""
    lines = shapely.linestrings([[(0, k), (10, k)] for k in range(11)])

    def share_percent(x: float, y: float, radius: float) -> float | None:
        area = shapely.Point(x, y).buffer(radius, 256)
        statistics = fracture_network(
            lines, SamplingRegion(area=area, circle=(x, y, radius))
        ).statistics
        note = by_code(statistics.notes).get("fractures.area-beyond-traces")
        return None if note is None else note["share_percent"]

    assert share_percent(5, 5, 4) is None
    assert share_percent(0, 0, 4) == pytest.approx(75, abs=0.1)
    assert share_percent(0, 5, 4) == pytest.approx(50, abs=0.1)
    # pi 50^2 = 7854 of which 100 are mapped.
    assert share_percent(5, 5, 50) == pytest.approx(100.0 * (1.0 - 100.0 / 7854.0), abs=0.1)
