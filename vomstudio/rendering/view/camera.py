"""Camera in World coordinates, in float64 and without VTK.

All projections that the program relies on (picking, handles, labels and the scale bar) are
computed here. VTK receives the same values, minus the scene origin, for drawing only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.coordinate_limits import check_coordinates
from vomstudio.geometry.vectors import wrap360

VERTICAL_DEG = 89.0
"""Plunge above which a view is treated as vertical, with North upwards in the image."""

STANDARD_VIEWS: dict[str, tuple[float, float]] = {
    "down": (0.0, 90.0),
    "up": (0.0, -90.0),
    "north": (0.0, 0.0),
    "northeast": (45.0, 0.0),
    "east": (90.0, 0.0),
    "southeast": (135.0, 0.0),
    "south": (180.0, 0.0),
    "southwest": (225.0, 0.0),
    "west": (270.0, 0.0),
    "northwest": (315.0, 0.0),
}
"""Trend and plunge of the standard view directions; "north" is the view from the south."""

# In a parallel view, contents beyond this multiple of the pivot distance are not drawn.
DEPTH_RANGE = 1000.0

VIEW_ALIASES = {"top": "down", "bottom": "up"}
"""Synonyms of view directions; a top view looks down."""


@dataclass(frozen=True)
class Eye:
    """View for drawing and projecting: position in the World frame, axes and depth range.

    Parameters
    ----------
    right, up, direction : (3,) float64
        Orthonormal vectors; `direction` points away from the viewer.
    near, far : float
        Depth range of the scene along `direction`, both positive.
    half_height : float
        Half the height of an orthographic image in metres, or the tangent of half the angle of
        view.
    """

    position: FloatArray
    right: FloatArray
    up: FloatArray
    direction: FloatArray
    near: float
    far: float
    half_height: float
    orthographic: bool

    def depth(self, points: FloatArray) -> FloatArray:
        """Return the depth (n,) along the view direction, metres."""
        return (points - self.position) @ self.direction

    def buffer_from_depth(self, depth: float) -> float:
        """Convert a depth along the view direction, metres, to a depth-buffer value (0 to 1)."""
        if self.orthographic:
            return (depth - self.near) / (self.far - self.near)
        return self.far * (depth - self.near) / (depth * (self.far - self.near))

    def depth_from_buffer(self, z: FloatArray) -> FloatArray:
        """Convert depth-buffer values (0 to 1) to depths along the view direction, metres."""
        if self.orthographic:
            return self.near + z * (self.far - self.near)
        return self.near * self.far / (self.far - z * (self.far - self.near))


def direction_vector(trend_deg: float, plunge_deg: float) -> FloatArray:
    """Return the unit vector (East, North, Up) of a line; plunge is positive downwards."""
    t, p = math.radians(trend_deg), math.radians(plunge_deg)
    return np.array([math.sin(t) * math.cos(p), math.cos(t) * math.cos(p), -math.sin(p)])


def view_frame(trend_deg: float, plunge_deg: float) -> FloatArray:
    """Return the right, up and view directions of a view as the rows of a matrix.

    Up, or North if the view is within 1 degree of vertical, points upwards in the image.
    """
    direction = direction_vector(trend_deg, plunge_deg)
    reference = np.array([0.0, 1.0, 0.0] if abs(plunge_deg) > VERTICAL_DEG else [0.0, 0.0, 1.0])
    up = reference - (reference @ direction) * direction
    up /= np.linalg.norm(up)
    return np.stack([np.cross(direction, up), up, direction])


def turntable_frame(heading_deg: float, plunge_deg: float) -> FloatArray:
    """Return the right, up and view directions without roll, even for vertical views.

    In a vertical view, the heading alone determines the rotation of the image.
    """
    t, p = math.radians(heading_deg), math.radians(plunge_deg)
    direction = direction_vector(heading_deg, plunge_deg)
    up = np.array([math.sin(t) * math.sin(p), math.cos(t) * math.sin(p), math.cos(p)])
    return np.stack([np.cross(direction, up), up, direction])


def rotation(axis: FloatArray, angle_deg: float) -> FloatArray:
    """Return the 3 x 3 right-handed rotation matrix about a unit axis."""
    a = math.radians(angle_deg)
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation_matrix: FloatArray = np.eye(3) + math.sin(a) * k + (1.0 - math.cos(a)) * (k @ k)
    return rotation_matrix


class Camera:
    """Camera with position, orientation and scale, and its moves.

    Pixels are logical, measured from the upper-left corner; sizes are (width, height) in the
    same unit. `distance` is the depth of the pivot, at which the scale of the view is defined.
    At this depth, the orthographic and the perspective view are identical.
    """

    def __init__(self) -> None:
        self.position: FloatArray = np.array([0.0, -10.0, 0.0])
        self.frame: FloatArray = view_frame(0.0, 0.0)
        self.distance = 10.0
        self.pivot: FloatArray = np.zeros(3)
        self.view_angle_deg = 30.0
        self.orthographic = False

    @property
    def direction(self) -> FloatArray:
        direction: FloatArray = self.frame[2]
        return direction

    @property
    def tangent(self) -> float:
        return math.tan(math.radians(self.view_angle_deg) / 2.0)

    # -- properties

    def metres_per_pixel(self, height: float, depth: float | None = None) -> float:
        """Return the metres per pixel at `depth`, by default at the depth of the pivot."""
        max_distance = self.distance if self.orthographic or depth is None else depth
        return 2.0 * max_distance * self.tangent / max(height, 1.0)

    def trend_plunge(self) -> tuple[float, float]:
        """Return the trend and plunge of the view direction; the trend of a vertical view is 0."""
        x, y, z = self.direction
        plunge = math.degrees(math.asin(max(-1.0, min(1.0, -z))))
        if math.hypot(x, y) < 1e-9:
            return 0.0, plunge
        return wrap360(math.degrees(math.atan2(x, y))), plunge

    def eye(self, corners: FloatArray) -> Eye:
        """Return the eye whose depth range contains the World points `corners` (n, 3).

        The range is limited to one that a 24-bit depth buffer can resolve at the pivot, so that
        another model thousands of kilometres away (for example in another frame) does not impair
        the view. An orthographic eye is moved back until everything is in front of it, which
        does not change the image.
        """
        position = self.position
        depth = (corners - position) @ self.direction if len(corners) else np.zeros(0)
        depth = depth[np.isfinite(depth)]
        nearest_depth, farthest = (
            (float(depth.min()), float(depth.max())) if len(depth) else (0.5, 2.0 * self.distance)
        )
        margin = 0.05 * (farthest - nearest_depth) + 0.02 * self.distance + 1e-6
        nearest_depth, farthest = nearest_depth - margin, farthest + margin
        if self.orthographic:
            max_distance = DEPTH_RANGE * self.distance
            nearest_depth = max(nearest_depth, min(farthest, self.distance) - max_distance)
            farthest = min(farthest, max(nearest_depth, self.distance) + max_distance)
            extra_distance = max(0.0, 1e-3 * (farthest - nearest_depth) - nearest_depth)
            position = position - extra_distance * self.direction
            nearest_depth, farthest = nearest_depth + extra_distance, farthest + extra_distance
            half_height = self.distance * self.tangent
        else:
            farthest = max(farthest, 1e-3 * self.distance)
            nearest_depth = max(nearest_depth, min(5e-4 * farthest, 0.1 * self.distance), 1e-6)
            nearest_depth = min(nearest_depth, 0.5 * farthest)
            half_height = self.tangent
        right, up, direction = self.frame
        return Eye(
            position, right, up, direction, nearest_depth, farthest, half_height, self.orthographic
        )

    def project(
        self, points: FloatArray, size: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the pixels (n, 2) and depths (n,) of points, NaN behind a perspective viewer."""
        q = (np.asarray(points, float).reshape(-1, 3) - self.position) @ self.frame.T
        width, height = size
        depth = q[:, 2]
        if self.orthographic:
            scale = np.full(len(q), height / (2.0 * self.distance * self.tangent))
        else:
            with np.errstate(divide="ignore", invalid="ignore"):
                scale = np.where(depth > 0.0, height / (2.0 * self.tangent * depth), np.nan)
        pixels = np.stack([width / 2.0 + q[:, 0] * scale, height / 2.0 - q[:, 1] * scale], axis=1)
        return pixels, depth

    def ray(self, x: float, y: float, size: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Return the World origin and unit direction of the ray through a pixel."""
        width, height = size
        a = (x - width / 2.0) * 2.0 * self.tangent / height
        b = (height / 2.0 - y) * 2.0 * self.tangent / height
        right, up, direction = self.frame
        if self.orthographic:
            return self.position + self.distance * (a * right + b * up), direction.copy()
        d = direction + a * right + b * up
        return self.position.copy(), d / np.linalg.norm(d)

    def point_at_depth(
        self, x: float, y: float, size: tuple[float, float], depth: float
    ) -> FloatArray:
        """Return the World point at a pixel and a depth along the view direction."""
        origin, d = self.ray(x, y, size)
        return origin + d * (depth - (origin - self.position) @ self.direction) / (
            d @ self.direction
        )

    # -- moves

    def set_pivot(self, point: FloatArray) -> None:
        """Set the pivot of rotations without changing the image."""
        self.pivot = np.asarray(point, float).copy()
        depth = float((self.pivot - self.position) @ self.direction)
        if self.orthographic:
            self.position = self.position + (depth - self.distance) * self.direction
        elif depth > 0.0:
            self.distance = depth

    def orbit(self, heading_deg: float, plunge_deg: float) -> None:
        """Rotate about the pivot by changes of heading and plunge, keeping the z axis upright."""
        x, y, z = self.direction
        up = self.frame[1]
        plunge = math.degrees(math.asin(max(-1.0, min(1.0, -z))))
        level = math.hypot(x, y)
        if level < 0.02 and math.hypot(up[0], up[1]) > 0.5:
            sign = 1.0 if z < 0.0 else -1.0
            heading = math.degrees(math.atan2(sign * up[0], sign * up[1]))
        else:
            heading = math.degrees(math.atan2(x, y))
        frame = turntable_frame(heading + heading_deg, max(-90.0, min(90.0, plunge + plunge_deg)))
        self._turn_to(frame)

    def tumble(self, right_deg: float, up_deg: float) -> None:
        """Rotate about the pivot around the image axes, like a trackball."""
        rotation_matrix = rotation(self.frame[1], -right_deg) @ rotation(self.frame[0], -up_deg)
        frame = self.frame @ rotation_matrix.T
        frame[2] /= np.linalg.norm(frame[2])
        frame[0] = np.cross(frame[2], frame[1])
        frame[0] /= np.linalg.norm(frame[0])
        frame[1] = np.cross(frame[0], frame[2])
        self._turn_to(frame)

    def _turn_to(self, frame: FloatArray) -> None:
        # The pivot keeps its camera coordinates and therefore its pixel.
        pivot_offset = self.frame @ (self.pivot - self.position)
        self.frame = frame
        self.position = self.pivot - frame.T @ pivot_offset

    def look_along(self, trend_deg: float, plunge_deg: float) -> None:
        """Look along a direction, keeping the pixel of the pivot."""
        self._turn_to(view_frame(trend_deg, plunge_deg))

    def zoom(self, factor: float, centre: FloatArray) -> None:
        """Multiply the distance to the point `centre` by a factor, keeping its pixel."""
        centre = np.asarray(centre, float)
        distance = self.distance * factor
        if not 1e-4 < distance < 1e8:
            return
        self.position = centre + (self.position - centre) * factor
        self.distance = distance

    def pan(self, dx: float, dy: float, height: float, depth: float | None = None) -> None:
        """Pan by (dx, dy) pixels, so that points at `depth` remain under the cursor."""
        step = self.metres_per_pixel(height, depth)
        right, up, _ = self.frame
        self.position = self.position - dx * step * right + dy * step * up

    def fit(self, points: FloatArray, size: tuple[float, float]) -> None:
        """Show all `points` (n, 3) with the pivot at their centre, keeping the direction."""
        points = np.asarray(points, float).reshape(-1, 3)
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return
        width, height = size
        total_height = self.tangent
        total_width = total_height * width / max(height, 1.0)
        # Reduces contiguous rows, because extremes of the columns of (n, 3) take four times as
        # long.
        q = np.ascontiguousarray((points @ self.frame.T).T)
        centre = (q.min(axis=1) + q.max(axis=1)) / 2.0
        depth = 0.0
        # In perspective, the centre of the image is not the centre of the box, and is found by
        # iteration.
        for _ in range(8):
            p = q - centre[:, None]
            if self.orthographic:
                depth = float(
                    max(np.abs(p[1]).max() / total_height, np.abs(p[0]).max() / total_width)
                )
                break
            depth = float(
                max(
                    (np.abs(p[1]) / total_height - p[2]).max(),
                    (np.abs(p[0]) / total_width - p[2]).max(),
                )
            )
            depth = max(depth, float(-p[2].min()) * 1.01 + 1e-3)
            image_points = p[:2] / (p[2] + depth)
            centre[:2] += (image_points.min(axis=1) + image_points.max(axis=1)) / 2.0 * depth
        self.distance = max(depth * 1.06, 1e-2)
        self.pivot = self.frame.T @ centre
        self.position = self.pivot - self.distance * self.direction

    # -- stored view state

    def to_dict(self) -> dict[str, Any]:
        return {
            "position": self.position.tolist(),
            "right": self.frame[0].tolist(),
            "up": self.frame[1].tolist(),
            "distance": float(self.distance),
            "pivot": self.pivot.tolist(),
            "view_angle_deg": float(self.view_angle_deg),
            "orthographic": bool(self.orthographic),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Restore a state of `to_dict`. If it is invalid, raise ValueError and change nothing."""
        try:
            position = np.array(state["position"], float)
            right = np.array(state["right"], float)
            up = np.array(state["up"], float)
            pivot = np.array(state["pivot"], float)
            distance = float(state["distance"])
            angle = float(state["view_angle_deg"])
            orthographic = bool(state["orthographic"])
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"not a camera state: {error}") from error
        values = np.concatenate([position, right, up, pivot, [distance, angle]])
        if values.shape != (14,) or not np.isfinite(values).all() or distance <= 0.0:
            raise ValueError("not a camera state: numbers missing or not finite")
        if check_coordinates([*position, *pivot, distance]) is not None:
            raise ValueError("not a camera state: too far from anything")
        if not 1.0 <= angle <= 120.0 or np.linalg.norm(np.cross(right, up)) < 1e-6:
            raise ValueError("not a camera state: the view angle or the axes cannot be")
        up = up / np.linalg.norm(up)
        right = right - (right @ up) * up
        right = right / np.linalg.norm(right)
        self.position, self.pivot = position, pivot
        self.frame = np.stack([right, up, np.cross(up, right)])
        self.distance, self.view_angle_deg, self.orthographic = distance, angle, orthographic
