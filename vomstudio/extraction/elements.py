"""Surface elements: the faces of a mesh or the points of a cloud.

They have neighbours, normals, areas and a local resolution, and form the facets.
"""

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
from vomstudio.extraction.kernels import average_normals, neighbour_cosines
from vomstudio.extraction.point_neighbours import (
    MAX_ANGLE_SHARE,
    MIN_CELL_CLOUD_POINTS,
    NORMAL_POINT_COUNTS,
    PointNeighbourhoods,
    estimate_normals,
    find_neighbourhoods,
    find_scattered_points,
    is_noise_dominated,
)
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.cell_lists import find_bounds
from vomstudio.geometry.kernels.jit import to_kernel_array, to_read_only_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.shared_corners import (
    check_connected,
    first_faces,
    neighbours_across_gaps,
    snap_corners,
)

_MAX_SMOOTHING_PASSES = 12
# Not from a paper: minimum number of faces and roughness of a noisy mesh, in which the normals of
# neighbouring faces differ by 30 degrees or more.
_MIN_NOISY_FACES, _MIN_NOISE = 1_000, 0.12
_POINTS_PER_CELL = 16.0
MIN_POINTS_AROUND = 20
"""Minimum number of points in and around a cell for fitting a plane."""
_MAX_NOISE_SAMPLE = 40_000
_MIN_SPARSE_POINTS = 1_000
_MAX_MEDIAN_SAMPLE = 100_000
_MAX_NORMAL_ERROR_DEG, _MAX_WRONG_SHARE = 30.0, 0.03
# Maximum variation of points that define a normal; an edge of 60 degrees reaches this value.
_MAX_FLAT_VARIATION = 0.06
NO_SURFACE = 1.0 / 3.0
"""Surface variation of a point that is not part of a surface."""
# A point is isolated if its neighbours are this many times farther from it than from their own
# neighbours.
_MAX_DISTANCE_RATIO = 2.0


@dataclass(frozen=True, eq=False)
class CellPlanes:
    """Planes of cells, transferred to the points (n,) of a cloud sorted by cell.

    Parameters
    ----------
    labels : (n,) int32 array
        Plane of each point; -1 if it belongs to none.
    is_open : (n,) bool array
        Points that must be analysed individually.
    normals, variation, areas, noise : arrays
        Properties of the neighbourhood of each point, see `Elements`.
    neighbourhood_width : float
        Width of the neighbourhoods that define normals if the noise exceeds the spacing, m; inf if
        no neighbourhood defines normals. 0 if the noise is smaller than the spacing.
    """

    labels: Int32Array
    is_open: BoolArray
    normals: FloatArray
    variation: FloatArray
    areas: FloatArray
    noise: FloatArray
    neighbourhood_width: float = 0.0


