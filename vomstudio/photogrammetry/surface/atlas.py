"""Texture atlas: charts of the surface, and their places on the pages.

Rock faces are made of few facets seen from a few sides, so that parallel projections along some
directions serve: faces take the direction that suits them and their neighbours, connected ones make
a chart, faces that would lie on others of their chart leave it, and charts are packed by their true
outlines. General parametrisations (uvatlas, xatlas) minimise stretch instead, which on such
surfaces takes many times longer and leaves more and smaller charts.
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
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.photogrammetry.surface.topology import components, cross_products, neighbours

# Cosines: between a chart's direction and its faces at least, and as far as one direction is taken
# to reach.
_LEAST_FACING = 0.26
_REACH = 0.72
_MOST_DIRECTIONS = 24
_JOINING = 0.35
# A chart that fills less than this share of its box and is wider than so many texels is divided;
# none with fewer faces is.
_RAGGED = 0.45
_WIDE = 192
_SMALL = 24
# A chart is packed in squares of so many texels.
_CELL = 8
_TRIES = 6


@dataclass(frozen=True)
class AtlasOptions:
    """How pages are laid out.

    page : longest side of a page, texels
    gutter : texels about each chart that repeat its border
    most_pages : with more, the texels are made larger
    """

    page: int = 4096
    gutter: int = 4
    most_pages: int = 16

    def __post_init__(self) -> None:
        if not 64 <= self.page <= 16384 or self.page % _CELL:
            raise UsageError(
                Finding("texture.page-size", step=_CELL),
                field="page",
            )
        if not 1 <= self.gutter <= 32:
            raise UsageError(
                Finding("option.out-of-range", value=self.gutter, minimum=1, maximum=32),
                field="gutter",
            )
        if self.most_pages < 1:
            raise UsageError(
                Finding("option.too-small", value=self.most_pages, minimum=1), field="most_pages"
            )


@dataclass(frozen=True, eq=False)
class Atlas:
    """m faces on pages.

    corners : (m, 3, 2) float64 texels on the page, x right, y down from its upper left corner
    page : (m,) int32
    chart : (m,) int32
    sizes : (p, 2) width and height of the pages, texels
    texel : edge of a texel on the surface, in the unit of the vertices
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
) -> Atlas:
    """Charts of all faces on as few pages as they need.

    texel : wanted edge of a texel, in the unit of the vertices; made larger, and said so in
    `facts`, where more than `most_pages` would come out

    Raises GeometryError for a mesh without faces, or where no charts fit.
    """
    options, progress = options or AtlasOptions(), progress or Silent()
    if not len(faces):
        raise GeometryError(Finding("texture.no-triangles"))
    if not (texel > 0 and math.isfinite(texel)):
        raise GeometryError(Finding("number.not-positive", value=texel), field="texel")
    progress.stage(tr("Creating texture charts"))
    cross = cross_products(vertices, faces)
    area = float(np.linalg.norm(cross, axis=1).sum() / 2)
    wanted = texel
    room = options.page**2 * options.most_pages * 0.6
    texel = max(texel, math.sqrt(area / room))
    flat, chart = _flatten(vertices, faces, cross, texel, options, progress)
    for _ in range(20):
        progress.stage(tr("Packing texture charts"))
        packed = _pack(flat / texel, chart, options, progress)
        if packed is not None:
            break
        texel *= 1.1
        flat, chart = _flatten(vertices, faces, cross, texel, options, progress)
    else:
        raise GeometryError(Finding("texture.charts-too-large"))
    corners, page, sizes = packed
    drawn = np.abs(_doubled_areas(corners)).sum() / 2
    facts = {
        "texel_m": texel,
        "wanted_texel_m": wanted,
        "charts": int(chart.max()) + 1,
        "pages": len(sizes),
        "page_sizes": sizes.tolist(),
        "filled_share": float(drawn / (sizes[:, 0] * sizes[:, 1]).sum()),
    }
    return Atlas(corners, page, chart, sizes, texel, facts)


