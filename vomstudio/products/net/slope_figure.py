"""Figure of a kinematic slope analysis: a net with the critical zone per failure mode.

The nets are equal-area, lower hemisphere. They show the poles of planes for planar sliding and
flexural toppling, and the intersections for wedges and direct toppling.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.words import tr
from vomstudio.geology import slopes
from vomstudio.geology import stereonet as nets
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.slopes import Margins, SlopeFace, Zones
from vomstudio.geology.table_slopes import FailureMode, TableSlope, set_numbers
from vomstudio.products.net.figure_file import write_figure
from vomstudio.products.net.net_axes import add_net, plane_transform, plot_curves, plot_vectors
from vomstudio.products.net.style import PRINT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE_MM = (170.0, 206.0)
MAX_INTERSECTIONS = 3000
"""Maximum number of intersections drawn; larger sets are thinned evenly."""

_ZONE_COLOR, _CRITICAL_COLOR, _NONCRITICAL_COLOR, _FACE_COLOR = (
    "#f3c6a8",
    "#c1440e",
    "#8a8f98",
    "#1a1a1a",
)
_GRID_SIZE = 361


@dataclass(frozen=True, eq=False)
class _Panel:
    """Panel of a failure mode: title, kind of features, vectors (n, 3), and critical zone.

    The vectors point downwards, in the frame of the face.
    """

    title: str
    of: str
    mode: FailureMode
    vectors: FloatArray
    zones: Zones
    margins: Callable[[FloatArray], Margins]
    limits: tuple[FloatArray, ...]
    """Construction lines as curves (k, 3) in the frame of the face."""


def write_slope_figure(
    target: str | Path | IO[bytes],
    table: OrientationRows,
    face: SlopeFace,
    slope: TableSlope,
    *,
    format: str,
    size_mm: tuple[float, float] = SIZE_MM,
    dpi: float = 300.0,
) -> None:
    """Write the figure as SVG, PDF or PNG.

    Raises
    ------
    UsageError
        If the format is not supported.
    """
    write_figure(
        target,
        lambda figure: draw_slope(figure, table, face, slope),
        format=format,
        size_mm=size_mm,
        paper=PRINT.paper,
        dpi=dpi,
    )


def draw_slope(
    figure: Figure, table: OrientationRows, face: SlopeFace, slope: TableSlope
) -> list[Any]:
    """Draw the four nets over the whole figure, after clearing it, and return their axes."""
    figure.clear()
    figure.set_facecolor(PRINT.paper)
    panels = _create_panels(table, face, slope)
    axes_list = []
    for index, panel in enumerate(panels):
        x_left, low = 0.02 + 0.49 * (index % 2), 0.51 - 0.444 * (index // 2)
        ax = add_net(
            figure, (x_left, low, 0.47, 0.435), PRINT, x_radii=(-1.15, 1.15), y_radii=(-1.42, 1.16)
        )
        _draw(ax, face, panel)
        axes_list.append(ax)
    plane = face.plane
    figure.text(
        0.03,
        0.988,
        tr(
            "Face {azimuth}/{dip:02.0f} (dip direction/dip), friction {friction:g}°, "
            "lateral limits ±{lateral:g}°, n = {n} planes",
            azimuth=format_azimuth(plane.dip_direction_deg),
            dip=plane.dip_deg,
            friction=face.options.friction_deg,
            lateral=face.options.lateral_deg,
            n=slope.n,
        ),
        fontsize=PRINT.font_pt + 1,
        color=PRINT.ink,
        va="top",
    )
    _draw_legend(figure, panels)
    return axes_list


def _create_panels(table: OrientationRows, face: SlopeFace, slope: TableSlope) -> list[_Panel]:
    rows = table.is_plane
    normals = slopes.to_face_frame(
        face, planes_to_normals(table.dip_direction_deg[rows], table.dip_deg[rows])
    )
    lines = _sample_intersections(normals, set_numbers(table))
    dip, friction = face.plane.dip_deg, face.options.friction_deg
    lateral_lines = _lateral_lines(face)
    poles_title = tr("poles of planes")
    intersections_title = tr("intersections of planes")
    straight_lateral_lines = _lateral_lines(
        SlopeFace(face.plane, replace(face.options, limits="straight"))
    )
    return [
        _Panel(
            tr("Planar sliding"),
            poles_title,
            slope.planar,
            0.0 - normals,
            slopes.planar_sliding(face, normals),
            lambda v: slopes.planar_margins(face, 0.0 - v),
            (_daylight_envelope(dip), _cone(friction), *lateral_lines),
        ),
        _Panel(
            tr("Wedge sliding"),
            intersections_title,
            slope.wedge,
            lines,
            slopes.wedge_sliding(face, lines),
            lambda v: slopes.wedge_margins(face, v),
            (_cone(90.0 - friction),),
        ),
        _Panel(
            tr("Flexural toppling"),
            poles_title,
            slope.flexural_toppling,
            0.0 - normals,
            slopes.flexural_toppling(face, normals),
            lambda v: slopes.flexural_margins(face, 0.0 - v),
            (_great_circle(dip - friction), *lateral_lines) if dip > friction else lateral_lines,
        ),
        _Panel(
            tr("Direct toppling"),
            intersections_title,
            slope.direct_toppling,
            lines,
            slopes.direct_toppling(face, lines),
            lambda v: slopes.direct_margins(face, v),
            (_cone(dip), *straight_lateral_lines),
        ),
    ]


def _sample_intersections(normals: FloatArray, sets: IntArray | None) -> FloatArray:
    """Return the intersections (m, 3) of an even sample of pairs, as downward unit vectors.

    Pairs within one set are excluded.
    """
    n = len(normals)
    pairs = n * (n - 1) // 2
    pair_ids = np.unique(
        np.linspace(0, max(pairs - 1, 0), min(pairs, MAX_INTERSECTIONS)).astype(np.int64)
    )
    if not pairs:
        return np.zeros((0, 3))
    # Determine the row in the triangle of pairs from the number of preceding pairs.
    starts = np.concatenate([[0], np.cumsum(np.arange(n - 1, 0, -1))])
    first_planes = np.searchsorted(starts, pair_ids, side="right") - 1
    second_planes = pair_ids - starts[first_planes] + first_planes + 1
    if sets is not None:
        is_different = (sets[first_planes] != sets[second_planes]) | (sets[first_planes] < 0)
        first_planes, second_planes = first_planes[is_different], second_planes[is_different]
    cross_products = np.cross(normals[first_planes], normals[second_planes])
    length = np.linalg.norm(cross_products, axis=1)
    lines = cross_products[length > 1e-9] / length[length > 1e-9, None]
    return np.asarray(np.where(lines[:, 2:] > 0.0, -lines, lines))


def _draw(ax: Any, face: SlopeFace, panel: _Panel) -> None:
    _shade_zone(ax, face, panel)
    face_axes = face.axes()
    limits = [part for curve in panel.limits for part in nets.split_at_primitive(curve @ face_axes)]
    plot_curves(ax, limits, colors=PRINT.soft, linewidths=0.7, linestyles=(0, (4, 2)), zorder=3)
    plot_vectors(
        ax, nets.great_circle(face.plane), flip=False, color=_FACE_COLOR, linewidth=1.3, zorder=4
    )
    vectors, is_critical = panel.vectors @ face_axes, panel.zones.critical
    size = float(np.interp(len(vectors), [50, 1000], [3.6, 1.4]))
    dot_style: dict[str, Any] = {
        "marker": "o",
        "linestyle": "none",
        "markeredgewidth": 0.0,
        "zorder": 5,
    }
    plot_vectors(ax, vectors[~is_critical], markersize=size, color=_NONCRITICAL_COLOR, **dot_style)
    plot_vectors(
        ax, vectors[is_critical], markersize=1.25 * size, color=_CRITICAL_COLOR, **dot_style
    )
    label_style: dict[str, Any] = {
        "transform": plane_transform(ax),
        "va": "top",
        "color": PRINT.ink,
    }
    ax.text(-1.13, 1.15, panel.title, fontsize=PRINT.font_pt + 1, fontweight="bold", **label_style)
    ax.text(-1.13, -1.12, _count_text(panel), fontsize=PRINT.font_pt, **label_style)


def _count_text(panel: _Panel) -> str:
    mode = panel.mode
    if mode.share is None:
        return tr("no intersections")
    text = tr(
        "{critical:,} of {of:,} {what}: {share:.1f} %",
        critical=mode.critical,
        of=mode.of,
        what=panel.of,
        share=100.0 * mode.share,
    )
    if mode.probability is None:
        return text
    expected_text = tr("expected, including errors: {share:.1f} %", share=100.0 * mode.probability)
    return f"{text}\n{expected_text}"


def _shade_zone(ax: Any, face: SlopeFace, panel: _Panel) -> None:
    """Shade the critical zone, where the margin is positive, on a fine grid of the net."""
    steps, positions = nets.hemisphere_grid(_GRID_SIZE)
    margins = panel.margins(positions.reshape(-1, 3) @ face.axes().T)
    margin = np.minimum(margins.zone, margins.lateral).reshape(_GRID_SIZE, _GRID_SIZE)
    if (margin > 0.0).any():
        ax.contourf(steps, steps, margin, levels=[0.0, 9.0], colors=[_ZONE_COLOR], zorder=1)


def _draw_legend(figure: Figure, panels: list[_Panel]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    dot_style: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgewidth": 0.0}
    entries: list[Any] = [
        Line2D([], [], color=_FACE_COLOR, linewidth=1.3, label=tr("face")),
        Patch(facecolor=_ZONE_COLOR, label=tr("critical zone")),
        Line2D([], [], color=_CRITICAL_COLOR, label=tr("critical"), markersize=4, **dot_style),
        Line2D(
            [], [], color=_NONCRITICAL_COLOR, label=tr("not critical"), markersize=3.4, **dot_style
        ),
        Line2D(
            [],
            [],
            color=PRINT.soft,
            linewidth=0.7,
            linestyle=(0, (4, 2)),
            label=tr("daylight, friction, slip and lateral limits"),
        ),
    ]
    figure.legend(
        handles=entries,
        loc="lower left",
        bbox_to_anchor=(0.02, 0.028),
        ncols=5,
        frameon=False,
        fontsize=PRINT.font_pt,
        handlelength=1.8,
        columnspacing=1.4,
    )
    footer = tr("Equal area, lower hemisphere")
    if any(mode.mode.of > MAX_INTERSECTIONS for mode in panels):
        footer += tr("; {count:,} intersections drawn, all counted", count=MAX_INTERSECTIONS)
    figure.text(0.03, 0.012, footer, fontsize=PRINT.font_pt, color=PRINT.soft)


# Construction lines, in the frame of the face --------------------------------------------------


def _cone(angle_deg: float) -> FloatArray:
    """Return the small circle with the half-angle `angle_deg` about the downward vertical."""
    t = np.linspace(0.0, 2.0 * np.pi, 181)
    sine, cosine = np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))
    return np.stack([sine * np.cos(t), sine * np.sin(t), np.full_like(t, -cosine)], axis=1)


def _great_circle(dip_deg: float) -> FloatArray:
    """Return the great circle of a plane with the face's dip direction and another dip."""
    t = np.linspace(-np.pi / 2, np.pi / 2, 91)
    dip = np.radians(dip_deg)
    return np.stack([np.cos(t) * np.cos(dip), np.sin(t), -np.cos(t) * np.sin(dip)], axis=1)


