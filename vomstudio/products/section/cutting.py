"""Intersection of a section with a mesh (exact) or a cloud (trend of nearby points)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import point_spacing
from vomstudio.products.section.section_lines import Curtain, Panel

JOIN_TOLERANCE_M = 1e-6
"""Maximum distance in metres at which the ends of two lines are joined."""
MAX_LINK_SPACINGS = 8.0
"""Maximum length of a link between points of a cloud, in spacings."""
SLAB_SPACINGS = 4.0
MIN_POINTS = 3
N_NEIGHBOURS = 24
"""Number of points to which a local plane of a cloud is fitted."""
MAX_PLANARITY_RATIO = 0.1
"""Maximum ratio of the smallest to the middle variance of points on a plane."""
MAX_SHIFT_RATIO = 2.0
"""Maximum shift of a point in its local plane, as a multiple of its distance to the section."""


@dataclass(frozen=True, eq=False)
class Cut:
    """Lines along which a section intersects a surface.

    Parameters
    ----------
    lines : tuple of (n, 2) arrays
        Distance along the section, and height in it, m.
    world : tuple of (n, 3) arrays
        The same points in the World frame, m.
    slab_m : float or None
        Thickness of the slab of points used from a cloud; None for a mesh.
    points : int or None
        Number of points in this slab; None for a mesh.
    """

    lines: tuple[FloatArray, ...]
    world: tuple[FloatArray, ...]
    slab_m: float | None = None
    points: int | None = None

    @property
    def length_m(self) -> float:
        """Total length of all lines in metres."""
        return float(
            sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in self.world)
        )


def cut_model(
    data: Mesh | PointCloud,
    curtain: Curtain,
    slab: float | None = None,
    spacing: float | None = None,
) -> Cut:
    """Intersect a model with a section.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    curtain : Curtain
    slab : float, optional
        Thickness of the slab of points used from a cloud, m. If omitted, `SLAB_SPACINGS` times
        `spacing`.
    spacing : float, optional
        Mean distance between neighbouring points of a cloud, m. If omitted, it is estimated.

    Returns
    -------
    Cut

    Raises
    ------
    UsageError
        If a slab is given for a mesh.
    """
    if isinstance(data, Mesh):
        if slab is not None:
            raise UsageError(Finding("option.clouds-only", option="--slab"), field="--slab")
        pieces = [_cut_mesh(data, panel) for panel in curtain.panels]
        return _merge_pieces(np.concatenate(pieces), curtain)
    if spacing is None:
        estimate = point_spacing(data)
        spacing = estimate if np.isfinite(estimate) else 0.0
    slab_thickness = SLAB_SPACINGS * spacing if slab is None else slab
    parts = [_project_slab(data.points, panel, slab_thickness) for panel in curtain.panels]
    points = np.concatenate(parts)
    lines = _link_points(points, max(spacing, 1e-12))
    world = tuple(_to_world(line, curtain) for line in lines)
    return Cut(tuple(lines), world, slab_thickness, len(points))


def _cut_mesh(mesh: Mesh, panel: Panel) -> FloatArray:
    """Return the segments (n, 2, 2) in which triangles intersect a panel.

    Each segment contains the distance and the height of both ends. A corner on the plane is
    assigned to the viewer's side, so that every triangle has either two crossed edges or none,
    consistently with its neighbours.
    """
    # Far from the origin, only differences of coordinates are precise.
    side = (mesh.vertices - panel.origin) @ panel.normal >= 0
    tip, *others = crossed_edges(mesh, side)
    ends = [_edge_crossings(mesh.vertices, tip, other, side, panel) for other in others]
    return _clip(np.stack(ends, axis=1), panel)


def crossed_edges(mesh: Mesh, side: BoolArray) -> tuple[Int32Array, Int32Array, Int32Array]:
    """Return the corners of the triangles that have corners on both sides of a surface.

    Parameters
    ----------
    mesh : Mesh
    side : (vertices,) array
        Side of each vertex.

    Returns
    -------
    tip : (n,) array
        Vertex that is alone on its side.
    first, second : (n,) array
        The other vertices.
    """
    corners = side[mesh.faces]
    intersected_rows = np.flatnonzero(corners.any(axis=1) & ~corners.all(axis=1))
    faces, corners = mesh.faces[intersected_rows], corners[intersected_rows]
    single_corner = np.where(
        corners[:, 0] == corners[:, 1], 2, np.where(corners[:, 0] == corners[:, 2], 1, 0)
    )
    rows = np.arange(len(faces))
    tip, first, second = (faces[rows, (single_corner + k) % 3] for k in range(3))
    return tip, first, second


def _edge_crossings(
    vertices: FloatArray,
    a: Int32Array,
    b: Int32Array,
    is_front: BoolArray,
    panel: Panel,
) -> FloatArray:
    """Return the points (n, 2) where edges cross the plane.

    They are interpolated starting from the viewer's side, so that both triangles of an edge give
    identical results.
    """
    upper_corner, lower_corner = np.where(is_front[a], a, b), np.where(is_front[a], b, a)
    p, q = (panel.coordinates(vertices[k]) for k in (upper_corner, lower_corner))
    fraction = p[:, 2] / (p[:, 2] - q[:, 2])
    return np.asarray(p[:, :2] + fraction[:, None] * (q[:, :2] - p[:, :2]))


def _clip(pieces: FloatArray, panel: Panel) -> FloatArray:
    """Clip segments (n, 2, 2) to the ends of a panel."""
    low, high = panel.start + panel.low, panel.start + panel.high
    first_end, last_end = pieces[:, :, 0].min(axis=1), pieces[:, :, 0].max(axis=1)
    pieces = pieces[(last_end >= low) & (first_end <= high)]
    if not np.isfinite(low) or not len(pieces):
        return pieces
    a, b = pieces[:, 0], pieces[:, 1]
    step = b - a
    cut = pieces.copy()
    for limit, is_outside in ((low, np.less), (high, np.greater)):
        for k, end in enumerate((a, b)):
            is_beyond = is_outside(end[:, 0], limit)
            fraction = (limit - a[is_beyond, 0]) / step[is_beyond, 0]
            cut[is_beyond, k] = np.stack(
                [np.full(len(fraction), limit), a[is_beyond, 1] + fraction * step[is_beyond, 1]], 1
            )
    return cut


def _merge_pieces(pieces: FloatArray, curtain: Curtain) -> Cut:
    """Merge segments that share ends into lines."""
    import shapely

    # At a bend of the section, the ends on the two panels differ by rounding errors.
    pieces = (
        np.round(pieces / JOIN_TOLERANCE_M) * JOIN_TOLERANCE_M
        if len(curtain.panels) > 1
        else pieces
    )
    pieces = pieces[(pieces[:, 0] != pieces[:, 1]).any(axis=1)]
    if not len(pieces):
        return Cut((), ())
    # Remove duplicates due to coincident faces or to an edge that lies in the plane.
    is_swapped = pieces[:, 0, 0] > pieces[:, 1, 0]
    is_swapped |= (pieces[:, 0, 0] == pieces[:, 1, 0]) & (pieces[:, 0, 1] > pieces[:, 1, 1])
    pieces[is_swapped] = pieces[is_swapped][:, ::-1]
    pieces = np.unique(pieces, axis=0)
    merged_lines = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(pieces)))
    parts = shapely.get_parts(merged_lines)
    lines = [np.asarray(shapely.get_coordinates(part), np.float64) for part in parts]
    lines = [line if line[0, 0] <= line[-1, 0] else line[::-1] for line in lines]
    lines.sort(key=lambda line: (float(line[:, 0].min()), float(line[0, 1])))
    return Cut(tuple(lines), tuple(_to_world(line, curtain) for line in lines))


def _to_world(line: FloatArray, curtain: Curtain) -> FloatArray:
    panels = curtain.panels
    starts = np.array([panel.start for panel in panels[1:]])
    panel_rows = np.searchsorted(starts, line[:, 0], side="right")
    points = np.empty((len(line), 3))
    for k in np.unique(panel_rows):
        rows = panel_rows == k
        points[rows] = panels[k].world(line[rows, 0], line[rows, 1])
    return points


def _project_slab(points: FloatArray, panel: Panel, thickness: float) -> FloatArray:
    """Project the points in a slab onto the panel along the surface, and return them (n, 2)."""
    position = panel.coordinates(points)
    is_within_panel = (position[:, 0] >= panel.start + panel.low) & (
        position[:, 0] <= panel.start + panel.high
    )
    is_near = is_within_panel & (np.abs(position[:, 2]) <= 0.5 * thickness)
    is_around = np.abs(position[:, 2]) <= thickness
    return np.ascontiguousarray(_slide_to_panel(position[is_near], position[is_around]))


def _slide_to_panel(position: FloatArray, surrounding_points: FloatArray) -> FloatArray:
    """Slide points (along, height, across) within their local planes to the panel (n, 2).

    A perpendicular projection would spread a surface that is oblique to the panel into a band, and
    the line through its points would become a zigzag. It is used only for points that have no local
    plane, or whose plane is nearly parallel to the panel.
    """
    from scipy.spatial import cKDTree

    if len(surrounding_points) < N_NEIGHBOURS:
        return position[:, :2]
    _, rows = cKDTree(surrounding_points).query(position, N_NEIGHBOURS)
    centre = surrounding_points[rows].mean(axis=1)
    offsets = surrounding_points[rows] - centre[:, None]
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    normal = axes[:, :, 0]
    horizontal_squares = np.maximum(1.0 - normal[:, 2] ** 2, 1e-12)
    is_planar = values[:, 0] <= MAX_PLANARITY_RATIO * values[:, 1]
    is_planar &= normal[:, 2] ** 2 <= MAX_SHIFT_RATIO**2 * horizontal_squares
    # Move the point perpendicularly onto its plane, then within the plane to the panel.
    distance = np.einsum("ni,ni->n", position - centre, normal)
    projected_position = position - distance[:, None] * normal
    crossing = (
        projected_position[:, :2]
        + (projected_position[:, 2] * normal[:, 2] / horizontal_squares)[:, None] * normal[:, :2]
    )
    return np.where(is_planar[:, None], crossing, position[:, :2])


def _link_points(points: FloatArray, spacing: float) -> list[FloatArray]:
    """Connect points into lines.

    Points are averaged in cells of one spacing. The means are linked by minimum spanning trees
    whose links are at most `MAX_LINK_SPACINGS` spacings long, and the longest path of each tree is
    returned.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
    from scipy.spatial import cKDTree

    if len(points) < MIN_POINTS:
        return []
    cells = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64)
    _, cell_ids = np.unique(cells, axis=0, return_inverse=True)
    cell_ids = cell_ids.ravel()
    counts = np.bincount(cell_ids)
    centres = np.stack([np.bincount(cell_ids, points[:, k]) / counts for k in (0, 1)], axis=1)
    pairs = cKDTree(centres).query_pairs(MAX_LINK_SPACINGS * spacing, output_type="ndarray")
    if not len(pairs):
        return []
    lengths = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
    n = len(centres)
    tree = minimum_spanning_tree(coo_matrix((lengths, tuple(pairs.T)), (n, n)).tocsr())
    count, label = connected_components(tree, directed=False)
    lines = []
    for k in range(count):
        rows = np.flatnonzero(label == k)
        if len(rows) >= MIN_POINTS:
            line = centres[rows][_longest_path(tree[rows][:, rows])]
            lines.append(line if line[0, 0] <= line[-1, 0] else line[::-1])
    return sorted(lines, key=lambda line: float(line[0, 0]))


def _longest_path(tree: object) -> list[int]:
    """Return the rows along the longest path in a tree, found by two farthest-node searches."""
    from scipy.sparse.csgraph import dijkstra

    farthest_node = int(np.argmax(dijkstra(tree, directed=False, indices=0)))
    distance, predecessors = dijkstra(
        tree, directed=False, indices=farthest_node, return_predecessors=True
    )
    index = int(np.argmax(distance))
    path = [index]
    while index != farthest_node:
        index = int(predecessors[index])
        path.append(index)
    return path
