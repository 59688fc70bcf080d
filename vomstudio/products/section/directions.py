"""Directions of projection onto a section.

Either all features are projected along one direction or, if no single direction is valid, those of
each domain along the axis of the domain (textbook 4.2, fig. 31c).
"""

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
from vomstudio.products.ortho.domain_axes import FAULT_TYPE, compute_domain_axes
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.section.section_lines import Curtain, Panel

MIN_ANGLE_DEG, MIN_ALLOWED_ANGLE_DEG = 20.0, 2.0
"""Angles between direction and section below which to issue a warning and raise an error.

An error of one degree shifts a feature by 15 % of its distance at the first angle, and by 14 times
its distance at the second."""
MAX_FAULT_ANGLE_DEG = 10.0
"""Maximum angle between the plane of a fault and the axis of the beds that end at it."""


@dataclass(frozen=True, eq=False)
class ProjectionDirections:
    """Directions of projection.

    Parameters
    ----------
    along : (3,) array or None
        Direction for features without a domain axis. If None, they are projected perpendicular to
        the section.
    axes : mapping of str to ProjectionAxis
        Axes of the domains, by name.
    faults : mapping of str to str
        For each fault outside the domains, by id, the domain along whose axis it is projected.
    """

    along: FloatArray | None = None
    axes: Mapping[str, ProjectionAxis] = field(default_factory=dict)
    faults: Mapping[str, str] = field(default_factory=dict)

    def of(self, item: Item) -> FloatArray | None:
        """Return the projection direction of a feature, or None if perpendicular to the section."""
        axis = self.axes.get(item.domain or self.faults.get(item.id, ""))
        return self.along if axis is None or axis.line is None else axis.line.vector()

    def check(self, curtain: Curtain) -> tuple[Finding, ...]:
        """Report directions at small angles to the section, and domains without a direction.

        Raises
        ------
        UsageError
            If a direction lies in the section or nearly so.
        """
        findings = list(_check_direction(curtain, self.along, None))
        for name, axis in self.axes.items():
            if axis.line is not None:
                findings += _check_direction(curtain, axis.line.vector(), name)
            elif self.along is None:
                findings.append(
                    Finding("section.domain-without-axis", domain=name, reason=axis.description)
                )
        return tuple(findings)


def assign_domain_axes(items: Sequence[Item], field_: str) -> ProjectionDirections:
    """Assign each domain its own axis.

    A fault between domains belongs to none of them. It is projected along the domain axis that is
    closest to its plane, if the angle between them is below `MAX_FAULT_ANGLE_DEG`.

    Parameters
    ----------
    items : sequence of Item
    field_ : str
        Name of the option in error messages.

    Raises
    ------
    UsageError
        If no plane belongs to a domain.
    """
    axes = compute_domain_axes(items, field_)
    vectors = {name: axis.line.vector() for name, axis in axes.items() if axis.line is not None}
    faults: dict[str, str] = {}
    for item in items:
        normal = item.normal
        if normal is None or item.domain or item.kind.casefold() != FAULT_TYPE or not vectors:
            continue
        sines = {name: abs(float(normal @ axis_vector)) for name, axis_vector in vectors.items()}
        nearest_name = min(sines, key=lambda name: sines[name])
        if sines[nearest_name] < math.sin(math.radians(MAX_FAULT_ANGLE_DEG)):
            faults[item.id] = nearest_name
    return ProjectionDirections(None, axes, faults)


@dataclass(frozen=True)
class DomainProjection:
    """Description of the projection of a domain onto the section.

    Parameters
    ----------
    name : str
    trend_deg, plunge_deg, error95_deg : float or None
        Direction and its 95 % error; None for a perpendicular projection.
    angle_deg : float
        Smallest angle between the direction and the section.
    text : str
        Description of the direction, or the reason why the projection is perpendicular.
    faults : int
        Number of faults outside the domains that are projected along the direction.
    valid : {"yes", "conditional"} or None
        Validity of the direction.
    """

    name: str
    trend_deg: float | None
    plunge_deg: float | None
    error95_deg: float | None
    angle_deg: float
    text: str
    faults: int = 0
    valid: str | None = None

    @property
    def words(self) -> str:
        """Description of the projection for reports."""
        if self.trend_deg is None or self.plunge_deg is None:
            return tr("{name}: perpendicular to the section", name=self.name)
        text = tr(
            "{name}: along {line}, {angle:.0f}° to the section ({said})",
            name=self.name,
            line=format_attitude(Line(self.trend_deg, self.plunge_deg), self.error95_deg),
            angle=self.angle_deg,
            said=self.text,
        )
        if self.valid == "conditional":
            text = f"{text}; {tr('only conditionally valid')}"
        if not self.faults:
            return text
        fault_text = tr_n("also {count} fault", "also {count} faults", self.faults)
        return f"{text}; {fault_text}"


def domain_projections(
    directions: ProjectionDirections, curtain: Curtain
) -> tuple[DomainProjection, ...]:
    """Describe the projection of each domain."""
    projections = []
    for name, axis in directions.axes.items():
        line = axis.line
        angle = smallest_angle(curtain, None if line is None else line.vector())
        trend, plunge = (None, None) if line is None else (line.trend_deg, line.plunge_deg)
        faults = sum(item == name for item in directions.faults.values())
        projections.append(
            DomainProjection(
                name, trend, plunge, axis.error95_deg, angle, axis.description, faults, axis.valid
            )
        )
    return tuple(projections)


def angle_to_panel(panel: Panel, direction: FloatArray | None) -> float:
    """Return the angle in degrees between a direction (3,) and a panel; 90 for None."""
    if direction is None:
        return 90.0
    return math.degrees(math.asin(min(abs(float(direction @ panel.normal)), 1.0)))


def smallest_angle(curtain: Curtain, direction: FloatArray | None) -> float:
    """Return the smallest angle in degrees between a direction and the panels of a section.

    Panels at less than `MIN_ALLOWED_ANGLE_DEG` are ignored. Returns 0 if no panel remains.
    """
    angles = [angle_to_panel(panel, direction) for panel in curtain.panels]
    return min((angle for angle in angles if angle >= MIN_ALLOWED_ANGLE_DEG), default=0.0)


def _check_direction(
    curtain: Curtain, direction: FloatArray | None, domain: str | None
) -> tuple[Finding, ...]:
    if direction is None:
        return ()
    angles = [angle_to_panel(panel, direction) for panel in curtain.panels]
    if max(angles) < MIN_ALLOWED_ANGLE_DEG:
        limits = {"limit_deg": MIN_ALLOWED_ANGLE_DEG, "recommended_deg": MIN_ANGLE_DEG}
        raise UsageError(
            Finding("section.along-direction", **limits)
            if domain is None
            else Finding("section.along-domain", domain=domain, **limits),
            field="--along",
        )
    findings = []
    if any(angle < MIN_ALLOWED_ANGLE_DEG for angle in angles):
        findings.append(Finding("section.pieces-without-features", limit_deg=MIN_ALLOWED_ANGLE_DEG))
    min_angle = smallest_angle(curtain, direction)
    if min_angle < MIN_ANGLE_DEG:
        cost = 100.0 * math.radians(1.0) / math.sin(math.radians(min_angle)) ** 2
        findings.append(
            Finding("section.grazing-direction", angle_deg=min_angle, cost_percent=cost)
            if domain is None
            else Finding(
                "section.grazing-domain", domain=domain, angle_deg=min_angle, cost_percent=cost
            )
        )
    return tuple(findings)
