"""From a dense cloud to a surface: Poisson's, cut where no points are, sharpened, and checked."""

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
from vomstudio.core.progress import Progress, Silent
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

_FEWEST = 100
_DEPTHS = (5, 12)
_NEAR = 24
_BYTES_PER_POINT = 1000
_FEWEST_THINNED = 100_000
# At its rim a surface ends at this share of the distance up to which it is borne out.
_RIM_SHARE = 0.45
# So wide, in the same unit, is the strip at most that is cut off there.
_RIM_WIDTH = 1.1
# Pieces with a smaller share of all triangles are left out: bits of bushes, and what errs.
_ISLAND_SHARE = 0.0005


@dataclass(frozen=True)
class SurfaceOptions:
    """How a surface is made.

    faces : wanted number of triangles; None keeps what Poisson's method gives
    depth : of the octree; None chooses it from spacing, extent and wanted faces
    trim : vertices farther than this many spacings from any point are cut off
    largest_hole_m : holes up to this wide are closed; None: 30 spacings
    smallest_island_faces : pieces with fewer triangles of the finished surface are left out, and
        of large surfaces those with less than a two-thousandth of all
    sharpen : draw the vertices back to the points, which keeps steps and edges
    max_points : a larger cloud is thinned evenly first, which bounds the memory (about 1 GB for
        each million points)
    threads : of Poisson's method; with 1 the result is the same every time
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
class Surface:
    """facts : spacing_m, depth, faces_poisson, faces, cut_share, holes_closed, islands_left_out,
    area_m2, and so on, for the report. warnings : sentences"""

    mesh: Mesh
    facts: dict[str, Any]
    warnings: tuple[Finding, ...]


def fitting_points() -> int:
    """How many points may make a surface in the memory that is free."""
    most = memory.SHARE * memory.available_bytes() / _BYTES_PER_POINT
    return int(min(max(most, _FEWEST_THINNED), SurfaceOptions.max_points))


def build_surface(
    cloud: PointCloud,
    options: SurfaceOptions | None = None,
    progress: Progress | None = None,
) -> Surface:
    """The surface through a cloud whose normals point out of the rock, each to the photos that saw
    its point, as those of `fuse` do.

    Screened Poisson reconstruction (Kazhdan and Hoppe 2013), cut off where no points are near;
    small holes keep Poisson's surface. Coordinates are those of the cloud.

    Raises GeometryError for a cloud without normals, with too few points or without extent.
    Poisson's method and the simplification cannot be stopped within; Cancelled comes after them.
    """
    options, progress = options or SurfaceOptions(), progress or Silent()
    points, normals, colors, warnings = _checked(cloud, options)
    shift = points.mean(axis=0)
    points = np.ascontiguousarray(points - shift)
    progress.stage(tr("Measuring the point spacing"))
    tree, spacing = _spacing(points)
    depth = options.depth or _depth(points, spacing, options.faces)
    # An open cell of the octree is what Poisson's method resolves; the cut must not fall below it.
    cell = 1.1 * float(np.ptp(points, axis=0).max()) / 2**depth
    facts: dict[str, Any] = {"points": len(points), "spacing_m": spacing, "depth": depth}
    progress.stage(tr("Computing the Poisson surface (cannot be cancelled)"))
    vertices, faces = _poisson(points, normals, depth, options.threads)
    facts["faces_poisson"] = len(faces)
    progress.stage(tr("Trimming unsupported surface"))
    distance = tree.query(vertices, workers=1)[0]
    reach = options.trim * spacing
    hole = 30 * spacing if options.largest_hole_m is None else options.largest_hole_m
    keep, closed = _trim(vertices, faces, distance, reach, hole)
    if not keep.any():
        raise GeometryError(Finding("surface.nothing-left"))
    vertices, faces, _ = compact(vertices, faces[keep])
    facts |= {"cut_share": 1 - len(faces) / facts["faces_poisson"], "holes_closed": closed}
    if options.sharpen:
        progress.stage(tr("Refining the surface"))
        vertices = _refine(
            vertices, faces, points, normals, tree, max(1.5 * spacing, 0.9 * cell), progress
        )
    vertices, faces, pieces = _without_islands(vertices, faces, 20)
    if options.faces is not None and len(faces) > options.faces:
        progress.stage(tr("Decimating {count:,} triangles (cannot be cancelled)", count=len(faces)))
        vertices, faces = _decimate(vertices, faces, options.faces)
    progress.stage(tr("Checking the surface"))
    vertices, faces = make_manifold(vertices, faces)
    vertices, faces, islands = _without_islands(
        vertices, faces, max(options.smallest_island_faces, int(_ISLAND_SHARE * len(faces)))
    )
    faces = _toward_normals(vertices, faces, tree, normals)
    _verify(vertices, faces)
    mesh = Mesh(vertices + shift, faces, colors=_colors(vertices, tree, colors))
    facts |= {
        "faces": len(faces),
        "islands_left_out": pieces + islands,
        "area_m2": float(np.linalg.norm(cross_products(vertices, faces), axis=1).sum() / 2),
    }
    if options.faces is not None and len(faces) > 1.05 * options.faces:
        warnings.append(Finding("surface.not-decimated", faces=len(faces), wanted=options.faces))
    return Surface(mesh, facts, tuple(warnings))


def _checked(
    cloud: PointCloud, options: SurfaceOptions
) -> tuple[FloatArray, Float32Array, ByteArray | None, list[Finding]]:
    points, normals, colors = cloud.points, cloud.normals, cloud.colors
    if not len(points):
        raise GeometryError(Finding("surface.no-points"))
    if normals is None:
        raise GeometryError(Finding("surface.no-normals"))
    warnings: list[Finding] = []
    length = np.linalg.norm(normals, axis=1)
    sound = np.isfinite(points).all(axis=1) & np.isfinite(length) & (length > 1e-6)
    if not sound.all():
        warnings.append(Finding("surface.points-left-out", count=int((~sound).sum())))
        points, normals, length = points[sound], normals[sound], length[sound]
        colors = None if colors is None else colors[sound]
    if len(points) < _FEWEST:
        raise GeometryError(Finding("surface.few-points", points=len(points), least=_FEWEST))
    normals = (normals / length[:, None]).astype(np.float32)
    if len(points) > options.max_points:
        rows = _thinned(points, options.max_points)
        warnings.append(Finding("surface.thinned", total=len(points), points=len(rows)))
        points, normals = points[rows], normals[rows]
        colors = None if colors is None else colors[rows]
    if not np.ptp(points, axis=0).max() > 0:
        raise GeometryError(Finding("surface.coincident-points"))
    return points, normals, colors, warnings


def _thinned(points: FloatArray, wanted: int) -> IntArray:
    """Every k-th point along a curve that goes through space cell by cell."""
    cells = np.floor((points - points.min(axis=0)) / (np.ptp(points, axis=0).max() / 1023 + 1e-300))
    order = np.lexsort(cells.T)
    return np.sort(order[np.linspace(0, len(points) - 1, wanted).astype(np.int64)])


def _spacing(points: FloatArray) -> tuple[Any, float]:
    from scipy.spatial import cKDTree

    tree = cKDTree(points, balanced_tree=False)
    some = points[:: max(1, len(points) // 20_000)]
    near = tree.query(some, k=2)[0][:, 1]
    near = near[near > 0]
    if not len(near):
        raise GeometryError(Finding("surface.coincident-points"))
    # Along a surface, points at random have neighbours at half the step of a regular grid.
    return tree, float(np.median(near))


def _depth(points: FloatArray, spacing: float, faces: int | None) -> int:
    """Cells of about two spacings to the nearest neighbour (the step of the pixels, where points
    are at random), and not so fine that simplification would throw away most of them."""
    extent = 1.1 * float(np.ptp(points, axis=0).max())
    cell = 2.0 * spacing
    if faces is not None:
        covered = len(points) * (2 * spacing) ** 2
        cell = max(cell, 0.4 * math.sqrt(2 * covered / faces))
    return int(np.clip(math.ceil(math.log2(extent / cell) - 0.25), *_DEPTHS))


def _poisson(
    points: FloatArray, normals: Float32Array, depth: int, threads: int
) -> tuple[FloatArray, Int32Array]:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.normals = o3d.utility.Vector3dVector(normals.astype(np.float64))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        made, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(
            cloud, depth=depth, n_threads=max(1, threads)
        )
    vertices, faces = np.asarray(made.vertices), np.asarray(made.triangles, np.int32)
    whole = np.isfinite(vertices).all(axis=1)
    return vertices.copy(), faces[whole[faces].all(axis=1)]


def _trim(
    vertices: FloatArray, faces: Int32Array, distance: FloatArray, reach: float, hole: float
) -> tuple[BoolArray, int]:
    """Which faces stay, and how many holes were closed by letting Poisson's surface stay there.

    Within `reach` of the points the surface stays where it goes on behind; at its rim, where it
    would lap over into the air, it ends sooner.
    """
    farthest = distance[faces].max(axis=1)
    keep = farthest <= _RIM_SHARE * reach
    if keep.all() or not keep.any():
        return keep, 0
    piece = components(faces, ~keep)
    count = int(piece.max()) + 1
    rows = np.flatnonzero(~keep)
    labels = piece[rows]
    corners = vertices[faces[rows]]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, labels, corners.min(axis=1))
    np.maximum.at(high, labels, corners.max(axis=1))
    far = np.zeros(count)
    np.maximum.at(far, labels, farthest[rows])
    # Where Poisson's surface itself ends there is no hole but a rim.
    rim = np.zeros(count, bool)
    rim[labels[(neighbours(faces)[rows] < 0).any(axis=1)]] = True
    sparse = (far <= reach) & ~rim
    closed = ~sparse & ~rim & (np.linalg.norm(high - low, axis=1) <= 1.2 * hole)
    keep[rows[(sparse | closed)[labels]]] = True
    keep |= _cracks(vertices, faces, ~keep & (farthest <= reach), farthest > reach, reach)
    return keep, int(closed.sum())


def _cracks(
    vertices: FloatArray,
    faces: Int32Array,
    band: BoolArray,
    air: BoolArray,
    reach: float,
) -> BoolArray:
    """Those of the band about the points that lie farther from the air, along the surface, than a
    rim is wide: narrow strips that no photo saw, such as the treads of joint steps, which only
    hang together with the rim."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    found = np.zeros(len(faces), bool)
    rows = np.flatnonzero(band)
    if not len(rows):
        return found
    used, corners = np.unique(faces[rows], return_inverse=True)
    corners = corners.reshape(-1, 3)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    length = np.linalg.norm(vertices[used[start]] - vertices[used[end]], axis=1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first = np.unique(low.astype(np.int64) << 32 | high, return_index=True)
    links = (np.maximum(length[first], 1e-12), (low[first], high[first]))
    graph = coo_matrix(links, shape=(len(used), len(used))).tocsr()
    beside = np.zeros(len(vertices), bool)
    beside[faces[air]] = True
    seeds = np.flatnonzero(beside[used])
    far = np.full(len(used), np.inf)
    if len(seeds):
        rim = _RIM_WIDTH * reach
        far = dijkstra(graph, directed=False, indices=seeds, min_only=True, limit=rim)
    found[rows] = np.isinf(far[corners]).all(axis=1)
    return found


def _refine(
    vertices: FloatArray,
    faces: Int32Array,
    points: FloatArray,
    normals: Float32Array,
    tree: Any,
    width: float,
    progress: Progress,
) -> FloatArray:
    """Vertices on the points near them; those whose faces would turn over stay."""
    from vomstudio.photogrammetry.surface._surface_kernels import pull_to_points

    moved = np.ascontiguousarray(vertices.copy())
    facing = vertex_normals(vertices, faces)
    step = 100_000
    for start in range(0, len(moved), step):
        progress.step(start)
        part = slice(start, start + step)
        distance, near = tree.query(moved[part], k=min(_NEAR, len(points)), workers=1)
        rows = start + np.flatnonzero(distance[:, 0] < 4 * width)
        some, ahead = np.ascontiguousarray(moved[rows]), np.ascontiguousarray(facing[rows])
        chosen = np.ascontiguousarray(near[rows - start].astype(np.int64))
        pull_to_points(some, ahead, chosen, points, normals, width, 2.5 * width)
        moved[rows] = some
    before = cross_products(vertices, faces)
    for _ in range(5):
        after = cross_products(moved, faces)
        turned = (before * after).sum(axis=1) < 0.2 * np.linalg.norm(before, axis=1) * (
            np.linalg.norm(after, axis=1)
        )
        if not turned.any():
            break
        rows = np.unique(faces[turned])
        moved[rows] = vertices[rows]
    return moved


def _decimate(
    vertices: FloatArray, faces: Int32Array, wanted: int
) -> tuple[FloatArray, Int32Array]:
    """Quadric error metrics. Each library fails at times without a word, hence the count."""
    import open3d

    # Its stubs know none of its own arguments.
    o3d: Any = open3d
    mesh = o3d.t.geometry.TriangleMesh(o3d.core.Tensor(vertices), o3d.core.Tensor(faces))
    share = 1 - wanted / len(faces)
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        made = mesh.simplify_quadric_decimation(share)
        found = made.vertex.positions.numpy(), made.triangle.indices.numpy()
        if not 0.5 * wanted <= len(found[1]) <= 1.05 * wanted or not np.isfinite(found[0]).all():
            old = o3d.geometry.TriangleMesh(
                o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces)
            ).simplify_quadric_decimation(wanted)
            found = np.asarray(old.vertices), np.asarray(old.triangles)
    if len(found[1]) > 0.98 * len(faces) or not len(found[1]):
        return vertices, faces
    return np.asarray(found[0], np.float64), np.asarray(found[1], np.int32)


