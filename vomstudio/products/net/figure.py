"""The net as a figure: one drawing for the window's dock and for `vomstudio stereonet`.

Everything is drawn in our own projected coordinates on one plain Axes that covers the figure: one
net unit is the radius of the net. That redraws in milliseconds, picks with plain arithmetic, and
leaves every artist an ordinary one (a map projection Axes transforms each vertex again at every
redraw). Matplotlib is imported where it is first needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, IndexArray
from vomstudio.core.errors import UsageError
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.findings import Finding
from vomstudio.geology import density as densities
from vomstudio.geology import stereonet as nets
from vomstudio.geology.orientation import Line
from vomstudio.products.net.annotations import draw_additions
from vomstudio.products.net.contents import AnyEllipse, NetContents, NetLive
from vomstudio.products.net.contour_drawing import draw_contours
from vomstudio.products.net.figure_file import FORMATS, font_of, write_figure
from vomstudio.products.net.figure_options import SIZE_MM
from vomstudio.products.net.page import Page
from vomstudio.products.net.selection_highlight import draw_emphasis
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_HIGHEST_MM, _STEP_MM = 240.0, 5.0
_LEAST_NET_MM, _LEAST_SHARE = 75.0, 0.7
"""A net is no smaller than the one, or on a narrow page than this share of its width, where the
page may grow."""


def picture_format(path: str | Path, field: str) -> str:
    """svg, pdf or png by the ending of a path. field : the option. Raises UsageError."""
    return check_extension(path, [f".{name}" for name in FORMATS], field).removeprefix(".")


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
    positions: list[FloatArray]
    """Per set (n, 2) net positions of poles or lines."""
    arcs: list[FloatArray]
    """Per set (m, k, 2) great circles as drawn (m = 0: none)."""
    arc_rows: list[IndexArray]
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
        before = _named_in_legend(self.contents)
        self.contents = self.contents.with_selection(selected, ellipses)
        if before != _named_in_legend(self.contents) and not self.contents.compact:
            figure = self.axes.get_figure(root=True)
            assert figure is not None
            anew = draw_stereonet(figure, self.contents, self.style)
            self.__dict__.update(anew.__dict__)
            return
        self._emphasise()

    def show_live(self, live: NetLive | None) -> None:
        """The feature that is being picked, over all; the caller redraws the canvas."""
        self.contents = replace(self.contents, live=live)
        self._emphasise()

    def _emphasise(self) -> None:
        for artist in self.emphasis:
            artist.remove()
        self.emphasis = draw_emphasis(self.axes, self.contents, self.style, self.positions)


def draw_stereonet(figure: Figure, net: NetContents, style: NetStyle = PRINT) -> NetArtists:
    """Draws the net over the whole figure, which is cleared first. Lays itself out by the figure's
    size: legend beside the net where the figure is wide, below it where it is not. Call it again
    after a resize."""
    if net.contour is not None and net.contour not in densities.DENSITY_METHODS:
        raise UsageError(
            Finding(
                "option.not-a-choice", value=net.contour, choices=tuple(densities.DENSITY_METHODS)
            )
        )
    figure.clear()
    figure.set_facecolor(style.paper)
    page = Page(figure, net, style)
    ax = page.axes
    page.draw_frame()
    if page.contours is not None:
        draw_contours(page, page.contours)
    positions = [nets.project(s.vectors(), net.projection) for s in net.sets]
    arcs, rows = page.draw_circles()
    draw_additions(page)
    poles = page.draw_poles(positions)
    if net.fold is not None:
        page.draw_fold(net.fold)
    emphasis = draw_emphasis(ax, net, style, positions)
    page.draw_legend()
    page.draw_means_and_labels()  # last, so that labels can keep clear of all other text
    return NetArtists(
        ax,
        net,
        style,
        page.radius * page.px,
        (page.cx * page.px, page.cy * page.px),
        positions,
        arcs,
        rows,
        poles,
        emphasis,
        [(a * page.px, b * page.px, c * page.px, d * page.px) for a, b, c, d in page.text_boxes],
    )


def _fitting_height_mm(net: NetContents, style: NetStyle, width_mm: float) -> float:
    """The usual height of a figure, or as much more as its words need."""
    from matplotlib.figure import Figure

    least = min(_LEAST_NET_MM, _LEAST_SHARE * width_mm) / 25.4 * 72.0
    height, before = SIZE_MM[1], 0.0
    while height < _HIGHEST_MM:
        page = Page(Figure(figsize=(width_mm / 25.4, height / 25.4)), net, style)
        # The width may be what keeps it small.
        if page.whole and (2.0 * page.radius >= least or page.radius <= before):
            break
        before = page.radius
        height += _STEP_MM
    return height


def write_stereonet(
    target: str | Path | IO[bytes],
    net: NetContents,
    *,
    format: str,
    style: NetStyle = PRINT,
    width_mm: float | None = None,
    height_mm: float | None = None,
    dpi: float = 300.0,
) -> None:
    """Writes the figure as svg, pdf or png (text stays text in svg and pdf). Without a height it
    is as high as its words need."""
    width = width_mm or SIZE_MM[0]

    def size() -> tuple[float, float]:
        return width, height_mm or _fitting_height_mm(net, style, width)

    write_figure(
        target,
        lambda figure: draw_stereonet(figure, net, style),
        format=format,
        size_mm=size,
        paper=style.paper,
        dpi=dpi,
        settings=font_of(style),
    )


def _named_in_legend(net: NetContents) -> list[type]:
    """What of the selection's ellipses the legend names."""
    return [type(e) for e in net.ellipses]


def _distance_to_arcs(point: FloatArray, arcs: FloatArray) -> FloatArray:
    """Distance (m,) of a point (2,) from polylines (m, k, 2)."""
    a, b = arcs[:, :-1], arcs[:, 1:]
    along = b - a
    square = np.maximum(np.sum(along**2, axis=-1), 1e-300)
    t = np.clip(np.sum((point - a) * along, axis=-1) / square, 0.0, 1.0)
    nearest = a + t[..., None] * along
    return np.asarray(np.min(np.hypot(*np.moveaxis(nearest - point, -1, 0)), axis=1))
