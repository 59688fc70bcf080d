"""Traces clipped to the area in which they are counted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding

MAX_ROUNDING_M = 1e-4
"""Distance below which points are identical, in metres and as a fraction of the median trace
length. GIS programs store coordinates on a grid of 0.1 mm by default.
"""
N_CIRCLE_VERTICES = 4096


@dataclass(frozen=True, eq=False)
class TracePieces:
    """Pieces of traces inside an area, not split at nodes.

    Attributes
    ----------
    lines : (n,) ndarray of shapely lines
    trace : (n,) ndarray of int
        Row of the trace that each piece belongs to.
    is_cut : (n, 2) ndarray of bool
        Whether the start and the end lie on the edge of the area, beyond which the trace is
        unknown.
    rounding_m : float
        Distance in metres within which points are identical.
    """

    lines: ObjectArray
    trace: IntArray
    is_cut: BoolArray
    rounding_m: float

    def __len__(self) -> int:
        return len(self.lines)

    def lengths(self) -> FloatArray:
        import shapely

        return np.asarray(shapely.length(self.lines))

    def ends(self) -> FloatArray:
        """Return x and y (n, 2, 2) of the start and end points."""
        import shapely

        points = [shapely.get_point(self.lines, i) for i in (0, -1)]
        return np.stack(
            [np.stack([shapely.get_x(point), shapely.get_y(point)], -1) for point in points], 1
        )


def coordinate_tolerance(lines: ObjectArray) -> float:
    """Return the distance within which points of a trace map are considered identical.

    Parameters
    ----------
    lines : (n,) ndarray of object
        Shapely lines.

    Returns
    -------
    float
        Distance in metres.
    """
    import shapely

    median_length = float(np.median(shapely.length(lines))) if len(lines) else 1.0
    return MAX_ROUNDING_M * min(1.0, median_length)


def circle_area(x: float, y: float, radius: float) -> Any:
    """Return a polygon with the exact area of a circle and an edge within 1e-6 radii of it.

    Parameters
    ----------
    x, y : float
        Coordinates of the centre.
    radius : float

    Returns
    -------
    shapely Polygon

    Raises
    ------
    GeometryError
        If the radius is not positive, or if a number is too large.
    """
    import shapely

    # Larger coordinates cannot resolve metres.
    if not (np.abs([x, y, radius]) < 1e12).all() or radius <= 0:
        raise GeometryError(
            Finding("fractures.not-a-circle", text=f"{x:g},{y:g},{radius:g}"), field="--circle"
        )
    step = 2 * np.pi / N_CIRCLE_VERTICES
    outer_radius = radius * np.sqrt(step / np.sin(step))
    angles = np.arange(N_CIRCLE_VERTICES) * step
    return shapely.Polygon(
        np.stack([x + outer_radius * np.cos(angles), y + outer_radius * np.sin(angles)], -1)
    )


def clip_traces(lines: ObjectArray, area: Any = None, edge_tolerance_m: float = 0.0) -> TracePieces:
    """Clip traces to the area in which they are counted.

    A trace that leaves the area and re-enters it becomes two pieces.

    Parameters
    ----------
    lines : (n,) ndarray of shapely lines
        Coordinates in metres.
    area : shapely polygon, optional
        If None, everything was mapped.
    edge_tolerance_m : float
        Maximum distance of an end from the edge for it to be treated as lying on the edge, m.

    Returns
    -------
    TracePieces
    """
    import shapely

    rounding = coordinate_tolerance(lines)
    rows = np.arange(len(lines), dtype=np.int64)
    if area is None:
        return TracePieces(lines, rows, np.zeros((len(lines), 2), np.bool_), rounding)
    shapely.prepare(area)
    is_inside = np.asarray(shapely.covered_by(lines, area))
    crossing_rows = np.flatnonzero(~is_inside & shapely.intersects(lines, area))
    parts, part_rows = _clip_lines(lines[crossing_rows], area)
    clipped_lines = np.concatenate([lines[is_inside], parts])
    trace = np.concatenate([rows[is_inside], crossing_rows[part_rows]])
    order = np.argsort(trace, kind="stable")
    pieces = TracePieces(
        clipped_lines[order], trace[order], np.zeros((len(clipped_lines), 2), np.bool_), rounding
    )
    edge = shapely.boundary(area)
    shapely.prepare(edge)
    positions = shapely.points(pieces.ends())
    is_cut = np.asarray(shapely.dwithin(edge, positions, max(edge_tolerance_m, rounding)), np.bool_)
    return replace(pieces, is_cut=is_cut.reshape(-1, 2))


def line_segments(lines: ObjectArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the straight segments of lines and the line of each segment.

    Parameters
    ----------
    lines : (n,) ndarray of object
        Shapely lines.

    Returns
    -------
    starts, ends : (m, 2) ndarray
    line : (m,) ndarray of int
        Index of the line of each segment.
    """
    import shapely

    xy, line = shapely.get_coordinates(lines, return_index=True)
    is_same = line[1:] == line[:-1]
    return xy[:-1][is_same], xy[1:][is_same], line[:-1][is_same].astype(np.int64)


