"""Fields of surfaces whose attitude, curvature and roughness are known by construction."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import clouds_of, grid_mesh, normal_of, sheet
from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.extraction.surface_fields import KINDS, SurfaceFields, field_name, surface_fields
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane

UTM = np.array([500_000.0, 5_000_000.0, 300.0])


def ball(radius: float, count: int = 40_000, at: np.ndarray = UTM) -> PointCloud:
    """Evenly covered, by Fibonacci's spiral, normals pointing out."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    out = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], 1)
    return PointCloud(radius * out + at, normals=out.astype(np.float32))


def inner(values: np.ndarray, points: np.ndarray, margin: float) -> np.ndarray:
    """Those of places away from the border of a sheet, seen from above."""
    low, high = points[:, :2].min(axis=0) + margin, points[:, :2].max(axis=0) - margin
    return values[((points[:, :2] > low) & (points[:, :2] < high)).all(axis=1)]


@pytest.mark.parametrize(
    ("dip_direction", "dip"), first_in_default_tier([(130.0, 35.0), (310.0, 80.0), (2.0, 12.0)])
)
def test_a_plane_has_its_attitude_everywhere(dip_direction, dip) -> None:
    rng = np.random.default_rng(5)
    points = sheet(rng, (dip_direction, dip), tuple(UTM), size=4.0, count=20_000, noise=0.0)
    result = surface_fields(PointCloud(points), 0.3).values
    assert np.abs(result["dip"] - dip).max() < 1e-3
    off = (result["dip_direction"] - dip_direction + 180.0) % 360.0 - 180.0
    assert np.abs(off).max() < 0.01
    assert result["roughness"].max() < 1e-6
    assert np.abs(result["curvature"]).max() < 1e-3


def test_rotating_cloud_rotates_dip_direction() -> None:
    cloud = ball(3.0, 8_000)
    turn = np.radians(30.0)
    # Clockwise seen from above, as azimuths count.
    rows = np.array(
        [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1.0]]
    )
    turned = PointCloud((cloud.points - UTM) @ rows.T + UTM, normals=cloud.normals @ rows.T)
    one, other = surface_fields(cloud, 0.8).values, surface_fields(turned, 0.8).values
    # Where it is steep enough to have one; the cells of the thinning lie otherwise.
    known = (one["dip"] > 20.0) & (one["dip"] < 85.0)
    off = (other["dip_direction"] - one["dip_direction"])[known] % 360.0
    assert np.median(off) == pytest.approx(30.0, abs=0.1)
    assert np.median(np.abs(other["dip"] - one["dip"])) < 0.5


@pytest.mark.parametrize("radius", first_in_default_tier([2.0, 5.0, 20.0], 1))
def test_sphere_curvature_is_inverse_radius(radius) -> None:
    """Mean curvature of a sphere is 1 / R."""
    cloud = ball(radius)
    result = surface_fields(cloud, 0.15 * radius)
    assert np.median(result.values["curvature"]) == pytest.approx(1.0 / radius, rel=0.02)
    # Seen from within it bends the other way.
    within = PointCloud(cloud.points, normals=-cloud.normals)
    turned = surface_fields(within, 0.15 * radius).values["curvature"]
    assert np.median(turned) == pytest.approx(-1.0 / radius, rel=0.02)


def test_cylinder_curvature_is_half_that_of_sphere() -> None:
    """H = 1 / (2 R)."""
    rng = np.random.default_rng(1)
    angle, along = rng.uniform(0.0, np.pi, 40_000), rng.uniform(-3.0, 3.0, 40_000)
    out = np.stack([np.cos(angle), np.zeros(40_000), np.sin(angle)], 1)
    points = 2.0 * out + np.stack([0 * along, along, 0 * along], 1)
    result = surface_fields(PointCloud(points, normals=out.astype(np.float32)), 0.3)
    kept = inner(result.values["curvature"], points, 0.4)
    assert np.median(kept) == pytest.approx(0.25, rel=0.02)


@pytest.mark.full
def test_roughness_equals_added_noise() -> None:
    rng = np.random.default_rng(2)
    points = sheet(rng, (200.0, 40.0), (0.0, 0.0, 0.0), size=4.0, count=40_000, noise=0.01)
    result = surface_fields(PointCloud(points), 0.4).values
    assert np.median(inner(result["roughness"], points, 0.5)) == pytest.approx(0.01, rel=0.05)


def test_coplanarity_and_collinearity_match_plane_fit() -> None:
    """Of the same points, by the fit that judges picks."""
    rng = np.random.default_rng(3)
    points = rng.standard_normal((24, 3)) * [0.3, 0.1, 0.02]
    result = surface_fields(PointCloud(points), 50.0).values
    fit = fit_plane(points)
    assert result["coplanarity"][0] == pytest.approx(fit.M, rel=1e-5)
    assert result["collinearity"][0] == pytest.approx(fit.K, rel=1e-5)


