"""A synthetic rock face with known cameras: what the dense stages are judged by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.scene import SparseScene


@dataclass(frozen=True, eq=False)
class Face:
    """A height field over the x-y plane that faces +z, in metres, with a colour everywhere."""

    vertices: np.ndarray
    triangles: np.ndarray
    scene: object
    noise: np.ndarray
    columns: int
    spacing: float

    def hits(self, origins, directions):
        """Distances (n,) in units of the directions, infinity for none; and triangles' normals."""
        start = np.ascontiguousarray(np.broadcast_to(origins, directions.shape), np.float32)
        found = self.scene.run(start, np.ascontiguousarray(directions, np.float32), output=True)
        hit = found["primID"] >= 0
        corners = self.vertices[self.triangles[np.where(hit, found["primID"], 0)]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        # Once more in double precision: the distance along the ray to the triangle's plane.
        above = ((corners[:, 0] - np.broadcast_to(origins, directions.shape)) * normal).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = above / (directions * normal).sum(axis=1)
        return np.where(hit, far, np.inf), normal

    def distance(self, points):
        """(n,) exact distances to the surface."""
        off = np.empty(len(points))
        _distances(self.vertices, self.columns, self.spacing, np.ascontiguousarray(points), off)
        return off

    def brightness(self, points):
        """Lichen, grains and stains: noise of four sizes."""
        from scipy.ndimage import map_coordinates

        total = np.zeros(len(points), np.float32)
        for cell, amount, shift in (
            (0.55, 0.5, 0.0),
            (0.16, 0.5, 5.3),
            (0.05, 0.45, 2.9),
            (0.018, 0.4, 8.1),
        ):
            at = (points / cell + shift).T
            total += amount * map_coordinates(self.noise, at, order=1, mode="grid-wrap")
        return total


@numba.njit(nogil=True)
def _distances(vertices, columns, spacing, points, off):
    """Distance to the triangles of all cells around that can be nearer than the nearest so far."""
    rows = len(vertices) // columns
    for k in range(len(points)):
        p = points[k]
        ci = int((p[0] - vertices[0, 0]) / spacing)
        cj = int((p[1] - vertices[0, 1]) / spacing)
        best, ring = 1e30, 0
        while ring < 60 and (ring - 1) * spacing < math.sqrt(best):
            for j in range(max(cj - ring, 0), min(cj + ring + 1, rows - 1)):
                for i in range(max(ci - ring, 0), min(ci + ring + 1, columns - 1)):
                    if max(abs(j - cj), abs(i - ci)) != ring:
                        continue
                    a = j * columns + i
                    b, c, d = a + 1, a + columns, a + columns + 1
                    best = min(best, _squared(p, vertices[a], vertices[b], vertices[c]))
                    best = min(best, _squared(p, vertices[b], vertices[d], vertices[c]))
            ring += 1
        off[k] = math.sqrt(best)


@numba.njit(nogil=True)
def _squared(p, a, b, c):
    """Squared distance of a point to a triangle."""
    ab, ac, ap = b - a, c - a, p - a
    n0 = ab[1] * ac[2] - ab[2] * ac[1]
    n1 = ab[2] * ac[0] - ab[0] * ac[2]
    n2 = ab[0] * ac[1] - ab[1] * ac[0]
    d00, d01, d11 = np.dot(ab, ab), np.dot(ab, ac), np.dot(ac, ac)
    d20, d21 = np.dot(ap, ab), np.dot(ap, ac)
    det = d00 * d11 - d01 * d01
    v, w = (d11 * d20 - d01 * d21) / det, (d00 * d21 - d01 * d20) / det
    if v >= 0 and w >= 0 and v + w <= 1:
        return (n0 * ap[0] + n1 * ap[1] + n2 * ap[2]) ** 2 / (n0 * n0 + n1 * n1 + n2 * n2)
    best = 1e30
    for s, e in ((a, b), (b, c), (c, a)):
        t = min(max(np.dot(p - s, e - s) / np.dot(e - s, e - s), 0.0), 1.0)
        q = p - (s + t * (e - s))
        best = min(best, np.dot(q, q))
    return best


def _waves(rng, size, spacing, largest, octaves, gain):
    """Smooth noise on a grid, finer and fainter with each octave."""
    from scipy.ndimage import map_coordinates

    nx, ny = (round(s / spacing) + 1 for s in size)
    y, x = np.mgrid[0:ny, 0:nx] * spacing
    total, amount, cell = np.zeros((ny, nx)), 1.0, largest
    for _ in range(octaves):
        grid = rng.standard_normal((int(size[1] / cell) + 5, int(size[0] / cell) + 5))
        total += amount * map_coordinates(grid, [y / cell + 1, x / cell + 1], order=3)
        amount, cell = amount * gain, cell / 2
    return total


def make_face(size=(14.0, 9.0), spacing=0.008, relief=0.28, step=0.16, seed=7, slope=(0.0, 0.0)):
    """relief : of the waves in the rock; step : of the ledges along joints; slope : dz/dx, dz/dy"""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
    from scipy.ndimage import gaussian_filter

    rng = np.random.default_rng(seed)
    height = relief * _waves(rng, size, spacing, 3.0, 7, 0.47)
    ny, nx = height.shape
    y, x = np.mgrid[0:ny, 0:nx] * spacing
    ledges = _waves(rng, size, spacing, 2.2, 3, 0.45) + 0.35 * x - 0.2 * y
    height += step * np.floor(1.3 * ledges)
    height -= height.mean()
    x, y = x - size[0] / 2, y - size[1] / 2
    height += slope[0] * x + slope[1] * y
    vertices = np.stack([x, y, height], axis=-1).reshape(-1, 3)
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + nx], 1),
            np.stack([corner + 1, corner + nx + 1, corner + nx], 1),
        ]
    )
    scene = EmbreeScene()
    TriangleMesh(scene, vertices.astype(np.float32), triangles.astype(np.int32))
    noise = gaussian_filter(rng.standard_normal((128,) * 3), 0.6, mode="wrap")
    return Face(vertices, triangles, scene, (noise / noise.std()).astype(np.float32), nx, spacing)


