"""What the dense stages are judged by: true depths, tie points, accuracy and completeness.

Faces lie on their backs here (`lying_face`): x to the right, y up in the photos, z towards them.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tests.photogrammetry import rock_face
from vomstudio.photogrammetry.base.scene import SparseScene

look = partial(rock_face.looking, up=(0.0, 1.0, 0.0))


def lying_face(size=(14.0, 9.0), spacing=0.01, relief=0.28, ledge=0.16, seed=7, slope=(0.0, 0.0)):
    """slope : dz/dx, dz/dy"""
    # What is farther into the rock of an upright face is lower of a lying one.
    into = (-slope[0], -slope[1])
    face = rock_face.rough_face(*size, spacing, seed=seed, relief=relief, ledge=ledge, slope=into)
    return face.lying()


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
    points, _ = face.scattered(count, np.random.default_rng(seed))
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