def test_overhangs_are_steeper_than_a_right_angle() -> None:
    heights = np.zeros((60, 60))
    mesh = grid_mesh(heights, 0.05)
    normal = normal_of(90.0, 70.0)
    for out, expected in ((normal, 70.0), (-normal, 110.0)):
        # A sheet turned so that its faces look along `out`.
        u = np.cross([0.0, 1.0, 0.0], out)
        axes = np.stack([np.cross(out, u / np.linalg.norm(u)), u / np.linalg.norm(u), out])
        axes[0] = np.cross(axes[1], axes[2])
        result = surface_fields(Mesh(mesh.vertices @ axes + UTM, mesh.faces), 0.3).values
        assert np.abs(result["steepness"] - expected).max() < 0.01
        assert np.abs(result["dip"] - 70.0).max() < 0.01


def test_density_differences_do_not_bias_dip() -> None:
    """Vertices a hundred times as dense on one of two planes that meet in the ball."""
    rng = np.random.default_rng(4)
    left = rng.uniform([-1.0, -1.0, 0.0], [0.0, 1.0, 0.0], (40_000, 3))
    right = rng.uniform([0.0, -1.0, 0.0], [1.0, 1.0, 0.0], (1_000, 3))
    right[:, 2] = right[:, 0]
    cloud = PointCloud(np.concatenate([left, right, [[0.0, 0.0, 0.0]]]))
    result = surface_fields(cloud, 0.6).values
    # Between 0 and 45 degrees, and far from the dense side's alone.
    assert 15.0 < result["dip"][-1] < 30.0


def test_places_with_few_neighbours_have_no_value() -> None:
    rng = np.random.default_rng(6)
    dense = sheet(rng, (90.0, 30.0), (0.0, 0.0, 0.0), size=2.0, count=4_000)
    lonely = rng.uniform(50.0, 90.0, (400, 3))
    cloud, part = clouds_of(dense, lonely)
    result = surface_fields(cloud, 0.2)
    for key in KINDS:
        assert np.isnan(result.values[key][part == 1]).all()
    assert np.isfinite(result.values["dip"][part == 0]).all()
    assert by_code(result.warnings)["fields.few-points"]["share_percent"] == pytest.approx(
        100.0 * 400 / 4_400, abs=0.1
    )


def test_duplicate_points_and_nan_are_tolerated() -> None:
    rng = np.random.default_rng(7)
    points = sheet(rng, (45.0, 25.0), (0.0, 0.0, 0.0), size=2.0, count=4_000, noise=0.0)
    broken = np.concatenate([points, points[:500], np.full((3, 3), np.nan)])
    result = surface_fields(PointCloud(broken), 0.3).values
    assert np.abs(result["dip"][:4_500] - 25.0).max() < 1e-3
    assert np.isnan(result["dip"][-3:]).all()


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_invalid_radius_is_refused(radius) -> None:
    with refused("number.not-a-length", UsageError, text=str(radius), field="radius"):
        surface_fields(ball(1.0, 1_000), radius)


def test_radius_without_points_is_refused() -> None:
    with refused("fields.too-few-points", GeometryError, radius_m=1e-4):
        surface_fields(ball(1.0, 1_000), 1e-4)


def test_cloud_without_normals_is_assumed_seen_from_above_with_warning() -> None:
    cloud = ball(1.0, 8_000)
    result: SurfaceFields = surface_fields(PointCloud(cloud.points), 0.3)
    assert "fields.outside-unknown" in by_code(result.warnings)
    assert np.nanmax(result.values["steepness"]) <= 90.0


def test_field_names_contain_radius_and_unit() -> None:
    names = (
        field_name("dip_direction", 0.5),
        field_name("curvature", 2.0, is_metric=False),
        field_name("coplanarity", 0.25),
    )
    assert names == (
        "dip direction, r 0.5 m [°]",
        "curvature, r 2 units [1/units]",
        "coplanarity M, r 0.25 m",
    )


def test_radius_is_checked_against_mesh_face_size() -> None:
    mesh = grid_mesh(np.zeros((30, 30)), 0.5)
    with refused("fields.radius-below-faces", GeometryError) as error:
        surface_fields(mesh, 0.001)
    assert 0.001 < float(str(error.value.values["minimum_m"])) < 0.1
    assert "fields.single-faces" in by_code(surface_fields(mesh, 0.4).warnings)
    assert surface_fields(mesh, 2.0).warnings == ()


def test_points_on_a_line_have_no_dip() -> None:
    """Any plane contains them: a dip would be one of rounding errors."""
    line = np.outer(np.linspace(0.0, 5.0, 2000), [1.0, 1.0, 0.5]) + UTM
    with refused("fields.points-in-line", GeometryError, radius_m=0.3):
        surface_fields(PointCloud(line), 0.3)
    with refused("fields.points-in-line", GeometryError, radius_m=0.3):
        surface_fields(PointCloud(np.repeat(UTM[None], 100, axis=0)), 0.3)
    sheet_points = sheet(
        np.random.default_rng(2),
        (130.0, 35.0),
        tuple(UTM + 20.0),
        size=4.0,
        count=20_000,
        noise=0.0,
    )
    result = surface_fields(PointCloud(np.concatenate([sheet_points, line])), 0.3)
    for values in result.values.values():
        assert np.isnan(values[20_000:]).all()
    assert np.isfinite(result.values["dip"][:20_000]).all()
    assert "fields.few-points" in by_code(result.warnings)
