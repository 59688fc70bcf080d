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
_DEPTH_RANGE = (5, 12)
_N_NEIGHBOURS = 24
_BYTES_PER_POINT = 1000
_MIN_THINNED_POINTS = 100_000
# Distance from points at which a rim is trimmed, as a share of the maximum distance.
_RIM_DISTANCE_SHARE = 0.45
# Maximum width of the trimmed strip, in the same unit.
_MAX_RIM_WIDTH_SHARE = 1.1
# Minimum share of triangles of a piece; smaller ones are vegetation or errors.
_MIN_ISLAND_SHARE = 0.0005


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
        Maximum distance of the surface from the points, in spacings. Only closed holes exceed it.
    largest_hole_m : float or None
        Maximum width of the holes that are closed. If None, 30 spacings.
    smallest_island_faces : int
        Minimum number of triangles of a piece; on large surfaces, a two-thousandth of all
        triangles.
    sharpen : bool
        Whether to move vertices onto the points, which preserves steps and edges.
    max_points : int
        Maximum number of points, which bounds the memory (about 1 GB per million points). Larger
        clouds are thinned evenly.
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
        if self.depth is not None and not _DEPTH_RANGE[0] <= self.depth <= _DEPTH_RANGE[1]:
            raise UsageError(
                Finding(
                    "option.out-of-range",
                    value=self.depth,
                    minimum=_DEPTH_RANGE[0],
                    maximum=_DEPTH_RANGE[1],
                ),
                field="depth",
            )
        if not self.trim > 0:
            raise UsageError(Finding("number.not-positive", value=self.trim), field="trim")


@dataclass(frozen=True, eq=False)
class MeshedSurface:
    """Surface with figures for the report.

    facts : values of spacing_m, depth, faces_poisson, faces, cut_share, holes_closed,
    islands_left_out, area_m2 and others, by name
    """

    mesh: Mesh
    facts: dict[str, Any]
    warnings: tuple[Finding, ...]


def max_points_in_memory() -> int:
    """Return the maximum number of points whose surface fits into free memory."""
    max_points = memory.MAX_MEMORY_SHARE * memory.available_bytes() / _BYTES_PER_POINT
    return int(min(max(max_points, _MIN_THINNED_POINTS), MeshingOptions.max_points))


def build_surface(
    cloud: PointCloud,
    options: MeshingOptions | None = None,
    progress: Progress | None = None,
) -> MeshedSurface:
    """Build the surface of a cloud whose normals point out of the rock.

    The surface is a screened Poisson reconstruction (Kazhdan and Hoppe 2013), trimmed far from the
    points; small holes keep the Poisson surface. Coordinates are those of the cloud. Poisson's
    method and the simplification cannot be interrupted; Cancelled is raised after them.

    Raises
    ------
    GeometryError
        If the cloud has no normals, too few points, or no extent, or if no valid surface remains.
    """
    options, progress = options or MeshingOptions(), progress or SilentProgress()
    points, normals, colors, warnings = _check_cloud(cloud, options)
    shift = points.mean(axis=0)
    points = np.ascontiguousarray(points - shift)
    progress.stage(tr("Measuring the point spacing"))
    tree, spacing = _typical_spacing(points)
    depth = options.depth or _octree_depth(points, spacing, options.faces)
    # Poisson's method resolves one cell of the octree, so the trimming distance must exceed it.
    cell_size = 1.1 * float(np.ptp(points, axis=0).max()) / 2**depth
    facts: dict[str, Any] = {"points": len(points), "spacing_m": spacing, "depth": depth}
    progress.stage(tr("Computing the Poisson surface (cannot be cancelled)"))
    vertices, faces = _reconstruct_poisson(points, normals, depth, options.threads)
    facts["faces_poisson"] = len(faces)
    progress.stage(tr("Trimming unsupported surface"))
    distances = tree.query(vertices, workers=1)[0]
    max_distance = options.trim * spacing
    max_hole_width = 30 * spacing if options.largest_hole_m is None else options.largest_hole_m
    is_kept, closed_hole_count = _trim(vertices, faces, distances, max_distance, max_hole_width)
    if not is_kept.any():
        raise GeometryError(Finding("surface.nothing-left"))
    vertices, faces, _ = compact(vertices, faces[is_kept])
    facts |= {
        "cut_share": 1 - len(faces) / facts["faces_poisson"],
        "holes_closed": closed_hole_count,
    }
    if options.sharpen:
        progress.stage(tr("Refining the surface"))
        vertices = _refine(
            vertices, faces, points, normals, tree, max(1.5 * spacing, 0.9 * cell_size), progress
        )
    vertices, faces, piece_count = _remove_islands(vertices, faces, 20)
    if options.faces is not None and len(faces) > options.faces:
        progress.stage(tr("Decimating {count:,} triangles (cannot be cancelled)", count=len(faces)))
        vertices, faces = _decimate(vertices, faces, options.faces)
    progress.stage(tr("Checking the surface"))
    vertices, faces = make_manifold(vertices, faces)
    vertices, faces, island_count = _remove_islands(
        vertices, faces, max(options.smallest_island_faces, int(_MIN_ISLAND_SHARE * len(faces)))
    )
    faces = _orient_to_normals(vertices, faces, tree, normals)
    _verify_mesh(vertices, faces)
    mesh = Mesh(vertices + shift, faces, colors=_vertex_colors(vertices, tree, colors))
    facts |= {
        "faces": len(faces),
        "islands_left_out": piece_count + island_count,
        "area_m2": float(np.linalg.norm(cross_products(vertices, faces), axis=1).sum() / 2),
    }
    if options.faces is not None and len(faces) > 1.05 * options.faces:
        warnings.append(Finding("surface.not-decimated", faces=len(faces), wanted=options.faces))
    return MeshedSurface(mesh, facts, tuple(warnings))


