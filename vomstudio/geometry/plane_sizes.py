"""Plane size required for a given error.

It is used by the planner, the survey check, the report and the verdict.

A plane is modelled as a disc with one independent point per resolution cell and with Gaussian noise
across the disc; natural waviness of the rock is not included. The expected 95 % error is the error
used for the verdict: the joint region of the fitted normal (F test, two slopes), but at least the
tilt by the resolution over the shorter axis of the disc, combined in quadrature with the error of
the registration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from vomstudio.core.results import OPTIONAL_IN_JSON

PIXELS_PER_RESOLUTION = 10.0
"""Resolution of a cloud from photos, in photo pixels (textbook 3.2.1)."""
NOISE_PIXELS = 0.5
"""One-sigma noise of a dense cloud across its surface. On synthetic faces, 95 % of the points are
within one pixel.
"""
TEXTBOOK_RESOLUTIONS = 100.0
"""Ratio between the size of a feature and the resolution (textbook 4.1.3), equal to 1000 pixels."""
MIN_RESOLUTIONS = 10.0
"""Minimum size of a plane with a reliable error, in multiples of the resolution."""
POINT_OVER_RESOLUTION = 0.08
"""One-sigma error of each point of a trace that its residuals may not reveal, in multiples of the
resolution. This is our own choice, from tests/benchmarks/bench_verdicts.py.
"""
TARGET_ERROR_DEG = 5.0
"""Maximum 95 % error of a plane with a good verdict."""
# Extents of the curve, in multiples of the resolution.
CURVE_RESOLUTIONS = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


def resolution_tilt_deg(resolution: float, width: float) -> float:
    """Return the tilt that an offset of half the resolution causes over the shorter axis.

    Parameters
    ----------
    resolution, width : float
        Resolution and length of the shorter axis, in the same unit.

    Returns
    -------
    float
        Tilt, degrees.
    """
    return math.degrees(math.atan2(0.5 * resolution, width))


def is_width_within_wander(
    second_variance: float, extent: float, n: int, resolution: float
) -> bool:
    """Return whether the width of a trace may be due to wandering along a flat face.

    Such a width does not determine the rotation of its plane about the line. Our own choice is that
    points wander by one resolution (one sigma). On flat walls, followed traces wander by 0.4 to 0.6
    resolutions, and 95 % of them by less than 1 (tests/benchmarks/bench_followed.py); manual picks
    are slightly better. Points closer than half a resolution, such as pixels of a photo, wander
    less, in proportion to their distance; but no model distinguishes a bend from a straight line
    within half a resolution.

    Parameters
    ----------
    second_variance : float
        Variance of the points along the second axis of their plane, m2.
    extent : float
        Length of the trace, m.
    n : int
        Number of points.
    resolution : float
        Resolution of the model, m.
    """
    dof = max(n - 2.0, 1.0)
    # The variance of few points may be larger by chance: 95 % of chi squared by Wilson-Hilferty.
    term = 2.0 / (9.0 * dof)
    max_ratio = dof * (1.0 - term + 1.645 * math.sqrt(term)) ** 3 / n
    scale = min(max(2.0 * extent / max(n - 1, 1), 0.5 * resolution), resolution)
    return second_variance <= max_ratio * scale**2


def _confidence95_deg(spread: float, noise: float, dof: float) -> float:
    """Compute `plane_errors.confidence_axes_rad` for a round plane, in degrees.

    The libraries of that module are not imported, because the window needs this module when it
    starts. `spread` and `noise` are the variances in the plane and across it.
    """
    quantile = math.expm1(-2.0 / dof * math.log(0.05))
    gap = spread - noise
    if gap <= 0.0:
        return 90.0
    sine = 2.0 * math.sqrt(quantile * spread * noise) / gap
    return 0.5 * math.degrees(math.asin(sine)) if sine < 1.0 else 90.0


@dataclass(frozen=True)
class PlaneError:
    """Expected error of a plane of a given size.

    Attributes
    ----------
    size_m : float or None
        Diameter, m; None if the unit of the model is not the metre.
    error95_deg : float
        Expected 95 % half-angle of the normal, degrees.
    size : float or None
        Diameter in the unit of the model if this unit is not the metre.
    """

    size_m: float | None
    error95_deg: float
    size: float | None = field(default=None, metadata=OPTIONAL_IN_JSON)


@dataclass(frozen=True)
class PlaneSizes:
    """Errors of planes by size, in one unit of length.

    Attributes
    ----------
    resolution : float
        Resolution of the model.
    noise : float
        One-sigma noise across the surface of the model.
    registration_deg : float
        95 % half-angle of the rotation of the model, degrees; 0 if unknown.
    """

    resolution: float
    noise: float
    registration_deg: float = 0.0

    @classmethod
    def from_pixel_size(cls, pixel: float, registration_deg: float = 0.0) -> PlaneSizes:
        """Return the sizes expected for photos with this pixel size on the rock."""
        return cls(PIXELS_PER_RESOLUTION * pixel, NOISE_PIXELS * pixel, registration_deg)

    @classmethod
    def from_resolution(
        cls, resolution: float, noise: float | None = None, registration_deg: float = 0.0
    ) -> PlaneSizes:
        """Return the sizes for a model.

        By default, the noise is the value expected for photos with this resolution.
        """
        default_noise = resolution * NOISE_PIXELS / PIXELS_PER_RESOLUTION
        return cls(resolution, default_noise if noise is None else noise, registration_deg)

    @property
    def textbook(self) -> float:
        """Extent of 100 resolutions, the limit of section 4.1.3."""
        return TEXTBOOK_RESOLUTIONS * self.resolution

    @property
    def min_size(self) -> float:
        """Minimum extent with a reported error."""
        return MIN_RESOLUTIONS * self.resolution

    def error_deg(self, size: float) -> float | None:
        """Return the expected 95 % half-angle for a diameter, or None below `min_size`."""
        if not size >= self.min_size * (1.0 - 1e-9):
            return None
        # One point per square of the resolution; the plane has three parameters.
        degrees_of_freedom = math.pi / 4.0 * (size / self.resolution) ** 2 - 3.0
        # A uniform disc has a variance of (d / 4)^2 along each diameter.
        fit = _confidence95_deg((size / 4.0) ** 2, self.noise**2, degrees_of_freedom)
        # A strip with the same variance is sqrt(12) d / 4 wide.
        tilt = resolution_tilt_deg(self.resolution, math.sqrt(12.0) * size / 4.0)
        return min(90.0, math.hypot(max(fit, tilt), self.registration_deg))

    def size_for_error(self, error_deg: float = TARGET_ERROR_DEG) -> float | None:
        """Return the smallest diameter with this expected error.

        The result is None if the error of the registration is not smaller.
        """
        if error_deg <= self.registration_deg:
            return None
        low = high = self.min_size
        # The error decreases with size to that of the registration.
        while (self.error_deg(high) or 0.0) > error_deg:
            low, high = high, 2.0 * high
            if high > 1e9 * self.resolution:
                return None
        if high == self.min_size:
            return high
        for _ in range(60):
            centre = 0.5 * (low + high)
            if (self.error_deg(centre) or 0.0) > error_deg:
                low = centre
            else:
                high = centre
        return high

    def curve(self, *, is_metric: bool = True) -> tuple[PlaneError, ...]:
        """Return the errors of sizes from 10 to 1000 resolutions, metres if `is_metric`."""
        sizes = [factor * self.resolution for factor in CURVE_RESOLUTIONS]
        errors = [(size, self.error_deg(size)) for size in sizes]
        return tuple(
            PlaneError(size, error) if is_metric else PlaneError(None, error, size)
            for size, error in errors
            if error is not None
        )
