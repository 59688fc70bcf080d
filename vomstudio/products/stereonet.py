"""The net as a figure: one drawing for the window's dock and for `vomstudio stereonet`.

Everything is drawn in our own projected coordinates on one plain Axes that covers the figure: one
net unit is the radius of the net. That redraws in milliseconds, picks with plain arithmetic, and
leaves every artist an ordinary one (a map projection Axes transforms each vertex again at every
redraw). Matplotlib is imported where it is first needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, UsageError
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

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

OKABE_ITO = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000",
)  # fmt: skip
"""Okabe & Ito's colours, safe for the colour-blind, the strongest on white paper first."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

_SIZES = {"P": 1.4, "X": 1.3, "*": 1.5, "D": 0.85, "^": 1.1, "v": 1.1, "p": 1.15}
"""Symbols of the same size do not look so: by how much each is drawn larger."""

DENSITY_NAMES = {
    "kamb": "Density after Kamb, 3 σ",
    "exponential_kamb": "Density, exponential Kamb, 3 σ",
    "linear_kamb": "Density, linear Kamb, 3 σ",
    "schmidt": "Density after Schmidt",
}

PROJECTION_NAMES = {"area": "Equal area", "angle": "Equal angle"}

AUTO_CIRCLES = 40
"""With more planes than this their great circles hide the poles and are left out unless asked."""

FORMATS = ("svg", "pdf", "png")


# What is on the net --------------------------------------------------------------------------


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
    """A mean of a set: a line to mark, and the text beside it."""

    line: Line
    label: str
    color: str
    marker: str


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
        label = text if len(chosen) > 1 else f"mean {text}"
        means.append(NetMean(line, label, s.color, s.marker))
    return tuple(means)


# How it looks --------------------------------------------------------------------------------


@dataclass(frozen=True)
class NetStyle:
    """Colours and sizes; sizes in points (1/72 inch of the figure)."""

    ink: str = "#1a1a1a"
    soft: str = "#7a7a7a"
    paper: str = "#ffffff"
    net: str = "#ffffff"
    font_pt: float = 8.0
    marker_pt: float = 4.5
    line_pt: float = 0.8
    swaps: Mapping[str, str] = field(default_factory=dict)
    contour_map: str = "light"

    @classmethod
    def dock(cls, dark: bool = False, dpi: float = 100.0, font_px: float = 11.0) -> NetStyle:
        """Sizes in pixels of a screen, light or dark."""
        px = 72.0 / dpi
        sizes = {"font_pt": font_px * px, "marker_pt": 6.0 * px, "line_pt": 1.1 * px}
        return replace(cls.dark() if dark else cls(), **sizes)  # type: ignore[arg-type]

    @classmethod
    def dark(cls) -> NetStyle:
        return cls(
            ink="#e8e8e8",
            soft="#9a9a9a",
            paper="#202124",
            net="#2a2b2e",
            # Black and the deepest blue vanish on a dark ground.
            swaps={"#000000": "#ffffff", "#0072B2": "#3d9be0"},
            contour_map="dark",
        )

    def color(self, color: str) -> str:
        for name, other in self.swaps.items():
            if name.casefold() == color.casefold():
                return other
        # A type's colour is made for a photograph: on a dark net a deep one is lifted.
        if _lightness(self.net) < 0.2:
            while _contrast(color, self.net) < 3.0:
                color = _mixed(color, self.ink, 0.15)
        return color

    def symbol(self, s: NetSet) -> tuple[str, str, float]:
        """Face and edge colour of a set's symbols, and the edge's width in points."""
        color = self.color(s.color)
        if s.variant % 4 == 1:
            return self.net, self.outline(color), 1.5 * self.line_pt
        if s.variant % 4 == 2:
            return _mixed(color, self.net), self.outline(color), 1.2 * self.line_pt
        face = color if s.variant % 4 == 0 else _mixed(color, self.ink)
        edge = self.outline(face)
        if s.marker in "PX" and edge == face:  # a light rim would leave little of their arms
            return face, face, 0.5 * self.line_pt
        return (face, self.net, 0.5 * self.line_pt) if edge == face else (face, edge, self.line_pt)

    def outline(self, color: str) -> str:
        """A colour for thin lines: yellow would be lost on white paper."""
        return _mixed(color, self.ink) if _contrast(color, self.net) < 1.8 else color


def _mixed(color: str, other: str, share: float = 0.5) -> str:
    from matplotlib.colors import to_hex, to_rgb

    pairs = zip(to_rgb(color), to_rgb(other), strict=True)
    return to_hex([(1.0 - share) * a + share * b for a, b in pairs])


