"""A patch as a surface: against self-affine surfaces of known exponent, grooves of known direction,
and a plane that is known to end."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.extraction.planes_by_construction import angle_deg, axes_of, normal_of
from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geology.roughness import increments
from vomstudio.geology.roughness.planar_part import find_planar_part
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.surface.analysis import analyse
from vomstudio.products.surface.patch import extract_facet, extract_within_radius
from vomstudio.products.surface.surface_options import SurfaceOptions

Array = np.ndarray
ATTITUDE = (130.0, 60.0)
PLACE = np.array([4.0e5, 5.0e6, 300.0])


def self_affine(n: int, exponent: float, rng: np.random.Generator) -> Array:
    """(n, n) of fractional Brownian motion with unit variance of first differences, exact by the
    intrinsic embedding of Stein (2002, Journal of Computational and Graphical Statistics 11, 587),
    for exponents of at most 0.9."""
    m, reach, alpha = 2 * n, 2.0, 2.0 * exponent
    if alpha <= 1.5:
        beta, c2 = 0.0, alpha / 2.0
        c0 = 1.0 - c2
    else:
        beta = alpha * (2.0 - alpha) / (3.0 * reach * (reach**2 - 1.0))
        c2 = (alpha - beta * (reach - 1.0) ** 2 * (reach + 2.0)) / 2.0
        c0 = beta * (reach - 1.0) ** 3 + 1.0 - c2
    t = np.linspace(0.0, reach, m)
    r = np.hypot(*np.meshgrid(t, t))
    far = beta * (reach - r) ** 3 / np.where(r > 0, r, 1.0)
    g = np.where(r <= 1, c0 - r**alpha + c2 * r**2, np.where(r <= reach, far, 0.0))
    whole = np.block([[g, g[:, -2:0:-1]], [g[-2:0:-1], g[-2:0:-1, -2:0:-1]]])
    power = np.fft.fft2(whole).real / whole.size
    assert power.min() > -1e-5 * power.max()
    z = rng.standard_normal(whole.shape) + 1j * rng.standard_normal(whole.shape)
    field = np.fft.fft2(np.sqrt(np.maximum(power, 0.0)) * z).real[:m, :m]
    tilt = math.sqrt(2.0 * c2) * rng.standard_normal(2)
    field = field - field[0, 0] + t[:, None] * tilt[0] + t[None, :] * tilt[1]
    return field[:n, :n] / np.sqrt(np.mean(np.diff(field[:n, :n], axis=0) ** 2))


def mesh_over(heights: Array, step: float, attitude: tuple[float, float] = ATTITUDE) -> Mesh:
    """Heights along the normal, columns along the strike's opposite, rows down the dip."""
    rows, columns = heights.shape
    y, x = np.mgrid[0:rows, 0:columns] * step
    u, v = axes_of(*attitude)
    points = PLACE + x.reshape(-1, 1) * u + y.reshape(-1, 1) * v
    points = points + heights.reshape(-1, 1) * normal_of(*attitude)
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    one = np.stack([a, a + 1, a + columns], axis=1)
    two = np.stack([a + 1, a + columns + 1, a + columns], axis=1)
    return Mesh(points, np.concatenate([one, two]).astype(np.int32))


def grooves(n: int, step: float, angle: float, wave: float, height: float) -> Array:
    y, x = np.mgrid[0:n, 0:n] * step
    across = math.radians(angle + 90)
    phase = (x * math.cos(across) + y * math.sin(across)) / wave
    return height * np.cos(2 * math.pi * phase)


