"""Modifications of a net before drawing: rotation, intersections, user-defined circles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding, cause_finding
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
    USER_LINE_MARKER,
    AnyEllipse,
    NetBand,
    NetCircle,
    NetContents,
    NetEllipse,
    NetMark,
    NetSet,
    compute_means,
)

MAX_PLANES = 300
"""Maximum number of planes to intersect; more than 45,000 lines cannot be distinguished."""


def parse_plane_circle(text: str, notation: str = "dipdir/dip") -> NetCircle:
    """Parse the great circle of a plane given as "DD/D" or in `notation`.

    Raises
    ------
    UsageError
    """
    plane = parse_net_plane(text, "--plane", notation)
    return NetCircle(plane.pole(), 90.0, tr("Plane {plane}", plane=text))


def parse_cone(text: str) -> NetCircle:
    """Parse a small circle given as "TREND/PLUNGE/HALF-ANGLE".

    Raises
    ------
    UsageError
    """
    trend, plunge, half_angle = _parse_three_numbers(text, "--cone")
    if not 0.0 < half_angle <= 90.0:
        raise _range_error("half-angle", half_angle, 0, 90, "--cone")
    return NetCircle(_line(trend, plunge, "--cone"), half_angle, tr("Cone {cone}", cone=text))


def parse_slip(text: str) -> tuple[NetCircle, NetMark]:
    """Parse a slip given as "DD/D/RAKE", with the rake from the right-hand-rule strike.

    Raises
    ------
    UsageError
    """
    direction, dip, rake = _parse_three_numbers(text, "--slip-line")
    if not 0.0 <= dip <= 90.0:
        raise _range_error("dip", dip, 0, 90, "--slip-line")
    if not abs(rake) <= 180.0:
        raise _range_error("rake", rake, -180, 180, "--slip-line")
    plane = Plane(direction, dip)
    rake_text = tr("rake {rake:g}", rake=rake)
    line = line_from_rake(plane, rake)
    if plane.undefined:
        # A horizontal plane keeps the strike entered by the user.
        line = Line(direction - 90.0 + rake, 0.0)
    return (
        NetCircle(plane.pole(), 90.0, tr("Plane {plane}", plane=text.rpartition("/")[0])),
        _parse_mark(line, rake_text),
    )


def _parse_mark(line: Line, text: str) -> NetMark:
    label = tr("{said}: {line}", said=text, line=format_line(line))
    return NetMark(line, label, USER_LINE_MARKER, input_text=text)


def parse_net_plane(text: str, field: str, notation: str = "dipdir/dip") -> Plane:
    """Parse a plane given as "DD/D" or in `notation`.

    Raises
    ------
    UsageError
    """
    try:
        return parse_plane(text, notation)
    except InputError as error:
        raise UsageError(cause_finding(error), field=field) from error


def parse_rotation(text: str) -> tuple[Line, float]:
    """Parse a rotation axis and angle given as "TREND/PLUNGE/ANGLE".

    Raises
    ------
    UsageError
    """
    trend, plunge, angle = _parse_three_numbers(text, "--rotate")
    return _line(trend, plunge, "--rotate"), angle


def _parse_three_numbers(text: str, field: str) -> tuple[float, float, float]:
    try:
        first, second, third = (float(word) for word in text.split("/"))
        if np.isfinite([first, second, third]).all():
            return first, second, third
    except ValueError:
        pass
    raise UsageError(Finding("net.not-three-numbers", text=text), field=field)


def _line(trend: float, plunge: float, field: str) -> Line:
    if not 0.0 <= plunge <= 90.0:
        raise _range_error("plunge", plunge, 0, 90, field)
    return Line(trend, plunge)


def _range_error(angle: str, value: float, minimum: int, maximum: int, field: str) -> UsageError:
    cause = Finding(
        "angle.out-of-range", angle=angle, value=value, minimum=minimum, maximum=maximum
    )
    return UsageError(cause, field=field)


@dataclass(frozen=True)
class NetRotation:
    """Rotation that is applied to orientations before drawing.

    First, the plane is rotated to horizontal about its strike. Then everything is rotated about the
    axis, following the right-hand rule about its downward end.
    """

    plane: Plane | None = None
    axis: Line | None = None
    angle_deg: float = 0.0

    @property
    def has_rotation(self) -> bool:
        return self.plane is not None or self.axis is not None

    @property
    def notes(self) -> tuple[str, ...]:
        """Descriptions of the rotation, shown in the figure."""
        notes = []
        if self.plane is not None:
            notes.append(
                tr(
                    "Untilted by {dip_direction}/{dip:02.0f}",
                    dip_direction=format_azimuth(self.plane.dip_direction_deg),
                    dip=self.plane.dip_deg,
                )
            )
        if self.axis is not None:
            notes.append(
                tr(
                    "Rotated by {angle:g}° about {trend}/{plunge:02.0f}",
                    angle=self.angle_deg,
                    trend=format_azimuth(self.axis.trend_deg),
                    plunge=self.axis.plunge_deg,
                )
            )
        return tuple(notes)

    def vectors(self, vectors: FloatArray) -> FloatArray:
        """Rotate vectors (n, 3)."""
        v = np.asarray(vectors, np.float64)
        if self.plane is not None:
            v = untilt(v, self.plane)
        if self.axis is not None:
            v = rotate_vectors(v, self.axis, self.angle_deg)
        return v

    def rotate_set(self, net_set: NetSet) -> NetSet:
        """Rotate a set; its registration errors become unknown."""
        v = self.vectors(net_set.vectors())
        if net_set.kind == "plane":
            azimuth, angle = normals_to_planes(v)[:2]
        else:
            azimuth, angle = vectors_to_lines(v, is_directed=bool((net_set.angle_deg < 0).any()))[
                :2
            ]
        slips = None if net_set.slips is None else self.vectors(net_set.slips)
        return replace(
            net_set, azimuth_deg=azimuth, angle_deg=angle, rotation_errors=None, slips=slips
        )

    def rotate_circle(self, circle: NetCircle, notation: str = "dipdir/dip") -> NetCircle:
        """Rotate a user-defined circle; its label states the original and the new attitude."""
        axis = Line.from_vector(self.vectors(circle.axis.vector()))
        axis_text = format_line(axis)
        if circle.half_angle_deg == 90.0:
            axis_text = format_plane(axis.normal_plane(), notation)
        label = tr("{typed}, rotated to {now}", typed=circle.label, now=axis_text)
        return replace(circle, axis=axis, label=label)

    def rotate_mark(self, mark: NetMark) -> NetMark:
        return _parse_mark(Line.from_vector(self.vectors(mark.line.vector())), mark.input_text)

    def rotate_ellipse(self, ellipse: AnyEllipse) -> AnyEllipse:
        if isinstance(ellipse, NetBand):
            first_edge, second_edge = ellipse.edges
            return NetBand((self.vectors(first_edge), self.vectors(second_edge)))
        line = ellipse.pole_ellipse() if isinstance(ellipse, NetEllipse) else ellipse
        vector, axis = self.vectors(np.array([line.line.vector(), line.axis]))
        return replace(line, line=Line.from_vector(vector), axis=axis)


def rotate_net(net: NetContents, rotation: NetRotation) -> NetContents:
    """Rotate a net and recompute its means."""
    sets = [rotation.rotate_set(set_) for set_ in net.sets]
    keys_with_mean = {mean.color + mean.marker for mean in net.means}
    clustered_sets = [set_ for set_ in sets if set_.color + set_.marker in keys_with_mean]
    return replace(
        net,
        sets=tuple(sets),
        means=compute_means(clustered_sets, net.notation, net.decimals),
        errors=tuple(rotation.rotate_ellipse(error) for error in net.errors),
        user_circles=tuple(
            rotation.rotate_circle(circle, net.notation) for circle in net.user_circles
        ),
        marks=tuple(map(rotation.rotate_mark, net.marks)),
        notes=(*net.notes, *rotation.notes),
    )


def add_intersections(net: NetContents) -> NetContents:
    """Add the intersections of all pairs of planes as a set.

    Raises
    ------
    UsageError
        If there are fewer than two planes or too many.
    """
    poles = [set_.vectors() for set_ in net.sets if set_.kind == "plane"]
    count = sum(map(len, poles))
    if not 2 <= count <= MAX_PLANES:
        raise UsageError(
            Finding("net.number-of-planes", count=count, maximum=MAX_PLANES),
            field="--intersections",
        )
    lines = pairwise_intersections(np.vstack(poles))
    trend, plunge = vectors_to_lines(lines)[:2]
    intersections = NetSet(
        tr("Intersections"), "line", trend, plunge, color=OKABE_ITO[-1], marker="x"
    )
    return replace(net, sets=(*net.sets, intersections))
