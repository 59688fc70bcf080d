"""How well a plane of a given attitude could be measured, place by place, before anyone picks.

Exercise 6 of the textbook: the same beds are known well where the outcrop's face turns, and not at
all where it is one flat wall, since their traces there are straight. For each place of a surface
the plane of that attitude is laid through it. The line along which it cuts the surface, within the
length of a trace, has a covariance as the vertices of a real trace have; with the noise of the
model across the plane, and one independent point for each resolution along the line, the joint 95 %
region of the plane's normal is that of `geometry.plane_errors`, no less than what the resolution can
tilt over the line's shorter axis, and with the registration, as for a picked trace. Where the face
is nearly parallel to the plane it exposes the plane as a surface, and the expected error is that of
a patch of this size (`geometry.plane_sizes`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, UsageError
from vomstudio.extraction.elements import Elements, elements_of
from vomstudio.extraction.finer_faces import finer
from vomstudio.extraction.measurable_kernels import line_moments
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import in_blocks
from vomstudio.geometry.plane_errors import confidence_axes_rad, joint_quantile
from vomstudio.geometry.plane_sizes import NOISE_PIXELS, PIXELS_PER_RESOLUTION, PlaneSizes
from vomstudio.geometry.resolution import COUNTS, effective_resolution, of_neighbours
from vomstudio.progress import Progress, Silent
from vomstudio.words import tr

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

ANGLE_DEG = 10.0
"""Within which a face is that of the plane itself: the conventions' surface effect."""
CLASSES = ("none", "poor", "doubtful", "good")
"""Of an expected error, the worst first; in none the plane can't be told at all."""
GOOD_DEG, POOR_DEG = 5.0, 15.0
LEAST_RESOLUTIONS = 10.0
USUAL_RESOLUTIONS = 100.0
"""The length of a trace that is proposed."""
_NORMALS_DEG = 20.0
# Of the length: the strip on either side of the line, at least, and where the mesh must be cut.
_STRIPS, _FEWEST_STRIPS, _STRIPS_OF_CUT = 40.0, 12.0, 40.0
# Of the half strip, the side of the cells of which one piece stands for all.
_CELL = 0.75
_FEWEST_PIECES = 4
_BLOCK = 20_000
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
    rows, row_of : as of Elements; areas : (n,) m2; resolutions : (n,) of the model there, m; resolution, noise : typical ones, m
    """

    elements: Elements
    trace_deg: Array
    patch_deg: Array
    extent: Array
    relief: Array
    classes: npt.NDArray[np.int8]
    patches: npt.NDArray[np.int32]
    areas: Array
    resolutions: Array
    length: float
    resolution: float
    noise: float
    warnings: tuple[str, ...]

    @property
    def trace_classes(self) -> npt.NDArray[np.int8]:
        """(n,) in CLASSES, of traces alone."""
        return _classes(self.trace_deg, self.extent, self.resolutions)

    @property
    def best_deg(self) -> Array:
        """(n,) expected 95 % error of whichever is better, 90 for none."""
        return np.asarray(np.fmin(np.fmin(self.trace_deg, self.patch_deg), 90.0))


@dataclass(frozen=True)
class Asked:
    """normal : (3,) of the plane; length : of a trace; resolution : None: what each place has
    noise : one sigma of a trace's vertices across their plane; None: as much as photos with this
        resolution leave, and at least the surface's own
    points : of a trace, vertices; None: one for each resolution of its length
    registration_deg : 95 % by which the registration can tilt the plane
    angle_deg : within which a face is the plane's own; all in the unit of the surface
    """

    normal: tuple[float, float, float]
    length: float
    resolution: float | None = None
    noise: float | None = None
    points: int | None = None
    registration_deg: float = 0.0
    angle_deg: float = ANGLE_DEG


def usual_resolution(data: Mesh | PointCloud) -> float:
    """Typical effective resolution of a model, as around a picked trace. Raises GeometryError where
    its points stand at one place."""
    from scipy.spatial import cKDTree

    points = np.asarray(data.vertices if isinstance(data, Mesh) else data.points, np.float64)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) > 3:
        points = points - points.mean(axis=0)
        tree = cKDTree(points, leafsize=32, compact_nodes=False, balanced_tree=False)
        found = effective_resolution(points, tree, points[:: max(1, len(points) // _OF_ALL)])
        if found is not None and found > 0.0:
            return found
    raise GeometryError(tr("The model has too few points to tell its resolution."))


def require_asked(asked: Asked) -> None:
    """Raises UsageError for figures that are none."""
    for field, value in (
        ("--length", asked.length),
        ("--resolution", asked.resolution),
        ("--noise", asked.noise),
    ):
        if value is not None and not 0.0 < value < np.inf:
            raise UsageError(
                tr("{field} is a positive length in metres.", field=field), field=field
            )
    if asked.points is not None and asked.points < 4:
        raise UsageError(
            tr("A trace of {count} points has no error; ask for at least 4.", count=asked.points),
            field="--points",
        )
    if not 0.0 < asked.angle_deg <= 45.0:
        raise UsageError(tr("--angle is between 0 and 45 degrees."), field="--angle")
    if not 0.0 <= asked.registration_deg < 90.0:
        raise UsageError(
            tr("--registration-error is between 0 and 90 degrees."), field="--registration-error"
        )


def measurable(
    data: Mesh | PointCloud, asked: Asked, progress: Progress | None = None
) -> Measurable:
    """The map on a surface in World.

    Raises UsageError for figures that are none, GeometryError where there is no surface or the
    length is no trace on it, Cancelled through `progress`.
    """
    require_asked(asked)
    progress = progress or Silent()
    elements, of = _surface(data, asked.length, progress)
    if asked.resolution is None:
        points = data.vertices if isinstance(data, Mesh) else data.points
        resolution = _resolutions(np.asarray(points, np.float64), elements)
    else:
        resolution = np.full(len(elements), asked.resolution)
    return _of_elements(elements, of, resolution, asked, progress)


# --- the surface ------------------------------------------------------------------------------
def _surface(data: Mesh | PointCloud, length: float, progress: Progress) -> tuple[Elements, Ints]:
    """Its pieces, none of them large beside the length, and of which face or point each is a
    piece."""
    progress.stage(tr("Surface"), None)
    if not isinstance(data, Mesh) or not len(data.faces):
        elements = elements_of(data, _NORMALS_DEG, progress)
        return elements, np.asarray(elements.rows)
    vertices = np.asarray(data.vertices, np.float64)
    faces = np.asarray(data.faces, np.int64)
    sound = np.isfinite(vertices).all(axis=1)[faces].all(axis=1)
    rows = np.flatnonzero(sound)
    if not len(rows):
        raise GeometryError(tr("The mesh has no faces with places."))
    origin = vertices[faces[rows]].reshape(-1, 3).min(axis=0)
    sides = np.linalg.norm(
        vertices[faces[rows]] - vertices[np.roll(faces[rows], 1, axis=1)], axis=2
    ).max(axis=1)
    if (sides <= 2.0 * _step(float(np.percentile(sides, 75.0)), length)).all():
        elements = elements_of(data, _NORMALS_DEG, progress)
        return elements, np.asarray(elements.rows)
    from vomstudio.geometry.coincident_points import welded

    number = welded(vertices)
    places = np.zeros((int(number.max()) + 1, 3))
    places[number] = np.where(np.isfinite(vertices), vertices, 0.0) - origin
    longest = 2.0 * _step(float(np.percentile(sides, 75.0)), length)
    places, fine, own = finer(places, number[faces[rows]], longest)
    cut = Mesh(places + origin, fine.astype(np.int32))
    elements = elements_of(cut, _NORMALS_DEG, progress)
    return elements, rows[own[elements.rows]]


def _resolutions(points: Array, elements: Elements) -> Array:
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
    near = tree.query(nearest, k=min(COUNTS[0], len(sound)))[1].reshape(len(rows), -1)
    area, _ = of_neighbours(sound[near])
    spacing = np.sqrt(np.where(np.isfinite(area) & (area > 0.0), area, np.nan))
    usual = float(np.nanmedian(spacing)) if np.isfinite(spacing).any() else np.nan
    whole = effective_resolution(sound, tree, nearest[:: max(1, len(nearest) // _OF_ALL)])
    if whole is None or not usual > 0.0:
        return np.asarray(elements.spacing)
    # Where noise is larger than the spacing, it is everywhere.
    spacing = np.maximum(np.nan_to_num(spacing, nan=usual), whole if whole > 1.5 * usual else 0.0)
    return np.asarray(spacing[cKDTree(elements.places[rows]).query(elements.places)[1]])


def _step(spacing: float, length: float) -> float:
    """Half of the width of the strip that a line is taken from, for a mesh or cloud of this
    spacing."""
    if spacing <= length / _FEWEST_STRIPS:
        return max(spacing, length / _STRIPS)
    return length / _STRIPS_OF_CUT


# --- the map ----------------------------------------------------------------------------------
def _of_elements(
    elements: Elements, of: Ints, resolution: Array, asked: Asked, progress: Progress
) -> Measurable:
    weight = np.where(np.isfinite(elements.areas), elements.areas, 0.0)
    typical = _weighted_median(resolution, weight)
    if asked.length < 4.0 * typical:
        raise GeometryError(
            tr(
                "A trace of {length:.3g} m is hardly longer than the model's resolution of "
                "{resolution:.3g} m: choose a longer one.",
                length=asked.length,
                resolution=typical,
            )
        )
    noise = typical * NOISE_PIXELS / PIXELS_PER_RESOLUTION if asked.noise is None else asked.noise
    normal = np.asarray(asked.normal, np.float64)
    normal = normal / np.linalg.norm(normal)
    known = np.isfinite(elements.normals[:, 0])
    cosine = np.abs(np.nan_to_num(elements.normals) @ normal)
    exposed = known & (cosine >= np.cos(np.radians(asked.angle_deg)))
    progress.stage(tr("Patches"), None)
    patches, patch_deg, patch_extent = _patches(elements, exposed, resolution, noise, asked, weight)
    figures = _lines(elements, normal, known & ~exposed, exposed, resolution, asked, progress)
    trace_deg, extent, relief = _errors(figures, noise, asked)
    of_trace = _classes(trace_deg, extent, resolution)
    of_patch = _classes(patch_deg, patch_extent, resolution)
    return Measurable(
        replace(elements, rows=of), trace_deg, patch_deg, extent, relief,
        np.maximum(of_trace, of_patch), patches, weight, resolution, asked.length, typical,
        noise, elements.warnings,
    )  # fmt: skip


def _weighted_median(values: Array, weights: Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[min(np.searchsorted(total, 0.5 * total[-1]), len(order) - 1)]])


def _classes(error: Array, extent: Array, resolution: Array) -> npt.NDArray[np.int8]:
    found = np.where(error <= GOOD_DEG, 3, np.where(error <= POOR_DEG, 2, 1))
    # Below ten resolutions no error can be believed.
    with np.errstate(invalid="ignore"):
        small = extent < LEAST_RESOLUTIONS * resolution
    found = np.where(small, np.minimum(found, 2), found)
    # 90 degrees: all planes through the line will do.
    return np.where(np.nan_to_num(error, nan=90.0) >= 90.0, 0, found).astype(np.int8)


# --- patches ----------------------------------------------------------------------------------
def _patches(
    elements: Elements, exposed: Bools, resolution: Array, noise: float, asked: Asked, weight: Array
) -> tuple[npt.NDArray[np.int32], Array, Array]:
    """Number of the patch of each piece, the expected error of it, and its diameter."""
    number = np.full(len(elements), -1, np.int32)
    label = _hanging_together(elements, np.where(exposed, 0, -1))
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
        told = PlaneSizes(float(fine[row]), noise, asked.registration_deg).error_deg(
            float(size[row])
        )
        error[row] = np.nan if told is None else told
    deg, extent = np.full(len(number), np.nan), np.full(len(number), np.nan)
    deg[exposed], extent[exposed] = error[own], size[own]
    return number, deg, extent


def _hanging_together(elements: Elements, band: Ints) -> Ints:
    """(n,) a number for the pieces of one band that are neighbours of neighbours; -1 has none."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(band)
    source = np.repeat(np.arange(n, dtype=np.int32), np.diff(elements.starts))
    same = (band[source] == band[elements.near]) & (band[source] >= 0)
    source, near = source[same], elements.near[same]
    graph = coo_matrix((np.ones(len(source), np.int8), (source, near)), shape=(n, n)).tocsr()
    found = connected_components(graph, directed=False)[1].astype(np.int64)
    found[band < 0] = -1
    return found