@pytest.mark.parametrize("exponent", first_in_default_tier([0.4, 0.8]))
def test_exponent_of_a_self_affine_surface_is_recovered(exponent: float) -> None:
    rng = np.random.default_rng(1)
    result, held = [], 0
    for _ in range(12):
        seen = increments.measure_variations(self_affine(128, exponent, rng), 0.02, 0.05)
        one = increments.fit_exponent(seen, 0.0)
        result.append(one.H)
        held += abs(one.H - exponent) <= one.error95
        assert one.error95 < 0.15
    assert np.mean(result) == pytest.approx(exponent, abs=0.02)
    assert held >= 10


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [0.3, 0.6, 0.8])
def test_stated_error_contains_the_exponent_and_no_direction_is_falsely_significant(
    exponent: float,
) -> None:
    rng = np.random.default_rng(2)
    runs, held, claimed, result = 200, 0, 0, []
    for _ in range(runs):
        seen = increments.measure_variations(self_affine(128, exponent, rng), 1.0, 2.0)
        one = increments.fit_exponent(seen, 0.0)
        result.append(one.H)
        held += abs(one.H - exponent) <= one.error95
        claimed += increments.find_smoothest_direction(seen, 0.0).is_significant
    assert np.mean(result) == pytest.approx(exponent, abs=0.01)
    assert 0.91 <= held / runs <= 0.99
    assert claimed / runs <= 0.03


@pytest.mark.full
def test_surfaces_without_a_direction_have_no_significant_one() -> None:
    rng = np.random.default_rng(3)
    claimed = [
        increments.find_smoothest_direction(
            increments.measure_variations(self_affine(96, 0.7, rng), 1.0, 2.0), 0.0
        ).is_significant
        for _ in range(20)
    ]
    assert sum(claimed) <= 1


@pytest.mark.parametrize("angle", first_in_default_tier([20.0, 75.0, 170.0]))
def test_groove_direction_is_found_within_the_stated_error(angle: float) -> None:
    rng = np.random.default_rng(4)
    held, off = 0, []
    for _ in range(8):
        rough = self_affine(128, 0.6, rng)
        seen = increments.measure_variations(rough + grooves(128, 1.0, angle, 14.0, 3.0), 1.0, 2.0)
        one = increments.find_smoothest_direction(seen, 0.0)
        assert one.is_significant
        off.append((one.angle_deg - angle + 90) % 180 - 90)
        held += abs(off[-1]) <= one.error95_deg
        assert one.error95_deg < 6
    assert abs(np.mean(off)) < 1.5
    assert held >= 7


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_groove_direction_on_a_dipping_face_is_a_line_in_world(turn: float) -> None:
    attitude = (ATTITUDE[0] + turn, ATTITUDE[1])
    rng = np.random.default_rng(5)
    heights = 0.002 * self_affine(128, 0.6, rng) + grooves(128, 0.05, 40.0, 0.7, 0.012)
    result = analyse(mesh_over(heights, 0.05, attitude), noise_m=0.0005)
    u, v = axes_of(*attitude)
    truth = math.cos(math.radians(40)) * u + math.sin(math.radians(40)) * v
    line = result.smoothest
    t, p = math.radians(line.trend_deg), math.radians(line.plunge_deg)
    seen = np.array([math.sin(t) * math.cos(p), math.cos(t) * math.cos(p), -math.sin(p)])
    assert angle_deg(truth, seen) <= line.error95_deg + 0.5
    assert line.error95_deg < 6
    assert line.ratio > 1.3
    along, across = result.profiles
    assert along.deviation_m.std() < 0.7 * across.deviation_m.std()
    assert ((along.points[-1] - along.points[0]) / np.ptp(along.distance_m)) @ seen == (
        pytest.approx(1.0, abs=0.01)
    ) or ((along.points[0] - along.points[-1]) / np.ptp(along.distance_m)) @ seen == (
        pytest.approx(1.0, abs=0.01)
    )


def test_deviations_are_the_heights_over_the_plane() -> None:
    heights = grooves(120, 0.05, 0.0, 1.0, 0.03)
    result = analyse(mesh_over(heights, 0.05))
    assert (
        angle_deg(
            normal_of(result.plane["dip_direction_deg"], result.plane["dip_deg"]),
            normal_of(*ATTITUDE),
        )
        < 0.1
    )
    assert result.rms_m == pytest.approx(0.03 / math.sqrt(2), rel=0.02)
    assert result.highest_m == pytest.approx(0.03, rel=0.05)
    assert result.lowest_m == pytest.approx(-0.03, rel=0.05)
    assert result.point_deviations == pytest.approx(heights.ravel() - heights.mean(), abs=0.002)
    assert result.trim is None
    rows, columns = result.deviations.shape
    assert result.cells == np.isfinite(result.deviations).sum() > 0.9 * rows * columns


