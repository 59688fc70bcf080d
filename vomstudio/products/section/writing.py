"""Output of a section as a table, a CAD drawing or a figure, with a description."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import atomic_group, check_target
from vomstudio.core.files.extensions import check_extension
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_formula
from vomstudio.core.findings import Finding
from vomstudio.core.results import FLATTENED_IN_JSON, Result
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geology.notation import (
    format_azimuth,
    format_compass_point,
    format_plain_azimuth,
    format_plane,
)
from vomstudio.geology.orientation import Line
from vomstudio.geometry.units import Axes, table_columns
from vomstudio.products.ortho.interpretation import (
    Item,
    ProjectedItem,
    count_features,
    project_item,
)
from vomstudio.products.ortho.vector_drawing import (
    Drawing,
    DrawingShape,
    create_shape,
    svg_text,
    write_dxf,
)
from vomstudio.products.section.bent_projection import project_along_bends
from vomstudio.products.section.cutting import Cut
from vomstudio.products.section.directions import (
    MIN_ALLOWED_ANGLE_DEG,
    DomainProjection,
    ProjectionDirections,
    angle_to_panel,
    domain_projections,
    smallest_angle,
)
from vomstudio.products.section.section_lines import Curtain

_MIN_WIDTH_RATIO, _MIN_HEIGHT_RATIO = 0.7, 0.15
"""Minimum width relative to the height of a drawing, and minimum height relative to the width."""

SUFFIXES = (".csv", ".dxf", ".svg")
_SURFACE_LAYER, _BENDS_LAYER, _BEND_COLOR = "section", "bends", "#8a8f98"
MAX_BENDS = 20
PERPENDICULAR_DIRECTIONS = ProjectionDirections()
PERPENDICULAR = "perpendicular to the section"
FEATURE_COLUMNS = (
    "layer",
    "id",
    "name",
    "kind",
    "set",
    "point",
    "distance_m",
    "height_m",
    "away_m",
    "dip_direction_deg",
    "dip_deg",
    "apparent_dip_deg",
    "overturned",
)


@dataclass(frozen=True)
class SectionFigures:
    """Figures of a section.

    Parameters
    ----------
    length_m : float
        Total length of the lines.
    polylines, points : int
        Number of lines, and number of their points or of the cloud's points in the slab.
    slab_m : float or None
        Thickness of the slab of points; None for a mesh.
    dip_direction_deg, dip_deg : float or None
        Plane of the section; None if it follows a bent line.
    left_deg, right_deg : float
        Azimuths of the left and the right end.
    features, left_out : int
        Number of projected features, and of features that are too far from the section or beyond
        its ends.
    projection_trend_deg, projection_plunge_deg : float or None
        Direction of projection; None for a perpendicular projection.
    projection_angle_deg : float or None
        Smallest angle between the direction of projection and the section; None if there are no
        features.
    domains : tuple of DomainProjection or None
    """

    length_m: float
    polylines: int
    points: int
    slab_m: float | None
    dip_direction_deg: float | None
    dip_deg: float | None
    left_deg: float
    right_deg: float
    features: int
    left_out: int
    projection_trend_deg: float | None = None
    projection_plunge_deg: float | None = None
    projection_angle_deg: float | None = None
    domains: tuple[DomainProjection, ...] | None = None


@dataclass(frozen=True)
class WrittenSection(Result):
    """Written section: its files, figures and warnings."""

    file: str
    figures: SectionFigures = field(metadata=FLATTENED_IN_JSON)
    features_file: str | None
    warnings: tuple[Finding, ...]


def format_from_path(path: str | Path) -> str:
    """Return the extension of a section file.

    Raises
    ------
    UsageError
        If the extension is not supported.
    """
    return check_extension(path, SUFFIXES)


def section_targets(path: str | Path, has_features: bool) -> list[Path]:
    """Return the files to write; the features of a table are in NAME_features.csv."""
    out = Path(path)
    features_path = out.with_name(f"{out.stem}_features.csv")
    return [out, features_path] if has_features and format_from_path(path) == ".csv" else [out]


def check_targets(path: str | Path, has_features: bool, *, force: bool) -> None:
    """Check that the files of a section can be written.

    Raises
    ------
    UsageError, TargetError
    """
    for target in section_targets(path, has_features):
        check_target(target, force=force)


def project_items(
    items: tuple[Item, ...],
    curtain: Curtain,
    directions: ProjectionDirections,
    max_distance: float | None,
) -> tuple[tuple[ProjectedItem, ...], int]:
    """Project features onto a section.

    On a bent section, a line is projected onto each piece that it faces.

    Parameters
    ----------
    items : tuple of Item
    curtain : Curtain
    directions : ProjectionDirections
    max_distance : float or None
        Maximum mean distance from the section, m; None for no limit.

    Returns
    -------
    projected_items : tuple of ProjectedItem
    left_out : int
        Number of features that are too far away or do not face any panel.
    """
    projected_features: list[ProjectedItem] = []
    for item in items:
        direction = directions.of(item)
        reachable_panels = [
            panel
            for panel in curtain.panels
            if angle_to_panel(panel, direction) >= MIN_ALLOWED_ANGLE_DEG
        ]
        if len(curtain.panels) > 1 and len(item.points) > 1:
            parts = project_along_bends(item, reachable_panels, direction)
            near_features = [
                item
                for item in parts
                if max_distance is None or np.abs(item.distance).mean() <= max_distance
            ]
            projected_features += near_features
            continue
        best_projection: ProjectedItem | None = None
        for panel in reachable_panels:
            projected_feature = project_item(item, panel.origin, panel.right, panel.up, direction)
            if projected_feature is None:
                continue
            x = float(projected_feature.points[:, 0].mean())
            if not panel.low <= x <= panel.high:
                continue
            if (
                best_projection is None
                or np.abs(projected_feature.distance).mean()
                < np.abs(best_projection.distance).mean()
            ):
                shift = np.array([panel.start, panel.level])
                best_projection = replace(
                    projected_feature, points=projected_feature.points + shift
                )
        if best_projection is None or (
            max_distance is not None
            and float(np.abs(best_projection.distance).mean()) > max_distance
        ):
            continue
        projected_features.append(best_projection)
    n_skipped = count_features(items) - _count(projected_features)
    return tuple(projected_features), n_skipped


def _count(items: Iterable[ProjectedItem]) -> int:
    """Count the features; a feature with several parts counts once."""
    return count_features(
        {id(projected_feature.item): projected_feature.item for projected_feature in items}.values()
    )


def section_figures(
    section_cut: Cut,
    curtain: Curtain,
    items: tuple[ProjectedItem, ...],
    n_skipped: int,
    directions: ProjectionDirections = PERPENDICULAR_DIRECTIONS,
) -> SectionFigures:
    """Compute the figures of a section.

    Raises
    ------
    InputError
        If the section does not intersect the model.
    """
    if not section_cut.lines:
        if section_cut.points is not None and section_cut.slab_m is not None:
            raise InputError(
                Finding(
                    "section.thin-slab", count=section_cut.points, half_m=section_cut.slab_m / 2
                )
            )
        raise InputError(Finding("section.misses-model"))
    plane = curtain.plane
    left_azimuth, right_azimuth = curtain.ends
    return SectionFigures(
        section_cut.length_m,
        len(section_cut.lines),
        sum(map(len, section_cut.lines)) if section_cut.points is None else section_cut.points,
        section_cut.slab_m,
        None if plane is None else plane.dip_direction_deg,
        None if plane is None else plane.dip_deg,
        left_azimuth,
        right_azimuth,
        _count(items),
        n_skipped,
        *(_projection_figures(curtain, directions) if items or n_skipped else ()),
    )


def _projection_figures(curtain: Curtain, directions: ProjectionDirections) -> tuple[Any, ...]:
    """Return trend and plunge, the angle to the section, and the projections of domains."""
    domains = domain_projections(directions, curtain) or None
    if directions.along is None:
        return None, None, 90.0, domains
    line = Line.from_vector(directions.along)
    return line.trend_deg, line.plunge_deg, smallest_angle(curtain, directions.along), domains


def write_section(
    path: str | Path,
    section_cut: Cut,
    curtain: Curtain,
    figures: SectionFigures,
    items: tuple[ProjectedItem, ...] = (),
    *,
    crs: str | None = None,
    model: str = "",
    is_metric: bool = True,
    is_north_known: bool = True,
    warnings: tuple[Finding, ...] = (),
    force: bool = False,
) -> WrittenSection:
    """Write a section to a file and, for a table, its features to a second file.

    Either all files are written completely or none.

    Raises
    ------
    UsageError, TargetError
    """
    suffix = format_from_path(path)
    targets = section_targets(path, bool(items))
    with atomic_group(targets, force) as temporary_paths:
        if suffix == ".csv":
            axes = Axes(is_metric, is_north_known)
            header = _header(curtain, crs, model, figures, axes)
            temporary_paths[0].write_text(header + _lines_table(section_cut, axes), "utf-8")
            if items:
                temporary_paths[1].write_text(header + _features_table(items, axes), "utf-8")
        else:
            drawing = section_drawing(
                section_cut,
                curtain,
                items,
                is_metric=is_metric,
                is_north_known=is_north_known,
                model=model,
                figures=figures,
            )
            if suffix == ".svg":
                temporary_paths[0].write_text(svg_text(drawing), "utf-8")
            else:
                write_dxf(temporary_paths[0], drawing)
    features_file = str(targets[1]) if len(targets) > 1 else None
    return WrittenSection(str(path), figures, features_file, warnings)


def section_drawing(
    section_cut: Cut,
    curtain: Curtain,
    items: tuple[ProjectedItem, ...],
    *,
    is_metric: bool = True,
    is_north_known: bool = True,
    model: str = "",
    figures: SectionFigures | None = None,
) -> Drawing:
    """Draw a section; `figures` are needed to describe the projection of features."""
    shapes = [
        DrawingShape(
            _SURFACE_LAYER,
            line,
            values={"polyline": k + 1},
            legend=tr("surface of the model"),
        )
        for k, line in enumerate(section_cut.lines)
    ]
    shapes += [create_shape(projected_feature) for projected_feature in items]
    all_points = np.concatenate([shape.points for shape in shapes])
    low, high = all_points.min(axis=0), all_points.max(axis=0)
    pad = max(0.05 * float((high - low).max()), 1e-3)
    # Very steep or flat sections also need space for labels.
    width, height = (high - low).tolist()
    padding = np.array(
        [max(_MIN_WIDTH_RATIO * height - width, 0.0), max(_MIN_HEIGHT_RATIO * width - height, 0.0)]
    )
    low, high = low - 0.5 * padding, high + 0.5 * padding
    shapes += _bend_marks(curtain, float(low[1]), float(high[1]))
    ends = end_names(curtain, is_north_known)
    unit = "m" if is_metric else tr("units")
    height = (
        tr("Z ({unit})", unit=unit) if curtain.vertical else tr("up the plane ({unit})", unit=unit)
    )
    return Drawing(
        tuple(shapes),
        np.stack([low - pad, high + pad]),
        ends,
        (tr("distance along the section ({unit})", unit=unit), height),
        (
            describe_section(curtain, section_cut, unit),
            *([] if figures is None else describe_projection(figures)),
            *([Path(model).name] if model else []),
        ),
        is_metric=is_metric,
    )


def _bend_marks(curtain: Curtain, low: float, high: float) -> list[DrawingShape]:
    """Mark the bends of a section, or only the sharpest if there are many."""
    return [
        DrawingShape(
            _BENDS_LAYER,
            np.array([[position, low], [position, high]]),
            _BEND_COLOR,
            label=tr("bend, continuing toward {azimuth}°", azimuth=f"{round(azimuth) % 360:03d}"),
            values={"azimuth_deg": azimuth},
            is_annotation=True,
        )
        for position, azimuth in curtain.bends(MAX_BENDS)
    ]


def describe_projection(figures: SectionFigures) -> list[str]:
    """Describe the projection of features; empty if there are no features."""
    if not figures.features:
        return []
    domain_lines = [item.words for item in figures.domains or ()]
    if domain_lines:
        domain_lines = [
            tr("Each domain projected along its own axis (trend/plunge, °):"),
            *domain_lines,
        ]
    if figures.projection_trend_deg is None or figures.projection_plunge_deg is None:
        text = tr("Features projected perpendicular to the section")
        return (
            [*domain_lines, tr("Other features: perpendicular to the section")]
            if domain_lines
            else [text]
        )
    return [
        *domain_lines,
        tr(
            "Features projected along {trend}/{plunge:04.1f} (trend/plunge, °), {angle:.0f}° to "
            "the section",
            trend=format_azimuth(figures.projection_trend_deg, 1),
            plunge=figures.projection_plunge_deg,
            angle=figures.projection_angle_deg or 90.0,
        ),
    ]


def end_names(curtain: Curtain, is_north_known: bool = True) -> tuple[str, str]:
    """Return the names of the left and the right end, e.g. "NW (315)"."""
    left_azimuth, right_azimuth = curtain.ends
    if not is_north_known:
        a, b = (
            tr("{azimuth:03d}, local", azimuth=round(v) % 360)
            for v in (left_azimuth, right_azimuth)
        )
        return a, b
    return format_compass_point(left_azimuth), format_compass_point(right_azimuth)


def describe_section(curtain: Curtain, section_cut: Cut, unit: str) -> str:
    """Describe a section in one sentence."""
    plane = curtain.plane
    if plane is None:
        text = tr("Vertical section along a line of {count} segments", count=len(curtain.panels))
    else:
        text = tr(
            "Section along the plane {plane} (dip direction/dip, °)", plane=format_plane(plane)
        )
    if section_cut.slab_m is not None:
        text += "; " + tr(
            "points in a slab {slab:.3g} {unit} thick", slab=section_cut.slab_m, unit=unit
        )
    return text


def _header(
    curtain: Curtain, crs: str | None, model: str, figures: SectionFigures, axes: Axes
) -> str:
    distance, height = table_columns(("distance_m", "height_m"), is_metric=axes.metric)
    height += " is Z" if curtain.vertical else " counts up the plane from the given point"
    to_grid = "; azimuths to grid north" if axes.north else ""
    rows = [
        f"VOM Studio {__version__}, section of {Path(model).name}",
        f"CRS: {crs or 'local'}; {axes.description}{to_grid}",
        f"{distance} along the section from {format_plain_azimuth(figures.left_deg, 2)} toward "
        f"{format_plain_azimuth(figures.right_deg, 2)} deg; {height}",
    ]
    if figures.dip_direction_deg is not None:
        rows.append(
            f"plane: dip direction {format_plain_azimuth(figures.dip_direction_deg)}, "
            f"dip {figures.dip_deg:.4f}"
        )
    bends = ", ".join(f"{position:.3f}" for position, _ in curtain.bends(MAX_BENDS))
    if bends:
        rows.append(f"bends at {distance} {bends}")
    if figures.features:
        direction = PERPENDICULAR
        if figures.projection_trend_deg is not None:
            direction = (
                f"along trend {format_plain_azimuth(figures.projection_trend_deg)}, plunge "
                f"{figures.projection_plunge_deg:.4f}, at {figures.projection_angle_deg:.1f} deg "
                "to the section"
            )
        rows.append(f"{'other ' if figures.domains else ''}features projected {direction}")
        rows += [f"domain {item.words}" for item in figures.domains or ()]
    if figures.slab_m is not None:
        unit = "m" if axes.metric else axes.unit
        rows.append(f"points within {figures.slab_m / 2:.6g} {unit} of the section on either side")
    return "".join(map(comment_line, rows))


def _lines_table(section_cut: Cut, axes: Axes) -> str:
    names = ("polyline", "distance_m", "height_m", "x", "y", "z")
    rows = [",".join(table_columns(names, is_metric=axes.metric))]
    for k, (line, world) in enumerate(zip(section_cut.lines, section_cut.world, strict=True)):
        rows += [
            f"{k + 1},{s:.6f},{t:.6f},{x:.6f},{y:.6f},{z:.6f}"
            for (s, t), (x, y, z) in zip(line.tolist(), world.tolist(), strict=True)
        ]
    return "\n".join(rows) + "\n"


def _features_table(items: tuple[ProjectedItem, ...], axes: Axes) -> str:
    import csv
    import io

    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    has_domains = any(projected_feature.item.domain for projected_feature in items)
    names = (*FEATURE_COLUMNS, "domain") if has_domains else FEATURE_COLUMNS
    out.writerow(table_columns(names, is_metric=axes.metric))
    for projected_feature in items:
        item = projected_feature.item
        texts = [
            escape_formula(word) for word in (item.layer, item.id, item.name, item.kind, item.set)
        ]
        angles = [
            "" if angle is None or not math.isfinite(angle) else format_angle(angle)
            for angle, format_angle in (
                (item.dip_direction_deg, format_plain_azimuth),
                (item.dip_deg, "{:.4f}".format),
                (projected_feature.apparent_dip_deg, "{:.4f}".format),
            )
        ]
        overturned_text = "" if item.normal is None else str(item.overturned).lower()
        last_cells = (
            [overturned_text, escape_formula(item.domain)] if has_domains else [overturned_text]
        )
        for k, ((s, t), distances) in enumerate(
            zip(projected_feature.points.tolist(), projected_feature.distance.tolist(), strict=True)
        ):
            out.writerow(
                [*texts, k + 1, f"{s:.6f}", f"{t:.6f}", f"{distances:.6f}", *angles, *last_cells]
            )
    return file.getvalue()
