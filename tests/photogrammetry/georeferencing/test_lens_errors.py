"""What wrong lenses do to a model, judged by Ceres' adjustment and by blocks of known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.messages import with_code
from tests.photogrammetry.georeferencing.test_gps_priors import Flight, block, ground, nadir
from tests.photogrammetry.made_photos import LENS, abreast, face
from vomstudio.geology.bowing import fit_shape_change, model_shape
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import (
    KnownCentre,
    bundle_adjust,
    noise_px,
)
from vomstudio.photogrammetry.georeferencing.lens_errors import (
    LensEffect,
    identity_placement,
    lens_effect,
)
from vomstudio.photogrammetry.georeferencing.lens_response import compute_response
from vomstudio.photogrammetry.georeferencing.world_frame import place_in_world
from vomstudio.registration.similarity import fit_similarity


def exact(views: list[View], points: np.ndarray) -> SparseScene:
    """Every point in all photos that contain it, to the bit."""
    pixels = np.stack([v.project(points) for v in views], 1)
    seen = np.stack([v.contains(pixels[:, i]) for i, v in enumerate(views)], axis=1)
    seen &= (seen.sum(axis=1) >= 3)[:, None]
    kept = seen.any(axis=1)
    count = int(kept.sum())
    return SparseScene(
        tuple(views),
        points[kept],
        np.zeros((count, 3), np.uint8),
        np.zeros(count, np.float32),
        np.concatenate([[0], np.cumsum(seen[kept].sum(axis=1))]).astype(np.int64),
        np.nonzero(seen[kept])[1].astype(np.int32),
        pixels[kept][seen[kept]].astype(np.float32),
    )


def calibrated(scene: SparseScene, focal: str, exif: float | None = 1500.0) -> list[Calibration]:
    names = tuple(view.name for view in scene.views)
    return [Calibration("SIMPLE_RADIAL", (), (), (), (), names, focal, (), exif, 0.0)]


def effect(scene: SparseScene, focal: str = "held", exif: float | None = 1500.0) -> LensEffect:
    found = lens_effect(scene, calibrated(scene, focal, exif), scene.points.mean(axis=0))
    assert found is not None
    return found


def in_truth(scene: SparseScene, truth: np.ndarray) -> SparseScene:
    return place_in_world(scene, fit_similarity(scene.points, truth), (0, 0, 0), None)


def test_response_to_a_wrong_focal_length_matches_a_bundle_adjustment() -> None:
    """Ceres adjusts the same block, with k1 free, from the same lens."""
    scene = exact(nadir((45.0,)), ground(400))
    lens = scene.views[0].intrinsics
    wrong = replace(lens, params=(lens.params[0] * 1.01, *lens.params[1:]))
    begun = tuple(replace(view, intrinsics=wrong) for view in scene.views)
    ceres = bundle_adjust(replace(scene, views=begun), ())
    response = compute_response(scene, noise_px(scene))
    change = np.array([0.01 * lens.params[0], 0.0, 0.0, 0.0])
    change[3] = -response.information[3, 0] * change[0] / response.information[3, 3]
    linear = response.apply_change(change)
    # Heights follow the focal length: only the likeness of both is seen after a similarity.
    left, right = (fit_similarity(s.points, scene.points)(s.points) for s in (ceres, linear))
    moves = np.linalg.norm(left - scene.points, axis=1)
    assert np.median(moves) > 1e-4
    assert np.linalg.norm(left - right, axis=1).max() < 0.05 * moves.max()
    by_ceres, by_us = (s.views[0].intrinsics.params[3] - lens.params[3] for s in (ceres, linear))
    assert by_us == pytest.approx(by_ceres, rel=0.1)


def test_known_camera_positions_reduce_the_effect_of_a_wrong_lens() -> None:
    """Positions to a centimetre hold the shape that photos alone would bend."""
    flight = Flight((40.0, 50.0), LENS, 1500.0)
    scene = in_truth(flight.scene, flight.points)
    cameras = calibrated(scene, "freed")
    centres = [
        KnownCentre(row, view.centre, np.full(3, 0.01)) for row, view in enumerate(flight.views)
    ]
    about = scene.points.mean(axis=0)
    alone = lens_effect(scene, cameras, about)
    tied = lens_effect(scene, cameras, about, identity_placement, centres=centres)
    assert alone is not None
    assert tied is not None
    assert tied.bend.side_deg < 0.3 * alone.bend.side_deg


def test_lens_without_exif_has_a_larger_error_than_one_with_exif() -> None:
    scene = exact(abreast(), face(400))
    with_exif, without = effect(scene), effect(scene, exif=None)
    assert without.bend.stretch_deg > 3.0 * with_exif.bend.stretch_deg
    # Of photos that look straight at a wall, depths follow the focal length: 4 % of it (95 %).
    assert with_exif.bend.stretch95 == pytest.approx(0.04, rel=0.3)


def test_lens_effect_is_none_without_cameras() -> None:
    scene = exact(abreast(), face(400))
    assert lens_effect(scene, (), scene.points.mean(axis=0)) is None


def test_effect_of_a_wrong_lens_is_within_the_stated_error() -> None:
    """A focal length 3 % too long and a principal point 5 pixels off, both held."""
    flight = Flight((45.0,), replace(LENS, params=(1500.0, 805.0, 596.0, -0.05)), 1545.0)
    scene = in_truth(flight.scene, flight.points)
    true = fit_shape_change(flight.points, scene.points - flight.points)
    bend = effect(scene).bend
    side = np.degrees(2.0 * abs(true.curvature_per_m) * model_shape(flight.points)[2])
    assert side < bend.side_deg


@pytest.mark.parametrize(("k2", "word"), [(0.1, "dome"), (-0.1, "dish")])
def test_camera_path_bends_like_the_ground(k2: float, word: str) -> None:
    """Ceres adjusts a block without the k2 that its lens has; positions to a decimetre, too few to
    enter the adjustment, tell what that did to the ground: the way it bends, and how much."""
    params = (1500.0, 800.0, 600.0, -0.05, k2)
    flight = Flight((45.0,), replace(LENS, model="RADIAL", params=params), 1500.0)
    scene = in_truth(flight.scene, flight.points)
    true = fit_shape_change(flight.points, scene.points - flight.points).curvature_per_m
    _, report = flight.placed(0.1, 2.0)
    assert not report.adjusted
    assert report.bowing is not None
    assert true * -np.sign(k2) > 1e-4
    assert report.bowing.curvature_per_m == pytest.approx(true, rel=0.35)
    (finding,) = with_code(report.warnings, "registration.bowed")
    assert f"(a {word})" in finding.values["where"]


@pytest.mark.slow
def test_stated_lens_error_covers_95_percent_of_wrong_lenses() -> None:
    """Walls of photos abreast, whose focal length from EXIF is wrong by 2 % (1 sigma)."""
    rng = np.random.default_rng(5)
    inside = []
    for _ in range(40):
        focal = 1500.0 * (1.0 + rng.normal(0.0, 0.0204))
        lens = replace(LENS, params=(focal, *(rng.normal((800.0, 600.0), 7.0)), -0.05))
        views, points = abreast(12, lens), face(500, seed=int(rng.integers(1 << 30)))
        made = block(views, points, LENS.params)
        truth = points[(sum(v.contains(v.project(points)) for v in views)) >= 3]
        if len(truth) != len(made.points):
            continue
        scene = in_truth(made, truth)
        true = fit_shape_change(truth, scene.points - truth)
        bend = effect(scene).bend
        inside.append(
            [
                abs(true.curvature_per_m) < bend.curvature95_per_m,
                abs(true.stretch) < bend.stretch95,
            ]
        )
    assert len(inside) >= 20
    assert np.mean(inside, axis=0).min() >= 0.9
