"""How well a plane of a given attitude could be measured, place by place, before anyone picks.

Exercise 6 of the textbook: the same beds are known well where the outcrop's face turns, and not at
all where it is one flat wall, since their traces there are straight. For each place of a surface
the plane of that attitude is laid through it. The line along which it cuts the surface, within the
length of a trace, has a covariance as the vertices of a real trace have; with the noise of the
model across the plane, and one independent point for each resolution along the line, the joint
95 % region of the plane's normal is that of `geometry.plane_errors`, no less than what the
resolution can tilt over the line's shorter axis, and with the registration, as for a picked trace.
Where the face is nearly parallel to the plane it exposes the plane as a surface, and the expected
error is that of a patch of this size (`geometry.plane_sizes`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray, Int8Array, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.extraction.decimation import thinner
from vomstudio.extraction.elements import Elements, elements_of
from vomstudio.extraction.measurable_kernels import longest_sides
from vomstudio.extraction.measurable_lines import CELL, hanging_together, lines_through, step_of
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.extraction.refinement import finer
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.kernels.jit import for_reading
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

CLASSES = ("none", "poor", "doubtful", "good")
"""Of an expected error, the worst first; in none the plane can't be told at all."""
GOOD_DEG, POOR_DEG = 5.0, 15.0
LEAST_RESOLUTIONS = 10.0
LEAST_LENGTH = 4.0
"""Of a trace, in resolutions."""
USUAL_RESOLUTIONS = 100.0
"""The length of a trace that is proposed."""
_NORMALS_DEG = 20.0
_FEWEST_PIECES = 4
_FINE = 1.25
"""Cells that are larger by this than the sides of most faces hold several of them."""
_SURELY = 0.6
"""Of the resolution of all points, which is taken where they are dense: the surface's is more."""
# Places evenly over the surface at which the model's resolution is looked at, and of these those
# that tell whether its noise is larger than its spacing.
_SAMPLES, _OF_ALL = 4000, 100


