"""Scenes placed by the positions of their cameras."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import refused, with_code
from tests.photogrammetry.made_photos import LENS, ORIGIN, Made, MadePhoto, face, looking
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.align.mapping import residuals
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.georeference import (
    ABOVE_ELLIPSOID,
    ABOVE_SEA_LEVEL,
    place_by_gps,
)
from vomstudio.registration.similarity import Similarity

ARBITRARY = Similarity(
    0.13, Rotation.from_euler("xyz", [20, 130, 75], degrees=True).as_matrix(), np.array([3.0, 2, 1])
)


def scene_of(views: list[View], points: np.ndarray) -> SparseScene:
    """Everything seen by everything, exactly, in a frame of its own."""
    n, v = len(points), len(views)
    pixels = np.stack([view.project(points) for view in views], axis=1)
    return SparseScene(
        tuple(v.moved(ARBITRARY.scale, ARBITRARY.rotation, ARBITRARY.translation) for v in views),
        ARBITRARY(points),
        np.zeros((n, 3), np.uint8),
        np.zeros(n, np.float32),
        np.arange(0, n * v + 1, v),
        np.tile(np.arange(v, dtype=np.int32), n),
        pixels.reshape(-1, 2).astype(np.float32),
    )


def flight(width: float = 60, rows: int = 3, columns: int = 5) -> list[View]:
    """Over the ground, looking down."""
    places = [
        (x, y, 40.0 + (i + j) % 2)
        for i, x in enumerate(np.linspace(-width / 2, width / 2, columns))
        for j, y in enumerate(np.linspace(-width / 3, width / 3, rows))
    ]
    return [
        looking(place, (place[0], place[1], 0), LENS, f"{i:02d}.jpg")
        for i, place in enumerate(places)
    ]


def made(views: list[View], points: np.ndarray | None = None) -> Made:
    photos = [MadePhoto(Path(view.name), view.name) for view in views]
    return Made(photos, [], views, face(60) if points is None else points)


def level() -> np.ndarray:
    """Ground below a flight, as wide as that."""
    x, y = np.meshgrid(np.linspace(-30, 30, 9), np.linspace(-20, 20, 7))
    return np.column_stack([x.ravel(), y.ravel(), 0.3 * np.sin(x.ravel() + 2 * y.ravel())])


def test_good_positions_place_the_scene() -> None:
    ground = made(flight())
    scene, report = place_by_gps(scene_of(ground.views, ground.points), ground.with_gps(0.0))
    assert scene.crs == "EPSG:32632" == report.crs
    assert scene.scaled
    assert report.scale == pytest.approx(1 / 0.13)
    assert scene.points + scene.origin == pytest.approx(ground.points + ORIGIN, abs=2e-4)
    assert all(isinstance(value, int) for value in scene.origin)
    assert np.abs(scene.points).max() < 300
    # The pictures of the points stay where they are.
    assert np.nanmax(np.abs(residuals(scene))) < 1e-2
    assert report.tilt_error_deg < 0.01
    assert not report.warnings
    assert report.heights == ABOVE_SEA_LEVEL


def test_crs_can_be_requested() -> None:
    ground = made(flight())
    photos = ground.with_gps(0.0)
    scene, _ = place_by_gps(scene_of(ground.views, ground.points), photos, "EPSG:25832")
    assert scene.points + scene.origin == pytest.approx(ground.points + ORIGIN, abs=0.01)
    with pytest.raises(InputError):
        place_by_gps(scene, photos, "EPSG:4326")


@pytest.mark.full
def test_noise_is_estimated_and_predicts_the_actual_tilt() -> None:
    ground = made(flight())
    tilts, stated = [], []
    for seed in range(30):
        photos = ground.with_gps(2.0, seed=seed)
        scene, report = place_by_gps(scene_of(ground.views, ground.points), photos)
        turned = scene.views[0].rotation.T @ ground.views[0].rotation
        vector = np.degrees(Rotation.from_matrix(turned).as_rotvec())
        tilts.append(np.hypot(vector[0], vector[1]))
        stated.append(report.tilt_error_deg)
    assert np.sqrt(np.mean(np.square(tilts))) == pytest.approx(np.mean(stated), rel=0.35)
    assert 1.5 < report.sigma_m < 2.6


def test_covariance_contains_the_stated_rotations_and_is_centred_on_the_cameras() -> None:
    ground = made(flight(), level())
    _, report = place_by_gps(scene_of(ground.views, ground.points), ground.with_gps(2.0, seed=1))
    turns = np.degrees(np.sqrt(np.diag(report.covariance)[:3]))
    assert turns == pytest.approx(report.rotation_error_deg)
    assert np.sqrt(report.covariance[3, 3]) == pytest.approx(report.scale_error)
    assert report.centre == pytest.approx(report.positions.mean(axis=0))
    assert report.bowing is not None
    assert report.bowing.side_error95_deg > 1.0


def test_bowing_of_a_block_is_reported_in_degrees() -> None:
    """Cameras that stand 2 mm m^-2 too low at the edges: 2 c r is 8 degrees at 36 m."""
    ground = made(flight(), level())
    photos = []
    for photo, view in zip(ground.with_gps(0.03, seed=2), ground.views, strict=True):
        x, y = view.centre[:2]
        assert photo.altitude_m is not None
        photos.append(replace(photo, altitude_m=photo.altitude_m + 0.002 * (x * x + y * y)))
    _, report = place_by_gps(scene_of(ground.views, ground.points), photos)
    bowing = report.bowing
    assert bowing is not None
    # The model less the positions: the other way round.
    assert bowing.curvature_per_m == pytest.approx(-0.002, rel=0.1)
    assert bowing.side_deg == pytest.approx(np.degrees(2 * 0.002 * 36.06), rel=0.1)
    assert with_code(report.warnings, "registration.bowed")


def test_small_face_with_phone_gps_reports_a_tilt_error_of_many_degrees() -> None:
    views = [
        looking((x, -20.0 - 6 * (i % 2), 1.6), (x / 2, 0, 2), LENS, f"{i}.jpg")
        for i, x in enumerate(np.linspace(-15, 15, 12))
    ]
    wall = made(views)
    _, report = place_by_gps(scene_of(wall.views, wall.points), wall.with_gps(3.0, stated=4.5))
    assert 8 < report.tilt_error_deg < 35
    assert with_code(report.warnings, "registration.weak-rotation")


def test_gps_outlier_is_left_out_and_reported() -> None:
    ground = made(flight())
    photos = ground.with_gps(0.5)
    photos[4] = replace(photos[4], latitude_deg=photos[4].latitude_deg + 0.01)
    scene, report = place_by_gps(scene_of(ground.views, ground.points), photos)
    assert [n for n, used in zip(report.names, report.used, strict=True) if not used] == ["04.jpg"]
    (finding,) = with_code(report.warnings, "cameras.left-out")
    assert finding.values["photos"] == ("04.jpg",)
    assert np.abs(scene.points + scene.origin - ground.points - ORIGIN).max() < 2


def test_insufficient_gps_positions_are_rejected_with_the_reason() -> None:
    ground = made(flight())
    scene = scene_of(ground.views, ground.points)
    photos = ground.with_gps(0.0)
    with refused("gps-few", GeometryError):
        place_by_gps(scene, ground.photos)
    with refused("gps-few", GeometryError):
        place_by_gps(scene, photos[:2] + ground.photos[2:])
    same = [
        replace(
            p,
            latitude_deg=photos[0].latitude_deg,
            longitude_deg=photos[0].longitude_deg,
            altitude_m=photos[0].altitude_m,
        )
        for p in photos
    ]
    with refused("gps-equal", GeometryError):
        place_by_gps(scene, same)
    with refused("gps.imprecise", GeometryError):
        place_by_gps(scene, ground.with_gps(40.0, stated=60.0))


def test_cameras_on_a_line_are_refused() -> None:
    views = [
        looking((x, -12, 2), (x, 0, 2), LENS, f"{i}.jpg")
        for i, x in enumerate(np.linspace(-30, 30, 8))
    ]
    wall = made(views)
    with refused("collinear", GeometryError):
        place_by_gps(scene_of(wall.views, wall.points), wall.with_gps(0.0))
    with refused("collinear", GeometryError):
        place_by_gps(scene_of(wall.views, wall.points), wall.with_gps(3.0))


def test_ellipsoidal_heights_are_reported_as_ellipsoidal() -> None:
    ground = made(flight())
    photos = [replace(p, altitude_reference="ellipsoid") for p in ground.with_gps(0.1)]
    _, report = place_by_gps(scene_of(ground.views, ground.points), photos)
    assert report.heights == ABOVE_ELLIPSOID


def test_southern_hemisphere_uses_its_own_utm_zones() -> None:
    ground = made(flight())
    photos = [replace(p, latitude_deg=-p.latitude_deg) for p in ground.with_gps(0.1)]
    from vomstudio.photogrammetry.georeferencing.georeference import select_crs

    assert select_crs(photos, None) == "EPSG:32732"
