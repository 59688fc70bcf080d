"""Large COPC files in the window: what is read for a view, what is let go, and what is said."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

from tests.io.models.test_copc import N, make
from vomstudio.core.findings import Finding
from vomstudio.geometry.brush import CloudSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.streaming.octree import CloudView
from vomstudio.geometry.streaming.surfaces import StreamedSurface, create_surface
from vomstudio.io.models import copc
from vomstudio.io.models.opening import read_model
from vomstudio.rendering.prepare.events import (
    NodeReady,
    NodesDropped,
    NodeStream,
    Problem,
    Stopped,
    StreamStarted,
    ViewDone,
)
from vomstudio.rendering.prepare.preparation import prepare_cloud


@pytest.fixture(scope="module")
def cliff(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("copc") / "cliff.copc.laz", split=2)


@pytest.fixture(scope="module")
def whole(cliff: Path) -> PointCloud:
    data = read_model(cliff).data
    assert isinstance(data, PointCloud)
    return data


@pytest.fixture(autouse=True)
def small_overview(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(copc, "OVERVIEW_POINTS", 3000)


def from_above(x: float, y: float, height: float) -> CloudView:
    return CloudView(
        (576000.0 + x, 5188000.0 + y, height),
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
        0.27,
        1.4,
        False,
        0.01,
        400,
    )


class Sink:
    """What the scene does with the events: it holds nodes, and lets them go. Everything is done in
    this thread."""

    def __init__(self, cloud: PointCloud, budget: int = 30_000) -> None:
        self.stop = threading.Event()
        self.nodes: dict[int, NodeReady] = {}
        self.shown: tuple[int, ...] = ()
        self.problems: list[Finding] = []
        self.most = 0
        self.done = -1
        self.streamer: NodeStream | None = None
        self.origin = np.round(cloud.bounds.mean(axis=0))
        prepare_cloud(cloud, self.origin, self.stop, self.emit, lambda job: job(), budget)

    def emit(self, event: object) -> None:
        if self.stop.is_set():
            raise Stopped
        if isinstance(event, NodeReady):
            self.nodes[event.row] = event
            self.most = max(self.most, sum(len(n.chunk.points) for n in self.nodes.values()))
        elif isinstance(event, NodesDropped):
            for row, piece in event.pieces.items():
                del self.nodes[row]
                event.nodes.release(row, piece)
        elif isinstance(event, Problem):
            self.problems.append(event.finding)
        elif isinstance(event, StreamStarted):
            self.streamer = event.streamer
        elif isinstance(event, ViewDone):
            self.done = event.request_number

    def look(self, view: CloudView) -> None:
        assert self.streamer is not None
        shown = self.streamer.look(view)
        assert shown is not None
        self.shown = tuple(shown)
        assert self.done == self.streamer.request_number
        assert self.streamer.look(view) is None


@pytest.mark.full
def test_streamed_points_keep_their_row_in_the_file(cliff: Path, whole: PointCloud) -> None:
    cloud = copc.stream(cliff, 20_000)
    assert cloud.count == N
    assert np.array_equal(cloud.bounds, whole.bounds)
    assert 0 < len(cloud.points) < 10_000
    ids = np.random.default_rng(0).integers(0, N, 500)
    assert np.array_equal(cloud.store.points_of(ids), whole.points[ids])
    assert np.array_equal(cloud.position(17), whole.points[17])
    row = cloud.store.first[-1]
    first = int(cloud.store.starts[row])
    held = cloud.store.loaded_nodes()[row]
    assert np.array_equal(held.points, whole.points[first : first + len(held.points)])


def test_near_views_select_finer_nodes_with_parents_first(cliff: Path) -> None:
    store = copc.stream(cliff, 20_000).store
    far, near = (store.select_nodes(from_above(40, 30, h), N) for h in (3000.0, 30.0))
    assert store.spacing[near].min() < store.spacing[far].min()
    assert len(store.select_nodes(from_above(5000, 30, 30.0), N)) == 0
    place = {row: k for k, row in enumerate(near.tolist())}
    for row, k in place.items():
        parent = int(store.parents[row])
        assert parent < 0 or place[parent] < k
    few = store.select_nodes(from_above(40, 30, 30.0), 9000)
    assert 0 < store.counts[few].sum() <= 9000
    assert all(closed <= store.spacing[row] for row, closed in store.closing_spacings(near).items())


def test_selected_nodes_are_read_within_the_point_budget(cliff: Path, whole: PointCloud) -> None:
    cloud = copc.stream(cliff, 30_000)
    sink = Sink(cloud)
    for x in (10.0, 45.0, 80.0, 10.0):
        sink.look(from_above(x, 30, 40.0))
        assert set(sink.shown) <= set(sink.nodes)
        assert set(sink.nodes) == set(cloud.store.loaded_nodes())
    assert sink.most <= 30_000
    assert len(sink.shown) > len(cloud.store.first)
    for node in sink.nodes.values():
        at = node.chunk.points + np.round(cloud.bounds.mean(axis=0))
        assert np.abs(at - whole.points[node.chunk.point_ids]).max() < 1e-3
    assert sink.problems == []


def test_surface_of_all_nodes_equals_that_of_the_whole_cloud(
    cliff: Path, whole: PointCloud
) -> None:
    cloud = copc.stream(cliff, N)
    for row in range(len(cloud.store)):
        cloud.store.fetch([row])
    surface, other = create_surface(cloud), CloudSurface(whole)
    assert isinstance(surface, StreamedSurface)
    surface.build()
    other.build()
    assert surface.count == other.count
    rng = np.random.default_rng(2)
    for index in rng.integers(0, N, 10).tolist():
        centre = whole.points[index]
        assert np.array_equal(
            surface.connected_ids_in_ball(index, centre, 1.5),
            other.connected_ids_in_ball(index, centre, 1.5),
        )
        line = whole.points[surface.connected_ids_in_ball(index, centre, 4.0)[:3]]
        assert surface.local_resolution(line) == pytest.approx(other.local_resolution(line))
        one, two = surface.outcrop_normal(line), other.outcrop_normal(line)
        assert one is not None
        assert two is not None
        assert abs(one @ two) > 0.999
        normal = surface.local_normal(index, centre, 1.5)
        assert normal is not None


def test_streamed_surface_reads_points_of_unloaded_nodes(cliff: Path, whole: PointCloud) -> None:
    cloud = copc.stream(cliff, 20_000)
    surface = create_surface(cloud)
    ids = np.arange(0, N, 97)
    assert np.array_equal(surface.corners(ids), whole.points[ids])
    centre = cloud.points[100]
    row = int(cloud.store.node_rows(np.array([0]))[0])
    assert row in range(len(cloud.store))
    coarse = surface.local_resolution(centre[None])
    fine = CloudSurface(whole).local_resolution(centre[None])
    assert coarse is not None
    assert fine is not None
    assert coarse > fine


def test_damaged_node_is_reported_once_and_the_others_are_shown(
    tmp_path: Path, cliff: Path
) -> None:
    path = tmp_path / "bad.copc.laz"
    content = bytearray(cliff.read_bytes())
    found = copc.nodes(cliff)
    deep = np.flatnonzero(found.keys[:, 0] == found.keys[:, 0].max())[:5]
    for at in found.offsets[deep]:
        content[at + 60 : at + 64] = b"\xff\xff\xff\xff"
        content[at + 30 : at + 60] = bytes(30)
    path.write_bytes(content)
    cloud = copc.stream(path, N)
    bad = []
    for row in range(len(cloud.store)):
        try:
            cloud.store.read(row)
        except copc.InputError:
            bad.append(row)
    assert set(bad) <= set(deep.tolist())
    assert bad
    sink = Sink(cloud)
    cloud.store.budget = 2 * N
    x, y = cloud.store.bounds[bad[0]].mean(axis=0)[:2] - (576000.0, 5188000.0)
    sink.look(from_above(x, y, 40.0))
    sink.look(from_above(x, y, 41.0))
    assert len(sink.problems) == 1
    assert sink.problems[0].code == "display.part-missing"
    assert "bad.copc.laz" in sink.problems[0].message
    assert len(sink.nodes) > len(cloud.store.first)


def test_file_truncated_while_open_is_reported_once(tmp_path: Path, cliff: Path) -> None:
    path = tmp_path / "cut.copc.laz"
    path.write_bytes(cliff.read_bytes())
    cloud = copc.stream(path, N)
    sink = Sink(cloud)
    with open(path, "r+b") as file:
        file.truncate(2000)
    sink.look(from_above(45, 30, 60.0))
    sink.look(from_above(20, 30, 40.0))
    assert len(sink.problems) == 1
    assert len(sink.nodes) == len(cloud.store.first)


def test_view_draws_only_the_needed_points_of_an_in_memory_cloud() -> None:
    rng = np.random.default_rng(3)
    points = rng.random((400_000, 3)) * [90, 60, 0.1] + [576000.0, 5188000.0, 0.0]
    cloud = PointCloud(points, rng.integers(0, 255, (len(points), 3), np.uint8))
    sink = Sink(cloud, budget=250_000)
    first = sum(len(n.chunk.points) for n in sink.nodes.values())
    assert 0 < first <= 50_000
    sink.look(from_above(45, 30, 3000.0))
    assert sum(len(sink.nodes[row].chunk.points) for row in sink.shown) == first
    for x in (10.0, 80.0, 10.0):
        sink.look(from_above(x, 30, 20.0))
        assert set(sink.shown) <= set(sink.nodes)
    assert sink.most <= 250_000
    for node in sink.nodes.values():
        at = node.chunk.points + sink.origin
        assert np.abs(at - points[node.chunk.point_ids]).max() < 1e-3
    # Near by, every point of what is seen is there.
    sink = Sink(cloud, budget=800_000)
    sink.look(from_above(45, 30, 10.0))
    ids = np.concatenate([sink.nodes[row].chunk.point_ids for row in sink.shown])
    seen = np.flatnonzero((np.abs(points[:, :2] - [576045.0, 5188030.0]) < 2.0).all(axis=1))
    assert np.isin(seen, ids).all()
    assert sink.problems == []


def test_stopped_stream_reads_no_more_nodes(cliff: Path) -> None:
    cloud = copc.stream(cliff, N)
    sink = Sink(cloud)
    assert sink.streamer is not None
    before = len(sink.nodes)
    sink.stop.set()
    assert sink.streamer.look(from_above(45, 30, 40.0)) is not None
    assert len(sink.nodes) == before
    assert sink.problems == []
