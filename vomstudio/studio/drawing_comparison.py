"""Comparison of the lines in a drawing with the features of a project."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.products.ortho.interpretation import items_from_records
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Record
from vomstudio.studio.jobs.drawing_tasks import DrawnLines, PictureGeometry

MAX_ROUNDING_PX = 0.05
"""Maximum distance between an unchanged line and its feature; drawing programs round
coordinates."""


@dataclass(frozen=True)
class LineComparison:
    """Result of comparing a drawn line with the features of a project.

    Parameters
    ----------
    state : {"new", "unchanged", "edited"}
    id : str
        Id of the corresponding feature, or "" if the line is new.
    """

    state: Literal["new", "unchanged", "edited"]
    id: str = ""


def compare_drawing(drawing: DrawnLines, records: Mapping[str, Record]) -> list[LineComparison]:
    """Compare the lines of a drawing with the features of a project.

    A line that coincides with a feature is unchanged; any other line with the id of a feature is
    edited. If several lines have the same id, they are copies: only one of them, preferably the one
    that has not moved, is matched with the feature, and the others are new.
    """
    import shapely

    items = [item for item in items_from_records(records, Measurements()) if item.form != "point"]
    drawn_shapes = [shapely.LineString(line.pixels) for line in drawing.lines]
    shapes = [
        shapely.LineString(
            _close_ring(project_to_pixels(item.points, drawing.picture), item.form == "ring")
        )
        for item in items
    ]
    frame = shapely.box(0.0, 0.0, drawing.picture.width, drawing.picture.height)
    tree = shapely.STRtree(shapes)
    unchanged_lines: dict[int, int] = {}
    # Lines with a known id are matched first: two features may coincide.
    ids = {item.id for item in items}
    for i in sorted(range(len(drawn_shapes)), key=lambda i: drawing.lines[i].id not in ids):
        candidates = tree.query(drawn_shapes[i], predicate="dwithin", distance=MAX_ROUNDING_PX)
        matches = [int(j) for j in candidates if _is_same(drawn_shapes[i], shapes[j], frame)]
        matches_by_id = [j for j in matches if items[j].id == drawing.lines[i].id]
        unmatched_ids = [j for j in matches if j not in unchanged_lines.values()]
        if matches:
            unchanged_lines[i] = (matches_by_id or unmatched_ids or matches)[0]
    used_ids = {items[j].id for j in unchanged_lines.values()}
    comparisons = []
    for i, line in enumerate(drawing.lines):
        if i in unchanged_lines:
            comparisons.append(LineComparison("unchanged", items[unchanged_lines[i]].id))
        elif line.id in ids and line.id not in used_ids:
            used_ids.add(line.id)
            comparisons.append(LineComparison("edited", line.id))
        else:
            comparisons.append(LineComparison("new"))
    return comparisons


def project_to_pixels(points: FloatArray, picture: PictureGeometry) -> FloatArray:
    """Return the pixel coordinates (n, 2) of points (n, 3) in the World frame."""
    to_pixels = np.linalg.inv(np.array(picture.matrix))
    return np.asarray((points @ to_pixels[:3, :3].T + to_pixels[:3, 3])[:, :2])


def merge_vertices(
    drawn_px: FloatArray,
    projections: Sequence[FloatArray | None],
    stored_px: FloatArray,
    stored_vertices: FloatArray,
) -> FloatArray:
    """Return the vertices of an edited line; unmoved vertices keep their coordinates.

    A moved vertex that misses the surface is omitted.

    Parameters
    ----------
    drawn_px : (m, 2) float64
        Vertices of the drawn line, in pixels.
    projections : sequence of m (3,) arrays or None
        The same vertices projected onto the surface in the picture, or None for a vertex that
        misses it.
    stored_px, stored_vertices : (k, 2) and (k, 3) float64
        Vertices of the feature, in pixels and as stored.
    """
    vertices = []
    for pixel, point in zip(drawn_px, projections, strict=True):
        distances = np.linalg.norm(stored_px - pixel, axis=1)
        nearest_row = int(np.argmin(distances))
        if distances[nearest_row] <= MAX_ROUNDING_PX:
            vertices.append(stored_vertices[nearest_row])
        elif point is not None:
            vertices.append(point)
    return np.array(vertices, np.float64).reshape(-1, 3)


def _close_ring(pixels: FloatArray, is_ring: bool) -> FloatArray:
    return np.vstack([pixels, pixels[:1]]) if is_ring else pixels


def _is_same(line: Any, feature: Any, frame: Any) -> bool:
    """Return whether a line equals a feature, or the part of a feature within the picture."""
    import shapely

    shapes = (feature, shapely.intersection(feature, frame))
    return any(
        not shapely.is_empty(shape) and shapely.hausdorff_distance(line, shape) <= MAX_ROUNDING_PX
        for shape in shapes
    )
