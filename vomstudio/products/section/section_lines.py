"""Where a section runs: one plane through a point, or vertical planes along a line on the map."""

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

SHORTEST = 1e-9
"""Pieces of a line that are shorter are a point twice, metres."""

BEND_DEG = 2.0
"""A section that turns by less is straight."""


@dataclass(frozen=True, eq=False)
class Panel:
    """A plane, or a strip of one, on which a section is drawn.

    origin : (3,) World, at distance `start` along the section; right, up : (3,) unit vectors of
        World along the section and up in it; low, high : how far it reaches along right from the
        origin
    level : what is added to lengths along up: World's Z of the origin in a vertical section
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
        """(3,) toward the viewer, who has `right` at the right hand and `up` up."""
        return np.cross(self.right, self.up)

    def coordinates(self, points: FloatArray) -> FloatArray:
        """(n, 3) distance along the section, height in it, and distance from it toward the viewer,
        of World points (n, 3)."""
        away = points - self.origin
        return np.stack(
            [away @ self.right + self.start, away @ self.up + self.level, away @ self.normal],
            axis=1,
        )

    def world(self, along: FloatArray, height: FloatArray) -> FloatArray:
        """(n, 3) World of points on the section."""
        return (
            self.origin
            + (along - self.start)[:, None] * self.right
            + (height - self.level)[:, None] * self.up
        )


@dataclass(frozen=True, eq=False)
class Curtain:
    """A section as a whole. panels : along the section; vertical : heights are Z of World; plane :
    of the section, None along a line with bends"""

    panels: tuple[Panel, ...]
    vertical: bool
    plane: Plane | None

    @property
    def ends(self) -> tuple[float, float]:
        """Azimuths of the left and the right end, degrees."""
        first, last = self.panels[0].right, self.panels[-1].right
        left, right = (math.degrees(math.atan2(v[0], v[1])) for v in (-first, last))
        return wrap360(left), wrap360(right)

    def bends(self, most: int) -> list[tuple[float, float]]:
        """Distances along the section at which it turns by `BEND_DEG` or more, and the azimuth of
        its right end from there on; of more than `most` the sharpest."""
        found = []
        for before, after in itertools.pairwise(self.panels):
            turn = math.degrees(math.acos(min(max(float(before.right @ after.right), -1.0), 1.0)))
            azimuth = wrap360(math.degrees(math.atan2(after.right[0], after.right[1])))
            if turn >= BEND_DEG:
                found.append((turn, after.start, azimuth))
        found = sorted(found, reverse=True)[:most]
        return sorted((start, azimuth) for _, start, azimuth in found)


def curtain_of_plane(plane: Plane, through: npt.ArrayLike) -> Curtain:
    """The plane through a World point (3,), from which distances along it count. It is looked at
    against its upward normal, as an orthophoto of it is: the right end of a vertical section that
    dips toward DD is at DD - 90."""
    origin = np.asarray(through, np.float64)
    frame = ViewFrame.looking(0.0 - plane.normal())
    level = float(origin[2]) if plane.vertical else 0.0
    panel = Panel(origin, frame.right, 0.0 - frame.down, level=level)
    return Curtain((panel,), plane.vertical, plane)


def curtain_of_line(line: npt.ArrayLike) -> Curtain:
    """Vertical planes along a line on the map, (n, 2 or more) x, y, from its first point. The
    viewer has its end at the right hand. Raises InputError for a line without length."""
    xy = np.asarray(line, np.float64)[:, :2]
    steps = np.diff(xy, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    keep = lengths > SHORTEST
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
    """(3,) of "x,y,z". Raises UsageError."""
    try:
        found = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        found = np.empty(0)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise UsageError(Finding("section.not-a-point", text=text), field="--through")
    return found