def _daylight_envelope(dip_deg: float) -> FloatArray:
    """Return the poles of the planes whose dip line lies in the face.

    The plunge p of this line and its azimuth a relative to the face satisfy tan p = tan d cos a,
    where d is the dip of the face. Both angles are sampled evenly, because for a steep face p
    decreases only if a is close to 90 degrees.
    """
    dip = np.radians(min(dip_deg, 90.0 - 1e-9))
    azimuth = np.linspace(0.0, 0.5 * np.pi, 91)[:-1]
    plunge = np.linspace(dip, 0.0, 91)
    plunge = np.concatenate([np.arctan(np.tan(dip) * np.cos(azimuth)), plunge])
    azimuth = np.append(azimuth, np.arccos(np.clip(np.tan(plunge[90:]) / np.tan(dip), -1.0, 1.0)))
    order = np.lexsort((-plunge, azimuth))
    azimuth, plunge = azimuth[order], plunge[order]
    half = np.stack(
        [-np.cos(azimuth) * np.sin(plunge), -np.sin(azimuth) * np.sin(plunge), -np.cos(plunge)],
        axis=1,
    )
    return np.vstack([half[::-1] * [1.0, -1.0, 1.0], half])


def _lateral_lines(face: SlopeFace) -> tuple[FloatArray, ...]:
    """Return both lateral limits: small circles about the strike, or great circles.

    Returns an empty tuple if the limits are 90 degrees or more.
    """
    if face.options.lateral_deg >= 90.0:
        return ()
    t = np.linspace(0.0, np.pi, 91)
    limit = np.radians(face.options.lateral_deg)
    curves = []
    for sign in (1.0, -1.0):
        if face.options.limits == "curved":
            x, y = np.cos(t) * np.cos(limit), np.full_like(t, sign * np.sin(limit))
            z = -np.sin(t) * np.cos(limit)
        else:
            x, y, z = np.cos(t) * np.cos(limit), sign * np.cos(t) * np.sin(limit), -np.sin(t)
        curves.append(np.stack([x, y, z], axis=1))
    return tuple(curves)
