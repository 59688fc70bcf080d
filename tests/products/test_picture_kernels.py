"""Compiled parts of pictures, against what their descriptions say, a pixel at a time."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from vomstudio.products.ortho._mesh_kernels import bin_faces, blend_corners, find_edges
from vomstudio.products.ortho._splat_kernels import bin_points, splat
from vomstudio.products.ortho._texture_kernels import sample_texture

# Textures


def noisy_pyramid(width: int, height: int, seed: int) -> list[np.ndarray]:
    """Levels that have nothing to do with each other, so that no other one passes for one."""
    rng = np.random.default_rng(seed)
    levels = []
    while True:
        levels.append(rng.integers(0, 256, (height, width, 3), np.uint8))
        if (width, height) == (1, 1):
            return levels
        width, height = -(-width // 2), -(-height // 2)


def sampled(levels: list[np.ndarray], *rest: object) -> np.ndarray:
    sizes = np.array([[m.shape[1], m.shape[0]] for m in levels], np.int64)
    starts = np.cumsum([0, *(m.size for m in levels)])[:-1].astype(np.int64)
    texels = np.concatenate([m.ravel() for m in levels])
    height, width = levels[0].shape[:2]
    rows, face, weights, view, faces, uv, gsd = rest
    rgb = np.zeros((len(face), 3), np.uint8)  # type: ignore[arg-type]
    sample_texture(
        texels,
        starts,
        sizes,
        float(width),
        float(height),
        rows,
        face,
        weights,
        view,
        faces,
        uv,
        gsd,
        rgb,
    )
    return rgb


def texture_plainly(
    levels: list[np.ndarray], corners: np.ndarray, uv: np.ndarray, weights: np.ndarray, gsd: float
) -> np.ndarray:
    """The footprint from a singular value decomposition, the texels from scipy's interpolation."""
    height, width = levels[0].shape[:2]
    at = np.column_stack([uv[:, 0] * width, (1.0 - uv[:, 1]) * height])
    place = at[0] + weights[0] * (at[1] - at[0]) + weights[1] * (at[2] - at[0])
    sides = (corners[1:, :2] - corners[0, :2]).T
    long = short = 0.0
    way = np.zeros(2)
    if abs(np.linalg.det(sides)) > 1e-9 * np.linalg.norm(sides, axis=0).prod():
        u, (long, short), _ = np.linalg.svd((at[1:] - at[0]).T @ np.linalg.inv(sides) * gsd)
        way = u[:, 0]
    n = max(1, min(16, math.ceil(long / max(short, 1.0))))
    level = min(math.log2(max(short, long / n, 1.0)), len(levels) - 1.0)
    fine = int(level)
    slack = 2.0 / np.array([width, height])
    repeat = ((uv < -slack) | (uv > 1.0 + slack)).any()
    total = np.zeros(3)
    for i in range(n):
        x, y = place + ((i + 0.5) / n - 0.5) * long * way
        if repeat:
            x, y = x % width, y % height
        for step, share in ((0, 1.0 - (level - fine)), (1, level - fine)):
            if share:
                texels = levels[fine + step].astype(float)
                where = [[y / 2.0 ** (fine + step) - 0.5], [x / 2.0 ** (fine + step) - 0.5]]
                total += (
                    share
                    / n
                    * np.array(
                        [
                            map_coordinates(texels[..., c], where, order=1, mode="nearest")[0]
                            for c in range(3)
                        ]
                    )
                )
    return np.asarray(np.floor(np.clip(total + 0.5, 0, 255)))


