"""Comparison of the lines of a drawing with the features of a project."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.products.ortho.interpretation import items_of
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Record
from vomstudio.studio.jobs.drawing_tasks import DrawnLines, Picture

MAX_ROUNDING_PX = 0.05
"""Largest distance of an unchanged line from its feature: programs round coordinates."""


@dataclass(frozen=True)
class Comparison:
    """Comparison of a drawn line with the features of a project.

    Parameters
    ----------
    state : {"new", "unchanged", "edited"}
    id : str
        Id of the feature that the line is, "" if it is new.
    """

    state: Literal["new", "unchanged", "edited"]
    id: str = ""


def compare_drawing(found: DrawnLines, records: Mapping[str, Record]) -> list[Comparison]:
    """Compare the lines of a drawing with what a drawing of the project would show.

    A line is the feature whose id it has, else the feature that lies where it does. Several lines
    with one id are copies, of which the one that has not moved is the feature.
    """
    import shapely

    items = [item for item in items_of(records, Measurements()) if item.form != "point"]
    drawn = [shapely.LineString(line.pixels) for line in found.lines]
    shapes = [
        shapely.LineString(_closed(pixels_of(item.points, found.picture), item.form == "ring"))
        for item in items
    ]
    frame = shapely.box(0.0, 0.0, found.picture.width, found.picture.height)
    tree = shapely.STRtree(shapes)
    unchanged: dict[int, int] = {}
    # Lines with an id choose first: two features may lie at one place.
    ids = {item.id for item in items}
    for i in sorted(range(len(drawn)), key=lambda i: found.lines[i].id not in ids):
        near = tree.query(drawn[i], predicate="dwithin", distance=MAX_ROUNDING_PX)
        same = [int(j) for j in near if _is_same(drawn[i], shapes[j], frame)]
        own = [j for j in same if items[j].id == found.lines[i].id]
        free = [j for j in same if j not in unchanged.values()]
        if same:
            unchanged[i] = (own or free or same)[0]
    used = {items[j].id for j in unchanged.values()}
    comparisons = []
    for i, line in enumerate(found.lines):
        if i in unchanged:
            comparisons.append(Comparison("unchanged", items[unchanged[i]].id))
        elif line.id in ids and line.id not in used:
            used.add(line.id)
            comparisons.append(Comparison("edited", line.id))
        else:
            comparisons.append(Comparison("new"))
    return comparisons


def pixels_of(points: FloatArray, picture: Picture) -> FloatArray:
    """Return the pixels (n, 2) of World points (n, 3)."""
    to_pixels = np.linalg.inv(np.array(picture.matrix))
    return np.asarray((points @ to_pixels[:3, :3].T + to_pixels[:3, 3])[:, :2])


def merge_vertices(
    drawn_px: FloatArray,
    brought: Sequence[FloatArray | None],
    stored_px: FloatArray,
    stored: FloatArray,
) -> FloatArray:
    """Return the vertices of an edited line; those that were not moved keep their coordinates.

    Parameters
    ----------
    drawn_px : (m, 2) float64
        Vertices of the drawing.
    brought : sequence of m (3,) arrays or None
        The same on the surface that the picture shows, None if they meet none.
    stored_px, stored : (k, 2) and (k, 3) float64
        Vertices of the feature, in pixels and as stored.
    """
    vertices = []
    for pixel, point in zip(drawn_px, brought, strict=True):
        distances = np.linalg.norm(stored_px - pixel, axis=1)
        nearest = int(np.argmin(distances))
        if distances[nearest] <= MAX_ROUNDING_PX:
            vertices.append(stored[nearest])
        elif point is not None:
            vertices.append(point)
    return np.array(vertices, np.float64).reshape(-1, 3)


def _closed(pixels: FloatArray, is_ring: bool) -> FloatArray:
    return np.vstack([pixels, pixels[:1]]) if is_ring else pixels


def _is_same(line: Any, feature: Any, frame: Any) -> bool:
    """Return whether a line is a feature, or the part of it within the picture."""
    import shapely

    shapes = (feature, shapely.intersection(feature, frame))
    return any(
        not shapely.is_empty(shape) and shapely.hausdorff_distance(line, shape) <= MAX_ROUNDING_PX
        for shape in shapes
    )
