"""What a straight trace does determine: the band of planes that contain its line.

A plane through a straight trace may be turned about it at will, so that its pole lies anywhere on
the great circle at right angles to the trace; the error of the trace's direction makes a band of
that circle. The band is the joint 95 % region of the fitted normal (`geometry.plane_errors`: the F
test of (m'Cm)(m'C^-1 m)) where that is no ellipse any more. Within it a plane is picked out by what
else is known: a set that the trace may belong to, whose poles scatter by Fisher's law, or another
trace in the same plane that crosses it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.populations.probabilities import f_tail
from vomstudio.geology.profiles import DEFAULTS
from vomstudio.geology.quality import is_within_wander, resolution_tilt_deg, wider_of
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.planes import PlaneFit

NARROW_DEG = 10.0
"""Ours: a band whose half-width is larger is no band: the points are a blob."""
_SLENDER = 3.0
"""And the planes must be freer to turn about the trace than along it by this factor."""
LEVEL = 0.05
_TURNS, _ACROSS, _REACH = 360, 41, 6.0
# Nothing is known better than this, radians: a trace that is straight to the last digit.
_LEAST = 1e-6
_CROSSING_DEG = 10.0


@dataclass(frozen=True, eq=False)
class PlaneBand:
    """The planes that a straight trace allows, 95 %.

    axes : (3, 3) unit vectors as rows: the trace's line, and two at right angles to it, of which
        the third is the normal of the best plane
    widths_rad : (2,) semi-axes along the line where the normal lies along the second and the third
    turn_rad : how far the normal may be turned about the line from the third; pi / 2 is any
    free : degrees of freedom of the errors
    """

    axes: FloatArray
    widths_rad: tuple[float, float]
    turn_rad: float
    free: float

    @property
    def line(self) -> Line:
        """The trace's, which lies in every plane of the band."""
        return Line.from_vector(self.axes[0])

    @property
    def half_width95_deg(self) -> float:
        """By how much a plane may miss the trace's line, at most."""
        return float(np.degrees(max(self.widths_rad)))

    @property
    def turn95_deg(self) -> float:
        """How far planes may be turned about the line from the best one; 90 is any."""
        return float(np.degrees(self.turn_rad))

    @property
    def best(self) -> Plane | None:
        """The plane in the middle of the band; None where all turns are alike."""
        return None if self.turn_rad >= np.pi / 2 else Plane.from_normal(self.axes[2])

    def widths_at_rad(self, turn: FloatArray) -> FloatArray:
        """(k,) half-widths where the normal is turned about the line by so much from the third."""
        second, third = np.tan(self.widths_rad)
        return np.asarray(np.arctan(np.hypot(second * np.sin(turn), third * np.cos(turn))))

    def normals(self, turn: FloatArray, along: FloatArray) -> FloatArray:
        """(k, 3) unit normals, turned about the line and tilted along it (radians)."""
        across = np.sin(turn)[:, None] * self.axes[1] + np.cos(turn)[:, None] * self.axes[2]
        return np.asarray(np.cos(along)[:, None] * across + np.sin(along)[:, None] * self.axes[0])

    def misfit(self, normals: npt.ArrayLike) -> FloatArray:
        """(k,) squared distance of unit normals (k, 3) from the best one, 1 on the band's edge."""
        own = np.atleast_2d(np.asarray(normals, np.float64)) @ self.axes.T
        turn = np.arctan2(own[:, 1], own[:, 2])
        along = np.arcsin(np.clip(own[:, 0], -1.0, 1.0))
        off = (np.tan(along) / np.tan(self.widths_at_rad(turn))) ** 2
        if self.turn_rad < np.pi / 2:
            off += ((np.abs((turn + np.pi / 2) % np.pi - np.pi / 2)) / self.turn_rad) ** 2
        return np.asarray(off)

    def holds(self, normals: npt.ArrayLike) -> BoolArray:
        """(k,) whether unit normals (k, 3) are inside the band."""
        return np.asarray(self.misfit(normals) <= 1.0)

    def dips_deg(self) -> tuple[float, float]:
        """Lowest and highest dip of the planes in the band."""
        turn = np.linspace(-self.turn_rad, self.turn_rad, 721)
        width = self.widths_at_rad(turn)
        dips = []
        for side in (-1.0, 0.0, 1.0):
            up = np.abs(self.normals(turn, side * width)[:, 2])
            dips.append(np.degrees(np.arccos(np.clip(up, 0.0, 1.0))))
        return float(np.min(dips)), float(np.max(dips))

    def outline(self, count: int = 181) -> tuple[FloatArray, FloatArray]:
        """The two edges (count, 3) of the band of normals."""
        turn = np.linspace(-self.turn_rad, self.turn_rad, count)
        width = self.widths_at_rad(turn)
        return self.normals(turn, width), self.normals(turn, -width)

    def likelihood(self, normals: FloatArray) -> FloatArray:
        """(k,) of unit normals (k, 3): Student's law in two dimensions, whose 95 % is the band."""
        quantile = float(joint_quantile(np.array([self.free]))[0])
        return np.asarray((1.0 + self.misfit(normals) * quantile) ** (-(self.free + 2.0) / 2.0))

    def sigma_rad(self, turn: FloatArray) -> FloatArray:
        """(k,) scale of the error along the line, where the normal is turned by so much."""
        quantile = float(joint_quantile(np.array([self.free]))[0])
        scale = self.widths_at_rad(turn) / np.sqrt(self.free * quantile)
        return np.asarray(np.maximum(scale, _LEAST))


