"""Geometry of sections: a plane through a point, or vertical planes along a map line."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import parse_plane_option
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.section.section_options import SectionOptions

MIN_SEGMENT_M = 1e-9
"""Minimum length of a line segment in metres; shorter ones are due to duplicate points."""

MIN_BEND_DEG = 2.0
"""Minimum change of direction at a bend; smaller changes are treated as straight."""


@dataclass(frozen=True, eq=False)
class Panel:
    """Planar panel of a section: a plane or a strip of a plane.

    Parameters
    ----------
    origin : (3,) array
        Point in the World frame, m, at the distance `start` along the section.
    right, up : (3,) arrays
        Unit vectors along the section and upwards in it, in the World frame.
    start : float
        Distance of the origin along the section, m.
    low, high : float
        Limits of the panel along `right`, relative to the origin, m.
    level : float
        Offset that is added to lengths along `up`; in a vertical section, the World Z of the
        origin.
    """

    origin: FloatArray
    right: FloatArray
    up: FloatArray
    start: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    level: float = 0.0

    @property
    def normal(self) -> FloatArray:
        """Unit normal (3,) towards a viewer who sees `right` to the right and `up` upwards."""
        return np.cross(self.right, self.up)

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Return section coordinates (n, 3) in metres: along, height, and towards the viewer."""
        offsets = points - self.origin
        return np.stack(
            [
                offsets @ self.right + self.start,
                offsets @ self.up + self.level,
                offsets @ self.normal,
            ],
            axis=1,
        )

    def world(self, along: FloatArray, height: FloatArray) -> FloatArray:
        """Return the World coordinates (n, 3) of points on the section."""
        return (
            self.origin
            + (along - self.start)[:, None] * self.right
            + (height - self.level)[:, None] * self.up
        )


@dataclass(frozen=True, eq=False)
class Curtain:
    """Complete section, consisting of one or more panels.

    Parameters
    ----------
    panels : tuple of Panel
        Panels in order along the section.
    vertical : bool
        Whether the section is vertical, so that heights are World Z.
    plane : Plane or None
        Plane of the section; None if it follows a bent line.
    """

    panels: tuple[Panel, ...]
    vertical: bool
    plane: Plane | None

    @property
    def ends(self) -> tuple[float, float]:
        """Azimuths of the left and the right end in degrees."""
        first_right, last_right = self.panels[0].right, self.panels[-1].right
        left, right = (math.degrees(math.atan2(v[0], v[1])) for v in (-first_right, last_right))
        return wrap360(left), wrap360(right)

    @property
    def normal(self) -> FloatArray:
        """Mean normal (3,) towards the viewer."""
        return np.asarray(np.mean([panel.normal for panel in self.panels], axis=0))

    def flipped(self) -> Curtain:
        """Return the section as seen from the other side, a mirror image.

        Distances along a line count from its other end; those on a plane change their sign.
        """
        if not math.isfinite(self.panels[-1].high):
            (panel,) = self.panels
            return replace(self, panels=(replace(panel, right=0.0 - panel.right),))
        length = self.panels[-1].start + self.panels[-1].high
        # Like those of a line, the panels begin at their origin.
        panels = (
            replace(
                panel,
                origin=panel.origin + panel.high * panel.right,
                right=0.0 - panel.right,
                start=length - panel.start - panel.high,
            )
            for panel in reversed(self.panels)
        )
        return replace(self, panels=tuple(panels))

    def bends(self, max_count: int) -> list[tuple[float, float]]:
        """Return the distance of each bend along the section, and the azimuth after it.

        If there are more than `max_count` bends, only the sharpest are returned.
        """
        bends = []
        for previous_panel, next_panel in itertools.pairwise(self.panels):
            angle = math.degrees(
                math.acos(min(max(float(previous_panel.right @ next_panel.right), -1.0), 1.0))
            )
            azimuth = wrap360(math.degrees(math.atan2(next_panel.right[0], next_panel.right[1])))
            if angle >= MIN_BEND_DEG:
                bends.append((angle, next_panel.start, azimuth))
        bends = sorted(bends, reverse=True)[:max_count]
        return sorted((start, azimuth) for _, start, azimuth in bends)


def curtain_from_plane(plane: Plane, through: npt.ArrayLike) -> Curtain:
    """Build the section on a plane through a World point (3,), which has distance zero.

    The section is viewed against the upward normal of the plane, like an orthophoto of it. The
    right end of a vertical section with dip direction DD is therefore at DD - 90.
    """
    origin = np.asarray(through, np.float64)
    frame = ViewFrame.from_direction(0.0 - plane.normal())
    level = float(origin[2]) if plane.vertical else 0.0
    panel = Panel(origin, frame.right, 0.0 - frame.down, level=level)
    return Curtain((panel,), plane.vertical, plane)


def curtain_from_line(line: npt.ArrayLike) -> Curtain:
    """Build the vertical section along a map line.

    Parameters
    ----------
    line : (n, 2) or wider array_like
        World x, y. The end of the line is on the viewer's right.

    Raises
    ------
    InputError
        If the line has no length.
    """
    xy = np.asarray(line, np.float64)[:, :2]
    steps = np.diff(xy, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    is_long_enough = lengths > MIN_SEGMENT_M
    if not is_long_enough.any():
        raise InputError(Finding("section.no-length"), field="--section-line")
    starts = np.concatenate([[0.0], np.cumsum(lengths)])[:-1]
    panels = tuple(
        Panel(
            np.array([*corner, 0.0]),
            np.array([*(step / length), 0.0]),
            np.array([0.0, 0.0, 1.0]),
            float(start),
            0.0,
            float(length),
        )
        for corner, step, length, start in zip(
            xy[:-1][is_long_enough],
            steps[is_long_enough],
            lengths[is_long_enough],
            starts[is_long_enough],
            strict=True,
        )
    )
    plane = Plane.from_normal(panels[0].normal) if len(panels) == 1 else None
    return Curtain(panels, True, plane)


def curtain_from_options(options: SectionOptions) -> Curtain:
    """Build the section on the plane and through the point of the options.

    Raises UsageError.
    """
    plane = parse_plane_option(str(options.plane))
    curtain = curtain_from_plane(plane, parse_through_point(str(options.through)))
    return curtain.flipped() if options.flip else curtain


def parse_through_point(text: str) -> FloatArray:
    """Parse a point (3,) given as "x,y,z".

    Raises
    ------
    UsageError
    """
    try:
        point = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        point = np.empty(0)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise UsageError(Finding("section.not-a-point", text=text), field="--through")
    return point
