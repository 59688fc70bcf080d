"""Traces and the area they are counted in: what of them lies inside."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

_ROUNDING = 1e-4
"""Metres, and share of a trace's usual length, whichever is less: places nearer than that are the
same. GIS programs keep coordinates on a grid, of 0.1 mm where nobody chose another."""
_CORNERS = 4096


@dataclass(frozen=True, eq=False)
class Pieces:
    """The traces inside an area, not cut at nodes.

    lines : (n,) shapely lines; trace : (n,) row of the trace that each is of; cut : (n, 2) whether
    its start and its end lie on the edge of the area, where nobody knows how it goes on;
    rounding_m : places nearer than that are the same.
    """

    lines: ObjectArray
    trace: IntArray
    cut: BoolArray
    rounding_m: float

    def __len__(self) -> int:
        return len(self.lines)

    def lengths(self) -> FloatArray:
        import shapely

        return np.asarray(shapely.length(self.lines))

    def ends(self) -> FloatArray:
        """(n, 2, 2) x and y of start and end."""
        import shapely

        found = [shapely.get_point(self.lines, i) for i in (0, -1)]
        return np.stack([np.stack([shapely.get_x(p), shapely.get_y(p)], -1) for p in found], 1)


def rounding_of(lines: ObjectArray) -> float:
    """Within which distance places of a map of traces (n,) are the same, in metres."""
    import shapely

    usual = float(np.median(shapely.length(lines))) if len(lines) else 1.0
    return _ROUNDING * min(1.0, usual)


def circle_area(x: float, y: float, radius: float) -> Any:
    """A polygon of the circle's very area; no place of its edge is further off than 1e-6 radii."""
    import shapely

    # Beyond this nothing is left of a metre in a double.
    if not (np.abs([x, y, radius]) < 1e12).all() or radius <= 0:
        raise GeometryError(
            Finding("fractures.not-a-circle", text=f"{x:g},{y:g},{radius:g}"), field="--circle"
        )
    step = 2 * np.pi / _CORNERS
    outer = radius * np.sqrt(step / np.sin(step))
    turn = np.arange(_CORNERS) * step
    return shapely.Polygon(np.stack([x + outer * np.cos(turn), y + outer * np.sin(turn)], -1))


def pieces_of(lines: ObjectArray, area: Any = None, edge_m: float = 0.0) -> Pieces:
    """Clip traces (n,) to an area (a shapely polygon; None: everything was seen).

    A trace that leaves the area and comes back is two pieces. edge_m : an end as near to the edge
    as this lies on it, beside what is rounding.
    """
    import shapely

    rounding = rounding_of(lines)
    rows = np.arange(len(lines), dtype=np.int64)
    if area is None:
        return Pieces(lines, rows, np.zeros((len(lines), 2), np.bool_), rounding)
    shapely.prepare(area)
    inside = np.asarray(shapely.covered_by(lines, area))
    crossing = np.flatnonzero(~inside & shapely.intersects(lines, area))
    parts, part_of = _cut(lines[crossing], area)
    kept = np.concatenate([lines[inside], parts])
    trace = np.concatenate([rows[inside], crossing[part_of]])
    order = np.argsort(trace, kind="stable")
    found = Pieces(kept[order], trace[order], np.zeros((len(kept), 2), np.bool_), rounding)
    edge = shapely.boundary(area)
    shapely.prepare(edge)
    places = shapely.points(found.ends())
    cut = np.asarray(shapely.dwithin(edge, places, max(edge_m, rounding)), np.bool_)
    return replace(found, cut=cut.reshape(-1, 2))


def segments_of(lines: ObjectArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Starts (m, 2) and ends (m, 2) of the straight segments of lines, and the line of each."""
    import shapely

    xy, line = shapely.get_coordinates(lines, return_index=True)
    same = line[1:] == line[:-1]
    return xy[:-1][same], xy[1:][same], line[:-1][same].astype(np.int64)


def _cut(lines: ObjectArray, area: Any) -> tuple[ObjectArray, IntArray]:
    """The parts of lines inside the area, each with the row of its line."""
    import shapely

    simple = np.asarray(shapely.is_simple(lines))
    inside = shapely.intersection(lines[simple], area)
    # A closed trace goes on where it begins.
    ring = np.asarray(shapely.is_ring(lines[simple]))
    inside[ring] = shapely.line_merge(inside[ring])
    parts, of = shapely.get_parts(inside, return_index=True)
    long = (shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)
    own, own_of = _cut_by_segments(lines[~simple], area)
    rows = [np.flatnonzero(simple)[of[long]], np.flatnonzero(~simple)[own_of]]
    return np.concatenate([parts[long], own]), np.concatenate(rows)


def _cut_by_segments(lines: ObjectArray, area: Any) -> tuple[ObjectArray, IntArray]:
    """The same of lines that cross themselves, where the library would cut them: segment by
    segment, and what follows without a gap is joined."""
    import shapely

    start, end, line = segments_of(lines)
    segments = shapely.linestrings(np.stack([start, end], axis=1))
    parts, of = shapely.get_parts(shapely.intersection(segments, area), return_index=True)
    straight = (shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)
    parts, of = parts[straight], of[straight]
    # From one end to the other, as the segment goes.
    ends = np.stack([shapely.get_coordinates(shapely.get_point(parts, i)) for i in (0, -1)], 1)
    along = end[of] - start[of]
    place = np.einsum("kej,kj->ke", ends - start[of][:, None], along)
    backward = place[:, 0] > place[:, 1]
    ends[backward] = ends[backward][:, ::-1]
    order = np.lexsort((place.min(axis=1), of))
    ends, owner = ends[order], line[of[order]]
    found: list[Any] = []
    found_of: list[int] = []
    begin = 0
    for i in range(1, len(ends) + 1):
        if i < len(ends) and owner[i] == owner[i - 1] and (ends[i, 0] == ends[i - 1, 1]).all():
            continue
        run = ends[begin:i]
        if len(run):
            found.append(shapely.linestrings(np.vstack([run[0, :1], run[:, 1]])))
            found_of.append(int(owner[begin]))
        begin = i
    made = np.empty(len(found), np.object_)
    made[:] = found
    return made, np.asarray(found_of, np.int64)
