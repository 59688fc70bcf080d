"""Band of the planes that are compatible with a straight trace.

A plane through a straight trace can rotate freely about it, so its pole lies anywhere on the great
circle perpendicular to the trace. The direction error of the trace widens this circle to a band:
the joint 95 % region of the fitted normal (`geometry.plane_errors`: the F test of (m'Cm)(m'C^-1 m))
if it is no longer an ellipse. Additional information selects a plane within the band: a set to
which the trace may belong, whose poles follow a Fisher distribution, or another trace that crosses
it in the same plane.
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
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
from vomstudio.geology.quality import governing_half_angles, is_within_wander, resolution_tilt_deg
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.planes import FittedPlane

MAX_HALF_WIDTH_DEG = 10.0
"""Maximum half-width of a band; above it, the points do not form a line (own choice)."""
MIN_ASPECT_RATIO = 3.0
"""Minimum ratio of the rotation error about the trace to that along it (own choice)."""
SIGNIFICANCE = 0.05
N_TURNS, N_TILTS, GRID_RANGE_SIGMA = 360, 41, 6.0
# Minimum direction error of a trace, which may be straight to the last digit.
MIN_SIGMA_RAD = 1e-6
MIN_CROSSING_DEG = 10.0


@dataclass(frozen=True, eq=False)
class PlaneBand:
    """Planes that are compatible with a straight trace at 95 % confidence.

    Attributes
    ----------
    axes : (3, 3) ndarray
        Unit vectors as rows: the line of the trace and two vectors perpendicular to it, the second
        of which is the normal of the best plane.
    widths_rad : (2,) tuple
        Semi-axes along the line, for normals along the second and third axis, radians.
    turn_rad : float
        Maximum rotation of the normal about the line, from the third axis, radians; pi / 2 if
        unrestricted.
    degrees_of_freedom : float
        Degrees of freedom of the error estimate.
    """

    axes: FloatArray
    widths_rad: tuple[float, float]
    turn_rad: float
    degrees_of_freedom: float

    @property
    def line(self) -> Line:
        """Line of the trace, about which the planes of the band rotate."""
        return Line.from_vector(self.axes[0])

    @property
    def half_width95_deg(self) -> float:
        """Maximum angle between a plane of the band and the line of the trace, degrees."""
        return float(np.degrees(max(self.widths_rad)))

    @property
    def turn95_deg(self) -> float:
        """Maximum rotation about the line from the best plane, degrees; 90 if unrestricted."""
        return float(np.degrees(self.turn_rad))

    @property
    def best_plane(self) -> Plane | None:
        """Plane in the middle of the band, or None if all rotations are equally likely."""
        return None if self.turn_rad >= np.pi / 2 else Plane.from_normal(self.axes[2])

    def widths_at_angle_rad(self, angle_rad: FloatArray) -> FloatArray:
        """Return the half-widths (k,) at normals rotated about the line by `angle_rad`."""
        second_width, third_width = np.tan(self.widths_rad)
        return np.asarray(
            np.arctan(np.hypot(second_width * np.sin(angle_rad), third_width * np.cos(angle_rad)))
        )

    def normals(self, angle_rad: FloatArray, tilt_rad: FloatArray) -> FloatArray:
        """Return unit normals (k, 3) rotated about the line and tilted along it, in radians."""
        cross_axes = (
            np.sin(angle_rad)[:, None] * self.axes[1] + np.cos(angle_rad)[:, None] * self.axes[2]
        )
        return np.asarray(
            np.cos(tilt_rad)[:, None] * cross_axes + np.sin(tilt_rad)[:, None] * self.axes[0]
        )

    def misfit(self, normals: npt.ArrayLike) -> FloatArray:
        """Return the squared distances (k,) of normals (k, 3) from the best one; 1 at the edge."""
        local_points = np.atleast_2d(np.asarray(normals, np.float64)) @ self.axes.T
        angles = np.arctan2(local_points[:, 1], local_points[:, 2])
        tilt_rad = np.arcsin(np.clip(local_points[:, 0], -1.0, 1.0))
        squares = (np.tan(tilt_rad) / np.tan(self.widths_at_angle_rad(angles))) ** 2
        if self.turn_rad < np.pi / 2:
            squares += ((np.abs((angles + np.pi / 2) % np.pi - np.pi / 2)) / self.turn_rad) ** 2
        return np.asarray(squares)

    def contains(self, normals: npt.ArrayLike) -> BoolArray:
        """Return whether each of the unit normals (k, 3) is inside the band."""
        return np.asarray(self.misfit(normals) <= 1.0)

    def dips_deg(self) -> tuple[float, float]:
        """Return the smallest and largest dip in the band, degrees."""
        angle = np.linspace(-self.turn_rad, self.turn_rad, 721)
        width = self.widths_at_angle_rad(angle)
        edge_dips = []
        for side in (-1.0, 0.0, 1.0):
            up = np.abs(self.normals(angle, side * width)[:, 2])
            edge_dips.append(np.degrees(np.arccos(np.clip(up, 0.0, 1.0))))
        return float(np.min(edge_dips)), float(np.max(edge_dips))

    def outline(self, count: int = 181) -> tuple[FloatArray, FloatArray]:
        """Return the two edges (count, 3) of the band of normals."""
        angle = np.linspace(-self.turn_rad, self.turn_rad, count)
        width = self.widths_at_angle_rad(angle)
        return self.normals(angle, width), self.normals(angle, -width)

    def likelihood(self, normals: FloatArray) -> FloatArray:
        """Return the likelihoods (k,) of normals (k, 3).

        The likelihood is Student's distribution in two dimensions, whose 95 % region is the band.
        """
        quantile = float(joint_quantile(np.array([self.degrees_of_freedom]))[0])
        return np.asarray(
            (1.0 + self.misfit(normals) * quantile) ** (-(self.degrees_of_freedom + 2.0) / 2.0)
        )

    def sigma_rad(self, rotation: FloatArray) -> FloatArray:
        """Return the scales (k,) of the error along the line for rotated normals, radians.

        `rotation` is the rotation in radians.
        """
        quantile = float(joint_quantile(np.array([self.degrees_of_freedom]))[0])
        scale = self.widths_at_angle_rad(rotation) / np.sqrt(self.degrees_of_freedom * quantile)
        return np.asarray(np.maximum(scale, MIN_SIGMA_RAD))


def find_plane_band(
    fit: FittedPlane,
    *,
    resolution_m: float | None = None,
    registration_deg: float | None = None,
    outcrop_normal: npt.ArrayLike | None = None,
) -> PlaneBand | None:
    """Find the band of a straight trace that does not determine its plane.

    Parameters
    ----------
    fit : FittedPlane
    resolution_m : float, optional
        Resolution of the model in metres, which limits the accuracy of the line.
    registration_deg : float, optional
        95 % half-angle of the registration, degrees.
    outcrop_normal : (3,) array_like, optional
        Normal of the outcrop face around the trace.

    Returns
    -------
    PlaneBand or None
        None if the trace determines a plane, or if it does not even determine a line.
    """
    if fit.error is not None or fit.trace is None or fit.n_effective is None:
        return None
    major_deg, minor_deg = governing_half_angles(
        fit, resolution_m=resolution_m, outcrop_normal=outcrop_normal
    )
    if major_deg is None or minor_deg is None:
        return None
    major_deg = max(major_deg, resolution_tilt_deg(fit, resolution_m) or 0.0)
    l1, l2, l3 = (max(float(eigenvalue), 0.0) for eigenvalue in fit.eigenvalues)
    if major_deg <= DEFAULT_THRESHOLDS.poor_confidence95_deg or l1 <= 0.0:
        return None
    minor_width = np.tan(np.radians(min(minor_deg, 89.0)))
    # The error is proportional to the variance in the direction of the normal.
    second_width = minor_width * np.sqrt(l2 / l3) if l3 > 0.0 else minor_width
    min_width = 0.0
    if resolution_m is not None and fit.extent:
        # Half the point spacing divided by the length, or the whole spacing if the trace is no
        # wider than its wander, which shifts long stretches to one side.
        n_spacings = 1.0 if is_within_wander(fit, "trace", resolution_m, outcrop_normal) else 0.5
        min_width = float(np.arctan(n_spacings * resolution_m / fit.extent))
    turn_error_rad = np.radians(registration_deg or 0.0)
    widths = [
        float(np.hypot(max(np.arctan(w), min_width), turn_error_rad))
        for w in (second_width, minor_width)
    ]
    half_width = float(np.degrees(max(widths)))
    if half_width > MAX_HALF_WIDTH_DEG or major_deg < MIN_ASPECT_RATIO * half_width:
        return None
    angle = (
        np.pi / 2 if major_deg >= 89.999 else float(np.hypot(np.radians(major_deg), turn_error_rad))
    )
    return PlaneBand(
        np.asarray(fit.axes),
        (max(widths[0], MIN_SIGMA_RAD), max(widths[1], MIN_SIGMA_RAD)),
        min(angle, np.pi / 2),
        max(fit.n_effective - 3.0, 1.0),
    )


@dataclass(frozen=True)
class SetPrior:
    """Set of planes: mean pole or normal (3,), Fisher concentration and number of planes."""

    name: str
    normal: tuple[float, float, float]
    kappa: float
    n: int

    @property
    def predictive_concentration(self) -> float:
        """Concentration of a further plane, from the scatter and the error of the mean."""
        return self.kappa * self.n / (self.n + 1.0)


@dataclass(frozen=True)
class BandSet:
    """Comparison of a set with the band of a straight trace.

    Attributes
    ----------
    p : float
        p-value for the hypothesis that the trace lies in a plane of the set.
    compatible : bool
        True if p is at least 0.05.
    probability : float
        Probability that the trace belongs to this set rather than to another set or to none.
    dip_direction_deg, dip_deg, max_confidence95_deg, min_confidence95_deg : float
        Plane of the trace in degrees if it belongs to the set.
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


