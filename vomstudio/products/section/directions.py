"""Along which directions features come onto a section: all along one, or each domain along the axis
of its own (textbook 4.2, fig. 31c), where none is valid for all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.domains import ProjectionAxis
from vomstudio.geology.notation import format_attitude
from vomstudio.geology.orientation import Line
from vomstudio.products.ortho.domain_axes import FAULTS, axes_of_domains
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.section.section_lines import Curtain, Panel

GRAZING_DEG, REFUSED_DEG = 20.0, 2.0
"""A direction of projection that meets the section at less is warned of: an error of one degree
moves what is projected by 15 % of its distance and more; and refused: by 14 times the distance."""
IN_PLANE_DEG = 10.0
"""An axis farther from the plane of a fault is not one of beds that end at it."""


@dataclass(frozen=True, eq=False)
class Directions:
    """along : (3,) of whatever is in no domain with an axis, None at right angles to the section;
    axes : of the domains, by name; faults : the domain along whose axis a fault in none is
    projected, by its id"""

    along: FloatArray | None = None
    axes: Mapping[str, ProjectionAxis] = field(default_factory=dict)
    faults: Mapping[str, str] = field(default_factory=dict)

    def of(self, item: Item) -> FloatArray | None:
        axis = self.axes.get(item.domain or self.faults.get(item.id, ""))
        return self.along if axis is None or axis.line is None else axis.line.vector()

    def check(self, curtain: Curtain) -> tuple[Finding, ...]:
        """Report directions at small angles to the section, and domains without a direction.

        Raises
        ------
        UsageError
            If a direction lies in the section, or nearly.
        """
        findings = list(_check(curtain, self.along, None))
        for name, axis in self.axes.items():
            if axis.line is not None:
                findings += _check(curtain, axis.line.vector(), name)
            elif self.along is None:
                findings.append(
                    Finding("section.domain-without-axis", domain=name, reason=axis.description)
                )
        return tuple(findings)


def by_domain(items: Sequence[Item], field_: str) -> Directions:
    """Each domain along its own axis. A fault between domains is in none, and lies along the axes
    of those that end at it: it is projected along the one that lies best in its plane. field_ : of
    whoever asks. Raises UsageError where no feature is in a domain."""
    axes = axes_of_domains(items, field_)
    known = {name: axis.line.vector() for name, axis in axes.items() if axis.line is not None}
    faults: dict[str, str] = {}
    for item in items:
        normal = item.normal
        if normal is None or item.domain or item.kind.casefold() != FAULTS or not known:
            continue
        off = {name: abs(float(normal @ along)) for name, along in known.items()}
        nearest = min(off, key=lambda name: off[name])
        if off[nearest] < math.sin(math.radians(IN_PLANE_DEG)):
            faults[item.id] = nearest
    return Directions(None, axes, faults)


@dataclass(frozen=True)
class DomainProjection:
    """How a domain came onto the section: along a trend and plunge, known to error95_deg; None at
    right angles to it. angle_deg : between it and the section, the least; said : what the direction
    is, or why there is none; faults : in no domain, that were projected along it as well; valid :
    of that direction, "yes" or "conditional"; None where there is none"""

    name: str
    trend_deg: float | None
    plunge_deg: float | None
    error95_deg: float | None
    angle_deg: float
    said: str
    faults: int = 0
    valid: str | None = None

    @property
    def words(self) -> str:
        if self.trend_deg is None or self.plunge_deg is None:
            return tr("{name}: at right angles to the section", name=self.name)
        said = tr(
            "{name}: along {line}, {angle:.0f}° to the section ({said})",
            name=self.name,
            line=format_attitude(Line(self.trend_deg, self.plunge_deg), self.error95_deg),
            angle=self.angle_deg,
            said=self.said,
        )
        if self.valid == "conditional":
            said = f"{said}; {tr('only conditionally valid')}"
        if not self.faults:
            return said
        more = tr_n("{count} fault along it, too", "{count} faults along it, too", self.faults)
        return f"{said}; {more}"


def domain_projections(directions: Directions, curtain: Curtain) -> tuple[DomainProjection, ...]:
    found = []
    for name, axis in directions.axes.items():
        line = axis.line
        angle = least_angle(curtain, None if line is None else line.vector())
        trend, plunge = (None, None) if line is None else (line.trend_deg, line.plunge_deg)
        faults = sum(each == name for each in directions.faults.values())
        found.append(
            DomainProjection(
                name, trend, plunge, axis.error95_deg, angle, axis.description, faults, axis.valid
            )
        )
    return tuple(found)


def angle_to(panel: Panel, along: FloatArray | None) -> float:
    """Between a direction (3,) and a section, degrees; 90 where it is projected at right angles."""
    if along is None:
        return 90.0
    return math.degrees(math.asin(min(abs(float(along @ panel.normal)), 1.0)))


def least_angle(curtain: Curtain, along: FloatArray | None) -> float:
    """Of those at which a direction meets the pieces of a section onto which it leads."""
    angles = [angle_to(panel, along) for panel in curtain.panels]
    return min((angle for angle in angles if angle >= REFUSED_DEG), default=0.0)


def _check(curtain: Curtain, along: FloatArray | None, domain: str | None) -> tuple[Finding, ...]:
    if along is None:
        return ()
    angles = [angle_to(panel, along) for panel in curtain.panels]
    if max(angles) < REFUSED_DEG:
        limits = {"limit_deg": REFUSED_DEG, "recommended_deg": GRAZING_DEG}
        raise UsageError(
            Finding("section.along-direction", **limits)
            if domain is None
            else Finding("section.along-domain", domain=domain, **limits),
            field="--along",
        )
    findings = []
    if any(angle < REFUSED_DEG for angle in angles):
        findings.append(Finding("section.pieces-without-features", limit_deg=REFUSED_DEG))
    least = least_angle(curtain, along)
    if least < GRAZING_DEG:
        cost = 100.0 * math.radians(1.0) / math.sin(math.radians(least)) ** 2
        findings.append(
            Finding("section.grazing-direction", angle_deg=least, cost_percent=cost)
            if domain is None
            else Finding(
                "section.grazing-domain", domain=domain, angle_deg=least, cost_percent=cost
            )
        )
    return tuple(findings)
