"""The photos of a model and what they see of it, both ways: which photos show a point, where and
how well, and which point of the model lies under a pixel.

Lines of sight are followed with the lens's distortion (the collinearity equations), and end at the
first surface they meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.photos.cameras_file import Cameras

if TYPE_CHECKING:
    from vomstudio.geometry.rays.raytree import RayTree


# A line between two points picked on a rough face runs through the rock here and there: it is
# hidden only where the rock covers it by more than this part of its length.
_SAGITTA = 0.12
_MOST_ON_A_LINE = 4000
_FOR_OBLIQUITY = 12


@dataclass(frozen=True, eq=False)
class Sighting:
    """A photo that shows a place.

    view : its row in `PhotoViews.views`
    pixel : (2,) where, COLMAP's pixels of the stored photo
    gsd_m : size of a pixel there at right angles to the line of sight, in the model's unit
    obliquity_deg : between the line of sight and the surface's normal; None where unknown. Of
        several places, like gsd_m, the median
    share : of the places asked for that the photo shows, 0 to 1
    """

    view: int
    name: str
    pixel: FloatArray
    gsd_m: float
    obliquity_deg: float | None
    share: float = 1.0

    @property
    def effective_gsd_m(self) -> float:
        """Size of a pixel on the surface, along its foreshortened direction; at most ten times its
        `gsd_m`, beyond which nothing can be told."""
        if self.obliquity_deg is None:
            return self.gsd_m
        return self.gsd_m / max(float(np.cos(np.radians(self.obliquity_deg))), 0.1)


@dataclass(frozen=True, eq=False)
class Seen:
    """What lies under a pixel: the row of the face or point, its place (3,) float64 in the model's
    own frame, and the barycentric weights of the face's corners (None for a point)."""

    index: int
    position: FloatArray
    weights: tuple[float, float, float] | None


