"""Nodes of large clouds: which a view needs, and that what is there answers like the whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from vomstudio.geometry.brush import CloudSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.progressive_order import arrange
from vomstudio.geometry.streaming.octree import (
    MAX_SPACING_PIXELS,
    ArrangedNodes,
    CloudNodes,
    CloudView,
    NodeStore,
    StreamedCloud,
    parent_rows,
    split_cloud,
)
from vomstudio.geometry.streaming.surfaces import StreamedSurface

UTM = np.array([576_704.0, 5_188_102.0, 184.0])
EAST, NORTH, UP = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def cubes(levels: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Keys (level, x, y, z) and boxes of a full octree's nodes over a unit cube's diagonal."""
    keys = []
    for level in range(levels):
        n = 2**level
        keys += [
            (level, x, y, z)
            for x in range(n)
            for y in range(n)
            for z in range(n)
            if abs(x - y) <= 1 and abs(y - z) <= 1
        ]
    key = np.array(keys)
    side = 0.5 ** key[:, :1]
    return key, np.stack([key[:, 1:] * side, (key[:, 1:] + 1) * side], axis=1)


def tree(budget: int = 10**9) -> CloudNodes:
    key, boxes = cubes()
    spacing = 0.05 * 0.5 ** key[:, 0]
    counts = np.arange(100, 100 + len(key))
    return CloudNodes(10.0 * boxes, 10.0 * spacing, counts, parent_rows(key), budget, (0,))


def test_parent_node_encloses_its_children() -> None:
    key, boxes = cubes()
    above = parent_rows(key)
    assert above[0] == -1
    assert (above[1:] >= 0).all()
    middle = boxes.mean(axis=1)[1:]
    around = boxes[above[1:]]
    assert ((middle > around[:, 0]) & (middle < around[:, 1])).all()
    assert np.array_equal(key[above[1:], 0], key[1:, 0] - 1)
    # A node whose parent is missing has none.
    assert parent_rows(np.array([[3, 5, 2, 7], [1, 1, 0, 1]])).tolist() == [-1, -1]


def view(position: np.ndarray, *, orthographic: bool = False, **more: object) -> CloudView:
    """A look to the north."""
    given = CloudView(tuple(position), (EAST, UP, NORTH), 0.4, 1.6, orthographic, 0.1, 900)
    return replace(given, **more)


def needed(nodes: CloudNodes, seen: CloudView) -> np.ndarray:
    """By the definition, a node at a time: points of its box in the picture, and neighbours of the
    node above too far apart on the screen at the box's nearest point."""
    position, axes = np.array(seen.position), np.array(seen.axes)
    rows = []
    steps = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3), axis=-1).reshape(-1, 3)
    for row, (low, high) in enumerate(nodes.bounds):
        q = (low + steps * (high - low) - position) @ axes.T
        tall = seen.half_height * (1.0 if seen.is_orthographic else q[:, 2])
        inside = (q[:, 2] > 0) & (np.abs(q[:, 1]) <= tall)
        inside &= np.abs(q[:, 0]) <= tall * seen.aspect
        off = np.maximum(np.maximum(low - position, position - high), 0.0)
        reach = 1.0 if seen.is_orthographic else max(float(np.linalg.norm(off)), seen.near)
        apart = nodes.spacing[row] * 2.0 / (2.0 * seen.half_height * reach / seen.pixels)
        if inside.any() and (apart > MAX_SPACING_PIXELS or nodes.parents[row] < 0):
            rows.append(row)
    return np.array(rows)


VIEWS = [
    view(np.array([5.0, -4.0, 5.0])),
    view(np.array([3.0, 2.0, 4.0]), half_height=0.2),
    view(np.array([5.0, -300.0, 5.0])),
    view(np.array([4.0, -2.0, 6.0]), orthographic=True, half_height=1.5),
    view(np.array([5.0, 2.0, 5.0]), axes=(NORTH, UP, (-1.0, 0.0, 0.0)), aspect=0.5),
]


