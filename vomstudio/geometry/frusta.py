"""Photos as pyramids in space: the camera at the tip, the photo's outline as the base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import View

SHARE_OF_SPACING = 0.35
SHARE_OF_DISTANCE = 0.2
_STEPS = 6


@dataclass(frozen=True, eq=False)
class Frustum:
    """name : of the photo
    tip : (3,) the camera's centre
    corners : (4, 3) of the photo, from the top left one clockwise
    outline : (k, 3) the photo's edge as the lens bends it, closed
    """

    name: str
    tip: FloatArray
    corners: FloatArray
    outline: FloatArray

    def moved(self, matrix: npt.ArrayLike, origin: npt.ArrayLike = (0, 0, 0)) -> Frustum:
        """In another frame: matrix (4, 4) applied to what lies at `origin` plus its positions."""
        m, shift = np.asarray(matrix, np.float64), np.asarray(origin, np.float64)

        def move(points: FloatArray) -> FloatArray:
            return np.asarray((points + shift) @ m[:3, :3].T + m[:3, 3])

        return Frustum(self.name, move(self.tip), move(self.corners), move(self.outline))


def edge(width: int, height: int, steps: int) -> FloatArray:
    """(4 * steps, 2) pixels around a photo, clockwise from its top left corner; every `steps`th is
    a corner."""
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64)
    along = np.linspace(0.0, 1.0, steps, endpoint=False)[:, None]
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + along * (b - a) for a, b in zip(corners, ends, strict=True)])


def frustum(view: View, depth: float) -> Frustum:
    """The pyramid of a photo whose base lies `depth` before the camera, in the scene's frame.

    Edges that the lens does not show are those of a lens without distortion.
    """
    lens = view.intrinsics
    steps = _STEPS if lens.distorts else 1
    pixels = edge(lens.width, lens.height, steps)
    rays = lens.rays(pixels)
    plain = np.column_stack([(pixels - lens.centre) / lens.focal, np.ones(len(pixels))])
    rays = np.where(np.isfinite(rays), rays, plain)
    points = (depth * rays - view.translation) @ view.rotation
    outline = np.vstack([points, points[:1]])
    return Frustum(view.name, view.centre, points[::steps], outline)


def good_size(centres: npt.ArrayLike, distance: float) -> float:
    """How deep pyramids at these places (n, 3) look best: a share of the usual distance to the
    next camera, and never more than a share of that to what they look at."""
    places = np.asarray(centres, np.float64).reshape(-1, 3)
    most = SHARE_OF_DISTANCE * distance if distance > 0 else np.inf
    spacing = np.inf
    if len(places) > 1:
        from scipy.spatial import cKDTree

        apart, _ = cKDTree(places).query(places, k=2)
        # Photos from one spot, in several directions, say nothing of the spacing.
        next_one = apart[:, 1][apart[:, 1] > 1e-6 * max(1.0, float(np.ptp(places, axis=0).max()))]
        if len(next_one):
            spacing = SHARE_OF_SPACING * float(np.median(next_one))
    size = min(most, max(spacing, 0.05 * most) if np.isfinite(most) else spacing)
    return float(size) if np.isfinite(size) else 1.0


def frusta(views: Sequence[View], target: npt.ArrayLike) -> list[Frustum]:
    """Pyramids of one size; target : (3,) about what the photos look at, in the same frame."""
    if not views:
        return []
    centres = np.array([view.centre for view in views])
    distance = float(np.median(np.linalg.norm(centres - np.asarray(target), axis=1)))
    size = good_size(centres, distance)
    return [frustum(view, size) for view in views]


def frustum_at(
    tips: FloatArray, corners: FloatArray, x: float, y: float, reach: float
) -> int | None:
    """The camera under a pixel: the one whose tip is nearest within `reach` pixels, else the
    smallest whose photo's outline holds it.

    tips : (n, 2) and corners : (n, 4, 2) pixels, NaN behind the viewer
    """
    if not len(tips):
        return None
    off = np.hypot(tips[:, 0] - x, tips[:, 1] - y)
    off = np.where(np.isfinite(off), off, np.inf)
    if off.min() <= reach:
        return int(off.argmin())
    ends = np.roll(corners, -1, axis=1)
    side = (ends[..., 0] - corners[..., 0]) * (y - corners[..., 1]) - (
        ends[..., 1] - corners[..., 1]
    ) * (x - corners[..., 0])
    inside = np.isfinite(side).all(axis=1) & ((side >= 0).all(axis=1) | (side <= 0).all(axis=1))
    if not inside.any():
        return None
    area = np.abs((corners[..., 0] * ends[..., 1] - ends[..., 0] * corners[..., 1]).sum(axis=1))
    return int(np.where(inside, area, np.inf).argmin())