def compare_sets(band: PlaneBand, sets: Sequence[SetPrior]) -> tuple[tuple[BandSet, ...], float]:
    """Compare the band of a straight trace with sets of planes.

    The prior probability of a set is its share of all planes. One additional plane, which belongs
    to none of the sets, has a uniform distribution of attitudes.

    Parameters
    ----------
    band : PlaneBand
    sets : sequence of SetPrior

    Returns
    -------
    sets : tuple of BandSet
        Results in order of decreasing probability.
    none_probability : float
        Probability that the trace belongs to none of the sets.
    """
    normals, weights = _band_grid(band)
    likelihood = band.likelihood(normals) * weights
    n_planes = sum(prior.n for prior in sets) + 1.0
    no_set_evidence = float(likelihood.sum()) / (4.0 * np.pi) / n_planes
    candidates = []
    for prior in sets:
        posterior = likelihood * _fisher_density(
            prior.predictive_concentration, normals @ np.asarray(prior.normal)
        )
        evidence = float(posterior.sum()) * prior.n / n_planes
        candidates.append((evidence, prior, posterior))
    total_evidence = no_set_evidence + sum(evidence for evidence, *_ in candidates)
    band_sets = []
    for evidence, prior, posterior in candidates:
        p = _p_value(band, prior)
        if evidence > 0.0:
            plane, major_deg, minor_deg = _mean_plane(normals, posterior)
        else:
            plane, major_deg, minor_deg = Plane.from_normal(np.asarray(prior.normal)), 90.0, 90.0
        band_sets.append(
            BandSet(
                prior.name,
                prior.n,
                p,
                p >= SIGNIFICANCE,
                evidence / total_evidence,
                plane.dip_direction_deg,
                plane.dip_deg,
                major_deg,
                minor_deg,
            )
        )
    band_sets.sort(key=lambda prior: -prior.probability)
    return tuple(band_sets), no_set_evidence / total_evidence