# --- lines ------------------------------------------------------------------------------------
def _lines(
    elements: Elements,
    normal: Array,
    cut: Bools,
    exposed: Bools,
    resolution: Array,
    asked: Asked,
    progress: Progress,
) -> Array:
    """(n, 6) of the line through each piece: its length, the resolution along it, the larger and
    the smaller variance, how many pieces; NaN where there is none."""
    n = len(elements)
    figures = np.full((n, 5), np.nan)
    if not cut.any():
        return figures
    places = elements.places
    offset = places @ normal
    offset = offset - offset[cut].min()
    spread = np.sqrt(np.percentile(elements.areas[cut], 75.0) * (2 if elements.of == "face" else 1))
    width = _step(float(spread), asked.length)
    one, of, weight = _thinned(elements, cut, normal, width)
    first, second = _in_plane(normal)
    slope = np.einsum("ij,j->i", np.nan_to_num(elements.normals[one]), normal)
    steep = np.sqrt(np.maximum(1.0 - slope**2, 1e-12))
    # Along the surface's own steepest line, which leaves the plane by its sine.
    slopes = np.stack(
        [-slope * (elements.normals[one] @ axis) / steep**2 for axis in (first, second)], axis=1
    )
    own = np.stack([offset[one], places[one] @ first, places[one] @ second], axis=1)
    found = np.full((len(one), 9), np.nan)
    quarter = offset / (4.0 * width)
    half_later = quarter + 0.5
    share = quarter[one] - np.floor(quarter[one])
    # Two sets of bands, so that every place is well inside one of them.
    middle = (share >= 0.25) & (share < 0.75)
    progress.stage(tr("Lines through the places"), len(one))
    before = 0
    for bands, places_there in ((quarter, middle), (half_later, ~middle)):
        band = np.where(cut | exposed, np.floor(bands).astype(np.int64), -1)
        label = _hanging_together(elements, np.where(band < 0, -1, band))[one]
        rows = np.flatnonzero(places_there)
        if len(rows):
            found[rows] = _moments(
                label, rows, own, slopes, steep, weight, resolution[one], asked.length / 2.0, width,
                progress, before,
            )  # fmt: skip
            before += len(rows)
    trace = 0.5 * (found[:, 4] + found[:, 5])
    root = np.hypot(0.5 * (found[:, 4] - found[:, 5]), found[:, 6])
    told = np.stack(
        [
            found[:, 0] / (2.0 * width),
            found[:, 1],
            np.maximum(trace + root, 0.0),
            np.maximum(trace - root, 0.0),
            found[:, 7],
        ],
        axis=1,
    )
    figures[cut] = told[of]
    return figures