def _check_cloud(
    cloud: PointCloud, options: MeshingOptions
) -> tuple[FloatArray, Float32Array, ByteArray | None, list[Finding]]:
    points, normals, colors = cloud.points, cloud.normals, cloud.colors
    if not len(points):
        raise GeometryError(Finding("surface.no-points"))
    if normals is None:
        raise GeometryError(Finding("surface.no-normals"))
    warnings: list[Finding] = []
    lengths = np.linalg.norm(normals, axis=1)
    is_valid = np.isfinite(points).all(axis=1) & np.isfinite(lengths) & (lengths > 1e-6)
    if not is_valid.all():
        warnings.append(Finding("surface.points-left-out", count=int((~is_valid).sum())))
        points, normals, lengths = points[is_valid], normals[is_valid], lengths[is_valid]
        colors = None if colors is None else colors[is_valid]
    if len(points) < _MIN_POINTS:
        raise GeometryError(Finding("surface.few-points", points=len(points), least=_MIN_POINTS))
    normals = (normals / lengths[:, None]).astype(np.float32)
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
    # The nearest neighbours of random surface points are at half the step of a regular grid.
    return tree, float(np.median(distances))


def _octree_depth(points: FloatArray, spacing: float, faces: int | None) -> int:
    """Return the depth of the octree.

    Cells are about two nearest-neighbour spacings, and not so fine that simplification would remove
    most of them.
    """
    extent = 1.1 * float(np.ptp(points, axis=0).max())
    cell_size = 2.0 * spacing
    if faces is not None:
        covered_area = len(points) * (2 * spacing) ** 2
        cell_size = max(cell_size, 0.4 * math.sqrt(2 * covered_area / faces))
    return int(np.clip(math.ceil(math.log2(extent / cell_size) - 0.25), *_DEPTH_RANGE))


