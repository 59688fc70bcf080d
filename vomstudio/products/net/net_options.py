"""What may be done to a net before it is drawn: turned back, intersections added, circles typed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_azimuth, format_line, format_plane, parse_plane
from vomstudio.geology.orientation import (
    Line,
    Plane,
    line_from_rake,
    normals_to_planes,
    vectors_to_lines,
)
from vomstudio.geology.rotations import pairwise_intersections, rotate_vectors, untilt
from vomstudio.products.net.contents import (
    OKABE_ITO,
    TYPED_LINE,
    AnyEllipse,
    NetBand,
    NetCircle,
    NetContents,
    NetEllipse,
    NetMark,
    NetSet,
    means_of,
)

MOST_PLANES = 300
"""Of more planes the intersections (45,000) are not told apart on a net."""


def typed_plane(text: str, notation: str = "dipdir/dip") -> NetCircle:
    """The great circle of a plane, "DD/D" or as the notation has it. Raises UsageError."""
    plane = plane_of(text, "--plane", notation)
    return NetCircle(plane.pole(), 90.0, tr("Plane {plane}", plane=text))


def typed_cone(text: str) -> NetCircle:
    """The small circle of "TREND/PLUNGE/HALF-ANGLE". Raises UsageError."""
    trend, plunge, half = _three(text, "--cone")
    if not 0.0 < half <= 90.0:
        raise _out_of_range("half-angle", half, 0, 90, "--cone")
    return NetCircle(_line(trend, plunge, "--cone"), half, tr("Cone {cone}", cone=text))


def typed_slip(text: str) -> tuple[NetCircle, NetMark]:
    """The plane of "DD/D/RAKE", and the line in it with that rake from the right-hand-rule strike.
    Raises UsageError."""
    direction, dip, rake = _three(text, "--slip-line")
    if not 0.0 <= dip <= 90.0:
        raise _out_of_range("dip", dip, 0, 90, "--slip-line")
    if not abs(rake) <= 180.0:
        raise _out_of_range("rake", rake, -180, 180, "--slip-line")
    plane = Plane(direction, dip)
    said = tr("rake {rake:g}", rake=rake)
    line = line_from_rake(plane, rake)
    if plane.undefined:
        # A horizontal plane has no strike but the one that was typed.
        line = Line(direction - 90.0 + rake, 0.0)
    return (
        NetCircle(plane.pole(), 90.0, tr("Plane {plane}", plane=text.rpartition("/")[0])),
        _typed_mark(line, said),
    )


def _typed_mark(line: Line, said: str) -> NetMark:
    label = tr("{said}: {line}", said=said, line=format_line(line))
    return NetMark(line, label, TYPED_LINE, said=said)


def plane_of(text: str, field: str, notation: str = "dipdir/dip") -> Plane:
    """Of "DD/D", or as the notation has it. Raises UsageError."""
    try:
        return parse_plane(text, notation)
    except InputError as error:
        raise UsageError(cause_of(error), field=field) from error


def turn_of(text: str) -> tuple[Line, float]:
    """Axis and angle of "TREND/PLUNGE/ANGLE". Raises UsageError."""
    trend, plunge, angle = _three(text, "--rotate")
    return _line(trend, plunge, "--rotate"), angle


def _three(text: str, field: str) -> tuple[float, float, float]:
    try:
        first, second, third = (float(word) for word in text.split("/"))
        if np.isfinite([first, second, third]).all():
            return first, second, third
    except ValueError:
        pass
    raise UsageError(Finding("net.not-three-numbers", text=text), field=field)


def _line(trend: float, plunge: float, field: str) -> Line:
    if not 0.0 <= plunge <= 90.0:
        raise _out_of_range("plunge", plunge, 0, 90, field)
    return Line(trend, plunge)


def _out_of_range(angle: str, value: float, minimum: int, maximum: int, field: str) -> UsageError:
    cause = Finding(
        "angle.out-of-range", angle=angle, value=value, minimum=minimum, maximum=maximum
    )
    return UsageError(cause, field=field)


@dataclass(frozen=True)
class Turning:
    """What is done to orientations before they are drawn: first the plane is made horizontal about
    its strike, then all is turned about the axis, by the right-hand rule about its downward end."""

    plane: Plane | None = None
    axis: Line | None = None
    angle_deg: float = 0.0

    @property
    def turns(self) -> bool:
        return self.plane is not None or self.axis is not None

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done, for the figure."""
        said = []
        if self.plane is not None:
            said.append(
                tr(
                    "Untilted by {dip_direction}/{dip:02.0f}",
                    dip_direction=format_azimuth(self.plane.dip_direction_deg),
                    dip=self.plane.dip_deg,
                )
            )
        if self.axis is not None:
            said.append(
                tr(
                    "Turned by {angle:g}° about {trend}/{plunge:02.0f}",
                    angle=self.angle_deg,
                    trend=format_azimuth(self.axis.trend_deg),
                    plunge=self.axis.plunge_deg,
                )
            )
        return tuple(said)

    def vectors(self, vectors: FloatArray) -> FloatArray:
        """(n, 3) after it."""
        v = np.asarray(vectors, np.float64)
        if self.plane is not None:
            v = untilt(v, self.plane)
        if self.axis is not None:
            v = rotate_vectors(v, self.axis, self.angle_deg)
        return v

    def of_set(self, s: NetSet) -> NetSet:
        """Registrations turn what is measured: what they do to it after it was turned is not
        said."""
        v = self.vectors(s.vectors())
        if s.kind == "plane":
            azimuth, angle = normals_to_planes(v)[:2]
        else:
            azimuth, angle = vectors_to_lines(v, directed=bool((s.angle_deg < 0).any()))[:2]
        slips = None if s.slips is None else self.vectors(s.slips)
        return replace(s, azimuth_deg=azimuth, angle_deg=angle, turns=None, slips=slips)

    def of_circle(self, circle: NetCircle, notation: str = "dipdir/dip") -> NetCircle:
        """One that was typed: named as it was, and as it lies now."""
        axis = Line.from_vector(self.vectors(circle.axis.vector()))
        now = format_line(axis)
        if circle.half_angle_deg == 90.0:
            now = format_plane(axis.normal_plane(), notation)
        label = tr("{typed}, turned to {now}", typed=circle.label, now=now)
        return replace(circle, axis=axis, label=label)

    def of_mark(self, mark: NetMark) -> NetMark:
        return _typed_mark(Line.from_vector(self.vectors(mark.line.vector())), mark.said)

    def of_ellipse(self, ellipse: AnyEllipse) -> AnyEllipse:
        if isinstance(ellipse, NetBand):
            one, other = ellipse.edges
            return NetBand((self.vectors(one), self.vectors(other)))
        line = ellipse.of_pole() if isinstance(ellipse, NetEllipse) else ellipse
        vector, axis = self.vectors(np.array([line.line.vector(), line.axis]))
        return replace(line, line=Line.from_vector(vector), axis=axis)


