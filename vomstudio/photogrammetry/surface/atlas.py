"""Texture atlas: charts of the surface, and their positions on pages.

Rock faces consist of few facets seen from a few sides, so parallel projections along some
directions suffice. Faces are assigned to the direction that suits them and their neighbours.
Connected faces form a chart, overlapping faces are moved to other charts, and charts are packed by
their outlines. General parametrisations (uvatlas, xatlas) minimise stretch instead, which takes
many times longer on such surfaces and results in more and smaller charts.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.surface.topology import components, cross_products, neighbours

# Cosines: minimum between a chart's direction and its faces, and limit of the faces of one
# direction.
_MIN_FACING_COSINE = 0.26
_MIN_DIRECTION_COSINE = 0.72
_MAX_DIRECTIONS = 24
_EQUAL_LABEL_GAIN = 0.35
# A chart is divided if it fills less than this share of its box, is wider than this number of
# texels, and has at least this number of faces.
_MIN_FILL_SHARE = 0.45
_MIN_SPLIT_WIDTH_TEXELS = 192
_MIN_SPLIT_FACES = 24
# Charts are packed in squares of this number of texels.
_CELL_TEXELS = 8
_MAX_ATTEMPTS = 6


@dataclass(frozen=True)
class AtlasOptions:
    """Layout of pages.

    Attributes
    ----------
    page : int
        Maximum side of a page, texels.
    gutter : int
        Width of the strip of texels around each chart that repeats its border.
    max_pages : int
        Maximum number of pages; if more would be needed, texels are enlarged.
    """

    page: int = 4096
    gutter: int = 4
    max_pages: int = 16

    def __post_init__(self) -> None:
        if not 64 <= self.page <= 16384 or self.page % _CELL_TEXELS:
            raise UsageError(
                Finding("texture.page-size", step=_CELL_TEXELS),
                field="page",
            )
        if not 1 <= self.gutter <= 32:
            raise UsageError(
                Finding("option.out-of-range", value=self.gutter, minimum=1, maximum=32),
                field="gutter",
            )
        if self.max_pages < 1:
            raise UsageError(
                Finding("option.too-small", value=self.max_pages, minimum=1), field="max_pages"
            )


@dataclass(frozen=True, eq=False)
class Atlas:
    """Atlas of m faces.

    Attributes
    ----------
    corners : (m, 3, 2) float64 array
        Corners of the faces in texels on the page, x right and y down from its upper left corner.
    page, chart : (m,) int32 array
    sizes : (p, 2) array
        Width and height of the pages, texels.
    texel : float
        Edge length of a texel on the surface, in the unit of the vertices, where its factor is 1.
    """

    corners: FloatArray
    page: Int32Array
    chart: Int32Array
    sizes: IntArray
    texel: float
    facts: dict[str, Any]


def make_atlas(
    vertices: FloatArray,
    faces: Int32Array,
    texel: float,
    options: AtlasOptions | None = None,
    progress: Progress | None = None,
    factors: FloatArray | None = None,
) -> Atlas:
    """Pack charts of all faces on as few pages as possible.

    Parameters
    ----------
    vertices, faces : array
    texel : float
        Edge length of a texel, in the unit of the vertices. It is enlarged if the charts do not fit
        on `max_pages` pages.
    options : AtlasOptions, optional
    progress : Progress, optional
    factors : (m,) array, optional
        Factor by which the texels of each face are enlarged. It should take few different values,
        because a chart has one factor.

    Raises
    ------
    GeometryError
        If the mesh has no faces, `texel` is not positive, or the charts do not fit.
    """
    options, progress = options or AtlasOptions(), progress or SilentProgress()
    if not len(faces):
        raise GeometryError(Finding("texture.no-triangles"))
    if not (texel > 0 and math.isfinite(texel)):
        raise GeometryError(Finding("number.not-positive", value=texel), field="texel")
    progress.stage(tr("Creating texture charts"))
    cross = cross_products(vertices, faces)
    if factors is None:
        factors = np.ones(len(faces))
    area = float((np.linalg.norm(cross, axis=1) / factors**2).sum() / 2)
    requested_texel = texel
    max_area = options.page**2 * options.max_pages * 0.6
    texel = max(texel, math.sqrt(area / max_area))
    chart_corners, chart = _flatten(vertices, faces, cross, factors, texel, options, progress)
    for _ in range(20):
        progress.stage(tr("Packing texture charts"))
        layout = _pack_charts(chart_corners / texel, chart, options, progress)
        if layout is not None:
            break
        texel *= 1.1
        chart_corners, chart = _flatten(vertices, faces, cross, factors, texel, options, progress)
    else:
        raise GeometryError(Finding("texture.charts-too-large"))
    corners, page, sizes = layout
    drawn_area = np.abs(_doubled_areas(corners)).sum() / 2
    facts = {
        "texel_m": texel,
        "wanted_texel_m": requested_texel,
        "has_factors": bool((factors != 1).any()),
        "charts": int(chart.max()) + 1,
        "pages": len(sizes),
        "page_sizes": sizes.tolist(),
        "filled_share": float(drawn_area / (sizes[:, 0] * sizes[:, 1]).sum()),
    }
    return Atlas(corners, page, chart, sizes, texel, facts)


def uv_mesh(atlas: Atlas, faces: Int32Array) -> tuple[IntArray, Int32Array, Float32Array, IntArray]:
    """Return a mesh whose vertices have one texture coordinate each, faces grouped by page.

    Returns
    -------
    old : (n,) array
        Original vertex of each new vertex.
    faces : (m, 3) array
        Faces as rows of the new vertices.
    uv : (n, 2) array
        Texture coordinates with the origin at the lower left.
    order : (m,) array
        Original row of each face.
    """
    order = np.argsort(atlas.page, kind="stable")
    keys = faces[order].astype(np.int64) << 32 | atlas.chart[order, None]
    _, first_corners, inverse = np.unique(keys.ravel(), return_index=True, return_inverse=True)
    old_vertices = faces[order].ravel()[first_corners].astype(np.int64)
    texel_positions = atlas.corners[order].reshape(-1, 2)[first_corners]
    page_sizes = atlas.sizes[np.repeat(atlas.page[order], 3)[first_corners]]
    uv = texel_positions / page_sizes
    uv[:, 1] = 1.0 - uv[:, 1]
    new_faces = inverse.reshape(-1, 3).astype(np.int32)
    return old_vertices, new_faces, np.clip(uv, 0, 1).astype(np.float32), order


# --- charts ------------------------------------------------------------------------------------


def _flatten(
    vertices: FloatArray,
    faces: Int32Array,
    cross: FloatArray,
    factors: FloatArray,
    texel: float,
    options: AtlasOptions,
    progress: Progress,
) -> tuple[FloatArray, Int32Array]:
    """Return corners (m, 3, 2) of faces in their charts, and non-overlapping charts (m,).

    Corners are in the unit of the vertices divided by the factors, from (0, 0).
    """
    length = np.linalg.norm(cross, axis=1)
    exact_normals = np.divide(
        cross, length[:, None], out=np.zeros_like(cross), where=length[:, None] > 0
    )
    neighbour_faces = neighbours(faces)
    labels = _direction_labels(cross, exact_normals, neighbour_faces)
    classes = np.unique(factors, return_inverse=True)[1].reshape(-1).astype(np.int32)
    class_count = int(classes.max()) + 1
    pieces = _connected_pieces(faces, labels * class_count + classes)
    chart_coordinates = np.zeros((len(faces), 3, 2))
    chart = np.full(len(faces), -1, np.int32)
    remaining_faces = np.arange(len(faces))
    chart_count = 0
    max_side = (options.page - 2 * options.gutter - 2 * _CELL_TEXELS) * texel
    for attempt in range(_MAX_ATTEMPTS):
        progress.step(attempt)
        if not len(remaining_faces):
            break
        is_last_attempt = attempt == _MAX_ATTEMPTS - 1
        groups = np.arange(len(remaining_faces)) if is_last_attempt else pieces[remaining_faces]
        order = np.argsort(groups, kind="stable")
        bounds = np.flatnonzero(np.r_[True, np.diff(groups[order]) != 0, True])
        overlapping_faces = []
        for start, stop in itertools.pairwise(bounds):
            rows = remaining_faces[order[start:stop]]
            is_facing_away = _project(
                vertices, faces, rows, cross, exact_normals, chart_coordinates
            )
            chart_coordinates[rows] /= factors[rows, None, None]
            for part_rows in _cut_chart(chart_coordinates, rows[~is_facing_away], max_side, texel):
                is_overlapping = _find_overlapping_faces(chart_coordinates, part_rows, texel)
                fitting_faces = part_rows[~is_overlapping]
                if len(fitting_faces):
                    chart_coordinates[fitting_faces] -= (
                        chart_coordinates[fitting_faces].reshape(-1, 2).min(axis=0)
                    )
                    chart[fitting_faces] = chart_count
                    chart_count += 1
                overlapping_faces.append(part_rows[is_overlapping])
            overlapping_faces.append(rows[is_facing_away])
        remaining_faces = (
            np.sort(np.concatenate(overlapping_faces)) if overlapping_faces else remaining_faces[:0]
        )
        if len(remaining_faces):
            is_remaining = np.zeros(len(faces), bool)
            is_remaining[remaining_faces] = True
            pieces = components(faces, is_remaining) * class_count + classes
    if len(remaining_faces):
        raise GeometryError(Finding("texture.charts-too-large"))
    return chart_coordinates, chart


def _direction_labels(
    cross: FloatArray, exact_normals: FloatArray, neighbour_faces: Int32Array
) -> Int32Array:
    """Return the projection direction (m,) of each face."""
    from vomstudio.photogrammetry.surface._atlas_kernels import assign_labels

    smoothed_normals = cross.copy()
    for _ in range(12):
        total = smoothed_normals.copy()
        for side in range(3):
            has_neighbour = neighbour_faces[:, side] >= 0
            total[has_neighbour] += smoothed_normals[neighbour_faces[has_neighbour, side]]
        smoothed_normals = total
        smoothed_normals /= 4
    length = np.linalg.norm(smoothed_normals, axis=1, keepdims=True)
    smoothed_normals = np.divide(
        smoothed_normals, length, out=np.zeros_like(smoothed_normals), where=length > 0
    )
    directions = _directions(smoothed_normals, np.linalg.norm(cross, axis=1))
    labels = np.ascontiguousarray((smoothed_normals @ directions.T).argmax(axis=1), np.int32)
    assign_labels(
        smoothed_normals,
        np.ascontiguousarray(exact_normals),
        neighbour_faces,
        directions,
        _MIN_FACING_COSINE,
        _EQUAL_LABEL_GAIN,
        30,
        labels,
    )
    return labels


def _directions(normals: FloatArray, weights: FloatArray) -> FloatArray:
    """Select a few directions so that nearly all of the surface faces one of them.

    The directions are selected greedily: each covers the largest part of the remaining surface, and
    is then replaced by the mean normal of that part.
    """
    candidate_count = 200
    k = np.arange(candidate_count) + 0.5
    z = 1 - 2 * k / candidate_count
    azimuth = np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z * z)
    candidates = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], 1)
    step = max(1, len(normals) // 50_000)
    sampled_normals, remaining_weights = normals[::step], weights[::step].copy()
    is_facing = sampled_normals @ candidates.T > _MIN_DIRECTION_COSINE
    total_weight = remaining_weights.sum()
    directions: list[FloatArray] = []
    for _ in range(_MAX_DIRECTIONS):
        if remaining_weights.sum() <= 0.002 * total_weight and directions:
            break
        best_direction = int((is_facing * remaining_weights[:, None]).sum(axis=0).argmax())
        direction = candidates[best_direction]
        for _ in range(3):
            is_covered = sampled_normals @ direction > _MIN_DIRECTION_COSINE
            mean = (sampled_normals[is_covered] * remaining_weights[is_covered, None]).sum(axis=0)
            if not np.linalg.norm(mean) > 0:
                break
            direction = mean / np.linalg.norm(mean)
        directions.append(direction)
        remaining_weights[sampled_normals @ direction > _MIN_DIRECTION_COSINE] = 0
        remaining_weights[is_facing[:, best_direction]] = 0
    return np.ascontiguousarray(directions)


def _connected_pieces(faces: Int32Array, labels: Int32Array) -> Int32Array:
    """Return the piece (m,) of connected faces with equal labels that contains each face."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    neighbour_faces = neighbours(faces)
    face, side = np.nonzero(neighbour_faces >= 0)
    other_face = neighbour_faces[face, side]
    has_same_label = labels[face] == labels[other_face]
    n = len(faces)
    links = coo_matrix(
        (
            np.ones(int(has_same_label.sum()), np.int8),
            (face[has_same_label], other_face[has_same_label]),
        ),
        shape=(n, n),
    )
    return np.asarray(connected_components(links, directed=False)[1], np.int32)