def band_of(
    fit: PlaneFit,
    *,
    resolution_m: float | None = None,
    registration_deg: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
) -> PlaneBand | None:
    """The band of a trace whose plane is poor because it is straight; None where a plane is
    determined, or not even a line.

    resolution_m : of the model, which can tilt a line over its length; registration_deg : 95 %
    half-angle by which the registration can; outcrop_normal : (3,) of the face around the trace
    """
    if fit.error is not None or fit.trace is None or fit.n_effective is None:
        return None
    largest, smallest = wider_of(fit, resolution_m=resolution_m, outcrop_normal=outcrop_normal)
    if largest is None or smallest is None:
        return None
    largest = max(largest, resolution_tilt_deg(fit, resolution_m) or 0.0)
    l1, l2, l3 = (max(float(v), 0.0) for v in fit.eigenvalues)
    if largest <= DEFAULTS.poor_confidence95_deg or l1 <= 0.0:
        return None
    third = np.tan(np.radians(min(smallest, 89.0)))
    # As the variance in the direction of the normal.
    second = third * np.sqrt(l2 / l3) if l3 > 0.0 else third
    floor = 0.0
    if resolution_m is not None and fit.extent:
        # Half a spacing over the length; where the trace has no other width than its own wander,
        # which goes to one side over long stretches, a whole one.
        sways = 1.0 if is_within_wander(fit, "trace", resolution_m, outcrop_normal) else 0.5
        floor = float(np.arctan(sways * resolution_m / fit.extent))
    turned = np.radians(registration_deg or 0.0)
    widths = [float(np.hypot(max(np.arctan(w), floor), turned)) for w in (second, third)]
    half = float(np.degrees(max(widths)))
    if half > NARROW_DEG or largest < _SLENDER * half:
        return None
    turn = np.pi / 2 if largest >= 89.999 else float(np.hypot(np.radians(largest), turned))
    return PlaneBand(
        np.asarray(fit.axes),
        (max(widths[0], _LEAST), max(widths[1], _LEAST)),
        min(turn, np.pi / 2),
        max(fit.n_effective - 3.0, 1.0),
    )


@dataclass(frozen=True)
class SetPrior:
    """A set of planes: its mean pole or normal (3,), Fisher's concentration and how many they
    are."""

    name: str
    normal: tuple[float, float, float]
    kappa: float
    n: int

    @property
    def predictive(self) -> float:
        """Concentration of the next plane of the set: its scatter, and the error of its mean."""
        return self.kappa * self.n / (self.n + 1.0)


@dataclass(frozen=True)
class BandSet:
    """What a set says of the plane of a straight trace.

    p : of a plane of the set as far from the band as its mean is, or farther; compatible : p is at
        least 0.05
    probability : that the trace is of this set, rather than of another or of none
    dip_direction_deg, dip_deg, max/min_confidence95_deg : the plane, if it is of the set
    """

    name: str
    n: int
    p: float
    compatible: bool
    probability: float
    dip_direction_deg: float
    dip_deg: float
    max_confidence95_deg: float
    min_confidence95_deg: float


def sets_in_band(band: PlaneBand, sets: Sequence[SetPrior]) -> tuple[tuple[BandSet, ...], float]:
    """What each set says of a straight trace's plane, the most probable first; and the probability
    that it is of none of them.

    Before the trace is looked at, a plane is of a set with the set's share of all planes; one plane
    more than there are is of none of them, and any attitude is as likely for it.
    """
    normals, weights = _grid(band)
    lie = band.likelihood(normals) * weights
    total = sum(each.n for each in sets) + 1.0
    none = float(lie.sum()) / (4.0 * np.pi) / total
    found = []
    for each in sets:
        posterior = lie * _fisher(each.predictive, normals @ np.asarray(each.normal))
        evidence = float(posterior.sum()) * each.n / total
        found.append((evidence, each, posterior))
    everything = none + sum(evidence for evidence, *_ in found)
    told = []
    for evidence, each, posterior in found:
        p = _p(band, each)
        if evidence > 0.0:
            plane, largest, smallest = _plane(normals, posterior)
        else:
            plane, largest, smallest = Plane.from_normal(np.asarray(each.normal)), 90.0, 90.0
        told.append(
            BandSet(
                each.name,
                each.n,
                p,
                p >= LEVEL,
                evidence / everything,
                plane.dip_direction_deg,
                plane.dip_deg,
                largest,
                smallest,
            )
        )
    told.sort(key=lambda each: -each.probability)
    return tuple(told), none / everything


