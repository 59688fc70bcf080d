"""A bed that bends: local dips of a known fold from traces on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.extraction.planes_by_construction import angle_deg, normal_of
from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geology.beds.curved import CurvedBed, curved_bed

Array = np.ndarray
RADIUS = 40.0


def fold(rng: np.random.Generator, noise: float, n: int = 25) -> tuple[Array, Array, Array]:
    """Five winding traces on a cylinder about a level axis to the north, with their normals."""
    points, normals = [], []
    for k in range(5):
        t = np.linspace(0, 1, n)
        local_dips = 4.0 * k + 3.0 * np.sin(3 * t + k)
        angle = np.radians(-14 + 28 * t + 3 * k)
        normal = np.stack([np.sin(angle), np.zeros(n), np.cos(angle)], axis=1)
        points.append(
            RADIUS * normal
            + local_dips[:, None] * [0.0, 1.0, 0.0]
            + noise * rng.standard_normal((n, 1)) * normal
        )
        normals.append(normal)
    return np.concatenate(points), np.concatenate(normals), np.arange(0, 5 * n + 1, n)


def off(found: CurvedBed, normals: Array) -> Array:
    return np.array(
        [
            angle_deg(normal_of(d, i), m)
            for (d, i, _), m in zip(found.local_dips, normals, strict=True)
        ]
    )


def test_local_dips_match_tangent_planes_of_fold() -> None:
    points, normals, cuts = fold(np.random.default_rng(1), 0.02)
    found = curved_bed(list("abcde"), points + [4e5, 5e6, 100], cuts)
    assert found.degree >= 2
    assert found.p < 1e-6
    assert off(found, normals).max() < 1.0
    assert np.median(off(found, normals)) < 0.3
    assert found.rms_m == pytest.approx(0.02, rel=0.25)
    assert [one.id for one in found.dips] == list("abcde")
    for one in found.dips:
        away = math.hypot(one.x - 4e5, one.z - 100)
        assert away == pytest.approx(RADIUS, abs=0.02)


@pytest.mark.full
@pytest.mark.parametrize("noise", [0.01, 0.02, 0.05, 0.2])
def test_stated_error_of_local_dips_is_reliable(noise: float) -> None:
    rng = np.random.default_rng(2)
    held = []
    for _ in range(40):
        points, normals, cuts = fold(rng, noise)
        found = curved_bed(list("abcde"), points, cuts)
        held.append(off(found, normals) <= found.local_dips[:, 2])
    assert np.mean(held) > 0.91


def test_planar_bed_is_fitted_as_plane() -> None:
    rng = np.random.default_rng(3)
    degrees = []
    for _ in range(60):
        u, v = rng.uniform(-5, 5, (2, 60))
        points = np.column_stack([u, v, 0.3 * u - 0.2 * v + 0.02 * rng.standard_normal(60)])
        found = curved_bed(["a", "b", "c"], points, [0, 20, 40, 60])
        degrees.append(found.degree)
        if found.degree == 1:
            assert found.p is None
            assert np.ptp(found.local_dips[:, 1]) < 1e-9
    # Two tests at half of 5 %.
    assert np.mean(np.array(degrees) > 1) < 0.17


def test_roughness_along_traces_reduces_effective_number_of_points() -> None:
    rng = np.random.default_rng(4)
    points, normals, cuts = fold(rng, 0.0, 80)
    rough = np.concatenate(
        [np.convolve(rng.standard_normal(100), np.ones(8) / 8, "same")[10:90] for _ in range(5)]
    )
    found = curved_bed(list("abcde"), points + 0.1 * rough[:, None] * normals, cuts)
    assert found.n_effective < 0.4 * found.n


def test_rotating_points_rotates_the_dips() -> None:
    points, _, cuts = fold(np.random.default_rng(5), 0.02)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    one = curved_bed(list("abcde"), points, cuts)
    two = curved_bed(list("abcde"), points @ turn.T, cuts)
    assert two.local_dips[:, 1] == pytest.approx(one.local_dips[:, 1], abs=1e-6)
    turned = (two.local_dips[:, 0] - one.local_dips[:, 0]) % 360
    assert turned == pytest.approx(np.full(len(turned), 30.0), abs=1e-4)


def test_points_without_unique_surface_are_refused() -> None:
    line = np.column_stack([np.arange(10.0), np.arange(10.0), np.arange(10.0)])
    with refused("beds.no-surface", GeometryError):
        curved_bed(["a"], line, [0, 10])
    with refused("beds.no-surface", GeometryError):
        curved_bed(["a"], line[:4], [0, 4])