def test_white_noise_and_a_perfect_plane_have_no_exponent_and_no_direction() -> None:
    rng = np.random.default_rng(6)
    y, x = (a.ravel() for a in np.mgrid[0:120, 0:120] * 0.05)
    u, v = axes_of(*ATTITUDE)
    flat = PLACE + x[:, None] * u + y[:, None] * v
    noisy = flat + 0.01 * rng.standard_normal((len(x), 1)) * normal_of(*ATTITUDE)
    result = analyse(PointCloud(noisy))
    assert result.noise_from == "points"
    assert result.noise_m == pytest.approx(0.01, rel=0.1)
    assert result.hurst is None
    assert result.hurst_reason.code == "roughness.below-noise"
    assert result.smoothest is None
    exact = analyse(mesh_over(np.zeros((100, 100)), 0.05))
    assert exact.noise_from == "mesh"
    assert exact.hurst is None
    assert exact.smoothest is None


def test_mesh_with_roughness_below_its_edges_has_no_exponent_unless_noise_is_given() -> None:
    rough = 0.002 * self_affine(128, 0.7, np.random.default_rng(7))
    mesh = mesh_over(rough, 0.05)
    assert analyse(mesh).hurst is None
    inputs = analyse(mesh, noise_m=0.00005)
    assert pytest.approx(0.7, abs=max(inputs.hurst.error95, 0.1)) == inputs.hurst.H
    assert len(inputs.hurst.directions) == increments.N_DIRECTIONS


def test_a_smooth_bend_has_no_exponent() -> None:
    y, x = np.mgrid[0:130, 0:130] * 0.05
    result = analyse(mesh_over(0.02 * (x - 3) ** 2 + 0.01 * (y - 3) ** 2, 0.05), noise_m=1e-5)
    assert result.hurst is None
    assert result.hurst_reason.code == "roughness.invalid-exponent"


@pytest.mark.parametrize("seed", [0, 1])
def test_grooves_of_one_wavelength_have_no_exponent(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:120, 0:120] * 0.03
    heights = 0.02 * np.sin(2 * np.pi * (0.5 * x + 0.87 * y) / 0.4)
    result = analyse(mesh_over(heights + 0.001 * rng.standard_normal(x.shape), 0.03), noise_m=0.001)
    assert result.hurst is None
    assert result.hurst_reason.code == "roughness.several-exponents"
    assert result.smoothest is not None


def test_exact_plane_is_reported_as_flat() -> None:
    rng = np.random.default_rng(0)
    u, v = axes_of(*ATTITUDE)
    result = analyse(PointCloud(rng.uniform(-2, 2, (8000, 2)) @ np.stack([u, v])))
    assert result.hurst is None
    assert result.smoothest is None
    assert result.trim is None
    for reason in (result.hurst_reason, result.smoothest_reason):
        assert reason.code == "roughness.flat"


def test_edge_of_the_plane_is_found_and_trimming_restores_its_attitude() -> None:
    rng = np.random.default_rng(8)
    n, step = 120, 0.05
    heights = 0.003 * rng.standard_normal((n, n))
    # From column 90 on the face bends away by 20 degrees.
    x = np.arange(n) * step
    heights += np.maximum(x - 90 * step, 0.0) * math.tan(math.radians(20))
    result = analyse(mesh_over(heights, step), noise_m=0.003)
    assert result.trim is not None
    assert result.trim.share == pytest.approx(0.25, abs=0.04)
    normal = normal_of(result.trim.plane["dip_direction_deg"], result.trim.plane["dip_deg"])
    whole = normal_of(result.plane["dip_direction_deg"], result.plane["dip_deg"])
    assert angle_deg(normal, normal_of(*ATTITUDE)) < 0.1
    assert result.trim.turn_deg == pytest.approx(angle_deg(normal, whole), abs=1e-6)
    assert result.trim.turn_deg > 1.0
    holds = result.holds.reshape(n, n)
    assert holds[:, :88].all()
    assert not holds[:, 96:].any()


@pytest.mark.full
def test_rough_planar_surface_is_not_trimmed() -> None:
    rng = np.random.default_rng(9)
    trims = [find_planar_part(self_affine(96, 0.5, rng), 0.0).is_trimmed for _ in range(20)]
    assert sum(trims) <= 2