def _reconstruct_poisson(
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
    distances: FloatArray,
    max_distance: float,
    max_hole_width: float,
) -> tuple[BoolArray, int]:
    """Return which faces remain, and the number of holes closed by the Poisson surface.

    Inside the surface, faces within `max_distance` of the points remain. At the rim, the limit is
    lower.
    """
    face_distances = distances[faces].max(axis=1)
    is_kept = face_distances <= _RIM_DISTANCE_SHARE * max_distance
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
    piece_distances = np.zeros(count)
    np.maximum.at(piece_distances, labels, face_distances[rows])
    # A border of the Poisson surface is a rim, not a hole.
    is_rim = np.zeros(count, bool)
    is_rim[labels[(neighbours(faces)[rows] < 0).any(axis=1)]] = True
    is_sparse = (piece_distances <= max_distance) & ~is_rim
    is_closed = ~is_sparse & ~is_rim & (np.linalg.norm(high - low, axis=1) <= 1.2 * max_hole_width)
    is_kept[rows[(is_sparse | is_closed)[labels]]] = True
    is_kept |= _find_cracks(
        vertices,
        faces,
        ~is_kept & (face_distances <= max_distance),
        face_distances > max_distance,
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
    """Return the band faces that are too far from the air to be a rim.

    The distance is measured along the surface. These faces are narrow strips that no photo shows
    and that are only connected to the rim, such as the treads of joint steps.
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
    lengths = np.linalg.norm(vertices[used_vertices[start]] - vertices[used_vertices[end]], axis=1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first_rows = np.unique(low.astype(np.int64) << 32 | high, return_index=True)
    links = (np.maximum(lengths[first_rows], 1e-12), (low[first_rows], high[first_rows]))
    graph = coo_matrix(links, shape=(len(used_vertices), len(used_vertices))).tocsr()
    is_adjacent_to_air = np.zeros(len(vertices), bool)
    is_adjacent_to_air[faces[is_air]] = True
    seeds = np.flatnonzero(is_adjacent_to_air[used_vertices])
    distances = np.full(len(used_vertices), np.inf)
    if len(seeds):
        max_rim_width = _MAX_RIM_WIDTH_SHARE * max_distance
        distances = dijkstra(
            graph, directed=False, indices=seeds, min_only=True, limit=max_rim_width
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
    from vomstudio.photogrammetry.surface._surface_kernels import move_onto_points

    refined_vertices = np.ascontiguousarray(vertices.copy())
    unit_normals = vertex_normals(vertices, faces)
    batch_size = 100_000
    for start in range(0, len(refined_vertices), batch_size):
        progress.step(start)
        batch = slice(start, start + batch_size)
        distances, nearest_rows = tree.query(
            refined_vertices[batch], k=min(_N_NEIGHBOURS, len(points)), workers=1
        )
        rows = start + np.flatnonzero(distances[:, 0] < 4 * width)
        subset, subset_normals = (
            np.ascontiguousarray(refined_vertices[rows]),
            np.ascontiguousarray(unit_normals[rows]),
        )
        neighbour_rows = np.ascontiguousarray(nearest_rows[rows - start].astype(np.int64))
        move_onto_points(
            subset, subset_normals, neighbour_rows, points, normals, width, 2.5 * width
        )
        refined_vertices[rows] = subset
    normals_before = cross_products(vertices, faces)
    for _ in range(5):
        normals_after = cross_products(refined_vertices, faces)
        is_flipped = (normals_before * normals_after).sum(axis=1) < 0.2 * np.linalg.norm(
            normals_before, axis=1
        ) * (np.linalg.norm(normals_after, axis=1))
        if not is_flipped.any():
            break
        rows = np.unique(faces[is_flipped])
        refined_vertices[rows] = vertices[rows]
    return refined_vertices


def _decimate(
    vertices: FloatArray, faces: Int32Array, target: int
) -> tuple[FloatArray, Int32Array]:
    """Simplify a mesh by quadric error metrics.

    The number of triangles is checked, because libraries may fail silently. If they do, the mesh is
    returned unchanged.
    """
    import open3d

    # The stubs of Open3D lack these arguments.
    o3d: Any = open3d
    mesh = o3d.t.geometry.TriangleMesh(o3d.core.Tensor(vertices), o3d.core.Tensor(faces))
    reduction = 1 - target / len(faces)
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        simplified_mesh = mesh.simplify_quadric_decimation(reduction)
        result = simplified_mesh.vertex.positions.numpy(), simplified_mesh.triangle.indices.numpy()
        if not 0.5 * target <= len(result[1]) <= 1.05 * target or not np.isfinite(result[0]).all():
            legacy_mesh = o3d.geometry.TriangleMesh(
                o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces)
            ).simplify_quadric_decimation(target)
            result = np.asarray(legacy_mesh.vertices), np.asarray(legacy_mesh.triangles)
    if len(result[1]) > 0.98 * len(faces) or not len(result[1]):
        return vertices, faces
    return np.asarray(result[0], np.float64), np.asarray(result[1], np.int32)


def _remove_islands(
    vertices: FloatArray, faces: Int32Array, min_face_count: int
) -> tuple[FloatArray, Int32Array, int]:
    """Remove small pieces, but never the largest one."""
    if not len(faces):
        return vertices, faces, 0
    pieces = components(faces)
    sizes = np.bincount(pieces)
    is_small = (sizes < min_face_count) & (np.arange(len(sizes)) != sizes.argmax())
    if not is_small.any():
        return vertices, faces, 0
    vertices, faces, _ = compact(vertices, faces[~is_small[pieces]])
    return vertices, faces, int(is_small.sum())


def _orient_to_normals(
    vertices: FloatArray, faces: Int32Array, tree: Any, normals: Float32Array
) -> Int32Array:
    """Orient the faces of each piece counter-clockwise, seen from outside the rock."""
    centres = vertices[faces].mean(axis=1)
    nearest_rows = tree.query(centres)[1]
    agreements = (cross_products(vertices, faces) * normals[nearest_rows]).sum(axis=1)
    pieces = components(faces)
    is_reversed = np.bincount(pieces, agreements)[pieces] < 0
    faces = faces.copy()
    faces[is_reversed] = faces[is_reversed][:, ::-1]
    return faces


def _vertex_colors(vertices: FloatArray, tree: Any, colors: ByteArray | None) -> ByteArray | None:
    if colors is None:
        return None
    nearest_rows = tree.query(vertices, k=min(4, tree.n))[1].reshape(len(vertices), -1)
    return np.asarray(
        np.rint(colors[nearest_rows].astype(np.float32).mean(axis=1)).astype(np.uint8)
    )


def _verify_mesh(vertices: FloatArray, faces: Int32Array) -> None:
    if not len(faces):
        raise GeometryError(Finding("surface.nothing-left"))
    if not np.isfinite(vertices).all() or not is_manifold(faces):
        raise GeometryError(Finding("surface.not-a-mesh"))
