"""The line in which a plane of given attitude cuts a surface, around each place of the surface."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements
from vomstudio.extraction.measurable_kernels import line_moments
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.nearby.point_grid import run_in_blocks

# Of the length: the strip on either side of the line, at least, and where the mesh must be cut.
_STRIPS, _FEWEST_STRIPS, _STRIPS_OF_CUT = 40.0, 12.0, 40.0
# Of the half strip, the side of the cells of which one piece stands for all.
CELL = 0.75
_BLOCK = 20_000


def step_of(spacing: float, length: float) -> float:
    """Half of the width of the strip that a line is taken from, for a mesh or cloud of this
    spacing."""
    if spacing <= length / _FEWEST_STRIPS:
        return max(spacing, length / _STRIPS)
    return length / _STRIPS_OF_CUT


def hanging_together(elements: Elements, band: IntArray) -> IntArray:
    """(n,) a number for the pieces of one band that are neighbours of neighbours; -1 has none."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(band)
    source = np.repeat(np.arange(n, dtype=np.int32), np.diff(elements.starts))
    same = (band[source] == band[elements.near]) & (band[source] >= 0)
    source, near = source[same], elements.near[same]
    graph = coo_matrix((np.ones(len(source), np.int8), (source, near)), shape=(n, n)).tocsr()
    found = np.asarray(connected_components(graph, directed=False)[1], np.int64)
    return np.where(band < 0, -1, found)


def lines_through(
    elements: Elements,
    normal: FloatArray,
    cut: BoolArray,
    exposed: BoolArray,
    resolution: FloatArray,
    length: float,
    progress: Progress,
) -> FloatArray:
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
    width = step_of(float(spread), length)
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
    progress.stage(tr("Measuring patches"), len(one))
    before = 0
    for bands, places_there in ((quarter, middle), (half_later, ~middle)):
        band = np.where(cut | exposed, np.floor(bands).astype(np.int64), -1)
        label = hanging_together(elements, np.where(band < 0, -1, band))[one]
        rows = np.flatnonzero(places_there)
        if len(rows):
            found[rows] = _moments(
                label,
                rows,
                own,
                slopes,
                steep,
                weight,
                resolution[one],
                length / 2.0,
                width,
                progress,
                before,
            )
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


def _in_plane(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors at right angles in the plane."""
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _thinned(
    elements: Elements, cut: BoolArray, normal: FloatArray, width: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Rows of pieces that stand for all that are cut, one in each cell of the width and side of the
    plane; which of them stands for each of these; and the area each stands for."""
    rows = np.flatnonzero(cut)
    areas = elements.areas[rows]
    usual = float(np.median(areas))
    if usual > 0.3 * width**2:
        return rows, np.arange(len(rows)), np.asarray(areas)
    cell = np.floor(elements.places[rows] / (CELL * width)).astype(np.int64)
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
    return (
        np.asarray(rows[order[last]], np.int64),
        np.asarray(of, np.int64),
        np.array(np.bincount(of, areas), np.float64),
    )


def _moments(
    label: IntArray,
    rows: IntArray,
    own: FloatArray,
    slopes: FloatArray,
    steep: FloatArray,
    weight: FloatArray,
    resolution: FloatArray,
    half: float,
    width: float,
    progress: Progress,
    before: int,
) -> FloatArray:
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
        at = for_kernels(place[rows[block]], np.int64)
        line_moments(at, sorted_own, *arrays, first, last, half, width, out)
        found[block] = out

    run_in_blocks(work, len(rows), _After(progress, before), _BLOCK)
    return found


class _After(Silent):
    """Steps that count on from others."""

    def __init__(self, progress: Progress, before: int) -> None:
        self._progress, self._before = progress, before

    def step(self, done: int) -> None:
        self._progress.step(self._before + done)
