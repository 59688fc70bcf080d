"""What is on a net, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.common_rotation_errors import (
    Region,
    Turns,
    cone,
    move_vectors,
    principal_axis,
    region,
)
from vomstudio.geology.density import SIGMA
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_line, format_plane
from vomstudio.geology.orientation import (
    Line,
    Plane,
    lines_to_vectors,
    planes_to_poles,
    sin_cos_deg,
)
from vomstudio.geology.statistics import (
    axial_mean,
    fisher,
    no_fisher_reason,
    orientation_tensor,
)
from vomstudio.geometry.rotation_errors import enlarged_semi_axes

OKABE_ITO = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#F0E442",
    "#000000",
)
"""Okabe & Ito's colours, safe for the colour-blind, the strongest on white paper first."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

TYPED_LINE = "d"
"""The marker of a line that was typed: of no set, and of no mean."""

AUTO_CIRCLES = 40
"""With more planes than this their great circles hide the poles and are left out unless asked."""


@dataclass(frozen=True, eq=False)
class NetSet:
    """One set of features, drawn alike.

    kind "plane": azimuth_deg, angle_deg (n,) are dip direction and dip; "line": trend and plunge.
    ids name the features for picking and selecting (empty: they can't be). variant tells sets of
    one type apart without leaving its colour: full, open, pale, deep, then over again. turns: how
    they turn with the registrations of their models, None where nothing is known of that. slips
    (n, 3): of striae, the unit vectors along which the hanging walls move, NaN where that is not
    known; None of none.
    """

    name: str
    kind: str
    azimuth_deg: FloatArray
    angle_deg: FloatArray
    ids: tuple[str, ...] = ()
    color: str = OKABE_ITO[0]
    marker: str = MARKERS[0]
    variant: int = 0
    turns: Turns | None = None
    slips: FloatArray | None = None

    @property
    def registered(self) -> bool:
        """Whether the error of a registration is known for any of them."""
        return self.turns is not None and self.turns.known

    def vectors(self) -> FloatArray:
        """(n, 3) unit vectors: poles of planes, lines as they are."""
        turn = planes_to_poles if self.kind == "plane" else lines_to_vectors
        return turn(self.azimuth_deg, self.angle_deg).reshape(-1, 3)

    def __len__(self) -> int:
        return len(np.atleast_1d(self.azimuth_deg))


@dataclass(frozen=True)
class NetMean:
    """A mean of a set: a line to mark, and the text beside it. orientation : the line, or the mean
    plane, in the net's notation. of_cluster : it is Fisher's mean; else the first axis of the
    tensor, for a girdle or a scatter has no mean. total : its 95 % ellipse with the registration,
    None where no error of a registration is known"""

    line: Line
    label: str
    color: str
    marker: str
    orientation: str = ""
    total: NetLineEllipse | None = None
    of_cluster: bool = True


@dataclass(frozen=True)
class NetEllipse:
    """95 % ellipse of a plane's pole: semi-axes and the rake of the larger one."""

    plane: Plane
    max_angle_deg: float
    min_angle_deg: float
    rake_deg: float

    @classmethod
    def with_total(
        cls,
        plane: Plane,
        largest_deg: float,
        smallest_deg: float,
        rake_deg: float,
        total_deg: float,
    ) -> NetEllipse:
        """The ellipse of a fit, enlarged to its total error (see `enlarged_semi_axes`)."""
        largest, smallest = enlarged_semi_axes(largest_deg, smallest_deg, total_deg)
        return cls(plane, float(largest), float(smallest), rake_deg)

    def outline(self, projection: str) -> list[FloatArray]:
        """Polylines (k, 2) on the net."""
        return nets.pole_ellipse(
            self.plane, self.max_angle_deg, self.min_angle_deg, self.rake_deg, projection
        )

    def of_pole(self) -> NetLineEllipse:
        """The same as that of a line, the pole."""
        pole = self.plane.pole()
        sine, cosine = sin_cos_deg(self.rake_deg)
        toward = cosine * self.plane.strike_vector() + sine * self.plane.dip_vector()
        return NetLineEllipse(pole, self.max_angle_deg, self.min_angle_deg, np.asarray(toward))


