"""The statistics of a set and the verdict of a fold, in words and as rows for a panel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from vomstudio.core.words import tr, tr_n
from vomstudio.geology.domains import DomainFigures, OneAxisFigures, describe_domain
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import degrees, format_attitude, format_line, format_plane
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.populations.distributions import AxisConfidence, LineFigures
from vomstudio.geology.populations.set_statistics import SetStatistics

if TYPE_CHECKING:
    from vomstudio.project.fold_planes import FoldPlanes

Rows = list[tuple[str, str]]


def statistics_rows(found: SetStatistics, notation: str) -> Rows:
    """Each figure with the method it is by."""
    return [
        (tr("Used"), _counted(found)),
        *_fisher(found, notation),
        *_kent(found),
        *_tensor(found),
        *_bingham(found),
        (tr("Uniformity ({test})", test=found.uniformity.test), _uniform(found)),
    ]


def fold_rows(axis: FoldAxis, planes: FoldPlanes, notation: str) -> Rows:
    """Beta and the verdict with what it rests on. planes : of which it is"""
    rows = [
        (tr("Planes used"), _planes_used(planes)),
        (
            tr("Verdict"),
            tr("{verdict}; view along beta valid: {valid}", verdict=axis.verdict, valid=axis.valid),
        ),
        (tr("Beta"), _axis_within(axis)),
        (tr("Pi-plane"), format_plane(axis.pi_plane, notation, 0)),
    ]
    if axis.limbs is not None:
        limbs = axis.limbs
        first, second = (
            format_plane(Plane(plane.dip_direction_deg, plane.dip_deg), notation, 0)
            for plane in limbs.planes
        )
        axial = Plane(limbs.axial_plane.dip_direction_deg, limbs.axial_plane.dip_deg)
        said = tr(
            "{first} and {second}, {angle:.0f}° ± {error:.0f}° between them; axial plane {axial} "
            "(95 %)",
            first=first,
            second=second,
            angle=limbs.interlimb_angle_deg,
            error=limbs.interlimb_error95_deg,
            axial=format_attitude(axial, limbs.axial_plane_error95_deg, notation),
        )
        rows.append((tr("Limbs"), said))
    if axis.leave_one_out is not None:
        said = tr(
            "without one plane beta turns by {turn:.1f}° at most", turn=axis.leave_one_out.turn_deg
        )
        rows.append((tr("Leave one out"), said))
    return [*rows, *(("•", reason.message) for reason in axis.reasons)]


def domain_rows(domains: Mapping[str, DomainFigures], one: OneAxisFigures) -> Rows:
    """Each domain's own axis, and whether one serves all."""
    rows = [(name, describe_domain(domain, 0)) for name, domain in domains.items()]
    return [*rows, *(("•", reason.message) for reason in one.reasons)]


def _planes_used(planes: FoldPlanes) -> str:
    texts = [f"{len(planes):,}"]
    if planes.not_good is not None:
        texts.append(tr("{count:,} not good", count=planes.not_good))
    texts += [tr("left out: {n:,} {what}: {reason}", **vars(each)) for each in planes.left_out]
    return "; ".join(texts)


def _counted(found: SetStatistics) -> str:
    if found.of == "poles":
        return tr_n("{count} pole of a plane", "{count} poles of planes", found.n)
    return tr_n("{count} line", "{count} lines", found.n)


def _fisher(found: SetStatistics, notation: str) -> Rows:
    fisher = found.fisher
    if fisher is None:
        return [(tr("Mean (Fisher)"), tr("none: {reason}", reason=found.fisher_reason))]
    line = Line(fisher.trend_deg, fisher.plunge_deg)
    mean = line.normal_plane() if found.of == "poles" else line
    error = fisher.alpha95_deg if fisher.total95_deg is None else fisher.total95_deg
    said = format_attitude(mean, error, notation)
    if error is not None and fisher.total95_deg is None:
        said = tr("{mean} (alpha95)", mean=said)
    if fisher.kappa is not None:
        said = tr("{said}, kappa {kappa:.1f}", said=said, kappa=fisher.kappa)
    rows = [(tr("Mean (Fisher)"), said + _fit(fisher.fit_p))]
    if fisher.alpha95_deg is None and found.fisher_reason is not None:
        rows.append(("•", found.fisher_reason.message))
    if fisher.registration_error_deg is not None and fisher.alpha95_deg is not None:
        said = tr(
            "{registration} of that (95 %), alpha95 {alpha}",
            registration=degrees(fisher.registration_error_deg),
            alpha=degrees(fisher.alpha95_deg),
        )
        rows.append((tr("Registration"), said))
    return rows


def _kent(found: SetStatistics) -> Rows:
    kent = found.kent
    if kent is None:
        return []
    said = tr(
        "{largest:.1f} × {smallest:.1f}° about the mean (joint 95 %), longest toward {major}",
        largest=kent.max_confidence95_deg,
        smallest=kent.min_confidence95_deg,
        major=_line(kent.major),
    )
    return [(tr("Elongated (Kent)"), said + _fit(kent.fit_p))]


def _tensor(found: SetStatistics) -> Rows:
    s1, s2, s3 = found.tensor.eigenvalues
    rows = [(tr("Tensor"), f"S1 {s1:.3f}, S2 {s2:.3f}, S3 {s3:.3f}")]
    named = zip(("1", "2", "3"), found.tensor.axes, found.tensor.confidence95, strict=True)
    rows += [(tr("Axis {number}", number=k), _line(axis) + _within(of)) for k, axis, of in named]
    point, girdle, random = found.vollmer.P, found.vollmer.G, found.vollmer.R
    rows.append((tr("Shape (Vollmer)"), f"P {point:.2f}, G {girdle:.2f}, R {random:.2f}"))
    if found.woodcock.K is not None and found.woodcock.C is not None:
        said = f"K {found.woodcock.K:.2f}, C {found.woodcock.C:.2f}"
        rows.append((tr("Shape (Woodcock)"), said))
    return rows


def _bingham(found: SetStatistics) -> Rows:
    bingham = found.bingham
    if bingham is None:
        return [("Bingham", tr("none: {reason}", reason=found.bingham_reason))]
    return [("Bingham", f"k1 {bingham.k1:.1f}, k2 {bingham.k2:.1f}" + _fit(bingham.fit_p))]


def _uniform(found: SetStatistics) -> str:
    p = found.uniformity.p
    if p is None:
        return tr("not tested: fewer than 5")
    return f"p {_chance(p)}"


def _axis_within(axis: FoldAxis) -> str:
    said = format_attitude(axis.beta, axis.error95_deg)
    return said if axis.error95_deg is None else tr("{line} (95 %)", line=said)


def _within(of: AxisConfidence | None) -> str:
    if of is None or of.max_deg >= 45.0:
        return ""
    return tr(" ± {largest:.1f} × {smallest:.1f}° (95 %)", largest=of.max_deg, smallest=of.min_deg)


def _line(figures: LineFigures) -> str:
    return format_line(Line(figures.trend_deg, figures.plunge_deg), 0)


def _fit(p: float | None) -> str:
    """Whether the model describes the data, in words: a p value alone is easily read wrongly."""
    if p is None:
        return ""
    if p < 0.05:
        return tr(" – does not fit (p {p})", p=_chance(p))
    return tr(" – fits (p {p})", p=_chance(p))


def _chance(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"= {p:.3f}"
