"""Verdicts on whether planes of one kind have a common axis, with the supporting values.

The names are those of section 4.2 and figure 31 of the textbook and of other folds: cylindrical,
conical, homoclinal, two axes, scattered; or undetermined if there are not enough planes. A cone or
two axes are reported only if they fit significantly better than the great circle and differ from it
by some degrees; otherwise, the simplest shape is reported. `tests/geology/test_fold_verdicts.py`
counts how often each verdict is correct.
"""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.geology.folding.shapes import MIN_CONE_SEPARATION, Cone, PoleShape, TwoCircles

MAX_CYLINDRICAL_DEG, MAX_NEARLY_CYLINDRICAL_DEG = 10.0, 20.0
"""Maximum angle from the great circle within which 90 % of the poles lie (Ramsay & Huber 1987)."""

MAX_VALID_AXIS_ERROR_DEG = 10.0
"""Maximum 95 % error of a valid beta; such an error changes lengths by 1.5 % or less."""

MAX_USABLE_AXIS_ERROR_DEG = 20.0
"""Semi-axis above which beta is too uncertain for projections. Its region, which is drawn for small
angles, is then too narrow.
"""

MIN_ARC_DEG = 30.0
"""Minimum arc of poles that determines their great circle well."""

MIN_PLANES = 5
"""Minimum number of planes that determine the scatter and its shape in addition to the axis."""

MIN_PLANES_FOR_VALID_AXIS = 8
"""Minimum number of planes for a valid axis, with a coverage of 93 % (docs/folds.md)."""

MAX_HOMOCLINAL_RMS_DEG = 20.0
"""Maximum RMS angle between poles of uniform dip and their mean."""

CONE_SIGNIFICANCE, MIN_CONE_OFFSET_DEG, MIN_CONE_ANGLE_DEG = 0.01, 5.0, 15.0
"""A cone is reported if its p-value is below this level, and if its difference from a great circle
and its half-angle are at least these angles.
"""

MAX_CONE_SCATTER, MAX_RING_SCATTER = 0.25, 0.2
"""Maximum scatter of poles about a cone relative to its half-angle (for a cluster, the ratio is one
half). The second limit excludes uniform scatter and uniform dip.
"""

MAX_CONE_WIDTH_DEG, MAX_RESOLVABLE_CONE_WIDTH_DEG = 25.0, 60.0
"""Uncertainty of the half-angle above which the verdict is conditional, and above which the poles
cannot distinguish a cone from a cylinder.
"""

MAX_CONE_DIFFERENCE_DEG = 30.0
"""Distance of the 95 % interval of the cone angle from the cylinder above which the verdict is also
conditional: of cones of 60 degrees with a dozen planes, one in seven was classified as a cylinder.
"""

(
    MIN_TWO_CIRCLES_GAIN,
    MIN_TWO_CIRCLES_ANGLE_DEG,
    MIN_TWO_CIRCLES_ARC_DEG,
    MIN_TWO_CIRCLES_SHARE,
    MIN_TWO_CIRCLES_RMS_GAIN_DEG,
) = (
    10.0,
    15.0,
    20.0,
    0.2,
    2.0,
)
"""Minimum gain, angle, arcs, share of the poles and RMS reduction for two great circles."""

UNIFORM_SIGNIFICANCE = 0.01


@dataclass(frozen=True)
class FoldVerdict:
    """Verdict on the shape of a fold, with its reasons.

    Parameters
    ----------
    name : str
    valid : {"yes", "conditional", "no"}
        Whether the axis may be used.
    reasons : tuple of Finding
    is_cone_untested : bool
        True if the name is "undetermined" only because a cone cannot be distinguished from a
        cylinder, although the axis is known.
    """

    name: str
    valid: str
    reasons: tuple[Finding, ...]
    is_cone_untested: bool = False


