"""Findings about a fold in addition to its verdict, with values and limits."""

from __future__ import annotations

import math

from vomstudio.core.findings import Finding
from vomstudio.geology.folding.limbs import Limbs
from vomstudio.geology.folding.shapes import PoleShape
from vomstudio.geology.folding.verdicts import MAX_USABLE_AXIS_ERROR_DEG, FoldVerdict


def bowed_findings(bowed_deg: float | None, arc_deg: float) -> list[Finding]:
    """Report that bowing of the model may explain the arc of the poles.

    Parameters
    ----------
    bowed_deg : float or None
        Difference in dip between the edges of the bowed model, degrees.
    arc_deg : float
        Arc of the poles, degrees.

    Returns
    -------
    list of Finding
        Empty if the arc exceeds the bowing, or if the bowing is unknown.
    """
    if bowed_deg is None or arc_deg >= bowed_deg:
        return []
    return [Finding("fold.bowed", bowed_deg=bowed_deg, arc_deg=arc_deg)]


def shape_findings(shape: PoleShape) -> list[Finding]:
    """Report the scatter and arc of the poles, and why limbs or an error are unknown.

    Parameters
    ----------
    shape : PoleShape

    Returns
    -------
    list of Finding
    """
    findings = [Finding("fold.shape", n=shape.n, rms_deg=shape.rms_deg, arc_deg=shape.arc_deg)]
    if shape.limbs is not None and shape.limbs.doubt:
        findings.append(_unknown_limbs_finding(shape.limbs))
    if shape.n == 2:
        findings.append(Finding("fold.two-planes"))
    return findings


def decisive_plane_finding(
    plane: str,
    turn_deg: float | None,
    error95_deg: float,
    verdict_without_plane: FoldVerdict | None,
) -> Finding:
    """Report that a verdict depends on a single plane.

    Parameters
    ----------
    plane : str
        Name of the plane.
    turn_deg : float or None
        Rotation of beta if the plane is omitted, degrees; None if its omission changes the verdict
        instead.
    error95_deg : float
        95 % error of beta, degrees.
    verdict_without_plane : FoldVerdict or None
        Verdict on the other planes, used if `turn_deg` is not given; None if they have a uniform
        dip.

    Returns
    -------
    Finding
    """
    if turn_deg is not None:
        return Finding(
            "fold.one-plane-turns", plane=plane, turn_deg=turn_deg, error_deg=error95_deg
        )
    if verdict_without_plane is None or verdict_without_plane.name == "homoclinal":
        return Finding("fold.one-plane-decides", plane=plane, verdict="homoclinal", reason="")
    return Finding(
        "fold.one-plane-decides",
        plane=plane,
        verdict=verdict_without_plane.name,
        reason=verdict_without_plane.reasons[0],
    )


def cone_excluded_finding(plane: str, verdict_without_plane: FoldVerdict) -> Finding:
    """Report that a cone is excluded because of a single plane.

    Parameters
    ----------
    plane : str
        Name of the plane.
    verdict_without_plane : FoldVerdict
        Verdict without this plane.

    Returns
    -------
    Finding
    """
    return Finding(
        "fold.one-plane-excludes-cone", plane=plane, reason=verdict_without_plane.reasons[0]
    )


def _unknown_limbs_finding(limbs: Limbs) -> Finding:
    """Report why the interlimb angle cannot be computed."""
    first_count, second_count = limbs.counts
    if limbs.doubt == "hinge":
        return Finding(
            "fold.limbs-or-hinge",
            first=first_count,
            second=second_count,
            apart_deg=limbs.limb_angle_deg,
        )
    code = "fold.mixed-limbs" if limbs.doubt == "mixed" else "fold.arc-limb"
    return Finding(code, first=first_count, second=second_count)


def error_finding(semi_axes: tuple[float, float]) -> Finding:
    """Report the joint 95 % region of beta and its effect on projected lengths.

    The effect is not reported if beta is too uncertain for projections.

    Parameters
    ----------
    semi_axes : tuple of float
        Semi-axes in degrees.

    Returns
    -------
    Finding
    """
    major_deg, minor_deg = semi_axes
    if major_deg > MAX_USABLE_AXIS_ERROR_DEG:
        return Finding(
            "fold.axis-weak",
            major_deg=major_deg,
            minor_deg=minor_deg,
            limit_deg=MAX_USABLE_AXIS_ERROR_DEG,
        )
    return Finding(
        "fold.axis-known",
        major_deg=major_deg,
        minor_deg=minor_deg,
        shortening_percent=100.0 * (1.0 - math.cos(math.radians(major_deg))),
        shift_percent=100.0 * math.sin(math.radians(major_deg)),
    )
