"""Analysis of fracture maps from files of traces and an area or scanlines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray, ObjectArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.fractures.network import MappedNetwork, SamplingRegion, fracture_network
from vomstudio.geology.fractures.pieces import circle_area, clip_traces
from vomstudio.geology.fractures.scanlines import assign_ranges
from vomstudio.geology.fractures.trace_plane import (
    TracePlane,
    find_trace_plane,
    trace_azimuths_deg,
    vertices_with_heights,
)
from vomstudio.geology.fractures.windows import trace_directions
from vomstudio.geology.notation import format_plane, parse_plane_option
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.outlines.self_crossing import resolve_crossings
from vomstudio.io.gate.drawn_layers import (
    DrawnLayer,
    RawLayer,
    extract_area,
    extract_lines,
    layer_from_shapes,
    read_raw_areas,
    read_raw_lines,
)
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.points import ModelFrame
from vomstudio.io.gis.raster import is_view_plane
from vomstudio.io.text.repeated_rows import repeats_finding

SET_COLUMN = "set"
_REPEAT_COLUMN = "repeat_of"


@dataclass(frozen=True)
class FractureMapRequest:
    """Input of a fracture analysis.

    Parameters
    ----------
    traces : Path or None
        File that contains the traces as lines.
    options : FractureOptions
    frame : FrameOptions
        Frame of the traces.
    """

    traces: Path | None
    options: FractureOptions = field(default_factory=FractureOptions)
    frame: FrameOptions = DEFAULT_FRAME


def map_fractures(
    request: FractureMapRequest,
    *,
    lines: ObjectArray | None = None,
    crs: str | None = None,
    area: ObjectArray | None = None,
    scanlines: ObjectArray | None = None,
    sampling_region: SamplingRegion | None = None,
    sets: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> MappedNetwork:
    """Analyse a map of fracture traces, or three-dimensional traces on their plane.

    Parameters
    ----------
    request : FractureMapRequest
        Files and options.
    lines, area, scanlines : (n,) arrays of shapely geometries or None
        Geometries that replace those of the files, in metres, with or without heights.
    crs : str or None
        CRS of `lines`, if known.
    sampling_region : SamplingRegion or None
        Sampling area or scanlines, in the coordinates in which the traces are analysed.
    sets : (n,) sequence of str or None
        Set of each trace, which replaces that of an attribute.
    progress : Progress, optional

    Raises
    ------
    InputError, UsageError, GeometryError
        The error names the file that caused it. For three-dimensional traces, the codes
        ``lines.no-plane``, ``lines.no-heights`` and ``lines.edge-on`` are possible.
    """
    options = request.options
    windows = (
        ("--area", options.area),
        ("--area", area),
        ("--circle", options.circle),
        ("--scanline", options.scanline),
        ("--scanline", scanlines),
    )
    used_options = [flag for flag, value in windows if value is not None]
    if len(used_options) > 1:
        finding = Finding("option.conflict", option=used_options[0], other=used_options[1])
        raise UsageError(finding, field=used_options[1])
    circle_values = None if options.circle is None else parse_circle(options.circle)
    strikes = parse_strikes(options.strikes)
    attitude = None if options.plane is None else parse_plane_option(options.plane)
    if lines is not None or request.traces is None:
        shapes = np.empty(0, np.object_) if lines is None else lines
        raw = layer_from_shapes(shapes, "traces", crs, request.frame)
    else:
        columns = _attributes(options) if sets is None else (_REPEAT_COLUMN,)
        raw = read_raw_lines(request.traces, options.layer, columns, progress, request.frame)
    placed_traces = _place_layer(raw, attitude)
    drawn_layer, plane = placed_traces.layer, placed_traces.plane
    warnings: list[Finding] = list(drawn_layer.warnings)
    if circle_values is not None:
        circle = placed_traces.circle(circle_values)
        sampling_region = SamplingRegion(circle_area(*circle), circle=circle)
    elif options.area is not None:
        raw = read_raw_areas(
            Path(options.area), progress=progress, model=ModelFrame(drawn_layer.crs)
        )
        polygon, area_layer = extract_area(placed_traces.window(raw, "area"))
        warnings += _new_findings(area_layer.warnings, warnings)
        sampling_region = SamplingRegion(polygon)
    elif area is not None:
        polygon, crossings = resolve_crossings(
            placed_traces.window(layer_from_shapes(area, "area"), "area").shapes
        )
        sampling_region = SamplingRegion(polygon, warnings=tuple(crossings))
    elif options.scanline is not None:
        raw = read_raw_lines(
            Path(options.scanline), progress=progress, model=ModelFrame(drawn_layer.crs)
        )
        area_layer = extract_lines(placed_traces.window(raw, "scanline"))
        warnings += _new_findings(area_layer.warnings, warnings)
        sampling_region = SamplingRegion(scanlines=area_layer.shapes)
    elif scanlines is not None:
        shapes = placed_traces.window(layer_from_shapes(scanlines, "scanline"), "scanline").shapes
        sampling_region = SamplingRegion(scanlines=shapes)
    if sets is None:
        sets = assign_sets(drawn_layer, options.by, strikes, plane)
    elif lines is None or len(sets) != len(lines):
        raise UsageError(Finding("fractures.sets-not-of-traces", sets=len(sets)), field="by")
    else:
        sets = [sets[i - 1] for i in drawn_layer.feature]
    if progress is not None:
        progress.stage(tr("Analysing the fracture network"))
    mapped_network = fracture_network(
        drawn_layer.shapes,
        sampling_region,
        sets=sets,
        snap_m=options.snap_m,
        terzaghi_cap=options.terzaghi_cap,
        warnings=warnings,
        plane=plane,
    )
    return (
        replace(mapped_network, y_axis="up")
        if plane is None and is_view_plane(drawn_layer.crs)
        else mapped_network
    )


def _new_findings(findings: Sequence[Finding], known_findings: Sequence[Finding]) -> list[Finding]:
    """Drop findings about the frame that were already reported for the traces."""
    codes = {item.code for item in known_findings if isinstance(item, Finding)}
    return [
        item
        for item in findings
        if not (isinstance(item, Finding) and item.code in codes and item.code.startswith("frame."))
    ]


@dataclass(frozen=True, eq=False)
class _PlacedTraces:
    """Traces in the coordinates in which they are analysed.

    Attributes
    ----------
    plane : TracePlane or None
        Plane of the traces; None if the coordinates are those of the map.
    heights : (float, float)
        Minimum and maximum Z of the traces, m; NaN if unknown.
    """

    layer: DrawnLayer
    plane: TracePlane | None
    heights: tuple[float, float]

    def window(self, raw_layer: RawLayer, option: Literal["area", "scanline"]) -> RawLayer:
        """Convert areas or scanlines to the coordinates of the traces. Raises GeometryError."""
        import shapely

        if self.plane is None:
            return replace(raw_layer, shapes=shapely.force_2d(raw_layer.shapes))
        shapes = self.plane.project_window(raw_layer.shapes, option, self.heights)
        return replace(raw_layer, shapes=shapes)

    def circle(self, circle: Sequence[float]) -> tuple[float, float, float]:
        """Convert a circle to x, y and radius in trace coordinates. Raises GeometryError."""
        if self.plane is None:
            x, y, *_, radius = circle
            return x, y, radius
        return self.plane.project_circle(circle)


def _place_layer(raw_layer: RawLayer, attitude: Plane | None) -> _PlacedTraces:
    """Project traces onto a plane if they are three-dimensional or if a plane is given."""
    lines, lacks_heights = vertices_with_heights(raw_layer.shapes)
    plane = find_trace_plane(lines) if attitude is None else None
    if attitude is not None:
        plane = _plane_from_attitude(attitude, lines, int(lacks_heights.sum()))
    if plane is None:
        findings: list[Finding] = []
        is_outline = raw_layer.outline_mask()
        if is_outline.any():
            findings = [Finding("lines.closed", lines=int(is_outline.sum()))]
            raw_layer = raw_layer.select_rows(~is_outline)
        first_pick_layer = _exclude_repeats(extract_lines(raw_layer))
        return _PlacedTraces(_add_findings(first_pick_layer, findings), None, (math.nan, math.nan))
    findings = []
    if lacks_heights.any() and not plane.is_horizontal:
        count = int(lacks_heights.sum())
        findings = [*findings, Finding("lines.no-heights", lines=count, plane=plane.name)]
        raw_layer = raw_layer.select_rows(~lacks_heights)
    projected_layer = replace(raw_layer, shapes=plane.project(raw_layer.shapes))
    first_pick_layer = _exclude_repeats(extract_lines(projected_layer, include_rings=False))
    findings = [plane.finding(len(first_pick_layer.shapes)), *findings]
    z = np.concatenate([line[:, 2] for line in lines]) if lines else np.array([math.nan])
    return _PlacedTraces(
        _add_findings(first_pick_layer, findings), plane, (float(z.min()), float(z.max()))
    )


def _plane_from_attitude(
    attitude: Plane, lines: Sequence[FloatArray], flat_count: int
) -> TracePlane | None:
    """Return the plane given by the user, placed through the traces, or None for a map.

    `flat_count` is the number of lines without heights. Raises GeometryError if no line has
    heights.
    """
    if attitude.undefined or not (lines or flat_count):
        return None
    if lines:
        return TracePlane.from_attitude(attitude, lines)
    finding = Finding("lines.no-heights", lines=flat_count, plane=format_plane(attitude))
    raise GeometryError(finding, field="--plane")


def _add_findings(drawn_layer: DrawnLayer, findings: Sequence[Finding]) -> DrawnLayer:
    return replace(drawn_layer, warnings=(*drawn_layer.warnings, *findings))


def _attributes(options: FractureOptions) -> list[str]:
    """Return the attributes of the traces that the analysis uses."""
    return [_REPEAT_COLUMN, SET_COLUMN, *([] if options.by is None else [options.by])]


def _exclude_repeats(drawn_layer: DrawnLayer) -> DrawnLayer:
    """Exclude lines that repeat another line according to their attribute `repeat_of`.

    Raises InputError if no line remains.
    """
    name = next(
        (column for column in drawn_layer.columns if column.casefold() == _REPEAT_COLUMN), None
    )
    if name is None:
        return drawn_layer
    is_first = np.array([not word for word in drawn_layer.column(name, name)], np.bool_)
    if is_first.all():
        return drawn_layer
    if not is_first.any():
        raise InputError(Finding("table.only-repeats"), file=drawn_layer.path, field=name)
    return replace(
        drawn_layer,
        shapes=drawn_layer.shapes[is_first],
        feature=drawn_layer.feature[is_first],
        columns={key: values[is_first] for key, values in drawn_layer.columns.items()},
        warnings=(*drawn_layer.warnings, repeats_finding(int((~is_first).sum()))),
    )


def assign_sets(
    drawn_layer: DrawnLayer,
    column: str | None,
    strikes: Sequence[tuple[float, float]],
    plane: TracePlane | None = None,
) -> list[str] | None:
    """Assign each trace (n,) to a set by an attribute or by ranges of strike.

    If neither is given, the attribute `set` is used. Returns None if it does not exist.
    """
    if strikes:
        row = assign_ranges(
            trace_azimuths_deg(trace_directions(clip_traces(drawn_layer.shapes)), plane), strikes
        )
        names = [f"{low:03g}-{high:03g}" for low, high in strikes]
        return ["" if i < 0 else names[i] for i in row]
    if column is not None:
        return drawn_layer.column(column, "--by")
    if any(name.casefold() == SET_COLUMN for name in drawn_layer.columns):
        return drawn_layer.column(SET_COLUMN, "--by")
    return None


def parse_circle(text: str) -> tuple[float, ...]:
    """Parse a circle given as "X,Y,R" or "X,Y,Z,R". Raises UsageError."""
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in (3, 4) or not np.isfinite(values).all() or values[-1] <= 0:
        raise UsageError(Finding("fractures.not-a-circle", text=text), field="--circle")
    return values


def parse_strikes(text: str | None) -> tuple[tuple[float, float], ...]:
    """Parse clockwise ranges of strike such as "340-020,060-100". Raises UsageError."""
    ranges = []
    for part in [] if text is None else text.split(","):
        low, _, high = part.partition("-")
        try:
            pair = (float(low), float(high))
        except ValueError:
            pair = (math.nan, math.nan)
        if not all(0 <= end <= 360 for end in pair):
            finding = Finding("fractures.not-a-strike-range", text=part)
            raise UsageError(finding, field="--strikes")
        ranges.append(pair)
    return tuple(ranges)