def assess_fold(
    shape: PoleShape,
    error95_deg: float | None,
    uniformity_p: float | None,
    waviness_deg: float | None,
    min_planes: int = MIN_PLANES,
    *,
    test_two_circles: bool = True,
) -> FoldVerdict:
    """Assess the shape of the poles of planes of one kind.

    Parameters
    ----------
    shape : PoleShape
    error95_deg : float or None
        95 % error of beta, degrees.
    uniformity_p : float or None
        p-value of a uniform distribution of the poles.
    waviness_deg : float or None
        Natural waviness, the standard deviation of a pole from the curve, degrees.
    min_planes : int
        Number of planes below which the shape is undetermined.
    test_two_circles : bool
        Whether to search for two axes, which takes the longest.

    Returns
    -------
    FoldVerdict
    """
    cylindrical_limit_deg, scatter_limit_deg = _scatter_limits(waviness_deg)
    cone = shape.cone
    if (
        cone is not None
        and _is_conical(cone, scatter_limit_deg)
        and _is_obvious_cone(shape, cone, scatter_limit_deg)
    ):
        return FoldVerdict("conical", "no", (_conical_finding(cone, shape.rms_deg),))
    if _is_homoclinal(shape, error95_deg):
        return FoldVerdict(
            "homoclinal", "conditional", (Finding("fold.one-dip", spread_deg=shape.spread_deg),)
        )
    is_uniform = uniformity_p is not None and shape.n >= 10 and uniformity_p > UNIFORM_SIGNIFICANCE
    if is_uniform and shape.within90_deg > cylindrical_limit_deg and not shape.is_cluster:
        return FoldVerdict("scattered", "no", (Finding("fold.uniform", p=uniformity_p),))
    if shape.limbs is not None and shape.limbs.are_flat and shape.within90_deg <= scatter_limit_deg:
        return _assess_cylinder(
            shape, error95_deg, cylindrical_limit_deg, scatter_limit_deg, min_planes
        )
    if test_two_circles and _has_two_axes(shape):
        assert shape.two_circles is not None
        return FoldVerdict("two axes", "no", (_two_axes_finding(shape.two_circles, shape.rms_deg),))
    if cone is not None and _is_conical(cone, scatter_limit_deg):
        return FoldVerdict("conical", "no", (_conical_finding(cone, shape.rms_deg),))
    if shape.within90_deg > scatter_limit_deg:
        scattered_finding = Finding(
            "fold.scattered", within_deg=shape.within90_deg, limit_deg=scatter_limit_deg
        )
        return FoldVerdict("scattered", "no", (scattered_finding,))
    return _assess_cylinder(
        shape, error95_deg, cylindrical_limit_deg, scatter_limit_deg, min_planes
    )


def _assess_cylinder(
    shape: PoleShape,
    error95_deg: float | None,
    cylindrical_limit_deg: float,
    scatter_limit_deg: float,
    min_planes: int,
) -> FoldVerdict:
    """Assess a shape that is compatible with a cylinder."""
    conditions: list[Finding] = []
    is_cone_untested = True
    if error95_deg is None or shape.n < min_planes:
        is_cone_untested = False
        conditions.append(Finding("fold.shape-unknown", n=shape.n, minimum=min_planes))
    elif error95_deg > MAX_USABLE_AXIS_ERROR_DEG:
        return FoldVerdict("undetermined", "no", (too_uncertain_axis_finding(error95_deg),))
    cone = shape.cone
    width = float("inf") if cone is None else cone.half_width_deg
    if shape.limbs is not None and (shape.limbs.are_flat or width > MAX_CONE_WIDTH_DEG):
        conditions.append(Finding("fold.two-dip-domains", apart_deg=shape.limbs.limb_angle_deg))
    elif width > MAX_RESOLVABLE_CONE_WIDTH_DEG and not conditions:
        conditions.append(Finding("fold.cone-or-cylinder"))
    if shape.arc_deg < MIN_ARC_DEG:
        is_cone_untested = False
        conditions.append(Finding("fold.short-arc", arc_deg=shape.arc_deg, limit_deg=MIN_ARC_DEG))
    if conditions:
        return FoldVerdict("undetermined", "conditional", tuple(conditions), is_cone_untested)
    return _cylindrical_verdict(shape, error95_deg or 0.0, width, cylindrical_limit_deg)


def _cylindrical_verdict(
    shape: PoleShape,
    error95_deg: float,
    width: float,
    cylindrical_limit_deg: float,
) -> FoldVerdict:
    reasons: list[Finding] = []
    conditions: list[Finding] = []
    is_nearly_cylindrical = shape.within90_deg > cylindrical_limit_deg
    (conditions if is_nearly_cylindrical else reasons).append(
        Finding(
            "fold.nearly-cylindrical" if is_nearly_cylindrical else "fold.cylindrical",
            within_deg=shape.within90_deg,
            limit_deg=cylindrical_limit_deg,
        )
    )
    cone = shape.cone
    assert cone is not None
    is_cone_possible = (
        width > MAX_CONE_WIDTH_DEG or 90.0 - cone.half_angle_deg + width > MAX_CONE_DIFFERENCE_DEG
    )
    (conditions if is_cone_possible else reasons).append(
        Finding(
            "fold.cone-possible" if is_cone_possible else "fold.no-cone",
            angle_deg=cone.half_angle_deg,
            width_deg=width,
            p=cone.p,
        )
    )
    if error95_deg > MAX_VALID_AXIS_ERROR_DEG:
        conditions.append(uncertain_axis_finding(error95_deg))
    if shape.n < MIN_PLANES_FOR_VALID_AXIS:
        conditions.append(
            Finding("fold.too-few-planes", n=shape.n, wanted=MIN_PLANES_FOR_VALID_AXIS)
        )
    return FoldVerdict(
        "cylindrical", "conditional" if conditions else "yes", (*conditions, *reasons)
    )


