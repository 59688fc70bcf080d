"""Whether planes of one kind have one axis to look along, with the numbers behind it.

The names are those of the textbook's section 4.2 and figure 31, and of what else folds are:
cylindrical, conical, homoclinal, two axes, scattered; or undetermined, where the planes do not
tell. A cone, or two axes, are believed where they fit better than the great circle significantly
and by some degrees; else the simplest is. How often each verdict is right is counted in
`tests/geology/test_fold_verdicts.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.geology.folding.shapes import CONE_APART, Cone, Shape, TwoCircles

CYLINDRICAL_DEG, NEARLY_CYLINDRICAL_DEG = 10.0, 20.0
"""Nine tenths of the poles are no farther from the great circle (Ramsay & Huber 1987)."""

KNOWN_AXIS_DEG = 10.0
"""A 95 % error of beta up to this costs 1.5 % of length at most."""

WEAK_AXIS_DEG = 20.0
"""A semi-axis over this: beta is not known well enough to project anything along it, and its
region, which is drawn for small angles, is too narrow."""

SHORT_ARC_DEG = 30.0
"""Poles within an arc shorter than this say little of the great circle they lie on."""

FEW_PLANES = 5
"""Under this many planes neither the scatter nor its shape can be told (an axis can)."""

MIN_PLANES_FOR_YES = 8
"""Regions of axes that are valid hold in 93 % from so many planes on (docs/folds.md)."""

ONE_DIP_DEG = 20.0
"""Poles of one dip stray by no more than this (RMS) from their mean."""

CONE_P, CONE_OFF_DEG, CONE_LEAST_DEG = 0.01, 5.0, 15.0
"""A cone is believed below this chance, from so many degrees off a great circle on, and from so
large a half-angle on."""

CONE_RING, CONE_EVEN_RING = 0.25, 0.2
"""Poles stray from it by no more than this share of its half-angle (the poles of a cluster by half
of it). By the second it is no accident of a uniform scatter, nor of one dip."""

CONE_OPEN_DEG, CONE_UNTOLD_DEG = 25.0, 60.0
"""A cone that differs by so much from the cylinder would fit as well: over the first the verdict
holds under conditions, over the second the poles do not tell a cone from a cylinder."""

CONE_LEFT_DEG = 30.0
"""Nor does it hold without conditions where the 95 % interval of the cone's angle reaches farther
from the cylinder: of a dozen planes on a cone of 60 degrees one in seven was called a cylinder."""

TWO_GAIN, TWO_ANGLE_DEG, TWO_ARC_DEG, TWO_SHARE, TWO_BETTER_DEG = 10.0, 15.0, 20.0, 0.2, 2.0
"""Two great circles are believed with such a gain, so far apart, each with such an arc and share
of the poles, and where the fit is better by so many degrees RMS."""

UNIFORM_P = 0.01


@dataclass(frozen=True)
class Verdict:
    """Verdict on the shape of a fold, with its reasons.

    Parameters
    ----------
    name : str
    valid : {"yes", "conditional", "no"}
        Whether the axis may be used.
    reasons : tuple of Finding
    untested : bool
        The name is "undetermined" only because a cone cannot be distinguished from a cylinder; the
        axis is known.
    """

    name: str
    valid: str
    reasons: tuple[Finding, ...]
    untested: bool = False


def verdict_of(
    shape: Shape,
    error95_deg: float | None,
    uniform_p: float | None,
    waviness_deg: float | None,
    fewest: int = FEW_PLANES,
    *,
    two: bool = True,
) -> Verdict:
    """Of poles of one kind: what they look like, the 95 % error of beta, the chance of a uniform
    scatter that is as uneven, the natural waviness (standard deviation of a pole about the curve)
    where it is known, under how many planes nothing can be told, and whether two axes, which take
    the longest, are looked for."""
    near, far = _limits(waviness_deg)
    cone = shape.cone
    if cone is not None and _conical(cone, far) and _ring(shape, cone, far):
        return Verdict("conical", "no", (_conical_finding(cone, shape.rms_deg),))
    if _one_dip(shape, error95_deg):
        return Verdict(
            "homoclinal", "conditional", (Finding("fold.one-dip", spread_deg=shape.spread_deg),)
        )
    even = uniform_p is not None and shape.n >= 10 and uniform_p > UNIFORM_P
    if even and shape.within90_deg > near and not shape.cluster:
        return Verdict("scattered", "no", (Finding("fold.uniform", p=uniform_p),))
    if shape.limbs is not None and shape.limbs.flat and shape.within90_deg <= far:
        return _cylinder(shape, error95_deg, near, far, fewest)
    if two and _two(shape):
        assert shape.two_circles is not None
        return Verdict("two axes", "no", (_two_axes_finding(shape.two_circles, shape.rms_deg),))
    if cone is not None and _conical(cone, far):
        return Verdict("conical", "no", (_conical_finding(cone, shape.rms_deg),))
    if shape.within90_deg > far:
        scattered = Finding("fold.scattered", within_deg=shape.within90_deg, limit_deg=far)
        return Verdict("scattered", "no", (scattered,))
    return _cylinder(shape, error95_deg, near, far, fewest)


def _cylinder(
    shape: Shape, error95_deg: float | None, near: float, far: float, fewest: int
) -> Verdict:
    """Nothing speaks against a cylinder: does enough speak for it?"""
    doubts: list[Finding] = []
    known = True
    if error95_deg is None or shape.n < fewest:
        known = False
        doubts.append(Finding("fold.shape-unknown", n=shape.n, minimum=fewest))
    elif error95_deg > WEAK_AXIS_DEG:
        return Verdict("undetermined", "no", (too_uncertain(error95_deg),))
    cone = shape.cone
    width = float("inf") if cone is None else cone.half_width_deg
    if shape.limbs is not None and (shape.limbs.flat or width > CONE_OPEN_DEG):
        doubts.append(Finding("fold.two-dip-domains", apart_deg=shape.limbs.apart_deg))
    elif width > CONE_UNTOLD_DEG and not doubts:
        doubts.append(Finding("fold.cone-or-cylinder"))
    if shape.arc_deg < SHORT_ARC_DEG:
        known = False
        doubts.append(Finding("fold.short-arc", arc_deg=shape.arc_deg, limit_deg=SHORT_ARC_DEG))
    if doubts:
        return Verdict("undetermined", "conditional", tuple(doubts), known)
    return _believed(shape, error95_deg or 0.0, width, near, far)


def _believed(shape: Shape, error95_deg: float, width: float, near: float, far: float) -> Verdict:
    reasons: list[Finding] = []
    conditions: list[Finding] = []
    nearly = shape.within90_deg > near
    (conditions if nearly else reasons).append(
        Finding(
            "fold.nearly-cylindrical" if nearly else "fold.cylindrical",
            within_deg=shape.within90_deg,
            limit_deg=near,
        )
    )
    cone = shape.cone
    assert cone is not None
    possible = width > CONE_OPEN_DEG or 90.0 - cone.half_angle_deg + width > CONE_LEFT_DEG
    (conditions if possible else reasons).append(
        Finding(
            "fold.cone-possible" if possible else "fold.no-cone",
            angle_deg=cone.half_angle_deg,
            width_deg=width,
            p=cone.p,
        )
    )
    if error95_deg > KNOWN_AXIS_DEG:
        conditions.append(uncertain(error95_deg))
    if shape.n < MIN_PLANES_FOR_YES:
        conditions.append(Finding("fold.too-few-planes", n=shape.n, wanted=MIN_PLANES_FOR_YES))
    return Verdict("cylindrical", "conditional" if conditions else "yes", (*conditions, *reasons))


def uncertain(error95_deg: float) -> Finding:
    """Report an axis that is valid only under conditions because of its error."""
    return Finding("fold.axis-uncertain", error_deg=error95_deg, limit_deg=KNOWN_AXIS_DEG)


def too_uncertain(error95_deg: float) -> Finding:
    """Report an axis that is not valid because of its error."""
    return Finding("fold.axis-too-uncertain", error_deg=error95_deg, limit_deg=WEAK_AXIS_DEG)


def _limits(waviness_deg: float | None) -> tuple[float, float]:
    """Of the distance that holds nine tenths of the poles: of normal scatter that is 1.645
    standard deviations."""
    if waviness_deg is None:
        return CYLINDRICAL_DEG, NEARLY_CYLINDRICAL_DEG
    return 1.645 * 1.2 * waviness_deg, 2.0 * 1.645 * 1.2 * waviness_deg


def _one_dip(shape: Shape, error95_deg: float | None) -> bool:
    if not shape.cluster or shape.spread_deg > ONE_DIP_DEG or shape.n < 3:
        return False
    if shape.spread_deg <= 5.0:
        return True
    return shape.limbs is None and (error95_deg is None or error95_deg > KNOWN_AXIS_DEG)


def _conical(cone: Cone, far: float) -> bool:
    return (
        cone.p < CONE_P
        and cone.off_deg >= CONE_OFF_DEG
        and cone.half_angle_deg >= CONE_LEAST_DEG
        and cone.off_deg > cone.half_width_deg
        and cone.rms_deg <= CONE_RING * cone.half_angle_deg
        and 1.645 * cone.rms_deg <= far
    )


def _ring(shape: Shape, cone: Cone, far: float) -> bool:
    """Whether a cone shows at a glance: many poles, close to it. Two limbs of one dip each, near a
    great circle, lie on many cones."""
    if shape.limbs is not None and shape.limbs.flat and shape.within90_deg <= far:
        return False
    close = cone.rms_deg <= CONE_EVEN_RING * min(cone.half_angle_deg, 50.0)
    apart = cone.half_angle_deg <= 60.0 or CONE_APART * cone.rms_deg <= cone.off_deg
    return shape.n >= 10 and apart and close


def _two(shape: Shape) -> bool:
    if shape.rms_deg < TWO_BETTER_DEG:
        return False
    two = shape.two_circles
    return (
        two is not None
        and two.gain > TWO_GAIN
        and two.angle_deg >= TWO_ANGLE_DEG
        and min(two.arcs_deg) >= TWO_ARC_DEG
        and min(two.counts) >= TWO_SHARE * shape.n
        and shape.rms_deg - two.rms_deg >= TWO_BETTER_DEG
        and two.rms_deg < 0.6 * shape.rms_deg
    )


def _conical_finding(cone: Cone, rms_deg: float) -> Finding:
    return Finding(
        "fold.conical",
        cone_rms_deg=cone.rms_deg,
        rms_deg=rms_deg,
        angle_deg=cone.half_angle_deg,
        width_deg=cone.half_width_deg,
        trend_deg=cone.axis.trend_deg,
        plunge_deg=cone.axis.plunge_deg,
        p=cone.p,
    )


def _two_axes_finding(two: TwoCircles, rms_deg: float) -> Finding:
    axes = (two.first, two.second)
    return Finding(
        "fold.two-axes",
        two_rms_deg=two.rms_deg,
        rms_deg=rms_deg,
        angle_deg=two.angle_deg,
        trend_deg=[axis.trend_deg for axis in axes],
        plunge_deg=[axis.plunge_deg for axis in axes],
        n=two.counts,
    )