def look(name, lens, centre, target, roll_deg=0.0):
    """The view from a point to another, with the y axis of the world up in the photo."""
    z = np.asarray(target, float) - centre
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    rotation = np.stack([c * x + s * y, c * y - s * x, z])
    return View(name, lens, rotation, -rotation @ np.asarray(centre, float))


def photograph(face, view, *, samples=2, noise=1.8, seed=0, gain=1.0):
    """(h, w, 3) uint8, each pixel the mean of samples x samples rays."""
    lens = view.intrinsics
    rng = np.random.default_rng(seed)
    sun = np.array([0.45, 0.6, 0.66])
    picture = np.zeros((lens.height, lens.width), np.float32)
    x, y = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    for sub in range(samples * samples):
        at = (np.array([sub % samples, sub // samples]) + 0.5) / samples
        pixels = np.stack([x + at[0], y + at[1]], axis=-1).reshape(-1, 2)
        directions = view.rays(pixels)
        lost = ~np.isfinite(directions).all(axis=1)
        directions[lost] = [0.0, 0.0, 1.0]
        depth, normal = face.hits(view.centre, directions)
        hit = np.isfinite(depth) & ~lost
        points = view.centre + directions * np.where(hit, depth, 0.0)[:, None]
        shade = 0.55 + 0.45 * np.clip(normal @ (sun / np.linalg.norm(sun)), 0.0, 1.0)
        value = gain * shade * (118.0 + 34.0 * face.brightness(points))
        picture += np.where(hit, value, 200.0).reshape(picture.shape)
    picture /= samples * samples
    colour = picture[..., None] * np.array([1.03, 0.96, 0.88])
    colour += rng.normal(0.0, noise, picture.shape)[..., None]
    return np.clip(np.round(colour), 0, 255).astype(np.uint8)


def true_depth(face, view):
    """(h, w) along the optical axis at the pixels' centres, 0 = none; for pinhole views."""
    lens = view.intrinsics
    x, y = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    directions = lens.rays(np.stack([x, y], axis=-1).reshape(-1, 2)) @ view.rotation
    depth, _ = face.hits(view.centre, directions)
    return np.where(np.isfinite(depth), depth, 0.0).reshape(x.shape)


def seen_from(face, points, view, border=8.0):
    """Which points (n, 3) the view shows."""
    pixels = view.project(points)
    lens = view.intrinsics
    with np.errstate(invalid="ignore"):
        on = (pixels > border).all(axis=1) & (
            pixels < [lens.width - border, lens.height - border]
        ).all(axis=1)
    depth, _ = face.hits(view.centre, points - view.centre)
    return on & (depth > 0.9985)


def tie_points(face, views, count=4000, noise_px=0.3, seed=1):
    """A SparseScene as an alignment leaves it: points on the face, slightly wrong."""
    rng = np.random.default_rng(seed)
    points = face.vertices[rng.choice(len(face.vertices), count, replace=False)]
    seen = np.stack([seen_from(face, points, view) for view in views], axis=1)
    kept = seen.sum(axis=1) >= 2
    points, seen = points[kept], seen[kept]
    gsd = np.mean([np.median(v.depths(points)) / np.mean(v.intrinsics.focal) for v in views])
    rows, columns = np.nonzero(seen)
    pixels = np.empty((len(rows), 2))
    for number, view in enumerate(views):
        pixels[columns == number] = view.project(points[rows[columns == number]])
    moved = points + rng.normal(0.0, noise_px * gsd, points.shape) * [1.0, 1.0, 3.0]
    return SparseScene(
        tuple(views),
        moved,
        np.full((len(points), 3), 128, np.uint8),
        np.full(len(points), noise_px, np.float32),
        np.concatenate([[0], np.cumsum(seen.sum(axis=1))]).astype(np.int64),
        columns.astype(np.int32),
        (pixels + rng.normal(0.0, noise_px, pixels.shape)).astype(np.float32),
        scaled=True,
    )


def true_points(face, views, count=150_000, least=3, seed=1):
    """(n, 3) points spread evenly over the face that at least so many views show."""
    rng = np.random.default_rng(seed)
    corners = face.vertices[face.triangles]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    chosen = corners[rng.choice(len(corners), count, p=area / area.sum())]
    a, b = rng.random((2, count, 1))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    points = chosen[:, 0] + a * (chosen[:, 1] - chosen[:, 0]) + b * (chosen[:, 2] - chosen[:, 0])
    return points[sum(seen_from(face, points, view).astype(int) for view in views) >= least]


def accuracy(face, points):
    """Median and 95 % of the distances to the face."""
    off = face.distance(points)
    return float(np.median(off)), float(np.percentile(off, 95))


def completeness(points, truth, gsd):
    """The part of the true points that lie within 4 GSD of a point."""
    from scipy.spatial import cKDTree

    near, _ = cKDTree(points).query(truth, distance_upper_bound=4 * gsd)
    return float(np.mean(np.isfinite(near)))
