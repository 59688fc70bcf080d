"""A model and its photos: what is seen where."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.geometry.test_raytree import CORNER, rough_sheet
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.io.photos.cameras_file import Cameras
from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

ORIGIN = (364_000, 4_721_000, 800)
LENS = Intrinsics(
    "OPENCV", 1500, 1000, (1150.0, 1152.0, 752.6, 498.1, -0.09, 0.03, 0.0008, -0.0005)
)


def looking(name: str, centre: np.ndarray, target: np.ndarray) -> View:
    """A view in coordinates minus ORIGIN, upright against the x axis."""
    forward = (target - centre) / np.linalg.norm(target - centre)
    right = np.cross(forward, [0.3, 1.0, 0.2])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return View(name, LENS, rotation, -rotation @ (centre - np.array(ORIGIN)))


def sheet_and_photos() -> tuple[Mesh, PhotoViews]:
    mesh = rough_sheet()
    middle = CORNER + [19.5, 19.5, 0]
    views = tuple(
        looking(f"{i}.jpg", middle + np.array(shift, float), middle)
        for i, shift in enumerate([(0, 0, 25), (12, 3, 22), (-14, 5, 24), (4, -18, 20)])
    )
    return mesh, PhotoViews(Cameras(views, Path("."), ORIGIN, "EPSG:32633"), RayTree(mesh))


def test_picking_through_the_lens_returns_the_visible_point() -> None:
    mesh, photos = sheet_and_photos()
    rng = np.random.default_rng(3)
    rows = rng.integers(0, len(mesh.faces), 200)
    weights = rng.dirichlet([1, 1, 1], 200)
    world = np.einsum("ij,ijk->ik", weights, mesh.vertices[mesh.faces[rows]])
    checked = 0
    for view in range(4):
        pixels = photos.pixels(view, world)
        for i in np.flatnonzero(photos.shows(view, world, slack_m=1e-6)):
            seen = photos.pick(view, pixels[i])
            assert seen is not None
            assert np.abs(seen.position - world[i]).max() < 1e-6
            assert seen.index == rows[i]
            assert np.abs(np.array(seen.weights) - weights[i]).max() < 1e-6
            checked += 1
    assert checked > 300


def test_registered_model_has_the_same_pixels() -> None:
    mesh, photos = sheet_and_photos()
    angle, scale = 0.7, 2.5
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = scale * turn
    matrix[:3, 3] = [500_000.0, 5_000_000.0, 30.0] - scale * turn @ CORNER
    moved = PhotoViews(photos.cameras, RayTree(mesh), matrix)
    world = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    # A northing of five million metres has steps of 1e-9 m.
    assert np.nanmax(np.abs(moved.pixels(1, world) - photos.pixels(1, mesh.vertices))) < 1e-5
    seen = moved.pick(1, moved.pixels(1, world[820:821])[0])
    assert seen is not None
    # What is picked is in the model's own frame, whatever its registration.
    direct = photos.pick(1, photos.pixels(1, mesh.vertices[820:821])[0])
    assert direct is not None
    assert np.abs(seen.position - direct.position).max() < 1e-6


def wall_and_screen() -> PhotoViews:
    """A wall at z = 0, and a screen at z = 5 that hides x > 0 from a camera at z = 10."""

    def square(x0: float, x1: float, z: float) -> np.ndarray:
        return np.array([[x0, -6, z], [x1, -6, z], [x1, 6, z], [x0, 6, z]], float)

    points = np.concatenate([square(-6, 6, 0), square(0, 3, 5)]) + CORNER
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    down = np.diag([1.0, -1.0, -1.0])

    def above(name: str, x: float) -> View:
        lens = Intrinsics("PINHOLE", 1000, 1000, (700.0, 700.0, 500.0, 500.0))
        centre = CORNER + [x, 0, 10] - np.array(ORIGIN)
        return View(name, lens, down, -down @ centre)

    cameras = Cameras((above("left.jpg", 0.0), above("right.jpg", 12.0)), Path("."), ORIGIN)
    return PhotoViews(cameras, RayTree(Mesh(points, faces)))


def test_points_behind_a_screen_are_not_visible() -> None:
    photos = wall_and_screen()
    behind, free = CORNER + [2.0, 1.0, 0.0], CORNER + [-2.0, 1.0, 0.0]
    assert photos.shows(0, [behind, free]).tolist() == [False, True]
    assert [s.name for s in photos.sightings([free])] == ["left.jpg"]
    assert [s.name for s in photos.sightings([CORNER + [5.9, 0.0, 0.0]])] == ["right.jpg"]


def test_visible_part_of_a_line_ends_at_the_screen() -> None:
    photos = wall_and_screen()
    line = CORNER + np.array([[-4.0, 0.5, 0.0], [5.5, 0.5, 0.0]])
    pixels, seen = photos.project_line(0, line, step_px=0.5, slack_m=0.01)
    assert np.count_nonzero(np.diff(seen.astype(int))) <= 2, "in one piece"
    part = pixels[seen]
    x = (part[:, 0] - 500.0) / 70.0
    assert x.min() == pytest.approx(-4.0, abs=1e-9)
    # The edge at x = 0, z = 5 is right below the camera.
    assert x.max() == pytest.approx(0.0, abs=0.02)
    assert np.abs(part[:, 1] - 500.0 + 35.0).max() < 1e-6


def test_sightings_are_sorted_by_pixel_size_and_obliquity() -> None:
    points = np.array([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]) + CORNER
    mesh = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    views = tuple(
        looking(name, CORNER + shift, CORNER)
        for name, shift in (("far", (0, 0, 30.0)), ("near", (0, 0, 10.0)), ("slant", (17, 0, 4.0)))
    )
    photos = PhotoViews(Cameras(views, Path("."), ORIGIN), RayTree(mesh))
    sightings = photos.sightings([CORNER])
    assert [s.name for s in sightings] == ["near", "far", "slant"]
    assert sightings[0].gsd_m == pytest.approx(10.0 / np.sqrt(1150.0 * 1152.0), rel=1e-6)
    slant = np.degrees(np.arctan2(17, 4))
    assert sightings[2].obliquity_deg == pytest.approx(slant, abs=1e-6)


def test_a_cloud_is_picked_at_its_points() -> None:
    mesh, photos = sheet_and_photos()
    points = mesh.vertices * [1, 1, 0] + [0, 0, CORNER[2]]
    cloud = PhotoViews(photos.cameras, RayTree(PointCloud(points), max_distance=0.7))
    for row in (700, 820, 905):
        seen = cloud.pick(0, cloud.pixels(0, points[row])[0])
        assert seen is not None
        assert seen.index == row
        assert seen.weights is None
        assert cloud.shows(0, points[row : row + 1]).all()


def test_nothing_is_picked_beside_the_model_or_off_the_photo() -> None:
    photos = wall_and_screen()
    assert photos.pick(0, (20.0, 20.0)) is None
    assert photos.pick(0, (-3.0, 500.0)) is None
    assert photos.sightings(np.zeros((0, 3))) == []
    assert len(photos.project_line(0, CORNER[None])[0]) == 0


def test_many_pixels_intersect_where_single_picks_do() -> None:
    _, photos = sheet_and_photos()
    rng = np.random.default_rng(0)
    size = photos.views[0].intrinsics
    pixels = rng.uniform(0.0, [size.width, size.height], (60, 2))
    found = photos.intersect_model(0, pixels)
    for pixel, place in zip(pixels, found, strict=True):
        seen = photos.pick(0, pixel)
        if seen is None:
            assert np.isnan(place).all()
        else:
            assert np.allclose(place, seen.position, atol=1e-9)
    assert np.isfinite(found[:, 0]).any()
    assert np.isnan(photos.intersect_model(0, [[-5.0, 10.0]])).all()