@pytest.mark.parametrize(("share", "slope"), [(0.3, 1.0), (0.35, 0.2), (0.4, 0.1), (0.5, 0.2)])
def test_plane_is_fitted_to_the_larger_part_only(share: float, slope: float) -> None:
    rng = np.random.default_rng(11)
    n, step = 100, 0.04
    x = np.arange(n) * step
    start = (1.0 - share) * n * step
    heights = 0.002 * rng.standard_normal((n, n)) + slope * np.maximum(x - start, 0.0)
    result = analyse(mesh_over(heights, step), noise_m=0.002)
    assert result.trim is not None
    assert result.trim.share == pytest.approx(share, abs=0.05)
    normal = normal_of(result.trim.plane["dip_direction_deg"], result.trim.plane["dip_deg"])
    bend = math.degrees(math.atan(slope))
    off = angle_deg(normal, normal_of(*ATTITUDE))
    assert min(off, abs(off - bend)) < 0.15
    assert by_code(result.warnings)["patch.two-planes"]["angle_deg"] == pytest.approx(bend, abs=0.3)


@pytest.mark.parametrize("exponent", first_in_default_tier([0.5, 0.8]))
def test_rough_and_bent_surfaces_are_not_reported_as_two_planes(exponent: float) -> None:
    rng = np.random.default_rng(12)
    for _ in range(8):
        assert find_planar_part(self_affine(72, exponent, rng), 0.0).remaining_plane is None
    y, x = np.mgrid[0:72, 0:72] / 72.0
    for curve in (0.2 * x**2, 0.2 * (x**2 + y**2), 0.02 * np.sin(12.0 * x + 3.0 * y)):
        result = find_planar_part(curve + 0.002 * rng.standard_normal(x.shape), 0.002)
        assert result.remaining_plane is None
        assert not result.is_trimmed


def test_part_of_a_model_is_selected_and_invalid_input_is_rejected() -> None:
    mesh = mesh_over(0.01 * np.random.default_rng(10).standard_normal((80, 80)), 0.05)
    middle = mesh.vertices.mean(axis=0)
    part = extract_within_radius(mesh, middle, 1.0)
    assert np.linalg.norm(part.vertices - middle, axis=1).max() <= 1.0
    assert len(part.faces) == pytest.approx(math.pi / 0.05**2 * 2, rel=0.1)
    with refused("patch.empty"):
        extract_within_radius(mesh, middle + 100, 1.0)
    with refused("facet.no-field", field="--facet"):
        extract_facet(mesh, 0)
    with refused("patch.too-small", GeometryError):
        analyse(extract_within_radius(mesh, middle, 0.15))
    with pytest.raises(UsageError) as error:
        SurfaceOptions(noise_m=-1.0)
    assert (error.value.code, error.value.field) == ("option.out-of-range", "--noise")
    with refused("raster.too-many-cells", UsageError, field="--gsd"):
        analyse(mesh, cell_m=0.0005)
    with pytest.raises(GeometryError):
        analyse(PointCloud(np.zeros((50, 3))))


@pytest.mark.full
@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_irregular_points_give_the_exponent_of_the_surface(hurst: float) -> None:
    """A map that is drawn from point to point is smoother than what lies between them. Heights are
    exact, of a spectrum of which every fourth place is taken: it has all of the short waves."""
    result = []
    for seed in range(4):
        chance = np.random.default_rng(seed)
        side = np.fft.fftfreq(960)
        k = np.hypot(side[:, None], side[None, :])
        k[0, 0] = 1.0
        waves = np.fft.fft2(chance.standard_normal((960, 960))) * k ** -(hurst + 1.0)
        waves[0, 0] = 0.0
        heights = np.fft.ifft2(waves).real[:640:4, :640:4]
        heights *= 0.03 / heights.std()
        y, x = np.mgrid[0:160, 0:160] * 0.025
        points = np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
        selection = chance.permutation(len(points))[: len(points) // 3]
        output = analyse(PointCloud(points[selection]), noise_m=0.0002)
        assert output.hurst is not None
        result.append(output.hurst.H)
    assert np.mean(result) == pytest.approx(hurst, abs=0.05)
