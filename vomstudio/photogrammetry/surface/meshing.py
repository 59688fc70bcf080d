"""Surface of a dense cloud by Poisson reconstruction, trimmed, sharpened and checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    ByteArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.photogrammetry.base import memory
from vomstudio.photogrammetry.surface.topology import (
    compact,
    components,
    cross_products,
    is_manifold,
    make_manifold,
    neighbours,
    vertex_normals,
)

_MIN_POINTS = 100
_DEPTHS = (5, 12)
_N_NEIGHBOURS = 24
_BYTES_PER_POINT = 1000
_MIN_THINNED_POINTS = 100_000
# Distance from points at which a rim is trimmed, as a share of the maximum distance.
_RIM_DISTANCE_SHARE = 0.45
# Maximum width of the trimmed strip, in the same unit.
_RIM_WIDTH = 1.1
# Minimum share of triangles of a piece; smaller ones are vegetation or errors.
_ISLAND_SHARE = 0.0005


@dataclass(frozen=True)
class MeshingOptions:
    """Options of surfaces.

    Attributes
    ----------
    faces : int or None
        Target number of triangles. If None, the result of Poisson's method is not simplified.
    depth : int or None
        Depth of the octree. If None, it is derived from the spacing, the extent and the target.
    trim : float
        Vertices whose distance from all points is larger, in spacings, are removed.
    largest_hole_m : float or None
        Maximum width of the holes that are closed. If None, 30 spacings.
    smallest_island_faces : int
        Minimum number of triangles of a piece; on large surfaces, a two-thousandth of all
        triangles.
    sharpen : bool
        Whether to move vertices onto the points, which preserves steps and edges.
    max_points : int
        Larger clouds are thinned evenly, which bounds the memory (about 1 GB per million points).
    threads : int
        Number of threads of Poisson's method; with 1, the result is reproducible.
    """

    faces: int | None = 200_000
    depth: int | None = None
    trim: float = 8.0
    largest_hole_m: float | None = None
    smallest_island_faces: int = 200
    sharpen: bool = True
    max_points: int = 4_000_000
    threads: int = 1

    def __post_init__(self) -> None:
        if self.faces is not None and self.faces < 4:
            raise UsageError(
                Finding("option.too-small", value=self.faces, minimum=4), field="faces"
            )
        if self.depth is not None and not _DEPTHS[0] <= self.depth <= _DEPTHS[1]:
            raise UsageError(
                Finding(
                    "option.out-of-range", value=self.depth, minimum=_DEPTHS[0], maximum=_DEPTHS[1]
                ),
                field="depth",
            )
        if not self.trim > 0:
            raise UsageError(Finding("number.not-positive", value=self.trim), field="trim")


@dataclass(frozen=True, eq=False)
class MeshedSurface:
    """Surface with figures for the report.

    facts : spacing_m, depth, faces_poisson, faces, cut_share, holes_closed, islands_left_out,
    area_m2, and others
    """

    mesh: Mesh
    facts: dict[str, Any]
    warnings: tuple[Finding, ...]


def fitting_points() -> int:
    """Return the maximum number of points whose surface fits into free memory."""
    maximum = memory.MAX_MEMORY_SHARE * memory.available_bytes() / _BYTES_PER_POINT
    return int(min(max(maximum, _MIN_THINNED_POINTS), MeshingOptions.max_points))


def build_surface(
    cloud: PointCloud,
    options: MeshingOptions | None = None,
    progress: Progress | None = None,
) -> MeshedSurface:
    """Build the surface of a cloud whose normals point out of the rock, as in `fuse_depth_maps`.

    Screened Poisson reconstruction (Kazhdan and Hoppe 2013), trimmed away from points; small holes
    keep the Poisson surface. Coordinates are those of the cloud. Poisson's method and the
    simplification cannot be interrupted; Cancelled is raised after them.

    Raises
    ------
    GeometryError
        If the cloud has no normals, too few points, or no extent.
    """
    options, progress = options or MeshingOptions(), progress or SilentProgress()
    points, normals, colors, warnings = _check(cloud, options)
    shift = points.mean(axis=0)
    points = np.ascontiguousarray(points - shift)
    progress.stage(tr("Measuring the point spacing"))
    tree, spacing = _typical_spacing(points)
    depth = options.depth or _depth(points, spacing, options.faces)
    # An open cell of the octree is what Poisson's method resolves; the cut must not fall below it.
    cell = 1.1 * float(np.ptp(points, axis=0).max()) / 2**depth
    facts: dict[str, Any] = {"points": len(points), "spacing_m": spacing, "depth": depth}
    progress.stage(tr("Computing the Poisson surface (cannot be cancelled)"))
    vertices, faces = _poisson(points, normals, depth, options.threads)
    facts["faces_poisson"] = len(faces)
    progress.stage(tr("Trimming unsupported surface"))
    distance = tree.query(vertices, workers=1)[0]
    max_distance = options.trim * spacing
    max_hole = 30 * spacing if options.largest_hole_m is None else options.largest_hole_m
    is_kept, closed_holes = _trim(vertices, faces, distance, max_distance, max_hole)
    if not is_kept.any():
        raise GeometryError(Finding("surface.nothing-left"))
    vertices, faces, _ = compact(vertices, faces[is_kept])
    facts |= {"cut_share": 1 - len(faces) / facts["faces_poisson"], "holes_closed": closed_holes}
    if options.sharpen:
        progress.stage(tr("Refining the surface"))
        vertices = _refine(
            vertices, faces, points, normals, tree, max(1.5 * spacing, 0.9 * cell), progress
        )
    vertices, faces, pieces = _remove_islands(vertices, faces, 20)
    if options.faces is not None and len(faces) > options.faces:
        progress.stage(tr("Decimating {count:,} triangles (cannot be cancelled)", count=len(faces)))
        vertices, faces = _decimate(vertices, faces, options.faces)
    progress.stage(tr("Checking the surface"))
    vertices, faces = make_manifold(vertices, faces)
    vertices, faces, islands = _remove_islands(
        vertices, faces, max(options.smallest_island_faces, int(_ISLAND_SHARE * len(faces)))
    )
    faces = _orient_to_normals(vertices, faces, tree, normals)
    _verify(vertices, faces)
    mesh = Mesh(vertices + shift, faces, colors=_vertex_colors(vertices, tree, colors))
    facts |= {
        "faces": len(faces),
        "islands_left_out": pieces + islands,
        "area_m2": float(np.linalg.norm(cross_products(vertices, faces), axis=1).sum() / 2),
    }
    if options.faces is not None and len(faces) > 1.05 * options.faces:
        warnings.append(Finding("surface.not-decimated", faces=len(faces), wanted=options.faces))
    return MeshedSurface(mesh, facts, tuple(warnings))


def _check(
    cloud: PointCloud, options: MeshingOptions
) -> tuple[FloatArray, Float32Array, ByteArray | None, list[Finding]]:
    points, normals, colors = cloud.points, cloud.normals, cloud.colors
    if not len(points):
        raise GeometryError(Finding("surface.no-points"))
    if normals is None:
        raise GeometryError(Finding("surface.no-normals"))
    warnings: list[Finding] = []
    length = np.linalg.norm(normals, axis=1)
    is_sound = np.isfinite(points).all(axis=1) & np.isfinite(length) & (length > 1e-6)
    if not is_sound.all():
        warnings.append(Finding("surface.points-left-out", count=int((~is_sound).sum())))
        points, normals, length = points[is_sound], normals[is_sound], length[is_sound]
        colors = None if colors is None else colors[is_sound]
    if len(points) < _MIN_POINTS:
        raise GeometryError(Finding("surface.few-points", points=len(points), least=_MIN_POINTS))
    normals = (normals / length[:, None]).astype(np.float32)
    if len(points) > options.max_points:
        rows = _thin_out(points, options.max_points)
        warnings.append(Finding("surface.thinned", total=len(points), points=len(rows)))
        points, normals = points[rows], normals[rows]
        colors = None if colors is None else colors[rows]
    if not np.ptp(points, axis=0).max() > 0:
        raise GeometryError(Finding("surface.coincident-points"))
    return points, normals, colors, warnings


def _thin_out(points: FloatArray, count: int) -> IntArray:
    """Return every k-th point along a space-filling order of cells."""
    cells = np.floor((points - points.min(axis=0)) / (np.ptp(points, axis=0).max() / 1023 + 1e-300))
    order = np.lexsort(cells.T)
    return np.sort(order[np.linspace(0, len(points) - 1, count).astype(np.int64)])


def _typical_spacing(points: FloatArray) -> tuple[Any, float]:
    from scipy.spatial import cKDTree

    tree = cKDTree(points, balanced_tree=False)
    sample = points[:: max(1, len(points) // 20_000)]
    distances = tree.query(sample, k=2)[0][:, 1]
    distances = distances[distances > 0]
    if not len(distances):
        raise GeometryError(Finding("surface.coincident-points"))
    # Along a surface, points at random have neighbours at half the step of a regular grid.
    return tree, float(np.median(distances))


def _depth(points: FloatArray, spacing: float, faces: int | None) -> int:
    """Return the depth of the octree.

    Cells are about two nearest-neighbour spacings, and not so fine that simplification would remove
    most of them.
    """
    extent = 1.1 * float(np.ptp(points, axis=0).max())
    cell = 2.0 * spacing
    if faces is not None:
        covered_count = len(points) * (2 * spacing) ** 2
        cell = max(cell, 0.4 * math.sqrt(2 * covered_count / faces))
    return int(np.clip(math.ceil(math.log2(extent / cell) - 0.25), *_DEPTHS))


def _poisson(
    points: FloatArray, normals: Float32Array, depth: int, threads: int
) -> tuple[FloatArray, Int32Array]:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.normals = o3d.utility.Vector3dVector(normals.astype(np.float64))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(
            cloud, depth=depth, n_threads=max(1, threads)
        )
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.triangles, np.int32)
    is_finite = np.isfinite(vertices).all(axis=1)
    return vertices.copy(), faces[is_finite[faces].all(axis=1)]


def _trim(
    vertices: FloatArray,
    faces: Int32Array,
    distance: FloatArray,
    max_distance: float,
    max_hole: float,
) -> tuple[BoolArray, int]:
    """Return which faces remain, and the number of holes closed by the Poisson surface.

    Within `max_distance` of the points the surface remains if it continues behind; at its rim it
    ends sooner.
    """
    farthest_distance = distance[faces].max(axis=1)
    is_kept = farthest_distance <= _RIM_DISTANCE_SHARE * max_distance
    if is_kept.all() or not is_kept.any():
        return is_kept, 0
    piece = components(faces, ~is_kept)
    count = int(piece.max()) + 1
    rows = np.flatnonzero(~is_kept)
    labels = piece[rows]
    corners = vertices[faces[rows]]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, labels, corners.min(axis=1))
    np.maximum.at(high, labels, corners.max(axis=1))
    farthest_distances = np.zeros(count)
    np.maximum.at(farthest_distances, labels, farthest_distance[rows])
    # A border of the Poisson surface is a rim, not a hole.
    rim_width = np.zeros(count, bool)
    rim_width[labels[(neighbours(faces)[rows] < 0).any(axis=1)]] = True
    is_sparse = (farthest_distances <= max_distance) & ~rim_width
    is_closed = ~is_sparse & ~rim_width & (np.linalg.norm(high - low, axis=1) <= 1.2 * max_hole)
    is_kept[rows[(is_sparse | is_closed)[labels]]] = True
    is_kept |= _find_cracks(
        vertices,
        faces,
        ~is_kept & (farthest_distance <= max_distance),
        farthest_distance > max_distance,
        max_distance,
    )
    return is_kept, int(is_closed.sum())


def _find_cracks(
    vertices: FloatArray,
    faces: Int32Array,
    is_band: BoolArray,
    is_air: BoolArray,
    max_distance: float,
) -> BoolArray:
    """Return the band faces farther from the air, along the surface, than the width of a rim.

    These are narrow strips that no photo shows, such as treads of joint steps, connected to the rim
    only.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    is_crack = np.zeros(len(faces), bool)
    rows = np.flatnonzero(is_band)
    if not len(rows):
        return is_crack
    used_vertices, corners = np.unique(faces[rows], return_inverse=True)
    corners = corners.reshape(-1, 3)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    length = np.linalg.norm(vertices[used_vertices[start]] - vertices[used_vertices[end]], axis=1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first = np.unique(low.astype(np.int64) << 32 | high, return_index=True)
    links = (np.maximum(length[first], 1e-12), (low[first], high[first]))
    graph = coo_matrix(links, shape=(len(used_vertices), len(used_vertices))).tocsr()
    is_adjacent_to_air = np.zeros(len(vertices), bool)
    is_adjacent_to_air[faces[is_air]] = True
    seeds = np.flatnonzero(is_adjacent_to_air[used_vertices])
    distances = np.full(len(used_vertices), np.inf)
    if len(seeds):
        rim_vertices = _RIM_WIDTH * max_distance
        distances = dijkstra(
            graph, directed=False, indices=seeds, min_only=True, limit=rim_vertices
        )
    is_crack[rows] = np.isinf(distances[corners]).all(axis=1)
    return is_crack


def _refine(
    vertices: FloatArray,
    faces: Int32Array,
    points: FloatArray,
    normals: Float32Array,
    tree: Any,
    width: float,
    progress: Progress,
) -> FloatArray:
    """Move vertices onto the points near them, unless their faces would flip."""
    from vomstudio.photogrammetry.surface._surface_kernels import pull_to_points

    refined_vertices = np.ascontiguousarray(vertices.copy())
    facing = vertex_normals(vertices, faces)
    step = 100_000
    for start in range(0, len(refined_vertices), step):
        progress.step(start)
        part = slice(start, start + step)
        distance, nearest_rows = tree.query(
            refined_vertices[part], k=min(_N_NEIGHBOURS, len(points)), workers=1
        )
        rows = start + np.flatnonzero(distance[:, 0] < 4 * width)
        subset, corrected_vertices = (
            np.ascontiguousarray(refined_vertices[rows]),
            np.ascontiguousarray(facing[rows]),
        )
        neighbour_rows = np.ascontiguousarray(nearest_rows[rows - start].astype(np.int64))
        pull_to_points(
            subset, corrected_vertices, neighbour_rows, points, normals, width, 2.5 * width
        )
        refined_vertices[rows] = subset
    normals_before = cross_products(vertices, faces)
    for _ in range(5):
        normals_after = cross_products(refined_vertices, faces)
        is_turned = (normals_before * normals_after).sum(axis=1) < 0.2 * np.linalg.norm(
            normals_before, axis=1
        ) * (np.linalg.norm(normals_after, axis=1))
        if not is_turned.any():
            break
        rows = np.unique(faces[is_turned])
        refined_vertices[rows] = vertices[rows]
    return refined_vertices


def _decimate(
    vertices: FloatArray, faces: Int32Array, target: int
) -> tuple[FloatArray, Int32Array]:
    """Simplify by quadric error metrics. Libraries may fail silently, hence the count."""
    import open3d

    # Its stubs lack its arguments.
    o3d: Any = open3d
    mesh = o3d.t.geometry.TriangleMesh(o3d.core.Tensor(vertices), o3d.core.Tensor(faces))
    reduction = 1 - target / len(faces)
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        simplified = mesh.simplify_quadric_decimation(reduction)
        result = simplified.vertex.positions.numpy(), simplified.triangle.indices.numpy()
        if not 0.5 * target <= len(result[1]) <= 1.05 * target or not np.isfinite(result[0]).all():
            legacy_mesh = o3d.geometry.TriangleMesh(
                o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces)
            ).simplify_quadric_decimation(target)
            result = np.asarray(legacy_mesh.vertices), np.asarray(legacy_mesh.triangles)
    if len(result[1]) > 0.98 * len(faces) or not len(result[1]):
        return vertices, faces
    return np.asarray(result[0], np.float64), np.asarray(result[1], np.int32)


