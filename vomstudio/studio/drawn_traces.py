"""Traces from lines that were drawn on an orthophoto of a model in another program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import DocumentError, GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.matrices import Point
from vomstudio.products.ortho.back_projection import off_surface_findings
from vomstudio.project import edits
from vomstudio.project.edit import Edit, change
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import SURROUNDINGS_RULE, FeatureType, Model, Record, get
from vomstudio.studio.drawing_comparison import compare_drawing, merge_vertices, project_to_pixels
from vomstudio.studio.jobs.drawing_tasks import DrawingLine, DrawnLines, PictureGeometry
from vomstudio.studio.tools.local_surface import measure_surroundings

MAX_NAMED = 5


@dataclass(frozen=True)
class DrawnTraces:
    """Traces that were created or edited from a drawing.

    Parameters
    ----------
    traces : tuple of Trace
        New traces, which are not in the project yet.
    edited : tuple of Trace
        Traces of the project, with the edited vertices of the drawing.
    unchanged : tuple of str
        Ids of the features that the drawing does not change.
    skipped : tuple of (name, reason)
        Lines that cannot be converted to a trace, with the reason.
    warnings : tuple of Finding
    """

    traces: tuple[Trace, ...]
    edited: tuple[Trace, ...]
    unchanged: tuple[str, ...]
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]

    @property
    def edited_findings(self) -> tuple[Finding, ...]:
        """Findings about edited traces that are not updated."""
        if not self.edited:
            return ()
        names = ", ".join(trace.name for trace in self.edited[:MAX_NAMED])
        return (Finding("drawing.edited", count=len(self.edited), names=names),)

    @property
    def messages(self) -> tuple[Finding, ...]:
        """All findings, including those about skipped lines."""
        skipped_count = (
            Finding("feature.left-out", feature=name, reason=reason)
            for name, reason in self.skipped
        )
        return (*self.warnings, *skipped_count)


@dataclass(frozen=True)
class DrawingTarget:
    """Model and defaults for the traces that are created from a drawing.

    Parameters
    ----------
    model : Model
        Model on which they were drawn.
    surface : SelectableSurface or None
        Surface of the model, used for the resolution and the outcrop face.
    type_id : str or None
        Feature type of new lines. If None, each line must name its type.
    set_name : str
        Set of new lines that have no attribute `set`.
    is_type_fixed : bool
        Whether to ignore the types in the attribute `kind` or the layer of a line.
    """

    model: Model
    surface: SelectableSurface | None
    type_id: str | None
    set_name: str = ""
    is_type_fixed: bool = False


def create_trace(
    name: str,
    points: FloatArray,
    model: Model,
    type_id: str,
    set_name: str,
    surface: SelectableSurface | None,
) -> Trace:
    """Create a trace from points (n, 3) in the file frame of a model."""
    vertices: tuple[Point, ...] = tuple((float(x), float(y), float(z)) for x, y, z in points)
    trace = Trace(
        id=new_id("trace"),
        name=name,
        type_id=type_id,
        model_id=model.id,
        model_hash=model.content_hash,
        vertices=vertices,
        set_name=set_name,
        axis="auto",
    )
    if surface is None:
        return trace
    resolution, normal = measure_surroundings(surface, vertices)
    return replace(trace, resolution=resolution, outcrop_normal=normal, rule=SURROUNDINGS_RULE)


def update_traces(
    records: Mapping[str, Record], edited_traces: Sequence[Trace], drawing: str
) -> Edit:
    """Create the edit that replaces the vertices of traces by those of a drawing.

    Raises
    ------
    DocumentError
        If a trace is no longer in the project.
    """
    label = tr_n(
        "Update {count} trace from {drawing}",
        "Update {count} traces from {drawing}",
        len(edited_traces),
        drawing=drawing,
    )
    changed_records: dict[str, Record | None] = {}
    for trace in edited_traces:
        current = get(records, trace.id, Trace)
        if current is None:
            raise DocumentError(Finding("record.missing", id=trace.id, kind="trace"))
        changed_records[trace.id] = replace(
            current,
            vertices=trace.vertices,
            resolution=trace.resolution,
            outcrop_normal=trace.outcrop_normal,
            rule=trace.rule,
        )
    return change(records, label, changed_records)


def find_layer_type(layer: str, types: Iterable[FeatureType]) -> FeatureType | None:
    """Return the feature type whose name or id equals a layer name, ignoring case, or None."""
    key = layer.strip().casefold()
    for feature_type in types:
        if key and key in (feature_type.id.casefold(), feature_type.name.casefold()):
            return feature_type
    return None


def create_drawn_traces(
    lines: DrawnLines,
    drawing: Path,
    sidecar: Path,
    target: DrawingTarget,
    records: Mapping[str, Record],
) -> DrawnTraces:
    """Compare the lines of a drawing with a project, and create traces of new and edited ones.

    Raises
    ------
    UsageError
        If a new line names no feature type and `target` has no default.
    GeometryError
        If no line can be converted to a trace.
    """
    model = target.model
    warnings = list(lines.warnings)
    if lines.content_hash not in (None, model.content_hash):
        warnings.append(Finding("drawing.orthophoto-of-other-file", model=model.name))
    note = tr(
        "Drawn on the orthophoto {picture}, in {drawing}.",
        picture=sidecar.stem,
        drawing=drawing.name,
    )
    traces: list[Trace] = []
    edited_traces: list[Trace] = []
    unchanged_traces: list[str] = []
    skipped_lines: list[tuple[str, Finding]] = []
    off_surface_count = 0
    comparisons = compare_drawing(lines, records)
    types = iter(
        _find_types(
            [
                line
                for line, comparison in zip(lines.lines, comparisons, strict=True)
                if comparison.state == "new"
            ],
            target,
            records,
        )
    )
    for line, comparison in zip(lines.lines, comparisons, strict=True):
        if comparison.state == "unchanged":
            unchanged_traces.append(comparison.id)
            continue
        try:
            if comparison.state == "edited":
                edited_traces.append(
                    _edited_trace(line, comparison.id, lines.picture, target, records)
                )
                continue
            type_id = next(types)
            # A line without a name was named by its number; the project has its own scheme of
            # names.
            name = "" if line.name.isdecimal() and not line.is_named else line.name
            points = np.array(line.surface_points).reshape(-1, 3)
            off_surface_count += len(line.points) - len(points)
            trace = create_trace(
                name, points, model, type_id, line.set or target.set_name, target.surface
            )
            trace = replace(trace, notes=note)
            edits.add_trace(records, trace)
            traces.append(trace)
        except GeometryError as error:
            skipped_lines.append((line.name, cause_finding(error)))
    if skipped_lines and not traces and not edited_traces and not unchanged_traces:
        name, reason = skipped_lines[0]
        raise GeometryError(
            Finding("drawing.no-plane", name=name, reason=reason),
            file=drawing,
        )
    warnings += off_surface_findings(off_surface_count, 0)
    if unchanged_traces:
        warnings.append(Finding("drawing.unchanged", count=len(unchanged_traces)))
    return DrawnTraces(
        tuple(traces),
        tuple(edited_traces),
        tuple(unchanged_traces),
        tuple(skipped_lines),
        tuple(warnings),
    )


def _find_types(
    lines: Sequence[DrawingLine], target: DrawingTarget, records: Mapping[str, Record]
) -> list[str]:
    """Return the id of the feature type of each new line. Raises UsageError."""
    types = [record for record in records.values() if isinstance(record, FeatureType)]
    type_ids = []
    for line in lines:
        named_layer_type = find_layer_type(line.kind, types) or find_layer_type(line.layer, types)
        is_named = named_layer_type is not None and not target.is_type_fixed
        type_ids.append(
            named_layer_type.id if named_layer_type is not None and is_named else target.type_id
        )
    missing_names = [
        line.layer for line, type_id in zip(lines, type_ids, strict=True) if type_id is None
    ]
    if missing_names:
        layers = ", ".join(layer or "0" for layer in list(dict.fromkeys(missing_names))[:MAX_NAMED])
        raise UsageError(
            Finding("drawing.unknown-type", layers=layers),
            field="--type",
        )
    return [type_id for type_id in type_ids if type_id is not None]


def _edited_trace(
    line: DrawingLine,
    feature_id: str,
    picture: PictureGeometry,
    target: DrawingTarget,
    records: Mapping[str, Record],
) -> Trace:
    """Return a trace of the project with the vertices of a drawn line. Raises GeometryError."""
    model = target.model
    trace = get(records, feature_id, Trace)
    if trace is None:
        raise GeometryError(Finding("drawing.not-a-trace"))
    if trace.model_id != model.id:
        raise GeometryError(Finding("feature.on-other-model", model=model.name, feature=trace.name))
    stored_vertices = np.array(trace.vertices, np.float64)
    stored_world = transform.apply(transform.matrix(model.to_world), stored_vertices)
    vertices = merge_vertices(
        np.array(line.pixels),
        [None if point is None else np.array(point) for point in line.points],
        project_to_pixels(stored_world, picture),
        stored_vertices,
    )
    drawn_trace = create_trace(
        trace.name, vertices, model, trace.type_id, trace.set_name, target.surface
    )
    edits.add_trace(records, drawn_trace)
    return replace(drawn_trace, id=trace.id)