@lru_cache(maxsize=256)
def _lightness(color: str) -> float:
    """Relative luminance, 0 to 1 (WCAG 2)."""
    from matplotlib.colors import to_rgb

    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in to_rgb(color)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def _contrast(a: str, b: str) -> float:
    """Contrast ratio of two colours, 1 to 21 (WCAG 2)."""
    low, high = sorted((_lightness(a), _lightness(b)))
    return (high + 0.05) / (low + 0.05)


PRINT = NetStyle()
PRINT_SIZE_MM = (170.0, 115.0)


# The drawing ---------------------------------------------------------------------------------


@dataclass(eq=False)
class NetArtists:
    """The drawn net, and what a pointer needs to know of it.

    Pixels are matplotlib's display pixels: from the bottom left corner, y up.
    """

    axes: Axes
    contents: NetContents
    style: NetStyle
    radius_px: float
    centre_px: tuple[float, float]
    positions: list[Array]
    """Per set (n, 2) net positions of poles or lines."""
    arcs: list[Array]
    """Per set (m, k, 2) great circles as drawn (m = 0: none)."""
    arc_rows: list[npt.NDArray[np.intp]]
    """Per set (m,) rows of the set that the arcs belong to."""
    poles: list[Line2D]
    emphasis: list[Artist]
    text_boxes: list[tuple[float, float, float, float]]
    """Pixel boxes (x0, y0, x1, y1) of all text, for tests of overlap."""

    def to_net(self, x_px: float, y_px: float) -> tuple[float, float]:
        """Net position (unit circle) of a pixel."""
        cx, cy = self.centre_px
        return (x_px - cx) / self.radius_px, (y_px - cy) / self.radius_px

    def line_at(self, x_px: float, y_px: float) -> Line | None:
        """The line under a pixel, None outside the net."""
        return nets.line_at(*self.to_net(x_px, y_px), self.contents.projection)

    def feature_at(self, x_px: float, y_px: float, reach_px: float = 6.0) -> str | None:
        """Id of the nearest pole or line within reach, else of the nearest great circle drawn
        within half of it, else None. Among equals the one drawn last, which is on top."""
        point = np.array(self.to_net(x_px, y_px))
        best, found = reach_px / self.radius_px, None
        if self.contents.poles:
            for s, at in zip(self.contents.sets, self.positions, strict=True):
                if s.ids and len(at):
                    away = np.hypot(*(at - point).T)
                    row = len(away) - 1 - int(np.argmin(away[::-1]))
                    if away[row] <= best:
                        best, found = float(away[row]), s.ids[row]
        if found is not None:
            return found
        best = max(2.0, reach_px / 2.0) / self.radius_px
        for s, arcs, rows in zip(self.contents.sets, self.arcs, self.arc_rows, strict=True):
            if s.ids and len(arcs):
                away = _distance_to_arcs(point, arcs)
                i = int(np.argmin(away))
                if away[i] <= best:
                    best, found = float(away[i]), s.ids[int(rows[i])]
        return found

    def features_within(self, polygon_px: Sequence[tuple[float, float]]) -> frozenset[str]:
        """Ids of the poles and lines inside a polygon of pixels (a lasso)."""
        from matplotlib.path import Path as Outline

        outline = Outline([self.to_net(x, y) for x, y in polygon_px])
        return frozenset(
            s.ids[int(i)]
            for s, at in zip(self.contents.sets, self.positions, strict=True)
            if s.ids and len(at)
            for i in np.flatnonzero(outline.contains_points(at))
        )

    def select(self, selected: Iterable[str], ellipses: Sequence[AnyEllipse] = ()) -> None:
        """Emphasises other features and leaves the rest; the caller redraws the canvas. All is
        drawn anew only where the legend gains, loses or renames the ellipse."""
        before = [type(e) for e in self.contents.ellipses]
        self.contents = self.contents.with_selection(selected, ellipses)
        if before != [type(e) for e in ellipses] and not self.contents.compact:
            figure = self.axes.get_figure(root=True)
            assert figure is not None
            anew = draw_stereonet(figure, self.contents, self.style)
            self.__dict__.update(anew.__dict__)
            return
        for artist in self.emphasis:
            artist.remove()
        self.emphasis = _draw_emphasis(self.axes, self.contents, self.style, self.positions)