def uncertain_axis_finding(error95_deg: float) -> Finding:
    """Report an axis whose error makes it valid only under certain conditions.

    Parameters
    ----------
    error95_deg : float

    Returns
    -------
    Finding
    """
    return Finding("fold.axis-uncertain", error_deg=error95_deg, limit_deg=MAX_VALID_AXIS_ERROR_DEG)


def too_uncertain_axis_finding(error95_deg: float) -> Finding:
    """Report an axis whose error makes it invalid.

    Parameters
    ----------
    error95_deg : float

    Returns
    -------
    Finding
    """
    return Finding(
        "fold.axis-too-uncertain", error_deg=error95_deg, limit_deg=MAX_USABLE_AXIS_ERROR_DEG
    )


def _scatter_limits(waviness_deg: float | None) -> tuple[float, float]:
    """Return the limits of the angle that contains 90 % of the poles, degrees.

    For normal scatter, this angle is 1.645 standard deviations.
    """
    if waviness_deg is None:
        return MAX_CYLINDRICAL_DEG, MAX_NEARLY_CYLINDRICAL_DEG
    return 1.645 * 1.2 * waviness_deg, 2.0 * 1.645 * 1.2 * waviness_deg


def _is_homoclinal(shape: PoleShape, error95_deg: float | None) -> bool:
    if not shape.is_cluster or shape.spread_deg > MAX_HOMOCLINAL_RMS_DEG or shape.n < 3:
        return False
    if shape.spread_deg <= 5.0:
        return True
    return shape.limbs is None and (error95_deg is None or error95_deg > MAX_VALID_AXIS_ERROR_DEG)


def _is_conical(cone: Cone, scatter_limit_deg: float) -> bool:
    return (
        cone.p < CONE_SIGNIFICANCE
        and cone.deviation_deg >= MIN_CONE_OFFSET_DEG
        and cone.half_angle_deg >= MIN_CONE_ANGLE_DEG
        and cone.deviation_deg > cone.half_width_deg
        and cone.rms_deg <= MAX_CONE_SCATTER * cone.half_angle_deg
        and 1.645 * cone.rms_deg <= scatter_limit_deg
    )


def _is_obvious_cone(shape: PoleShape, cone: Cone, scatter_limit_deg: float) -> bool:
    """Return whether many poles are close to a cone.

    Two limbs of uniform dip, close to a great circle, lie on many cones.
    """
    if shape.limbs is not None and shape.limbs.are_flat and shape.within90_deg <= scatter_limit_deg:
        return False
    is_narrow = cone.rms_deg <= MAX_RING_SCATTER * min(cone.half_angle_deg, 50.0)
    is_separated = (
        cone.half_angle_deg <= 60.0 or MIN_CONE_SEPARATION * cone.rms_deg <= cone.deviation_deg
    )
    return shape.n >= 10 and is_separated and is_narrow


def _has_two_axes(shape: PoleShape) -> bool:
    if shape.rms_deg < MIN_TWO_CIRCLES_RMS_GAIN_DEG:
        return False
    circle_pair = shape.two_circles
    return (
        circle_pair is not None
        and circle_pair.gain > MIN_TWO_CIRCLES_GAIN
        and circle_pair.angle_deg >= MIN_TWO_CIRCLES_ANGLE_DEG
        and min(circle_pair.arcs_deg) >= MIN_TWO_CIRCLES_ARC_DEG
        and min(circle_pair.counts) >= MIN_TWO_CIRCLES_SHARE * shape.n
        and shape.rms_deg - circle_pair.rms_deg >= MIN_TWO_CIRCLES_RMS_GAIN_DEG
        and circle_pair.rms_deg < 0.6 * shape.rms_deg
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


def _two_axes_finding(two_circles: TwoCircles, rms_deg: float) -> Finding:
    axes = (two_circles.first, two_circles.second)
    return Finding(
        "fold.two-axes",
        two_rms_deg=two_circles.rms_deg,
        rms_deg=rms_deg,
        angle_deg=two_circles.angle_deg,
        trend_deg=[axis.trend_deg for axis in axes],
        plunge_deg=[axis.plunge_deg for axis in axes],
        n=two_circles.counts,
    )
