"""What may be done to a net before it is drawn: turned back, intersections added, circles typed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.errors import InputError, UsageError
from vomstudio.geology.notation import parse_plane
from vomstudio.geology.orientation import Array, Line, Plane, normals_to_planes, vectors_to_lines
from vomstudio.geology.rotations import meetings, turned, untilted
from vomstudio.products.net.contents import OKABE_ITO, NetCircle, NetContents, NetSet, means_of
from vomstudio.words import tr

MOST_PLANES = 300
"""Of more planes the intersections (45,000) are not told apart on a net."""


def typed_plane(text: str) -> NetCircle:
    """The great circle of "DD/D". Raises UsageError."""
    plane = plane_of(text, "--plane")
    return NetCircle(plane.pole(), 90.0, tr("Plane {plane}", plane=text))


def typed_cone(text: str) -> NetCircle:
    """The small circle of "TREND/PLUNGE/HALF-ANGLE". Raises UsageError."""
    trend, plunge, half = _three(text, "--cone")
    if not 0.0 < half <= 90.0:
        raise UsageError(
            tr("The half-angle of a cone lies between 0 and 90 degrees."), field="--cone"
        )
    return NetCircle(_line(trend, plunge, "--cone"), half, tr("Cone {cone}", cone=text))


def plane_of(text: str, field: str) -> Plane:
    """Of "DD/D". Raises UsageError."""
    try:
        return parse_plane(text, "dipdir/dip")
    except InputError as error:
        raise UsageError(error.message, field=field) from error


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
    raise UsageError(tr("“{text}” is not three numbers like 125/26/30.", text=text), field=field)


def _line(trend: float, plunge: float, field: str) -> Line:
    if not 0.0 <= plunge <= 90.0:
        raise UsageError(tr("A plunge lies between 0 and 90 degrees."), field=field)
    return Line(trend, plunge)


def net_untilted(net: NetContents, plane: Plane) -> NetContents:
    """All of the net after the plane has been turned to the horizontal about its strike."""
    note = tr(
        "Untilted by {dip_direction:03.0f}/{dip:02.0f}",
        dip_direction=plane.dip_direction_deg,
        dip=plane.dip_deg,
    )
    return _moved(net, [untilted(s.vectors(), plane) for s in net.sets], note)


def net_turned(net: NetContents, axis: Line, angle_deg: float) -> NetContents:
    """All of the net turned about an axis, by the right-hand rule about its downward end."""
    note = tr(
        "Turned by {angle:g}° about {trend:03.0f}/{plunge:02.0f}",
        angle=angle_deg,
        trend=axis.trend_deg,
        plunge=axis.plunge_deg,
    )
    return _moved(net, [turned(s.vectors(), axis, angle_deg) for s in net.sets], note)


def _moved(net: NetContents, vectors: Sequence[Array], note: str) -> NetContents:
    """Registrations turn what is measured: what they do to it after it was turned is not said."""
    sets = []
    for s, v in zip(net.sets, vectors, strict=True):
        azimuth, angle = normals_to_planes(v)[:2] if s.kind == "plane" else vectors_to_lines(v)[:2]
        sets.append(replace(s, azimuth_deg=azimuth, angle_deg=angle, turns=None))
    meant = {mean.color + mean.marker for mean in net.means}
    clustered = [s for s in sets if s.color + s.marker in meant]
    means = means_of(clustered, net.notation, net.decimals)
    return replace(net, sets=tuple(sets), means=means, notes=(*net.notes, note))


def with_intersections(net: NetContents) -> NetContents:
    """The lines in which each two of the planes meet, as a set of their own. Raises UsageError for
    too many planes, and for fewer than two."""
    poles = [s.vectors() for s in net.sets if s.kind == "plane"]
    count = sum(map(len, poles))
    if not 2 <= count <= MOST_PLANES:
        raise UsageError(
            tr(
                "Intersections are drawn of 2 to {most} planes; there are {count}.",
                most=MOST_PLANES,
                count=count,
            ),
            field="--intersections",
        )
    lines = meetings(np.vstack(poles))
    trend, plunge = vectors_to_lines(lines)[:2]
    made = NetSet(tr("Intersections"), "line", trend, plunge, color=OKABE_ITO[-1], marker="x")
    return replace(net, sets=(*net.sets, made))