@dataclass(frozen=True, eq=False)
class Measurable:
    """Of each of n pieces of a surface (faces of a mesh, points of a cloud); degrees and metres.

    trace_deg : (n,) expected 95 % error of a trace through it, 90 where any plane through the line
        would do, NaN where there is no line: the face is the plane's, or has no normal
    patch_deg : (n,) of the patch of the plane that the face exposes, NaN where it exposes none or a
        patch under ten resolutions
    extent : (n,) longest axis of the line, m; relief : (n,) its shorter axis, m
    classes : (n,) int8 in CLASSES, of the better of the two
    patches : (n,) int32 number of the patch, -1 for none
    areas : (n,) m2; resolutions : (n,) of the model there, m; resolution, noise : typical ones, m
    nodes : (vertices of the model,) those with one number are one vertex of the map, of a mesh that
        is far finer than it needs; None where each is one by itself
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
        """(n,) in CLASSES, of traces alone."""
        return _classes(self.trace_deg, self.extent, self.resolutions)

    @property
    def best_deg(self) -> FloatArray:
        """(n,) expected 95 % error of whichever is better, 90 for none."""
        return np.asarray(np.fmin(np.fmin(self.trace_deg, self.patch_deg), 90.0))


def usual_resolution(data: Mesh | PointCloud) -> float:
    """Typical effective resolution of a model, as around a picked trace. Raises GeometryError where
    its points stand at one place."""
    from scipy.spatial import cKDTree

    points = resolving_points(data)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) > 3:
        points = points - points.mean(axis=0)
        tree = cKDTree(points, leafsize=32, compact_nodes=False, balanced_tree=False)
        found = effective_resolution(points, tree, points[:: max(1, len(points) // _OF_ALL)])
        if found is not None and found > 0.0:
            return found
    raise GeometryError(Finding("model.no-resolution"))


def measurable(
    data: Mesh | PointCloud,
    normal: npt.ArrayLike,
    options: MeasurableOptions,
    progress: Progress | None = None,
) -> Measurable:
    """Map how well a plane could be measured on a surface in World.

    Parameters
    ----------
    normal : (3,) array_like
        Normal of the plane.
    options : MeasurableOptions
        With the length of a trace.

    Raises
    ------
    GeometryError
        If there is no surface, or the length is too short for a trace on it.
    Cancelled
        Through `progress`.
    """
    assert options.length_m is not None
    length = options.length_m
    progress = progress or Silent()
    surface = _surface(data, length, options.resolution_m, progress)
    elements = surface.elements
    if options.resolution_m is None:
        resolution = _resolutions(resolving_points(data), elements)
    else:
        resolution = np.full(len(elements), options.resolution_m)
    return _of_elements(
        surface, np.asarray(normal, np.float64), resolution, length, options, progress
    )


# --- the surface ------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class _Surface:
    """elements : pieces, none of them large or very small beside the length; of : (n,) the face or
    point of the model that each is a piece of; nodes : as `Measurable` has them"""

    elements: Elements
    of: IntArray
    nodes: IntArray | None = None


def _surface(
    data: Mesh | PointCloud, length: float, resolution: float | None, progress: Progress
) -> _Surface:
    progress.stage(tr("Analysing the surface"), None)
    if not isinstance(data, Mesh) or not len(data.faces):
        elements = elements_of(data, _NORMALS_DEG, progress)
        return _Surface(elements, np.asarray(elements.rows))
    vertices = np.asarray(data.vertices, np.float64)
    faces = np.asarray(data.faces, np.int64)
    whole = np.asarray(np.isfinite(vertices).all(axis=1))
    rows = np.arange(len(faces)) if whole.all() else np.flatnonzero(whole[faces].all(axis=1))
    if not len(rows):
        raise GeometryError(Finding("model.no-faces"))
    own = faces if len(rows) == len(faces) else faces[rows]
    square = np.empty(len(own))
    longest_sides(for_reading(vertices, np.float64), for_reading(own, np.int64), square)
    # A half and three quarters of the faces have no longer side.
    usual, long = np.sqrt(np.percentile(square, [50.0, 75.0]))
    step = step_of(float(long), length)
    longest = 2.0 * step
    if longest < usual:
        # What is far too short would be cut into millions of pieces before it is refused.
        _require_longer(length, resolution or _SURELY * usual_resolution(data))
    fine = CELL * step > _FINE * usual
    if not fine and float(square.max()) <= longest**2:
        elements = elements_of(data, _NORMALS_DEG, progress)
        return _Surface(elements, np.asarray(elements.rows))
    number = welded(vertices)
    places = np.zeros((int(number.max()) + 1, 3))
    origin = vertices[whole].min(axis=0)
    places[number] = np.where(whole[:, None], vertices, origin) - origin
    own, nodes, areas = number[own], None, None
    if fine:
        few = thinner(places, own, CELL * step)
        places, own, areas = few.vertices, few.faces, few.areas
        rows, nodes = rows[few.rows], few.nodes[number]
    places, cut, of = finer(places, own, longest)
    mesh = Mesh(places + origin, cut.astype(np.int32))
    elements = elements_of(mesh, _NORMALS_DEG, progress)
    of = of[elements.rows]
    if areas is not None:
        # Those of their pieces in their proportion.
        shown = np.bincount(of, elements.areas, len(areas))[of]
        elements = replace(elements, areas=elements.areas * (areas[of] / shown))
    return _Surface(elements, rows[of], nodes)


def _resolutions(points: FloatArray, elements: Elements) -> FloatArray:
    """(n,) effective resolution of the model around each piece, taken as that around a picked trace
    is: spacing and noise of the vertices or points nearest to it, and not of the pieces, which are
    cut finer than the model is."""
    from scipy.spatial import cKDTree

    sound = points[np.isfinite(points).all(axis=1)] - elements.origin
    tree = cKDTree(sound, leafsize=32, compact_nodes=False, balanced_tree=False)
    weight = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    # Evenly over the area.
    total = np.cumsum(weight)
    evenly = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * total[-1]
    rows = np.unique(np.minimum(np.searchsorted(total, evenly), len(weight) - 1))
    nearest = sound[tree.query(elements.places[rows])[1]]
    near = tree.query(nearest, k=min(NEIGHBOUR_COUNTS[0], len(sound)))[1].reshape(len(rows), -1)
    area, _ = neighbour_statistics(sound[near])
    spacing = np.sqrt(np.where(np.isfinite(area) & (area > 0.0), area, np.nan))
    usual = float(np.nanmedian(spacing)) if np.isfinite(spacing).any() else np.nan
    whole = effective_resolution(sound, tree, nearest[:: max(1, len(nearest) // _OF_ALL)])
    if whole is None or not usual > 0.0:
        return np.asarray(elements.spacing)
    # Where noise is larger than the spacing, it is everywhere.
    spacing = np.maximum(np.nan_to_num(spacing, nan=usual), whole if whole > 1.5 * usual else 0.0)
    return np.asarray(spacing[cKDTree(elements.places[rows]).query(elements.places)[1]])


# --- the map ----------------------------------------------------------------------------------
def _of_elements(
    surface: _Surface,
    normal: FloatArray,
    resolution: FloatArray,
    length: float,
    options: MeasurableOptions,
    progress: Progress,
) -> Measurable:
    elements = surface.elements
    weight = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    typical = _weighted_median(resolution, weight)
    _require_longer(length, typical)
    noise = options.noise_m
    if noise is None:
        noise = typical * NOISE_PIXELS / PIXELS_PER_RESOLUTION
    normal = normal / np.linalg.norm(normal)
    known = np.isfinite(elements.normals[:, 0])
    cosine = np.abs(np.nan_to_num(elements.normals) @ normal)
    exposed = known & (cosine >= np.cos(np.radians(options.angle_deg)))
    progress.stage(tr("Selecting patches"), None)
    patches, patch_deg, patch_extent = _patches(
        elements, exposed, resolution, noise, options, weight
    )
    figures = lines_through(
        elements, normal, known & ~exposed, exposed, resolution, length, progress
    )
    trace_deg, extent, relief = _errors(figures, noise, options)
    of_trace = _classes(trace_deg, extent, resolution)
    of_patch = _classes(patch_deg, patch_extent, resolution)
    return Measurable(
        replace(elements, rows=surface.of),
        trace_deg,
        patch_deg,
        extent,
        relief,
        np.maximum(of_trace, of_patch),
        patches,
        weight,
        resolution,
        length,
        typical,
        noise,
        elements.warnings,
        surface.nodes,
    )


def _require_longer(length: float, resolution: float) -> None:
    if length < LEAST_LENGTH * resolution:
        raise GeometryError(Finding("trace.too-short", length_m=length, resolution_m=resolution))


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[min(np.searchsorted(total, 0.5 * total[-1]), len(order) - 1)]])


def _classes(error: FloatArray, extent: FloatArray, resolution: FloatArray) -> Int8Array:
    found = np.where(error <= GOOD_DEG, 3, np.where(error <= POOR_DEG, 2, 1))
    # Below ten resolutions no error can be believed.
    with np.errstate(invalid="ignore"):
        small = extent < LEAST_RESOLUTIONS * resolution
    found = np.where(small, np.minimum(found, 2), found)
    # 90 degrees: all planes through the line will do.
    return np.where(np.nan_to_num(error, nan=90.0) >= 90.0, 0, found).astype(np.int8)


# --- patches ----------------------------------------------------------------------------------
def _patches(
    elements: Elements,
    exposed: BoolArray,
    resolution: FloatArray,
    noise: float,
    options: MeasurableOptions,
    weight: FloatArray,
) -> tuple[Int32Array, FloatArray, FloatArray]:
    """Number of the patch of each piece, the expected error of it, and its diameter."""
    number = np.full(len(elements), -1, np.int32)
    label = hanging_together(elements, np.where(exposed, 0, -1))
    if not exposed.any():
        return number, np.full(len(number), np.nan), np.full(len(number), np.nan)
    _, own = np.unique(label[exposed], return_inverse=True)
    number[exposed] = own
    area = np.bincount(own, weight[exposed])
    fine = np.bincount(own, (weight * resolution)[exposed]) / np.maximum(area, 1e-300)
    size = 2.0 * np.sqrt(area / np.pi)
    error = np.full(len(size), np.nan)
    # The curve is one of the size over the resolution, and most patches are too small for it.
    for row in np.flatnonzero(size >= LEAST_RESOLUTIONS * fine):
        told = PlaneSizes(float(fine[row]), noise, options.used_registration_error_deg).error_deg(
            float(size[row])
        )
        error[row] = np.nan if told is None else told
    deg, extent = np.full(len(number), np.nan), np.full(len(number), np.nan)
    deg[exposed], extent[exposed] = error[own], size[own]
    return number, deg, extent


# --- errors -----------------------------------------------------------------------------------
def _errors(
    figures: FloatArray, noise: float, options: MeasurableOptions
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Expected 95 % error of the trace, its longest and its shorter axis."""
    length, resolution, larger, smaller, count = figures.T
    relief, extent = np.sqrt(12.0 * smaller), np.sqrt(12.0 * larger)
    free = length / resolution - 3.0
    if options.points is not None:
        free = np.minimum(free, options.points - 3.0)
    square = noise**2
    values = np.stack([larger + square, smaller + square, np.full(len(larger), square)], axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        able = (free > 0.0) & (count >= _FEWEST_PIECES) & (smaller > 0.0)
        quantile = joint_quantile(np.where(able, free, 1.0))
        fit = np.degrees(confidence_axes_rad(np.nan_to_num(values), quantile, quantile)[0])
        # As of a trace: quality.resolution_tilt_deg.
        unseen = POINT_OVER_RESOLUTION * np.sqrt(12.0 * CHI2_TWO / np.maximum(free + 3.0, 1.0))
        tilt = np.degrees(np.arctan2(np.minimum(0.5, unseen) * resolution, relief))
        error = np.minimum(
            np.hypot(np.maximum(fit, tilt), options.used_registration_error_deg), 90.0
        )
    error = np.where(able, error, 90.0)
    return np.where(np.isfinite(larger), error, np.nan), extent, relief