def _in_plane(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors at right angles in the plane."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _thinned(
    elements: Elements, cut: Bools, normal: Array, width: float
) -> tuple[Ints, Ints, Array]:
    """Rows of pieces that stand for all that are cut, one in each cell of the width and side of the
    plane; which of them stands for each of these; and the area each stands for."""
    rows = np.flatnonzero(cut)
    areas = elements.areas[rows]
    usual = float(np.median(areas))
    if usual > 0.3 * width**2:
        return rows, np.arange(len(rows)), np.asarray(areas)
    cell = np.floor(elements.places[rows] / (_CELL * width)).astype(np.int64)
    cell -= cell.min(axis=0)
    size = cell.max(axis=0) + 1
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    # Faces of one cell that look elsewhere are another surface.
    normals = elements.normals[rows]
    first, second = _in_plane(normal)
    turn = np.arctan2(normals @ second, normals @ first)
    key = key * 4 + np.floor((turn + np.pi) / (np.pi / 2.0)).astype(np.int64) % 4
    _, of = np.unique(key, return_inverse=True)
    order = np.lexsort((areas, of))
    last = np.flatnonzero(np.append(np.diff(of[order]) != 0, True))
    return rows[order[last]], of, np.bincount(of, areas)


def _moments(
    label: Ints,
    rows: Ints,
    own: Array,
    slopes: Array,
    steep: Array,
    weight: Array,
    resolution: Array,
    half: float,
    width: float,
    progress: Progress,
    before: int,
) -> Array:
    """(len(rows), 9) what `line_moments` tells of these places. label : (k,) what hangs together
    near each of the planes."""
    count = int(label.max()) + 1
    # Along the longest direction in the plane of what hangs together the walk is shortest.
    number = np.maximum(np.bincount(label, minlength=count), 1)
    mean = [np.bincount(label, own[:, k], count) / number for k in (1, 2)]
    off = [own[:, k] - mean[k - 1][label] for k in (1, 2)]
    uu, vv, uv = (
        np.bincount(label, a * b, count)
        for a, b in ((off[0], off[0]), (off[1], off[1]), (off[0], off[1]))
    )
    angle = 0.5 * np.arctan2(2.0 * uv, uu - vv)
    along = np.cos(angle)[label] * off[0] + np.sin(angle)[label] * off[1]
    order = np.lexsort((along, label))
    ends = np.cumsum(np.bincount(label, minlength=count))
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    sorted_own = for_kernels(np.column_stack([own, along])[order], np.float64)
    last = for_kernels(ends[label[order]], np.int64)
    first = for_kernels(np.concatenate([[0], ends[:-1]])[label[order]], np.int64)
    arrays = [
        for_kernels(values[order], np.float64) for values in (slopes, steep, weight, resolution)
    ]
    found = np.empty((len(rows), 9))

    def work(block: slice) -> None:
        out = np.full((len(rows[block]), 9), np.nan)
        line_moments(
            for_kernels(place[rows[block]], np.int64), sorted_own, *arrays, first, last, half, width,
            out,
        )  # fmt: skip
        found[block] = out

    in_blocks(work, len(rows), _After(progress, before), _BLOCK)
    return found


