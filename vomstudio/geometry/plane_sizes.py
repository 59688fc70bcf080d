"""How large a plane must be for its direction to be known: the one answer of planner, survey check,
report and verdict.

A plane is taken as a disc that the model shows by independent points, one for each square of its
resolution, with Gaussian noise across it; natural waviness of the rock comes on top. The expected
95 % error is that of the verdict: the joint region of the fitted normal (F test, two slopes), never
less than what the resolution can tilt over the disc's shorter axis, and in quadrature the error of
the registration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from vomstudio.core.results import OPTIONAL

PIXELS_PER_RESOLUTION = 10.0
"""A cloud from photos resolves about ten pixels of them (textbook 3.2.1)."""
NOISE_PIXELS = 0.5
"""Of a dense cloud across its surface, one sigma: on made faces of known truth 95 % of the points
lie within one pixel."""
TEXTBOOK_RESOLUTIONS = 100.0
"""Two orders of magnitude between a feature and the resolution (4.1.3): 1000 pixels."""
LEAST_RESOLUTIONS = 10.0
"""Below so many no error can be believed."""
POINT_OVER_RESOLUTION = 0.08
"""Ours, by tests/benchmarks/bench_verdicts.py: error of each point of a trace, one sigma, that its
residuals may not show."""
WANTED_DEG = 5.0
"""The 95 % error up to which the verdict on a plane is good."""
# Of the extents for which the curve is told, in resolutions.
_TOLD = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


def resolution_tilt_deg(resolution: float, across: float) -> float:
    """Half of the resolution over the shorter axis of a feature, degrees."""
    return math.degrees(math.atan2(0.5 * resolution, across))


def within_wander(second: float, extent: float, n: int, resolution: float) -> bool:
    """Whether a trace is no wider than one that strays from a straight line along a flat face:
    such a width is no evidence of how its plane turns about the line.

    second : variance of the n points along the second axis of their plane; extent : their length
    Ours: points stray by one resolution, one sigma. On flat walls those of followed traces have
    0.4 to 0.6, and 95 % of the traces less than 1 (tests/benchmarks/bench_followed.py); who picks
    by hand hardly does better. Where points lie closer than half of it, as those of a photo's
    pixels, they stray less, in the measure of their distance; but within half a resolution no model
    tells a bend from a straight line.
    """
    free = max(n - 2.0, 1.0)
    # Of few points the variance may be larger by chance: chi squared's 95 % by Wilson and Hilferty.
    term = 2.0 / (9.0 * free)
    chance = free * (1.0 - term + 1.645 * math.sqrt(term)) ** 3 / n
    scale = min(max(2.0 * extent / max(n - 1, 1), 0.5 * resolution), resolution)
    return second <= chance * scale**2


def _confidence95_deg(spread: float, noise: float, free: float) -> float:
    """`plane_errors.confidence_axes_rad` for one round plane, without the libraries that it needs:
    the window starts with this module. Variances in the plane and across it."""
    quantile = math.expm1(-2.0 / free * math.log(0.05))
    gap = spread - noise
    if gap <= 0.0:
        return 90.0
    sine = 2.0 * math.sqrt(quantile * spread * noise) / gap
    return 0.5 * math.degrees(math.asin(sine)) if sine < 1.0 else 90.0


@dataclass(frozen=True)
class PlaneError:
    """size_m : diameter of a plane, None where the model has no metres
    error95_deg : expected 95 % half-angle of its normal
    size : the diameter in the unit of the model, where that is not the metre"""

    size_m: float | None
    error95_deg: float
    size: float | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class PlaneSizes:
    """resolution : of the model; noise : one sigma across its surface; both in one unit of length,
    in which all sizes are. registration_deg : 95 % half-angle of the model's rotation, 0 where
    there is none or none is known"""

    resolution: float
    noise: float
    registration_deg: float = 0.0

    @classmethod
    def of_pixels(cls, pixel: float, registration_deg: float = 0.0) -> PlaneSizes:
        """What photos of this pixel size on the rock can be expected to give."""
        return cls(PIXELS_PER_RESOLUTION * pixel, NOISE_PIXELS * pixel, registration_deg)

    @classmethod
    def of_model(
        cls, resolution: float, noise: float | None = None, registration_deg: float = 0.0
    ) -> PlaneSizes:
        """noise : None where it is not known: as much as photos with this resolution leave"""
        usual = resolution * NOISE_PIXELS / PIXELS_PER_RESOLUTION
        return cls(resolution, usual if noise is None else noise, registration_deg)

    @property
    def textbook(self) -> float:
        """Extent of 100 resolutions, the limit of section 4.1.3."""
        return TEXTBOOK_RESOLUTIONS * self.resolution

    @property
    def least(self) -> float:
        """Extent below which no error is told."""
        return LEAST_RESOLUTIONS * self.resolution

    def error_deg(self, size: float) -> float | None:
        """Expected 95 % half-angle of a plane of this diameter; None below `least`."""
        if not size >= self.least * (1.0 - 1e-9):
            return None
        # One point for each square of the resolution; three are spent on the plane.
        free = math.pi / 4.0 * (size / self.resolution) ** 2 - 3.0
        # A uniform disc has a variance of (d / 4)^2 along each diameter.
        fit = _confidence95_deg((size / 4.0) ** 2, self.noise**2, free)
        # A strip with the same variance is sqrt(12) d / 4 wide.
        tilt = resolution_tilt_deg(self.resolution, math.sqrt(12.0) * size / 4.0)
        return min(90.0, math.hypot(max(fit, tilt), self.registration_deg))

    def size_for(self, error_deg: float = WANTED_DEG) -> float | None:
        """The smallest diameter with this expected error or less; None where the registration
        alone is worse."""
        if error_deg <= self.registration_deg:
            return None
        low = high = self.least
        # The error falls with the size, to that of the registration.
        while (self.error_deg(high) or 0.0) > error_deg:
            low, high = high, 2.0 * high
            if high > 1e9 * self.resolution:
                return None
        if high == self.least:
            return high
        for _ in range(60):
            middle = 0.5 * (low + high)
            if (self.error_deg(middle) or 0.0) > error_deg:
                low = middle
            else:
                high = middle
        return high

    def curve(self, *, metric: bool = True) -> tuple[PlaneError, ...]:
        """From 10 to 1000 resolutions, the textbook's limit of 100 among them. metric : whether the
        sizes are in metres"""
        sizes = [times * self.resolution for times in _TOLD]
        errors = [(size, self.error_deg(size)) for size in sizes]
        return tuple(
            PlaneError(size, error) if metric else PlaneError(None, error, size)
            for size, error in errors
            if error is not None
        )