@pytest.mark.parametrize("seen", VIEWS)
def test_selection_contains_every_visible_node_and_few_others(seen: CloudView) -> None:
    nodes = tree()
    chosen = nodes.select_nodes(seen, 10**9)
    wanted = needed(nodes, seen)
    assert set(wanted) <= set(chosen.tolist())
    # A ball is held for its cube: it reaches out by a part of the node's size.
    grown = replace(
        seen,
        position=tuple(np.array(seen.position) - 3.0 * np.array(seen.axes[2])),
        half_height=2.0 * seen.half_height + (3.0 if seen.is_orthographic else 0.0),
    )
    position, axes = np.array(grown.position), np.array(grown.axes)
    for row in set(chosen.tolist()) - set(wanted):
        low, high = nodes.bounds[row]
        radius = np.linalg.norm(high - low) / 2
        q = ((low + high) / 2 - position) @ axes.T
        assert q[2] > -radius
        tall = grown.half_height * (1.0 if seen.is_orthographic else q[2])
        assert abs(q[1]) <= tall + 2 * radius
        assert abs(q[0]) <= tall * seen.aspect + 3 * radius


def test_nodes_out_of_view_are_not_selected_and_far_view_selects_only_root() -> None:
    nodes = tree()
    assert nodes.select_nodes(view(np.array([5.0, 40.0, 5.0])), 10**9).tolist() == []
    assert nodes.select_nodes(view(np.array([90.0, -4.0, 5.0])), 10**9).tolist() == []
    assert nodes.select_nodes(view(np.array([5.0, -4.0, 60.0])), 10**9).tolist() == []
    far = nodes.select_nodes(view(np.array([5.0, -9000.0, 5.0])), 10**9)
    assert far.tolist() == [0]


def test_nodes_are_sorted_by_need_and_limited_by_budget() -> None:
    nodes, seen = tree(), VIEWS[0]
    everything = nodes.select_nodes(seen, 10**9)
    off = np.maximum(nodes.bounds[:, 0] - seen.position, seen.position - nodes.bounds[:, 1])
    distance = np.linalg.norm(np.maximum(off, 0.0), axis=1)
    need = (nodes.spacing / np.maximum(distance, seen.near))[everything]
    assert (np.diff(need) <= 1e-12).all()
    most = int(nodes.counts[everything[:7]].sum())
    assert nodes.select_nodes(seen, most).tolist() == everything[:7].tolist()
    assert nodes.select_nodes(seen, most - 1).tolist() == everything[:6].tolist()
    assert nodes.point_count == nodes.counts.sum()
    assert len(nodes) == len(nodes.counts)


def test_closing_spacing_is_the_finest_spacing_shown_below_a_node() -> None:
    nodes = tree()
    deep = int(np.argmin(nodes.spacing))
    line = [deep]
    while nodes.parents[line[-1]] >= 0:
        line.append(int(nodes.parents[line[-1]]))
    other = next(k for k in range(len(nodes)) if nodes.parents[k] == 0 and k not in line)
    closing = nodes.closing_spacings(np.array([*line[::-1], other]))
    assert {closing[row] for row in line} == {float(nodes.spacing[deep])}
    assert closing[other] == float(nodes.spacing[other])
    # A gap in the line ends what is passed on.
    closing = nodes.closing_spacings(np.array([line[-1], line[0]]))
    assert closing[line[-1]] == float(nodes.spacing[line[-1]])


def face(n: int = 130_000, seed: int = 0) -> PointCloud:
    rng = np.random.default_rng(seed)
    x, z = rng.random(n) * 10.0, rng.random(n) * 6.0
    points = np.column_stack([x, 0.3 * np.sin(x) + 0.01 * rng.random(n), z]) + UTM
    return PointCloud(
        points,
        colors=rng.integers(0, 255, (n, 3), np.uint8),
        normals=rng.normal(size=(n, 3)).astype(np.float32),
        fields={"intensity": rng.integers(0, 99, n)},
    )


