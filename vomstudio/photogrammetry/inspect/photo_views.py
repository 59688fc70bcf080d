"""Photos and surface of a model: photos that show a point, and points under pixels.

Lines of sight include the distortion of the lens (the collinearity equations), and end at the first
surface.
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


# Depth below the rock, as a share of its length, up to which a line between points on a rough face
# is visible.
_MAX_SAG_SHARE = 0.12
_MAX_LINE_POINTS = 4000
_OBLIQUITY_POINTS = 12


@dataclass(frozen=True, eq=False)
class Sighting:
    """Photo that shows a position or several positions.

    Attributes
    ----------
    view : int
        Row in `PhotoViews.views`.
    pixel : (2,) array
        Pixel of the stored photo, in COLMAP's convention.
    gsd_m : float
        Pixel size perpendicular to the line of sight, in the unit of the model; the median if there
        are several positions.
    obliquity_deg : float or None
        Median angle between the line of sight and the surface normal; None if unknown.
    share : float
        Share of the positions that are visible, 0 to 1.
    """

    view: int
    name: str
    pixel: FloatArray
    gsd_m: float
    obliquity_deg: float | None
    share: float = 1.0

    @property
    def effective_gsd_m(self) -> float:
        """Size of a pixel along its foreshortened direction on the surface.

        It is limited to ten times `gsd_m`.
        """
        if self.obliquity_deg is None:
            return self.gsd_m
        return self.gsd_m / max(float(np.cos(np.radians(self.obliquity_deg))), 0.1)


@dataclass(frozen=True, eq=False)
class PickedSurface:
    """Surface under a pixel.

    It consists of the row of the face or point, its position (3,) float64 in the frame of the
    model, and the barycentric weights of the corners of the face (None for a point).
    """

    index: int
    position: FloatArray
    weights: tuple[float, float, float] | None


class PhotoViews:
    """Model together with its photos.

    World points are float64 and shifted to the origin of the cameras first, so that UTM coordinates
    keep their precision.

    Parameters
    ----------
    cameras : Cameras
        Views in the frame of the model's file minus their origin.
    tree : RayTree
        Ray tree of the model, in the frame of its file.
    to_world : (4, 4) array, optional
        Similarity from the frame of the file to the World frame.
    resolution_m : float
        Resolution of the model; tolerances are derived from it.
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
        self._to_file = matrix[:3, :3]
        self._from_file = np.linalg.inv(self._to_file)
        # Origin of the cameras in the World frame.
        self._world_origin = self._to_file @ self._origin + matrix[:3, 3]
        self.resolution = max(resolution_m, tree.max_distance)
        self._centres = np.array([view.centre for view in self.views]).reshape(-1, 3)

    def row(self, name: str) -> int:
        """Return the row of a photo. Raises KeyError if it has no camera."""
        for number, view in enumerate(self.views):
            if view.name == name:
                return number
        raise KeyError(name)

    def has(self, name: str) -> bool:
        """Return whether a photo has a camera."""
        return any(view.name == name for view in self.views)

    def direction(self, view: int) -> FloatArray:
        """Return the unit vector (3,) of a photo's axis in the World frame."""
        direction = np.linalg.solve(self._from_file, self.views[view].direction)
        return np.asarray(direction / np.linalg.norm(direction))

    def to_local(self, world: npt.ArrayLike) -> FloatArray:
        """Transform World points (n, 3) to the cameras' frame."""
        points = np.asarray(world, np.float64).reshape(-1, 3)
        return np.asarray((points - self._world_origin) @ self._from_file.T)

    # --- from the model to the photos --------------------------------------------------------
    def pixels(self, view: int, world: npt.ArrayLike) -> FloatArray:
        """Project World points to pixels (n, 2); NaN outside the lens.

        Hidden points and pixels outside the photo are included.
        """
        return self.views[view].project(self.to_local(world))

    def shows(self, view: int, world: npt.ArrayLike, slack_m: float | None = None) -> BoolArray:
        """Return a mask (n,) of the World points that a photo shows and that are not hidden.

        slack_m : maximum distance behind the first surface, in the model's unit; default: twice the
        model's resolution
        """
        local_points = self.to_local(world)
        return self._shows(view, local_points, self.views[view].project(local_points), slack_m)

    def _shows(
        self, view: int, local_points: FloatArray, pixels: FloatArray, slack_m: float | None
    ) -> BoolArray:
        is_visible = self.views[view].contains(pixels)
        rows = np.flatnonzero(is_visible)
        if len(rows):
            is_visible[rows] = ~self._is_hidden(self._centres[view], local_points[rows], slack_m)
        return is_visible

    def _is_hidden(
        self, centre: FloatArray, local_points: FloatArray, slack_m: float | FloatArray | None
    ) -> BoolArray:
        sight_lines = local_points - centre
        distances = np.linalg.norm(sight_lines, axis=1)
        slack = 2.0 * self.resolution if slack_m is None else slack_m
        # A line of sight hits every cloud point that is closer to it than `tree.max_distance`.
        slack = np.minimum(slack + self.tree.max_distance, 0.5 * distances) + 1e-9 * distances
        max_fractions = 1.0 - slack / np.maximum(distances, 1e-300)
        hits = self.tree.cast(centre + self._origin, sight_lines, max_fractions)
        return np.asarray(hits.index >= 0)

    def sightings(self, world: npt.ArrayLike, slack_m: float | None = None) -> list[Sighting]:
        """Return the photos that show World points (n, 3).

        Photos are sorted by their share of visible points, in fifths and largest first, then by
        pixel size on the surface, finest first.
        """
        local_points = self.to_local(world)
        if not len(local_points) or not self.views:
            return []
        sightings = []
        for number, view in enumerate(self.views):
            pixels = view.project(local_points)
            is_visible = self._shows(number, local_points, pixels, slack_m)
            if is_visible.any():
                rows = np.flatnonzero(is_visible)
                subset = local_points[rows[:: max(1, len(rows) // _OBLIQUITY_POINTS)]]
                sightings.append(
                    Sighting(
                        number,
                        view.name,
                        pixels[rows[len(rows) // 2]],
                        float(np.median(view.depths(subset))) / self._focal(number),
                        self._obliquity(number, subset),
                        float(is_visible.mean()),
                    )
                )
        # Compare shares in fifths: a slightly larger share does not justify much coarser pixels.
        return sorted(
            sightings, key=lambda s: (-int(5 * s.share + 1e-9), s.effective_gsd_m, s.name)
        )

    def _focal(self, view: int) -> float:
        return float(np.sqrt(np.prod(self.views[view].intrinsics.focal)))

    def _obliquity(self, view: int, local_points: FloatArray) -> float | None:
        directions = local_points - self._centres[view]
        hits = self.tree.cast(self._centres[view] + self._origin, directions)
        cosines = []
        for direction, index in zip(directions, hits.index.tolist(), strict=True):
            normal = self.tree.normal(index) if index >= 0 else None
            if normal is not None:
                cosines.append(
                    abs(float(normal @ direction)) / max(float(np.linalg.norm(direction)), 1e-300)
                )
        if not cosines:
            return None
        return float(np.degrees(np.arccos(min(float(np.median(cosines)), 1.0))))

    def project_line(
        self, view: int, line: npt.ArrayLike, step_px: float = 3.0, slack_m: float | None = None
    ) -> tuple[FloatArray, BoolArray]:
        """Return pixels (k, 2) along a World polyline (n, 3), and which of them are visible.

        Visibility is tested as in `shows`. However, unless `slack_m` is given, a line may sag below
        the surface between its corners by a fraction of its length.

        step_px : approximate spacing of the pixels
        """
        local_points = self.to_local(line)
        if len(local_points) < 2:
            return np.zeros((0, 2)), np.zeros(0, np.bool_)
        steps = self._steps(view, local_points, step_px)
        pieces: list[FloatArray] = []
        slacks: list[FloatArray] = []
        for a, b, count in zip(local_points[:-1], local_points[1:], steps, strict=True):
            t = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
            pieces.append(a + t * (b - a))
            # 0 at the corners, the maximum half way between them.
            sag = 4.0 * (t * (1.0 - t)).ravel() * _MAX_SAG_SHARE * float(np.linalg.norm(b - a))
            slacks.append(sag + 2.0 * self.resolution)
        points = np.concatenate([*pieces, local_points[-1:]])
        slack = np.append(np.concatenate(slacks), 2.0 * self.resolution)
        if slack_m is not None:
            slack[:] = slack_m
        photo = self.views[view]
        pixels = photo.project(points)
        is_visible = photo.contains(pixels)
        rows = np.flatnonzero(is_visible)
        if len(rows):
            is_visible[rows] = ~self._is_hidden(self._centres[view], points[rows], slack[rows])
        return pixels, is_visible

    def _steps(self, view: int, local_points: FloatArray, step_px: float) -> list[int]:
        pixels = self.views[view].project(local_points)
        lengths = np.hypot(*np.diff(pixels, axis=0).T)
        size = float(np.hypot(*(self.views[view].intrinsics.width,) * 2))
        # The length is unknown if the lens does not show the ends.
        lengths = np.minimum(np.nan_to_num(lengths, nan=size, posinf=size), 3 * size)
        step = max(step_px, float(lengths.sum()) / _MAX_LINE_POINTS)
        return [max(1, int(np.ceil(length / step))) for length in lengths]

    # --- from a photo to the model -----------------------------------------------------------
    def intersect_model(self, view: int, pixels: npt.ArrayLike) -> FloatArray:
        """Return the World points (n, 3) where lines of sight first hit the model, or NaN.

        For a cloud, this is the point on the line of sight at the distance of the cloud point.

        pixels : (n, 2) pixels of the photo
        """
        photo = self.views[view]
        pixel_positions = np.asarray(pixels, np.float64).reshape(-1, 2)
        directions = photo.rays(pixel_positions)
        hits = self.tree.cast(self._centres[view] + self._origin, directions)
        is_hit = (hits.index >= 0) & photo.contains(pixel_positions)
        places = np.full((len(pixel_positions), 3), np.nan)
        hit_positions = self.tree.positions(hits.index[is_hit], hits.weights[is_hit])
        if not isinstance(self.tree.data, Mesh):
            start, hit_directions = self._centres[view] + self._origin, directions[is_hit]
            hit_positions = (
                start
                + ((hit_positions - start) * hit_directions).sum(axis=1, keepdims=True)
                * hit_directions
            )
        places[is_hit] = (hit_positions - self._origin) @ self._to_file.T + self._world_origin
        return places

    def pick(self, view: int, pixel: Sequence[float] | FloatArray) -> PickedSurface | None:
        """Return the surface at a pixel of a photo, or None if it is outside the model or photo."""
        photo = self.views[view]
        if not photo.contains(pixel)[0]:
            return None
        ray = photo.rays(pixel)
        hits = self.tree.cast(self._centres[view] + self._origin, ray)
        index = int(hits.index[0])
        if index < 0:
            return None
        position = self.tree.position(index, hits.weights[0])
        if not isinstance(self.tree.data, Mesh):
            return PickedSurface(index, position, None)
        a, b, c = hits.weights[0].tolist()
        return PickedSurface(index, position, (a, b, c))