def net_after(net: NetContents, turning: Turning) -> NetContents:
    """All of the net turned, its means found anew."""
    sets = [turning.of_set(s) for s in net.sets]
    meant = {mean.color + mean.marker for mean in net.means}
    clustered = [s for s in sets if s.color + s.marker in meant]
    return replace(
        net,
        sets=tuple(sets),
        means=means_of(clustered, net.notation, net.decimals),
        errors=tuple(turning.of_ellipse(e) for e in net.errors),
        circles_typed=tuple(turning.of_circle(c, net.notation) for c in net.circles_typed),
        marks=tuple(map(turning.of_mark, net.marks)),
        notes=(*net.notes, *turning.notes),
    )


def with_intersections(net: NetContents) -> NetContents:
    """The lines in which each two of the planes meet, as a set of their own. Raises UsageError for
    too many planes, and for fewer than two."""
    poles = [s.vectors() for s in net.sets if s.kind == "plane"]
    count = sum(map(len, poles))
    if not 2 <= count <= MOST_PLANES:
        raise UsageError(
            Finding("net.number-of-planes", count=count, maximum=MOST_PLANES),
            field="--intersections",
        )
    lines = pairwise_intersections(np.vstack(poles))
    trend, plunge = vectors_to_lines(lines)[:2]
    made = NetSet(tr("Intersections"), "line", trend, plunge, color=OKABE_ITO[-1], marker="x")
    return replace(net, sets=(*net.sets, made))
