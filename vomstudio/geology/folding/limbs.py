"""Limbs of a fold identified among its poles, and reasons to doubt them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geology.folding.arcs import flip_into_arc, rms
from vomstudio.geology.populations.distributions import f95
from vomstudio.geology.populations.probabilities import chi2_tail, f_tail, t95
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor

MIN_SCATTER_DEG = 1e-3
"""Minimum scatter: poles within this angle of the curve are exact, so no test is possible."""

MAX_FLAT_RATIO, MAX_FLAT_DEG = 2.5, 1.5
"""A limb has a uniform dip if the scatter of its poles along the great circle is below this
multiple of the scatter across it, or below this angle: traces on one face are all least accurate in
the same direction, and such a short arc of natural beds does not reveal a curve.
"""

MIN_SEPARATION = 6.0
"""Minimum separation between the poles of two limbs, in units of their scatter along the great
circle; for an evenly bent arc that is cut in the middle, the separation is 3.5.
"""

MAX_SCATTER_RATIO = 2.0
"""Maximum ratio of the scatter of a limb along the great circle to that of the other limb. A group
with a larger scatter that is not separated by this scatter is an arc rather than a limb: its mean
is not a plane of the fold.
"""

MAX_HINGE_OFFSET_DEG = 25.0
"""Maximum angle between the poles of both limbs of a tight fold and the plane perpendicular to the
hinge plane; they coincide because poles are axial.
"""

MAX_ISOCLINAL_DEG, MAX_HINGE_SHARE = 10.0, 0.35
"""Angle from the plane perpendicular to the hinge plane within which the poles of both limbs form
one group, and maximum share of planes in a hinge.
"""

MIN_HINGE_ARC_DEG, NARROW_SIGNIFICANCE = 20.0, 0.02
"""Minimum arc of the planes of a hinge. A group is a limb if its scatter is unlikely for a hinge,
with a p-value below this level.
"""

VARIANCE_SIGNIFICANCE = 0.05
"""Significance level for a difference in scatter between two limbs."""

MAX_MIXED_SHARE = 0.2
"""Maximum share of planes of a limb whose overturned flags contradict those of the others."""

BENT_SIGNIFICANCE, SMALL_LIMB_BENT_SIGNIFICANCE, MAX_SMALL_LIMB_POLES = 0.01, 0.05, 8
"""Significance levels for a bent group (scatter along the great circle compared with that across
it); the second one applies to groups with few planes.
"""


@dataclass(frozen=True, eq=False)
class Limbs:
    """Two limbs of a fold.

    Attributes
    ----------
    poles : ((3,) ndarray, (3,) ndarray)
        Mean poles of the limbs.
    counts : (int, int)
        Number of planes in each limb.
    limb_angle_deg : float
        Angle between the mean poles along the great circle, degrees.
    along_deg, across_deg : float
        RMS angle of the poles from their means along and across the great circle, degrees.
    variances : (float, float)
        Variance of the planes of each limb along the great circle, radians squared.
    overturned : (bool, bool)
    doubt : str
        Reason to doubt that the groups are limbs of one fold: "hinge" if one group may contain both
        limbs of a tight fold and the other group its hinge, "arc" if one group is an arc rather
        than a limb, "mixed" if only some planes of a limb are overturned; otherwise "".
    """

    poles: tuple[FloatArray, FloatArray]
    counts: tuple[int, int]
    limb_angle_deg: float
    along_deg: float
    across_deg: float
    variances: tuple[float, float]
    overturned: tuple[bool, bool] = (False, False)
    doubt: str = ""

    @property
    def are_flat(self) -> bool:
        """Whether each limb has a uniform dip.

        The poles of such limbs do not show how their curve continues.
        """
        return self.along_deg <= max(MAX_FLAT_RATIO * self.across_deg, MAX_FLAT_DEG)

    @property
    def up(self) -> tuple[FloatArray, FloatArray]:
        """Unit normals toward younger beds; they point up unless a limb is overturned."""
        first_direction, second_direction = (
            pole if (pole[2] > 0) != is_overturned else -pole
            for pole, is_overturned in zip(self.poles, self.overturned, strict=True)
        )
        return first_direction, second_direction

    def errors95_deg(self, axis: FloatArray) -> tuple[float, float]:
        """Return the errors of the interlimb angle and of the axial plane.

        The errors use quantiles of Student's t and Fisher's F, with Welch's (1947) degrees of
        freedom for the angle. These are used without a preliminary test for equal scatter, because
        such a test has little power for few planes (Zimmerman 2004, British Journal of Mathematical
        and Statistical Psychology 57, 173-181). If equal scatter is not rejected, each limb has at
        least the pooled scatter.

        Parameters
        ----------
        axis : (3,) ndarray
            Fold axis.

        Returns
        -------
        angle, axial_plane : float
            95 % error of the interlimb angle, and larger half-angle of the joint 95 % region of the
            bisecting plane, degrees.
        """
        counts = np.array(self.counts, np.float64)
        variances = np.array(self.variances)
        dof = float(counts.sum() - 2.0)
        low, high = (0, 1) if variances[0] <= variances[1] else (1, 0)
        ratio = variances[high] / max(variances[low], math.radians(MIN_SCATTER_DEG) ** 2)
        are_equal = (
            f_tail(counts[high] - 1.0, counts[low] - 1.0, ratio) > VARIANCE_SIGNIFICANCE / 2.0
        )
        if are_equal:
            # The scatter of a few planes may be too small by chance.
            variances = np.maximum(variances, float(variances @ (counts - 1.0)) / dof)
        along_variances = variances / counts
        welch_dof = float(
            along_variances.sum() ** 2 / max(np.sum(along_variances**2 / (counts - 1.0)), 1e-300)
        )
        welch_dof = min(max(welch_dof, 1.0), dof)
        if not are_equal:
            dof = welch_dof
        n = float(counts.sum())
        across_variances = math.radians(self.across_deg) ** 2 * n / max(n - 2.0, 1.0) / counts
        first, second = self.up
        axial_normal = first - second
        length = float(np.linalg.norm(axial_normal))
        axial_normal /= length
        covariance = np.zeros((3, 3))
        for normal, variance_along, variance_across in zip(
            (first, second), along_variances, across_variances, strict=True
        ):
            cross_direction = np.cross(axis, normal)
            covariance += variance_along * np.outer(
                cross_direction, cross_direction
            ) + variance_across * np.outer(axis, axis)
        projection = np.eye(3) - np.outer(axial_normal, axial_normal)
        max_variance = (
            float(np.linalg.eigvalsh(projection @ covariance @ projection)[-1]) / length**2
        )
        # Limbs are recognised by a small scatter, which is often due to chance if there are few
        # planes.
        widening_factor = 1.0 + 1.0 / max(n - 2.0, 1.0)
        angle = widening_factor * t95(welch_dof) * math.sqrt(float(along_variances.sum()))
        region = math.atan(widening_factor * math.sqrt(max_variance * 2.0 * f95(dof)))
        return min(math.degrees(angle), 180.0), math.degrees(region)


def find_limbs(
    poles: FloatArray, axes: FloatArray, overturned: BoolArray | None = None
) -> Limbs | None:
    """Find the two limbs of a fold among its poles.

    Parameters
    ----------
    poles : (n, 3) ndarray
        Unit poles.
    axes : (3, 3) ndarray
        Principal axes of the orientation tensor of the poles.
    overturned : (n,) ndarray of bool or None
        Overturned flags; None if unknown.

    Returns
    -------
    Limbs or None
        None if the poles do not form two groups along the great circle.
    """
    if len(poles) < 4:
        return None
    ends = flip_into_arc(poles, axes)
    direction = ends.sum(axis=0)
    direction -= axes[2] * (direction @ axes[2])
    direction /= np.linalg.norm(direction)
    projections = np.arctan2(ends @ np.cross(axes[2], direction), ends @ direction)
    order = np.argsort(projections)
    angles = projections[order]
    # Cut where the scatter within both groups is smallest.
    n = np.arange(1, len(angles))
    left_sums = np.cumsum(angles)[:-1]
    right_sums, total_squares = angles.sum() - left_sums, float(np.sum(angles**2))
    within_squares = total_squares - left_sums**2 / n - right_sums**2 / (len(angles) - n)
    split_row = (
        int(np.argmin(within_squares[1:-1])) + 2
        if len(angles) > 4
        else int(np.argmin(within_squares)) + 1
    )
    groups = order[:split_row], order[split_row:]
    if min(map(len, groups)) < 2:
        return None
    separation = float(projections[groups[1]].mean() - projections[groups[0]].mean())
    scatter = math.sqrt(max(float(within_squares[split_row - 1]), 0.0) / (len(angles) - 2))
    if separation < math.radians(20.0) or separation < MIN_SEPARATION * scatter:
        return None
    means = [orientation_tensor(poles[group])[1][0] for group in groups]
    heights = ends @ axes[2]
    scatter_rad = rms(np.concatenate([heights[group] - heights[group].mean() for group in groups]))
    is_overturned, doubt_code = (
        (False, False),
        _doubt_code([projections[group] for group in groups], separation, scatter_rad),
    )
    if overturned is not None:
        shares = [float(np.mean(overturned[group])) for group in groups]
        is_overturned = shares[0] > 0.5, shares[1] > 0.5
        if any(MAX_MIXED_SHARE < share < 1.0 - MAX_MIXED_SHARE for share in shares):
            doubt_code = "mixed"
    first_variance, second_variance = (
        float(np.var(projections[group], ddof=1)) for group in groups
    )
    return Limbs(
        (means[0], means[1]),
        (len(groups[0]), len(groups[1])),
        math.degrees(separation),
        math.degrees(scatter),
        math.degrees(scatter_rad),
        (first_variance, second_variance),
        is_overturned,
        doubt_code,
    )


def find_lone_limb(poles: FloatArray) -> int | None:
    """Find a plane that is the only one of its limb, if the others have a uniform dip.

    Returns
    -------
    int or None
        Row of the plane; None if no plane is the only one of its limb.
    """
    if len(poles) < 4:
        return None
    _, axes = orientation_tensor(poles)
    row = int(np.argmax(np.abs(poles @ axes[1])))
    other_poles = np.delete(poles, row, axis=0)
    mean = orientation_tensor(other_poles)[1][0]
    direction = poles[row] * math.copysign(1.0, float(poles[row] @ mean))
    separation = math.acos(min(max(float(direction @ mean), -1.0), 1.0))
    direction = direction - mean * float(direction @ mean)
    length = float(np.linalg.norm(direction))
    if separation < math.radians(20.0) or length == 0.0:
        return None
    projections = np.arcsin(
        np.clip(flip_to_hemisphere(other_poles, mean) @ direction / length, -1.0, 1.0)
    )
    return row if separation >= MIN_SEPARATION * rms(projections) else None


def _doubt_code(groups: list[FloatArray], separation: float, scatter_rad: float) -> str:
    """Return the doubt about two groups of angles along the great circle. See `Limbs.doubt`.

    `separation` and the scatter `scatter_rad` are in radians.
    """
    dof = sum(map(len, groups)) - 2
    # Largest variance that the scatter of the planes can cause without a bend.
    variance = max(scatter_rad**2 * (dof + 2) / dof, math.radians(MIN_SCATTER_DEG) ** 2)
    variances = [float(np.var(group, ddof=1)) for group in groups]
    is_bent = [
        f_tail(len(group) - 1, dof, value / variance)
        < (SMALL_LIMB_BENT_SIGNIFICANCE if len(group) < MAX_SMALL_LIMB_POLES else BENT_SIGNIFICANCE)
        for group, value in zip(groups, variances, strict=True)
    ]
    right_angle_offset_deg = abs(math.degrees(separation) - 90.0)
    smaller_index = 0 if len(groups[0]) <= len(groups[1]) else 1
    if right_angle_offset_deg <= MAX_HINGE_OFFSET_DEG and any(is_bent):
        return "hinge"
    if (
        right_angle_offset_deg <= MAX_ISOCLINAL_DEG
        and len(groups[smaller_index]) <= MAX_HINGE_SHARE * (dof + 2)
        and not _is_narrow(variances[smaller_index], len(groups[smaller_index]), variance)
    ):
        return "hinge"
    max_scatter = math.sqrt(max(variances))
    if (
        max_scatter > MAX_SCATTER_RATIO * math.sqrt(min(variances))
        and separation < MIN_SEPARATION * max_scatter
    ):
        return "arc"
    return ""


def _is_narrow(limb_variance: float, n: int, variance: float) -> bool:
    """Return whether n angles scatter significantly less than the planes of a hinge would.

    `limb_variance` is the variance of the angles, and `variance` that of planes without a bend,
    both in radians squared.
    """
    if n < 3:
        return False
    hinge_variance = math.radians(MIN_HINGE_ARC_DEG) ** 2 / 12.0 + variance
    return 1.0 - chi2_tail(n - 1, (n - 1) * limb_variance / hinge_variance) < NARROW_SIGNIFICANCE
