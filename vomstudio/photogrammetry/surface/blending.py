"""Blending of all photos to one colouring of a mesh: exposure, occluders, seams.

Two bands (Burt and Adelson 1983), parted on the mesh and not in the photos, where a blur would mix
the rock with what stands before it. The low band is averaged over all photos that agree; the high
one comes from the photo that sees a face best. Both at once: a texel is the best photo's pixel,
times the photo's gain, plus how far the photo lies off the mean of all, smoothed over the surface.
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

# A photo that sees a face only just is drawn only where no other one does.
_POOR = 1e-3
_JOINING = 0.12
# Above this sharpness, relative to the median photo, photos are as good as each other.
_SHARP = 0.88
_SAMPLE = 40_000
_FEWEST_IN_COMMON = 40
# Values of 0..255 by which photos may differ before one is thought to show something else.
_LEAST_DIFFERENCE = 20.0
_RINGS_ABOUT_OCCLUDER = 3
_LOW_BAND_TEXELS = 40.0
_MOST_ROUNDS = 80


@dataclass(frozen=True, eq=False)
class Blend:
    """How m faces and n vertices are coloured from photos numbered as they were given.

    views : (m,) the photo that each face is drawn from, -1 where none sees it
    seen_by : (m,) how many photos see each face well enough
    draws : one row for each photo that has a share in a face: face, view (e,), and at the face's
        corners weights (e, 3) and offsets (e, 3, 3), RGB to be added once the gain is applied
    colors : (n, 3) of the vertices, 0..255; known : (n,) whether from photos
    gains : (k, 3) RGB factors; sharpness : (k,) relative to the median photo
    occluded : (k,) vertices at which each photo was left out, since the others agree on something
        else
    """

    views: Int32Array
    seen_by: Int32Array
    draw_face: Int32Array
    draw_view: Int32Array
    draw_weights: Float32Array
    draw_offsets: Float32Array
    colors: Float32Array
    known: BoolArray
    gains: FloatArray
    sharpness: FloatArray
    occluded: IntArray


@dataclass(frozen=True, eq=False)
class _Rows:
    """Sorted by owner (a vertex or a face), then by view."""

    starts: Int32Array
    owner: Int32Array
    views: Int32Array
    keys: IntArray

    @cached_property
    def by_view(self) -> list[IndexArray]:
        """The rows of each view up to the last one that has any."""
        order = np.argsort(self.views, kind="stable")
        return np.split(order, np.cumsum(np.bincount(self.views))[:-1])

    def of_view(self, view: int) -> IndexArray:
        return self.by_view[view] if view < len(self.by_view) else np.zeros(0, np.intp)

    @classmethod
    def of(
        cls, owner: Int32Array, views: Int32Array, n: int, count: int
    ) -> tuple[_Rows, IndexArray]:
        keys = owner.astype(np.int64) * count + views
        order = np.argsort(keys, kind="stable")
        owner, views = owner[order], views[order]
        starts = np.zeros(n + 1, np.int32)
        np.cumsum(np.bincount(owner, minlength=n), out=starts[1:])
        return cls(starts, owner, views, keys[order]), order

    def find(self, keys: IntArray) -> IntArray:
        """Rows of these keys, -1 where there is none."""
        if not len(self.keys):
            return np.full(keys.shape, -1, np.int64)
        at = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
        return np.where(self.keys[at] == keys, at, -1)


def blend(
    vertices: FloatArray,
    faces: Int32Array,
    visible: Sequence[PhotoVisibility],
    texel: float,
    progress: Progress,
) -> Blend:
    """Decide what each photo contributes. texel : edge of a texel in the unit of the vertices."""
    from vomstudio.photogrammetry.surface._texture_kernels import choose_views, smooth_quality

    count, m, n = len(visible), len(faces), len(vertices)
    at_vertices, order = _Rows.of(
        np.concatenate([photo.vertices for photo in visible]).astype(np.int32),
        _numbered([photo.vertices for photo in visible]),
        n,
        count,
    )
    colors = np.concatenate([photo.colors for photo in visible])[order]
    detail = np.concatenate([photo.detail for photo in visible])[order]
    progress.stage(tr("Balancing exposure"))
    gains = np.exp(-_balance(at_vertices, n, count, np.log(colors + 4.0), _unclipped(colors)))
    gains /= np.exp(np.log(gains).mean(axis=0))
    sharpness = np.exp(_balance(at_vertices, n, count, detail[:, None], None)[:, 0])
    sharpness /= np.median(sharpness)
    colors = np.ascontiguousarray(colors * gains[at_vertices.views], np.float32)
    links = _Links.of(faces, n)
    progress.stage(tr("Detecting occluders"), count)
    occluded = _occluded(at_vertices, colors, links, count, progress)
    at_faces, order = _Rows.of(
        np.concatenate([photo.faces for photo in visible]).astype(np.int32),
        _numbered([photo.faces for photo in visible]),
        m,
        count,
    )
    quality = np.concatenate([photo.quality for photo in visible])[order]
    well = np.concatenate([photo.well for photo in visible])[order]
    quality = quality * np.clip(sharpness[at_faces.views] / _SHARP, 0.3, 1.0)
    doubtful = _faces_at(occluded, at_vertices, at_faces, faces, count)
    seen_by = np.bincount(at_faces.owner[well & ~doubtful], minlength=m).astype(np.int32)
    quality = np.where(well, quality, _POOR * quality)
    quality = np.where(doubtful, _POOR**2 * quality, quality).astype(np.float32)
    progress.stage(tr("Selecting a photo for each triangle"))
    across = neighbours(faces)
    smooth_quality(at_faces.starts, at_faces.views, quality, across, 6, np.empty_like(quality))
    # What is smoothed must not bring back what was ruled out.
    ruled = np.where(doubtful, _POOR**2, np.where(well, 1.0, _POOR))
    quality = (quality * ruled).astype(np.float32)
    views = np.full(m, -1, np.int32)
    choose_views(at_faces.starts, at_faces.views, quality, across, _JOINING, 40, views)
    progress.stage(tr("Blending low frequencies"), count)
    offsets = _offsets(
        vertices,
        faces,
        at_vertices,
        at_faces,
        colors,
        quality,
        well & ~doubtful,
        occluded,
        links,
        texel,
        count,
        progress,
    )
    draws = _draws(faces, views, at_vertices, at_faces, quality, offsets, count)
    shown, known = _vertex_colors(
        faces, views, seen_by, at_vertices, colors + offsets, links, count
    )
    return Blend(
        views,
        seen_by,
        *draws,
        shown,
        known,
        gains,
        sharpness,
        np.bincount(at_vertices.views[occluded], minlength=count),
    )


def _numbered(parts: Sequence[Int32Array]) -> Int32Array:
    return np.repeat(np.arange(len(parts), dtype=np.int32), [len(part) for part in parts])


@dataclass(frozen=True, eq=False)
class _Links:
    """Which vertices are joined by an edge: those of v are others[starts[v]:starts[v + 1]]."""

    starts: Int32Array
    others: Int32Array

    @classmethod
    def of(cls, faces: Int32Array, n: int) -> _Links:
        keys = np.unique(edge_keys(faces))
        a, b = (keys >> 32).astype(np.int32), (keys & 0xFFFFFFFF).astype(np.int32)
        start, end = np.r_[a, b], np.r_[b, a]
        order = np.argsort(start, kind="stable")
        starts = np.zeros(n + 1, np.int32)
        np.cumsum(np.bincount(start, minlength=n), out=starts[1:])
        return cls(starts, np.ascontiguousarray(end[order]))

    def spread(
        self, some: Int32Array, counts: BoolArray, values: Float32Array, rounds: int
    ) -> None:
        """Average the values (n, c) of `some` vertices over those linked to them that count."""
        from vomstudio.photogrammetry.surface._texture_kernels import diffuse

        spare = np.empty((len(some), values.shape[1]), np.float32)
        diffuse(self.starts, self.others, some, counts, values, spare, rounds)


def _unclipped(colors: Float32Array) -> BoolArray:
    return np.asarray(((colors > 6) & (colors < 248)).all(axis=1))


def _balance(
    rows: _Rows, n: int, count: int, values: Float32Array, usable: BoolArray | None
) -> FloatArray:
    """(count, c) by how much each photo's values lie above the others' at the same vertices: least
    squares over the medians of all pairs, with a mean of about 0 in each connected group."""
    step = max(1, n // _SAMPLE)
    chosen = rows.owner % step == 0
    if usable is not None:
        chosen &= usable
    table = np.full((count, n // step + 1, values.shape[1]), np.nan, np.float32)
    table[rows.views[chosen], rows.owner[chosen] // step] = values[chosen]
    there = np.isfinite(table[..., 0])
    common = there.astype(np.float32) @ there.astype(np.float32).T
    normal, right = np.zeros((count, count)), np.zeros((count, values.shape[1]))
    for i in range(count):
        # Of hundreds of photos each sees a small part.
        mine = np.flatnonzero(there[i])
        for j in np.flatnonzero(common[i, :i] >= _FEWEST_IN_COMMON):
            both = mine[there[j, mine]]
            above = np.median(table[i, both] - table[j, both], axis=0)
            weight = float(common[i, j])
            normal[i, i] += weight
            normal[j, j] += weight
            normal[i, j] -= weight
            normal[j, i] -= weight
            right[i] += weight * above
            right[j] -= weight * above
    normal += np.eye(count) * max(1e-4 * np.trace(normal) / count, 1e-9)
    return np.asarray(np.linalg.solve(normal, right), np.float64)


def _occluded(
    rows: _Rows, colors: Float32Array, links: _Links, count: int, progress: Progress
) -> BoolArray:
    """(e,) which entries show an occluder: something else than the other photos of their vertex
    agree on."""
    from vomstudio.photogrammetry.surface._texture_kernels import from_median

    n = len(rows.starts) - 1
    smoothed = colors.copy()
    for view in range(count):
        progress.step(view)
        _on_view(rows, view, smoothed, links, 3)
    distance = np.zeros(len(colors), np.float32)
    spread = np.zeros(len(colors), np.float32)
    from_median(rows.starts, smoothed, distance, spread)
    # Photos of one place differ by misplacement and by the light: learn by how much.
    usual = float(np.median(distance[distance > 0])) if (distance > 0).any() else 0.0
    occluded = np.asarray(distance > np.maximum(max(_LEAST_DIFFERENCE, 6.0 * usual), 2.5 * spread))
    for view in range(count):
        mine = rows.of_view(view)
        if not occluded[mine].any():
            continue
        owner = rows.owner[mine]
        here = np.zeros((n, 1), np.float32)
        here[owner, 0] = occluded[mine]
        there = np.zeros(n, bool)
        there[owner] = True
        # A single vertex is noise; a spot has an edge that is mixed with the rock.
        links.spread(owner, there, here, 1)
        here[here < 0.4] = 0
        links.spread(owner, there, here, _RINGS_ABOUT_OCCLUDER)
        occluded[mine] = here[owner, 0] > 0.01
    return occluded


def _on_view(rows: _Rows, view: int, values: Float32Array, links: _Links, rounds: int) -> None:
    """Smooth the values of one view's entries over the vertices that it sees."""
    n = len(rows.starts) - 1
    mine = rows.of_view(view)
    owner = rows.owner[mine]
    dense = np.zeros((n, values.shape[1]), np.float32)
    seen = np.zeros(n, bool)
    seen[owner] = True
    dense[owner] = values[mine]
    links.spread(owner, seen, dense, rounds)
    values[mine] = dense[owner]