class _After(Silent):
    """Steps that count on from others."""

    def __init__(self, progress: Progress, before: int) -> None:
        self._progress, self._before = progress, before

    def step(self, done: int) -> None:
        self._progress.step(self._before + done)


# --- errors -----------------------------------------------------------------------------------
def _errors(figures: Array, noise: float, asked: Asked) -> tuple[Array, Array, Array]:
    """Expected 95 % error of the trace, its longest and its shorter axis."""
    length, resolution, larger, smaller, count = figures.T
    relief, extent = np.sqrt(12.0 * smaller), np.sqrt(12.0 * larger)
    free = length / resolution - 3.0
    if asked.points is not None:
        free = np.minimum(free, asked.points - 3.0)
    square = noise**2
    values = np.stack([larger + square, smaller + square, np.full(len(larger), square)], axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        able = (free > 0.0) & (count >= _FEWEST_PIECES) & (smaller > 0.0)
        quantile = joint_quantile(np.where(able, free, 1.0))
        fit = np.degrees(confidence_axes_rad(np.nan_to_num(values), quantile, quantile)[0])
        tilt = np.degrees(np.arctan2(0.5 * resolution, relief))
        error = np.minimum(np.hypot(np.maximum(fit, tilt), asked.registration_deg), 90.0)
    error = np.where(able, error, 90.0)
    return np.where(np.isfinite(larger), error, np.nan), extent, relief