def test_nodes_of_loaded_cloud_refer_to_its_rows() -> None:
    cloud = face()
    arrangement = arrange(cloud.points)
    nodes = ArrangedNodes(cloud, arrangement, 10**6)
    pieces = nodes.fetch(range(len(nodes)))
    assert np.array_equal(np.sort(np.concatenate([p.ids for p in pieces])), np.arange(130_000))
    for row, piece in enumerate(pieces):
        assert piece.cloud is cloud
        assert np.array_equal(piece.rows, piece.ids)
        own = cloud.points[piece.rows]
        assert np.array_equal([own.min(axis=0), own.max(axis=0)], nodes.bounds[row])
        assert len(piece.ids) == nodes.counts[row]
    assert nodes.first == tuple(np.flatnonzero(nodes.parents < 0))


class File:
    """Nodes of a cloud as they stand in a file, in another order than that of the tree."""

    def __init__(self, budget: int = 10**6) -> None:
        whole = face(60_000)
        corner = whole.points.min(axis=0)
        size = float(np.ptp(whole.points, axis=0).max())
        cell = np.minimum((whole.points - corner) / size * 4, 3).astype(int)
        level = np.random.default_rng(1).integers(0, 3, len(whole.points))
        keys = np.column_stack([level, cell >> (2 - level)[:, None]])
        self.keys, which = np.unique(keys, axis=0, return_inverse=True)
        which = which.ravel()
        in_file = np.random.default_rng(2).permutation(len(self.keys))
        rank = np.argsort(in_file)
        order = np.lexsort((np.arange(len(which)), rank[which]))
        self.whole = split_cloud(_rows(whole, order), [len(order)])[0]
        self.counts = np.bincount(which)
        self.starts = np.zeros(len(self.keys), np.int64)
        self.starts[in_file] = np.cumsum(self.counts[in_file]) - self.counts[in_file]
        side = size * 0.5 ** self.keys[:, :1]
        low = corner + self.keys[:, 1:] * side
        self.boxes = np.stack([low, low + side], axis=1)
        self.asked: list[int] = []
        first = tuple(np.flatnonzero(self.keys[:, 0] == 0).tolist())
        self.store = NodeStore(
            self.boxes,
            0.01 * side[:, 0],
            self.counts,
            self.starts,
            parent_rows(self.keys),
            self.read,
            budget,
            first,
        )
        start = self.read(first)
        self.asked.clear()
        for row, cloud in zip(first, split_cloud(start, self.counts[list(first)]), strict=True):
            self.store.store_node(row, cloud)
        box = np.stack([whole.points.min(axis=0), whole.points.max(axis=0)])
        self.cloud = StreamedCloud(
            start.points, start.colors, start.normals, start.fields, store=self.store, box=box
        )

    def read(self, rows: Sequence[int]) -> PointCloud:
        self.asked += rows
        spans = [np.arange(self.starts[r], self.starts[r] + self.counts[r]) for r in rows]
        return _rows(self.whole, np.concatenate(spans))


def _rows(cloud: PointCloud, rows: np.ndarray) -> PointCloud:
    assert cloud.colors is not None
    assert cloud.normals is not None
    fields = {name: values[rows] for name, values in cloud.fields.items()}
    return PointCloud(cloud.points[rows], cloud.colors[rows], cloud.normals[rows], fields)


def test_point_ids_are_file_rows_whatever_is_loaded() -> None:
    file = File()
    ids = np.random.default_rng(3).integers(0, len(file.whole.points), 500)
    for _ in range(2):
        assert np.array_equal(file.store.points_of(ids), file.whole.points[ids])
        holders = file.store.node_rows(ids)
        assert (file.starts[holders] <= ids).all()
        assert (ids < file.starts[holders] + file.counts[holders]).all()
        file.store.fetch([2, 5])
    assert np.array_equal(file.cloud.position(int(ids[0])), file.whole.points[ids[0]])
    assert file.store.points_of(np.zeros(0, np.int64)).shape == (0, 3)