@dataclass(frozen=True)
class CrossingPlane:
    """Plane through two straight traces that cross each other.

    Attributes
    ----------
    max_confidence95_deg, min_confidence95_deg : float
        Semi-axes of the joint 95 % region of the normal, degrees.
    crossing_deg : float
        Angle between the traces, degrees.
    """

    dip_direction_deg: float
    dip_deg: float
    normal: tuple[float, float, float]
    max_confidence95_deg: float
    min_confidence95_deg: float
    crossing_deg: float


def crossing_plane(first_band: PlaneBand, second_band: PlaneBand) -> CrossingPlane:
    """Find the plane that contains the lines of two traces, and its error.

    Parameters
    ----------
    first_band, second_band : PlaneBand

    Returns
    -------
    CrossingPlane

    Raises
    ------
    GeometryError
        If the angle between the lines is less than `MIN_CROSSING_DEG`.
    """
    first_axis, second_axis = first_band.axes[0], second_band.axes[0]
    angle = float(
        np.degrees(np.arcsin(min(float(np.linalg.norm(np.cross(first_axis, second_axis))), 1.0)))
    )
    if angle < MIN_CROSSING_DEG:
        raise GeometryError(Finding("plane.parallel-traces", angle_deg=angle))
    normal = np.cross(first_axis, second_axis)
    normal /= np.linalg.norm(normal)
    basis = np.stack([first_axis, np.cross(normal, first_axis)])
    # A tilt x of the normal rotates it away from each line d by x . d.
    lines = np.stack([first_axis, second_axis]) @ basis.T
    scales = [_line_error_rad(band, normal) for band in (first_band, second_band)]
    dof = min(first_band.degrees_of_freedom, second_band.degrees_of_freedom)
    inverse = np.linalg.inv(lines)
    covariance = inverse @ np.diag(np.square(scales)) @ inverse.T
    factor = np.sqrt(dof * float(joint_quantile(np.array([dof]))[0]))
    minor_rad, major_rad = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance), 0.0)) * factor
    plane = Plane.from_normal(normal)
    x, y, z = plane.normal().tolist()
    return CrossingPlane(
        plane.dip_direction_deg,
        plane.dip_deg,
        (x, y, z),
        float(np.degrees(np.arctan(major_rad))),
        float(np.degrees(np.arctan(minor_rad))),
        angle,
    )


