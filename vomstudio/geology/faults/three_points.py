"""The plane through three points or more, and how well they tell it.

Its errors are those of all planes that the points do not contradict: a normal n belongs to them
where n' S n, S the scatter of the points about their mean, is larger than the least one by no more
than the errors of the points allow (chi-squared, or F where the misfit tells these errors). Those
normals fill an elliptic cone, and of points nearly on one line all planes that hold the line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import FLAT
from vomstudio.geology.measured import CONE95
from vomstudio.geology.orientation import Plane, normals_to_planes
from vomstudio.geometry.rotation_errors import Z95

# Points are nearly on a line where they spread beside it so little of what they do along it.
_NEARLY_ON_A_LINE = 0.05
_UNSURE_DEG = 30.0
# Points that are wide by chance alone would tell a dip direction that is wrong.
_TELLS_NO_DIRECTION_DEG = 20.0
# A width that is error alone passes for a plane so often.
_BY_CHANCE = 0.02
_A_CENTIMETRE = 0.01
_AROUND = np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False)


@dataclass(frozen=True, repr=False)
class ThreePoints(PrintableResult):
    """The plane through three points, or the best one through more of them, with the 95 % errors of
    its dip and dip direction, each by itself, and the half-angle of its 95 % cone in the worst
    direction; None where nothing is known of the points' errors. Where a plane may be off more to
    one side than to the other, the larger one is told. A dip direction uncertain by more
    than 90 degrees is None, and so is that of a plane that may be off by 20 degrees, or of four
    points whose one degree of freedom alone tells their error. n points; rms_m : of their distances
    from the plane, None of three, which leave none; sigma_m : standard deviation of each coordinate
    behind the errors, as it was stated, or as more than three points tell it themselves; warnings :
    what makes the plane doubtful; dropped_lines : of the table, without a place"""

    plane: Plane = field(metadata=FLAT)
    dip_error_deg: float | None
    dip_direction_error_deg: float | None
    max_confidence95_deg: float | None
    n: int = 3
    rms_m: float | None = None
    sigma_m: float | None = None
    warnings: tuple[Finding, ...] = ()
    dropped_lines: tuple[int, ...] = ()

    @property
    def dip_direction_deg(self) -> float:
        return self.plane.dip_direction_deg

    @property
    def dip_deg(self) -> float:
        return self.plane.dip_deg

    @property
    def strike_rhr_deg(self) -> float:
        return self.plane.strike_rhr_deg

    def of_table(self, dropped: tuple[int, ...], warnings: tuple[Finding, ...]) -> ThreePoints:
        """The same, with what the table said that its points are from."""
        return replace(self, dropped_lines=dropped, warnings=(*warnings, *self.warnings))

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return super().to_dict() | {"strike_rhr_deg": self.strike_rhr_deg}


def plane_of_three_points(points: npt.ArrayLike, sigma_m: float = 0.0) -> ThreePoints:
    """The three-point problem: points (n, 3) in World on one surface, n at least 3; of more than
    three the plane of least squares. sigma_m : standard deviation of each coordinate; without it
    the misfit of more than three points tells it, and their errors follow Student and Fisher with
    n - 3 degrees of freedom. Raises GeometryError for fewer points and points on one line."""
    p = np.asarray(points, np.float64)
    if p.ndim != 2 or p.shape[1] != 3 or not np.isfinite(p).all():
        raise GeometryError(Finding("points.invalid"))
    n = len(p)
    if n < 3:
        raise GeometryError(Finding("feature.too-few-points", count=3 - n, minimum=3))
    apart = p - p.mean(axis=0)
    longest = float(np.linalg.norm(apart, axis=1).max())
    _, sizes, axes = np.linalg.svd(apart, full_matrices=False)
    if not longest or sizes[1] <= 1e-9 * longest:
        raise GeometryError(Finding("points.collinear", n=n))
    direction, dip, _ = normals_to_planes(axes[2])
    plane = Plane(float(direction[0]), float(dip[0]))
    rms = None if n == 3 else float(np.sqrt(((apart @ axes[2]) ** 2).mean()))
    sigma, single, joint = sigma_m, Z95, CONE95
    if rms is not None and not sigma_m:
        from scipy.stats import f, t

        sigma = rms * math.sqrt(n / (n - 3))
        single = float(t.ppf(0.975, n - 3))
        joint = math.sqrt(2.0 * float(f.ppf(0.95, 2, n - 3)))
    if rms is None and not sigma_m:
        return ThreePoints(plane, None, None, None, n, warnings=_said_of_line(sizes, None))
    noise = n > 3 and _spread_is_noise(sizes, n, sigma_m)
    dip_error, turn = _figures(plane, axes, _half_angles(sizes, single * sigma, noise=noise))
    worst = math.degrees(_half_angles(sizes, joint * sigma, noise=noise)[1])
    if worst >= _TELLS_NO_DIRECTION_DEG or (n == 4 and not sigma_m):
        turn = None
    said = _said_of_line(sizes, worst)
    return ThreePoints(plane, dip_error, turn, worst, n, rms, sigma, said)


def _spread_is_noise(sizes: FloatArray, n: int, sigma_m: float) -> bool:
    """Whether what n points spread beside their line may be their error alone, so that they show no
    direction there: by the stated error, else by how round their cross-section is (of two errors of
    one size W ** ((n - 3) / 2) is evenly distributed, W = 4 a b / (a + b) ** 2 of the squares)."""
    from scipy.stats import chi2

    a, b = float(sizes[1]) ** 2, float(sizes[2]) ** 2
    if sigma_m:
        return bool(a + b <= sigma_m**2 * float(chi2.ppf(1.0 - _BY_CHANCE, 2 * (n - 2))))
    evenly = (4.0 * a * b / (a + b) ** 2) ** ((n - 3) / 2.0)
    return bool(evenly > _BY_CHANCE)


def _half_angles(sizes: FloatArray, error: float, *, noise: bool) -> tuple[float, float]:
    """By how much planes that agree tilt along the long and along the short axis of the points,
    radians; a right angle where all do. noise : the short axis is one of errors"""

    def tilt(size: float) -> float:
        room = size**2 - sizes[2] ** 2 - error**2
        return math.atan(error / math.sqrt(room)) if room > 0.0 else math.pi / 2

    return tilt(float(sizes[0])), math.pi / 2 if noise else tilt(float(sizes[1]))


def _figures(
    plane: Plane, axes: FloatArray, tilts: tuple[float, float]
) -> tuple[float, float | None]:
    """How far dip and dip direction of the planes of a cone are from those of its middle, degrees;
    a dip direction by more than a right angle is None. tilts : of the cone along the first two
    `axes`, radians"""
    normal = axes[2] if axes[2] @ plane.normal() > 0 else -axes[2]
    long, short = tilts
    if long >= math.pi / 2:
        return max(plane.dip_deg, 90.0 - plane.dip_deg), None
    if short >= math.pi / 2:
        # All planes that hold a line, which is known to `long`.
        plunge = math.degrees(math.asin(min(1.0, abs(float(axes[0, 2])))))
        least = max(0.0, plunge - math.degrees(long))
        return max(plane.dip_deg - least, 90.0 - plane.dip_deg), None
    edge = (
        np.outer(math.tan(long) * np.cos(_AROUND), axes[0])
        + np.outer(math.tan(short) * np.sin(_AROUND), axes[1])
        + normal
    )
    edge /= np.linalg.norm(edge, axis=1, keepdims=True)
    dips = np.degrees(np.arccos(np.clip(edge[:, 2], -1.0, 1.0)))
    off = float(np.abs(dips - plane.dip_deg).max())
    up = np.array([axes[0, 2] / math.tan(long), axes[1, 2] / math.tan(short)]) if long else None
    if up is not None and normal[2] > 0 and float(np.hypot(*up)) <= normal[2]:
        # A level plane is among them, which dips nowhere.
        return min(max(off, plane.dip_deg), 90.0), None
    if plane.undefined:
        return min(off, 90.0), None
    azimuths = np.degrees(np.arctan2(edge[:, 0], edge[:, 1]))
    turns = (azimuths - plane.dip_direction_deg + 180.0) % 360.0 - 180.0
    turn = float(np.abs(turns).max())
    return min(off, 90.0), turn if turn < 90.0 else None


def _said_of_line(sizes: FloatArray, worst_deg: float | None) -> tuple[Finding, ...]:
    """Of points that do not tell the plane about the line that they are nearly on, or not at
    all. worst_deg : the error of the plane, None where it is not known"""
    on_a_line = float(sizes[1]) < _NEARLY_ON_A_LINE * float(sizes[0])
    if worst_deg is None:
        if not on_a_line:
            return ()
        return (
            Finding(
                "points.nearly-collinear",
                error_m=_A_CENTIMETRE,
                turn_deg=math.degrees(math.atan(_A_CENTIMETRE / float(sizes[1]))),
            ),
        )
    if worst_deg < _UNSURE_DEG:
        return ()
    if on_a_line or float(sizes[1]) < 0.3 * float(sizes[0]):
        return (Finding("points.uncertain-about-line", error_deg=worst_deg),)
    return (Finding("points.too-near", error_deg=worst_deg),)
