"""Text rows for the statistics of a set and the verdict on a fold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from vomstudio.core.words import tr, tr_n
from vomstudio.geology.domains import DomainFigures, OneAxisTest, describe_domain
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_attitude, format_error_deg, format_line, format_plane
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.populations.distributions import AxisConfidence, LineAttitude
from vomstudio.geology.populations.set_statistics import SetStatistics

if TYPE_CHECKING:
    from vomstudio.project.fold_planes import FoldPlanes

Rows = list[tuple[str, str]]


def statistics_rows(statistics: SetStatistics, notation: str) -> Rows:
    """Return the statistics of a set as rows, each stating its method."""
    return [
        (tr("Used"), _count_text(statistics)),
        *_fisher_rows(statistics, notation),
        *_kent_rows(statistics),
        *_tensor_rows(statistics),
        *_bingham_rows(statistics),
        (tr("Uniformity ({test})", test=statistics.uniformity.test), _uniformity_text(statistics)),
    ]


def fold_rows(axis: FoldAxis, planes: FoldPlanes, notation: str) -> Rows:
    """Return the fold axis (beta), the limbs, the verdict and its reasons as rows."""
    rows = [
        (tr("Planes used"), _used_planes_text(planes)),
        (
            tr("Verdict"),
            tr("{verdict}; view along beta valid: {valid}", verdict=axis.verdict, valid=axis.valid),
        ),
        (tr("Beta"), _axis_text(axis)),
        (tr("Pi-plane"), format_plane(axis.pi_plane, notation, 0)),
    ]
    if axis.limbs is not None:
        limbs = axis.limbs
        first, second = (
            format_plane(Plane(plane.dip_direction_deg, plane.dip_deg), notation, 0)
            for plane in limbs.planes
        )
        axial = Plane(limbs.axial_plane.dip_direction_deg, limbs.axial_plane.dip_deg)
        text = tr(
            "{first} and {second}, interlimb angle {angle:.0f}° ± {error:.0f}°; axial plane"
            " {axial} (95 %)",
            first=first,
            second=second,
            angle=limbs.interlimb_angle_deg,
            error=limbs.interlimb_error95_deg,
            axial=format_attitude(axial, limbs.axial_plane_error95_deg, notation),
        )
        rows.append((tr("Limbs"), text))
    if axis.leave_one_out is not None:
        text = tr(
            "without one plane, beta rotates by up to {turn:.1f}°", turn=axis.leave_one_out.turn_deg
        )
        rows.append((tr("Leave one out"), text))
    return [*rows, *(("•", reason.message) for reason in axis.reasons)]


def domain_rows(domains: Mapping[str, DomainFigures], one_axis_test: OneAxisTest) -> Rows:
    """Return rows with the fold axis of each domain and the reasons from the one-axis test."""
    rows = [(name, describe_domain(domain, 0)) for name, domain in domains.items()]
    return [*rows, *(("•", reason.message) for reason in one_axis_test.reasons)]


def _used_planes_text(planes: FoldPlanes) -> str:
    texts = [f"{len(planes):,}"]
    if planes.not_good:
        texts.append(tr("{count:,} not rated good", count=planes.not_good))
    texts += [tr("left out: {n:,} {what}: {reason}", **vars(group)) for group in planes.left_out]
    return "; ".join(texts)


def _count_text(statistics: SetStatistics) -> str:
    if statistics.of == "poles":
        return tr_n("{count} pole of a plane", "{count} poles of planes", statistics.n)
    return tr_n("{count} line", "{count} lines", statistics.n)


def _fisher_rows(statistics: SetStatistics, notation: str) -> Rows:
    fisher = statistics.fisher
    if fisher is None:
        return [(tr("Mean (Fisher)"), tr("none: {reason}", reason=statistics.fisher_reason))]
    line = Line(fisher.trend_deg, fisher.plunge_deg)
    mean = line.normal_plane() if statistics.of == "poles" else line
    error = fisher.alpha95_deg if fisher.total95_deg is None else fisher.total95_deg
    text = format_attitude(mean, error, notation)
    if error is not None and fisher.total95_deg is None:
        text = tr("{mean} (alpha95)", mean=text)
    if fisher.kappa is not None:
        text = tr("{said}, kappa {kappa:.1f}", said=text, kappa=fisher.kappa)
    rows = [(tr("Mean (Fisher)"), text + _fit_text(fisher.fit_p))]
    if fisher.alpha95_deg is None and statistics.fisher_reason is not None:
        rows.append(("•", statistics.fisher_reason.message))
    if fisher.registration_error_deg is not None and fisher.alpha95_deg is not None:
        text = tr(
            "{registration} (95 %), included; alpha95 alone {alpha}",
            registration=format_error_deg(fisher.registration_error_deg),
            alpha=format_error_deg(fisher.alpha95_deg),
        )
        rows.append((tr("Registration"), text))
    return rows


def _kent_rows(statistics: SetStatistics) -> Rows:
    kent = statistics.kent
    if kent is None:
        return []
    text = tr(
        "{largest:.1f} × {smallest:.1f}° about the mean (joint 95 %), longest toward {major}",
        largest=kent.max_confidence95_deg,
        smallest=kent.min_confidence95_deg,
        major=_line_text(kent.major),
    )
    return [(tr("Elongated (Kent)"), text + _fit_text(kent.fit_p))]


def _tensor_rows(statistics: SetStatistics) -> Rows:
    s1, s2, s3 = statistics.tensor.eigenvalues
    rows = [(tr("Tensor"), f"S1 {s1:.3f}, S2 {s2:.3f}, S3 {s3:.3f}")]
    axes = zip(("1", "2", "3"), statistics.tensor.axes, statistics.tensor.confidence95, strict=True)
    rows += [
        (tr("Axis {number}", number=k), _line_text(axis) + _confidence_text(confidence))
        for k, axis, confidence in axes
    ]
    point, girdle, random = statistics.vollmer.P, statistics.vollmer.G, statistics.vollmer.R
    rows.append((tr("Shape (Vollmer)"), f"P {point:.2f}, G {girdle:.2f}, R {random:.2f}"))
    if statistics.woodcock.K is not None and statistics.woodcock.C is not None:
        text = f"K {statistics.woodcock.K:.2f}, C {statistics.woodcock.C:.2f}"
        rows.append((tr("Shape (Woodcock)"), text))
    return rows


def _bingham_rows(statistics: SetStatistics) -> Rows:
    bingham = statistics.bingham
    if bingham is None:
        return [("Bingham", tr("none: {reason}", reason=statistics.bingham_reason))]
    return [("Bingham", f"k1 {bingham.k1:.1f}, k2 {bingham.k2:.1f}" + _fit_text(bingham.fit_p))]


def _uniformity_text(statistics: SetStatistics) -> str:
    p = statistics.uniformity.p
    if p is None:
        return tr("not tested: n < 5")
    return f"p {_p_value_text(p)}"


def _axis_text(axis: FoldAxis) -> str:
    text = format_attitude(axis.beta, axis.error95_deg)
    return text if axis.error95_deg is None else tr("{line} (95 %)", line=text)


def _confidence_text(confidence: AxisConfidence | None) -> str:
    if confidence is None or confidence.max_deg >= 45.0:
        return ""
    return tr(
        " ± {largest:.1f} × {smallest:.1f}° (95 %)",
        largest=confidence.max_deg,
        smallest=confidence.min_deg,
    )


def _line_text(figures: LineAttitude) -> str:
    return format_line(Line(figures.trend_deg, figures.plunge_deg), 0)


def _fit_text(p: float | None) -> str:
    """Return whether the distribution fits, as text; empty if the p-value is unknown.

    A p-value alone is easily misread.
    """
    if p is None:
        return ""
    if p < 0.05:
        return tr(" – does not fit (p {p})", p=_p_value_text(p))
    return tr(" – fits (p {p})", p=_p_value_text(p))


def _p_value_text(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"= {p:.3f}"