@dataclass(frozen=True, eq=False)
class NetLineEllipse:
    """Joint 95 % ellipse of a line: semi-axes, and the direction (3,) of the larger one."""

    line: Line
    max_angle_deg: float
    min_angle_deg: float
    axis: FloatArray

    @classmethod
    def of(cls, vector: FloatArray, region: Region) -> NetLineEllipse:
        """Of a region about a unit vector (3,)."""
        line = Line.from_vector(vector)
        return cls(line, region.largest_deg, region.smallest_deg, region.axis)

    def outline(self, projection: str) -> list[FloatArray]:
        """Polylines (k, 2) on the net."""
        return nets.confidence_ellipse(
            self.line.vector(), self.axis, self.max_angle_deg, self.min_angle_deg, projection
        )


def fold_ellipse(fold: FoldAxis) -> NetLineEllipse | None:
    """Return the 95 % ellipse of a fold axis, with the registration as far as that is known."""
    if fold.total is not None and fold.registration_error_deg is not None:
        return NetLineEllipse.of(fold.beta.vector(), fold.total)
    largest, smallest = fold.max_confidence95_deg, fold.min_confidence95_deg
    if largest is None or smallest is None or fold.confidence_axis is None:
        return None
    return NetLineEllipse(fold.beta, largest, smallest, fold.confidence_axis.vector())


@dataclass(frozen=True)
class NetCircle:
    """A circle about an axis: half_angle_deg 90 is a great circle. label: for the legend. color:
    of the set that it is of, None for one that was typed."""

    axis: Line
    half_angle_deg: float
    label: str
    color: str | None = None

    @property
    def dash(self) -> str:
        """Of its line: great and small circles are told apart."""
        return "--" if self.half_angle_deg == 90.0 else ":"

    def outline(self, projection: str) -> list[FloatArray]:
        """Polylines (k, 2) on the net."""
        axis = self.axis.vector()
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first /= np.linalg.norm(first)
        half = self.half_angle_deg
        return nets.cone_curve(axis, first, np.cross(axis, first), half, half, projection, 361)


@dataclass(frozen=True, eq=False)
class NetBand:
    """The band of poles that a straight trace allows: its two edges (k, 3), of normals."""

    edges: tuple[FloatArray, FloatArray]

    def outline(self, projection: str) -> list[FloatArray]:
        """Polylines (k, 2) on the net."""
        return [part for edge in self.edges for part in nets.split_at_primitive(edge, projection)]


AnyEllipse = NetEllipse | NetLineEllipse | NetBand


@dataclass(frozen=True)
class NetMark:
    """A direction that is marked, with the text beside it. color: of the set that it is of, None
    for one that was typed; said: of a typed one, the words of its text before its line."""

    line: Line
    label: str
    marker: str = "x"
    color: str | None = None
    said: str = ""


@dataclass(frozen=True)
class NetLive:
    """A feature that is being picked: its plane, or its line, with its 95 % ellipse where that is
    known."""

    plane: Plane | None = None
    line: Line | None = None
    ellipse: AnyEllipse | None = None

    @property
    def place(self) -> Line | None:
        """Of the pole or the line."""
        return self.line if self.plane is None else self.plane.pole()


@dataclass(frozen=True)
class Contouring:
    """How density is contoured.

    levels: ascending, in the unit of the method; empty for round ones. filled: None for filled
    where all are contoured together, lines where each set is by itself. sigma: Kamb's, which makes
    the counting circle larger (no meaning for Schmidt's).
    """

    levels: tuple[float, ...] = ()
    filled: bool | None = None
    each_set: bool = False
    sigma: float = SIGMA

    @property
    def is_filled(self) -> bool:
        return not self.each_set if self.filled is None else self.filled


