"""Worked examples of others: Umeyama's own, and those of IOGP's Geomatics Guidance Note 7-2."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.io.gis.crs import degrees_to_grid
from vomstudio.registration.placing import register_points
from vomstudio.registration.similarity import fit_similarity


def test_umeyama_example_gives_a_rotation_without_reflection() -> None:
    """Umeyama 1991, section V: three points of the plane whose best fit by any matrix is a mirror
    image; the best rotation, shift and scale are printed to three decimals. Here they are the ends
    of a prism along z, which no turn in space may lay over."""
    plane = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]])
    target = np.array([[0.0, 0.0], [-1.0, 0.0], [0.0, 2.0]])
    scale, height = 0.721, 10.0
    ends = np.repeat([height, -height], 3)
    model = np.column_stack([np.tile(plane, (2, 1)), ends])
    world = np.column_stack([np.tile(target, (2, 1)), scale * ends])
    fit = fit_similarity(model, world)
    assert fit.rotation[:2, :2] == pytest.approx(
        np.array([[0.832, 0.555], [-0.555, 0.832]]), abs=6e-4
    )
    assert fit.translation[:2] == pytest.approx([-0.800, 0.400], abs=6e-4)
    assert fit.scale == pytest.approx(scale, abs=6e-4)
    assert np.linalg.det(fit.rotation) == pytest.approx(1.0)


def test_wgs_72_to_wgs_84_matches_the_published_point() -> None:
    """Guidance Note 7-2, Position Vector transformation: dz 4.5 m, rz 0.554 seconds of arc, scale
    0.219 ppm. A registration finds these numbers again by points that were moved by them, as far
    from the origin as the Earth is large, and takes the published point to the published one."""
    rz, scale, shift = np.radians(0.554 / 3600.0), 1.0 + 0.219e-6, np.array([0.0, 0.0, 4.5])
    turn = np.array([[1.0, -rz, 0.0], [rz, 1.0, 0.0], [0.0, 0.0, 1.0]])
    model = 6.37e6 * np.array(
        [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0.6, 0.0, 0.8]], float
    )
    placed = register_points(model, scale * model @ turn.T + shift)
    there = placed([3657660.66, 255768.55, 5201382.11])
    assert there == pytest.approx([3657660.78, 255778.43, 5201387.75], abs=0.01)
    assert placed.scale - 1.0 == pytest.approx(0.219e-6, abs=1e-9)
    assert placed.matrix[1, 0] == pytest.approx(rz, abs=1e-9)


@pytest.mark.parametrize(
    ("crs", "base", "longitude", "latitude", "east", "north"),
    [
        # Transverse Mercator: OSGB 1936 / British National Grid, 50°30'N 0°30'E.
        ("EPSG:27700", "EPSG:4277", 0.5, 50.5, 577274.99, 69740.50),
        # Lambert conic conformal, one standard parallel: JAD69 / Jamaica National Grid,
        # 17°55'55.80"N 76°56'37.26"W.
        ("EPSG:24200", "EPSG:4242", -76.943683333, 17.932166667, 255966.58, 142493.51),
        # Lambert azimuthal equal area: ETRS89 / LAEA Europe, 50°N 5°E.
        ("EPSG:3035", "EPSG:4258", 5.0, 50.0, 3962799.45, 2999718.85),
    ],
)
def test_projected_positions_match_the_guidance_note(
    crs: str, base: str, longitude: float, latitude: float, east: float, north: float
) -> None:
    there = degrees_to_grid(crs, base)(longitude, latitude)
    assert there is not None
    assert there[:2] == pytest.approx((east, north), abs=0.01)
