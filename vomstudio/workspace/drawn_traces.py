"""Traces on a model from lines that were drawn on an orthophoto of it in another program."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.document import edits
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import SURROUNDINGS_RULE, FeatureType, Model, Point, Record
from vomstudio.errors import GeometryError
from vomstudio.geometry.brush import PaintSurface
from vomstudio.jobs.drawing_tasks import DrawnLines
from vomstudio.tools.local_surface import around
from vomstudio.words import tr

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class DrawnTraces:
    """traces : not yet in the project; skipped : names of lines that give none, each with why;
    warnings : sentences"""

    traces: tuple[Trace, ...]
    skipped: tuple[tuple[str, str], ...]
    warnings: tuple[Message, ...]


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


def type_of_layer(layer: str, types: Iterable[FeatureType]) -> FeatureType | None:
    """The feature type that a layer of a drawing is named after, in whatever case."""
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
    """Each line that was brought back and defines a plane as a trace.

    type_id : of the lines whose layer is not called as a feature type of the project is. Raises
    GeometryError where no line defines a plane.
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
    types = [record for record in records.values() if isinstance(record, FeatureType)]
    for line in found.lines:
        # A line without a name was given its number; the project has names of its own.
        name = "" if line.name.isdecimal() and not line.named else line.name
        kind = type_of_layer(line.layer, types)
        own_type = type_id if kind is None else kind.id
        points = np.array(line.points, np.float64)
        trace = trace_through(name, points, model, own_type, set_name, surface)
        trace = replace(trace, notes=note)
        try:
            edits.add_trace(records, trace)
        except GeometryError as error:
            skipped.append((line.name, error.message))
            continue
        traces.append(trace)
    if not traces:
        name, reason = skipped[0]
        raise GeometryError(
            tr(
                "None of the drawn lines defines a plane. The first is {name}: {reason}",
                name=name,
                reason=reason,
            ),
            file=drawing,
        )
    return DrawnTraces(tuple(traces), tuple(skipped), tuple(warnings))
