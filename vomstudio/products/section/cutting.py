"""Where a section meets a surface: exact lines on a mesh, and the trend of points beside it of a
cloud."""

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

JOINED = 1e-6
"""Ends of lines this near to each other are one place, metres."""
LINK_STEPS = 8.0
"""Points of a cloud are linked over so many steps at most."""
SLAB_SPACINGS = 4.0
FEWEST_POINTS = 3
NEIGHBOURS = 24
"""Points that tell the local plane of one of a cloud."""
PLANAR = 0.1
"""Their least variance by the one before it, at most, where they lie in a plane."""
STEEPEST = 2.0
"""A point moves along its local plane by so many times its distance from the section at most."""


@dataclass(frozen=True, eq=False)
class Cut:
    """What a section shows. lines : each (n, 2) distance along the section and height in it; world
    : the same points, each (n, 3); slab_m : thickness of the slab whose points of a cloud were
    taken, None for a mesh; points : how many those were"""

    lines: tuple[FloatArray, ...]
    world: tuple[FloatArray, ...]
    slab_m: float | None = None
    points: int | None = None

    @property
    def length_m(self) -> float:
        """Of all lines together."""
        return float(
            sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in self.world)
        )


def cut_model(
    data: Mesh | PointCloud,
    curtain: Curtain,
    slab: float | None = None,
    spacing: float | None = None,
) -> Cut:
    """Cut a model of World.

    Parameters
    ----------
    slab : float, optional
        Thickness for a cloud, metres; SLAB_SPACINGS times `spacing` if omitted.
    spacing : float, optional
        Mean distance of neighbouring points of a cloud, metres; estimated if omitted.

    Raises
    ------
    UsageError
        For a slab of a mesh.
    """
    if isinstance(data, Mesh):
        if slab is not None:
            raise UsageError(Finding("option.clouds-only", option="--slab"), field="--slab")
        pieces = [_cut_mesh(data, panel) for panel in curtain.panels]
        return _joined(np.concatenate(pieces), curtain)
    if spacing is None:
        estimate = point_spacing(data)
        spacing = estimate if np.isfinite(estimate) else 0.0
    thick = SLAB_SPACINGS * spacing if slab is None else slab
    parts = [_slab(data.points, panel, thick) for panel in curtain.panels]
    points = np.concatenate(parts)
    lines = _linked(points, max(spacing, 1e-12))
    world = tuple(_in_world(line, curtain) for line in lines)
    return Cut(tuple(lines), world, thick, len(points))


def _cut_mesh(mesh: Mesh, panel: Panel) -> FloatArray:
    """(n, 2, 2) pieces, one for each triangle that is met: distance along and height of both ends.

    A corner on the plane itself counts as on the viewer's side, so that every triangle has two
    crossed edges or none and neighbours agree on them.
    """
    # Far from zero only differences have the digits.
    side = (mesh.vertices - panel.origin) @ panel.normal >= 0
    corners = side[mesh.faces]
    met = np.flatnonzero(corners.any(axis=1) & ~corners.all(axis=1))
    faces, corners = mesh.faces[met], corners[met]
    # The corner that is alone on its side, then the two others.
    alone = np.where(
        corners[:, 0] == corners[:, 1], 2, np.where(corners[:, 0] == corners[:, 2], 1, 0)
    )
    rows = np.arange(len(faces))
    tip = faces[rows, alone]
    ends = [
        _crossing(mesh.vertices, tip, faces[rows, (alone + k) % 3], side, panel) for k in (1, 2)
    ]
    pieces = np.stack(ends, axis=1)
    return _within(pieces, panel)


def _crossing(
    vertices: FloatArray,
    a: Int32Array,
    b: Int32Array,
    side: BoolArray,
    panel: Panel,
) -> FloatArray:
    """(n, 2) where edges cross the plane. Always reckoned from the viewer's side, so that triangles
    on both sides of an edge find the same to the bit, corners that stand twice included."""
    first, second = np.where(side[a], a, b), np.where(side[a], b, a)
    p, q = (panel.coordinates(vertices[k]) for k in (first, second))
    share = p[:, 2] / (p[:, 2] - q[:, 2])
    return np.asarray(p[:, :2] + share[:, None] * (q[:, :2] - p[:, :2]))


def _within(pieces: FloatArray, panel: Panel) -> FloatArray:
    """What of pieces (n, 2, 2) lies on the panel, cut off at its ends."""
    low, high = panel.start + panel.low, panel.start + panel.high
    first, last = pieces[:, :, 0].min(axis=1), pieces[:, :, 0].max(axis=1)
    pieces = pieces[(last >= low) & (first <= high)]
    if not np.isfinite(low) or not len(pieces):
        return pieces
    a, b = pieces[:, 0], pieces[:, 1]
    step = b - a
    cut = pieces.copy()
    for limit, beyond in ((low, np.less), (high, np.greater)):
        for k, end in enumerate((a, b)):
            off = beyond(end[:, 0], limit)
            share = (limit - a[off, 0]) / step[off, 0]
            cut[off, k] = np.stack(
                [np.full(len(share), limit), a[off, 1] + share * step[off, 1]], 1
            )
    return cut