def test_fetched_nodes_stay_loaded_until_released() -> None:
    file = File()
    rows = [row for row in range(len(file.keys)) if row not in file.store.loaded_nodes()][:4]
    pieces = file.store.fetch([*rows, *file.store.first])
    assert file.asked == rows
    for row, piece in zip([*rows, *file.store.first], pieces, strict=True):
        assert np.array_equal(piece.cloud.points[piece.rows], file.whole.points[piece.ids])
        assert np.array_equal(piece.cloud.colors[piece.rows], file.whole.colors[piece.ids])
        assert len(piece.ids) == file.counts[row]
    file.store.fetch(rows)
    assert file.asked == rows
    file.store.tree(rows[0], pieces[0].cloud)
    again = replace(pieces[0], cloud=replace(pieces[0].cloud))
    file.store.release(rows[0], again)  # one that has been read anew since stays
    assert rows[0] in file.store.loaded_nodes()
    file.store.release(rows[0], pieces[0])
    assert rows[0] not in file.store.loaded_nodes()
    assert file.store.tree(rows[1], pieces[1].cloud) is file.store.tree(rows[1], pieces[1].cloud)


def test_split_clouds_keep_all_point_attributes() -> None:
    cloud = face(100)
    a, b, c = split_cloud(cloud, [30, 0, 70])
    assert [len(part.points) for part in (a, b, c)] == [30, 0, 70]
    assert np.array_equal(c.points, cloud.points[30:])
    assert np.array_equal(c.colors, cloud.colors[30:])  # type: ignore[index]
    assert np.array_equal(c.normals, cloud.normals[30:])  # type: ignore[index]
    assert np.array_equal(c.fields["intensity"], cloud.fields["intensity"][30:])
    bare = split_cloud(PointCloud(cloud.points), [100])[0]
    assert bare.colors is bare.normals is None


def test_streamed_cloud_reports_bounds_and_overview_of_the_whole() -> None:
    file = File()
    assert file.cloud.count == len(file.whole.points) == file.store.point_count
    assert np.array_equal(file.cloud.bounds, file.whole.bounds)
    overview = file.cloud.overview()
    assert type(overview) is PointCloud
    assert len(overview.points) == file.counts[list(file.store.first)].sum()
    first = [file.starts[k] + np.arange(file.counts[k]) for k in file.store.first]
    rows = np.concatenate(first)
    for name in ("points", "colors", "normals"):
        assert np.array_equal(getattr(overview, name), getattr(file.whole, name)[rows])
    intensity = file.whole.fields["intensity"][rows]
    assert np.array_equal(overview.fields["intensity"], intensity)
    half = file.store.point_count / 2
    finer = file.counts[file.store.spacing < file.store.median_spacing].sum()
    coarser = file.counts[file.store.spacing > file.store.median_spacing].sum()
    assert finer <= half
    assert coarser <= half


@pytest.mark.full
@pytest.mark.parametrize("loaded_nodes", ["all", "some"])
def test_streamed_surface_matches_surface_of_loaded_points(loaded_nodes: str) -> None:
    file = File()
    rows = range(len(file.keys)) if loaded_nodes == "all" else range(0, len(file.keys), 2)
    file.store.fetch(rows)
    there = sorted(file.store.loaded_nodes())
    ids = np.concatenate([file.starts[row] + np.arange(file.counts[row]) for row in there])
    known = PointCloud(file.whole.points[ids])
    plain, streamed = CloudSurface(known), StreamedSurface(file.cloud)
    plain.build()
    streamed.build()
    assert streamed.count == len(file.whole.points)
    assert streamed.extent == pytest.approx(np.linalg.norm(np.ptp(file.whole.points, axis=0)))
    rng = np.random.default_rng(4)
    for at in rng.integers(0, len(ids), 6):
        centre = known.points[at] + rng.normal(0, 0.02, 3)
        found = streamed.connected_ids_in_ball(int(ids[at]), centre, 0.3)
        assert np.array_equal(
            found, np.sort(ids[plain.connected_ids_in_ball(int(at), centre, 0.3)])
        )
        trace = known.points[at] + np.outer(np.linspace(-0.5, 0.5, 7), [1.0, 0.3, 0.2])
        assert streamed.local_resolution(trace) == pytest.approx(plain.local_resolution(trace))
        normal, theirs = streamed.outcrop_normal(trace), plain.outcrop_normal(trace)
        assert abs(normal @ theirs) == pytest.approx(1.0, abs=1e-9)  # type: ignore[operator]
        near, far = (s.local_normal(0, centre, 0.3) for s in (streamed, plain))
        assert abs(near @ far) == pytest.approx(1.0, abs=1e-9)  # type: ignore[operator]
        assert np.array_equal(streamed.corners(found), file.whole.points[found])