class PhotoViews:
    """A model with its photos.

    cameras : views in the frame of the model's file minus their origin
    tree : the model itself, in the frame of its file
    to_world : (4, 4) from that frame to World, a similarity

    World points are float64; they are brought near the cameras' origin before anything is
    multiplied, so that UTM coordinates lose nothing.
    """

    def __init__(
        self,
        cameras: Cameras,
        tree: RayTree,
        to_world: npt.ArrayLike | None = None,
        resolution_m: float = 0.0,
    ) -> None:
        self.cameras = cameras
        self.views = cameras.views
        self.tree = tree
        self._origin = np.asarray(cameras.origin, np.float64)
        matrix = np.eye(4) if to_world is None else np.asarray(to_world, np.float64)
        self.to_world: FloatArray = matrix
        self._forth = matrix[:3, :3]
        self._back = np.linalg.inv(self._forth)
        # World of the cameras' origin.
        self._anchor = self._forth @ self._origin + matrix[:3, 3]
        self.resolution = max(resolution_m, tree.reach)
        self._centres = np.array([view.centre for view in self.views]).reshape(-1, 3)

    def row(self, name: str) -> int:
        """Raises KeyError for a photo that has no camera."""
        for number, view in enumerate(self.views):
            if view.name == name:
                return number
        raise KeyError(name)

    def has(self, name: str) -> bool:
        """Whether a photo has a camera."""
        return any(view.name == name for view in self.views)

    def direction(self, view: int) -> FloatArray:
        """(3,) unit vector in World along a photo's axis."""
        way = np.linalg.solve(self._back, self.views[view].direction)
        return np.asarray(way / np.linalg.norm(way))

    def local(self, world: npt.ArrayLike) -> FloatArray:
        """World points (n, 3) in the cameras' frame."""
        points = np.asarray(world, np.float64).reshape(-1, 3)
        return np.asarray((points - self._anchor) @ self._back.T)

    # --- from the model to the photos --------------------------------------------------------
    def pixels(self, view: int, world: npt.ArrayLike) -> FloatArray:
        """(n, 2) of World points; NaN where the lens shows nothing, whatever hides them, inside the
        photo or not."""
        return self.views[view].project(self.local(world))

    def shows(self, view: int, world: npt.ArrayLike, slack_m: float | None = None) -> BoolArray:
        """(n,) World points that are on the photo and not hidden.

        slack_m : how far behind the first surface a point may lie, in the model's unit; without
            it twice the model's resolution
        """
        local = self.local(world)
        return self._shows(view, local, self.views[view].project(local), slack_m)

    def _shows(
        self, view: int, local: FloatArray, pixels: FloatArray, slack_m: float | None
    ) -> BoolArray:
        seen = self.views[view].contains(pixels)
        rows = np.flatnonzero(seen)
        if len(rows):
            seen[rows] = ~self._hidden(self._centres[view], local[rows], slack_m)
        return seen

    def _hidden(
        self, centre: FloatArray, local: FloatArray, slack_m: float | FloatArray | None
    ) -> BoolArray:
        ways = local - centre
        far = np.linalg.norm(ways, axis=1)
        slack = 2.0 * self.resolution if slack_m is None else slack_m
        # Of a cloud every point within reach of the line of sight counts.
        slack = np.minimum(slack + self.tree.reach, 0.5 * far) + 1e-9 * far
        last = 1.0 - slack / np.maximum(far, 1e-300)
        hits = self.tree.cast(centre + self._origin, ways, last)
        return np.asarray(hits.index >= 0)

    def sightings(self, world: npt.ArrayLike, slack_m: float | None = None) -> list[Sighting]:
        """The photos that show World points (n, 3): those that show most of them first, and of
        these the one with the finest pixels on the surface."""
        local = self.local(world)
        if not len(local) or not self.views:
            return []
        found = []
        for number, view in enumerate(self.views):
            pixels = view.project(local)
            seen = self._shows(number, local, pixels, slack_m)
            if seen.any():
                rows = np.flatnonzero(seen)
                some = local[rows[:: max(1, len(rows) // _FOR_OBLIQUITY)]]
                found.append(
                    Sighting(
                        number,
                        view.name,
                        pixels[rows[len(rows) // 2]],
                        float(np.median(view.depths(some))) / self._focal(number),
                        self._obliquity(number, some),
                        float(seen.mean()),
                    )
                )
        # Shares in fifths: a little more of the feature is no reason for much coarser pixels.
        return sorted(found, key=lambda s: (-int(5 * s.share + 1e-9), s.effective_gsd_m, s.name))

    def _focal(self, view: int) -> float:
        return float(np.sqrt(np.prod(self.views[view].intrinsics.focal)))

    def _obliquity(self, view: int, local: FloatArray) -> float | None:
        ways = local - self._centres[view]
        hits = self.tree.cast(self._centres[view] + self._origin, ways)
        found = []
        for way, index in zip(ways, hits.index.tolist(), strict=True):
            normal = self.tree.normal(index) if index >= 0 else None
            if normal is not None:
                found.append(abs(float(normal @ way)) / max(float(np.linalg.norm(way)), 1e-300))
        if not found:
            return None
        return float(np.degrees(np.arccos(min(float(np.median(found)), 1.0))))

    def course(
        self, view: int, line: npt.ArrayLike, step_px: float = 3.0, slack_m: float | None = None
    ) -> tuple[FloatArray, BoolArray]:
        """Pixels (k, 2) along a World polyline (n, 3), some `step_px` apart, and which of them are
        on the photo and not hidden (as `shows`; between its corners a line may run below the
        surface by a part of its length)."""
        local = self.local(line)
        if len(local) < 2:
            return np.zeros((0, 2)), np.zeros(0, np.bool_)
        steps = self._steps(view, local, step_px)
        pieces: list[FloatArray] = []
        slacks: list[FloatArray] = []
        for a, b, count in zip(local[:-1], local[1:], steps, strict=True):
            t = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
            pieces.append(a + t * (b - a))
            # Nothing at the corners, most half way between them.
            sag = 4.0 * (t * (1.0 - t)).ravel() * _SAGITTA * float(np.linalg.norm(b - a))
            slacks.append(sag + 2.0 * self.resolution)
        points = np.concatenate([*pieces, local[-1:]])
        slack = np.append(np.concatenate(slacks), 2.0 * self.resolution)
        if slack_m is not None:
            slack[:] = slack_m
        photo = self.views[view]
        pixels = photo.project(points)
        seen = photo.contains(pixels)
        rows = np.flatnonzero(seen)
        if len(rows):
            seen[rows] = ~self._hidden(self._centres[view], points[rows], slack[rows])
        return pixels, seen

    def _steps(self, view: int, local: FloatArray, step_px: float) -> list[int]:
        pixels = self.views[view].project(local)
        lengths = np.hypot(*np.diff(pixels, axis=0).T)
        size = float(np.hypot(*(self.views[view].intrinsics.width,) * 2))
        # Ends that the lens does not show say nothing of the length between.
        lengths = np.minimum(np.nan_to_num(lengths, nan=size, posinf=size), 3 * size)
        step = max(step_px, float(lengths.sum()) / _MOST_ON_A_LINE)
        return [max(1, int(np.ceil(length / step))) for length in lengths]

    # --- from a photo to the model -----------------------------------------------------------
    def places_under(self, view: int, pixels: npt.ArrayLike) -> FloatArray:
        """(n, 3) where the lines of sight through pixels (n, 2) of a photo first meet the model,
        World; NaN where nowhere. In a cloud as far along the line as the point that is met."""
        photo = self.views[view]
        given = np.asarray(pixels, np.float64).reshape(-1, 2)
        ways = photo.rays(given)
        hits = self.tree.cast(self._centres[view] + self._origin, ways)
        met = (hits.index >= 0) & photo.contains(given)
        found = np.full((len(given), 3), np.nan)
        own = self.tree.positions(hits.index[met], hits.weights[met])
        if not isinstance(self.tree.data, Mesh):
            start, along = self._centres[view] + self._origin, ways[met]
            own = start + ((own - start) * along).sum(axis=1, keepdims=True) * along
        found[met] = (own - self._origin) @ self._forth.T + self._anchor
        return found

    def pick(self, view: int, pixel: Sequence[float] | FloatArray) -> Seen | None:
        """What a photo shows at a pixel; None beside the model or off the photo."""
        photo = self.views[view]
        if not photo.contains(pixel)[0]:
            return None
        way = photo.rays(pixel)
        hits = self.tree.cast(self._centres[view] + self._origin, way)
        index = int(hits.index[0])
        if index < 0:
            return None
        position = self.tree.position(index, hits.weights[0])
        if not isinstance(self.tree.data, Mesh):
            return Seen(index, position, None)
        a, b, c = hits.weights[0].tolist()
        return Seen(index, position, (a, b, c))