def _joined(pieces: FloatArray, curtain: Curtain) -> Cut:
    """Pieces that share their ends as lines."""
    import shapely

    # Beside a bend of the section both panels find the same end but for rounding.
    pieces = np.round(pieces / JOINED) * JOINED if len(curtain.panels) > 1 else pieces
    pieces = pieces[(pieces[:, 0] != pieces[:, 1]).any(axis=1)]
    if not len(pieces):
        return Cut((), ())
    # The same piece twice: of faces that stand twice, or an edge that lies on the plane.
    swapped = pieces[:, 0, 0] > pieces[:, 1, 0]
    swapped |= (pieces[:, 0, 0] == pieces[:, 1, 0]) & (pieces[:, 0, 1] > pieces[:, 1, 1])
    pieces[swapped] = pieces[swapped][:, ::-1]
    pieces = np.unique(pieces, axis=0)
    merged = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(pieces)))
    parts = shapely.get_parts(merged)
    lines = [np.asarray(shapely.get_coordinates(part), np.float64) for part in parts]
    lines = [line if line[0, 0] <= line[-1, 0] else line[::-1] for line in lines]
    lines.sort(key=lambda line: (float(line[:, 0].min()), float(line[0, 1])))
    return Cut(tuple(lines), tuple(_in_world(line, curtain) for line in lines))


def _in_world(line: FloatArray, curtain: Curtain) -> FloatArray:
    panels = curtain.panels
    starts = np.array([panel.start for panel in panels[1:]])
    which = np.searchsorted(starts, line[:, 0], side="right")
    found = np.empty((len(line), 3))
    for k in np.unique(which):
        rows = which == k
        found[rows] = panels[k].world(line[rows, 0], line[rows, 1])
    return found


def _slab(points: FloatArray, panel: Panel, thick: float) -> FloatArray:
    """(n, 2) points within half the thickness of the panel, brought onto it along the surface."""
    at = panel.coordinates(points)
    along = (at[:, 0] >= panel.start + panel.low) & (at[:, 0] <= panel.start + panel.high)
    near = along & (np.abs(at[:, 2]) <= 0.5 * thick)
    around = np.abs(at[:, 2]) <= thick
    return np.ascontiguousarray(_slid(at[near], at[around]))


def _slid(at: FloatArray, around: FloatArray) -> FloatArray:
    """(n, 2) where the local planes of points (along, height, across) meet the panel. At right
    angles the points of a surface that slants across the panel would be a band, and the line
    through them a zigzag; so would their noise. Those without a plane, or whose plane runs nearly
    along the panel, are projected at right angles."""
    from scipy.spatial import cKDTree

    if len(around) < NEIGHBOURS:
        return at[:, :2]
    _, rows = cKDTree(around).query(at, NEIGHBOURS)
    middle = around[rows].mean(axis=1)
    beside = around[rows] - middle[:, None]
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", beside, beside))
    normal = axes[:, :, 0]
    free = np.maximum(1.0 - normal[:, 2] ** 2, 1e-12)
    planar = values[:, 0] <= PLANAR * values[:, 1]
    planar &= normal[:, 2] ** 2 <= STEEPEST**2 * free
    # The point goes onto its plane at right angles, then in the plane to the panel.
    off = np.einsum("ni,ni->n", at - middle, normal)
    on_plane = at - off[:, None] * normal
    met = on_plane[:, :2] + (on_plane[:, 2] * normal[:, 2] / free)[:, None] * normal[:, :2]
    return np.where(planar[:, None], met, at[:, :2])


def _linked(points: FloatArray, spacing: float) -> list[FloatArray]:
    """Lines through points: the mean of those in each cell of one spacing, linked by their shortest
    spanning tree without links over LINK_STEPS spacings, of each tree its longest way."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
    from scipy.spatial import cKDTree

    if len(points) < FEWEST_POINTS:
        return []
    cells = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64)
    _, where = np.unique(cells, axis=0, return_inverse=True)
    where = where.ravel()
    counts = np.bincount(where)
    middle = np.stack([np.bincount(where, points[:, k]) / counts for k in (0, 1)], axis=1)
    pairs = cKDTree(middle).query_pairs(LINK_STEPS * spacing, output_type="ndarray")
    if not len(pairs):
        return []
    lengths = np.linalg.norm(middle[pairs[:, 0]] - middle[pairs[:, 1]], axis=1)
    n = len(middle)
    tree = minimum_spanning_tree(coo_matrix((lengths, tuple(pairs.T)), (n, n)).tocsr())
    count, label = connected_components(tree, directed=False)
    lines = []
    for k in range(count):
        rows = np.flatnonzero(label == k)
        if len(rows) >= FEWEST_POINTS:
            line = middle[rows][_longest_way(tree[rows][:, rows])]
            lines.append(line if line[0, 0] <= line[-1, 0] else line[::-1])
    return sorted(lines, key=lambda line: float(line[0, 0]))


def _longest_way(tree: object) -> list[int]:
    """Rows along the longest way in a tree: from any row to the farthest, from there to the
    farthest."""
    from scipy.sparse.csgraph import dijkstra

    far = int(np.argmax(dijkstra(tree, directed=False, indices=0)))
    away, before = dijkstra(tree, directed=False, indices=far, return_predecessors=True)
    at = int(np.argmax(away))
    way = [at]
    while at != far:
        at = int(before[at])
        way.append(at)
    return way