def test_streamed_surface_has_no_normal_if_nothing_usable_is_loaded() -> None:
    file = File()
    surface = StreamedSurface(file.cloud)
    away = UTM + [500.0, 500.0, 500.0]
    assert surface.local_normal(0, away, 0.3) is None
    assert surface.outcrop_normal(away + np.eye(3)) is None
    # Nor where all that is there stands at one place, or in a line.
    for shape in (np.zeros((9, 3)), np.outer(np.arange(9.0), [1.0, 2.0, 3.0])):
        file.store.store_node(0, PointCloud(shape + file.boxes[0].mean(axis=0)))
        for row in set(file.store.loaded_nodes()) - {0}:
            file.store.store_node(row, PointCloud(np.zeros((0, 3))))
        assert surface.local_normal(0, file.boxes[0].mean(axis=0), 30.0) is None


def chosen_plainly(nodes: CloudNodes, seen: CloudView) -> set[int]:
    """A node at a time: the ball around its box against the planes that bound the picture."""
    position, axes = np.array(seen.position), np.array(seen.axes)
    wide = seen.half_height * seen.aspect
    found = set()
    for row, (low, high) in enumerate(nodes.bounds):
        x, y, z = axes @ ((low + high) / 2 - position)
        radius = np.linalg.norm(high - low) / 2
        if seen.is_orthographic:
            beyond = max(abs(x) - wide, abs(y) - seen.half_height)
        else:
            ahead = max(z, 0.0)
            beside = (abs(x) - wide * ahead) / np.hypot(1.0, wide)
            above = (abs(y) - seen.half_height * ahead) / np.hypot(1.0, seen.half_height)
            beyond = max(beside, above)
        nearest = np.clip(position, low, high)
        reach = max(float(np.linalg.norm(nearest - position)), seen.near)
        height = 2.0 * seen.half_height * (1.0 if seen.is_orthographic else reach)
        apart = 2.0 * nodes.spacing[row] / height * seen.pixels
        if beyond <= radius and -z < radius and (apart > 1.5 or nodes.parents[row] < 0):
            found.add(row)
    return found


def test_node_is_requested_if_its_ball_is_visible_and_too_coarse() -> None:
    """Fewer would leave holes at the edges of a picture, more would be read for nothing."""
    nodes, rng = tree(), np.random.default_rng(5)
    some = 0
    for k in range(60):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        seen = view(
            rng.uniform(-6.0, 16.0, 3),
            axes=tuple(map(tuple, turn.tolist())),
            orthographic=k % 3 == 0,
            half_height=float(rng.uniform(0.1, 1.5)),
            aspect=float(rng.uniform(0.4, 2.5)),
            near=float(rng.uniform(0.05, 2.0)),
            pixels=int(rng.integers(50, 1500)),
        )
        chosen = nodes.select_nodes(seen, 10**9).tolist()
        assert len(set(chosen)) == len(chosen)
        assert set(chosen) == chosen_plainly(nodes, seen)
        some += 0 < len(chosen) < len(nodes)
    assert some > 30


