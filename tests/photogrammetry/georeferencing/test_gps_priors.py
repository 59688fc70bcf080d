"""Positions of cameras in the adjustment, judged by scenes whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.messages import with_code
from tests.photogrammetry.georeferencing.test_georeference import ARBITRARY
from tests.photogrammetry.made_photos import LENS, ORIGIN, Made, MadePhoto, looking
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.georeference import GpsReport, place_by_gps
from vomstudio.photogrammetry.georeferencing.ground_adjustment import bundle_adjust
from vomstudio.registration.similarity import fit_similarity


def ground(count: int = 700) -> np.ndarray:
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-42, 42, (2, count))
    z = np.sin(x / 9) * np.cos(y / 7) + rng.normal(0, 0.3, count)
    return np.column_stack([x, y, z])


def nadir(levels: tuple[float, ...] = (40.0, 50.0)) -> list[View]:
    """A block of 5 by 4 photos that look down, flown at some heights."""
    return [
        looking(
            (x, y, levels[(i + j) % len(levels)]),
            (x + 0.3 * (i * j % 3 - 1), y + 0.4 * (i % 2), 0),
            LENS,
            f"{i}{j}.jpg",
        )
        for i, x in enumerate(np.linspace(-30, 30, 5))
        for j, y in enumerate(np.linspace(-20, 20, 4))
    ]


def block(views: list[View], points: np.ndarray, params: tuple[float, ...]) -> SparseScene:
    """What an alignment with a lens of these parameters, held but for k1, finds of it."""
    rng = np.random.default_rng(1)
    pixels = np.stack([v.project(points) + rng.normal(0, 0.3, (len(points), 2)) for v in views], 1)
    seen = np.stack([v.contains(pixels[:, i]) for i, v in enumerate(views)], axis=1)
    seen &= np.isfinite(pixels).all(axis=2)
    seen[seen.sum(axis=1) < 3] = False
    kept = seen.any(axis=1)
    lens = replace(LENS, params=params)
    turned = [
        replace(v, intrinsics=lens).moved(
            ARBITRARY.scale, ARBITRARY.rotation, ARBITRARY.translation
        )
        for v in views
    ]
    count = int(kept.sum())
    scene = SparseScene(
        tuple(turned),
        ARBITRARY(points[kept]),
        np.zeros((count, 3), np.uint8),
        np.zeros(count, np.float32),
        np.concatenate([[0], np.cumsum(seen[kept].sum(axis=1))]).astype(np.int64),
        np.nonzero(seen[kept])[1].astype(np.int32),
        pixels[kept][seen[kept]].astype(np.float32),
    )
    return bundle_adjust(scene, ())


class Flight:
    """views, points : the truth; scene : as it was aligned with a focal length, 5 % too long"""

    def __init__(
        self, levels: tuple[float, ...], lens: Intrinsics = LENS, focal: float = 1575.0
    ) -> None:
        self.views = [replace(view, intrinsics=lens) for view in nadir(levels)]
        points = ground()
        seen = sum(v.contains(v.project(points)).astype(int) for v in self.views)
        self.scene = block(self.views, points, (focal, 800.0, 600.0, -0.05))
        self.points = points[seen >= 3][: len(self.scene.points)]
        photos = [MadePhoto(Path(v.name), v.name) for v in self.views]
        self.made = Made(photos, [], self.views, points)

    def heights(self, scene: SparseScene) -> np.ndarray:
        return np.asarray(scene.points[:, 2] + scene.origin[2] - self.points[:, 2] - ORIGIN[2])

    def shape(self, scene: SparseScene) -> float:
        """Root mean square error after a similarity."""
        truth = self.points
        miss = fit_similarity(scene.points, truth)(scene.points) - truth
        return float(np.sqrt((miss**2).sum(axis=1).mean()))

    def placed(self, noise_m: float, stated: float | None) -> tuple[SparseScene, GpsReport]:
        return place_by_gps(self.scene, self.made.with_gps(noise_m, stated=stated), threads=1)


@pytest.fixture(scope="module")
def flight() -> Flight:
    return Flight((40.0, 50.0))


def test_centimetre_positions_determine_the_focal_length_of_a_nadir_block(flight: Flight) -> None:
    scene, report = flight.placed(0.02, 0.03)
    assert report.adjusted
    assert scene.views[0].intrinsics.focal[0] == pytest.approx(1500, rel=0.004)
    assert with_code(report.decisions, "lens.ground-estimated")
    # 5 % of 45 m are 2 m.
    assert abs(np.median(flight.heights(scene))) < 0.1
    assert flight.shape(scene) < 0.6 * flight.shape(flight.scene)
    assert np.mean(scene.errors_px) < np.mean(flight.scene.errors_px) + 0.005
    assert report.rms_m < 0.06


def test_metre_positions_leave_the_shape_unchanged(flight: Flight) -> None:
    scene, report = flight.placed(3.0, None)
    assert not report.adjusted
    assert report.decisions[0].code == "gps.not-useful"
    assert flight.shape(scene) == pytest.approx(flight.shape(flight.scene), rel=1e-6)
    assert np.mean(scene.errors_px) == pytest.approx(np.mean(flight.scene.errors_px), rel=1e-3)
    assert scene.views[0].intrinsics == flight.scene.views[0].intrinsics


def test_positions_with_too_small_stated_errors_are_downweighted(flight: Flight) -> None:
    scene, _ = flight.placed(3.0, 0.03)
    assert flight.shape(scene) < 1.05 * flight.shape(flight.scene)
    assert np.mean(scene.errors_px) < 1.02 * np.mean(flight.scene.errors_px)
    assert scene.views[0].intrinsics == flight.scene.views[0].intrinsics


def test_gps_outlier_does_not_move_the_scene(flight: Flight) -> None:
    photos = flight.made.with_gps(0.02, stated=0.03)
    photos[7] = replace(photos[7], altitude_m=photos[7].altitude_m + 50.0)
    scene, report = place_by_gps(flight.scene, photos, threads=1)
    assert report.adjusted
    assert [n for n, u in zip(report.names, report.used, strict=True) if not u] == [photos[7].name]
    truth = np.array([v.centre for v in flight.views]) + ORIGIN
    assert np.linalg.norm(scene.centres + scene.origin - truth, axis=1).max() < 0.1
    assert abs(np.median(flight.heights(scene))) < 0.1


def test_decimetre_positions_at_one_height_do_not_free_the_focal_length() -> None:
    level = Flight((45.0,))
    scene, report = level.placed(0.1, 0.15)
    assert scene.views[0].intrinsics.focal[0] == 1575.0
    (finding,) = with_code(report.decisions, "lens.ground-held")
    assert finding.values["focal_px"] == 1575.0


def test_bowing_from_an_incomplete_lens_model_is_corrected() -> None:
    bent = Intrinsics("RADIAL", 1600, 1200, (1500.0, 800.0, 600.0, -0.05, 0.03))
    flat = Flight((45.0,), bent, 1500.0)

    def dome(scene: SparseScene) -> float:
        distance = (flat.points[:, :2] ** 2).sum(axis=1)
        return float(np.polyfit(distance, flat.heights(scene), 1)[0] * 36**2)

    free, report = flat.placed(3.0, None)
    tied, better = flat.placed(0.02, 0.03)
    assert not report.adjusted
    assert better.adjusted
    assert abs(dome(free)) > 0.3
    assert abs(dome(tied)) < 0.06
    assert flat.shape(tied) < 0.25 * flat.shape(free)


def test_same_positions_give_identical_results(flight: Flight) -> None:
    one, _ = flight.placed(0.02, 0.03)
    two, _ = flight.placed(0.02, 0.03)
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.centres, two.centres)
