"""Map of the expected error of a plane of given attitude before any points are picked.

A bed can be measured well where the outcrop face changes direction, but not on a single flat wall,
because its trace is straight there. For each piece of the surface, a plane of the given attitude is
placed through it. The line along which this plane cuts the surface, limited to the length of a
trace, has a covariance like the vertices of a picked trace. With the noise of the model across the
plane and one independent point per resolution along the line, the joint 95 % region of the normal
follows from `geometry.plane_errors`. As for a picked trace, the error is at least the tilt that the
resolution allows over the shorter axis of the line, and includes the registration error.

If the face is nearly parallel to the plane, it exposes the plane as a surface. The expected error
is then the error of a patch of this size (`geometry.plane_sizes`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, Int8Array, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.extraction.decimation import thin_mesh
from vomstudio.extraction.elements import Elements, build_elements
from vomstudio.extraction.measurable_kernels import square_longest_sides
from vomstudio.extraction.measurable_lines import (
    CELL_STRIPS,
    connected_pieces,
    intersection_moments,
    strip_half_width,
)
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.extraction.refinement import subdivide_mesh
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.kernels.jit import to_read_only_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.plane_errors import confidence_axes_rad, joint_quantile
from vomstudio.geometry.plane_sizes import (
    NOISE_PIXELS,
    PIXELS_PER_RESOLUTION,
    POINT_OVER_RESOLUTION,
    PlaneSizes,
)
from vomstudio.geometry.resolution import (
    NEIGHBOUR_COUNTS,
    effective_resolution,
    neighbour_statistics,
    resolving_points,
)
from vomstudio.geometry.rotation_errors import CHI2_TWO

QUALITY_CLASSES = ("none", "poor", "doubtful", "good")
"""Classes of the expected error, worst first; "none" means that the plane is undetermined."""
MAX_GOOD_DEG, MAX_POOR_DEG = 5.0, 15.0
MIN_EXTENT_RESOLUTIONS = 10.0
MIN_LENGTH_RESOLUTIONS = 4.0
"""Minimum length of a trace, in model resolutions."""
DEFAULT_LENGTH_RESOLUTIONS = 100.0
"""Default length of a trace, in model resolutions."""
_NORMAL_ANGLE_DEG = 20.0
_MIN_PIECES = 4
_MIN_CELL_RATIO = 1.25
"""Ratio of cell size to the typical side of a face above which a cell contains several faces."""
_MIN_RESOLUTION_RATIO = 0.6
"""Lower bound for the ratio of the resolution of the surface to that of all points."""
# Number of positions, evenly distributed over the area, at which the resolution is estimated, and
# of positions that show whether the noise exceeds the spacing.
_RESOLUTION_SAMPLES, _NOISE_SAMPLES = 4000, 100


@dataclass(frozen=True, eq=False)
class Measurable:
    """Expected errors on n pieces of a surface (faces of a mesh, or points of a cloud).

    Parameters
    ----------
    elements : Elements
    trace_deg : (n,) array
        Expected 95 % error of a trace through each piece, degrees. 90 if any plane through the line
        is possible; NaN if no line exists because the face is parallel to the plane or has no
        normal.
    patch_deg : (n,) array
        Expected 95 % error of the exposed patch, degrees; NaN outside patches, and for patches
        smaller than ten resolutions.
    extent, relief : (n,) arrays
        Longest and shorter axes of the line, m.
    classes : (n,) int8 array
        Index into `QUALITY_CLASSES` for the better of trace and patch.
    patches : (n,) int32 array
        Number of the patch of each piece; -1 outside patches.
    areas : (n,) array
        Area of each piece, m².
    resolutions : (n,) array
        Local resolution of the model, m.
    length : float
        Length of a trace, m.
    resolution, noise : float
        Typical values for the model, m.
    warnings : tuple of Finding
    nodes : (vertices of the model,) int array, optional
        Vertex of the map for each vertex of a decimated mesh; None if the mesh was not decimated.
    """

    elements: Elements
    trace_deg: FloatArray
    patch_deg: FloatArray
    extent: FloatArray
    relief: FloatArray
    classes: Int8Array
    patches: Int32Array
    areas: FloatArray
    resolutions: FloatArray
    length: float
    resolution: float
    noise: float
    warnings: tuple[Finding, ...]
    nodes: IntArray | None = None

    @property
    def trace_classes(self) -> Int8Array:
        """Index (n,) into `QUALITY_CLASSES` for traces only."""
        return _classify_errors(self.trace_deg, self.extent, self.resolutions)

    @property
    def best_deg(self) -> FloatArray:
        """Expected 95 % error (n,) of the better of trace and patch, degrees; 90 if undefined."""
        return np.asarray(np.fmin(np.fmin(self.trace_deg, self.patch_deg), 90.0))


def typical_resolution(data: Mesh | PointCloud) -> float:
    """Estimate the typical effective resolution of a model, as around a picked trace.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.

    Returns
    -------
    float
        Resolution in metres.

    Raises
    ------
    GeometryError
        If there are fewer than four points, or if all points coincide.
    """
    from scipy.spatial import cKDTree

    points = resolving_points(data)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) > 3:
        points = points - points.mean(axis=0)
        tree = cKDTree(points, leafsize=32, compact_nodes=False, balanced_tree=False)
        resolution = effective_resolution(
            points, tree, points[:: max(1, len(points) // _NOISE_SAMPLES)]
        )
        if resolution is not None and resolution > 0.0:
            return resolution
    raise GeometryError(Finding("model.no-resolution"))


def map_measurability(
    data: Mesh | PointCloud,
    normal: npt.ArrayLike,
    options: MeasurableOptions,
    progress: Progress | None = None,
) -> Measurable:
    """Map how accurately a plane of given attitude can be measured on a surface.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    normal : (3,) array_like
        Normal of the plane in the World frame.
    options : MeasurableOptions
        Must contain the length of a trace.
    progress : Progress, optional

    Returns
    -------
    Measurable

    Raises
    ------
    GeometryError
        If the model has no surface, or if the length is too short for a trace on the model.
    Cancelled
        Through `progress`.
    """
    assert options.length_m is not None
    length = options.length_m
    progress = progress or SilentProgress()
    surface = _prepare_surface(data, length, options.resolution_m, progress)
    elements = surface.elements
    if options.resolution_m is None:
        resolution = _estimate_resolutions(resolving_points(data), elements)
    else:
        resolution = np.full(len(elements), options.resolution_m)
    return _map_elements(
        surface, np.asarray(normal, np.float64), resolution, length, options, progress
    )


# --- the surface ------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class _ShortPieces:
    """Pieces of a surface that are all short compared with a trace.

    `source_rows` (n,) is the face or point of the model that each piece belongs to. See
    `Measurable` for `nodes`.
    """

    elements: Elements
    source_rows: IntArray
    nodes: IntArray | None = None


def _prepare_surface(
    data: Mesh | PointCloud, length: float, resolution: float | None, progress: Progress
) -> _ShortPieces:
    progress.stage(tr("Analysing the surface"), None)
    if not isinstance(data, Mesh) or not len(data.faces):
        elements = build_elements(data, _NORMAL_ANGLE_DEG, progress)
        return _ShortPieces(elements, np.asarray(elements.rows))
    vertices = np.asarray(data.vertices, np.float64)
    faces = np.asarray(data.faces, np.int64)
    is_finite_vertex = np.asarray(np.isfinite(vertices).all(axis=1))
    rows = (
        np.arange(len(faces))
        if is_finite_vertex.all()
        else np.flatnonzero(is_finite_vertex[faces].all(axis=1))
    )
    if not len(rows):
        raise GeometryError(Finding("model.no-faces"))
    used_faces = faces if len(rows) == len(faces) else faces[rows]
    squared_lengths = np.empty(len(used_faces))
    square_longest_sides(
        to_read_only_array(vertices, np.float64),
        to_read_only_array(used_faces, np.int64),
        squared_lengths,
    )
    # Half and three quarters of the faces have no side longer than these lengths.
    typical_side, long_side = np.sqrt(np.percentile(squared_lengths, [50.0, 75.0]))
    step = strip_half_width(float(long_side), length)
    max_side = 2.0 * step
    if max_side < typical_side:
        # Reject a length that is much too short before the mesh is divided into millions of pieces.
        _require_min_length(length, resolution or _MIN_RESOLUTION_RATIO * typical_resolution(data))
    is_fine = CELL_STRIPS * step > _MIN_CELL_RATIO * typical_side
    if not is_fine and float(squared_lengths.max()) <= max_side**2:
        elements = build_elements(data, _NORMAL_ANGLE_DEG, progress)
        return _ShortPieces(elements, np.asarray(elements.rows))
    node_indices = weld_points(vertices)
    places = np.zeros((int(node_indices.max()) + 1, 3))
    origin = vertices[is_finite_vertex].min(axis=0)
    places[node_indices] = np.where(is_finite_vertex[:, None], vertices, origin) - origin
    used_faces, nodes, areas = node_indices[used_faces], None, None
    if is_fine:
        thinned_mesh = thin_mesh(places, used_faces, CELL_STRIPS * step)
        places, used_faces, areas = (
            thinned_mesh.vertices,
            thinned_mesh.faces,
            thinned_mesh.areas,
        )
        rows, nodes = rows[thinned_mesh.rows], thinned_mesh.nodes[node_indices]
    places, divided_faces, source = subdivide_mesh(places, used_faces, max_side)
    mesh = Mesh(places + origin, divided_faces.astype(np.int32))
    elements = build_elements(mesh, _NORMAL_ANGLE_DEG, progress)
    source = source[elements.rows]
    if areas is not None:
        # Distribute the area of each face proportionally over its pieces.
        piece_area = np.bincount(source, elements.areas, len(areas))[source]
        elements = replace(elements, areas=elements.areas * (areas[source] / piece_area))
    return _ShortPieces(elements, rows[source], nodes)


def _estimate_resolutions(points: FloatArray, elements: Elements) -> FloatArray:
    """Estimate the effective resolution (n,) of the model around each piece, m.

    It is derived from the spacing and noise of the nearest vertices or points, as around a picked
    trace, because the pieces themselves are smaller than the resolution.
    """
    from scipy.spatial import cKDTree

    finite_points = points[np.isfinite(points).all(axis=1)] - elements.origin
    tree = cKDTree(finite_points, leafsize=32, compact_nodes=False, balanced_tree=False)
    weight = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    # Sample evenly over the area.
    total = np.cumsum(weight)
    sample_area = (np.arange(_RESOLUTION_SAMPLES) + 0.5) / _RESOLUTION_SAMPLES * total[-1]
    rows = np.unique(np.minimum(np.searchsorted(total, sample_area), len(weight) - 1))
    nearest_points = finite_points[tree.query(elements.places[rows])[1]]
    neighbour_rows = tree.query(nearest_points, k=min(NEIGHBOUR_COUNTS[0], len(finite_points)))[
        1
    ].reshape(len(rows), -1)
    area, _ = neighbour_statistics(finite_points[neighbour_rows])
    spacing = np.sqrt(np.where(np.isfinite(area) & (area > 0.0), area, np.nan))
    typical_spacing = float(np.nanmedian(spacing)) if np.isfinite(spacing).any() else np.nan
    overall_resolution = effective_resolution(
        finite_points, tree, nearest_points[:: max(1, len(nearest_points) // _NOISE_SAMPLES)]
    )
    if overall_resolution is None or not typical_spacing > 0.0:
        return np.asarray(elements.spacing)
    # If the noise exceeds the spacing, it is assumed to do so everywhere.
    spacing = np.maximum(
        np.nan_to_num(spacing, nan=typical_spacing),
        overall_resolution if overall_resolution > 1.5 * typical_spacing else 0.0,
    )
    return np.asarray(spacing[cKDTree(elements.places[rows]).query(elements.places)[1]])


# --- the map ----------------------------------------------------------------------------------
def _map_elements(
    surface: _ShortPieces,
    normal: FloatArray,
    resolution: FloatArray,
    length: float,
    options: MeasurableOptions,
    progress: Progress,
) -> Measurable:
    elements = surface.elements
    weight = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    median_resolution = _weighted_median(resolution, weight)
    _require_min_length(length, median_resolution)
    noise = options.noise_m
    if noise is None:
        noise = median_resolution * NOISE_PIXELS / PIXELS_PER_RESOLUTION
    normal = normal / np.linalg.norm(normal)
    has_normal = np.isfinite(elements.normals[:, 0])
    cosine = np.abs(np.nan_to_num(elements.normals) @ normal)
    is_exposed = has_normal & (cosine >= np.cos(np.radians(options.angle_deg)))
    progress.stage(tr("Selecting patches"), None)
    patches, patch_deg, patch_extent = _find_patches(
        elements, is_exposed, resolution, noise, options, weight
    )
    moments = intersection_moments(
        elements, normal, has_normal & ~is_exposed, is_exposed, resolution, length, progress
    )
    trace_deg, extent, relief = _expected_errors(moments, noise, options)
    trace_classes = _classify_errors(trace_deg, extent, resolution)
    patch_classes = _classify_errors(patch_deg, patch_extent, resolution)
    return Measurable(
        replace(elements, rows=surface.source_rows),
        trace_deg,
        patch_deg,
        extent,
        relief,
        np.maximum(trace_classes, patch_classes),
        patches,
        weight,
        resolution,
        length,
        median_resolution,
        noise,
        elements.warnings,
        surface.nodes,
    )


def _require_min_length(length: float, resolution: float) -> None:
    if length < MIN_LENGTH_RESOLUTIONS * resolution:
        raise GeometryError(Finding("trace.too-short", length_m=length, resolution_m=resolution))


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[min(np.searchsorted(total, 0.5 * total[-1]), len(order) - 1)]])


def _classify_errors(error: FloatArray, extent: FloatArray, resolution: FloatArray) -> Int8Array:
    classes = np.where(error <= MAX_GOOD_DEG, 3, np.where(error <= MAX_POOR_DEG, 2, 1))
    # Below ten resolutions, an error estimate is not reliable.
    with np.errstate(invalid="ignore"):
        is_small = extent < MIN_EXTENT_RESOLUTIONS * resolution
    classes = np.where(is_small, np.minimum(classes, 2), classes)
    # At 90 degrees, every plane through the line is possible.
    return np.where(np.nan_to_num(error, nan=90.0) >= 90.0, 0, classes).astype(np.int8)


# --- patches ----------------------------------------------------------------------------------
def _find_patches(
    elements: Elements,
    is_exposed: BoolArray,
    resolution: FloatArray,
    noise: float,
    options: MeasurableOptions,
    weight: FloatArray,
) -> tuple[Int32Array, FloatArray, FloatArray]:
    """Return the patch of each piece, its expected error (degrees) and its diameter (m)."""
    patches = np.full(len(elements), -1, np.int32)
    label = connected_pieces(elements, np.where(is_exposed, 0, -1))
    if not is_exposed.any():
        return patches, np.full(len(patches), np.nan), np.full(len(patches), np.nan)
    _, patch_rows = np.unique(label[is_exposed], return_inverse=True)
    patches[is_exposed] = patch_rows
    area = np.bincount(patch_rows, weight[is_exposed])
    mean_resolution = np.bincount(patch_rows, (weight * resolution)[is_exposed]) / np.maximum(
        area, 1e-300
    )
    size = 2.0 * np.sqrt(area / np.pi)
    error = np.full(len(size), np.nan)
    # The error depends on the size relative to the resolution, and most patches are too small.
    for row in np.flatnonzero(size >= MIN_EXTENT_RESOLUTIONS * mean_resolution):
        error_deg = PlaneSizes(
            float(mean_resolution[row]), noise, options.used_registration_error_deg
        ).error_deg(float(size[row]))
        error[row] = np.nan if error_deg is None else error_deg
    piece_error_deg, extent = np.full(len(patches), np.nan), np.full(len(patches), np.nan)
    piece_error_deg[is_exposed], extent[is_exposed] = error[patch_rows], size[patch_rows]
    return patches, piece_error_deg, extent


# --- errors -----------------------------------------------------------------------------------
def _expected_errors(
    moments: FloatArray, noise: float, options: MeasurableOptions
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the expected 95 % errors of the traces (degrees) and their axes (m).

    The longest axis is followed by the shorter one.
    """
    length, resolution, larger_eigenvalue, smaller_eigenvalue, count = moments.T
    relief, extent = np.sqrt(12.0 * smaller_eigenvalue), np.sqrt(12.0 * larger_eigenvalue)
    degrees_of_freedom = length / resolution - 3.0
    if options.points is not None:
        degrees_of_freedom = np.minimum(degrees_of_freedom, options.points - 3.0)
    variance = noise**2
    values = np.stack(
        [
            larger_eigenvalue + variance,
            smaller_eigenvalue + variance,
            np.full(len(larger_eigenvalue), variance),
        ],
        axis=1,
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        is_determined = (
            (degrees_of_freedom > 0.0) & (count >= _MIN_PIECES) & (smaller_eigenvalue > 0.0)
        )
        quantile = joint_quantile(np.where(is_determined, degrees_of_freedom, 1.0))
        fit = np.degrees(confidence_axes_rad(np.nan_to_num(values), quantile, quantile)[0])
        # As for a trace, see quality.resolution_tilt_deg.
        hidden_errors = POINT_OVER_RESOLUTION * np.sqrt(
            12.0 * CHI2_TWO / np.maximum(degrees_of_freedom + 3.0, 1.0)
        )
        tilt = np.degrees(np.arctan2(np.minimum(0.5, hidden_errors) * resolution, relief))
        error = np.minimum(
            np.hypot(np.maximum(fit, tilt), options.used_registration_error_deg), 90.0
        )
    error = np.where(is_determined, error, 90.0)
    return np.where(np.isfinite(larger_eigenvalue), error, np.nan), extent, relief