def uv_mesh(atlas: Atlas, faces: Int32Array) -> tuple[IntArray, Int32Array, Float32Array, IntArray]:
    """A mesh whose vertices have one texture coordinate each, faces grouped by page.

    Returns the old vertex of each new one (n,), faces (m, 3) of new vertices, uv (n, 2) with the
    origin at the lower left, and the old row of each face (m,).
    """
    order = np.argsort(atlas.page, kind="stable")
    key = faces[order].astype(np.int64) << 32 | atlas.chart[order, None]
    _, first, inverse = np.unique(key.ravel(), return_index=True, return_inverse=True)
    old = faces[order].ravel()[first].astype(np.int64)
    place = atlas.corners[order].reshape(-1, 2)[first]
    size = atlas.sizes[np.repeat(atlas.page[order], 3)[first]]
    uv = place / size
    uv[:, 1] = 1.0 - uv[:, 1]
    fresh = inverse.reshape(-1, 3).astype(np.int32)
    return old, fresh, np.clip(uv, 0, 1).astype(np.float32), order


# --- charts ------------------------------------------------------------------------------------


def _flatten(
    vertices: FloatArray,
    faces: Int32Array,
    cross: FloatArray,
    texel: float,
    options: AtlasOptions,
    progress: Progress,
) -> tuple[FloatArray, Int32Array]:
    """(m, 3, 2) corners of each face within its chart, in the unit of the vertices, from (0, 0) up;
    and (m,) charts, no two faces of one overlapping."""
    length = np.linalg.norm(cross, axis=1)
    exact = np.divide(cross, length[:, None], out=np.zeros_like(cross), where=length[:, None] > 0)
    across = neighbours(faces)
    labels = _labels(cross, exact, across)
    piece = _connected_pieces(faces, labels)
    flat = np.zeros((len(faces), 3, 2))
    chart = np.full(len(faces), -1, np.int32)
    left = np.arange(len(faces))
    count = 0
    longest = (options.page - 2 * options.gutter - 2 * _CELL) * texel
    for attempt in range(_TRIES):
        progress.step(attempt)
        if not len(left):
            break
        alone = attempt == _TRIES - 1
        groups = np.arange(len(left)) if alone else piece[left]
        order = np.argsort(groups, kind="stable")
        bounds = np.flatnonzero(np.r_[True, np.diff(groups[order]) != 0, True])
        out = []
        for start, stop in itertools.pairwise(bounds):
            rows = left[order[start:stop]]
            poor = _project(vertices, faces, rows, cross, exact, flat)
            for part in _cut(flat, rows[~poor], longest, texel):
                clash = _overlapping(flat, part, texel)
                sound = part[~clash]
                if len(sound):
                    flat[sound] -= flat[sound].reshape(-1, 2).min(axis=0)
                    chart[sound] = count
                    count += 1
                out.append(part[clash])
            out.append(rows[poor])
        left = np.sort(np.concatenate(out)) if out else left[:0]
        if len(left):
            among = np.zeros(len(faces), bool)
            among[left] = True
            piece = components(faces, among)
    if len(left):
        raise GeometryError(Finding("texture.charts-too-large"))
    return flat, chart


def _labels(cross: FloatArray, exact: FloatArray, across: Int32Array) -> Int32Array:
    """(m,) the direction along which each face is drawn."""
    from vomstudio.photogrammetry.surface._atlas_kernels import settle_labels

    smooth = cross.copy()
    for _ in range(12):
        total = smooth.copy()
        for side in range(3):
            there = across[:, side] >= 0
            total[there] += smooth[across[there, side]]
        smooth = total
        smooth /= 4
    length = np.linalg.norm(smooth, axis=1, keepdims=True)
    smooth = np.divide(smooth, length, out=np.zeros_like(smooth), where=length > 0)
    directions = _directions(smooth, np.linalg.norm(cross, axis=1))
    labels = np.ascontiguousarray((smooth @ directions.T).argmax(axis=1), np.int32)
    settle_labels(
        smooth, np.ascontiguousarray(exact), across, directions, _LEAST_FACING, _JOINING, 30, labels
    )
    return labels


