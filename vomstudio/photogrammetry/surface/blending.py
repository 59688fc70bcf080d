"""Blending of all photos into one colouring of a mesh: exposure, occluders, seams.

Two bands are blended (Burt and Adelson 1983). They are separated on the mesh and not in the photos,
where a blur would mix the rock with its foreground. The low band is the mean of all agreeing
photos, and the high band is that of the best photo of a face. The colour of a texel is the pixel of
the best photo, times the gain of the photo, plus the offset of the mean from the photo, smoothed
over the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    IndexArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.surface.topology import edge_keys, neighbours
from vomstudio.photogrammetry.surface.visibility import PhotoVisibility

# Quality factor of barely visible faces, which are drawn only without a better photo.
_POOR_QUALITY_FACTOR = 1e-3
_EQUAL_VIEW_GAIN = 0.12
# Sharpness relative to the median photo above which photos are equally good.
_MIN_SHARPNESS = 0.88
_MAX_SAMPLED_VERTICES = 40_000
_MIN_COMMON_VERTICES = 40
# Difference of values (0..255) above which a photo may show an occluder.
_MIN_OCCLUDER_DIFFERENCE = 20.0
_OCCLUDER_MARGIN_RINGS = 3
_LOW_BAND_WIDTH_TEXELS = 40.0
_MAX_ROUNDS = 80


@dataclass(frozen=True, eq=False)
class Blend:
    """Colouring of m faces and n vertices from photos.

    Attributes
    ----------
    views : (m,) array
        Photo from which each face is drawn; -1 if it is not drawn from a photo.
    view_counts : (m,) array
        Number of photos with a good view of each face.
    entry_faces, entry_views, entry_weights, entry_offsets
        One row for each photo of a face: the face and the view (e,), and for the corners of the
        face the weights (e, 3) and the RGB offsets (e, 3, 3) that are added after the gain.
    colors : (n, 3) array
        Colours of the vertices, 0..255.
    is_known : (n,) array
        Whether the colour of each vertex is from photos.
    gains : (k, 3) array
        RGB gain of each photo.
    sharpness : (k,) array
        Sharpness of each photo relative to the median photo.
    occluded_counts : (k,) array
        Number of vertices at which each photo shows an occluder.
    """

    views: Int32Array
    view_counts: Int32Array
    entry_faces: Int32Array
    entry_views: Int32Array
    entry_weights: Float32Array
    entry_offsets: Float32Array
    colors: Float32Array
    is_known: BoolArray
    gains: FloatArray
    sharpness: FloatArray
    occluded_counts: IntArray


@dataclass(frozen=True, eq=False)
class _Entries:
    """Entries sorted by owner (a vertex or a face), then by view."""

    starts: Int32Array
    owner: Int32Array
    views: Int32Array
    keys: IntArray

    @cached_property
    def rows_by_view(self) -> list[IndexArray]:
        """Rows of each view, up to the last view with entries."""
        order = np.argsort(self.views, kind="stable")
        return np.split(order, np.cumsum(np.bincount(self.views))[:-1])

    def rows_of_view(self, view: int) -> IndexArray:
        return self.rows_by_view[view] if view < len(self.rows_by_view) else np.zeros(0, np.intp)

    @classmethod
    def build(
        cls, owner: Int32Array, views: Int32Array, n: int, count: int
    ) -> tuple[_Entries, IndexArray]:
        keys = owner.astype(np.int64) * count + views
        order = np.argsort(keys, kind="stable")
        owner, views = owner[order], views[order]
        starts = np.zeros(n + 1, np.int32)
        np.cumsum(np.bincount(owner, minlength=n), out=starts[1:])
        return cls(starts, owner, views, keys[order]), order

    def find(self, keys: IntArray) -> IntArray:
        """Return the rows of keys; missing keys have row -1."""
        if not len(self.keys):
            return np.full(keys.shape, -1, np.int64)
        index = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[index] == keys, index, -1)


def blend(
    vertices: FloatArray,
    faces: Int32Array,
    visibilities: Sequence[PhotoVisibility],
    texel: float,
    progress: Progress,
) -> Blend:
    """Compute the contribution of each photo.

    `texel` is the edge of a texel in the unit of the vertices.
    """
    from vomstudio.photogrammetry.surface._texture_kernels import choose_views, smooth_quality

    count, m, n = len(visibilities), len(faces), len(vertices)
    vertex_entries, order = _Entries.build(
        np.concatenate([photo.vertices for photo in visibilities]).astype(np.int32),
        _photo_numbers([photo.vertices for photo in visibilities]),
        n,
        count,
    )
    colors = np.concatenate([photo.colors for photo in visibilities])[order]
    detail = np.concatenate([photo.detail for photo in visibilities])[order]
    progress.stage(tr("Balancing exposure"))
    gains = np.exp(
        -_photo_biases(vertex_entries, n, count, np.log(colors + 4.0), _is_unclipped(colors))
    )
    gains /= np.exp(np.log(gains).mean(axis=0))
    sharpness = np.exp(_photo_biases(vertex_entries, n, count, detail[:, None], None)[:, 0])
    sharpness /= np.median(sharpness)
    colors = np.ascontiguousarray(colors * gains[vertex_entries.views], np.float32)
    links = _Links.build(faces, n)
    progress.stage(tr("Detecting occluders"), count)
    is_occluded = _find_occluded(vertex_entries, colors, links, count, progress)
    face_entries, order = _Entries.build(
        np.concatenate([photo.faces for photo in visibilities]).astype(np.int32),
        _photo_numbers([photo.faces for photo in visibilities]),
        m,
        count,
    )
    quality = np.concatenate([photo.quality for photo in visibilities])[order]
    is_clearly_visible = np.concatenate([photo.is_clearly_visible for photo in visibilities])[order]
    quality = quality * np.clip(sharpness[face_entries.views] / _MIN_SHARPNESS, 0.3, 1.0)
    is_doubtful = _has_flagged_corner(is_occluded, vertex_entries, face_entries, faces, count)
    view_counts = np.bincount(
        face_entries.owner[is_clearly_visible & ~is_doubtful], minlength=m
    ).astype(np.int32)
    quality = np.where(is_clearly_visible, quality, _POOR_QUALITY_FACTOR * quality)
    quality = np.where(is_doubtful, _POOR_QUALITY_FACTOR**2 * quality, quality).astype(np.float32)
    progress.stage(tr("Selecting a photo for each triangle"))
    neighbour_faces = neighbours(faces)
    smooth_quality(
        face_entries.starts, face_entries.views, quality, neighbour_faces, 6, np.empty_like(quality)
    )
    # Smoothing must not restore excluded entries.
    factors = np.where(
        is_doubtful,
        _POOR_QUALITY_FACTOR**2,
        np.where(is_clearly_visible, 1.0, _POOR_QUALITY_FACTOR),
    )
    quality = (quality * factors).astype(np.float32)
    views = np.full(m, -1, np.int32)
    choose_views(
        face_entries.starts,
        face_entries.views,
        quality,
        neighbour_faces,
        _EQUAL_VIEW_GAIN,
        40,
        views,
    )
    progress.stage(tr("Blending low frequencies"), count)
    offsets = _offsets(
        vertices,
        faces,
        vertex_entries,
        face_entries,
        colors,
        quality,
        is_clearly_visible & ~is_doubtful,
        is_occluded,
        links,
        texel,
        count,
        progress,
    )
    entries = _photos_of_faces(faces, views, vertex_entries, face_entries, quality, offsets, count)
    vertex_colors, is_known_vertex = _vertex_colors(
        faces, views, view_counts, vertex_entries, colors + offsets, links, count
    )
    return Blend(
        views,
        view_counts,
        *entries,
        vertex_colors,
        is_known_vertex,
        gains,
        sharpness,
        np.bincount(vertex_entries.views[is_occluded], minlength=count),
    )


def _photo_numbers(arrays: Sequence[Int32Array]) -> Int32Array:
    return np.repeat(np.arange(len(arrays), dtype=np.int32), [len(array) for array in arrays])


@dataclass(frozen=True, eq=False)
class _Links:
    """Neighbours of vertices; vertex v has the neighbours others[starts[v]:starts[v + 1]]."""

    starts: Int32Array
    others: Int32Array

    @classmethod
    def build(cls, faces: Int32Array, n: int) -> _Links:
        keys = np.unique(edge_keys(faces))
        a, b = (keys >> 32).astype(np.int32), (keys & 0xFFFFFFFF).astype(np.int32)
        start, end = np.r_[a, b], np.r_[b, a]
        order = np.argsort(start, kind="stable")
        starts = np.zeros(n + 1, np.int32)
        np.cumsum(np.bincount(start, minlength=n), out=starts[1:])
        return cls(starts, np.ascontiguousarray(end[order]))

    def smooth_values(
        self, vertex_rows: Int32Array, is_counted: BoolArray, values: Float32Array, rounds: int
    ) -> None:
        """Average the values (n, c) of the vertices `vertex_rows` with their counted neighbours."""
        from vomstudio.photogrammetry.surface._texture_kernels import diffuse

        scratch = np.empty((len(vertex_rows), values.shape[1]), np.float32)
        diffuse(self.starts, self.others, vertex_rows, is_counted, values, scratch, rounds)


def _is_unclipped(colors: Float32Array) -> BoolArray:
    return np.asarray(((colors > 6) & (colors < 248)).all(axis=1))


def _photo_biases(
    entries: _Entries, n: int, count: int, values: Float32Array, is_usable: BoolArray | None
) -> FloatArray:
    """Return the excess (count, c) of each photo's values over others at the same vertices.

    The biases are fitted by least squares to the median differences of all pairs of photos, with a
    mean of about 0 in each connected group.
    """
    step = max(1, n // _MAX_SAMPLED_VERTICES)
    is_sampled = entries.owner % step == 0
    if is_usable is not None:
        is_sampled &= is_usable
    table = np.full((count, n // step + 1, values.shape[1]), np.nan, np.float32)
    table[entries.views[is_sampled], entries.owner[is_sampled] // step] = values[is_sampled]
    is_known = np.isfinite(table[..., 0])
    common_counts = is_known.astype(np.float32) @ is_known.astype(np.float32).T
    normal_matrix, right_side = np.zeros((count, count)), np.zeros((count, values.shape[1]))
    for i in range(count):
        # Each of hundreds of photos sees a small part.
        known_vertices = np.flatnonzero(is_known[i])
        for j in np.flatnonzero(common_counts[i, :i] >= _MIN_COMMON_VERTICES):
            common_vertices = known_vertices[is_known[j, known_vertices]]
            differences = np.median(table[i, common_vertices] - table[j, common_vertices], axis=0)
            weight = float(common_counts[i, j])
            normal_matrix[i, i] += weight
            normal_matrix[j, j] += weight
            normal_matrix[i, j] -= weight
            normal_matrix[j, i] -= weight
            right_side[i] += weight * differences
            right_side[j] -= weight * differences
    normal_matrix += np.eye(count) * max(1e-4 * np.trace(normal_matrix) / count, 1e-9)
    return np.asarray(np.linalg.solve(normal_matrix, right_side), np.float64)


def _find_occluded(
    entries: _Entries, colors: Float32Array, links: _Links, count: int, progress: Progress
) -> BoolArray:
    """Return which entries (e,) differ from the consensus of the photos of their vertex."""
    from vomstudio.photogrammetry.surface._texture_kernels import median_distances

    n = len(entries.starts) - 1
    smoothed_colors = colors.copy()
    for view in range(count):
        progress.step(view)
        _smooth_view(entries, view, smoothed_colors, links, 3)
    distances = np.zeros(len(colors), np.float32)
    deviations = np.zeros(len(colors), np.float32)
    max_entries = int(np.diff(entries.starts).max(initial=0))
    values = np.empty(max_entries, np.float32)
    median_distances(entries.starts, smoothed_colors, distances, deviations, values)
    # Estimate the usual differences of photos by misregistration and light.
    median = float(np.median(distances[distances > 0])) if (distances > 0).any() else 0.0
    is_occluded = np.asarray(
        distances > np.maximum(max(_MIN_OCCLUDER_DIFFERENCE, 6.0 * median), 2.5 * deviations)
    )
    for view in range(count):
        view_rows = entries.rows_of_view(view)
        if not is_occluded[view_rows].any():
            continue
        owner = entries.owner[view_rows]
        flags = np.zeros((n, 1), np.float32)
        flags[owner, 0] = is_occluded[view_rows]
        is_visible = np.zeros(n, bool)
        is_visible[owner] = True
        # A single vertex is noise; an occluder has an edge that is mixed with the rock.
        links.smooth_values(owner, is_visible, flags, 1)
        flags[flags < 0.4] = 0
        links.smooth_values(owner, is_visible, flags, _OCCLUDER_MARGIN_RINGS)
        is_occluded[view_rows] = flags[owner, 0] > 0.01
    return is_occluded


def _smooth_view(
    entries: _Entries, view: int, values: Float32Array, links: _Links, rounds: int
) -> None:
    """Smooth the values of one view's entries over its visible vertices."""
    n = len(entries.starts) - 1
    view_rows = entries.rows_of_view(view)
    owner = entries.owner[view_rows]
    dense = np.zeros((n, values.shape[1]), np.float32)
    is_visible = np.zeros(n, bool)
    is_visible[owner] = True
    dense[owner] = values[view_rows]
    links.smooth_values(owner, is_visible, dense, rounds)
    values[view_rows] = dense[owner]