def _project(
    vertices: FloatArray,
    faces: Int32Array,
    rows: IntArray,
    cross: FloatArray,
    exact_normals: FloatArray,
    chart_coordinates: FloatArray,
) -> BoolArray:
    """Project faces along their mean normal, rotated into the smallest box, in place.

    Returns which of them face away. The mean area of texels is preserved.
    """
    normal = cross[rows].sum(axis=0)
    if not np.linalg.norm(normal) > 0:
        normal = cross[rows[np.linalg.norm(cross[rows], axis=1).argmax()]]
    if not np.linalg.norm(normal) > 0:
        normal = np.array([0.0, 0.0, 1.0])
    normal = normal / np.linalg.norm(normal)
    helper_axis = np.eye(3)[np.abs(normal).argmin()]
    right_axis = np.cross(helper_axis, normal)
    right_axis /= np.linalg.norm(right_axis)
    # y increases downwards on a page: right x down = into the surface.
    down_axis = np.cross(right_axis, normal)
    corners = vertices[faces[rows]]
    plane_coordinates = np.stack([corners @ right_axis, corners @ down_axis], -1)
    cosines = exact_normals[rows] @ normal
    areas = np.linalg.norm(cross[rows], axis=1)
    mean_cosine = float((areas * cosines).sum() / areas.sum()) if areas.sum() > 0 else 1.0
    angle = _smallest_box_angle(plane_coordinates.reshape(-1, 2))
    c, s = math.cos(angle), math.sin(angle)
    stretch = 1 / math.sqrt(min(max(mean_cosine, 0.5), 1.0))
    chart_coordinates[rows] = plane_coordinates @ np.array([[c, s], [-s, c]]) * stretch
    is_facing_away = (cosines < _MIN_FACING_COSINE / 2) & (areas > 0)
    return is_facing_away if len(rows) > 1 else np.zeros(1, bool)


