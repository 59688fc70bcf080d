"""Camera geometry of photos: collinearity equations with lens distortion.

Pixels follow COLMAP: x to the right, y down, (0.5, 0.5) is the centre of the top-left pixel of the
photo as stored in the file (an orientation tag rotates the image for display but does not affect
these pixels). The camera frame has x to the right, y down and z along the viewing direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

CAMERA_MODELS: dict[str, tuple[str, ...]] = {
    "SIMPLE_PINHOLE": ("f", "cx", "cy"),
    "PINHOLE": ("fx", "fy", "cx", "cy"),
    "SIMPLE_RADIAL": ("f", "cx", "cy", "k1"),
    "RADIAL": ("f", "cx", "cy", "k1", "k2"),
    "OPENCV": ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"),
    "FULL_OPENCV": (*("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),),
    "OPENCV_FISHEYE": ("fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"),
}
"""Names and order of the parameters as in COLMAP; focal lengths and principal point in pixels."""

# Radius at which the search for the edge of a lens ends: the tangent of 80 degrees from the axis.
MAX_RADIUS = 5.7


@dataclass(frozen=True)
class Intrinsics:
    """Interior orientation of a camera, including its lens distortion.

    Parameters
    ----------
    model : str
        One of `CAMERA_MODELS`.
    width, height : int
        Size of the photos, pixels.
    params : tuple of float
        Parameters in the order of ``CAMERA_MODELS[model]``.

    Raises
    ------
    GeometryError
        If the model is unknown or the number of parameters is wrong.
    """

    model: str
    width: int
    height: int
    params: tuple[float, ...]

    def __post_init__(self) -> None:
        names = CAMERA_MODELS.get(self.model)
        if names is None:
            raise GeometryError(
                Finding("lens.unknown-model", model=self.model, models=tuple(CAMERA_MODELS))
            )
        if len(names) != len(self.params):
            raise GeometryError(
                Finding(
                    "lens.parameter-count",
                    model=self.model,
                    needed=len(names),
                    given=len(self.params),
                )
            )

    @classmethod
    def pinhole(cls, width: int, height: int, f: float, cx: float, cy: float) -> Intrinsics:
        return cls("PINHOLE", width, height, (f, f, cx, cy))

    @cached_property
    def _named_parameters(self) -> dict[str, float]:
        return dict(zip(CAMERA_MODELS[self.model], self.params, strict=True))

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths in x and in y, pixels."""
        parameters = self._named_parameters
        return (
            (parameters["f"], parameters["f"])
            if "f" in parameters
            else (parameters["fx"], parameters["fy"])
        )

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point, pixels."""
        return self._named_parameters["cx"], self._named_parameters["cy"]

    @property
    def matrix(self) -> FloatArray:
        """Calibration matrix (3, 3), without the distortion."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @property
    def has_distortion(self) -> bool:
        parameters = self._named_parameters
        return self.model == "OPENCV_FISHEYE" or any(
            value != 0.0 for name, value in parameters.items() if name[0] in "kp"
        )

    def project(self, points: npt.ArrayLike) -> FloatArray:
        """Project points (n, 3) in the camera frame to pixels (n, 2).

        The pixels are NaN for points behind the camera, and for points beyond the radius at which
        the polynomial of the lens has its maximum.
        """
        xyz = np.asarray(points, np.float64).reshape(-1, 3)
        with np.errstate(divide="ignore", invalid="ignore"):
            normalized_points = np.where(xyz[:, 2:] > 0, xyz[:, :2] / xyz[:, 2:], np.nan)
            normalized_points = np.where(
                np.hypot(*normalized_points.T)[:, None] <= self._max_ideal_radius,
                normalized_points,
                np.nan,
            )
            distorted_points = self._distort(normalized_points)
        return distorted_points * self.focal + self.centre

    def rays(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return the directions (n, 3) of pixels (n, 2) in the camera frame, with z = 1.

        Directions are NaN outside the range of the lens.
        """
        normalized_pixels = (
            np.asarray(pixels, np.float64).reshape(-1, 2) - self.centre
        ) / self.focal
        undistorted_points = (
            self._undistort(normalized_pixels) if self.has_distortion else normalized_pixels
        )
        return np.column_stack([undistorted_points, np.ones(len(undistorted_points))])

    def scaled(self, width: int, height: int) -> Intrinsics:
        """Return the camera for photos resampled to another size."""
        sx, sy = width / self.width, height / self.height
        parameters = dict(self._named_parameters)
        if "f" in parameters:
            parameters["f"] *= (sx + sy) / 2
        else:
            parameters["fx"], parameters["fy"] = parameters["fx"] * sx, parameters["fy"] * sy
        parameters["cx"], parameters["cy"] = parameters["cx"] * sx, parameters["cy"] * sy
        return Intrinsics(
            self.model, width, height, tuple(parameters[n] for n in CAMERA_MODELS[self.model])
        )

    # ------------------------------------------------------------------------------------------
    def _distort(self, normalized_points: FloatArray) -> FloatArray:
        """Convert ideal to distorted image coordinates (n, 2), in units of the focal length."""
        parameters = self._named_parameters
        r2 = (normalized_points**2).sum(1)
        if self.model == "OPENCV_FISHEYE":
            r = np.sqrt(r2)
            with np.errstate(divide="ignore", invalid="ignore"):
                factor = np.where(r > 1e-12, self._distorted_radius(r) / r, 1.0)
            return normalized_points * factor[:, None]
        distorted_points = normalized_points * self._radial_factor(r2)[:, None]
        p1, p2 = parameters.get("p1", 0.0), parameters.get("p2", 0.0)
        if p1 or p2:
            x, y = normalized_points.T
            distorted_points = distorted_points + np.column_stack(
                [2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y]
            )
        return distorted_points

    def _radial_factor(self, r2: FloatArray) -> FloatArray:
        get = self._named_parameters.get
        numerator = 1 + r2 * (get("k1", 0.0) + r2 * (get("k2", 0.0) + r2 * get("k3", 0.0)))
        denominator = 1 + r2 * (get("k4", 0.0) + r2 * (get("k5", 0.0) + r2 * get("k6", 0.0)))
        return numerator / denominator

    def _distorted_radius(self, r: FloatArray) -> FloatArray:
        """Convert an ideal radius to the distorted radius."""
        if self.model != "OPENCV_FISHEYE":
            return r * self._radial_factor(r * r)
        parameters, angle = self._named_parameters, np.arctan(r)
        a2 = angle * angle
        k1, k2, k3, k4 = (parameters[n] for n in ("k1", "k2", "k3", "k4"))
        return angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))

    @cached_property
    def _max_ideal_radius(self) -> float:
        """Ideal radius up to which the distorted radius increases."""
        if not self.has_distortion:
            return np.inf
        r = np.linspace(0.0, MAX_RADIUS, 5701)
        with np.errstate(divide="ignore", invalid="ignore"):
            distorted_radii = self._distorted_radius(r)
        falling_rows = np.flatnonzero(~(np.diff(distorted_radii) > 0))
        return float(r[falling_rows[0]]) if len(falling_rows) else np.inf

    def _undistort(self, distorted_points: FloatArray) -> FloatArray:
        """Invert `_distort` by Newton's method.

        The start values neglect the tangential distortion. The result is NaN for points at which
        the iteration does not converge.
        """
        max_radius = min(self._max_ideal_radius, MAX_RADIUS)
        r = np.linspace(0.0, max_radius, 2000)
        distorted_radii = self._distorted_radius(r)
        radii: FloatArray = np.hypot(distorted_points[:, 0], distorted_points[:, 1])
        initial_radii = np.interp(radii, distorted_radii, r)
        with np.errstate(divide="ignore", invalid="ignore"):
            normalized_points = np.where(
                radii[:, None] > 1e-12,
                distorted_points / radii[:, None] * initial_radii[:, None],
                distorted_points,
            )
        step = 1e-6
        for _ in range(12):
            residuals = self._distort(normalized_points) - distorted_points
            if not np.nanmax(np.abs(residuals), initial=0.0) > 1e-14:
                break
            dx = (
                self._distort(normalized_points + [step, 0.0])
                - self._distort(normalized_points - [step, 0.0])
            ) / (2 * step)
            dy = (
                self._distort(normalized_points + [0.0, step])
                - self._distort(normalized_points - [0.0, step])
            ) / (2 * step)
            with np.errstate(divide="ignore", invalid="ignore"):
                det = dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]
                normalized_points = normalized_points - np.column_stack(
                    [
                        (residuals[:, 0] * dy[:, 1] - residuals[:, 1] * dy[:, 0]) / det,
                        (dx[:, 0] * residuals[:, 1] - dx[:, 1] * residuals[:, 0]) / det,
                    ]
                )
        has_failed = (
            np.abs(self._distort(normalized_points) - distorted_points).max(axis=1, initial=0.0)
            > 1e-8
        )
        normalized_points = np.where(has_failed[:, None], np.nan, normalized_points)
        return normalized_points


@dataclass(frozen=True, eq=False)
class View:
    """Photo with its camera and its pose: x_camera = rotation @ x + translation.

    Attributes
    ----------
    name : str
        Name of the photo, relative to its folder, with forward slashes.
    rotation : (3, 3) ndarray
        Rotation from the scene to the camera frame.
    translation : (3,) ndarray
        Translation in the unit of the scene.
    """

    name: str
    intrinsics: Intrinsics
    rotation: FloatArray
    translation: FloatArray

    @property
    def centre(self) -> FloatArray:
        """Projection centre (3,) in scene coordinates."""
        return np.asarray(-self.rotation.T @ self.translation)

    @property
    def direction(self) -> FloatArray:
        """Unit vector (3,) along the optical axis, in scene coordinates."""
        return np.asarray(self.rotation[2])

    def depths(self, points: npt.ArrayLike) -> FloatArray:
        """Return distances (n,) of scene points (n, 3) along the optical axis."""
        projections = np.asarray(points, np.float64) @ self.rotation[2]
        return np.asarray(projections + self.translation[2])

    def project(self, points: npt.ArrayLike) -> FloatArray:
        """Project scene points (n, 3) to pixels (n, 2), which may be outside the photo.

        Pixels are NaN under the conditions of `Intrinsics.project`.
        """
        xyz = np.asarray(points, np.float64).reshape(-1, 3)
        return self.intrinsics.project(xyz @ self.rotation.T + self.translation)

    def rays(self, pixels: npt.ArrayLike) -> FloatArray:
        """Return the unit directions (n, 3), in the scene, from `centre` through pixels (n, 2)."""
        rays = self.intrinsics.rays(pixels) @ self.rotation
        return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

    def contains(self, pixels: npt.ArrayLike) -> BoolArray:
        """Return a mask of the pixels (n, 2) that are inside the photo."""
        x, y = np.asarray(pixels, np.float64).reshape(-1, 2).T
        width, height = self.intrinsics.width, self.intrinsics.height
        return np.asarray((x >= 0) & (x <= width) & (y >= 0) & (y <= height))

    def moved(self, scale: float, rotation: FloatArray, translation: FloatArray) -> View:
        """Return the photo after a similarity of the scene.

        The similarity is x' = scale * rotation @ x + translation.
        """
        new_rotation = self.rotation @ rotation.T
        return View(
            self.name,
            self.intrinsics,
            new_rotation,
            scale * self.translation - new_rotation @ np.asarray(translation),
        )