def _corner_rows(
    at_vertices: _Rows, faces: Int32Array, face: Int32Array, view: Int32Array, count: int
) -> IntArray:
    """(e, 3) entries of the corners of faces in views."""
    keys = faces[face].astype(np.int64) * count + view[:, None]
    return at_vertices.find(keys)


def _faces_at(
    flags: BoolArray, at_vertices: _Rows, at_faces: _Rows, faces: Int32Array, count: int
) -> BoolArray:
    """Which entries of faces have a flagged corner in their view."""
    rows = _corner_rows(at_vertices, faces, at_faces.owner, at_faces.views, count)
    return np.asarray((flags[rows] & (rows >= 0)).any(axis=1))


def _offsets(
    vertices: FloatArray,
    faces: Int32Array,
    rows: _Rows,
    at_faces: _Rows,
    colors: Float32Array,
    quality: Float32Array,
    well: BoolArray,
    occluded: BoolArray,
    links: _Links,
    texel: float,
    count: int,
    progress: Progress,
) -> Float32Array:
    """(e, 3) low band of all photos less that of the entry's own; what is occluded or hardly seen
    in a photo takes what is found beside it."""
    n = len(rows.starts) - 1
    edges = vertices[faces] - vertices[np.roll(faces, -1, axis=1)]
    edge = float(np.median(np.linalg.norm(edges[:: max(1, len(edges) // 20_000)], axis=2)))
    rounds = int(np.clip((_LOW_BAND_TEXELS * texel / max(edge, 1e-12)) ** 2, 2, _MOST_ROUNDS))
    total = np.zeros(len(rows.owner), np.float32)
    sound = np.zeros(len(rows.owner), bool)
    corner = _corner_rows(rows, faces, at_faces.owner, at_faces.views, count)
    for k in range(3):
        total += np.bincount(corner[:, k], quality, minlength=len(total)).astype(np.float32)
        sound[corner[well, k]] = True
    sound &= ~occluded
    weight = np.zeros(len(colors), np.float32)
    everywhere = np.ones(n, bool)
    for view in range(count):
        progress.step(view)
        mine = rows.of_view(view)
        # Towards the end of what a photo sees well it fades out, so that no step is left there.
        mine = mine[sound[mine]]
        owner = rows.owner[mine]
        ramp = np.zeros((n, 1), np.float32)
        ramp[owner, 0] = 1.0
        links.spread(owner, everywhere, ramp, min(rounds, 30))
        weight[mine] = total[mine] * np.maximum(ramp[owner, 0], 1e-4)
    weight = np.maximum(weight, np.where(occluded, 1e-12, 1e-9)).astype(np.float32)
    mean = np.empty((n, 3), np.float32)
    sums = np.maximum(np.bincount(rows.owner, weight, minlength=n), 1e-30)
    for c in range(3):
        mean[:, c] = np.bincount(rows.owner, weight * colors[:, c], minlength=n) / sums
    # Smoothed is the difference: photos that see different parts of a step agree on either side.
    offsets = (mean[rows.owner] - colors).astype(np.float32)
    for view in range(count):
        progress.step(view)
        mine = rows.of_view(view)
        owner = rows.owner[mine]
        seen = np.zeros(n, bool)
        seen[owner] = True
        dense = np.zeros((n, 4), np.float32)
        dense[owner, :3] = offsets[mine] * sound[mine, None]
        dense[owner, 3] = sound[mine]
        links.spread(owner, seen, dense, rounds)
        offsets[mine] = dense[owner, :3] / np.maximum(dense[owner, 3:], 1e-3)
    return offsets


def _draws(
    faces: Int32Array,
    views: Int32Array,
    rows: _Rows,
    at_faces: _Rows,
    quality: Float32Array,
    offsets: Float32Array,
    count: int,
) -> tuple[Int32Array, Int32Array, Float32Array, Float32Array]:
    """Along a seam both photos are drawn, each fading over the faces that touch it."""
    known = np.flatnonzero(views >= 0)
    keys = (faces[known].astype(np.int64) * count + views[known, None]).ravel()
    pairs, shares = np.unique(keys, return_counts=True)
    starts = np.searchsorted(pairs, np.arange(len(rows.starts), dtype=np.int64) * count)
    # Each face takes the photos of its three corners.
    face, view = [], []
    for k in range(3):
        v = faces[known, k]
        many = starts[v + 1] - starts[v]
        at = np.repeat(starts[v], many) + (
            np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
        )
        face.append(np.repeat(known, many))
        view.append((pairs[at] % count).astype(np.int32))
    both = np.unique(np.concatenate(face) * np.int64(count) + np.concatenate(view))
    draw_face, draw_view = (both // count).astype(np.int32), (both % count).astype(np.int32)
    entry = at_faces.find(both)
    # A photo that does not see the face as well as its own cannot help it out.
    own = at_faces.find(draw_face.astype(np.int64) * count + views[draw_face])
    fit = (entry >= 0) & (quality[entry] > 0.05 * quality[own])
    draw_face, draw_view = draw_face[fit], draw_view[fit]
    corner = faces[draw_face].astype(np.int64) * count + draw_view[:, None]
    at = np.minimum(np.searchsorted(pairs, corner), max(len(pairs) - 1, 0))
    weights = np.where(pairs[at] == corner, shares[at], 0).astype(np.float32)
    whole = np.bincount(faces[known].ravel(), minlength=len(rows.starts) - 1)
    weights /= np.maximum(whole[faces[draw_face]], 1)
    return draw_face, draw_view, weights.astype(np.float32), offsets[rows.find(corner)]


def _vertex_colors(
    faces: Int32Array,
    views: Int32Array,
    seen_by: Int32Array,
    rows: _Rows,
    colors: Float32Array,
    links: _Links,
    count: int,
) -> tuple[Float32Array, BoolArray]:
    """Of the photos that the faces about a vertex are drawn from; where none is, of the vertices
    beside it that are seen well: at the border of what is seen, colours are mixed with what stands
    before it."""
    from vomstudio.photogrammetry.surface._texture_kernels import fill_outward

    n = len(rows.starts) - 1
    drawn = np.flatnonzero(views >= 0)
    at = rows.find((faces[drawn].astype(np.int64) * count + views[drawn, None]).ravel())
    owner = faces[drawn].ravel()
    total = np.bincount(owner, minlength=n)
    shown = np.zeros((n, 3), np.float32)
    for c in range(3):
        shown[:, c] = np.bincount(owner, colors[at, c], minlength=n) / np.maximum(total, 1)
    known = total > 0
    sure = known.copy()
    sure[faces[seen_by == 0]] = False
    filled = shown.copy()
    spare = np.zeros(n, np.int32)
    fill_outward(links.starts, links.others, sure, filled, spare)
    # A part that is nowhere seen well takes what there is.
    known |= sure
    fill_outward(links.starts, links.others, known, filled, spare)
    own = total > 0
    own[faces[views < 0]] = False
    return np.where(own[:, None], shown, filled), known