@pytest.mark.parametrize("beyond", [0.0, 1.7])
@pytest.mark.parametrize("gsd", [0.001, 0.01, 0.04, 0.3, 3.0])
def test_a_pixel_is_the_mean_of_the_texels_under_it(gsd: float, beyond: float) -> None:
    """Magnified, minified and stretched; within the picture and over its edges."""
    rng = np.random.default_rng(int(1000 * gsd))
    levels = noisy_pyramid(40, 23, 1)
    count = 60
    view = rng.uniform(-1.0, 1.0, (3 * count, 3))
    view[::2, 1] *= 0.05  # steep ones
    faces = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    uv = rng.uniform(-beyond, 1.0 + beyond, (3 * count, 2)).astype(np.float32)
    face = rng.permutation(count).astype(np.int32)
    weights = rng.dirichlet(np.ones(3), count)[:, 1:].copy()
    rows = np.sort(rng.permutation(count)[:50])
    result = sampled(levels, rows, face, weights, view, faces, uv, gsd)
    assert not result[np.setdiff1d(np.arange(count), rows)].any()
    for k in rows:
        f = faces[face[k]]
        expected = texture_plainly(levels, view[f], uv[f].astype(float), weights[k], gsd)
        assert np.abs(result[k].astype(float) - expected).max() <= 1.0, k


def test_a_face_seen_edge_on_takes_the_texel_under_the_ray() -> None:
    levels = noisy_pyramid(16, 16, 2)
    view = np.array([[0.0, 0, 0], [1, 0, 1], [2, 0, -1]])
    faces = np.array([[0, 1, 2]], np.int32)
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    weights = np.array([[0.25, 0.5]])
    rows, face = np.array([0]), np.array([0], np.int32)
    result = sampled(levels, rows, face, weights, view, faces, uv, 0.1)
    expected = texture_plainly(levels, view, uv.astype(float), weights[0], 0.1)
    assert np.abs(result[0] - expected).max() <= 1.0


@pytest.mark.parametrize(("off", "repeats"), [(1.9, False), (2.1, True)])
def test_texture_coordinates_slightly_outside_the_picture_are_clamped(
    off: float, repeats: bool
) -> None:
    """Up to two texels the edge goes on; from there on the picture begins anew."""
    width, height = 20, 10
    image = np.zeros((height, width, 3), np.uint8)
    image[:, 0], image[:, -1], image[0], image[-1] = 50, 100, 150, 200
    for axis, sign, edge, other in (
        (0, 1, 100, 50),
        (0, -1, 50, 100),
        (1, 1, 150, 200),
        (1, -1, 200, 150),
    ):
        size = (width, height)[axis]
        middle = np.full((3, 2), 0.5)
        middle[:, axis] = (1.0 + off / size) if sign > 0 else -off / size
        uv = (middle + [[0, 0], [1e-3, 0], [0, 1e-3]]).astype(np.float32)
        uv[:, axis] = middle[:, axis]
        view = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        rgb = sampled(
            [image],
            np.array([0]),
            np.array([0], np.int32),
            np.zeros((1, 2)),
            view,
            np.array([[0, 1, 2]], np.int32),
            uv,
            0.1,
        )
        if not repeats:
            assert rgb[0, 0] == edge
        else:
            assert rgb[0, 0] < max(edge, other)
            assert rgb[0, 0] != edge


def test_colours_between_corners_are_their_weighted_mean() -> None:
    rng = np.random.default_rng(3)
    colors = rng.integers(0, 256, (30, 3), np.uint8)
    faces = rng.permutation(30).astype(np.int32).reshape(-1, 3)
    face = rng.integers(0, 10, 80).astype(np.int32)
    weights = rng.dirichlet(np.ones(3), 80)[:, 1:].copy()
    rgb = np.zeros((80, 3), np.uint8)
    rows = np.arange(5, 80)
    blend_corners(rows, face, weights, faces, colors, rgb)
    own = np.column_stack([1.0 - weights.sum(axis=1), weights])
    expected = np.einsum("ki,kic->kc", own, colors[faces[face]].astype(float))
    assert np.abs(rgb[5:] - expected[5:]).max() <= 0.5 + 1e-9
    assert not rgb[:5].any()


# Tiles