def test_nodes_near_box_are_those_whose_cubes_intersect_it() -> None:
    file = File()
    file.store.fetch(range(0, len(file.keys), 3))
    rng, there = np.random.default_rng(8), file.store.loaded_nodes()
    corners = file.boxes.reshape(-1, 3)
    boxes = [np.sort(corners[rng.integers(0, len(corners), 2)], axis=0) for _ in range(40)]
    boxes += [
        np.sort(rng.uniform(corners.min(axis=0), corners.max(axis=0), (2, 3)), axis=0)
        for _ in range(40)
    ]
    for low, high in boxes:
        found = file.store.find_touching_nodes(low, high)
        wanted = {
            row
            for row in there
            if (np.maximum(low, file.boxes[row, 0]) <= np.minimum(high, file.boxes[row, 1])).all()
        }
        assert {row for row, _ in found} == wanted
        assert all(cloud is there[row] for row, cloud in found)


def test_read_nodes_are_not_kept_loaded() -> None:
    file = File()
    before = set(file.store.loaded_nodes())
    row = next(row for row in range(len(file.keys)) if row not in before)
    alone = file.store.read(row)
    assert np.array_equal(alone.points, file.whole.points[file.starts[row] :][: file.counts[row]])
    assert file.store.tree(row, alone) is not file.store.tree(row, alone)
    file.store.points_of(np.arange(len(file.whole.points)))
    assert set(file.store.loaded_nodes()) == before
    # The tree of a node goes with it.
    piece = file.store.fetch([row])[0]
    kept = file.store.tree(row, piece.cloud)
    file.store.release(row, piece)
    assert file.store.tree(row, file.store.fetch([row])[0].cloud) is not kept


def test_median_spacing_is_the_median_over_points() -> None:
    store = File().store
    every = np.sort(np.repeat(store.spacing, store.counts))
    assert store.median_spacing == every[-(-len(every) // 2) - 1]


def test_neighbours_are_consecutive_in_nodes_of_a_loaded_cloud() -> None:
    cloud = face(60_000)
    nodes = ArrangedNodes(cloud, arrange(cloud.points), 10**6)
    assert nodes.is_ordered
    assert not File().store.is_ordered
    for piece in nodes.fetch(np.flatnonzero(nodes.counts > 5000).tolist()):
        own = cloud.points[piece.rows]
        steps = np.linalg.norm(np.diff(own, axis=0), axis=1)
        assert np.median(steps) < 0.05 * np.median(np.linalg.norm(own - own[0], axis=1))


@pytest.mark.parametrize("most", [1, 50, 777])
def test_surface_near_box_uses_at_most_the_maximum_number_of_points(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vomstudio.geometry.streaming.surfaces.MAX_FACE_POINTS", most)
    file = File()
    file.store.fetch(range(len(file.keys)))
    low, high = UTM + [2.0, -1.0, 1.0], UTM + [6.0, 1.0, 5.0]
    found = StreamedSurface(file.cloud)._vertices_near_box(low, high)
    points = file.whole.points
    inside = points[((points >= low) & (points <= high)).all(axis=1)]
    assert most <= len(found) < 2 * most + 1
    assert {tuple(p) for p in found.tolist()} <= {tuple(p) for p in inside.tolist()}
    if most > 100:
        # From all of the box.
        assert found.mean(axis=0) == pytest.approx(inside.mean(axis=0), abs=0.2)


def test_nearest_points_are_searched_in_all_loaded_nodes() -> None:
    file = File()
    file.store.fetch(range(0, len(file.keys), 2))
    there = np.concatenate([cloud.points for cloud in file.store.loaded_nodes().values()])
    surface, rng = StreamedSurface(file.cloud), np.random.default_rng(9)
    for centre in rng.uniform(there.min(axis=0) - 2.0, there.max(axis=0) + 2.0, (25, 3)):
        away = np.sort(np.linalg.norm(there - centre, axis=1))
        for count in (1, 16, 700):
            found = np.linalg.norm(surface._nearest(centre, count) - centre, axis=1)
            assert found == pytest.approx(away[:count], rel=1e-12)
    assert len(surface._nearest(centre, len(there) + 5)) == len(there)