def _directions(normals: FloatArray, weights: FloatArray) -> FloatArray:
    """Few directions so that nearly all of the surface faces one of them: greedily, the one that
    reaches most of what is left, moved to the mean of what it reaches."""
    n = 200
    k = np.arange(n) + 0.5
    z = 1 - 2 * k / n
    turn = np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z * z)
    candidates = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], 1)
    step = max(1, len(normals) // 50_000)
    some, weight = normals[::step], weights[::step].copy()
    facing = some @ candidates.T > _REACH
    whole = weight.sum()
    chosen: list[FloatArray] = []
    for _ in range(_MOST_DIRECTIONS):
        if weight.sum() <= 0.002 * whole and chosen:
            break
        best = int((facing * weight[:, None]).sum(axis=0).argmax())
        direction = candidates[best]
        for _ in range(3):
            reached = some @ direction > _REACH
            mean = (some[reached] * weight[reached, None]).sum(axis=0)
            if not np.linalg.norm(mean) > 0:
                break
            direction = mean / np.linalg.norm(mean)
        chosen.append(direction)
        weight[some @ direction > _REACH] = 0
        weight[facing[:, best]] = 0
    return np.ascontiguousarray(chosen)


def _connected_pieces(faces: Int32Array, labels: Int32Array) -> Int32Array:
    """(m,) connected faces of one label."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    across = neighbours(faces)
    face, side = np.nonzero(across >= 0)
    other = across[face, side]
    same = labels[face] == labels[other]
    n = len(faces)
    links = coo_matrix((np.ones(int(same.sum()), np.int8), (face[same], other[same])), shape=(n, n))
    return np.asarray(connected_components(links, directed=False)[1], np.int32)


def _project(
    vertices: FloatArray,
    faces: Int32Array,
    rows: IntArray,
    cross: FloatArray,
    exact: FloatArray,
    flat: FloatArray,
) -> BoolArray:
    """Draw faces along their mean normal into the narrowest upright box; which of them look away
    from it. Texels keep their area on average."""
    normal = cross[rows].sum(axis=0)
    if not np.linalg.norm(normal) > 0:
        normal = cross[rows[np.linalg.norm(cross[rows], axis=1).argmax()]]
    if not np.linalg.norm(normal) > 0:
        normal = np.array([0.0, 0.0, 1.0])
    normal = normal / np.linalg.norm(normal)
    helper = np.eye(3)[np.abs(normal).argmin()]
    right = np.cross(helper, normal)
    right /= np.linalg.norm(right)
    # y grows downwards on a page: right x down = into the surface.
    down = np.cross(right, normal)
    corners = vertices[faces[rows]]
    drawn = np.stack([corners @ right, corners @ down], -1)
    flatness = exact[rows] @ normal
    seen = np.linalg.norm(cross[rows], axis=1)
    cosine = float((seen * flatness).sum() / seen.sum()) if seen.sum() > 0 else 1.0
    angle = _smallest_box_angle(drawn.reshape(-1, 2))
    c, s = math.cos(angle), math.sin(angle)
    stretch = 1 / math.sqrt(min(max(cosine, 0.5), 1.0))
    flat[rows] = drawn @ np.array([[c, s], [-s, c]]) * stretch
    poor = (flatness < _LEAST_FACING / 2) & (seen > 0)
    return poor if len(rows) > 1 else np.zeros(1, bool)


def _smallest_box_angle(points: FloatArray) -> float:
    """Angle by which points are turned to fit the smallest box."""
    some = points[:: max(1, len(points) // 3000)]
    angles = np.radians(np.arange(0, 90, 5.0))
    x = some @ np.stack([np.cos(angles), -np.sin(angles)])
    y = some @ np.stack([np.sin(angles), np.cos(angles)])
    return float(angles[(np.ptp(x, axis=0) * np.ptp(y, axis=0)).argmin()])


def _cut(flat: FloatArray, rows: IntArray, longest: float, texel: float) -> list[IntArray]:
    """Parts of a chart that fit a page and fill their boxes, by the middles of their faces."""
    if not len(rows):
        return []
    low = flat[rows].reshape(-1, 2).min(axis=0)
    extent = flat[rows].reshape(-1, 2).max(axis=0) - low
    large = (extent > longest).any()
    if not large:
        drawn = np.abs(_doubled_areas(flat[rows])).sum() / 2
        # A ring or a winding ledge keeps more of a page free than its parts do.
        ragged = drawn < _RAGGED * extent.prod() and extent.max() > _WIDE * texel
        if not ragged or len(rows) < _SMALL:
            return [rows]
    if len(rows) == 1:
        raise GeometryError(
            Finding("texture.triangle-too-large"),
            field="page",
        )
    middle = flat[rows].mean(axis=1) - low
    axis = int(extent.argmax())
    far = middle[:, axis] > extent[axis] / 2
    if far.all() or not far.any():
        far = np.arange(len(rows)) >= len(rows) // 2
    return [
        *_cut(flat, rows[~far], longest, texel),
        *_cut(flat, rows[far], longest, texel),
    ]


def _overlapping(flat: FloatArray, rows: IntArray, texel: float) -> BoolArray:
    from vomstudio.photogrammetry.surface._atlas_kernels import find_overlap

    if len(rows) < 2:
        return np.zeros(len(rows), bool)
    drawn = np.ascontiguousarray(flat[rows] / texel)
    drawn -= drawn.reshape(-1, 2).min(axis=0)
    width, height = (np.ceil(drawn.reshape(-1, 2).max(axis=0)).astype(int) + 1).tolist()
    clash = np.zeros(len(rows), bool)
    grid = np.full((height, width), -1, np.int32)
    find_overlap(drawn, np.arange(len(rows), dtype=np.int32), grid, clash)
    return clash


# --- pages -------------------------------------------------------------------------------------


def _pack(
    drawn: FloatArray, chart: Int32Array, options: AtlasOptions, progress: Progress
) -> tuple[FloatArray, Int32Array, IntArray] | None:
    """Corners on pages, in texels; None where there would be too many pages."""
    from vomstudio.photogrammetry.surface._atlas_kernels import cover_cells

    count = int(chart.max()) + 1
    order = np.argsort(chart, kind="stable").astype(np.int32)
    bounds = np.r_[0, np.cumsum(np.bincount(chart, minlength=count))]
    shapes, filled = [], np.zeros(count, np.int64)
    pad = float(options.gutter)
    for k in range(count):
        rows = order[bounds[k] : bounds[k + 1]]
        size = drawn[rows].reshape(-1, 2).max(axis=0) + 2 * pad
        cells = np.zeros(np.ceil(size[::-1] / _CELL).astype(int), bool)
        cover_cells(drawn, np.ascontiguousarray(rows), pad, pad, float(_CELL), cells)
        shapes.append(cells)
        filled[k] = cells.sum()
    side = _page_side(shapes, int(filled.sum()), options) // _CELL
    while True:
        packed = _place_charts(shapes, filled, side, options, progress)
        # One page a little larger is better than a second one for what is left.
        if side == options.page // _CELL or (packed is not None and len(packed[0]) == 1):
            break
        side = min(side + max(side // 20, 1), options.page // _CELL)
    if packed is None:
        return None
    pages, place = packed
    corners = drawn + (place[chart, 1:] * _CELL + pad)[:, None, :]
    sizes = []
    for page in pages:
        rows_used, columns_used = np.flatnonzero(page.any(axis=1)), np.flatnonzero(page.any(axis=0))
        sizes.append([(columns_used.max() + 1) * _CELL, (rows_used.max() + 1) * _CELL])
    return corners, place[chart, 0].astype(np.int32), np.array(sizes, np.int64)


def _place_charts(
    shapes: list[BoolArray],
    filled: IntArray,
    side: int,
    options: AtlasOptions,
    progress: Progress,
) -> tuple[list[BoolArray], IntArray] | None:
    """Pages of side x side cells, and page, column and row of each chart; None where there would
    be too many pages."""
    from vomstudio.photogrammetry.surface._atlas_kernels import place_chart

    count = len(shapes)
    pages: list[BoolArray] = []
    starts: list[dict[tuple[int, int], int]] = []
    place = np.zeros((count, 3), np.int64)
    tallest = np.array([max(s.shape) for s in shapes])
    for done, k in enumerate(np.lexsort((-filled, -tallest)).tolist()):
        if done % 64 == 0:
            progress.step(done)
        cells = shapes[k]
        kind = (int(cells.shape[0]).bit_length(), int(cells.shape[1]).bit_length())
        number, at = 0, -1
        while at < 0:
            if number == len(pages):
                if number == options.most_pages:
                    return None
                pages.append(np.zeros((side, side), bool))
                starts.append({})
            # Where a chart of this size found room, rows above are full for the next as well.
            first = starts[number].get(kind, 0)
            at = int(place_chart(pages[number], cells, first, side))
            if at < 0:
                starts[number][kind] = side
                number += 1
        row, column = divmod(at, side)
        starts[number][kind] = row
        h, w = cells.shape
        pages[number][row : row + h, column : column + w] |= cells
        place[k] = number, column, row
    return pages, place


def _page_side(shapes: list[BoolArray], filled: int, options: AtlasOptions) -> int:
    """A page no larger than all charts need."""
    widest = max(max(shape.shape) for shape in shapes) * _CELL
    side = math.ceil(math.sqrt(filled / 0.85) * _CELL / 64) * 64
    return int(min(max(side, widest), options.page))


def _doubled_areas(corners: FloatArray) -> FloatArray:
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
