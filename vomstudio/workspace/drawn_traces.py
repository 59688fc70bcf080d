"""Traces on a model from lines that were drawn on an orthophoto of it in another program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.document import edits
from vomstudio.document.edit import Edit, change
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import SURROUNDINGS_RULE, FeatureType, Model, Point, Record
from vomstudio.errors import GeometryError
from vomstudio.geometry.brush import PaintSurface
from vomstudio.jobs.drawing_tasks import DrawnLines
from vomstudio.tools.local_surface import around
from vomstudio.words import tr, tr_n
from vomstudio.workspace.redrawn import NEW, Comparison, compare_with_traces, traces_in_world

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class DrawnTraces:
    """Traces from a drawing.

    Parameters
    ----------
    traces : tuple of Trace
        New ones, which are not in the project yet.
    skipped : tuple of (name, reason)
        Lines that give no trace.
    warnings : tuple of Message
    unchanged : int
        Number of lines that are traces of the project as they are.
    edited : tuple of Trace
        Traces of the project with the vertices that the drawing has.
    """

    traces: tuple[Trace, ...]
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[Message, ...]
    unchanged: int = 0
    edited: tuple[Trace, ...] = ()


def trace_through(
    name: str,
    points: Array,
    model: Model,
    type_id: str,
    set_name: str,
    surface: PaintSurface | None,
) -> Trace:
    """points : (n, 3) in the frame of the model's file; surface : for resolution and face"""
    vertices: tuple[Point, ...] = tuple((float(x), float(y), float(z)) for x, y, z in points)
    trace = Trace(
        id=edits.new_id("trace"), name=name, type_id=type_id, model_id=model.id,
        model_hash=model.content_hash, vertices=vertices, set_name=set_name, axis="auto",
    )  # fmt: skip
    if surface is None:
        return trace
    resolution, normal = around(surface, vertices)
    return replace(trace, resolution=resolution, outcrop_normal=normal, rule=SURROUNDINGS_RULE)


def with_vertices_of(trace: Trace, other: Trace) -> Trace:
    """Return a trace with the vertices of another, and what follows from their place."""
    return replace(
        trace,
        vertices=other.vertices,
        resolution=other.resolution,
        outcrop_normal=other.outcrop_normal,
        rule=other.rule,
    )


def update_traces(records: Mapping[str, Record], edited: Sequence[Trace], drawing: str) -> Edit:
    """Return the edit that gives traces the vertices that a drawing has."""
    label = tr_n(
        "Update {count} trace from {drawing}",
        "Update {count} traces from {drawing}",
        len(edited),
        drawing=drawing,
    )
    return change(records, label, {trace.id: trace for trace in edited})


def type_of_layer(layer: str, types: Iterable[FeatureType]) -> FeatureType | None:
    """Return the feature type with the name or id of a layer, in upper or lower case."""
    wanted = layer.strip().casefold()
    for kind in types:
        if wanted and wanted in (kind.id.casefold(), kind.name.casefold()):
            return kind
    return None


def drawn_traces(
    found: DrawnLines,
    drawing: Path,
    sidecar: Path,
    model: Model,
    surface: PaintSurface | None,
    records: Mapping[str, Record],
    type_id: str,
    set_name: str = "",
) -> DrawnTraces:
    """Compare the lines that were brought back with the project, and make traces of new ones.

    Parameters
    ----------
    type_id : str
        Feature type of new lines whose attribute `kind` and whose layer name none of the project.
    set_name : str
        Set of new lines without an attribute `set`.

    Raises
    ------
    GeometryError
        If no line defines a plane.
    """
    warnings = list(found.warnings)
    if found.content_hash not in (None, model.content_hash):
        warnings.append(
            tr(
                "The orthophoto was made of another file than {model}, or of it before it changed.",
                model=model.name,
            )
        )
    skipped = [(name, tr("it meets no surface")) for name in found.skipped]
    note = tr("Drawn on the orthophoto {picture}, in {drawing}.", picture=sidecar.stem,
              drawing=drawing.name)  # fmt: skip
    traces: list[Trace] = []
    edited: list[Trace] = []
    unchanged = 0
    types = [record for record in records.values() if isinstance(record, FeatureType)]
    for line, comparison in zip(found.lines, _compared(found, records), strict=True):
        if comparison.state == "unchanged":
            unchanged += 1
            continue
        if (reason := why_not_updated(comparison, model, records)) is not None:
            skipped.append((line.name, reason))
            continue
        # A line without a name was given its number; the project has names of its own.
        name = "" if line.name.isdecimal() and not line.named else line.name
        kind = type_of_layer(line.kind, types) or type_of_layer(line.layer, types)
        own_type = type_id if kind is None else kind.id
        points = np.array(line.points, np.float64)
        trace = trace_through(name, points, model, own_type, line.set or set_name, surface)
        trace = replace(trace, notes=note)
        try:
            edits.add_trace(records, trace)
        except GeometryError as error:
            skipped.append((line.name, error.message))
            continue
        if comparison.trace is None:
            traces.append(trace)
            continue
        edited.append(with_vertices_of(comparison.trace, trace))
    if not traces and not edited and not unchanged:
        name, reason = skipped[0]
        raise GeometryError(
            tr(
                "None of the drawn lines defines a plane. The first is {name}: {reason}",
                name=name,
                reason=reason,
            ),
            file=drawing,
        )
    return DrawnTraces(tuple(traces), tuple(skipped), tuple(warnings), unchanged, tuple(edited))


def why_not_updated(
    comparison: Comparison, model: Model, records: Mapping[str, Record]
) -> str | None:
    """Return why a line that was drawn on a model cannot be its trace, None if it can."""
    trace = comparison.trace
    if trace is None or trace.model_id == model.id:
        return None
    other = records.get(trace.model_id)
    name = other.name if isinstance(other, Model) else trace.model_id
    return tr("it was edited, but is a trace on {model}", model=name)


def _compared(found: DrawnLines, records: Mapping[str, Record]) -> Sequence[Comparison]:
    if found.picture is None:
        return [NEW] * len(found.lines)
    return compare_with_traces(
        [np.array(line.pixels) for line in found.lines],
        [line.id for line in found.lines],
        traces_in_world(records),
        found.picture,
    )