def _without_islands(
    vertices: FloatArray, faces: Int32Array, smallest: int
) -> tuple[FloatArray, Int32Array, int]:
    """Never the largest piece, however small it is."""
    if not len(faces):
        return vertices, faces, 0
    piece = components(faces)
    size = np.bincount(piece)
    small = (size < smallest) & (np.arange(len(size)) != size.argmax())
    if not small.any():
        return vertices, faces, 0
    vertices, faces, _ = compact(vertices, faces[~small[piece]])
    return vertices, faces, int(small.sum())


def _toward_normals(
    vertices: FloatArray, faces: Int32Array, tree: Any, normals: Float32Array
) -> Int32Array:
    """Counter-clockwise as seen from the air; piece by piece, since sheets may be turned over."""
    middle = vertices[faces].mean(axis=1)
    nearest = tree.query(middle)[1]
    agree = (cross_products(vertices, faces) * normals[nearest]).sum(axis=1)
    piece = components(faces)
    wrong = np.bincount(piece, agree)[piece] < 0
    faces = faces.copy()
    faces[wrong] = faces[wrong][:, ::-1]
    return faces


def _colors(vertices: FloatArray, tree: Any, colors: ByteArray | None) -> ByteArray | None:
    if colors is None:
        return None
    near = tree.query(vertices, k=min(4, tree.n))[1].reshape(len(vertices), -1)
    return np.asarray(np.rint(colors[near].astype(np.float32).mean(axis=1)).astype(np.uint8))


def _verify(vertices: FloatArray, faces: Int32Array) -> None:
    if not len(faces):
        raise GeometryError(Finding("surface.nothing-left"))
    if not np.isfinite(vertices).all() or not is_manifold(faces):
        raise GeometryError(Finding("surface.not-a-mesh"))