@pytest.mark.parametrize("margin", [0.0, 0.35])
def test_tile_gets_exactly_the_faces_that_may_be_visible_in_it(margin: float) -> None:
    """All whose box, grown by the margin, touches it; no more, or a large model would be slow."""
    rng = np.random.default_rng(4)
    left, top, side, columns, rows = -2.0, -1.0, 0.8, 5, 4
    view = rng.uniform(-4.0, 4.0, (90, 3))
    faces = rng.permutation(90).astype(np.int32).reshape(-1, 3)
    view[faces[::2]] = view[faces[::2, :1]] + 0.2 * (view[faces[::2]] - view[faces[::2, :1]])
    reach = rng.uniform(0.0, 0.6, 90)

    def lists(binned: object, what: tuple[object, ...]) -> list[list[int]]:
        starts = np.zeros(columns * rows + 1, np.int64)
        where = (*what, left, top, side, margin, columns, rows)
        binned(*where, starts, np.empty(0, np.int32))  # type: ignore[operator]
        starts = np.cumsum(starts)
        members = np.full(starts[-1], -1, np.int32)
        binned(*where, starts[:-1].copy(), members)  # type: ignore[operator]
        return [members[a:b].tolist() for a, b in pairwise(starts)]

    by_face, by_point = lists(bin_faces, (view, faces)), lists(bin_points, (view, reach))
    corners = view[faces]
    for (low, high), result in (
        ((corners.min(axis=1), corners.max(axis=1)), by_face),
        ((view - reach[:, None], view + reach[:, None]), by_point),
    ):
        for t in range(columns * rows):
            x, y = left + (t % columns) * side, top + (t // columns) * side
            meets = (low[:, 0] - margin < x + side) & (high[:, 0] + margin >= x)
            meets &= (low[:, 1] - margin < y + side) & (high[:, 1] + margin >= y)
            assert result[t] == np.flatnonzero(meets).tolist()


# Points


@pytest.mark.parametrize("gsd", [0.05, 0.2])
def test_a_pixel_of_a_cloud_is_the_mean_of_the_nearest_discs(gsd: float) -> None:
    rng = np.random.default_rng(5)
    view = rng.uniform(-1.0, 1.0, (150, 3)) * [1.2, 1.2, 0.6]
    reach = rng.uniform(0.05, 0.3, 150)
    colors = rng.integers(0, 256, (150, 3), np.uint8)
    selection = rng.permutation(150)[:120].astype(np.int32)
    left, top, h, w = -0.9, -0.8, 30, 34
    nearest = np.full((h, w), np.inf, np.float32)
    color, weight = np.zeros((h, w, 3), np.float32), np.zeros((h, w), np.float32)
    depth = np.zeros((h, w))
    limit = np.zeros((h, w), np.float32)
    splat(selection, view, reach, colors, left, top, gsd, nearest, limit, color, weight, depth)
    # How steep: the smaller difference to both sides, none at the border; at most twelvefold.
    with np.errstate(invalid="ignore"):
        steps = [np.abs(np.diff(nearest.astype(float), axis=axis)) for axis in (0, 1)]
    down, across = np.zeros((h, w)), np.zeros((h, w))
    down[1:-1] = np.fmin(steps[0][:-1], steps[0][1:])
    across[:, 1:-1] = np.fmin(steps[1][:, :-1], steps[1][:, 1:])
    steep = np.minimum(np.hypot(across, down) / gsd, 12.0)
    some = 0
    for j in range(h):
        for i in range(w):
            x, y = left + (i + 0.5) * gsd, top + (j + 0.5) * gsd
            own, size = view[selection], reach[selection]
            k = 1.0 - ((own[:, 0] - x) ** 2 + (own[:, 1] - y) ** 2) / size**2
            on = k > 0.0
            if not on.any():
                assert weight[j, i] == 0.0
                assert nearest[j, i] == np.inf
                continue
            some += 1
            front = own[on, 2].min()
            assert nearest[j, i] == pytest.approx(front)
            within = max(3.0, 2.0 * steep[j, i])
            assert limit[j, i] == pytest.approx(within, rel=1e-4)
            on &= own[:, 2] - float(limit[j, i]) * size <= nearest[j, i]
            share = k[on] ** 2
            assert weight[j, i] == pytest.approx(share.sum(), rel=1e-5)
            assert depth[j, i] == pytest.approx((share * own[on, 2]).sum(), rel=1e-5, abs=1e-6)
            expected = share @ colors[selection][on].astype(float)
            assert color[j, i] == pytest.approx(expected, rel=1e-5)
    assert some > 100


# Edges


def test_edge_pixels_are_depth_jumps_off_the_planes_of_both_sides() -> None:
    rng = np.random.default_rng(6)
    gsd, h, w = 0.1, 25, 30
    view = rng.uniform(-1.0, 1.0, (24, 3)) * [1.0, 1.0, 3.0]
    faces = np.arange(24, dtype=np.int32).reshape(-1, 3)
    view[faces[7]] = [[0, 0, 0], [0.01, 1, 0.5], [0.011, 2, 3.0]]  # almost edge-on
    face = rng.integers(-1, 8, (h, w)).astype(np.int32)
    depth = np.where(face >= 0, 0.4 * rng.standard_normal((h, w)), np.inf)
    result = np.zeros((h, w), bool)
    find_edges(view, faces, face, depth, gsd, result)

    def slope(f: int, axis: int) -> float:
        a, b, c = view[faces[f]]
        n = np.cross(b - a, c - a)
        return float(-n[axis] / n[2])

    expected = np.zeros((h, w), bool)
    for j in range(h):
        for i in range(w):
            for axis, (j2, i2) in enumerate(((j, i + 1), (j + 1, i))):
                if j2 >= h or i2 >= w or face[j, i] == face[j2, i2]:
                    continue
                f, g = int(face[j, i]), int(face[j2, i2])
                if f >= 0 and g >= 0:
                    step = depth[j2, i2] - depth[j, i]
                    slopes = [s for s in (slope(f, axis), slope(g, axis)) if abs(s) < 20.0]
                    off = min(abs(step - s * gsd) for s in (0.0, *slopes))
                    if off <= 3.0 * gsd:
                        continue
                expected[j, i] = expected[j2, i2] = True
    assert np.array_equal(result, expected)
    assert 50 < result.sum() < result.size - 20


def test_neither_a_slope_nor_the_border_between_coplanar_faces_is_an_edge() -> None:
    """Two triangles of one steep plane, the first with number 0."""
    view = np.array([[0, 0, 0], [4, 0, 16.0], [0, 4, 8.0], [4, 4, 24.0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
    i, j = np.meshgrid(np.arange(4) + 0.5, np.arange(4) + 0.5)
    depth = 4.0 * i + 2.0 * j
    face = (i + j > 4.0).astype(np.int32)
    result = np.zeros((4, 4), bool)
    find_edges(view, faces, face, depth, 1.0, result)
    assert not result.any()
    face[3, 3] = -1
    find_edges(view, faces, face, depth, 1.0, result)
    assert np.argwhere(result).tolist() == [[2, 3], [3, 2], [3, 3]]


def test_pixels_of_a_face_do_not_depend_on_earlier_faces() -> None:
    """Faces with textures at different scales, met in any order, look the same one by one."""
    rng = np.random.default_rng(11)
    levels = [rng.integers(0, 255, (size, size, 3)).astype(np.uint8) for size in (64, 32, 16, 8)]
    view = rng.uniform(0, 4, (30, 3))
    uv = rng.uniform(0, 1, (30, 2)).astype(np.float32)
    faces = np.arange(30, dtype=np.int32).reshape(10, 3)
    face = rng.integers(0, 10, 200).astype(np.int32)
    weights = np.ascontiguousarray(rng.dirichlet([1, 1, 1], 200)[:, :2])
    texels = np.concatenate([level.reshape(-1) for level in levels])
    offsets = np.concatenate([[0], np.cumsum([level.size for level in levels])[:-1]])
    sizes = np.array([[level.shape[1], level.shape[0]] for level in levels])

    def draw(rows: np.ndarray) -> np.ndarray:
        rgb = np.zeros((200, 3), np.uint8)
        sample_texture(
            texels, offsets, sizes, 64.0, 64.0, rows, face, weights, view, faces, uv, 0.05, rgb
        )
        return rgb

    together = draw(np.arange(200))
    alone = np.zeros_like(together)
    for k in range(200):
        alone[k] = draw(np.array([k]))[k]
    assert (together == alone).all()
    assert (together == draw(np.argsort(face, kind="stable"))).all()
