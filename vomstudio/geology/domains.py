"""Domains of a structure, each with its own axis, and whether one axis serves all of them.

Where no direction is valid for all (fig. 31c), a section projects each domain along its own. One
great circle through all poles is tested against one for each domain by F (the extra sum of squares
of nested fits); a domain of one dip has no axis of its own, and is asked only how far its mean pole
lies from the common great circle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.folding.figures import AxisFigures
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Line, angle_between_lines, planes_to_poles
from vomstudio.geology.populations.probabilities import f_tail
from vomstudio.geology.statistics import flip_to, orientation_tensor

APART_P, APART_DEG = 0.05, 5.0
"""Domains have their own axes below this chance, and from so many degrees apart on."""


@dataclass(frozen=True)
class DomainFigures:
    """A domain: how many planes, and its axis, or the reason why it has none."""

    n: int
    axis: AxisFigures | None
    reason: Finding | None


@dataclass(frozen=True)
class OneAxisFigures:
    """Test whether one axis serves all domains.

    F, p : of the extra sum of squares, None if there is nothing to test
    apart_deg : largest angle between the axes of two domains, None if fewer than two have one
    beds_off_deg : largest angle between the common axis and the mean bed of a domain of one dip,
        None without such domains
    """

    serves_all: bool
    F: float | None
    p: float | None
    apart_deg: float | None
    beds_off_deg: float | None
    reasons: tuple[Finding, ...]


def describe_domain(domain: DomainFigures, decimals: int) -> str:
    """Describe a domain in one line: its count, and its axis or the reason why it has none."""
    if domain.axis is None:
        return tr("n = {n}: {reason}", n=domain.n, reason=domain.reason)
    if domain.axis.verdict == "homoclinal":
        return tr("n = {n}: one dip, no axis of its own", n=domain.n)
    beta = domain.axis.beta
    return tr(
        "n = {n}: beta {line}; {verdict}; valid: {valid}",
        n=domain.n,
        line=format_line(Line(beta.trend_deg, beta.plunge_deg), decimals),
        verdict=domain.axis.verdict,
        valid=domain.axis.valid,
    )


def apply_domain_verdict(axis: FoldAxis, one_axis: OneAxisFigures) -> FoldAxis:
    """Return the axis of all planes with the verdict that its domains allow."""
    if one_axis.serves_all:
        return replace(axis, reasons=(*axis.reasons, *one_axis.reasons))
    reasons = (*one_axis.reasons, *axis.reasons)
    return replace(axis, verdict="two axes", valid="no", reasons=reasons)


def domain_axes(
    beds: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    pooled: FoldAxis,
    waviness_deg: float | None = None,
) -> tuple[dict[str, DomainFigures], OneAxisFigures]:
    """Compute the fold axis of each domain, and test whether one axis serves all.

    Parameters
    ----------
    beds : mapping
        Domain -> dip directions and dips (n,), degrees.
    pooled : FoldAxis
        The axis of the planes of all domains.
    waviness_deg : float, optional
        As in `fold_axis`.
    """
    beta = pooled.beta.vector()
    figures: dict[str, DomainFigures] = {}
    axes_by_domain: dict[str, FoldAxis] = {}
    separate, parameters, n = 0.0, 0, 0
    together, off_beds = 0.0, list[float]()
    for name, (azimuth, dip) in beds.items():
        poles = planes_to_poles(azimuth, dip).reshape(-1, 3)
        n += len(poles)
        together += _square(poles @ beta)
        axis, reason = _own_axis(azimuth, dip, waviness_deg)
        if axis is not None and axis.verdict != "homoclinal" and len(poles) > 2:
            axes_by_domain[name] = axis
            separate += _square(poles @ axis.beta.vector())
            parameters += 2
        else:
            axes = orientation_tensor(poles)[1]
            along = flip_to(poles, axes[0]) @ beta
            separate += float(np.sum((along - along.mean()) ** 2))
            parameters += 1
            off_beds.append(math.degrees(math.asin(min(abs(float(axes[0] @ beta)), 1.0))))
        figures[name] = DomainFigures(len(poles), None if axis is None else axis.figures, reason)
    off_axes = [
        angle_between_lines(a.beta, b.beta) for a, b in combinations(axes_by_domain.values(), 2)
    ]
    return figures, _judged(
        together,
        separate,
        parameters,
        n,
        max(off_axes, default=None),
        max(off_beds, default=None),
    )


@dataclass(frozen=True)
class ProjectionAxis:
    """Axis along which a domain is projected: its fold axis, or the line in which its beds meet the
    faults (fig. 31c).

    line : None if the domain has none
    error95_deg : None if it is not known
    description : name of the line, or the reason why the domain has no line
    valid : "yes" or "conditional", as of a fold axis
    """

    line: Line | None
    error95_deg: float | None
    description: str
    valid: str | None = None


def projection_axes(
    beds: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    faults: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> dict[str, ProjectionAxis]:
    """Of each domain its own axis (textbook 4.2, fig. 31c and d): beta of a fold whose verdict is
    not "no"; of beds of one dip the line in which their mean meets that of the faults.

    beds : by domain, dip directions and dips (n,) in degrees; faults : those of all faults.
    """
    found: dict[str, ProjectionAxis] = {}
    for name, (azimuth, dip) in beds.items():
        fold, reason = _own_axis(azimuth, dip, None)
        if fold is not None and fold.verdict != "homoclinal" and fold.valid != "no":
            description = tr("fold axis, {verdict}", verdict=fold.verdict)
            found[name] = ProjectionAxis(fold.beta, fold.error95_deg, description, fold.valid)
            continue
        if faults is not None:
            try:
                met = common_axis({"beds": (azimuth, dip), "faults": faults})
            except GeometryError as error:
                found[name] = ProjectionAxis(None, None, error.message)
                continue
            description = tr("where the beds meet the faults")
            found[name] = ProjectionAxis(met.beta, met.error95_deg, description, met.valid)
            continue
        description = (
            str(reason)
            if fold is None
            else tr("{verdict}, and no fault that its beds meet", verdict=fold.verdict)
        )
        found[name] = ProjectionAxis(None, None, description)
    return found


def _own_axis(
    azimuth: npt.ArrayLike, dip: npt.ArrayLike, waviness_deg: float | None
) -> tuple[FoldAxis | None, Finding | None]:
    try:
        return fold_axis(azimuth, dip, waviness_deg=waviness_deg), None
    except GeometryError as error:
        return None, cause_of(error)


def _square(along: FloatArray) -> float:
    return float(np.sum(np.arcsin(np.clip(along, -1.0, 1.0)) ** 2))


def _judged(
    together: float,
    separate: float,
    parameters: int,
    n: int,
    apart_deg: float | None,
    beds_off_deg: float | None,
) -> OneAxisFigures:
    extra, free = parameters - 2, n - parameters
    if extra <= 0 or free <= 0:
        reason = Finding("fold.one-dip-domains")
        return OneAxisFigures(True, None, None, apart_deg, beds_off_deg, (reason,))
    variance = max(separate / free, 1e-12)
    ratio = max(together - separate, 0.0) / extra / variance
    p = f_tail(extra, free, ratio)
    differ = p < APART_P and max(apart_deg or 0.0, beds_off_deg or 0.0) >= APART_DEG
    reasons = [Finding("fold.domains-differ" if differ else "fold.one-axis", p=p)]
    if apart_deg is not None:
        reasons.append(Finding("fold.axes-apart", angle_deg=apart_deg))
    if beds_off_deg is not None:
        reasons.append(Finding("fold.beds-off-axis", angle_deg=beds_off_deg))
    return OneAxisFigures(not differ, ratio, p, apart_deg, beds_off_deg, tuple(reasons))
