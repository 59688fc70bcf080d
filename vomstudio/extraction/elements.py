"""The pieces of a surface that facets are made of: faces of a mesh, points of a cloud, with their
neighbours, normals, areas and the resolution around them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.kernels import agreement, smoothed
from vomstudio.extraction.point_neighbours import (
    AROUND,
    MANY,
    QUIET,
    Seen,
    drowned,
    normals_of_places,
    scattered,
    seen_around,
)
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.cell_lists import bounds_of
from vomstudio.geometry.kernels.jit import for_kernels, for_reading
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.shared_corners import (
    check_connected,
    first_faces,
    neighbours_across_gaps,
    snap_corners,
)

_SMOOTHINGS = 12
# Ours: neighbours of faces are turned by 30 degrees and more.
_FEWEST_NOISY, _NOISY = 1_000, 0.12
_PER_CELL = 16.0
FEWEST_AROUND = 20
"""Points in a cell and those around it that tell a plane."""
_LOOKED_AT = 40_000
_FEWEST_SCATTERED = 1_000
_ENOUGH = 100_000
_WRONG_NORMALS_DEG, _WRONG_SHARE = 30.0, 0.03
# Below it the points tell a normal: at an edge of 60 degrees the variation is as much.
_FLAT = 0.06
NO_SURFACE = 1.0 / 3.0
"""The variation of a point that is no piece of a surface."""
# A point whose neighbours lie much farther from it than theirs from them is no piece of a surface.
_LONELY = 2.0


@dataclass(frozen=True, eq=False)
class Begun:
    """What cells tell of the points (n,) of a cloud, which are sorted by them.

    labels : int32 plane, -1 for none; open : to be looked at by itself
    normals (n, 3), variation, areas, noise : of the surroundings, as `Elements` has them
    wide : m, how wide the surroundings are where the noise is so large beside the spacing that only
        they tell normals, NaN where they do not; inf where none do; 0 where single points do
    """

    labels: Int32Array
    open: BoolArray
    normals: FloatArray
    variation: FloatArray
    areas: FloatArray
    noise: FloatArray
    wide: float = 0.0


def middle_of(values: FloatArray) -> float:
    """The median, of very many that of some hundred thousand wherever they lie."""
    return float(np.median(values[:: max(1, len(values) // _ENOUGH)]))


Begin = Callable[[FloatArray, bool], tuple[CellGrid, Begun]]
"""Of places, and whether their noise is known to be large."""


@dataclass(frozen=True, eq=False)
class Elements:
    """n pieces of a surface; lengths in the unit of World.

    of : what they are, a cell being the points in a cube; origin : (3,) to be added to all places
    places : (n, 3) from the origin on; normals : (n, 3) unit, of either side, NaN where none
    areas : (n,) each stands for; inner : (n, 6) second moments of each about its place, over its
        area (xx, yy, zz, xy, xz, yz), or one row of zeros for all
    variation : (n,) surface variation, 0 for flat, NO_SURFACE for none; NaN where unknown
    spacing, noise : (n,) mean spacing of the model's points around, and of their scatter about the
        surface
    starts, near : the neighbours of e are near[starts[e]:starts[e + 1]]; points that scatter in all
        directions have none
    rows : (n,) of the model's faces or points, which stand behind them
    row_of : (rows of the model,) the element of each face or point, -1 for none
    begun : (n,) facets that are known already; points amid one have no neighbours listed
    around : of how many points normals and variation of points are; 0 where of wide surroundings
    fewer : (n,) where they are of the least number, None where nowhere
    """

    of: Literal["face", "point", "cell"]
    origin: FloatArray
    places: FloatArray
    normals: FloatArray
    areas: FloatArray
    inner: FloatArray
    variation: FloatArray
    spacing: FloatArray
    noise: FloatArray
    starts: IntArray
    near: Int32Array
    rows: IntArray
    row_of: IntArray
    warnings: tuple[Finding, ...] = ()
    begun: Int32Array | None = None
    around: int = 0
    fewer: BoolArray | None = None

    @cached_property
    def usual_area(self) -> float:
        return middle_of(self.areas)

    def __len__(self) -> int:
        return len(self.places)


def elements_of(
    data: Mesh | PointCloud, angle_deg: float, progress: Progress, begin: Begin | None = None
) -> Elements:
    """Of a model in World. angle_deg : by which normals may differ on one facet; they are taken
    from as much of the surface as their noise needs. begin : finds planes in a cloud of many
    points from 0 on, before its points are looked at one by one. Raises GeometryError where there
    is no surface, Cancelled through `progress`."""
    if isinstance(data, Mesh) and len(data.faces):
        return _of_mesh(data, angle_deg, progress)
    points = data.vertices if isinstance(data, Mesh) else data.points
    normals = None if isinstance(data, Mesh) else data.normals
    return _of_cloud(points, normals, angle_deg, progress, begin)


# --- clouds -----------------------------------------------------------------------------------
def _of_cloud(
    points: FloatArray,
    file_normals: Float32Array | None,
    angle_deg: float,
    progress: Progress,
    begin: Begin | None,
) -> Elements:
    grid, begun, sound, origin = _grid_of(points, begin)
    places = grid.places
    if len(places) < 4:
        raise GeometryError(Finding("cloud.too-few-points", n=len(places), minimum=4))
    rows, row_of = grid.rows, grid.row_of
    if sound is not None:
        rows, row_of = sound[rows], np.full(len(points), -1, np.int64)
        row_of[sound] = grid.row_of
    open_ = np.arange(len(places)) if begun is None else np.flatnonzero(begun.open)
    known = None if begun is None else _neighbours_for(begun, angle_deg)
    few, lost, area = None, open_[:0], 0.0
    if len(places) >= MANY:
        few = grid.count_around() < FEWEST_AROUND
        open_, lost, area = _without_scattered(grid, open_, few)
    around, seen = seen_around(grid, open_, few, known, angle_deg, progress)
    number = np.zeros(len(places) + 1, np.int64)
    number[open_ + 1] = seen.near.shape[1]
    warnings: list[Finding] = []
    if begun is not None and begun.wide:
        around = 0
        known_ = begun.normals, begun.variation, begun.areas, begun.noise
        if np.isfinite(begun.wide):
            warnings.append(_wide(begun))
    else:
        known_ = _surroundings(open_, seen, begun, len(places))
    normals, variation, areas, noise = known_
    if around:
        normals[lost], variation[lost], areas[lost], noise[lost] = np.nan, NO_SURFACE, area, 0.0
    if file_normals is not None:
        normals = _merge_normals(
            np.asarray(file_normals, np.float64)[rows], normals, variation, warnings
        )
    fewer = None
    if around and (seen.around < around).any():
        fewer = np.zeros(len(places), np.bool_)
        fewer[open_[seen.around < around]] = True
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
        np.cumsum(number),
        seen.near.ravel(),
        rows,
        row_of,
        tuple(warnings),
        None if begun is None else begun.labels,
        around,
        fewer,
    )


def _grid_of(
    points: FloatArray, begin: Begin | None
) -> tuple[CellGrid, Begun | None, IntArray | None, FloatArray]:
    """The points in cells, what is begun on these, the rows of the points that have a place, where
    these are not all, and the origin of the places."""
    given = for_reading(points, np.float64)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    odd = bounds_of(given, low, high)
    if len(points) - odd < 4:
        raise GeometryError(Finding("cloud.too-few-points", n=len(points) - odd, minimum=4))
    sound = np.flatnonzero(np.isfinite(points).all(axis=1)) if odd else None
    origin = np.floor(low)
    local = (given if sound is None else given[sound]) - origin
    noisy = begin is not None and len(local) < MANY and drowned(local)
    if begin is not None and (noisy or len(local) >= MANY):
        return *begin(local, noisy), sound, origin
    return create_cell_grid(local, _PER_CELL), None, sound, origin


def _without_scattered(
    grid: CellGrid, open_: IntArray, few: BoolArray
) -> tuple[IntArray, IntArray, float]:
    """Of the open points those to be looked at, and those in cells with few points that scatter in
    all directions, with the area of each of these."""
    thin = few[grid.cells_of(open_)]
    if thin.sum() < _FEWEST_SCATTERED:
        return open_, open_[:0], 0.0
    lost = np.zeros(len(open_), np.bool_)
    lost[thin], area = scattered(grid.places[open_[thin]])
    return open_[~lost], open_[lost], area


def _surroundings(
    open_: IntArray, seen: Seen, begun: Begun | None, n: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Normals, variation, areas and noise of n points from what is around those that are open, and
    from cells around the others."""
    kept = seen.near.shape[1]
    if begun is None:
        normals, variation, areas, noise = np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
    else:
        normals, variation, areas, noise = begun.normals, begun.variation, begun.areas, begun.noise
    normals[open_], variation[open_] = seen.normals, seen.variation
    far = seen.far
    areas[open_] = np.pi * far**2 / kept
    beside = np.sort(areas[seen.near], axis=1)
    usual = (np.sqrt(beside[:, (kept - 1) // 2]) + np.sqrt(beside[:, kept // 2])) / 2.0
    usual *= np.sqrt(kept / np.pi)
    lone = open_[far > 2.0 * _LONELY * usual]
    areas[open_] = np.pi * np.minimum(far, _LONELY * usual) ** 2 / kept
    # Of a disc of area A the variance along each diameter is A / (4 pi).
    own = np.maximum(seen.variation, 0.0) * seen.around * areas[open_]
    noise[open_] = np.sqrt(own / (2.0 * np.pi))
    normals[lone], variation[lone] = np.nan, NO_SURFACE
    return normals, variation, areas, noise


def _wide(begun: Begun) -> Finding:
    noise = float(np.median(begun.noise))
    return Finding(
        "cloud.noisy",
        noise_m=noise,
        times=noise / float(np.sqrt(np.median(begun.areas))),
        width_m=begun.wide,
    )


def _neighbours_for(begun: Begun, angle_deg: float) -> int | None:
    """How many neighbours make quiet normals by the noise of what lies in planes; None where that
    is less than half of the cloud."""
    if begun.wide:
        return AROUND[0]
    n = len(begun.open)
    if 2 * int(begun.open.sum()) > n:
        return None
    closed = np.flatnonzero(~begun.open)[:: max(1, n // _LOOKED_AT)]
    noise = float(np.median(begun.noise[closed] / np.sqrt(begun.areas[closed])))
    # The error of the normal of k points with that noise is 2 sqrt(pi) noise / (spacing k), and
    # normals of neighbours, which share points, differ by about as much at the median.
    wanted = 2.0 * np.sqrt(np.pi) * noise / np.radians(QUIET * angle_deg)
    return next((count for count in AROUND if count >= wanted), AROUND[-1])


def _merge_normals(
    file_normals: FloatArray, fitted: FloatArray, variation: FloatArray, warnings: list[Finding]
) -> FloatArray:
    """Replace fitted normals by those of the file where these agree with the points.

    If the median angle between them is large, or too many differ in flat parts, a warning is
    appended and fewer or none of the file's normals are used.

    Parameters
    ----------
    file_normals, fitted : (n, 3) arrays
        NaN or zero if unknown; those fitted are unit vectors.
    variation : (n,) array
        Surface variation: large near edges, where fitted normals lie between two faces.
    warnings : list of Finding
    """
    size = np.linalg.norm(file_normals, axis=1)
    known = np.isfinite(size) & (size > 1e-6)
    unit = file_normals / np.where(known, size, 1.0)[:, None]
    cosine = np.abs((unit * fitted).sum(axis=1))
    both = known & np.isfinite(cosine)
    if not both.any():
        return fitted
    angle = float(np.degrees(np.arccos(min(float(np.median(cosine[both])), 1.0))))
    if angle > _WRONG_NORMALS_DEG:
        warnings.append(Finding("cloud.normals-unused", angle_deg=angle))
        return fitted
    flat = both & (variation < _FLAT)
    wrong = flat & (cosine < np.cos(np.radians(_WRONG_NORMALS_DEG)))
    share = float(wrong.sum()) / max(int(flat.sum()), 1)
    if share > _WRONG_SHARE:
        warnings.append(
            Finding(
                "cloud.normals-partly-unused",
                share_percent=100.0 * share,
                limit_deg=_WRONG_NORMALS_DEG,
            )
        )
        # Near an edge as many may be wrong, but the points do not show which.
        known &= flat
    return np.where((known & ~wrong)[:, None], unit, fitted)


# --- meshes -----------------------------------------------------------------------------------
def _of_mesh(mesh: Mesh, angle_deg: float, progress: Progress) -> Elements:
    vertices = np.asarray(mesh.vertices, np.float64)
    whole = np.asarray(np.isfinite(vertices).all(axis=1))
    faces = np.asarray(mesh.faces, np.int64)
    sound = whole[faces].all(axis=1)
    if not sound.any():
        raise GeometryError(Finding("model.no-faces"))
    origin = np.floor(vertices[whole].min(axis=0))
    local = np.where(whole[:, None], vertices, 0.0) - origin
    local = snap_corners(local, faces[sound])
    corners = local[faces]
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross = np.cross(edge_a, edge_b)
    double = np.linalg.norm(cross, axis=1)
    # Slivers have no normal worth the name.
    longest = np.maximum((edge_a**2).sum(axis=1), (edge_b**2).sum(axis=1))
    rows = np.flatnonzero(sound & (double > 1e-9 * longest))
    if not len(rows):
        raise GeometryError(Finding("mesh.no-area"))
    progress.stage(tr("Finding neighbours"), None)
    warnings: list[Finding] = []
    nodes = welded(local)[faces[rows]]
    check_connected(nodes, warnings)
    first = first_faces(nodes, warnings)
    rows, nodes = rows[first], nodes[first]
    row_of = np.full(len(faces), -1, np.int64)
    row_of[rows] = np.arange(len(rows))
    used_corners = corners[rows]
    starts, near = _face_neighbours(nodes, used_corners)
    places = used_corners.mean(axis=1)
    areas = double[rows] / 2.0
    normals = cross[rows] / double[rows, None]
    off = used_corners - places[:, None]
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    inner = np.stack([(off[..., a] * off[..., b]).sum(axis=1) / 12.0 for a, b in pairs], axis=1)
    progress.stage(tr("Computing normals"), None)
    places = for_kernels(places, np.float64)
    normals, variation, quiet = _quiet_normals(
        for_kernels(normals, np.float64),
        for_kernels(areas, np.float64),
        starts,
        near,
        angle_deg,
        progress,
    )
    if not quiet:
        smoothed = normals_of_places(places, angle_deg, progress)
        normals = normals if smoothed is None else smoothed
    # Two faces for each vertex.
    spacing = np.sqrt(2.0 * areas)
    return Elements(
        "face",
        origin,
        places,
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
        tuple(warnings),
    )


def _face_neighbours(nodes: IntArray, corners: FloatArray) -> tuple[IntArray, Int32Array]:
    """Neighbours across edges of faces (k, 3 numbers of places), and across gaps; the faces of an
    edge that more than two share follow each other in a ring."""
    k = len(nodes)
    a = nodes.ravel()
    b = np.roll(nodes, -1, axis=1).ravel()
    key = np.minimum(a, b) * (int(nodes.max()) + 1) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    same = np.diff(key[order]) == 0
    one, two = order[:-1][same] // 3, order[1:][same] // 3
    before, _, beyond = neighbours_across_gaps(nodes, corners)
    source = np.concatenate([one, two, before, beyond])
    target = np.concatenate([two, one, beyond, before])
    by = np.argsort(source, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(source, minlength=k))]).astype(np.int64)
    return starts, for_kernels(target[by], np.int32)


def _quiet_normals(
    normals: FloatArray,
    areas: FloatArray,
    starts: IntArray,
    near: Int32Array,
    angle_deg: float,
    progress: Progress,
) -> tuple[FloatArray, FloatArray, bool]:
    """Normals smoothed until neighbours agree, half the mean squared sine between each face as it
    is and its neighbours, which is how rough the mesh is there, and whether they agree."""
    if not len(near):
        return normals, np.zeros(len(normals)), True
    cosine = np.empty(len(near))
    agreement(normals, starts, near, cosine)
    number = np.diff(starts)
    source = np.repeat(np.arange(len(normals)), number)
    rough = np.bincount(source, 1.0 - cosine**2, len(normals)) / np.maximum(number, 1) / 2.0
    # Across edges that a smoothing must keep.
    least = float(np.cos(np.radians(min(2.5 * angle_deg, 60.0))))
    for _ in range(_SMOOTHINGS):
        angle = np.degrees(np.arccos(min(float(np.median(cosine)), 1.0)))
        if angle <= 0.5 * QUIET * angle_deg:
            return normals, rough, True
        out = np.empty_like(normals)
        smoothed(normals, areas, starts, near, least, out)
        normals = out
        agreement(normals, starts, near, cosine)
        progress.step(0)
    # With noise of some half of a side faces look in all directions; where they are tells more.
    # Those of a mesh with few faces are a block's own.
    angle = np.degrees(np.arccos(min(float(np.median(cosine)), 1.0)))
    noisy = len(normals) >= _FEWEST_NOISY and float(np.median(rough)) > _NOISY
    return normals, rough, not noisy or bool(angle <= 0.5 * QUIET * angle_deg)