@dataclass(frozen=True)
class CrossingPlane:
    """The plane of two straight traces that cross: semi-axes of the joint 95 % region of its
    normal; crossing_deg : the angle between the traces"""

    dip_direction_deg: float
    dip_deg: float
    normal: tuple[float, float, float]
    max_confidence95_deg: float
    min_confidence95_deg: float
    crossing_deg: float


def crossing_plane(one: PlaneBand, other: PlaneBand) -> CrossingPlane:
    """The plane that contains both lines, each with its error. Raises GeometryError for lines that
    are nearly parallel."""
    first, second = one.axes[0], other.axes[0]
    angle = float(np.degrees(np.arcsin(min(float(np.linalg.norm(np.cross(first, second))), 1.0))))
    if angle < _CROSSING_DEG:
        raise GeometryError(Finding("plane.parallel-traces", angle_deg=angle))
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal)
    basis = np.stack([first, np.cross(normal, first)])
    # A tilt x of the normal misses each line by x . d.
    lines = np.stack([first, second]) @ basis.T
    scales = [_scale(band, normal) for band in (one, other)]
    free = min(one.free, other.free)
    back = np.linalg.inv(lines)
    covariance = back @ np.diag(np.square(scales)) @ back.T
    reach = np.sqrt(free * float(joint_quantile(np.array([free]))[0]))
    small, large = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance), 0.0)) * reach
    plane = Plane.from_normal(normal)
    x, y, z = plane.normal().tolist()
    return CrossingPlane(
        plane.dip_direction_deg,
        plane.dip_deg,
        (x, y, z),
        float(np.degrees(np.arctan(large))),
        float(np.degrees(np.arctan(small))),
        angle,
    )


# ----------------------------------------------------------------------------------------------
def _scale(band: PlaneBand, normal: FloatArray) -> float:
    """Of the error along the line, where the plane's normal is this."""
    own = band.axes @ normal
    return float(band.sigma_rad(np.array([np.arctan2(own[1], own[2])]))[0])


def _grid(band: PlaneBand) -> tuple[FloatArray, FloatArray]:
    """Normals (k, 3) all over the band and beyond its edges, and the area of each."""
    turn = (np.arange(_TURNS) + 0.5) * np.pi / _TURNS - np.pi / 2
    share = np.linspace(-_REACH, _REACH, _ACROSS)
    sigma = band.sigma_rad(turn)
    along = np.clip(np.outer(sigma, share), -1.5, 1.5)
    step = sigma * (share[1] - share[0]) * np.pi / _TURNS
    normals = band.normals(np.repeat(turn, _ACROSS), along.ravel())
    return normals, np.repeat(step, _ACROSS) * np.cos(along.ravel())


def _fisher(kappa: float, cosine: FloatArray) -> FloatArray:
    """Density of an axial Fisher law on the sphere at the cosines from its mean."""
    c = np.abs(cosine)
    both = np.exp(kappa * (c - 1.0)) + np.exp(-kappa * (c + 1.0))
    return np.asarray(kappa * both / (4.0 * np.pi * -np.expm1(-2.0 * kappa)))


def _p(band: PlaneBand, prior: SetPrior) -> float:
    """Of a plane of the set lying as far from the band as the set's mean, along the line."""
    own = band.axes @ np.asarray(prior.normal)
    off = float(np.arcsin(np.clip(abs(own[0]), 0.0, 1.0)))
    of_line = _scale(band, np.asarray(prior.normal)) ** 2
    of_set = 1.0 / prior.predictive
    # Welch and Satterthwaite's degrees of freedom of the sum.
    both = of_line + of_set
    free = both**2 / (of_line**2 / band.free + of_set**2 / max(2.0 * (prior.n - 1.0), 1.0))
    return f_tail(1.0, free, off**2 / both)


def _plane(normals: FloatArray, weights: FloatArray) -> tuple[Plane, float, float]:
    """The axis about which weighted normals lie, and the semi-axes of their 95 % ellipse."""
    share = weights / weights.sum()
    tensor = (normals * share[:, None]).T @ normals
    _, vectors = np.linalg.eigh(tensor)
    middle = vectors[:, 2]
    # Seen in the tangent plane, which the ellipse is drawn in; far ones weigh no more than at 80
    # degrees.
    own = normals @ vectors
    cosine = np.maximum(np.abs(own[:, 2]), np.cos(np.radians(80.0)))
    tangent = own[:, :2] / cosine[:, None]
    covariance = (tangent * share[:, None]).T @ tangent
    small, large = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance), 0.0) * -2.0 * np.log(LEVEL))
    return (
        Plane.from_normal(middle),
        float(np.degrees(np.arctan(large))),
        float(np.degrees(np.arctan(small))),
    )
