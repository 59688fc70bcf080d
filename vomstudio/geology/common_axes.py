"""The axis that several sets of planes share: hanging wall, footwall and fault (fig. 31a to c).

Each set counts once, by its mean, however many planes it has. Two mean planes always meet in a
line. Three or more share an axis where their poles lie in one plane: by how far they do not,
against the cones of error of the means (with three sets that is the triple product of the means
against its error), as chi-square with an estimated variance, F.
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
from vomstudio.geology.common_rotation_errors import Moved, Turns, joined, moved, principal_axis
from vomstudio.geology.folding.figures import PairFigures
from vomstudio.geology.folding.verdicts import (
    KNOWN_AXIS_DEG,
    WEAK_AXIS_DEG,
    Verdict,
    too_uncertain,
    uncertain,
)
from vomstudio.geology.folds import MIN_ARC, FoldAxis, axis_of
from vomstudio.geology.intersections import UncertainPlane, intersection_line, mean_plane
from vomstudio.geology.orientation import planes_to_poles
from vomstudio.geology.populations.distributions import f95
from vomstudio.geology.populations.probabilities import chi2_tail, f_tail
from vomstudio.geology.statistics import flip_to, orientation_tensor, unit_vectors

NATURAL_SCATTER_DEG = 5.0
"""Of a single plane about the mean of its set, where no set tells it."""

TWO_AXES_P, TWO_AXES_DEG = 0.05, 5.0
"""Two axes are believed below this chance, and where a mean lies so far off the common plane."""


def common_axis(
    sets: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    turns: Mapping[str, Turns] | None = None,
) -> FoldAxis:
    """The axis common to several sets of planes (hanging wall, footwall, fault ...): the pole of
    the best plane through the means of their poles, each set counting once however many planes it
    has; with two sets the intersection of their mean planes (textbook 4.2, fig. 31a, b).

    sets: name -> (dip directions, dips) in degrees. turns: what is known of their registrations, by
    the same names and of the same rotations. The confidence carries the scatter of each
    set's mean along the axis, as F with the smallest set's degrees of freedom; it is None where a
    set has a single plane, whose scatter is unknown. Raises GeometryError for fewer than two sets,
    an empty one, or parallel means.
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
    means = np.array([of_set[0] for _, of_set in tensors])
    values, axes = orientation_tensor(means)
    if values[1] < MIN_ARC:
        raise GeometryError(Finding("fold.parallel-means", sets=names))
    strays, freedom = _strays(members, means, axes[2])
    semi_axes, swing = _region_of(means, axes, strays, min(map(len, members)))
    turned = None
    if turns is not None and any(turns[name].known for name in names):
        moved_members = [
            moved(poles, turns[name]) for name, poles in zip(names, members, strict=True)
        ]
        turned = _turned_axis(moved_members, tensors, values, axes)
    off = np.degrees(np.abs(np.arcsin(np.clip(means @ axes[2], -1.0, 1.0))))
    p = _chance(means, axes, strays, freedom)
    pairs = _pairs(names, members)

    def judged(error95_deg: float | None) -> Verdict:
        return _verdict(names, off, p, error95_deg, _supposed(members))

    counted = [Finding("fold.means-of-sets", sets=names, n=[len(poles) for poles in members])]
    if semi_axes is None:
        counted.append(Finding("fold.set-of-one-plane"))
    axis = axis_of(means, values, axes, semi_axes, swing, judged, turned, counted)
    return replace(axis, pairs=pairs)


def _strays(
    members: Sequence[FloatArray], means: FloatArray, beta: FloatArray
) -> tuple[FloatArray, int]:
    """Variance of each mean along beta, radians squared, and the degrees of freedom behind them.
    A single plane strays as those of the other sets do, or by `NATURAL_SCATTER_DEG`."""
    squares = [
        float(np.sum((flip_to(poles, mean) @ beta - mean @ beta) ** 2))
        for poles, mean in zip(members, means, strict=True)
    ]
    counts = np.array([len(poles) for poles in members])
    free = int((counts - 1).sum())
    natural = np.radians(NATURAL_SCATTER_DEG) ** 2
    pooled = sum(squares) / free if free else natural
    variances = [
        square / (n - 1) if n > 1 else pooled for square, n in zip(squares, counts, strict=True)
    ]
    return np.array(variances) / counts, free