def _clip_lines(lines: ObjectArray, area: Any) -> tuple[ObjectArray, IntArray]:
    """Return the parts of lines inside the area, and the row of the line of each part."""
    import shapely

    is_simple = np.asarray(shapely.is_simple(lines))
    clipped_lines = shapely.intersection(lines[is_simple], area)
    # Join the two ends of a closed trace.
    is_ring = np.asarray(shapely.is_ring(lines[is_simple]))
    clipped_lines[is_ring] = shapely.line_merge(clipped_lines[is_ring])
    parts, line_row = shapely.get_parts(clipped_lines, return_index=True)
    is_line = (shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)
    rejoined_parts, rejoined_rows = _clip_by_segments(lines[~is_simple], area)
    rows = [
        np.flatnonzero(is_simple)[line_row[is_line]],
        np.flatnonzero(~is_simple)[rejoined_rows],
    ]
    return np.concatenate([parts[is_line], rejoined_parts]), np.concatenate(rows)


def _clip_by_segments(lines: ObjectArray, area: Any) -> tuple[ObjectArray, IntArray]:
    """Clip self-crossing lines segment by segment and join consecutive segments without a gap.

    Shapely would split such lines where they cross themselves.
    """
    import shapely

    start, end, line = line_segments(lines)
    segments = shapely.linestrings(np.stack([start, end], axis=1))
    parts, segment_row = shapely.get_parts(shapely.intersection(segments, area), return_index=True)
    is_line = (shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)
    parts, segment_row = parts[is_line], segment_row[is_line]
    # Orient the parts along their segments.
    ends = np.stack([shapely.get_coordinates(shapely.get_point(parts, i)) for i in (0, -1)], 1)
    segment_vectors = end[segment_row] - start[segment_row]
    position = np.einsum("kej,kj->ke", ends - start[segment_row][:, None], segment_vectors)
    is_backward = position[:, 0] > position[:, 1]
    ends[is_backward] = ends[is_backward][:, ::-1]
    order = np.lexsort((position.min(axis=1), segment_row))
    ends, line_indices = ends[order], line[segment_row[order]]
    joined_lines: list[Any] = []
    joined_line_indices: list[int] = []
    begin = 0
    for i in range(1, len(ends) + 1):
        if (
            i < len(ends)
            and line_indices[i] == line_indices[i - 1]
            and (ends[i, 0] == ends[i - 1, 1]).all()
        ):
            continue
        run = ends[begin:i]
        if len(run):
            joined_lines.append(shapely.linestrings(np.vstack([run[0, :1], run[:, 1]])))
            joined_line_indices.append(int(line_indices[begin]))
        begin = i
    lines_inside = np.empty(len(joined_lines), np.object_)
    lines_inside[:] = joined_lines
    return lines_inside, np.asarray(joined_line_indices, np.int64)
