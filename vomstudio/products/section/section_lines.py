"""Geometry of a section: one plane through a point, or vertical planes along a map line."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import plane_option
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.section.section_options import SectionOptions

MIN_PIECE_M = 1e-9
"""Minimum length of a piece of a line, m; shorter pieces are duplicate points."""

MIN_BEND_DEG = 2.0
"""Minimum turn of a section at a bend; less counts as straight."""


@dataclass(frozen=True, eq=False)
class Panel:
    """Plane, or strip of a plane, of a section.

    Parameters
    ----------
    origin : (3,) array
        World, m, at the distance `start` along the section.
    right, up : (3,) arrays
        Unit vectors along the section and up in it, World.
    start : float
        m.
    low, high : float
        Limits along `right`, relative to the origin, m.
    level : float
        Added to lengths along `up`: World's Z of the origin in a vertical section.
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
        """Unit vector (3,) towards the viewer, who has `right` to the right and `up` upwards."""
        return np.cross(self.right, self.up)

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Return distance along the section, height and distance towards the viewer (n, 3), m."""
        away = points - self.origin
        return np.stack(
            [away @ self.right + self.start, away @ self.up + self.level, away @ self.normal],
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
    """Section as a whole.

    Parameters
    ----------
    panels : tuple of Panel
        In order along the section.
    vertical : bool
        Whether heights are Z of World.
    plane : Plane or None
        Plane of the section; None along a line with bends.
    """

    panels: tuple[Panel, ...]
    vertical: bool
    plane: Plane | None

    @property
    def ends(self) -> tuple[float, float]:
        """Azimuths of the left and the right end, degrees."""
        first, last = self.panels[0].right, self.panels[-1].right
        left, right = (math.degrees(math.atan2(v[0], v[1])) for v in (-first, last))
        return wrap360(left), wrap360(right)

    def bends(self, max_count: int) -> list[tuple[float, float]]:
        """Return the distances of bends along the section, and the azimuths after them.

        Of more than `max_count` bends the sharpest are returned.
        """
        bends = []
        for before, after in itertools.pairwise(self.panels):
            turn = math.degrees(math.acos(min(max(float(before.right @ after.right), -1.0), 1.0)))
            azimuth = wrap360(math.degrees(math.atan2(after.right[0], after.right[1])))
            if turn >= MIN_BEND_DEG:
                bends.append((turn, after.start, azimuth))
        bends = sorted(bends, reverse=True)[:max_count]
        return sorted((start, azimuth) for _, start, azimuth in bends)


def curtain_of_plane(plane: Plane, through: npt.ArrayLike) -> Curtain:
    """Build the section by a plane through the World point (3,) at distance zero.

    The view is against the upward normal of the plane, as in an orthophoto of it: the right end of
    a vertical section that dips towards DD is at DD - 90.
    """
    origin = np.asarray(through, np.float64)
    frame = ViewFrame.looking(0.0 - plane.normal())
    level = float(origin[2]) if plane.vertical else 0.0
    panel = Panel(origin, frame.right, 0.0 - frame.down, level=level)
    return Curtain((panel,), plane.vertical, plane)


def curtain_of_line(line: npt.ArrayLike) -> Curtain:
    """Build the vertical section along a map line.

    Parameters
    ----------
    line : (n, 2) or wider array_like
        x, y, World. The end of the line is to the right of the viewer.

    Raises
    ------
    InputError
        If the line has no length.
    """
    xy = np.asarray(line, np.float64)[:, :2]
    steps = np.diff(xy, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    keep = lengths > MIN_PIECE_M
    if not keep.any():
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
            xy[:-1][keep], steps[keep], lengths[keep], starts[keep], strict=True
        )
    )
    plane = Plane.from_normal(panels[0].normal) if len(panels) == 1 else None
    return Curtain(panels, True, plane)


def curtain_of_options(options: SectionOptions) -> Curtain:
    """Return the section by a plane through a point. Raises UsageError."""
    plane = plane_option(str(options.plane))
    return curtain_of_plane(plane, parse_through(str(options.through)))


def parse_through(text: str) -> FloatArray:
    """Parse the point (3,) of "x,y,z".

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