def _smallest_box_angle(points: FloatArray) -> float:
    """Return the rotation angle of the smallest box around points."""
    hull_sample = points[:: max(1, len(points) // 3000)]
    angles = np.radians(np.arange(0, 90, 5.0))
    x = hull_sample @ np.stack([np.cos(angles), -np.sin(angles)])
    y = hull_sample @ np.stack([np.sin(angles), np.cos(angles)])
    return float(angles[(np.ptp(x, axis=0) * np.ptp(y, axis=0)).argmin()])


def _cut_chart(
    chart_coordinates: FloatArray, rows: IntArray, max_side: float, texel: float
) -> list[IntArray]:
    """Divide a chart, by its face centres, into parts that fit on a page and fill their boxes."""
    if not len(rows):
        return []
    lower_corner = chart_coordinates[rows].reshape(-1, 2).min(axis=0)
    extent = chart_coordinates[rows].reshape(-1, 2).max(axis=0) - lower_corner
    is_too_large = (extent > max_side).any()
    if not is_too_large:
        drawn_area = np.abs(_doubled_areas(chart_coordinates[rows])).sum() / 2
        # A ring or a winding ledge keeps more of a page free than its parts do.
        is_ragged = (
            drawn_area < _MIN_FILL_SHARE * extent.prod()
            and extent.max() > _MIN_SPLIT_WIDTH_TEXELS * texel
        )
        if not is_ragged or len(rows) < _MIN_SPLIT_FACES:
            return [rows]
    if len(rows) == 1:
        raise GeometryError(
            Finding("texture.triangle-too-large"),
            field="page",
        )
    centres = chart_coordinates[rows].mean(axis=1) - lower_corner
    axis = int(extent.argmax())
    is_far_side = centres[:, axis] > extent[axis] / 2
    if is_far_side.all() or not is_far_side.any():
        is_far_side = np.arange(len(rows)) >= len(rows) // 2
    return [
        *_cut_chart(chart_coordinates, rows[~is_far_side], max_side, texel),
        *_cut_chart(chart_coordinates, rows[is_far_side], max_side, texel),
    ]


def _find_overlapping_faces(
    chart_coordinates: FloatArray, rows: IntArray, texel: float
) -> BoolArray:
    from vomstudio.photogrammetry.surface._atlas_kernels import find_overlap

    if len(rows) < 2:
        return np.zeros(len(rows), bool)
    texel_coordinates = np.ascontiguousarray(chart_coordinates[rows] / texel)
    texel_coordinates -= texel_coordinates.reshape(-1, 2).min(axis=0)
    width, height = (np.ceil(texel_coordinates.reshape(-1, 2).max(axis=0)).astype(int) + 1).tolist()
    is_overlapping = np.zeros(len(rows), bool)
    grid = np.full((height, width), -1, np.int32)
    find_overlap(texel_coordinates, np.arange(len(rows), dtype=np.int32), grid, is_overlapping)
    return is_overlapping


# --- pages -------------------------------------------------------------------------------------


def _pack_charts(
    texel_coordinates: FloatArray, chart: Int32Array, options: AtlasOptions, progress: Progress
) -> tuple[FloatArray, Int32Array, IntArray] | None:
    """Return corners on pages in texels, the page of each face, and the page sizes.

    Returns None if there are too many pages.
    """
    from vomstudio.photogrammetry.surface._atlas_kernels import mark_covered_cells

    count = int(chart.max()) + 1
    order = np.argsort(chart, kind="stable").astype(np.int32)
    bounds = np.r_[0, np.cumsum(np.bincount(chart, minlength=count))]
    cell_masks, filled_counts = [], np.zeros(count, np.int64)
    padding = float(options.gutter)
    for k in range(count):
        rows = order[bounds[k] : bounds[k + 1]]
        size = texel_coordinates[rows].reshape(-1, 2).max(axis=0) + 2 * padding
        cells = np.zeros(np.ceil(size[::-1] / _CELL_TEXELS).astype(int), bool)
        mark_covered_cells(
            texel_coordinates,
            np.ascontiguousarray(rows),
            padding,
            padding,
            float(_CELL_TEXELS),
            cells,
        )
        cell_masks.append(cells)
        filled_counts[k] = cells.sum()
    page_side = _page_side(cell_masks, int(filled_counts.sum()), options) // _CELL_TEXELS
    while True:
        layout = _place_charts(cell_masks, filled_counts, page_side, options, progress)
        # One slightly larger page is better than a second one for the remaining charts.
        if page_side == options.page // _CELL_TEXELS or (
            layout is not None and len(layout[0]) == 1
        ):
            break
        page_side = min(page_side + max(page_side // 20, 1), options.page // _CELL_TEXELS)
    if layout is None:
        return None
    pages, placements = layout
    corners = texel_coordinates + (placements[chart, 1:] * _CELL_TEXELS + padding)[:, None, :]
    sizes = []
    for page in pages:
        used_rows, used_columns = np.flatnonzero(page.any(axis=1)), np.flatnonzero(page.any(axis=0))
        sizes.append(
            [(used_columns.max() + 1) * _CELL_TEXELS, (used_rows.max() + 1) * _CELL_TEXELS]
        )
    return corners, placements[chart, 0].astype(np.int32), np.array(sizes, np.int64)


def _place_charts(
    cell_masks: list[BoolArray],
    filled_counts: IntArray,
    page_side: int,
    options: AtlasOptions,
    progress: Progress,
) -> tuple[list[BoolArray], IntArray] | None:
    """Return the pages, and the page, column and row of each chart; None if they do not fit."""
    from vomstudio.photogrammetry.surface._atlas_kernels import find_chart_position

    count = len(cell_masks)
    pages: list[BoolArray] = []
    starts: list[dict[tuple[int, int], int]] = []
    placements = np.zeros((count, 3), np.int64)
    longest_sides = np.array([max(s.shape) for s in cell_masks])
    for done_count, k in enumerate(np.lexsort((-filled_counts, -longest_sides)).tolist()):
        if done_count % 64 == 0:
            progress.step(done_count)
        cells = cell_masks[k]
        size_class = (int(cells.shape[0]).bit_length(), int(cells.shape[1]).bit_length())
        page_number, position = 0, -1
        while position < 0:
            if page_number == len(pages):
                if page_number == options.max_pages:
                    return None
                pages.append(np.zeros((page_side, page_side), bool))
                starts.append({})
            # Rows above the last chart of this size have no space for the next one either.
            first_row = starts[page_number].get(size_class, 0)
            position = int(find_chart_position(pages[page_number], cells, first_row, page_side))
            if position < 0:
                starts[page_number][size_class] = page_side
                page_number += 1
        row, column = divmod(position, page_side)
        starts[page_number][size_class] = row
        h, w = cells.shape
        pages[page_number][row : row + h, column : column + w] |= cells
        placements[k] = page_number, column, row
    return pages, placements


def _page_side(cell_masks: list[BoolArray], filled_count: int, options: AtlasOptions) -> int:
    """Return the side length of a page, no larger than required for all charts."""
    max_chart_side = max(max(shape.shape) for shape in cell_masks) * _CELL_TEXELS
    side = math.ceil(math.sqrt(filled_count / 0.85) * _CELL_TEXELS / 64) * 64
    return int(min(max(side, max_chart_side), options.page))


def _doubled_areas(corners: FloatArray) -> FloatArray:
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
