"""The pieces of a surface that facets are made of: faces of a mesh, points of a cloud, with their
neighbours, normals, areas and the resolution around them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.extraction.kernels import agreement, local_planes, smoothed
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import in_blocks
from vomstudio.progress import Progress
from vomstudio.words import tr

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Rows = npt.NDArray[np.int32]

NEIGHBOURS = 12
"""Of a point of a cloud, that it hands a facet on to."""
_AROUND = (16, 32, 64, 96)
"""Points from which a normal is taken; more where noise makes neighbours' normals differ."""
_SMOOTHINGS = 12
_QUIET = 0.25
"""Of the angle: neighbouring normals may differ by so much at the median."""
_TRIED = 20_000
_BLOCK = 50_000
_WRONG_NORMALS_DEG = 30.0
# A point whose neighbours lie much farther from it than theirs from them is no piece of a surface.
_LONELY = 2.0


@dataclass(frozen=True, eq=False)
class Elements:
    """n pieces of a surface; lengths in the unit of World.

    of : what they are; origin : (3,) that is to be added to all places
    places : (n, 3) from the origin on; normals : (n, 3) unit, of either side, NaN where none
    areas : (n,) each stands for; inner : (n, 6) second moments of each about its place, over its
        area (xx, yy, zz, xy, xz, yz), or one row of zeros for all
    variation : (n,) surface variation, 0 for flat, 1/3 for no surface; NaN where unknown
    spacing, noise : (n,) mean spacing of the model's points around, and of their scatter about the
        surface
    starts, near : the neighbours of e are near[starts[e]:starts[e + 1]]
    rows : (n,) of the model's faces or points, which stand behind them
    row_of : (rows of the model,) the element of each face or point, -1 for none
    """

    of: Literal["face", "point"]
    origin: Array
    places: Array
    normals: Array
    areas: Array
    inner: Array
    variation: Array
    spacing: Array
    noise: Array
    starts: Ints
    near: Rows
    rows: Ints
    row_of: Ints
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.places)


def elements_of(data: Mesh | PointCloud, angle_deg: float, progress: Progress) -> Elements:
    """Of a model in World. angle_deg : by which normals may differ on one facet; they are taken
    from as much of the surface as their noise needs. Raises GeometryError where there is no
    surface, Cancelled through `progress`."""
    if isinstance(data, Mesh) and len(data.faces):
        return _of_mesh(data, angle_deg, progress)
    points = data.vertices if isinstance(data, Mesh) else data.points
    normals = None if isinstance(data, Mesh) else data.normals
    return _of_cloud(points, normals, angle_deg, progress)


# --- clouds -----------------------------------------------------------------------------------
def _of_cloud(
    points: Array, given: npt.NDArray[np.float32] | None, angle_deg: float, progress: Progress
) -> Elements:
    from scipy.spatial import cKDTree

    sound = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(sound) < 4:
        raise GeometryError(tr("A cloud of {count} points has no facets.", count=len(sound)))
    origin = np.floor(points[sound].min(axis=0))
    local = points[sound] - origin
    which = welded(local)
    # One point of each place, in an order in which neighbours are near each other in memory.
    first = np.full(int(which.max()) + 1, -1, np.int64)
    first[which[::-1]] = np.arange(len(which))[::-1]
    order = _along_cells(local[first])
    places = for_kernels(local[first[order]], np.float64)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    row_of = np.full(len(points), -1, np.int64)
    row_of[sound] = rank[which]
    if len(places) < 4:
        raise GeometryError(tr("A cloud of {count} points has no facets.", count=len(places)))

    progress.stage(tr("Finding neighbours"), None)
    tree = cKDTree(places, leafsize=16, compact_nodes=False, balanced_tree=False)
    around = _wanted_neighbours(tree, places, angle_deg)
    n, kept = len(places), min(NEIGHBOURS, len(places) - 1)
    near = np.empty((n, kept), np.int32)
    normals, variation, far = np.empty((n, 3)), np.empty(n), np.empty(n)
    progress.stage(tr("Normals"), n)

    def work(block: slice) -> None:
        distance, rows = tree.query(places[block], k=around)
        own = np.ascontiguousarray(rows, np.int32)
        found = np.empty((len(own), 3)), np.empty(len(own))
        local_planes(places, for_kernels(places[block], np.float64), own, *found)
        normals[block], variation[block] = found
        near[block] = own[:, 1 : kept + 1]
        far[block] = distance[:, kept]

    in_blocks(work, n, progress, _BLOCK)
    usual = np.median(far[near], axis=1)
    reached = np.minimum(far, _LONELY * usual)
    areas = np.pi * reached**2 / kept
    said: list[str] = []
    if given is not None:
        normals = _given_or(np.asarray(given, np.float64)[sound[first[order]]], normals, said)
    # Of a disc of area A the variance along each diameter is A / (4 pi).
    noise = np.sqrt(np.maximum(variation, 0.0) * around * areas / (2.0 * np.pi))
    lonely = far > 2.0 * _LONELY * usual
    normals[lonely] = np.nan
    return Elements(
        "point",
        origin,
        places,
        for_kernels(normals, np.float64),
        areas,
        np.zeros((1, 6)),
        variation,
        np.sqrt(areas),
        noise,
        np.arange(0, n * kept + 1, kept, dtype=np.int64),
        near.ravel(),
        sound[first[order]],
        row_of,
        tuple(said),
    )