def _region_of(
    means: FloatArray, axes: FloatArray, strays: FloatArray, smallest: int
) -> tuple[tuple[float, float] | None, FloatArray]:
    """Semi-axes of the joint 95 % region of beta, degrees, and the direction of the larger one."""
    if smallest < 2:
        return None, axes[1]
    # A mean that strays by e along beta turns beta by t with A t = sum m e, A = sum m m^T in
    # the plane of the means (linearised); e has the variance of the mean of its set.
    across = axes[:2]
    flat = means @ across.T
    inverse = np.linalg.inv(flat.T @ flat)
    covariance = inverse @ (flat.T * strays) @ flat @ inverse
    spread, directions = np.linalg.eigh(covariance)
    angles = np.degrees(np.arctan(np.sqrt(np.maximum(spread, 0.0) * 2.0 * f95(smallest - 1))))
    return (float(angles[1]), float(angles[0])), directions[:, 1] @ across


def _chance(means: FloatArray, axes: FloatArray, strays: FloatArray, free: int) -> float | None:
    """Chance of means so far off a common plane where they share one; None of two, which always
    do."""
    k = len(means)
    if k < 3:
        return None
    flat, off = means @ axes[:2].T, means @ axes[2]
    # Two readings that happen to agree do not make a mean exact.
    weights = 1.0 / np.maximum(strays, max(0.25 * float(strays.mean()), 1e-16))
    tilt = np.linalg.solve((flat.T * weights) @ flat, (flat.T * weights) @ off)
    square = float(weights @ (off - flat @ tilt) ** 2)
    if free == 0:
        return chi2_tail(k - 2, square)
    return f_tail(k - 2, free, square / (k - 2))


def _pairs(names: Sequence[str], members: Sequence[FloatArray]) -> tuple[PairFigures, ...]:
    """Where the mean planes of each two sets meet; parallel ones are left out."""
    planes = [mean_plane([UncertainPlane(pole, None) for pole in poles]) for poles in members]
    found = []
    for i, j in combinations(range(len(names)), 2):
        try:
            meeting = intersection_line(planes[i], planes[j])
        except GeometryError:
            continue
        line = meeting.line
        found.append(
            PairFigures(
                (names[i], names[j]),
                line.trend_deg,
                line.plunge_deg,
                meeting.angle_deg,
                meeting.max_confidence95_deg,
                meeting.min_confidence95_deg,
            )
        )
    return tuple(found)


def _supposed(members: Sequence[FloatArray]) -> bool:
    """Whether nothing but a supposition tells the scatter."""
    return all(len(poles) == 1 for poles in members)


def _verdict(
    names: Sequence[str],
    off: FloatArray,
    p: float | None,
    error95_deg: float | None,
    supposed: bool,
) -> Verdict:
    if p is None:
        return _common([Finding("fold.two-sets")], error95_deg, [])
    reasons = [Finding("fold.off-common-plane", sets=names, off_deg=np.round(off, 1).tolist(), p=p)]
    if supposed:
        reasons.append(Finding("fold.scatter-assumed", scatter_deg=NATURAL_SCATTER_DEG))
    largest = float(off.max())
    if p < TWO_AXES_P and largest >= TWO_AXES_DEG:
        reasons.append(Finding("fold.several-axes"))
        return Verdict("two axes", "no", tuple(reasons))
    doubts = [Finding("fold.off-within-errors")] if largest >= TWO_AXES_DEG else []
    return _common(reasons, error95_deg, doubts)


def _common(reasons: list[Finding], error95_deg: float | None, doubts: list[Finding]) -> Verdict:
    if error95_deg is not None and error95_deg > WEAK_AXIS_DEG:
        return Verdict("undetermined", "no", (too_uncertain(error95_deg), *reasons))
    if error95_deg is not None and error95_deg > KNOWN_AXIS_DEG:
        doubts.append(uncertain(error95_deg))
    valid = "conditional" if doubts or error95_deg is None else "yes"
    return Verdict("common axis", valid, (*doubts, *reasons))


def _turned_axis(
    members: Sequence[Moved],
    tensors: Sequence[tuple[FloatArray, FloatArray]],
    values: FloatArray,
    axes: FloatArray,
) -> Moved:
    """The axis common to sets as the registrations of their planes move it."""
    parts = [principal_axis(own, *of, 0) for own, of in zip(members, tensors, strict=True)]
    return principal_axis(joined(parts), values, axes, 2)