def _remove_islands(
    vertices: FloatArray, faces: Int32Array, smallest_count: int
) -> tuple[FloatArray, Int32Array, int]:
    """Remove small pieces, but never the largest one."""
    if not len(faces):
        return vertices, faces, 0
    piece = components(faces)
    size = np.bincount(piece)
    is_small = (size < smallest_count) & (np.arange(len(size)) != size.argmax())
    if not is_small.any():
        return vertices, faces, 0
    vertices, faces, _ = compact(vertices, faces[~is_small[piece]])
    return vertices, faces, int(is_small.sum())


def _orient_to_normals(
    vertices: FloatArray, faces: Int32Array, tree: Any, normals: Float32Array
) -> Int32Array:
    """Orient the faces of each piece counter-clockwise, seen from the air."""
    centre = vertices[faces].mean(axis=1)
    nearest_points = tree.query(centre)[1]
    agreements = (cross_products(vertices, faces) * normals[nearest_points]).sum(axis=1)
    piece = components(faces)
    is_wrong = np.bincount(piece, agreements)[piece] < 0
    faces = faces.copy()
    faces[is_wrong] = faces[is_wrong][:, ::-1]
    return faces


def _vertex_colors(vertices: FloatArray, tree: Any, colors: ByteArray | None) -> ByteArray | None:
    if colors is None:
        return None
    nearest_rows = tree.query(vertices, k=min(4, tree.n))[1].reshape(len(vertices), -1)
    return np.asarray(
        np.rint(colors[nearest_rows].astype(np.float32).mean(axis=1)).astype(np.uint8)
    )


def _verify(vertices: FloatArray, faces: Int32Array) -> None:
    if not len(faces):
        raise GeometryError(Finding("surface.nothing-left"))
    if not np.isfinite(vertices).all() or not is_manifold(faces):
        raise GeometryError(Finding("surface.not-a-mesh"))