def _along_cells(local: Array) -> Ints:
    """Order of points (n, 3) by cells of about fifty each, so that neighbours come together."""
    size = np.ptp(local, axis=0)
    cells = max(len(local) / 50.0, 1.0)
    flat = np.sort(size)[::-1]
    side = max(float(np.sqrt(flat[0] * max(flat[1], 1e-12) / cells)), float(flat[0]) / 2e5, 1e-12)
    i, j, k = (np.floor(local / side).astype(np.int64) & 0x1FFFFF).T
    return np.argsort((i << 42) | (j << 21) | k, kind="stable")


def _wanted_neighbours(tree: object, places: Array, angle_deg: float) -> int:
    """How many neighbours make normals that agree with those beside them, on a sample."""
    n = len(places)
    sample = np.arange(0, n, max(1, n // _TRIED))
    wanted = min(_AROUND[0], n)
    for count in _AROUND:
        wanted = min(count, n)
        _, rows = tree.query(places[sample], k=wanted)  # type: ignore[attr-defined]
        # The fourth neighbour, and the plane around it.
        beside = rows[:, min(4, wanted - 1)]
        _, others = tree.query(places[beside], k=wanted)  # type: ignore[attr-defined]
        sides = []
        for at, own in ((sample, rows), (beside, others)):
            found = np.empty((len(own), 3)), np.empty(len(own))
            local_planes(
                places, for_kernels(places[at], np.float64),
                np.ascontiguousarray(own, np.int32), *found,
            )  # fmt: skip
            sides.append(found[0])
        cosine = np.abs((sides[0] * sides[1]).sum(axis=1))
        cosine = cosine[np.isfinite(cosine)]
        if not len(cosine):
            break
        if np.degrees(np.arccos(min(float(np.median(cosine)), 1.0))) <= _QUIET * angle_deg:
            break
        if wanted == n:
            break
    return wanted


def _given_or(given: Array, found: Array, said: list[str]) -> Array:
    """The file's normals where they are some and agree with the points on the whole."""
    size = np.linalg.norm(given, axis=1)
    known = np.isfinite(size) & (size > 1e-6)
    unit = given / np.where(known, size, 1.0)[:, None]
    cosine = np.abs((unit * found).sum(axis=1))
    both = known & np.isfinite(cosine)
    if not both.any():
        return found
    angle = float(np.degrees(np.arccos(min(float(np.median(cosine[both])), 1.0))))
    if angle > _WRONG_NORMALS_DEG:
        said.append(
            tr(
                "The normals of the file are {angle:.0f}° off the surface of its points (median) "
                "and were not used.",
                angle=angle,
            )
        )
        return found
    return np.where(known[:, None], unit, found)


# --- meshes -----------------------------------------------------------------------------------
def _of_mesh(mesh: Mesh, angle_deg: float, progress: Progress) -> Elements:
    vertices = np.asarray(mesh.vertices, np.float64)
    whole = np.asarray(np.isfinite(vertices).all(axis=1))
    faces = np.asarray(mesh.faces, np.int64)
    sound = whole[faces].all(axis=1)
    if not sound.any():
        raise GeometryError(tr("The mesh has no faces with places."))
    origin = np.floor(vertices[whole].min(axis=0))
    local = np.where(whole[:, None], vertices, 0.0) - origin
    corners = local[faces]
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross = np.cross(edge_a, edge_b)
    double = np.linalg.norm(cross, axis=1)
    # Slivers have no normal worth the name.
    longest = np.maximum((edge_a**2).sum(axis=1), (edge_b**2).sum(axis=1))
    rows = np.flatnonzero(sound & (double > 1e-9 * longest))
    if not len(rows):
        raise GeometryError(tr("No face of the mesh has an area."))
    row_of = np.full(len(faces), -1, np.int64)
    row_of[rows] = np.arange(len(rows))

    progress.stage(tr("Finding neighbours"), None)
    nodes = welded(local)[faces[rows]]
    starts, near = _face_neighbours(nodes)
    own = corners[rows]
    places = own.mean(axis=1)
    areas = double[rows] / 2.0
    normals = cross[rows] / double[rows, None]
    off = own - places[:, None]
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    inner = np.stack([(off[..., a] * off[..., b]).sum(axis=1) / 12.0 for a, b in pairs], axis=1)
    progress.stage(tr("Normals"), None)
    normals, variation = _quiet_normals(
        for_kernels(normals, np.float64), for_kernels(areas, np.float64), starts, near, angle_deg,
        progress,
    )  # fmt: skip
    # Two faces for each vertex.
    spacing = np.sqrt(2.0 * areas)
    return Elements(
        "face",
        origin,
        for_kernels(places, np.float64),
        normals,
        for_kernels(areas, np.float64),
        for_kernels(inner, np.float64),
        variation,
        spacing,
        spacing * np.sqrt(np.maximum(np.nan_to_num(variation), 0.0)),
        starts,
        near,
        rows,
        row_of,
    )


def _face_neighbours(nodes: Ints) -> tuple[Ints, Rows]:
    """Neighbours across edges of faces (k, 3 numbers of places); the faces of an edge that more
    than two share follow each other in a ring."""
    k = len(nodes)
    a = nodes.ravel()
    b = np.roll(nodes, -1, axis=1).ravel()
    key = np.minimum(a, b) * (int(nodes.max()) + 1) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    same = np.diff(key[order]) == 0
    one, two = order[:-1][same] // 3, order[1:][same] // 3
    source = np.concatenate([one, two])
    target = np.concatenate([two, one])
    by = np.argsort(source, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(source, minlength=k))]).astype(np.int64)
    return starts, for_kernels(target[by], np.int32)


def _quiet_normals(
    normals: Array, areas: Array, starts: Ints, near: Rows, angle_deg: float, progress: Progress
) -> tuple[Array, Array]:
    """Normals smoothed until neighbours agree, and half the mean squared sine between each face as
    it is and its neighbours: how rough the mesh is there."""
    if not len(near):
        return normals, np.zeros(len(normals))
    cosine = np.empty(len(near))
    agreement(normals, starts, near, cosine)
    number = np.diff(starts)
    source = np.repeat(np.arange(len(normals)), number)
    rough = np.bincount(source, 1.0 - cosine**2, len(normals)) / np.maximum(number, 1) / 2.0
    # Across edges that a smoothing must keep.
    least = float(np.cos(np.radians(min(2.5 * angle_deg, 60.0))))
    for _ in range(_SMOOTHINGS):
        angle = np.degrees(np.arccos(min(float(np.median(cosine)), 1.0)))
        if angle <= 0.5 * _QUIET * angle_deg:
            break
        out = np.empty_like(normals)
        smoothed(normals, areas, starts, near, least, out)
        normals = out
        agreement(normals, starts, near, cosine)
        progress.step(0)
    return normals, rough