def _corner_rows(
    vertex_entries: _Entries, faces: Int32Array, face: Int32Array, view: Int32Array, count: int
) -> IntArray:
    """Return the entries (e, 3) of the corners of faces in views."""
    keys = faces[face].astype(np.int64) * count + view[:, None]
    return vertex_entries.find(keys)


def _has_flagged_corner(
    is_flagged: BoolArray,
    vertex_entries: _Entries,
    face_entries: _Entries,
    faces: Int32Array,
    count: int,
) -> BoolArray:
    """Return which entries of faces have a flagged corner in their view."""
    rows = _corner_rows(vertex_entries, faces, face_entries.owner, face_entries.views, count)
    return np.asarray((is_flagged[rows] & (rows >= 0)).any(axis=1))


def _offsets(
    vertices: FloatArray,
    faces: Int32Array,
    entries: _Entries,
    face_entries: _Entries,
    colors: Float32Array,
    quality: Float32Array,
    is_clearly_visible: BoolArray,
    is_occluded: BoolArray,
    links: _Links,
    texel: float,
    count: int,
    progress: Progress,
) -> Float32Array:
    """Return the low band of all photos minus that of the entry's photo (e, 3).

    Occluded and poorly visible entries use the values of their neighbours.
    """
    n = len(entries.starts) - 1
    edges = vertices[faces] - vertices[np.roll(faces, -1, axis=1)]
    median_edge = float(np.median(np.linalg.norm(edges[:: max(1, len(edges) // 20_000)], axis=2)))
    rounds = int(
        np.clip((_LOW_BAND_WIDTH_TEXELS * texel / max(median_edge, 1e-12)) ** 2, 2, _MAX_ROUNDS)
    )
    quality_sums = np.zeros(len(entries.owner), np.float32)
    is_reliable = np.zeros(len(entries.owner), bool)
    corner_rows = _corner_rows(entries, faces, face_entries.owner, face_entries.views, count)
    for k in range(3):
        quality_sums += np.bincount(corner_rows[:, k], quality, minlength=len(quality_sums)).astype(
            np.float32
        )
        is_reliable[corner_rows[is_clearly_visible, k]] = True
    is_reliable &= ~is_occluded
    weights = np.zeros(len(colors), np.float32)
    is_counted = np.ones(n, bool)
    for view in range(count):
        progress.step(view)
        view_rows = entries.rows_of_view(view)
        # Fade a photo out towards the border of its well visible part, to avoid a step.
        view_rows = view_rows[is_reliable[view_rows]]
        owner = entries.owner[view_rows]
        fade = np.zeros((n, 1), np.float32)
        fade[owner, 0] = 1.0
        links.smooth_values(owner, is_counted, fade, min(rounds, 30))
        weights[view_rows] = quality_sums[view_rows] * np.maximum(fade[owner, 0], 1e-4)
    weights = np.maximum(weights, np.where(is_occluded, 1e-12, 1e-9)).astype(np.float32)
    mean = np.empty((n, 3), np.float32)
    weight_sums = np.maximum(np.bincount(entries.owner, weights, minlength=n), 1e-30)
    for c in range(3):
        mean[:, c] = np.bincount(entries.owner, weights * colors[:, c], minlength=n) / weight_sums
    # Smooth the difference: photos of different sides of a step agree on either side.
    offsets = (mean[entries.owner] - colors).astype(np.float32)
    for view in range(count):
        progress.step(view)
        view_rows = entries.rows_of_view(view)
        owner = entries.owner[view_rows]
        is_visible = np.zeros(n, bool)
        is_visible[owner] = True
        dense = np.zeros((n, 4), np.float32)
        dense[owner, :3] = offsets[view_rows] * is_reliable[view_rows, None]
        dense[owner, 3] = is_reliable[view_rows]
        links.smooth_values(owner, is_visible, dense, rounds)
        offsets[view_rows] = dense[owner, :3] / np.maximum(dense[owner, 3:], 1e-3)
    return offsets


def _photos_of_faces(
    faces: Int32Array,
    views: Int32Array,
    entries: _Entries,
    face_entries: _Entries,
    quality: Float32Array,
    offsets: Float32Array,
    count: int,
) -> tuple[Int32Array, Int32Array, Float32Array, Float32Array]:
    """Return the photos of faces: both photos along a seam, each fading over adjacent faces."""
    known_faces = np.flatnonzero(views >= 0)
    keys = (faces[known_faces].astype(np.int64) * count + views[known_faces, None]).ravel()
    pairs, corner_counts = np.unique(keys, return_counts=True)
    starts = np.searchsorted(pairs, np.arange(len(entries.starts), dtype=np.int64) * count)
    # Each face uses the photos of its three corners.
    face, view = [], []
    for k in range(3):
        v = faces[known_faces, k]
        counts = starts[v + 1] - starts[v]
        index = np.repeat(starts[v], counts) + (
            np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        )
        face.append(np.repeat(known_faces, counts))
        view.append((pairs[index] % count).astype(np.int32))
    face_views = np.unique(np.concatenate(face) * np.int64(count) + np.concatenate(view))
    entry_faces, entry_views = (
        (face_views // count).astype(np.int32),
        (face_views % count).astype(np.int32),
    )
    entry = face_entries.find(face_views)
    # Exclude photos with a much worse view of the face than its own.
    best_entry = face_entries.find(entry_faces.astype(np.int64) * count + views[entry_faces])
    is_useful = (entry >= 0) & (quality[entry] > 0.05 * quality[best_entry])
    entry_faces, entry_views = entry_faces[is_useful], entry_views[is_useful]
    corner = faces[entry_faces].astype(np.int64) * count + entry_views[:, None]
    index = np.minimum(np.searchsorted(pairs, corner), max(len(pairs) - 1, 0))
    weights = np.where(pairs[index] == corner, corner_counts[index], 0).astype(np.float32)
    known_corner_counts = np.bincount(faces[known_faces].ravel(), minlength=len(entries.starts) - 1)
    weights /= np.maximum(known_corner_counts[faces[entry_faces]], 1)
    return entry_faces, entry_views, weights.astype(np.float32), offsets[entries.find(corner)]


def _vertex_colors(
    faces: Int32Array,
    views: Int32Array,
    view_counts: Int32Array,
    entries: _Entries,
    colors: Float32Array,
    links: _Links,
    count: int,
) -> tuple[Float32Array, BoolArray]:
    """Return the vertex colours (n, 3), and whether they are known.

    Colours are taken from the photos of adjacent faces, or otherwise from clearly visible
    neighbours, since colours at the border of the visible surface are mixed with the foreground.
    """
    from vomstudio.photogrammetry.surface._texture_kernels import fill_outward

    n = len(entries.starts) - 1
    drawn_rows = np.flatnonzero(views >= 0)
    drawn_entries = entries.find(
        (faces[drawn_rows].astype(np.int64) * count + views[drawn_rows, None]).ravel()
    )
    owner = faces[drawn_rows].ravel()
    drawn_counts = np.bincount(owner, minlength=n)
    shown_colors = np.zeros((n, 3), np.float32)
    for c in range(3):
        shown_colors[:, c] = np.bincount(owner, colors[drawn_entries, c], minlength=n) / np.maximum(
            drawn_counts, 1
        )
    is_known = drawn_counts > 0
    is_well_known = is_known.copy()
    is_well_known[faces[view_counts == 0]] = False
    filled_colors = shown_colors.copy()
    queue = np.zeros(n, np.int32)
    fill_outward(links.starts, links.others, is_well_known, filled_colors, queue)
    # Parts without a good view use any colour.
    is_known |= is_well_known
    fill_outward(links.starts, links.others, is_known, filled_colors, queue)
    has_all_faces = drawn_counts > 0
    has_all_faces[faces[views < 0]] = False
    return np.where(has_all_faces[:, None], shown_colors, filled_colors), is_known