def approximate_median(values: FloatArray) -> float:
    """Return the median of values; if there are many, the median of a regular sample.

    Parameters
    ----------
    values : (n,) ndarray

    Returns
    -------
    float
    """
    return float(np.median(values[:: max(1, len(values) // _MAX_MEDIAN_SAMPLE)]))


PlaneFinder = Callable[[FloatArray, bool], tuple[CellGrid, CellPlanes]]
"""Function that finds planes on cells of points (n, 3), given whether the noise is large."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Elements of a surface; lengths are in the unit of the World frame.

    Parameters
    ----------
    kind : {"face", "point", "cell"}
        Kind of element; a cell contains the points in a cube.
    origin : (3,) array
        Offset to be added to `places`.
    places : (n, 3) array
        Positions relative to the origin.
    normals : (n, 3) array
        Unit vectors with arbitrary sign; NaN if unknown.
    areas : (n,) array
    inner_moments : (n, 6) array
        Second moments of each element about its position, divided by its area (xx, yy, zz, xy, xz,
        yz), or a single row of zeros for all.
    variation : (n,) array
        Surface variation: 0 if flat, `NO_SURFACE` for isolated or scattered points, NaN if
        unknown.
    spacing, noise : (n,) arrays
        Mean local spacing of the points of the model, and their scatter about the surface.
    starts, neighbours : int arrays
        The neighbours of element e are neighbours[starts[e]:starts[e + 1]]. Points that scatter in
        all directions have no neighbours.
    rows : (n,) int array
        Face or point of the model for each element.
    inverse_rows : int array
        Element of each face or point of the model; -1 for those that do not belong to an element.
    warnings : tuple of Finding
    initial_labels : (n,) int32 array, optional
        Facets known in advance; points inside them have no list of neighbours.
    around : int
        Number of points used for normals and variation; 0 for wide neighbourhoods and for elements
        that are not points.
    has_fewest_neighbours : (n,) bool array, optional
        Points for which the smallest number of neighbours is used; None if there are no such
        points.
    """

    kind: Literal["face", "point", "cell"]
    origin: FloatArray
    places: FloatArray
    normals: FloatArray
    areas: FloatArray
    inner_moments: FloatArray
    variation: FloatArray
    spacing: FloatArray
    noise: FloatArray
    starts: IntArray
    neighbours: Int32Array
    rows: IntArray
    inverse_rows: IntArray
    warnings: tuple[Finding, ...] = ()
    initial_labels: Int32Array | None = None
    around: int = 0
    has_fewest_neighbours: BoolArray | None = None

    @cached_property
    def typical_area(self) -> float:
        """Typical area of an element."""
        return approximate_median(self.areas)

    def __len__(self) -> int:
        return len(self.places)


def build_elements(
    data: Mesh | PointCloud,
    angle_deg: float,
    progress: Progress,
    find_planes: PlaneFinder | None = None,
) -> Elements:
    """Build the surface elements of a model.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    angle_deg : float
        Maximum angle between the normals within a facet. Normals are averaged over a part of the
        surface whose size depends on their noise.
    progress : Progress
    find_planes : callable, optional
        Function that finds planes on the cells of a large cloud before its points are analysed
        individually.

    Returns
    -------
    Elements

    Raises
    ------
    GeometryError
        If the model has no surface.
    Cancelled
        Through `progress`.
    """
    if isinstance(data, Mesh) and len(data.faces):
        return _mesh_elements(data, angle_deg, progress)
    points = data.vertices if isinstance(data, Mesh) else data.points
    normals = None if isinstance(data, Mesh) else data.normals
    return _cloud_elements(points, normals, angle_deg, progress, find_planes)


# --- clouds -----------------------------------------------------------------------------------
def _cloud_elements(
    points: FloatArray,
    file_normals: Float32Array | None,
    angle_deg: float,
    progress: Progress,
    find_planes: PlaneFinder | None,
) -> Elements:
    grid, cell_planes, finite_indices, origin = _build_grid(points, find_planes)
    positions = grid.places
    if len(positions) < 4:
        raise GeometryError(Finding("cloud.too-few-points", n=len(positions), minimum=4))
    rows, inverse_rows = grid.rows, grid.inverse_rows
    if finite_indices is not None:
        rows, inverse_rows = finite_indices[rows], np.full(len(points), -1, np.int64)
        inverse_rows[finite_indices] = grid.inverse_rows
    open_indices = (
        np.arange(len(positions)) if cell_planes is None else np.flatnonzero(cell_planes.is_open)
    )
    point_count = None if cell_planes is None else _required_neighbour_count(cell_planes, angle_deg)
    is_sparse, scattered_rows, scattered_area = None, open_indices[:0], 0.0
    if len(positions) >= MIN_CELL_CLOUD_POINTS:
        is_sparse = grid.count_neighbourhood_points() < MIN_POINTS_AROUND
        open_indices, scattered_rows, scattered_area = _separate_scattered_points(
            grid, open_indices, is_sparse
        )
    points_per_normal, surroundings = find_neighbourhoods(
        grid, open_indices, is_sparse, point_count, angle_deg, progress
    )
    neighbour_count = np.zeros(len(positions) + 1, np.int64)
    neighbour_count[open_indices + 1] = surroundings.neighbours.shape[1]
    warnings: list[Finding] = []
    if cell_planes is not None and cell_planes.neighbourhood_width:
        points_per_normal = 0
        values = cell_planes.normals, cell_planes.variation, cell_planes.areas, cell_planes.noise
        if np.isfinite(cell_planes.neighbourhood_width):
            warnings.append(_noise_warning(cell_planes))
    else:
        values = _combine_neighbourhoods(open_indices, surroundings, cell_planes, len(positions))
    normals, variation, areas, noise = values
    if points_per_normal:
        (
            normals[scattered_rows],
            variation[scattered_rows],
            areas[scattered_rows],
            noise[scattered_rows],
        ) = np.nan, NO_SURFACE, scattered_area, 0.0
    if file_normals is not None:
        normals = _merge_normals(
            np.asarray(file_normals, np.float64)[rows], normals, variation, warnings
        )
    has_fewest_neighbours = None
    if points_per_normal and (surroundings.point_counts < points_per_normal).any():
        has_fewest_neighbours = np.zeros(len(positions), np.bool_)
        has_fewest_neighbours[open_indices[surroundings.point_counts < points_per_normal]] = True
    return Elements(
        "point",
        origin,
        positions,
        to_kernel_array(normals, np.float64),
        areas,
        np.zeros((1, 6)),
        variation,
        np.sqrt(areas),
        noise,
        np.cumsum(neighbour_count),
        surroundings.neighbours.ravel(),
        rows,
        inverse_rows,
        tuple(warnings),
        None if cell_planes is None else cell_planes.labels,
        points_per_normal,
        has_fewest_neighbours,
    )


def _build_grid(
    points: FloatArray, find_planes: PlaneFinder | None
) -> tuple[CellGrid, CellPlanes | None, IntArray | None, FloatArray]:
    """Sort points into cells and find planes on the cells.

    Return the grid, the planes found on its cells (None if they were not searched for), the rows of
    the finite points (None if all are finite), and the origin of the positions.
    """
    coordinates = to_read_only_array(points, np.float64)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    invalid_count = find_bounds(coordinates, low, high)
    if len(points) - invalid_count < 4:
        raise GeometryError(
            Finding("cloud.too-few-points", n=len(points) - invalid_count, minimum=4)
        )
    finite_indices = np.flatnonzero(np.isfinite(points).all(axis=1)) if invalid_count else None
    origin = np.floor(low)
    local_points = (coordinates if finite_indices is None else coordinates[finite_indices]) - origin
    is_noisy = (
        find_planes is not None
        and len(local_points) < MIN_CELL_CLOUD_POINTS
        and is_noise_dominated(local_points)
    )
    if find_planes is not None and (is_noisy or len(local_points) >= MIN_CELL_CLOUD_POINTS):
        return *find_planes(local_points, is_noisy), finite_indices, origin
    return create_cell_grid(local_points, _POINTS_PER_CELL), None, finite_indices, origin


def _separate_scattered_points(
    grid: CellGrid, open_rows: IntArray, is_sparse: BoolArray
) -> tuple[IntArray, IntArray, float]:
    """Separate open points that are analysed from scattered points in sparse cells.

    Return the rows of both and the area of each scattered point.
    """
    is_in_sparse_cell = is_sparse[grid.find_cells(open_rows)]
    if is_in_sparse_cell.sum() < _MIN_SPARSE_POINTS:
        return open_rows, open_rows[:0], 0.0
    is_scattered = np.zeros(len(open_rows), np.bool_)
    is_scattered[is_in_sparse_cell], area = find_scattered_points(
        grid.places[open_rows[is_in_sparse_cell]]
    )
    return open_rows[~is_scattered], open_rows[is_scattered], area


def _combine_neighbourhoods(
    open_rows: IntArray, surroundings: PointNeighbourhoods, cell_planes: CellPlanes | None, n: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Combine normals, variation, areas and noise of n points from open points and cells."""
    neighbour_count = surroundings.neighbours.shape[1]
    if cell_planes is None:
        normals, variation, areas, noise = np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
    else:
        normals, variation, areas, noise = (
            cell_planes.normals,
            cell_planes.variation,
            cell_planes.areas,
            cell_planes.noise,
        )
    normals[open_rows], variation[open_rows] = surroundings.normals, surroundings.variation
    farthest_distance = surroundings.farthest_distances
    areas[open_rows] = np.pi * farthest_distance**2 / neighbour_count
    neighbour_areas = np.sort(areas[surroundings.neighbours], axis=1)
    typical_spacing = (
        np.sqrt(neighbour_areas[:, (neighbour_count - 1) // 2])
        + np.sqrt(neighbour_areas[:, neighbour_count // 2])
    ) / 2.0
    typical_spacing *= np.sqrt(neighbour_count / np.pi)
    isolated_rows = open_rows[farthest_distance > 2.0 * _MAX_DISTANCE_RATIO * typical_spacing]
    areas[open_rows] = (
        np.pi
        * np.minimum(farthest_distance, _MAX_DISTANCE_RATIO * typical_spacing) ** 2
        / neighbour_count
    )
    # In a disc of area A, the variance along each diameter is A / (4 pi).
    variance = (
        np.maximum(surroundings.variation, 0.0) * surroundings.point_counts * areas[open_rows]
    )
    noise[open_rows] = np.sqrt(variance / (2.0 * np.pi))
    normals[isolated_rows], variation[isolated_rows] = np.nan, NO_SURFACE
    return normals, variation, areas, noise


def _noise_warning(cell_planes: CellPlanes) -> Finding:
    noise = float(np.median(cell_planes.noise))
    return Finding(
        "cloud.noisy",
        noise_m=noise,
        times=noise / float(np.sqrt(np.median(cell_planes.areas))),
        width_m=cell_planes.neighbourhood_width,
    )


def _required_neighbour_count(cell_planes: CellPlanes, angle_deg: float) -> int | None:
    """Return the number of neighbours for stable normals, based on the noise within planes.

    Return None if planes cover less than half of the cloud.
    """
    if cell_planes.neighbourhood_width:
        return NORMAL_POINT_COUNTS[0]
    n = len(cell_planes.is_open)
    if 2 * int(cell_planes.is_open.sum()) > n:
        return None
    closed_rows = np.flatnonzero(~cell_planes.is_open)[:: max(1, n // _MAX_NOISE_SAMPLE)]
    noise = float(
        np.median(cell_planes.noise[closed_rows] / np.sqrt(cell_planes.areas[closed_rows]))
    )
    # With k points and this noise, the error of a normal is 2 sqrt(pi) noise / (spacing k). The
    # normals of neighbours, which share points, have about the same median difference.
    min_neighbours = 2.0 * np.sqrt(np.pi) * noise / np.radians(MAX_ANGLE_SHARE * angle_deg)
    return next(
        (count for count in NORMAL_POINT_COUNTS if count >= min_neighbours), NORMAL_POINT_COUNTS[-1]
    )


def _merge_normals(
    file_normals: FloatArray,
    fitted_normals: FloatArray,
    variation: FloatArray,
    warnings: list[Finding],
) -> FloatArray:
    """Replace fitted normals by the normals of the file if they agree with the points.

    If the median angle between both is large, or if too many of them differ in flat parts, a
    warning is appended and fewer or none of the file normals are used.

    Parameters
    ----------
    file_normals, fitted_normals : (n, 3) arrays
        NaN or zero if unknown; the fitted normals are unit vectors.
    variation : (n,) array
        Surface variation; it is large near edges, where fitted normals lie between the normals of
        two faces.
    warnings : list of Finding
    """
    size = np.linalg.norm(file_normals, axis=1)
    is_known = np.isfinite(size) & (size > 1e-6)
    unit = file_normals / np.where(is_known, size, 1.0)[:, None]
    cosine = np.abs((unit * fitted_normals).sum(axis=1))
    has_both_normals = is_known & np.isfinite(cosine)
    if not has_both_normals.any():
        return fitted_normals
    angle = float(np.degrees(np.arccos(min(float(np.median(cosine[has_both_normals])), 1.0))))
    if angle > _MAX_NORMAL_ERROR_DEG:
        warnings.append(Finding("cloud.normals-unused", angle_deg=angle))
        return fitted_normals
    is_flat = has_both_normals & (variation < _MAX_FLAT_VARIATION)
    is_wrong = is_flat & (cosine < np.cos(np.radians(_MAX_NORMAL_ERROR_DEG)))
    wrong_share = float(is_wrong.sum()) / max(int(is_flat.sum()), 1)
    if wrong_share > _MAX_WRONG_SHARE:
        warnings.append(
            Finding(
                "cloud.normals-partly-unused",
                share_percent=100.0 * wrong_share,
                limit_deg=_MAX_NORMAL_ERROR_DEG,
            )
        )
        # Near an edge just as many may be wrong, but the points do not reveal which ones.
        is_known &= is_flat
    return np.where((is_known & ~is_wrong)[:, None], unit, fitted_normals)


# --- meshes -----------------------------------------------------------------------------------
def _mesh_elements(mesh: Mesh, angle_deg: float, progress: Progress) -> Elements:
    vertices = np.asarray(mesh.vertices, np.float64)
    is_finite_vertex = np.asarray(np.isfinite(vertices).all(axis=1))
    faces = np.asarray(mesh.faces, np.int64)
    is_finite_face = is_finite_vertex[faces].all(axis=1)
    if not is_finite_face.any():
        raise GeometryError(Finding("model.no-faces"))
    origin = np.floor(vertices[is_finite_vertex].min(axis=0))
    local_points = np.where(is_finite_vertex[:, None], vertices, 0.0) - origin
    local_points = snap_corners(local_points, faces[is_finite_face])
    corners = local_points[faces]
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross_products = np.cross(edge_a, edge_b)
    doubled_areas = np.linalg.norm(cross_products, axis=1)
    # Slivers do not have reliable normals.
    longest_edges_squared = np.maximum((edge_a**2).sum(axis=1), (edge_b**2).sum(axis=1))
    rows = np.flatnonzero(is_finite_face & (doubled_areas > 1e-9 * longest_edges_squared))
    if not len(rows):
        raise GeometryError(Finding("mesh.no-area"))
    progress.stage(tr("Finding neighbours"), None)
    warnings: list[Finding] = []
    nodes = weld_points(local_points)[faces[rows]]
    check_connected(nodes, warnings)
    first = first_faces(nodes, warnings)
    rows, nodes = rows[first], nodes[first]
    inverse_rows = np.full(len(faces), -1, np.int64)
    inverse_rows[rows] = np.arange(len(rows))
    used_corners = corners[rows]
    starts, neighbours = _face_neighbours(nodes, used_corners)
    positions = used_corners.mean(axis=1)
    areas = doubled_areas[rows] / 2.0
    normals = cross_products[rows] / doubled_areas[rows, None]
    offsets = used_corners - positions[:, None]
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    inner_moments = np.stack(
        [(offsets[..., a] * offsets[..., b]).sum(axis=1) / 12.0 for a, b in pairs], axis=1
    )
    progress.stage(tr("Computing normals"), None)
    positions = to_kernel_array(positions, np.float64)
    normals, variation, is_stable = _stabilise_normals(
        to_kernel_array(normals, np.float64),
        to_kernel_array(areas, np.float64),
        starts,
        neighbours,
        angle_deg,
        progress,
    )
    if not is_stable:
        estimated_normals = estimate_normals(positions, angle_deg, progress)
        normals = normals if estimated_normals is None else estimated_normals
    # A mesh has about two faces per vertex.
    spacing = np.sqrt(2.0 * areas)
    return Elements(
        "face",
        origin,
        positions,
        normals,
        to_kernel_array(areas, np.float64),
        to_kernel_array(inner_moments, np.float64),
        variation,
        spacing,
        spacing * np.sqrt(np.maximum(np.nan_to_num(variation), 0.0)),
        starts,
        neighbours,
        rows,
        inverse_rows,
        tuple(warnings),
    )


def _face_neighbours(nodes: IntArray, corners: FloatArray) -> tuple[IntArray, Int32Array]:
    """List the neighbours of faces across edges and gaps.

    If more than two faces share an edge, they form a chain of neighbours.
    """
    k = len(nodes)
    a = nodes.ravel()
    b = np.roll(nodes, -1, axis=1).ravel()
    key = np.minimum(a, b) * (int(nodes.max()) + 1) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    is_same_edge = np.diff(key[order]) == 0
    first, second = order[:-1][is_same_edge] // 3, order[1:][is_same_edge] // 3
    previous_faces, _, next_faces = neighbours_across_gaps(nodes, corners)
    source = np.concatenate([first, second, previous_faces, next_faces])
    target = np.concatenate([second, first, next_faces, previous_faces])
    source_order = np.argsort(source, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(source, minlength=k))]).astype(np.int64)
    return starts, to_kernel_array(target[source_order], np.int32)


def _stabilise_normals(
    normals: FloatArray,
    areas: FloatArray,
    starts: IntArray,
    neighbours: Int32Array,
    angle_deg: float,
    progress: Progress,
) -> tuple[FloatArray, FloatArray, bool]:
    """Smooth normals until neighbouring normals agree, up to a maximum number of passes.

    Return the normals, the roughness (half the mean squared sine of the angles between each
    original face and its neighbours), and whether the normals are reliable: neighbours agree, or
    the mesh is not noisy.
    """
    if not len(neighbours):
        return normals, np.zeros(len(normals)), True
    cosine = np.empty(len(neighbours))
    neighbour_cosines(normals, starts, neighbours, cosine)
    number = np.diff(starts)
    source = np.repeat(np.arange(len(normals)), number)
    roughness = np.bincount(source, 1.0 - cosine**2, len(normals)) / np.maximum(number, 1) / 2.0
    # Do not smooth across sharp edges.
    min_cosine = float(np.cos(np.radians(min(2.5 * angle_deg, 60.0))))
    for _ in range(_MAX_SMOOTHING_PASSES):
        angle = np.degrees(np.arccos(min(float(np.median(cosine)), 1.0)))
        if angle <= 0.5 * MAX_ANGLE_SHARE * angle_deg:
            return normals, roughness, True
        out = np.empty_like(normals)
        average_normals(normals, areas, starts, neighbours, min_cosine, out)
        normals = out
        neighbour_cosines(normals, starts, neighbours, cosine)
        progress.step(0)
    # If the noise is about half of a side, faces have arbitrary orientations, and their positions
    # define better normals. The sharp edges of a mesh with few faces are real.
    angle = np.degrees(np.arccos(min(float(np.median(cosine)), 1.0)))
    is_noisy = len(normals) >= _MIN_NOISY_FACES and float(np.median(roughness)) > _MIN_NOISE
    return normals, roughness, not is_noisy or bool(angle <= 0.5 * MAX_ANGLE_SHARE * angle_deg)
