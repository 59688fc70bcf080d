"""A path that leaves its contact for a parallel one, against planes that are known."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.extraction.followed_trace import followed_trace
from vomstudio.extraction.path_jumps import MAX_VERTICES, find_jumps
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import fit_remaining_plane
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane

STEP = 0.02
ROCK = 1.0
CONTACT = 0.1


def bent_line(n: int = 150, seed: int = 0) -> np.ndarray:
    """(n, 3) points along a line that bends in the plane z = 0, scattered about it by 4 mm."""
    rng = np.random.default_rng(seed)
    x = STEP * np.arange(n)
    return np.stack([x, 0.4 * np.sin(2.0 * x), 0.004 * rng.standard_normal(n)], axis=1)


def crossed(n: int, *places: int) -> np.ndarray:
    """(n,) costs of a contact that is left or reached at some places."""
    costs = np.full(n, CONTACT)
    for place in places:
        costs[place - 1 : place + 2] = ROCK
    return costs


@pytest.mark.parametrize("offset", [0.06, -0.15, 0.3])
@pytest.mark.parametrize("stretch", [(20, 60), (95, 130)])
def test_stretch_off_the_plane_is_found(offset: float, stretch: tuple[int, int]) -> None:
    points = bent_line()
    first, last = stretch
    points[first : last + 1, 2] += offset
    result = find_jumps(points, crossed(150, *stretch), np.array([0, 75, 149]), STEP)
    assert len(result) == 1
    assert np.abs(np.subtract(result[0], stretch)).max() <= 2
    rest = fit_remaining_plane(points, result)
    assert rest is not None
    assert rest.fit is not None
    assert abs(rest.stretches[0].offset_m) == pytest.approx(abs(offset), abs=0.01)
    assert rest.fit.normal[2] == pytest.approx(1.0, abs=1e-4)
    # The plane of all points is at most as far off as is stated.
    fit = fit_plane(points)
    assert np.degrees(np.arccos(fit.normal[2])) <= rest.error95_deg(fit, STEP)
    assert [each.code for each in rest.findings()] == ["trace.beside"]


def test_stretches_of_both_legs_are_found() -> None:
    points = bent_line()
    points[20:50, 2] += 0.2
    points[90:120, 2] -= 0.1
    result = find_jumps(points, crossed(150, 20, 50, 90, 120), np.array([0, 75, 149]), STEP)
    assert np.abs(np.array(result) - [[20, 50], [90, 120]]).max() <= 2


def test_gaps_in_one_contact_are_not_jumps() -> None:
    for seed in range(20):
        costs = crossed(150, 20, 60, 95, 130)
        assert find_jumps(bent_line(seed=seed), costs, np.array([0, 75, 149]), STEP) == ()


def test_stretch_confirmed_by_way_point_is_not_a_jump() -> None:
    """Both contacts were clicked: the path did not choose."""
    points = bent_line()
    points[60:90, 2] += 0.15
    assert find_jumps(points, crossed(150, 60, 90), np.array([0, 75, 149]), STEP) == ()


def test_undulating_bed_has_no_jumps() -> None:
    """By 3 cm at a wavelength of a third of the trace, with gaps."""
    points = bent_line()
    points[:, 2] += 0.03 * np.sin(2.0 * np.pi * points[:, 0])
    costs = crossed(150, 12, 38, 62, 87, 112, 137)
    assert find_jumps(points, costs, np.array([0, 75, 149]), STEP) == ()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_jumps_are_invariant_to_rotation_and_scale(scale: float) -> None:
    points, at = bent_line(), np.array([0, 75, 149])
    points[20:60, 2] += 0.1
    costs = crossed(150, 20, 60)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    there = scale * (points @ turn.T) + [4.6e5, 4.6e6, 8.0e2]
    assert find_jumps(there, costs, at, scale * STEP) == find_jumps(points, costs, at, STEP) != ()


def test_photo_pixels_are_grouped_before_search() -> None:
    points = bent_line(10 * MAX_VERTICES) * [0.02, 0.02, 1.0]
    points[1000:2000, 2] += 0.1
    costs = np.full(len(points), CONTACT)
    costs[980:1020] = costs[1980:2020] = ROCK
    at = np.array([0, 2500, len(points) - 1])
    ((first, last),) = find_jumps(points, costs, at, STEP)
    assert abs(first - 1000) < 60
    assert abs(last - 2000) < 60


def test_ranges_outside_the_trace_are_ignored() -> None:
    assert fit_remaining_plane(bent_line(), [(-1, 4), (3, 150), (9, 2)]) is None


def two_seams() -> tuple[Mesh, np.ndarray, float]:
    """A wavy wall with a dark seam whose middle is covered, and there a parallel one 18 cm above;
    way-points on the first seam; its dip, which is 20 degrees to the right."""
    x, height = (a.ravel() for a in np.meshgrid(np.arange(0, 3, STEP), np.arange(0, 2, STEP)))
    y = 0.25 * np.sin(2.1 * x) + 0.2 * np.sin(3.3 * height + 1.0)
    points = np.stack([x, y, height], axis=1)
    normal = np.array([np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0))])
    off = (points - [1.5, 0.0, 1.0]) @ normal
    covered = (x > 0.5) & (x < 1.3)
    dark = (np.abs(off) < 0.02) & ~covered
    dark |= (np.abs(off - 0.18) < 0.02) & (x > 0.45) & (x < 1.35)
    grey = np.where(dark, 40, 180).astype(np.uint8)
    count = len(np.arange(0, 3, STEP))
    a = (np.arange(len(x) // count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([a, a + 1, a + count], axis=1),
            np.stack([a + 1, a + count + 1, a + count], axis=1),
        ]
    )
    mesh = Mesh(points, faces.astype(np.int32), colors=np.repeat(grey[:, None], 3, axis=1))
    clicks = []
    for place in (0.1, 1.7, 2.9):
        on = np.flatnonzero((np.abs(off) < 0.02) & ~covered & (np.abs(x - place) < STEP))
        clicks.append(points[on[0]])
    return mesh, np.array(clicks), 20.0


def test_trace_that_jumps_to_next_seam_is_marked_and_not_good() -> None:
    mesh, clicks, dip = two_seams()
    result = followed_trace(
        SurfaceGraph(mesh), clicks, cost="dark", resolution=STEP, model="m", frame="local"
    )
    assert "trace.beside" in [getattr(each, "code", "") for each in result.warnings]
    (stretch,) = result.doubtful
    own = result.points[stretch.first : stretch.last + 1]
    assert 0.3 < own[:, 0].min() < own[:, 0].max() < 1.6
    assert abs(stretch.offset_m) == pytest.approx(0.18, abs=0.04)
    assert result.plane is not None
    assert result.plane["quality"] != "good"
    normal = np.array([np.sin(np.radians(dip)), 0.0, np.cos(np.radians(dip))])
    own_normal = [result.plane[f"normal_{axis}"] for axis in "xyz"]
    error = np.degrees(np.arccos(min(abs(float(normal @ own_normal)), 1.0)))
    assert error <= result.plane["total95_deg"]