def draw_stereonet(figure: Figure, net: NetContents, style: NetStyle = PRINT) -> NetArtists:
    """Draws the net over the whole figure, which is cleared first. Lays itself out by the figure's
    size: legend beside the net where the figure is wide, below it where it is not. Call it again
    after a resize."""
    if net.contour is not None and net.contour not in nets.DENSITY_METHODS:
        raise UsageError(
            f"“{net.contour}” is no way to contour; use one of {', '.join(nets.DENSITY_METHODS)}."
        )
    figure.clear()
    figure.set_facecolor(style.paper)
    page = _Page(figure, net, style)
    ax = page.axes
    page.draw_frame()
    if net.contour is not None:
        page.draw_contours(net.contour)
    positions = [nets.project(s.vectors(), net.projection) for s in net.sets]
    arcs, rows = page.draw_circles()
    poles = page.draw_poles(positions)
    if net.fold is not None:
        page.draw_fold(net.fold)
    emphasis = _draw_emphasis(ax, net, style, positions)
    page.draw_legend()
    page.draw_means_and_labels()  # last, so that labels can keep clear of all other text
    return NetArtists(
        ax, net, style, page.radius * page.px, (page.cx * page.px, page.cy * page.px),
        positions, arcs, rows, poles, emphasis,
        [tuple(v * page.px for v in box) for box in page.text_boxes],  # type: ignore[misc]
    )  # fmt: skip


