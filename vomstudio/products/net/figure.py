"""Stereonet as a figure, for the dock of the window and for `vomstudio stereonet`.

The net is drawn on the axes of mplstereonet, and everything around it in points of the page.
Picking is simple arithmetic on positions in the unit circle. Matplotlib is imported on first use.
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
from vomstudio.products.net.contents import AnyEllipse, LiveFeature, NetContents
from vomstudio.products.net.contour_drawing import draw_bar, draw_contours
from vomstudio.products.net.drawing import NetDrawing
from vomstudio.products.net.figure_file import FORMATS, font_settings, write_figure
from vomstudio.products.net.figure_options import SIZE_MM
from vomstudio.products.net.page import NetPage
from vomstudio.products.net.selection_highlight import draw_highlight
from vomstudio.products.net.style import PRINT, NetStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

_MAX_HEIGHT_MM, _HEIGHT_STEP_MM = 240.0, 5.0
_MIN_NET_MM, _MIN_WIDTH_SHARE = 75.0, 0.7
"""Minimum diameter of a net if the page may grow: in mm, and as a share of a narrow page."""


def picture_format(path: str | Path, field: str) -> str:
    """Return the format, svg, pdf or png, given by the extension of a path.

    Raises
    ------
    UsageError
        If the extension is not supported; `field` is the name of the option.
    """
    return check_extension(path, [f".{name}" for name in FORMATS], field).removeprefix(".")


@dataclass(eq=False)
class NetArtists:
    """Drawn net, with the data needed for picking.

    Pixels are matplotlib's display pixels, counted from the bottom left corner with y up.
    """

    axes: Axes
    contents: NetContents
    style: NetStyle
    radius_px: float
    centre_px: tuple[float, float]
    positions: list[FloatArray]
    """Net positions (n, 2) of the poles or lines of each set."""
    arcs: list[FloatArray]
    """Net positions (m, k, 2) of the great circles of each set; m is 0 if none are drawn."""
    arc_rows: list[IndexArray]
    """For each set, the rows (m,) of the features to which the arcs belong."""
    poles: list[Line2D]
    emphasis: list[Artist]
    text_boxes: list[tuple[float, float, float, float]]
    """Bounding boxes (x0, y0, x1, y1) of all text in pixels, to test for overlap."""

    def to_net(self, x_px: float, y_px: float) -> tuple[float, float]:
        """Return the net position of a pixel, in the unit circle."""
        cx, cy = self.centre_px
        return (x_px - cx) / self.radius_px, (y_px - cy) / self.radius_px

    def line_at(self, x_px: float, y_px: float) -> Line | None:
        """Return the line under a pixel, or None outside the net."""
        return nets.line_at(*self.to_net(x_px, y_px), self.contents.projection)

    def feature_at(self, x_px: float, y_px: float, max_distance_px: float = 6.0) -> str | None:
        """Return the id of the nearest pole or line, or else of the nearest great circle.

        A pole or line must be within `max_distance_px`, a great circle within half of it or within
        2 pixels. Returns None if there is none. If several poles or lines are equally near, the one
        drawn last is returned.
        """
        point = np.array(self.to_net(x_px, y_px))
        best_distance, id_ = max_distance_px / self.radius_px, None
        if self.contents.poles:
            for set_, position in zip(self.contents.sets, self.positions, strict=True):
                if set_.ids and len(position):
                    distances = np.hypot(*(position - point).T)
                    row = len(distances) - 1 - int(np.argmin(distances[::-1]))
                    if distances[row] <= best_distance:
                        best_distance, id_ = float(distances[row]), set_.ids[row]
        if id_ is not None:
            return id_
        best_distance = max(2.0, max_distance_px / 2.0) / self.radius_px
        for set_, arcs, rows in zip(self.contents.sets, self.arcs, self.arc_rows, strict=True):
            if set_.ids and len(arcs):
                distances = _distance_to_arcs(point, arcs)
                i = int(np.argmin(distances))
                if distances[i] <= best_distance:
                    best_distance, id_ = float(distances[i]), set_.ids[int(rows[i])]
        return id_

    def features_in_polygon(self, polygon_px: Sequence[tuple[float, float]]) -> frozenset[str]:
        """Return the ids of the poles and lines inside a pixel polygon (a lasso)."""
        from matplotlib.path import Path as Outline

        outline = Outline([self.to_net(x, y) for x, y in polygon_px])
        return frozenset(
            set_.ids[int(i)]
            for set_, position in zip(self.contents.sets, self.positions, strict=True)
            if set_.ids and len(position)
            for i in np.flatnonzero(outline.contains_points(position))
        )

    def select(self, selected_ids: Iterable[str], ellipses: Sequence[AnyEllipse] = ()) -> None:
        """Change the highlighted features; the caller must redraw the canvas.

        The whole net is drawn again only if the legend entry of the ellipse changes.
        """
        ellipse_types = _legend_ellipse_types(self.contents)
        self.contents = self.contents.replace_selection(selected_ids, ellipses)
        if ellipse_types != _legend_ellipse_types(self.contents) and not self.contents.compact:
            figure = self.axes.get_figure(root=True)
            assert figure is not None
            new_artists = draw_stereonet(figure, self.contents, self.style)
            self.__dict__.update(new_artists.__dict__)
            return
        self._update_highlight()

    def show_live_feature(self, live_feature: LiveFeature | None) -> None:
        """Draw the feature being picked on top; the caller must redraw the canvas."""
        self.contents = replace(self.contents, live=live_feature)
        self._update_highlight()

    def _update_highlight(self) -> None:
        for artist in self.emphasis:
            artist.remove()
        self.emphasis = draw_highlight(self.axes, self.contents, self.style)


def draw_stereonet(figure: Figure, net: NetContents, style: NetStyle = PRINT) -> NetArtists:
    """Draw a net over a whole figure, after clearing the figure.

    The layout depends on the size: the legend is beside the net in a wide figure, and below it
    otherwise. Call this function again after a resize.

    Raises
    ------
    UsageError
        If the contouring method is unknown.
    """
    if net.contour is not None and net.contour not in densities.DENSITY_METHODS:
        raise UsageError(
            Finding(
                "option.not-a-choice", value=net.contour, choices=tuple(densities.DENSITY_METHODS)
            )
        )
    figure.clear()
    figure.set_facecolor(style.paper)
    page = NetPage(figure, net, style)
    page.draw_north()
    if page.contours is not None:
        draw_contours(page.axes, page.contours, style)
    drawing = NetDrawing(page.axes, net, style)
    drawing.draw()
    emphasis = draw_highlight(page.axes, net, style)
    page.draw_legend()
    if page.bar is not None:
        draw_bar(page, page.bar)
    page.draw_labels(drawing.outlines)  # last, so that labels can keep clear of all other text
    return NetArtists(
        page.axes,
        net,
        style,
        page.radius * page.px,
        (page.cx * page.px, page.cy * page.px),
        [nets.project(set_.vectors(), net.projection) for set_ in net.sets],
        [nets.project(arcs, net.projection, flip=False) for arcs in drawing.arcs],
        drawing.arc_rows,
        drawing.poles,
        emphasis,
        [(a * page.px, b * page.px, c * page.px, d * page.px) for a, b, c, d in page.text_boxes],
    )


def _fitting_height_mm(net: NetContents, style: NetStyle, width_mm: float) -> float:
    """Return the default height of a figure, increased if the text or the net requires it."""
    from matplotlib.figure import Figure

    min_diameter_pt = min(_MIN_NET_MM, _MIN_WIDTH_SHARE * width_mm) / 25.4 * 72.0
    height, previous_radius = SIZE_MM[1], 0.0
    while height < _MAX_HEIGHT_MM:
        page = NetPage(Figure(figsize=(width_mm / 25.4, height / 25.4)), net, style)
        # The width may be the limiting dimension.
        if page.is_complete and (
            2.0 * page.radius >= min_diameter_pt or page.radius <= previous_radius
        ):
            break
        previous_radius = page.radius
        height += _HEIGHT_STEP_MM
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
    """Write a net as SVG, PDF or PNG; text remains editable in SVG and PDF.

    If no height is given, the default height is increased until all text fits.

    Raises
    ------
    UsageError
        If the format or the contouring method is not supported.
    """
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
        settings=font_settings(style),
    )


def _legend_ellipse_types(net: NetContents) -> list[type]:
    """Return the types of the selection's ellipses, which determine their legend entry."""
    return [type(ellipse) for ellipse in net.ellipses]


def _distance_to_arcs(point: FloatArray, arcs: FloatArray) -> FloatArray:
    """Return the distances (m,) of a point (2,) from polylines (m, k, 2)."""
    a, b = arcs[:, :-1], arcs[:, 1:]
    segments = b - a
    square = np.maximum(np.sum(segments**2, axis=-1), 1e-300)
    t = np.clip(np.sum((point - a) * segments, axis=-1) / square, 0.0, 1.0)
    nearest_points = a + t[..., None] * segments
    return np.asarray(np.min(np.hypot(*np.moveaxis(nearest_points - point, -1, 0)), axis=1))
