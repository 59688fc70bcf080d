"""What is on a net, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.errors import GeometryError
from vomstudio.geology import stereonet as nets
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_line, format_plane
from vomstudio.geology.orientation import (
    Array,
    Line,
    Plane,
    lines_to_vectors,
    planes_to_poles,
)
from vomstudio.geology.statistics import axial_mean
from vomstudio.words import tr

OKABE_ITO = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000",
)  # fmt: skip
"""Okabe & Ito's colours, safe for the colour-blind, the strongest on white paper first."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

AUTO_CIRCLES = 40
"""With more planes than this their great circles hide the poles and are left out unless asked."""


@dataclass(frozen=True, eq=False)
class NetSet:
    """One set of features, drawn alike.

    kind "plane": azimuth_deg, angle_deg (n,) are dip direction and dip; "line": trend and plunge.
    ids name the features for picking and selecting (empty: they can't be). variant tells sets of
    one type apart without leaving its colour: full, open, pale, deep, then over again.
    """

    name: str
    kind: str
    azimuth_deg: Array
    angle_deg: Array
    ids: tuple[str, ...] = ()
    color: str = OKABE_ITO[0]
    marker: str = MARKERS[0]
    variant: int = 0

    def vectors(self) -> Array:
        """(n, 3) unit vectors: poles of planes, lines as they are."""
        turn = planes_to_poles if self.kind == "plane" else lines_to_vectors
        return turn(self.azimuth_deg, self.angle_deg).reshape(-1, 3)

    def __len__(self) -> int:
        return len(np.atleast_1d(self.azimuth_deg))


@dataclass(frozen=True)
class NetMean:
    """A mean of a set: a line to mark, and the text beside it. orientation : the line, or the mean
    plane, in the net's notation"""

    line: Line
    label: str
    color: str
    marker: str
    orientation: str = ""


@dataclass(frozen=True)
class NetEllipse:
    """95 % confidence ellipse of a plane's pole: semi-axes and the rake of the larger one, as the
    fit gives them."""

    plane: Plane
    max_angle_deg: float
    min_angle_deg: float
    rake_deg: float

    def outline(self, projection: str) -> list[Array]:
        """Polylines (k, 2) on the net."""
        return nets.pole_ellipse(
            self.plane, self.max_angle_deg, self.min_angle_deg, self.rake_deg, projection
        )


@dataclass(frozen=True, eq=False)
class NetLineEllipse:
    """Joint 95 % ellipse of a line: semi-axes, and the direction (3,) of the larger one."""

    line: Line
    max_angle_deg: float
    min_angle_deg: float
    axis: Array

    def outline(self, projection: str) -> list[Array]:
        """Polylines (k, 2) on the net."""
        return nets.confidence_ellipse(
            self.line.vector(), self.axis, self.max_angle_deg, self.min_angle_deg, projection
        )


AnyEllipse = NetEllipse | NetLineEllipse


@dataclass(frozen=True, eq=False)
class NetContents:
    """Everything a net shows, as plain data.

    circles: great circles of planes always (True), never (False), or while there are few (None).
    selected: ids that are emphasised; their great circles are always drawn.
    contour: one of `stereonet.DENSITY_METHODS`, of all poles and lines shown.
    notation, decimals: how orientations are written on the net.
    title, notes: over the net, and above its caption (frame, north, what was left out).
    compact: a net on the screen. Its legend is terse, and does not explain the selected pole's
    ellipse: it would move the net at every click.
    """

    sets: tuple[NetSet, ...] = ()
    projection: str = "area"
    circles: bool | None = None
    poles: bool = True
    means: tuple[NetMean, ...] = ()
    fold: FoldAxis | None = None
    selected: frozenset[str] = frozenset()
    ellipses: tuple[AnyEllipse, ...] = ()
    contour: str | None = None
    notation: str = "dipdir/dip"
    decimals: int = 0
    title: str = ""
    notes: tuple[str, ...] = ()
    compact: bool = False

    def with_selection(
        self, selected: Iterable[str], ellipses: Sequence[AnyEllipse] = ()
    ) -> NetContents:
        """The same net with other features emphasised."""
        return replace(self, selected=frozenset(selected), ellipses=tuple(ellipses))


def make_sets(
    groups: Mapping[str, tuple[str, Sequence[float] | Array, Sequence[float] | Array]],
    ids: Mapping[str, Sequence[str]] | None = None,
) -> tuple[NetSet, ...]:
    """Sets of {name: (kind, azimuths, angles)} with the colours and symbols of the house, in
    order; rows that are not numbers are left out."""
    sets = []
    for i, (name, (kind, azimuth, angle)) in enumerate(groups.items()):
        if kind not in ("plane", "line"):
            raise ValueError(kind)
        a, b = np.asarray(azimuth, dtype=np.float64), np.asarray(angle, dtype=np.float64)
        sound = np.isfinite(a) & np.isfinite(b)
        names = tuple(ids[name]) if ids and name in ids else ()
        kept = tuple(k for k, ok in zip(names, sound, strict=True) if ok) if names else ()
        color = OKABE_ITO[i % len(OKABE_ITO)]
        marker = MARKERS[(i + i // len(OKABE_ITO)) % len(MARKERS)]
        sets.append(NetSet(name, kind, a[sound], b[sound], kept, color, marker))
    return tuple(sets)


def means_of(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[NetMean, ...]:
    """Axial mean of every set of at least 3 that has one (poles for planes; the text is the mean
    plane)."""
    chosen = list(sets)
    means = []
    for s in chosen:
        if len(s) < 3:
            continue
        try:
            line = axial_mean(s.vectors())
        except GeometryError:
            continue
        if s.kind == "plane":
            text = format_plane(line.normal_plane(), notation, decimals)
        else:
            text = format_line(line, decimals)
        # Colour and symbol tell whose mean it is; a name would not fit where sets are many.
        label = text if len(chosen) > 1 else tr("Mean {orientation}", orientation=text)
        means.append(NetMean(line, label, s.color, s.marker, text))
    return tuple(means)


def circles_shown(net: NetContents) -> bool:
    """Whether all great circles are drawn."""
    if net.circles is not None:
        return net.circles
    return sum(len(s) for s in net.sets if s.kind == "plane") <= AUTO_CIRCLES