def write_stereonet(
    target: str | Path | IO[bytes],
    net: NetContents,
    *,
    format: str,
    style: NetStyle = PRINT,
    size_mm: tuple[float, float] = PRINT_SIZE_MM,
    dpi: float = 300.0,
) -> None:
    """Writes the figure as svg, pdf or png (text stays text in svg and pdf)."""
    if format not in FORMATS:
        raise UsageError(f"A net cannot be written as “{format}”; use svg, pdf or png.")
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size_mm[0] / 25.4, size_mm[1] / 25.4), dpi=dpi)
    FigureCanvasAgg(figure)
    draw_stereonet(figure, net, style)
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}[format]
    with rc_context({"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "vomstudio"}):
        figure.savefig(target, format=format, dpi=dpi, facecolor=style.paper, metadata=metadata)


@lru_cache(maxsize=4096)
def _text_width(text: str, font_pt: float) -> float:
    """Width of a text in points, without needing a canvas."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    if not text.strip():
        return 0.3 * font_pt * len(text)
    # A set may be called "$": names are no formulas.
    plain = text.replace("$", r"\$")
    box = TextPath((0, 0), plain, size=font_pt, prop=FontProperties()).get_extents()
    return float(box.x1)


def _shortened(text: str, font_pt: float, width: float) -> str:
    if _text_width(text, font_pt) <= width:
        return text
    while len(text) > 1 and _text_width(text + "…", font_pt) > width:
        text = text[:-1]
    return text.rstrip() + "…"


@dataclass(frozen=True)
class _Entry:
    """A line of the legend: a symbol (marker and/or line) and its text."""

    text: str
    color: str
    marker: str | None = None
    line: str | None = None
    outlined: bool = False
    like: NetSet | None = None
    """Of this set: its symbol is drawn as on the net."""


Box = tuple[float, float, float, float]


class _Page:
    """The layout of one figure, in points from its bottom left corner."""

    def __init__(self, figure: Figure, net: NetContents, style: NetStyle) -> None:
        self.net, self.style = net, style
        self.width, self.height = (72.0 * float(v) for v in figure.get_size_inches())
        self.px = figure.dpi / 72.0
        self.font = style.font_pt
        self.row = 1.45 * self.font
        self.pad = 0.8 * self.font
        self.entries = _legend_entries(net, style)
        self.foot = list(net.notes)
        planes = sum(len(s) for s in net.sets if s.kind == "plane")
        if net.circles is None and planes > AUTO_CIRCLES:
            self.foot.append(f"great circles left out ({planes:,} planes)")
        self.foot.append(f"{PROJECTION_NAMES[net.projection]}, lower hemisphere")
        self.heading = 1.9 * self.row if net.title else 0.0
        self.text_boxes: list[Box] = []
        self.outlines: list[Array] = []
        """Points of curves that labels should not lie on, on the net."""
        self.levels: list[float] = []
        self.colors: list[object] = []
        self._arrange()
        self.axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        r = self.radius
        self.axes.set_xlim(-self.cx / r, (self.width - self.cx) / r)
        self.axes.set_ylim(-self.cy / r, (self.height - self.cy) / r)
        self.axes.set_axis_off()
        self.axes.set_autoscale_on(False)

    # Layout

    def _arrange(self) -> None:
        """Where the net goes, and where legend and colour bar have room: beside the net or below
        it, whichever leaves the larger net."""
        head = self.row + 0.6 * self.font  # N and its tick
        tick = 0.9 * self.font
        foot = len(self.foot)
        bar = 4.5 * self.font if self.net.contour is not None else 0.0

        gap = tick + 1.5 * self.font
        column = self._column_width()
        beside = min(
            self.height - head - tick - self.pad,
            self.width - 2 * self.pad - tick - gap - column,
        )

        rows = self._flow(self.width - 2 * self.pad)
        low = (len(rows) + foot) * self.row + self.pad
        while len(rows) > 1 and self.height - head - tick - low < 0.55 * self.height:
            rows.pop()
            low = (len(rows) + foot) * self.row + self.pad
        below = min(
            self.height - head - tick - low - self.heading,
            self.width - 2 * (self.pad + tick) - bar,
        )

        self.beside = beside >= below
        self.radius = max(beside, below, 20.0) / 2.0
        if self.beside:
            room = self.height - 2 * self.pad - self._foot() - self.heading
            most = int(room / (1.15 * self.row))
            self.rows = [[(0.0, e)] for e in self.entries[: max(most, 1)]]
            self.cx = self.pad + tick + self.radius
            self.cy = self.height - head - self.radius - self.pad / 2
            self.legend_x = self.cx + self.radius + gap
            self.legend_width = self.width - self.legend_x - self.pad
        else:
            self.rows = rows
            self.cx = (self.width - bar) / 2.0
            self.cy = self.height - self.heading - head - self.radius
            self.legend_x = self.pad
            self.legend_width = self.width - 2 * self.pad

    def _column_width(self) -> float:
        """Width of a legend beside the net; long names are shortened rather than the net."""
        texts = [*self.foot]
        if self.net.title:
            texts.append(self.net.title[:40] + 4 * " ")
        if self.net.contour is not None:
            texts += [DENSITY_NAMES[self.net.contour], nets.DENSITY_UNITS[self.net.contour]]
        entries = [2.2 * self.font + _text_width(e.text, self.font) for e in self.entries]
        widest = min(max(entries, default=0.0), 24.0 * self.font)
        return 1.05 * max(widest, *(_text_width(t, self.font) for t in texts))

    def _foot(self) -> float:
        """Height of what stands under a legend beside the net: the caption and the colour bar."""
        under = (len(self.foot) + 1.0) * self.row
        return under + (12.0 * self.font + 3.0 * self.row if self.net.contour else 0.0)

    def _flow(self, width: float) -> list[list[tuple[float, _Entry]]]:
        """Entries set side by side in rows: (offset, entry)."""
        rows: list[list[tuple[float, _Entry]]] = []
        x = 0.0
        for e in self.entries:
            need = 2.2 * self.font + _text_width(e.text, self.font)
            if rows and x + need <= width:
                rows[-1].append((x, e))
            else:
                rows.append([(0.0, e)])
                x = 0.0
            x += need + 1.6 * self.font
        return rows

    def net_of(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.cx) / self.radius, (y - self.cy) / self.radius

    def text(
        self,
        x: float,
        y: float,
        text: str,
        *,
        align: str = "left",
        color: str | None = None,
        weight: str = "normal",
        halo: bool = False,
        size: float = 1.0,
    ) -> None:
        """Text at a place in points, y its middle; its box is remembered."""
        from matplotlib import patheffects

        width = _text_width(text, self.font * size)
        left = {"left": x, "center": x - width / 2, "right": x - width}[align]
        half = 0.5 * self.font * size
        self.text_boxes.append((left, y - half, left + width, y + half))
        artist = self.axes.text(
            *self.net_of(x, y), text, ha=align, va="center_baseline", fontsize=self.font * size,
            color=color or self.style.ink, weight=weight, zorder=9, parse_math=False,
        )  # fmt: skip
        if halo:
            ring = patheffects.withStroke(linewidth=0.3 * self.font, foreground=self.style.net)
            artist.set_path_effects([ring])

    # Drawing

    def draw_frame(self) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.patches import Circle

        style, ax = self.style, self.axes
        ax.add_patch(Circle((0, 0), 1.0, facecolor=style.net, edgecolor="none", zorder=0))
        self.rim = Circle((0, 0), 1.0, facecolor="none", edgecolor=style.ink,
                          linewidth=1.25 * style.line_pt, zorder=5)  # fmt: skip
        ax.add_patch(self.rim)
        azimuth = np.radians(np.arange(0, 360, 10))
        unit = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
        long = np.arange(36) % 9 == 0
        length = np.where(long, 0.6, 0.3)[:, None] * self.font / self.radius
        cross = 0.35 * self.font / self.radius
        ticks = [*np.stack([unit, unit * (1 + length)], axis=1)]
        ticks += [np.array([[-cross, 0], [cross, 0]]), np.array([[0, -cross], [0, cross]])]
        ax.add_collection(
            LineCollection(ticks, colors=style.ink, linewidths=style.line_pt, zorder=5)
        )
        self.text(
            self.cx, self.cy + self.radius + 0.6 * self.font + 0.62 * self.row, "N",
            align="center", weight="bold", size=1.15,
        )  # fmt: skip

    def draw_contours(self, method: str) -> None:
        from matplotlib import colormaps

        vectors = [s.vectors() for s in self.net.sets if len(s)]
        if not vectors:
            return
        x, y, values = nets.density_grid(np.vstack(vectors), method, self.net.projection)
        self.levels = _levels(float(values.max()), method)
        if not self.levels:
            return
        shades = np.linspace(0.12, 0.62, len(self.levels))
        if self.style.contour_map == "dark":
            shades = np.linspace(0.1, 0.75, len(self.levels))
            self.colors = [colormaps["cividis"](float(s)) for s in shades]
        else:
            self.colors = [colormaps["Greys"](float(s)) for s in shades]
        filled = self.axes.contourf(
            x, y, values, levels=self.levels, colors=self.colors, extend="max",
            zorder=1, antialiased=True,
        )  # fmt: skip
        filled.set_clip_path(self.rim)
        lines = self.axes.contour(
            x, y, values, levels=self.levels, colors=self.style.soft,
            linewidths=0.6 * self.style.line_pt, zorder=4.2,
        )  # fmt: skip
        lines.set_clip_path(self.rim)
        self._draw_bar(method)

    def _draw_bar(self, method: str) -> None:
        from matplotlib.patches import Rectangle

        n = len(self.levels)
        thick = 1.0 * self.font
        if self.beside:
            tall = min(1.5 * self.font * n, 0.4 * self.height)
            left, low = self.legend_x, self.pad + (len(self.foot) + 0.8) * self.row
            self.text(left, low + tall + 0.8 * self.row, nets.DENSITY_UNITS[method])
            self.text(left, low + tall + 1.8 * self.row, DENSITY_NAMES[method])
        else:
            tall = min(1.5 * self.font * n, 1.2 * self.radius)
            left, low = self.width - self.pad - 3.2 * self.font, self.cy - tall / 2
            short = "σ" if method != "schmidt" else "% / 1 %"
            self.text(self.width - self.pad, low + tall + 0.8 * self.row, short, align="right")
        for i, (level, color) in enumerate(zip(self.levels, self.colors, strict=True)):
            y = low + tall * i / n
            self.axes.add_patch(
                Rectangle(
                    self.net_of(left, y), thick / self.radius, tall / n / self.radius,
                    facecolor=color, edgecolor=self.style.soft,
                    linewidth=0.5 * self.style.line_pt, zorder=5,
                )
            )  # fmt: skip
            self.text(left + thick + 0.4 * self.font, y, f"{level:g}", color=self.style.ink)

    def draw_circles(self) -> tuple[list[Array], list[npt.NDArray[np.intp]]]:
        from matplotlib.collections import LineCollection

        net, style = self.net, self.style
        many = sum(len(s) for s in net.sets if s.kind == "plane")
        all_of_them = circles_shown(net)
        steps = 61 if many <= 100 else 31
        arcs: list[Array] = []
        rows: list[npt.NDArray[np.intp]] = []
        for s in net.sets:
            keep = np.arange(len(s) if s.kind == "plane" and all_of_them else 0)
            lines = nets.great_circles(
                s.azimuth_deg[keep], s.angle_deg[keep], net.projection, steps
            )
            arcs.append(lines)
            rows.append(keep)
            if len(keep) <= AUTO_CIRCLES:
                self.outlines += list(lines[:, ::4])
            if len(keep):
                self.axes.add_collection(
                    LineCollection(
                        list(lines), colors=style.outline(style.color(s.color)),
                        linewidths=style.line_pt,
                        alpha=min(1.0, max(0.15, 12.0 / math.sqrt(many) / 3.0)), zorder=2,
                    )
                )  # fmt: skip
        return arcs, rows

    def draw_poles(self, positions: list[Array]) -> list[Line2D]:
        net, style = self.net, self.style
        total = sum(len(s) for s in net.sets)
        size = style.marker_pt * _crowding(total)
        dots = net.contour is not None and total > 500  # so that the contours stay visible
        if dots:
            size *= 0.5
        drawn = []
        for s, at in zip(net.sets, positions, strict=True):
            shown = at if net.poles else at[:0]
            # Directed lines that point up are shown by their lower end, hollow.
            up = (s.angle_deg < 0) if s.kind == "line" else np.zeros(len(s), dtype=bool)
            up = up[: len(shown)]
            color = style.color(s.color)
            face, rim, edge = style.symbol(s)
            if rim == style.net and (dots or len(at) > 2000):
                edge = 0.0
            own = size * _SIZES.get(s.marker, 1.0)
            (line,) = self.axes.plot(
                shown[~up, 0], shown[~up, 1], linestyle="none", marker=s.marker, markersize=own,
                markerfacecolor=face, markeredgecolor=rim, markeredgewidth=edge, zorder=4,
                alpha=0.4 if dots else 1.0,
            )  # fmt: skip
            drawn.append(line)
            if up.any():
                self.axes.plot(
                    shown[up, 0], shown[up, 1], linestyle="none", marker=s.marker,
                    markersize=own, markerfacecolor=style.net, markeredgecolor=color,
                    markeredgewidth=1.2 * style.line_pt, zorder=4,
                )  # fmt: skip
        return drawn

    def draw_fold(self, fold: FoldAxis) -> None:
        net, style = self.net, self.style
        circle = nets.great_circle(fold.pi_plane, net.projection)
        self.outlines.append(circle)
        self.axes.plot(
            *circle.T, color=style.ink, linewidth=1.3 * style.line_pt, dashes=(5, 3), zorder=4.5
        )
        if fold.max_confidence95_deg and fold.min_confidence95_deg and fold.confidence_axis:
            for part in nets.confidence_ellipse(
                fold.beta.vector(), fold.confidence_axis.vector(),
                fold.max_confidence95_deg, fold.min_confidence95_deg, net.projection,
            ):  # fmt: skip
                self.axes.plot(*part.T, color=style.ink, linewidth=style.line_pt, zorder=4.5)
                self.outlines.append(part)
        x, y = nets.project(fold.beta.vector(), net.projection)[0]
        self.axes.plot(
            [x], [y], marker="*", markersize=2.4 * style.marker_pt, markerfacecolor=style.ink,
            markeredgecolor=style.net, markeredgewidth=style.line_pt, linestyle="none", zorder=6,
        )  # fmt: skip

    def draw_means_and_labels(self) -> None:
        net, style = self.net, self.style
        wanted: list[tuple[Array, str, str]] = []
        for mean in net.means:
            at = nets.project(mean.line.vector(), net.projection)[0]
            color = style.outline(style.color(mean.color))
            self.axes.plot(
                *at[:, None], marker=mean.marker, markersize=2.0 * style.marker_pt,
                markerfacecolor=style.net, markeredgecolor=color,
                markeredgewidth=2.4 * style.line_pt, linestyle="none", zorder=6,
            )  # fmt: skip
            wanted.append((at, mean.label, style.ink))
        if net.fold is not None:
            at = nets.project(net.fold.beta.vector(), net.projection)[0]
            text = f"β {format_line(net.fold.beta, net.decimals)}"
            wanted.append((at, text, style.ink))
        crowd = np.vstack(
            [np.zeros((0, 2)), *self.outlines]
            + [part for e in net.ellipses for part in e.outline(net.projection)]
            + [nets.project(s.vectors(), net.projection) for s in net.sets if net.poles and len(s)]
        )
        crowd = np.array([self.cx, self.cy]) + self.radius * crowd
        marks = [np.array([self.cx, self.cy]) + self.radius * at for at, _, _ in wanted]
        for mark, (_, text, color) in zip(marks, wanted, strict=True):
            place = self._free_place(mark, text, crowd, marks)
            if place is not None:
                self.text(*place, text, color=color, halo=True)

    def _free_place(
        self, mark: Array, text: str, crowd: Array, marks: list[Array]
    ) -> tuple[float, float] | None:
        """Left end and middle height of a label near a mark: the place that meets no other text
        or mark, stays in the figure, and hides the fewest poles; None where there is no room."""
        width, half = _text_width(text, self.font), 0.62 * self.font
        best, cost = None, math.inf
        for reach in (1.0, 1.7, 2.6, 4.0):
            away = reach * 1.1 * self.font
            for i in range(12):
                angle = math.radians(30.0 * i)
                dx, dy = math.cos(angle), math.sin(angle)
                x = float(mark[0]) + away * dx - width * (0.5 - 0.5 * dx)
                y = float(mark[1]) + away * dy
                box = (x - 2, y - half, x + width + 2, y + half)
                if box[0] < 2 or box[2] > self.width - 2:
                    continue
                if box[1] < 2 or box[3] > self.height - 2:
                    continue
                if any(_meet(box, other) for other in self.text_boxes):
                    continue
                gaps = [_gap(box, m) for m in marks]
                if min(gaps) < _gap(box, mark):  # it would be read as another mark's
                    continue
                hits = sum(_holds(box, m, 0.6 * self.font) for m in marks)
                inside = ((crowd > [box[0], box[1]]) & (crowd < [box[2], box[3]])).all(axis=1).sum()
                corner = max(
                    math.hypot(cx - self.cx, cy - self.cy) for cx in box[::2] for cy in box[1::2]
                )
                rim = 3.0 if corner > self.radius else 0.0  # would lie across the rim
                now = 30.0 * hits + float(inside) + rim + 1.5 * reach
                if now < cost:
                    best, cost = (x, y), now
        return best

    def draw_legend(self) -> None:
        if self.net.title:
            room = self.legend_width if self.beside else self.width - 2 * self.pad
            title = _shortened(self.net.title, 1.15 * self.font, room)
            top = self.height - self.pad - 0.5 * self.row
            self.text(self.legend_x, top, title, weight="bold", size=1.15)
        if self.beside:
            y = self.height - self.pad - 0.5 * self.row - self.heading
        else:
            y = self.pad + (len(self.rows) + len(self.foot) - 0.5) * self.row
        hidden = len(self.entries) - sum(len(r) for r in self.rows)
        step = self.row * (1.15 if self.beside else 1.0)
        for i, row in enumerate(self.rows):
            for offset, entry in row:
                room = self.legend_width - offset - 2.2 * self.font
                text = entry.text
                if hidden and i == len(self.rows) - 1 and (offset, entry) == row[-1]:
                    text = f"and {hidden + 1} more"
                    self._legend_entry(offset, y, replace(entry, text=text, marker=None, line=None))
                    continue
                text = _shortened(text, self.font, room)
                self._legend_entry(offset, y, replace(entry, text=text))
            y -= step
        for i, line in enumerate(reversed(self.foot)):
            y = self.pad + (i + 0.5) * self.row
            text = _shortened(line, self.font, self.legend_width)
            self.text(self.legend_x, y, text, color=self.style.soft)

    def _legend_entry(self, offset: float, y: float, entry: _Entry) -> None:
        style = self.style
        x = self.legend_x + offset
        left, right = self.net_of(x, y), self.net_of(x + 1.6 * self.font, y)
        if entry.line is not None:
            self.axes.plot(
                [left[0], right[0]], [left[1], right[1]], color=entry.color, zorder=8,
                linewidth=1.3 * style.line_pt, linestyle="-" if entry.line == "-" else (0, (3, 2)),
            )  # fmt: skip
        if entry.marker is not None:
            big = 1.6 if entry.marker == "*" or entry.outlined else 1.1
            face, edge = entry.color, style.ink if entry.outlined else style.paper
            width = (1.4 if entry.outlined else 0.5) * style.line_pt
            if entry.like is not None:
                face, edge, width = style.symbol(entry.like)
                big = 1.1 * _SIZES.get(entry.marker, 1.0)
            self.axes.plot(
                [(left[0] + right[0]) / 2], [left[1]], marker=entry.marker, zorder=8,
                markersize=big * style.marker_pt, linestyle="none", markerfacecolor=face,
                markeredgecolor=edge, markeredgewidth=width,
            )  # fmt: skip
        self.text(x + 2.2 * self.font, y, entry.text)


def circles_shown(net: NetContents) -> bool:
    """Whether all great circles are drawn."""
    if net.circles is not None:
        return net.circles
    return sum(len(s) for s in net.sets if s.kind == "plane") <= AUTO_CIRCLES


def _legend_entries(net: NetContents, style: NetStyle) -> list[_Entry]:
    entries = []
    names = [s.name for s in net.sets]
    for s in net.sets:
        circles = s.kind == "plane" and circles_shown(net)
        terse = s.name
        if s.kind == "line" and names.count(s.name) > 1:
            terse += ", lines"
        what = "lines" if s.kind == "line" else "poles" if net.poles else "planes"
        entries.append(
            _Entry(
                f"{terse} ({len(s):,})" if net.compact else f"{s.name}, {what} (n = {len(s):,})",
                style.color(s.color),
                s.marker if net.poles else None,
                "-" if circles else None,
                like=s,
            )
        )
    if net.fold is not None:
        fold = net.fold
        text = "β"
        if fold.max_confidence95_deg is not None and fold.min_confidence95_deg is not None:
            major, minor = fold.max_confidence95_deg, fold.min_confidence95_deg
            errors = f"±{major:.1f}° / ±{minor:.1f}°"
            text = f"β {errors}" if net.compact else f"β, joint 95 %: {errors}"
        entries.append(_Entry(text, style.ink, "*"))
        plane = format_plane(fold.pi_plane, net.notation, net.decimals)
        name = "π" if net.compact else "π-plane"
        entries.append(_Entry(f"{name} {plane}", style.ink, None, "--"))
    if net.means:
        entries.append(_Entry("open: mean", style.net, "o", None, outlined=True))
    if net.ellipses and not net.compact:
        what = "pole" if isinstance(net.ellipses[0], NetEllipse) else "line"
        entries.append(_Entry(f"joint 95 % of the selected {what}", style.ink, None, "-"))
    return entries


def _draw_emphasis(
    ax: Axes, net: NetContents, style: NetStyle, positions: list[Array]
) -> list[Artist]:
    """Selected features: the same colour, larger, ringed, their great circles cased, as long as
    these are few enough to be told apart."""
    from matplotlib.collections import LineCollection

    made: list[Artist] = []
    chosen = [
        np.array([i for i, name in enumerate(s.ids) if name in net.selected], dtype=np.intp)
        if net.selected
        else np.zeros(0, dtype=np.intp)
        for s in net.sets
    ]
    planes = sum(len(rows) for s, rows in zip(net.sets, chosen, strict=True) if s.kind == "plane")
    circles = planes <= AUTO_CIRCLES or not net.poles
    # Rings around thousands would be one black blot.
    many = float(np.interp(math.log10(1 + sum(map(len, chosen))), [1.5, 3.0], [0.0, 1.0]))
    size = style.marker_pt * _crowding(sum(len(s) for s in net.sets))
    size = max(size * (1.7 - 0.5 * many), (1.5 - 0.8 * many) * style.marker_pt)
    ring = (1.6 - 1.2 * many) * style.line_pt
    for s, at, rows in zip(net.sets, positions, chosen, strict=True):
        if not len(rows):
            continue
        color = style.color(s.color)
        if s.kind == "plane" and circles:
            steps = 181 if planes <= AUTO_CIRCLES else 31
            arcs = nets.great_circles(s.azimuth_deg[rows], s.angle_deg[rows], net.projection, steps)
            for ink, width, order in ((style.ink, 3.4, 5.5), (color, 2.0, 5.6)):
                lines = LineCollection(
                    list(arcs), colors=ink, linewidths=width * style.line_pt, zorder=order
                )
                made.append(ax.add_collection(lines, autolim=False))
        if net.poles:
            made += ax.plot(
                at[rows, 0], at[rows, 1], linestyle="none", marker=s.marker,
                markersize=size * _SIZES.get(s.marker, 1.0),
                markerfacecolor=style.symbol(s)[0], markeredgecolor=style.ink,
                markeredgewidth=ring, zorder=6.5,
            )  # fmt: skip
    for e in net.ellipses:
        for part in e.outline(net.projection):
            made += ax.plot(*part.T, color=style.ink, linewidth=1.2 * style.line_pt, zorder=6.4)
    return made


def _crowding(n: int) -> float:
    """How much smaller symbols get as they become many."""
    return float(np.interp(math.log10(max(n, 1)), [2.0, 3.0, 4.0], [1.0, 0.7, 0.4]))


def _levels(top: float, method: str) -> list[float]:
    """At most 8 round levels: every 2 (or more) standard deviations, or round shares."""
    steps = (2, 4, 5, 10, 20, 50, 100, 200, 500) if method != "schmidt" else (1, 2, 5, 10, 20, 50)
    for step in steps:
        if top / step <= 8:
            count = math.ceil(top / step) - 1
            return [float(step * (i + 1)) for i in range(max(count, 0))]
    return [float(steps[-1])]


def _distance_to_arcs(point: Array, arcs: Array) -> Array:
    """Distance (m,) of a point (2,) from polylines (m, k, 2)."""
    a, b = arcs[:, :-1], arcs[:, 1:]
    along = b - a
    square = np.maximum(np.sum(along**2, axis=-1), 1e-300)
    t = np.clip(np.sum((point - a) * along, axis=-1) / square, 0.0, 1.0)
    nearest = a + t[..., None] * along
    return np.min(np.hypot(*np.moveaxis(nearest - point, -1, 0)), axis=1)


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _gap(box: Box, mark: Array) -> float:
    """Distance of a mark from a box."""
    dx = max(box[0] - float(mark[0]), 0.0, float(mark[0]) - box[2])
    dy = max(box[1] - float(mark[1]), 0.0, float(mark[1]) - box[3])
    return math.hypot(dx, dy)


def _holds(box: Box, mark: Array, margin: float) -> bool:
    x, y = float(mark[0]), float(mark[1])
    return box[0] - margin < x < box[2] + margin and box[1] - margin < y < box[3] + margin
