"""Moments of the lines along which a plane of given attitude cuts a surface."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements
from vomstudio.extraction.measurable_kernels import line_moments
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.nearby.point_grid import run_in_blocks

# Width of the strip on either side of the line, as a fraction of the length: the finest, the
# coarsest for the mesh as it is, and that for a mesh that must be subdivided.
_N_STRIPS, _MIN_N_STRIPS, _N_COARSE_STRIPS = 40.0, 12.0, 40.0
# Side length of the cells in which one piece represents all others, in half strip widths.
CELL_STRIPS = 0.75
_PIECES_PER_BLOCK = 20_000


def strip_half_width(spacing: float, length: float) -> float:
    """Return half the width of the strip of surface around a line.

    Parameters
    ----------
    spacing : float
        Spacing of the points, m.
    length : float
        Length of the line, m.

    Returns
    -------
    float
        Half-width in metres.
    """
    if spacing <= length / _MIN_N_STRIPS:
        return max(spacing, length / _N_STRIPS)
    return length / _N_COARSE_STRIPS


def connected_pieces(elements: Elements, band: IntArray) -> IntArray:
    """Find the connected pieces of the surface within each band.

    Parameters
    ----------
    elements : Elements
    band : (n,) ndarray of int
        Band of each element; -1 if it belongs to none.

    Returns
    -------
    (n,) ndarray of int
        Number of the piece; -1 for elements that belong to no band.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(band)
    source = np.repeat(np.arange(n, dtype=np.int32), np.diff(elements.starts))
    is_same_band = (band[source] == band[elements.neighbours]) & (band[source] >= 0)
    source, neighbours = source[is_same_band], elements.neighbours[is_same_band]
    graph = coo_matrix((np.ones(len(source), np.int8), (source, neighbours)), shape=(n, n)).tocsr()
    components = np.asarray(connected_components(graph, directed=False)[1], np.int64)
    return np.where(band < 0, -1, components)


def intersection_moments(
    elements: Elements,
    normal: FloatArray,
    is_cut: BoolArray,
    is_exposed: BoolArray,
    resolution: FloatArray,
    length: float,
    progress: Progress,
) -> FloatArray:
    """Compute the moments of the line through each piece of a surface.

    Parameters
    ----------
    elements : Elements
    normal : (3,) array
        Normal of the plane in the World frame.
    is_cut : (n,) bool array
        Pieces that are cut by the plane.
    is_exposed : (n,) bool array
        Pieces that are parallel to the plane.
    resolution : (n,) array
        Local resolution of the model, m.
    length : float
        Length of a trace, m.
    progress : Progress

    Returns
    -------
    (n, 5) array
        Length of the line and resolution along it, m; larger and smaller variance, m²; number of
        pieces. NaN for pieces without a line.
    """
    n = len(elements)
    moments = np.full((n, 5), np.nan)
    if not is_cut.any():
        return moments
    positions = elements.places
    offset = positions @ normal
    offset = offset - offset[is_cut].min()
    typical_side = np.sqrt(
        np.percentile(elements.areas[is_cut], 75.0) * (2 if elements.kind == "face" else 1)
    )
    width = strip_half_width(float(typical_side), length)
    representatives, representative_rows, weight = _select_representatives(
        elements, is_cut, normal, width
    )
    first_axis, second_axis = _plane_axes(normal)
    slope = np.einsum("ij,j->i", np.nan_to_num(elements.normals[representatives]), normal)
    sine = np.sqrt(np.maximum(1.0 - slope**2, 1e-12))
    # The line of steepest ascent of the surface leaves the plane by this sine.
    slopes = np.stack(
        [
            -slope * (elements.normals[representatives] @ axis) / sine**2
            for axis in (first_axis, second_axis)
        ],
        axis=1,
    )
    coordinates = np.stack(
        [
            offset[representatives],
            positions[representatives] @ first_axis,
            positions[representatives] @ second_axis,
        ],
        axis=1,
    )
    sums = np.full((len(representatives), 9), np.nan)
    band_positions = offset / (4.0 * width)
    shifted_positions = band_positions + 0.5
    fraction = band_positions[representatives] - np.floor(band_positions[representatives])
    # Use two overlapping sets of bands, so that every piece is well inside one of them.
    is_middle = (fraction >= 0.25) & (fraction < 0.75)
    progress.stage(tr("Measuring patches"), len(representatives))
    processed_count = 0
    for bands, is_inside in ((band_positions, is_middle), (shifted_positions, ~is_middle)):
        band = np.where(is_cut | is_exposed, np.floor(bands).astype(np.int64), -1)
        label = connected_pieces(elements, np.where(band < 0, -1, band))[representatives]
        rows = np.flatnonzero(is_inside)
        if len(rows):
            sums[rows] = _compute_moments(
                label,
                rows,
                coordinates,
                slopes,
                sine,
                weight,
                resolution[representatives],
                length / 2.0,
                width,
                progress,
                processed_count,
            )
            processed_count += len(rows)
    trace = 0.5 * (sums[:, 4] + sums[:, 5])
    root = np.hypot(0.5 * (sums[:, 4] - sums[:, 5]), sums[:, 6])
    results = np.stack(
        [
            sums[:, 0] / (2.0 * width),
            sums[:, 1],
            np.maximum(trace + root, 0.0),
            np.maximum(trace - root, 0.0),
            sums[:, 7],
        ],
        axis=1,
    )
    moments[is_cut] = results[representative_rows]
    return moments


