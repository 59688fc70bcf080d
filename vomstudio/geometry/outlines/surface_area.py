"""Part of a surface inside an outline drawn on the surface, and its area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.geometry.coincident_points import weld_points

if TYPE_CHECKING:
    import shapely


N_CELLS = 256
"""Number of cells along the longer side; most faces are entirely in inner or outer cells."""
N_SEEDS = 64
"""Number of points of the outline at which the surface below it is searched."""


@dataclass(frozen=True, eq=False)
class _EnclosedTriangles:
    """Triangles and the share of each inside an outline.

    The fields are the triangles (k, 3, 3), their projection (k, 3, 2) along the normal of the
    outline, the share (k,) of each triangle inside the outline, and the projected outline.
    """

    faces: FloatArray
    projected_faces: FloatArray
    share: FloatArray
    polygon: shapely.Polygon


def area_inside(corners: npt.ArrayLike, ring: npt.ArrayLike) -> float | None:
    """Compute the area of the part of a triangulated surface inside an outline.

    The outline is projected along its normal, the direction in which its area is largest. Faces
    that the outline cuts count partially. Only faces connected to the outline count, so a wall
    behind the surface is excluded.

    Parameters
    ----------
    corners : (m, 3, 3) array_like
        Triangles around the outline.
    ring : (n, 3) array_like
        Points of the outline on the surface; the first point is not repeated.

    Returns
    -------
    float or None
        Area in squared length units, or None if the outline has no area, encloses no surface or
        crosses itself.
    """
    enclosed_triangles = _find_enclosed_triangles(corners, ring)
    if enclosed_triangles is None:
        return None
    edges = enclosed_triangles.faces[:, 1:] - enclosed_triangles.faces[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return float((areas * enclosed_triangles.share).sum())


def clip_to_outline(corners: npt.ArrayLike, ring: npt.ArrayLike) -> FloatArray | None:
    """Return the part of a surface inside an outline, cut at the outline.

    Parameters
    ----------
    corners, ring : array_like
        See `area_inside`.

    Returns
    -------
    (k, 3, 3) ndarray or None
        Triangles, or None under the conditions of `area_inside`.
    """
    enclosed_triangles = _find_enclosed_triangles(corners, ring)
    if enclosed_triangles is None:
        return None
    is_fully_enclosed = enclosed_triangles.share >= 1.0 - 1e-9
    return np.concatenate(
        [
            enclosed_triangles.faces[is_fully_enclosed],
            _clip_faces(
                enclosed_triangles.faces[~is_fully_enclosed],
                enclosed_triangles.projected_faces[~is_fully_enclosed],
                enclosed_triangles.polygon,
            ),
        ]
    )


def _clip_faces(
    faces: FloatArray, projected_faces: FloatArray, polygon: shapely.Polygon
) -> FloatArray:
    """Return triangles (p, 3, 3) of the parts of faces (k, 3, 3) inside the polygon."""
    import shapely

    faces, projected_faces = (
        faces[_has_projected_area(projected_faces)],
        projected_faces[_has_projected_area(projected_faces)],
    )
    parts = shapely.intersection(shapely.polygons(projected_faces), polygon)
    pieces, face_row = shapely.get_parts(
        shapely.constrained_delaunay_triangles(parts), return_index=True
    )
    if not len(pieces):
        return np.zeros((0, 3, 3))
    positions = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3]
    # Barycentric coordinates are invariant under the projection.
    a, u, v = (
        projected_faces[face_row, 0],
        projected_faces[face_row, 1] - projected_faces[face_row, 0],
        projected_faces[face_row, 2] - projected_faces[face_row, 0],
    )
    offsets = positions - a[:, None]
    double_area = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])[:, None]
    s = (offsets[..., 0] * v[:, None, 1] - offsets[..., 1] * v[:, None, 0]) / double_area
    t = (u[:, None, 0] * offsets[..., 1] - u[:, None, 1] * offsets[..., 0]) / double_area
    first, second = faces[face_row, 1] - faces[face_row, 0], faces[face_row, 2] - faces[face_row, 0]
    return np.asarray(
        faces[face_row, :1] + s[..., None] * first[:, None] + t[..., None] * second[:, None]
    )


def _find_enclosed_triangles(
    corners: npt.ArrayLike, ring: npt.ArrayLike
) -> _EnclosedTriangles | None:
    import shapely

    xyz = np.asarray(ring, np.float64).reshape(-1, 3)
    faces = np.asarray(corners, np.float64).reshape(-1, 3, 3)
    if len(xyz) < 3 or not len(faces):
        return None
    origin = xyz.mean(axis=0)
    axes = _axes(xyz - origin)
    if axes is None:
        return None
    outline = (xyz - origin) @ axes.T
    polygon = shapely.Polygon(outline[:, :2])
    if not polygon.is_valid:
        return None
    projected_faces = (faces - origin) @ axes.T
    low, high = outline[:, :2].min(axis=0), outline[:, :2].max(axis=0)
    projected_2d = projected_faces[:, :, :2]
    is_near = _intersects_box(projected_2d, low, high)
    faces, projected_faces = faces[is_near], projected_faces[is_near]
    if not len(faces):
        return None
    shares = _enclosed_shares(projected_faces[:, :, :2], polygon, low, high)
    has_share = shares > 0.0
    faces, projected_faces, shares = (
        faces[has_share],
        projected_faces[has_share],
        shares[has_share],
    )
    is_connected = _find_connected_faces(faces, _find_faces_below_outline(projected_faces, outline))
    if is_connected is None:
        return None
    return _EnclosedTriangles(
        faces[is_connected], projected_faces[is_connected, :, :2], shares[is_connected], polygon
    )


def _intersects_box(plane_corners: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Return a mask of the triangles (m, 3, 2) whose bounding boxes intersect the box."""
    is_near = np.ones(len(plane_corners), np.bool_)
    for axis in (0, 1):
        a, b, c = (plane_corners[:, corner, axis] for corner in range(3))
        # Reductions over short axes are ten times slower.
        is_near &= np.maximum(np.maximum(a, b), c) >= low[axis]
        is_near &= np.minimum(np.minimum(a, b), c) <= high[axis]
    return is_near


