"""A rock face of known shape and colour, photographed by known cameras.

The face stands upright and looks south: x East, y North (into the rock), z up. Its colour is a
function of position, so that what a texture should show is known everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.cloud import PointCloud

Array = npt.NDArray[np.float64]
SUN = np.array([-0.35, -0.75, 0.56]) / np.linalg.norm([-0.35, -0.75, 0.56])


def lattice(rng: np.random.Generator, size: int = 96) -> Array:
    from scipy.ndimage import gaussian_filter

    values = gaussian_filter(rng.standard_normal((size, size, size)), 0.6, mode="wrap")
    return values / values.std()


@dataclass(frozen=True, eq=False)
class Face:
    """vertices, faces : the true surface, fine. paint : colours (n, 3), 0..255, of points (n, 3)
    sun : towards it
    """

    vertices: Array
    faces: npt.NDArray[np.int32]
    paint: Callable[[Array], Array]
    sun: Array = field(default_factory=SUN.copy)

    @cached_property
    def scene(self) -> Any:
        import open3d as o3d

        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(
            o3d.core.Tensor(self.vertices.astype(np.float32)),
            o3d.core.Tensor(self.faces.astype(np.uint32)),
        )
        return scene

    def hits(self, origins: Array, directions: Array) -> tuple[Array, Array]:
        """Distances (n,) in units of the directions, infinity for none; and triangles' normals."""
        import open3d as o3d

        packed = np.concatenate([np.broadcast_to(origins, directions.shape), directions], 1)
        found = self.scene.cast_rays(o3d.core.Tensor(packed.astype(np.float32)))
        return found["t_hit"].numpy(), found["primitive_normals"].numpy()

    def distance(self, points: Array) -> Array:
        """(n,) distances to the surface."""
        import open3d as o3d

        tensor = o3d.core.Tensor(np.ascontiguousarray(points, np.float32))
        return self.scene.compute_distance(tensor).numpy()

    def shade(self, normals: Array) -> Array:
        return 0.55 + 0.45 * np.clip(normals @ self.sun, 0, 1)

    def lying(self) -> Face:
        """Turned on its back: y is where z was, and it faces +z."""
        turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        return Face(self.vertices @ turn.T, self.faces, self.paint, turn @ self.sun)

    def scattered(self, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Points (n, 3) spread evenly over the surface, and its normals there."""
        corners = self.vertices[self.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(cross, axis=1) / 2
        chosen = rng.choice(len(area), count, p=area / area.sum())
        a, b = rng.random((2, count))
        flip = a + b > 1
        a[flip], b[flip] = 1 - a[flip], 1 - b[flip]
        c = corners[chosen]
        points = c[:, 0] + a[:, None] * (c[:, 1] - c[:, 0]) + b[:, None] * (c[:, 2] - c[:, 0])
        return points, cross[chosen] / (2 * area[chosen, None])

    @property
    def area(self) -> float:
        corners = self.vertices[self.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return float(np.linalg.norm(cross, axis=1).sum() / 2)


def rough_face(
    width: float = 14.0,
    height: float = 9.0,
    step: float = 0.02,
    *,
    seed: int = 7,
    joints: bool = True,
    relief: float = 0.28,
    ledge: float = 0.16,
    slope: tuple[float, float] = (0.0, 0.0),
) -> Face:
    """Roughness over seven octaves, with ledges and joint steps. slope : dy/dx, dy/dz"""
    from scipy.ndimage import map_coordinates

    rng = np.random.default_rng(seed)
    nx, nz = int(width / step) + 1, int(height / step) + 1
    x, z = np.linspace(0, width, nx), np.linspace(0, height, nz)

    def noise(base: float, octaves: int, gain: float) -> Array:
        total, amplitude, size = np.zeros((nz, nx)), 1.0, base
        for _ in range(octaves):
            grid = rng.standard_normal((int(height / size) + 4, int(width / size) + 4))
            zz, xx = np.meshgrid(z / size + 1, x / size + 1, indexing="ij")
            total += amplitude * map_coordinates(grid, [zz, xx], order=3, mode="nearest")
            amplitude, size = amplitude * gain, size / 2
        return total

    depth = relief * noise(3.0, 7, 0.47)
    if joints:
        steps = noise(2.2, 3, 0.45) + 0.35 * x - 0.2 * z[:, None]
        depth += ledge * np.floor(1.3 * steps)
    xx, zz = np.meshgrid(x - width / 2, z - height / 2)
    depth += slope[0] * xx + slope[1] * zz - depth.mean()
    vertices = np.stack([xx, depth, zz], -1).reshape(-1, 3)
    return Face(vertices, grid_faces(nz, nx), rock_paint(seed))


def flat_face(width: float, height: float, paint: Callable[[Array], Array], n: int = 2) -> Face:
    """A plane y = 0 about the origin."""
    x, z = np.linspace(-width / 2, width / 2, n), np.linspace(-height / 2, height / 2, n)
    xx, zz = np.meshgrid(x, z)
    vertices = np.stack([xx, np.zeros_like(xx), zz], -1).reshape(-1, 3)
    return Face(vertices, grid_faces(n, n), paint)


def joined(*parts: Face) -> Face:
    """One face of several, each with its paint inside its own box."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    ends = [(part.vertices.min(axis=0) - 0.1, part.vertices.max(axis=0) + 0.1) for part in parts]

    def paint(points: Array) -> Array:
        colors = np.zeros_like(points)
        for part, (low, high) in reversed(list(zip(parts, ends, strict=True))):
            inside = ((points >= low) & (points <= high)).all(axis=1)
            colors[inside] = part.paint(points[inside])
        return colors

    vertices = np.concatenate([part.vertices for part in parts])
    return Face(vertices, np.concatenate(faces).astype(np.int32), paint)


def wall_at(
    width: float,
    height: float,
    centre: tuple[float, float, float],
    n: int = 120,
    paint: Callable[[Array], Array] = np.zeros_like,
) -> Face:
    """A plane that faces -y, of n x n vertices."""
    plain = flat_face(width, height, paint, n)
    return Face(plain.vertices + centre, plain.faces, paint)


def grid_faces(rows: int, columns: int) -> npt.NDArray[np.int32]:
    """Facing -y where the grid's columns go along x and its rows along z."""
    i = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    both = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    return both.astype(np.int32)


def rock_paint(seed: int, finest: float = 0.02) -> Callable[[Array], Array]:
    """Octaves of noise down to cells of `finest` metres."""
    from scipy.ndimage import map_coordinates

    rng = np.random.default_rng(seed + 1)
    grid = lattice(rng)
    cells = ((30 * finest, 0.55), (8.5 * finest, 0.5), (2.75 * finest, 0.45), (finest, 0.45))

    def paint(points: Array) -> Array:
        def at(cell: float, shift: float) -> Array:
            return map_coordinates(grid, (points / cell + shift).T, order=1, mode="grid-wrap")

        tone = sum(weight * at(cell, 3.1 * k) for k, (cell, weight) in enumerate(cells))
        hue = at(40 * finest, 9.3)
        grey = 118 + 34 * tone
        return np.stack([grey * 1.05 + 10 * hue, grey * 0.95, grey * 0.86 - 8 * hue], -1)

    return paint


def checker_paint(cell: float) -> Callable[[Array], Array]:
    def paint(points: Array) -> Array:
        dark = (np.floor(points[:, 0] / cell) + np.floor(points[:, 2] / cell)) % 2 > 0
        return np.where(dark[:, None], [60.0, 70.0, 80.0], [200.0, 190.0, 180.0])

    return paint


def ring_of_views(
    rows: int = 2,
    columns: int = 6,
    *,
    spread: tuple[float, float] = (7.8, 2.0),
    distance: float = 8.0,
    size: tuple[int, int] = (1200, 864),
    focal: float = 1100.0,
    seed: int = 3,
    toward: float = 0.72,
    params: tuple[str, tuple[float, ...]] | None = None,
) -> list[View]:
    """Cameras in rows before the face, turned in somewhat. params : model and distortion after the
    focal length and the centre"""
    rng = np.random.default_rng(seed)
    lens = Intrinsics.pinhole(*size, focal, size[0] / 2, size[1] / 2)
    if params is not None:
        lens = Intrinsics(params[0], *size, (focal, focal, size[0] / 2, size[1] / 2, *params[1]))
    views = []
    for row in range(rows):
        for column in range(columns):
            place = np.array(
                [
                    spread[0] * ((column + 0.5) / columns - 0.5) * columns / max(columns - 1, 1),
                    -distance,
                    spread[1] * ((row + 0.5) / rows - 0.5) * rows / max(rows - 1, 1),
                ]
            ) + rng.normal(0, 0.012 * distance, 3)
            target = np.array([place[0] * toward, 0.0, place[2] * 0.45]) + rng.normal(0, 0.1, 3)
            views.append(looking(f"{len(views):02d}.png", lens, place, target))
    return views


def looking(
    name: str,
    lens: Intrinsics,
    place: npt.ArrayLike,
    target: npt.ArrayLike,
    roll_deg: float = 0.0,
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> View:
    """The view from a place to another; straight up or down, y is up in the photo."""
    place = np.asarray(place, float)
    z = np.asarray(target, float) - place
    z /= np.linalg.norm(z)
    x = np.cross(z, up if abs(z @ up) < 0.98 else (0.0, 1.0, 0.0))
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    rotation = np.stack([c * x + s * y, c * y - s * x, z])
    return View(name, lens, rotation, -rotation @ place)


def photograph(
    face: Face,
    view: View,
    *,
    gain: float | tuple[float, float, float] = 1.0,
    noise: float = 1.5,
    blur: float = 0.0,
    samples: int = 2,
    shaded: bool = True,
    occluder: tuple[float, float, float, float] | None = None,
    seed: int = 0,
) -> npt.NDArray[np.uint8]:
    """(h, w, 3) RGB. occluder : x, y, half width, half height, pixels, of a green thing in front"""
    import cv2

    width, height = view.intrinsics.width, view.intrinsics.height
    x, y = np.meshgrid(
        (np.arange(width * samples) + 0.5) / samples, (np.arange(height * samples) + 0.5) / samples
    )
    rays = view.rays(np.stack([x.ravel(), y.ravel()], 1))
    # Beyond the edge of the lens there is nothing.
    beyond = ~np.isfinite(rays).all(axis=1)
    rays[beyond] = view.direction
    reach, normals = face.hits(view.centre, rays)
    hit = np.isfinite(reach) & ~beyond
    colors = np.full((len(rays), 3), 205.0)
    colors[hit] = face.paint(view.centre + rays[hit] * reach[hit, None])
    if shaded:
        colors[hit] *= face.shade(normals[hit])[:, None]
    picture = colors.reshape(height, samples, width, samples, 3).mean((1, 3)) * np.asarray(gain)
    if occluder is not None:
        cx, cy, rx, ry = occluder
        yy, xx = np.mgrid[:height, :width]
        inside = ((xx - cx) / rx) ** 2 + ((yy - cy) / ry) ** 2 < 1
        picture[inside] = [40, 150, 30]
    if blur:
        picture = cv2.GaussianBlur(picture, (0, 0), blur)
    picture = picture + np.random.default_rng(seed).normal(0, noise, picture.shape)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def encoded(picture: npt.NDArray[np.uint8], ending: str = ".png") -> bytes:
    import cv2

    return cv2.imencode(
        ending, picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 97] if ending == ".jpg" else []
    )[1].tobytes()


def taken(view: View, picture, mask=None, ending: str = ".png"):  # type: ignore[no-untyped-def]
    """A photo as the texture wants it."""
    import cv2

    data = None if mask is None else cv2.imencode(".png", mask)[1].tobytes()
    return SimpleNamespace(photo=encoded(picture, ending), mask=data, view=view)


def cloud_of(
    face: Face, views: list[View], *, spacing: float, noise: float = 0.0, seed: int = 1
) -> PointCloud:
    """What a dense matching would leave: points of the face that at least two views see."""
    rng = np.random.default_rng(seed)
    points, normals = face.scattered(int(face.area / spacing**2), rng)
    seen = np.zeros(len(points), int)
    for view in views:
        pixels = view.project(points)
        inside = view.contains(np.nan_to_num(pixels, nan=-1.0))
        rays = points - view.centre
        reach = np.linalg.norm(rays, axis=1)
        hit, _ = face.hits(view.centre, rays / reach[:, None])
        seen += inside & (hit > reach - 0.2 * spacing) & ((rays * normals).sum(1) < -0.17 * reach)
    keep = seen >= 2
    points, normals = points[keep], normals[keep]
    colors = np.clip(face.paint(points) * face.shade(normals)[:, None], 0, 255).astype(np.uint8)
    points = points + rng.normal(0, noise, points.shape) if noise else points
    turned = normals + rng.normal(0, 0.08, normals.shape) if noise else normals
    turned = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return PointCloud(points, colors, turned.astype(np.float32))