def _plane_axes(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two orthogonal unit vectors in the plane with a given normal."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    first_axis = np.cross(normal, helper)
    first_axis /= np.linalg.norm(first_axis)
    return first_axis, np.cross(normal, first_axis)


def _select_representatives(
    elements: Elements, is_cut: BoolArray, normal: FloatArray, width: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Select one piece per cell and quadrant of directions to represent all pieces there.

    If the pieces are not small, each of them represents itself.

    Return the rows of the representatives, the representative of each cut piece, and the area that
    each one represents.
    """
    rows = np.flatnonzero(is_cut)
    areas = elements.areas[rows]
    typical_area = float(np.median(areas))
    if typical_area > 0.3 * width**2:
        return rows, np.arange(len(rows)), np.asarray(areas)
    cell = np.floor(elements.places[rows] / (CELL_STRIPS * width)).astype(np.int64)
    cell -= cell.min(axis=0)
    size = cell.max(axis=0) + 1
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    # Faces in the same cell with a different direction belong to another surface.
    normals = elements.normals[rows]
    first_axis, second_axis = _plane_axes(normal)
    angles = np.arctan2(normals @ second_axis, normals @ first_axis)
    key = key * 4 + np.floor((angles + np.pi) / (np.pi / 2.0)).astype(np.int64) % 4
    _, cell_rows = np.unique(key, return_inverse=True)
    order = np.lexsort((areas, cell_rows))
    last_in_cell = np.flatnonzero(np.append(np.diff(cell_rows[order]) != 0, True))
    return (
        np.asarray(rows[order[last_in_cell]], np.int64),
        np.asarray(cell_rows, np.int64),
        np.array(np.bincount(cell_rows, areas), np.float64),
    )


def _compute_moments(
    label: IntArray,
    rows: IntArray,
    coordinates: FloatArray,
    slopes: FloatArray,
    steepness: FloatArray,
    weight: FloatArray,
    resolution: FloatArray,
    half_length: float,
    width: float,
    progress: Progress,
    previous_count: int,
) -> FloatArray:
    """Return the `line_moments` (rows, 9); `label` (k,) is the component of each piece."""
    count = int(label.max()) + 1
    # Sorting along the longest direction of a component keeps the runs short.
    number = np.maximum(np.bincount(label, minlength=count), 1)
    mean = [np.bincount(label, coordinates[:, k], count) / number for k in (1, 2)]
    offset = [coordinates[:, k] - mean[k - 1][label] for k in (1, 2)]
    uu, vv, uv = (
        np.bincount(label, a * b, count)
        for a, b in ((offset[0], offset[0]), (offset[1], offset[1]), (offset[0], offset[1]))
    )
    angle = 0.5 * np.arctan2(2.0 * uv, uu - vv)
    line_distance = np.cos(angle)[label] * offset[0] + np.sin(angle)[label] * offset[1]
    order = np.lexsort((line_distance, label))
    ends = np.cumsum(np.bincount(label, minlength=count))
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    sorted_coordinates = to_kernel_array(
        np.column_stack([coordinates, line_distance])[order], np.float64
    )
    last_piece = to_kernel_array(ends[label[order]], np.int64)
    first = to_kernel_array(np.concatenate([[0], ends[:-1]])[label[order]], np.int64)
    arrays = [
        to_kernel_array(values[order], np.float64)
        for values in (slopes, steepness, weight, resolution)
    ]
    moments = np.empty((len(rows), 9))

    def compute_block(block: slice) -> None:
        out = np.full((len(rows[block]), 9), np.nan)
        position = to_kernel_array(place[rows[block]], np.int64)
        line_moments(
            position, sorted_coordinates, *arrays, first, last_piece, half_length, width, out
        )
        moments[block] = out

    run_in_blocks(
        compute_block, len(rows), _OffsetProgress(progress, previous_count), _PIECES_PER_BLOCK
    )
    return moments


class _OffsetProgress(SilentProgress):
    """Progress that continues the count of a previous step."""

    def __init__(self, progress: Progress, offset: int) -> None:
        self._progress, self._offset = progress, offset

    def step(self, done_count: int) -> None:
        self._progress.step(self._offset + done_count)