def _axes(local_points: FloatArray) -> FloatArray | None:
    """Return two in-plane axes and the normal of an outline, or None if it has no area."""
    normal = np.cross(local_points, np.roll(local_points, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(normal))
    if not size > 1e-12 * float((local_points**2).sum()):
        return None
    normal = normal / size
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(normal, u), normal])


def _enclosed_shares(
    plane_corners: FloatArray, polygon: shapely.Polygon, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the share (m,) of each triangle (m, 3, 2) inside the polygon."""
    import shapely

    step = float((high - low).max()) / N_CELLS
    count = np.maximum(np.ceil((high - low) / step).astype(int), 1) + 2
    start = low - step
    is_border = _is_border_cell(polygon, start, step, count)
    centre = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in count), indexing="ij"), axis=-1)
    positions = (start + step * centre).reshape(-1, 2)
    is_inside = shapely.contains_xy(polygon, positions[:, 0], positions[:, 1]).reshape(count)
    first_cell = np.clip(((plane_corners.min(axis=1) - start) / step).astype(int), 0, count - 1)
    last_cell = np.clip(((plane_corners.max(axis=1) - start) / step).astype(int), 0, count - 1)
    # A summed-area table gives the number of border cells in the box of each triangle.
    sums = np.zeros(count + 1, np.int64)
    sums[1:, 1:] = is_border.cumsum(axis=0).cumsum(axis=1)
    (x0, y0), (x1, y1) = first_cell.T, last_cell.T + 1
    is_crossed = sums[x1, y1] - sums[x0, y1] - sums[x1, y0] + sums[x0, y0] > 0
    shares = np.where(is_crossed, 0.0, is_inside[x0, y0].astype(np.float64))
    if is_crossed.any():
        shares[is_crossed] = _cut_shares(plane_corners[is_crossed], polygon)
    return shares


def _is_border_cell(
    polygon: shapely.Polygon, start: FloatArray, step: float, count: npt.NDArray[np.int_]
) -> BoolArray:
    """Mark cells that the outline crosses or touches."""
    ends = np.asarray(polygon.exterior.coords)[:, :2]
    segments = np.diff(ends, axis=0)
    n_steps = np.maximum(np.ceil(2.0 * np.linalg.norm(segments, axis=1) / step).astype(int), 1)
    segment = np.repeat(np.arange(len(segments)), n_steps)
    distances = (
        np.arange(len(segment)) - np.repeat(np.cumsum(n_steps) - n_steps, n_steps)
    ) / n_steps[segment]
    positions = ends[segment] + distances[:, None] * segments[segment]
    cells = np.clip(((positions - start) / step).astype(int), 1, count - 2)
    is_border = np.zeros(count, np.bool_)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            is_border[cells[:, 0] + dx, cells[:, 1] + dy] = True
    return is_border


def _cut_shares(plane_corners: FloatArray, polygon: shapely.Polygon) -> FloatArray:
    """Return the shares (k,) inside the outline of triangles that it may cross."""
    import shapely

    centre = plane_corners.mean(axis=1)
    # Triangles seen edge-on have no area, so their centre decides.
    shares: FloatArray = shapely.contains_xy(polygon, centre[:, 0], centre[:, 1]).astype(np.float64)
    has_area, area = _has_projected_area(plane_corners), _projected_areas(plane_corners)
    triangles = shapely.polygons(plane_corners[has_area])
    shares[has_area] = np.clip(
        shapely.area(shapely.intersection(triangles, polygon)) / area[has_area], 0, 1
    )
    return shares


def _projected_areas(plane_corners: FloatArray) -> FloatArray:
    """Return the areas of triangles (k, 3, 2)."""
    a, b = plane_corners[:, 1] - plane_corners[:, 0], plane_corners[:, 2] - plane_corners[:, 0]
    return np.asarray(0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))


def _has_projected_area(plane_corners: FloatArray) -> BoolArray:
    """Return whether triangles (k, 3, 2) are not edge-on."""
    squared_diagonal = (np.ptp(plane_corners, axis=1) ** 2).sum(axis=1)
    return np.asarray(_projected_areas(plane_corners) > 1e-9 * squared_diagonal)


def _find_faces_below_outline(projected_faces: FloatArray, outline: FloatArray) -> IntArray:
    """Return the rows of the triangles (m, 3, 3) nearest to points of the outline."""
    corners = [
        [np.ascontiguousarray(projected_faces[:, k, axis]) for k in range(3)] for axis in (0, 1)
    ]
    low = [np.minimum(np.minimum(a, b), c) for a, b, c in corners]
    high = [np.maximum(np.maximum(a, b), c) for a, b, c in corners]
    face_rows = []
    for point in outline[:: max(1, len(outline) // N_SEEDS)]:
        x, y = float(point[0]), float(point[1])
        is_covering = (low[0] <= x) & (high[0] >= x) & (low[1] <= y) & (high[1] >= y)
        rows = np.flatnonzero(is_covering)
        if not len(rows):
            continue
        distances = np.abs(_triangle_heights(projected_faces[rows], point[:2]) - point[2])
        face_rows.append(int(rows[int(np.argmin(distances))]))
    return np.array(sorted(set(face_rows)), np.int64)


def _triangle_heights(triangles: FloatArray, position: FloatArray) -> FloatArray:
    """Return the heights (k,) of triangles at a position; infinite outside a triangle."""
    a = triangles[:, 0]
    b, c, p = triangles[:, 1] - a, triangles[:, 2] - a, position - a[:, :2]
    double_area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (p[:, 0] * c[:, 1] - p[:, 1] * c[:, 0]) / double_area
        t = (b[:, 0] * p[:, 1] - b[:, 1] * p[:, 0]) / double_area
    heights = a[:, 2] + s * b[:, 2] + t * c[:, 2]
    is_outside = ~(np.isfinite(heights) & (s > -1e-6) & (t > -1e-6) & (s + t < 1.0 + 1e-6))
    return np.asarray(np.where(is_outside, np.inf, heights), np.float64)


def _find_connected_faces(faces: FloatArray, seeds: IntArray) -> BoolArray | None:
    """Return a mask of the faces (k, 3, 3) connected to a seed through shared vertices.

    Return None if there are no seeds.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    if not len(seeds):
        return None
    k = len(faces)
    nodes = weld_points(faces.reshape(-1, 3))
    size = k + int(nodes.max()) + 1
    starts = np.full(size + 1, 3 * k, np.int64)
    starts[: k + 1] = np.arange(0, 3 * k + 1, 3)
    graph = csr_array((np.ones(3 * k), nodes + k, starts), (size, size))
    label = connected_components(graph, directed=False)[1][:k]
    return np.asarray(np.isin(label, label[seeds]))
