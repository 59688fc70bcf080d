"""Shapes of a drawing compared with the features from which they were drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import Model, Record, get
from vomstudio.geometry import transform
from vomstudio.jobs.drawing_tasks import Picture
from vomstudio.products.ortho.drawing_back import BackLine, Sidecar

Array = npt.NDArray[np.float64]
State = Literal["new", "unchanged", "edited"]

MAX_ROUNDING_PX = 0.05
"""Largest distance of an unchanged line from its feature: programs round coordinates."""


@dataclass(frozen=True)
class Comparison:
    """Comparison of a drawn line with the traces of a project.

    Parameters
    ----------
    state : {"new", "unchanged", "edited"}
    trace : Trace or None
        Trace of the project that the line is, None if it is new.
    """

    state: State
    trace: Trace | None = None


NEW = Comparison("new")


def compare_with_traces(
    lines: Sequence[Array],
    ids: Sequence[str],
    traces: Mapping[str, tuple[Trace, Array]],
    picture: Picture,
) -> list[Comparison]:
    """Compare the lines of a drawing with the traces of a project.

    A line is the trace whose id it has, else the trace that lies where it does. Several lines with
    one id are copies, of which the one that has not moved is the trace.

    Parameters
    ----------
    lines : sequence of (n, 2) float64
        Vertices in pixels of the picture.
    ids : sequence of str
        Id that the drawing states for each line, "" for none.
    traces : mapping of str to (Trace, (k, 3) float64)
        Traces by id, with their vertices in World.
    picture : Picture
        In World.
    """
    import shapely

    frame = shapely.box(0.0, 0.0, picture.width, picture.height)
    to_pixels = np.linalg.inv(np.array(picture.matrix))
    drawn = [shapely.LineString(line) for line in lines]
    known = [trace for trace, _ in traces.values()]
    places = [shapely.LineString(_pixels(points, to_pixels)) for _, points in traces.values()]
    tree = shapely.STRtree(places)
    row = {id_: i for i, id_ in enumerate(traces)}
    unchanged: dict[int, int] = {}
    # Lines with an id choose first: two traces may lie at one place.
    for i in sorted(range(len(drawn)), key=lambda i: ids[i] not in row):
        near = tree.query(drawn[i], predicate="dwithin", distance=MAX_ROUNDING_PX)
        same = [int(j) for j in near if _is_same(drawn[i], places[j], frame)]
        free = [j for j in same if j not in unchanged.values()]
        if same:
            own = row.get(ids[i], -1)
            unchanged[i] = own if own in same else (free or same)[0]
    used = set(unchanged.values())
    comparisons = []
    for i, id_ in enumerate(ids):
        number = row.get(id_, -1)
        if i in unchanged:
            comparisons.append(Comparison("unchanged", known[unchanged[i]]))
        elif number >= 0 and number not in used:
            used.add(number)
            comparisons.append(Comparison("edited", known[number]))
        else:
            comparisons.append(NEW)
    return comparisons


def compare_brought(
    lines: Sequence[BackLine], sidecar: Sidecar, records: Mapping[str, Record]
) -> list[Comparison]:
    """Compare lines that were brought back with the traces of a project, as
    `compare_with_traces`."""
    return compare_with_traces(
        [line.pixels for line in lines],
        [line.words.id for line in lines],
        traces_in_world(records),
        Picture.of(sidecar),
    )


def traces_in_world(records: Mapping[str, Record]) -> dict[str, tuple[Trace, Array]]:
    """Return the traces of a project by id, with their vertices (k, 3) in World."""
    found = {}
    for id_ in records:
        trace = get(records, id_, Trace)
        model = None if trace is None else get(records, trace.model_id, Model)
        if trace is not None and model is not None:
            vertices = np.array(trace.vertices, np.float64)
            found[id_] = (trace, transform.apply(transform.matrix(model.to_world), vertices))
    return found


def _pixels(points: Array, to_pixels: Array) -> Array:
    return np.asarray((points @ to_pixels[:3, :3].T + to_pixels[:3, 3])[:, :2])


def _is_same(line: object, trace: object, frame: object) -> bool:
    """Return whether a drawn line is a trace, whose parts outside of the picture are not drawn."""
    import shapely

    visible = shapely.intersection(trace, frame)
    if shapely.is_empty(visible) or shapely.length(visible) == 0.0:
        visible = trace
    return bool(shapely.hausdorff_distance(line, visible) <= MAX_ROUNDING_PX)