# ----------------------------------------------------------------------------------------------
def _line_error_rad(band: PlaneBand, normal: FloatArray) -> float:
    """Return the scale of the error along the line for a normal, radians."""
    local_points = band.axes @ normal
    return float(band.sigma_rad(np.array([np.arctan2(local_points[1], local_points[2])]))[0])


def _band_grid(band: PlaneBand) -> tuple[FloatArray, FloatArray]:
    """Return grid normals (k, 3) that extend beyond the edges of the band, and their areas."""
    angles = (np.arange(N_TURNS) + 0.5) * np.pi / N_TURNS - np.pi / 2
    deviations = np.linspace(-GRID_RANGE_SIGMA, GRID_RANGE_SIGMA, N_TILTS)
    sigma = band.sigma_rad(angles)
    tilt_rad = np.clip(np.outer(sigma, deviations), -1.5, 1.5)
    step = sigma * (deviations[1] - deviations[0]) * np.pi / N_TURNS
    normals = band.normals(np.repeat(angles, N_TILTS), tilt_rad.ravel())
    return normals, np.repeat(step, N_TILTS) * np.cos(tilt_rad.ravel())


def _fisher_density(kappa: float, cosine: FloatArray) -> FloatArray:
    """Return the axial Fisher density on the sphere for cosines of angles to its mean."""
    c = np.abs(cosine)
    density = np.exp(kappa * (c - 1.0)) + np.exp(-kappa * (c + 1.0))
    return np.asarray(kappa * density / (4.0 * np.pi * -np.expm1(-2.0 * kappa)))


def _p_value(band: PlaneBand, prior: SetPrior) -> float:
    """Return the p-value for the hypothesis that the trace lies in a plane of the set."""
    local_points = band.axes @ np.asarray(prior.normal)
    misfit = float(np.arcsin(np.clip(abs(local_points[0]), 0.0, 1.0)))
    line_variance = _line_error_rad(band, np.asarray(prior.normal)) ** 2
    set_variance = 1.0 / prior.predictive_concentration
    # Welch-Satterthwaite degrees of freedom of the sum of variances.
    variance = line_variance + set_variance
    dof = variance**2 / (
        line_variance**2 / band.degrees_of_freedom
        + set_variance**2 / max(2.0 * (prior.n - 1.0), 1.0)
    )
    return f_tail(1.0, dof, misfit**2 / variance)


def _mean_plane(normals: FloatArray, weights: FloatArray) -> tuple[Plane, float, float]:
    """Return the mean axis of weighted normals and the semi-axes of their 95 % ellipse."""
    shares = weights / weights.sum()
    tensor = (normals * shares[:, None]).T @ normals
    _, vectors = np.linalg.eigh(tensor)
    centre = vectors[:, 2]
    # Project onto the tangent plane of the ellipse; limit the weight of normals beyond 80 degrees.
    local_points = normals @ vectors
    cosine = np.maximum(np.abs(local_points[:, 2]), np.cos(np.radians(80.0)))
    tangent = local_points[:, :2] / cosine[:, None]
    covariance = (tangent * shares[:, None]).T @ tangent
    minor_rad, major_rad = np.sqrt(
        np.maximum(np.linalg.eigvalsh(covariance), 0.0) * -2.0 * np.log(SIGNIFICANCE)
    )
    return (
        Plane.from_normal(centre),
        float(np.degrees(np.arctan(major_rad))),
        float(np.degrees(np.arctan(minor_rad))),
    )
