"""Photos as pyramids in space, with the camera as apex and the photo outline as base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import View

MAX_SPACING_SHARE = 0.35
MAX_DISTANCE_SHARE = 0.2
N_EDGE_STEPS = 6


@dataclass(frozen=True, eq=False)
class Frustum:
    """Pyramid of a photo.

    Attributes
    ----------
    tip : (3,) ndarray
        Projection centre.
    corners : (4, 3) ndarray
        Corners of the photo, clockwise from the top left.
    outline : (k, 3) ndarray
        Closed outline of the photo with lens distortion.
    is_weak : bool
        Whether the photo is weakly connected to the other photos.
    """

    name: str
    tip: FloatArray
    corners: FloatArray
    outline: FloatArray
    is_weak: bool = False

    def transform(self, matrix: npt.ArrayLike, origin: npt.ArrayLike = (0, 0, 0)) -> Frustum:
        """Transform to another frame: apply matrix (4, 4) to `origin` plus positions."""
        rows, shift = np.asarray(matrix, np.float64), np.asarray(origin, np.float64)

        def move(points: FloatArray) -> FloatArray:
            return np.asarray((points + shift) @ rows[:3, :3].T + rows[:3, 3])

        return Frustum(
            self.name, move(self.tip), move(self.corners), move(self.outline), self.is_weak
        )


def edge_pixels(width: int, height: int, steps: int) -> FloatArray:
    """Return pixels around the edge of a photo, clockwise from the top left corner.

    Parameters
    ----------
    width, height : int
        Size of the photo.
    steps : int
        Number of pixels per side.

    Returns
    -------
    (4 * steps, 2) ndarray
    """
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64)
    edge_fractions = np.linspace(0.0, 1.0, steps, endpoint=False)[:, None]
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate(
        [
            corner + edge_fractions * (end - corner)
            for corner, end in zip(corners, ends, strict=True)
        ]
    )


def frustum(view: View, depth: float) -> Frustum:
    """Return the pyramid of a photo, with its base at `depth`, in the frame of the scene.

    Edges outside the range of the lens model are computed without distortion.

    Parameters
    ----------
    view : View
    depth : float
        Distance of the base from the camera, in the unit of the scene.

    Returns
    -------
    Frustum
    """
    lens = view.intrinsics
    steps = N_EDGE_STEPS if lens.has_distortion else 1
    pixels = edge_pixels(lens.width, lens.height, steps)
    rays = lens.rays(pixels)
    pixel_rays = np.column_stack([(pixels - lens.centre) / lens.focal, np.ones(len(pixels))])
    rays = np.where(np.isfinite(rays), rays, pixel_rays)
    points = (depth * rays - view.translation) @ view.rotation
    outline = np.vstack([points, points[:1]])
    return Frustum(view.name, view.centre, points[::steps], outline)


def choose_frustum_size(centres: npt.ArrayLike, distance: float) -> float:
    """Return a suitable depth of the pyramids of photos.

    It is a share of the median distance between cameras, limited to a share of the distance to the
    object and to at least a twentieth of this share. It is 1 if neither distance is known.

    Parameters
    ----------
    centres : (n, 3) array_like
        Positions of the cameras.
    distance : float
        Distance to the object; ignored unless positive.

    Returns
    -------
    float
    """
    positions = np.asarray(centres, np.float64).reshape(-1, 3)
    max_size = MAX_DISTANCE_SHARE * distance if distance > 0 else np.inf
    spacing = np.inf
    if len(positions) > 1:
        from scipy.spatial import cKDTree

        distances, _ = cKDTree(positions).query(positions, k=2)
        # Exclude photos taken from one position in several directions.
        spacings = distances[:, 1][
            distances[:, 1] > 1e-6 * max(1.0, float(np.ptp(positions, axis=0).max()))
        ]
        if len(spacings):
            spacing = MAX_SPACING_SHARE * float(np.median(spacings))
    size = min(max_size, max(spacing, 0.05 * max_size) if np.isfinite(max_size) else spacing)
    return float(size) if np.isfinite(size) else 1.0


def frusta(views: Sequence[View], target: npt.ArrayLike) -> list[Frustum]:
    """Return the pyramids of photos, all of the same size.

    Parameters
    ----------
    views : sequence of View
    target : (3,) array_like
        Centre of the photographed object.

    Returns
    -------
    list of Frustum
    """
    if not views:
        return []
    centres = np.array([view.centre for view in views])
    distance = float(np.median(np.linalg.norm(centres - np.asarray(target), axis=1)))
    size = choose_frustum_size(centres, distance)
    return [frustum(view, size) for view in views]


def find_frustum_at_pixel(
    apexes: FloatArray, corners: FloatArray, x: float, y: float, max_distance_px: float
) -> int | None:
    """Find the camera at a pixel.

    This is the camera with the nearest apex within `max_distance_px` pixels or, if no apex is that
    close, the camera with the smallest outline that contains the pixel.

    Parameters
    ----------
    apexes : (n, 2) ndarray
    corners : (n, 4, 2) ndarray
        Corners of the photos in pixels; NaN for points behind the viewer.
    x, y : float
        Pixel.
    max_distance_px : float
        Maximum distance of the nearest apex, pixels.

    Returns
    -------
    int or None
        Row of the camera; None if there is no camera at the pixel.
    """
    if not len(apexes):
        return None
    distances = np.hypot(apexes[:, 0] - x, apexes[:, 1] - y)
    distances = np.where(np.isfinite(distances), distances, np.inf)
    if distances.min() <= max_distance_px:
        return int(distances.argmin())
    ends = np.roll(corners, -1, axis=1)
    cross_products = (ends[..., 0] - corners[..., 0]) * (y - corners[..., 1]) - (
        ends[..., 1] - corners[..., 1]
    ) * (x - corners[..., 0])
    is_inside = np.isfinite(cross_products).all(axis=1) & (
        (cross_products >= 0).all(axis=1) | (cross_products <= 0).all(axis=1)
    )
    if not is_inside.any():
        return None
    area = np.abs((corners[..., 0] * ends[..., 1] - ends[..., 0] * corners[..., 1]).sum(axis=1))
    return int(np.where(is_inside, area, np.inf).argmin())
