"""Common axis of several sets of planes: hanging wall, footwall and fault (fig. 31a to c).

Each set is represented by its mean with equal weight, regardless of its number of planes. Two mean
planes always intersect in a line. Three or more sets have a common axis if the poles of their means
are coplanar. The deviation from their plane is compared with the errors of the means (for three
sets, the triple product of the means and its error) by a chi-square test or, if the variance is
estimated, an F test.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import (
    RotationErrors,
    VectorsWithDerivatives,
    concatenate_vectors,
    differentiate_vectors,
    principal_axis,
)
from vomstudio.geology.folding.figures import PairIntersection
from vomstudio.geology.folding.verdicts import (
    MAX_USABLE_AXIS_ERROR_DEG,
    MAX_VALID_AXIS_ERROR_DEG,
    FoldVerdict,
    too_uncertain_axis_finding,
    uncertain_axis_finding,
)
from vomstudio.geology.folds import MIN_SECOND_EIGENVALUE, FoldAxis, build_axis
from vomstudio.geology.intersections import UncertainPlane, intersection_line, mean_plane
from vomstudio.geology.orientation import planes_to_poles
from vomstudio.geology.populations.distributions import f95
from vomstudio.geology.populations.probabilities import chi2_tail, f_tail
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor, unit_vectors

NATURAL_SCATTER_DEG = 5.0
"""Assumed angular scatter of the planes in a set if it cannot be determined from any set."""

TWO_AXES_SIGNIFICANCE, MIN_TWO_AXES_DEG = 0.05, 5.0
"""Significance level and minimum angle from the common plane for the verdict "two axes"."""


def common_axis(
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    rotation_errors: Mapping[str, RotationErrors] | None = None,
) -> FoldAxis:
    """Find the common axis of several sets of planes.

    The axis is the pole of the best-fit plane through the mean poles of the sets, and each set has
    equal weight regardless of its number of planes. For two sets, it is the intersection of their
    mean planes (textbook 4.2, fig. 31a, b).

    Parameters
    ----------
    sets : mapping of str to (array_like, array_like)
        Dip directions and dips of each set, degrees.
    rotation_errors : mapping of str to RotationErrors, optional
        Errors of the registrations of each set, which refer to the same rotations.

    Returns
    -------
    FoldAxis
        Its confidence region is derived from the scatter of the mean of each set along the axis,
        with F and the degrees of freedom of the smallest set; None if a set has only one plane.

    Raises
    ------
    GeometryError
        If there are fewer than two sets, if a set is empty, or if the means are parallel.
    """
    if len(sets) < 2:
        raise GeometryError(Finding("fold.too-few-sets"))
    names = list(sets)
    members: list[FloatArray] = []
    for name in names:
        poles = planes_to_poles(*sets[name]).reshape(-1, 3)
        if len(poles) == 0:
            raise GeometryError(Finding("sets.empty", set=name))
        members.append(unit_vectors(poles))
    tensors = [orientation_tensor(poles) for poles in members]
    means = np.array([set_axes[0] for _, set_axes in tensors])
    eigenvalues, axes = orientation_tensor(means)
    if eigenvalues[1] < MIN_SECOND_EIGENVALUE:
        raise GeometryError(Finding("fold.parallel-means", sets=names))
    variances, degrees_of_freedom = _mean_variances(members, means, axes[2])
    semi_axes, major_direction = _axis_region(means, axes, variances, min(map(len, members)))
    axis_with_derivatives = None
    if rotation_errors is not None and any(
        rotation_errors[name].has_known_errors for name in names
    ):
        members_with_derivatives = [
            differentiate_vectors(poles, rotation_errors[name])
            for name, poles in zip(names, members, strict=True)
        ]
        axis_with_derivatives = _axis_with_derivatives(
            members_with_derivatives, tensors, eigenvalues, axes
        )
    off_plane_deg = np.degrees(np.abs(np.arcsin(np.clip(means @ axes[2], -1.0, 1.0))))
    p = _coplanarity_p(means, axes, variances, degrees_of_freedom)
    pairs = _pair_intersections(names, members)

    def judge(error95_deg: float | None) -> FoldVerdict:
        return _verdict(names, off_plane_deg, p, error95_deg, _is_scatter_assumed(members))

    notes = [Finding("fold.means-of-sets", sets=names, n=[len(poles) for poles in members])]
    if semi_axes is None:
        notes.append(Finding("fold.set-of-one-plane"))
    axis = build_axis(
        means, eigenvalues, axes, semi_axes, major_direction, judge, axis_with_derivatives, notes
    )
    return replace(axis, pairs=pairs)


def _mean_variances(
    members: Sequence[FloatArray], means: FloatArray, beta: FloatArray
) -> tuple[FloatArray, int]:
    """Return the variances of the means along beta, and their degrees of freedom.

    The variances are in radians squared. For a set with a single plane, the scatter of the other
    sets is used, or `NATURAL_SCATTER_DEG`.
    """
    squares = [
        float(np.sum((flip_to_hemisphere(poles, mean) @ beta - mean @ beta) ** 2))
        for poles, mean in zip(members, means, strict=True)
    ]
    counts = np.array([len(poles) for poles in members])
    degrees_of_freedom = int((counts - 1).sum())
    natural_variance = np.radians(NATURAL_SCATTER_DEG) ** 2
    pooled_variance = sum(squares) / degrees_of_freedom if degrees_of_freedom else natural_variance
    variances = [
        square / (count - 1) if count > 1 else pooled_variance
        for square, count in zip(squares, counts, strict=True)
    ]
    return np.array(variances) / counts, degrees_of_freedom


def _axis_region(
    means: FloatArray, axes: FloatArray, variances: FloatArray, min_count: int
) -> tuple[tuple[float, float] | None, FloatArray]:
    """Return the semi-axes of the joint 95 % region of beta and the major direction.

    The semi-axes are in degrees; None if a set has only one plane.
    """
    if min_count < 2:
        return None, axes[1]
    # An error e of a mean along beta rotates beta by t, where A t = sum m e and A = sum m m^T in
    # the plane of the means (linearised); e has the variance of the mean of its set.
    cross_axes = axes[:2]
    tangent_components = means @ cross_axes.T
    inverse = np.linalg.inv(tangent_components.T @ tangent_components)
    covariance = inverse @ (tangent_components.T * variances) @ tangent_components @ inverse
    eigenvalues, directions = np.linalg.eigh(covariance)
    angles = np.degrees(np.arctan(np.sqrt(np.maximum(eigenvalues, 0.0) * 2.0 * f95(min_count - 1))))
    return (float(angles[1]), float(angles[0])), directions[:, 1] @ cross_axes


def _coplanarity_p(
    means: FloatArray, axes: FloatArray, variances: FloatArray, dof: int
) -> float | None:
    """Return the p-value for means in a common plane; None for two means."""
    k = len(means)
    if k < 3:
        return None
    plane_components, heights = means @ axes[:2].T, means @ axes[2]
    # Two equal readings do not make their mean exact.
    weights = 1.0 / np.maximum(variances, max(0.25 * float(variances.mean()), 1e-16))
    tilt = np.linalg.solve(
        (plane_components.T * weights) @ plane_components, (plane_components.T * weights) @ heights
    )
    misfit = float(weights @ (heights - plane_components @ tilt) ** 2)
    if dof == 0:
        return chi2_tail(k - 2, misfit)
    return f_tail(k - 2, dof, misfit / (k - 2))


def _pair_intersections(
    names: Sequence[str], members: Sequence[FloatArray]
) -> tuple[PairIntersection, ...]:
    """Intersect the mean planes of each pair of sets that are not parallel."""
    planes = [mean_plane([UncertainPlane(pole, None) for pole in poles]) for poles in members]
    figures = []
    for i, j in combinations(range(len(names)), 2):
        try:
            intersection = intersection_line(planes[i], planes[j])
        except GeometryError:
            continue
        line = intersection.line
        figures.append(
            PairIntersection(
                (names[i], names[j]),
                line.trend_deg,
                line.plunge_deg,
                intersection.angle_deg,
                intersection.max_confidence95_deg,
                intersection.min_confidence95_deg,
            )
        )
    return tuple(figures)


def _is_scatter_assumed(members: Sequence[FloatArray]) -> bool:
    return all(len(poles) == 1 for poles in members)


def _verdict(
    names: Sequence[str],
    off_plane_deg: FloatArray,
    p: float | None,
    error95_deg: float | None,
    is_scatter_assumed: bool,
) -> FoldVerdict:
    if p is None:
        return _common_verdict([Finding("fold.two-sets")], error95_deg, [])
    reasons = [
        Finding(
            "fold.off-common-plane", sets=names, off_deg=np.round(off_plane_deg, 1).tolist(), p=p
        )
    ]
    if is_scatter_assumed:
        reasons.append(Finding("fold.scatter-assumed", scatter_deg=NATURAL_SCATTER_DEG))
    max_off_plane_deg = float(off_plane_deg.max())
    if p < TWO_AXES_SIGNIFICANCE and max_off_plane_deg >= MIN_TWO_AXES_DEG:
        reasons.append(Finding("fold.several-axes"))
        return FoldVerdict("two axes", "no", tuple(reasons))
    warnings = [Finding("fold.off-within-errors")] if max_off_plane_deg >= MIN_TWO_AXES_DEG else []
    return _common_verdict(reasons, error95_deg, warnings)


def _common_verdict(
    reasons: list[Finding], error95_deg: float | None, warnings: list[Finding]
) -> FoldVerdict:
    if error95_deg is not None and error95_deg > MAX_USABLE_AXIS_ERROR_DEG:
        return FoldVerdict(
            "undetermined", "no", (too_uncertain_axis_finding(error95_deg), *reasons)
        )
    if error95_deg is not None and error95_deg > MAX_VALID_AXIS_ERROR_DEG:
        warnings.append(uncertain_axis_finding(error95_deg))
    validity = "conditional" if warnings or error95_deg is None else "yes"
    return FoldVerdict("common axis", validity, (*warnings, *reasons))


def _axis_with_derivatives(
    members: Sequence[VectorsWithDerivatives],
    tensors: Sequence[tuple[FloatArray, FloatArray]],
    eigenvalues: FloatArray,
    axes: FloatArray,
) -> VectorsWithDerivatives:
    """Return the common axis with its derivatives with respect to the registrations."""
    parts = [
        principal_axis(vectors, *tensor, 0)
        for vectors, tensor in zip(members, tensors, strict=True)
    ]
    return principal_axis(concatenate_vectors(parts), eigenvalues, axes, 2)