@dataclass(frozen=True, eq=False)
class NetContents:
    """Everything a net shows, as plain data.

    fold_not_good: planes of the fold axis whose verdict is not good, None if not known.
    circles: great circles of planes always (True), never (False), or while there are few (None).
    selected: ids that are emphasised; their great circles are always drawn.
    contour: one of `density.DENSITY_METHODS`, of all poles and lines; contouring: how.
    notation, decimals: how orientations are written on the net.
    circles_typed: great and small circles that were asked for, girdles too.
    marks: directions that were asked for: the densest places, slip lines that were typed.
    errors: 95 % ellipses of all features of which they are known.
    averages: of each set in words, under the legend.
    live: the feature that is being picked.
    title, notes: over the net, and above its caption (frame, north, what was left out).
    compact: a net on the screen. Its legend is terse, and does not explain the selected pole's
    ellipse: it would move the net at every click.
    north: False in a local frame, where azimuths are from its y axis.
    """

    sets: tuple[NetSet, ...] = ()
    projection: str = "area"
    circles: bool | None = None
    poles: bool = True
    means: tuple[NetMean, ...] = ()
    fold: FoldAxis | None = None
    fold_not_good: int | None = None
    selected: frozenset[str] = frozenset()
    ellipses: tuple[AnyEllipse, ...] = ()
    contour: str | None = None
    contouring: Contouring = Contouring()
    circles_typed: tuple[NetCircle, ...] = ()
    marks: tuple[NetMark, ...] = ()
    errors: tuple[AnyEllipse, ...] = ()
    averages: tuple[str, ...] = ()
    live: NetLive | None = None
    notation: str = "dipdir/dip"
    decimals: int = 0
    title: str = ""
    notes: tuple[str, ...] = ()
    compact: bool = False
    north: bool = True

    def with_selection(
        self, selected: Iterable[str], ellipses: Sequence[AnyEllipse] = ()
    ) -> NetContents:
        """The same net with other features emphasised."""
        return replace(self, selected=frozenset(selected), ellipses=tuple(ellipses))


def make_sets(
    groups: Mapping[str, tuple[str, Sequence[float] | FloatArray, Sequence[float] | FloatArray]],
    ids: Mapping[str, Sequence[str]] | None = None,
    turns: Mapping[str, Turns] | None = None,
) -> tuple[NetSet, ...]:
    """Sets of {name: (kind, azimuths, angles)} with the colours and symbols of the house, in
    order; rows that are not numbers are left out. turns: of each, where known."""
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
        turned = turns[name].of(sound) if turns and name in turns else None
        sets.append(NetSet(name, kind, a[sound], b[sound], kept, color, marker, turns=turned))
    return tuple(sets)


def means_of(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[NetMean, ...]:
    """Of every set of at least 3 what its averages in words are: Fisher's mean of a cluster, else
    the first axis of its tensor, where it has one (poles for planes; the text is the mean
    plane)."""
    chosen = list(sets)
    means = []
    for s in chosen:
        if len(s) < 3:
            continue
        vectors = s.vectors()
        directed = s.kind == "line" and bool((s.angle_deg < 0).any())
        cluster = no_fisher_reason(vectors, directed) is None
        try:
            line = fisher(vectors, directed).mean if cluster else axial_mean(vectors)
        except GeometryError:
            continue
        if s.kind == "plane":
            text = format_plane(line.normal_plane(), notation, decimals)
        else:
            text = format_line(line, decimals)
        # Colour and symbol tell whose mean it is; a name would not fit where sets are many.
        label = text
        if len(chosen) == 1:
            label = (
                tr("Mean {orientation}", orientation=text)
                if cluster
                else tr("Axis 1 {orientation}", orientation=text)
            )
        total = _total(s, line.vector())
        means.append(NetMean(line, label, s.color, s.marker, text, total, cluster))
    return tuple(means)


def means_text(means: Sequence[NetMean]) -> str:
    """What the open symbols of a net are."""
    of_clusters = {mean.of_cluster for mean in means}
    if of_clusters == {True}:
        return tr("Open symbol: Fisher mean")
    if of_clusters == {False}:
        return tr("Open symbol: axis 1 of the tensor")
    return tr("Open symbol: Fisher mean; of girdles axis 1")


def _total(s: NetSet, mean: FloatArray) -> NetLineEllipse | None:
    """The 95 % ellipse of a set's mean (3,) with the registration: about the cone of Fisher, where
    the set is a cluster."""
    if s.turns is None or not s.turns.known:
        return None
    vectors = s.vectors()
    values, axes = orientation_tensor(vectors)
    covariance = principal_axis(move_vectors(vectors, s.turns), values, axes, 0).covariance()[0]
    own = None
    if no_fisher_reason(vectors, False) is None:
        alpha = fisher(vectors, False).alpha95_deg
        own = None if alpha is None else cone(mean, alpha)
    return NetLineEllipse.of(mean, region(mean, covariance, own))


def circles_shown(net: NetContents) -> bool:
    """Whether all great circles are drawn."""
    if net.circles is not None:
        return net.circles
    return sum(len(s) for s in net.sets if s.kind == "plane") <= AUTO_CIRCLES
