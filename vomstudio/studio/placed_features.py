"""Features from points in the file frame of a model, for commands and scripts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.matrices import Point
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import FeatureType, Model
from vomstudio.studio.drawn_traces import create_trace
from vomstudio.studio.tools.brush_stroke import patch_fields
from vomstudio.studio.tools.element_preview import empty_patch

PickedShape = Literal["trace", "line", "patch"]
SHAPE_NOUNS: dict[PickedShape, str] = {"trace": "traces", "line": "lines", "patch": "patches"}
"""Words of the labels of edits."""
MIN_LINE_POINTS = 2
MIN_OUTLINE_POINTS = 3
BLOCK_SIZE = 1_000_000


def create_feature(
    shape: PickedShape,
    points: FloatArray,
    model: Model,
    kind: FeatureType,
    surface: SelectableSurface | None,
) -> Trace | Lineation | Contact | Patch:
    """Create a feature from its points.

    Parameters
    ----------
    shape : {"trace", "line", "patch"}
        Geometry of the points: a trace, a line (see `create_line`), or the outline of a patch.
    points : (n, 3) float64
        Points in the file frame of the model.
    model : Model
    kind : FeatureType
    surface : SelectableSurface or None
        Surface of the model, which a patch requires.

    Raises
    ------
    GeometryError
        If the points do not define a feature of this shape.
    """
    if shape == "trace":
        return create_trace("", points, model, kind.id, "", surface)
    if shape == "line":
        return create_line(points, model, kind, surface)
    assert surface is not None
    return create_patch(elements_inside(surface, points), model, kind, surface)


def create_line(
    points: FloatArray, model: Model, kind: FeatureType, surface: SelectableSurface | None
) -> Lineation | Contact:
    """Create a lineation if the features of the type are lines, otherwise a contact line.

    Parameters
    ----------
    points : (n, 3) float64
        Points in the file frame of the model, n >= 2.
    model : Model
    kind : FeatureType
    surface : SelectableSurface or None
        Surface of the model, used for the resolution of a lineation.

    Raises
    ------
    GeometryError
        If there are fewer than two distinct points.
    """
    if len(points) < MIN_LINE_POINTS:
        count = MIN_LINE_POINTS - len(points)
        raise GeometryError(Finding("feature.too-few-points", count=count, minimum=MIN_LINE_POINTS))
    if not np.ptp(points, axis=0).any():
        raise GeometryError(Finding("points.coincident"))
    vertices = to_vertices(points)
    if kind.geometry == "plane":
        return Contact(new_id("contact"), "", kind.id, model.id, model.content_hash, vertices)
    return Lineation(
        new_id("line"),
        "",
        kind.id,
        model.id,
        model.content_hash,
        vertices,
        resolution=None if surface is None else surface.local_resolution(points),
    )


def create_patch(
    elements: IntArray, model: Model, kind: FeatureType, surface: SelectableSurface
) -> Patch:
    """Create a patch of faces or points of a model.

    Parameters
    ----------
    elements : (k,) int
        Sorted ids of the faces or points.
    model : Model
    kind : FeatureType
    surface : SelectableSurface
        Surface of the model.

    Raises
    ------
    GeometryError
        If `elements` is empty.
    """
    if not len(elements):
        raise GeometryError(Finding("patch.no-elements", model=model.name))
    patch = empty_patch(model, surface.element, kind.id)
    return patch.replace_fields(**patch_fields(surface, elements))


def elements_inside(surface: SelectableSurface, ring: FloatArray) -> IntArray:
    """Return the ids of the connected faces or points inside an outline.

    The outline is projected along its normal. A face is inside if its centroid is inside. Rock
    behind the outcrop face is left out because it is not connected to the face within the ball
    around the outline.

    Parameters
    ----------
    surface : SelectableSurface
    ring : (n, 3) float64
        Outline in the file frame of the model, n >= 3.

    Raises
    ------
    GeometryError
        If there are fewer than three points, or the outline has no area or crosses itself.
    """
    import shapely

    if len(ring) < MIN_OUTLINE_POINTS:
        count = MIN_OUTLINE_POINTS - len(ring)
        raise GeometryError(
            Finding("feature.too-few-points", count=count, minimum=MIN_OUTLINE_POINTS)
        )
    centre = ring.mean(axis=0)
    axes = np.linalg.svd(ring - centre)[2][:2]
    polygon = shapely.Polygon((ring - centre) @ axes.T)
    if not polygon.area > 0.0:
        raise GeometryError(Finding("tool.no-area"))
    if not polygon.is_valid:
        raise GeometryError(Finding("patch.crossing-outline"))
    shapely.prepare(polygon)
    radius = float(np.linalg.norm(ring - centre, axis=1).max())
    candidates = _elements_in_ball(surface, centre, radius)
    offsets = _element_positions(surface, candidates) - centre
    is_inside = np.asarray(shapely.contains_xy(polygon, *(offsets @ axes.T).T))
    candidates, offsets = candidates[is_inside], offsets[is_inside]
    if not len(candidates):
        return np.asarray(candidates, np.int64)
    # The face nearest to the plane of the outline is the one on which it was drawn.
    normal = np.cross(*axes)
    seed = int(candidates[np.argmin(np.abs(offsets @ normal))])
    return np.intersect1d(surface.connected_ids_in_ball(seed, centre, radius), candidates)


def _elements_in_ball(surface: SelectableSurface, centre: FloatArray, radius: float) -> IntArray:
    blocks = []
    for start in range(0, surface.count, BLOCK_SIZE):
        ids = np.arange(start, min(start + BLOCK_SIZE, surface.count), dtype=np.int64)
        is_near = np.linalg.norm(_element_positions(surface, ids) - centre, axis=1) <= radius
        blocks.append(ids[is_near])
    return np.concatenate(blocks) if blocks else np.empty(0, np.int64)


def _element_positions(surface: SelectableSurface, ids: IntArray) -> FloatArray:
    """Return the centroids (k, 3) of faces, or the points (k, 3)."""
    corners = surface.corners(ids)
    return corners if surface.element == "point" else corners.mean(axis=1)


def to_vertices(points: FloatArray) -> tuple[Point, ...]:
    """Convert points to the vertices of a record.

    Parameters
    ----------
    points : (n, 3) float64

    Returns
    -------
    tuple of Point
    """
    return tuple((x, y, z) for x, y, z in points.tolist())
