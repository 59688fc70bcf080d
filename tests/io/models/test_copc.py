"""COPC files, node by node: the same points as laspy finds, and no trust in the table of nodes."""

from __future__ import annotations

import struct
import time
from pathlib import Path

import laspy
import numpy as np
import pytest

from tests.io.models.copc_maker import write_copc
from tests.messages import by_code, refused
from vomstudio.core.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models import copc
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.preview import preview

N = 60_000


def make(path: Path, n: int = N, point_format: int = 7, split: int | None = None) -> Path:
    rng = np.random.default_rng(4)
    header = laspy.LasHeader(version="1.4", point_format=point_format)
    header.scales, header.offsets = [0.001] * 3, [576000.0, 5188000.0, 0.0]
    header.add_extra_dim(laspy.ExtraBytesParams("facet", np.int32))
    header.add_extra_dim(laspy.ExtraBytesParams("rough", np.float32))
    las = laspy.LasData(header)
    x, y = rng.random((2, n)) * [[90], [60]]
    for axis, values in zip("XYZ", (x, y, 8 * np.sin(x / 9)), strict=True):
        las[axis] = np.rint(values * 1000)
    if point_format > 6:
        las.red, las.green, las.blue = rng.integers(0, 65536, (3, n))
        las.red[0] = 65535
    las.intensity = rng.integers(1, 65536, n)
    las.classification = rng.integers(0, 200, n)
    las.facet = rng.integers(-5, 5, n)
    las.rough = rng.random(n)
    write_copc(path, las, split_pages_at=split)
    return path


@pytest.fixture(scope="module")
def cliff(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("copc") / "cliff.copc.laz", split=2)


def in_order(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.round(3).T)]


def test_nodes_of_a_level_match_laspy(cliff: Path) -> None:
    with laspy.CopcReader.open(cliff) as reader, copc.CopcFile(cliff) as file:
        assert file.nodes().points.sum() == N
        for level in range(4):
            found = file.nodes(range(level, level + 1))
            cloud = file.read(found)
            theirs = reader.query(level=level)
            assert (found.keys[:, 0] == level).all()
            assert len(cloud.points) == found.points.sum() == len(theirs)
            mine = np.column_stack([cloud.points, cloud.fields["facet"]])
            other = np.column_stack([np.asarray(theirs[a]) for a in ("x", "y", "z", "facet")])
            assert np.abs(in_order(mine) - in_order(other)).max() < 1e-9


def test_node_points_are_inside_their_cube(cliff: Path) -> None:
    found = copc.nodes(cliff)
    with copc.CopcFile(cliff) as file:
        for row in range(len(found)):
            points = file.read(found.select_rows(np.array([row]))).points
            low, high = found.bounds[row]
            assert ((points >= low - 1e-3) & (points <= high + 1e-3)).all()
    assert found.spacing[0] == pytest.approx(2 * found.spacing[found.keys[:, 0] == 1][0])


def test_nodes_in_bounds_contain_all_their_points(cliff: Path) -> None:
    box = np.array([[576020.0, 5188010.0, -10.0], [576030.0, 5188030.0, 10.0]])
    whole = read_model(cliff).data
    assert isinstance(whole, PointCloud)

    def inside(points: np.ndarray) -> np.ndarray:
        return points[((points >= box[0]) & (points <= box[1])).all(axis=1)]

    with copc.CopcFile(cliff) as file:
        found = file.nodes(bounds=box)
        part = file.read(found)
    assert len(part.points) < 0.7 * N
    assert np.array_equal(in_order(inside(part.points)), in_order(inside(whole.points)))
    assert len(copc.nodes(cliff, bounds=box + 1e6)) == 0


def test_whole_file_reads_as_laz(cliff: Path) -> None:
    loaded = read_model(cliff)
    assert isinstance(loaded.data, PointCloud)
    assert loaded.crs == "EPSG:32615"
    assert loaded.warnings == ()
    las = laspy.read(cliff)
    assert np.array_equal(loaded.data.points, np.asarray(las.xyz))
    cloud = all_nodes(cliff)
    assert np.array_equal(in_order(cloud.points), in_order(loaded.data.points))
    assert set(cloud.fields) == set(loaded.data.fields)
    with copc.CopcFile(cliff) as file:
        found = file.nodes()
        by_offset = file.read(found.select_rows(np.argsort(found.offsets)))
    assert by_offset.colors is not None
    assert loaded.data.colors is not None
    assert np.array_equal(by_offset.colors, loaded.data.colors)
    for name, values in loaded.data.fields.items():
        assert np.array_equal(by_offset.fields[name], values)


@pytest.mark.parametrize("point_format", [6, 8])
def test_all_copc_point_formats_are_read(tmp_path: Path, point_format: int) -> None:
    path = make(tmp_path / "a.copc.laz", 5000, point_format)
    cloud = all_nodes(path)
    assert len(cloud.points) == 5000
    assert (cloud.colors is None) == (point_format == 6)


def test_preview_covers_the_whole_and_is_quick(cliff: Path) -> None:
    preview(cliff, 5000)
    started = time.perf_counter()
    cloud = preview(cliff, 5000)
    assert time.perf_counter() - started < 0.3
    assert cloud is not None
    assert 1000 < len(cloud.points) <= 5000
    whole = read_model(cliff).data.bounds
    assert np.abs(cloud.bounds - whole).max() < 3.0


def test_file_that_is_not_copc_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "a.copc.laz"
    for content in (b"", b"LASF", b"nonsense" * 100):
        path.write_bytes(content)
        with refused("file.other-format", format="COPC", file=path):
            copc.nodes(path)
    with pytest.raises(InputError):
        copc.nodes(tmp_path / "none.copc.laz")


def test_bounds_and_point_count_are_read_without_points(cliff: Path) -> None:
    with copc.CopcFile(cliff) as file, laspy.open(cliff) as theirs:
        assert file.crs == "EPSG:32615"
        assert file.points == N
        assert np.array_equal(file.bounds, [theirs.header.mins, theirs.header.maxs])


def all_nodes(path: Path) -> PointCloud:
    with copc.CopcFile(path) as file:
        return file.read(file.nodes())


def cut_or_sound(path: Path) -> None:
    """Everything the module does gives points, or an InputError that names the file."""
    try:
        with copc.CopcFile(path) as file:
            file.read(file.nodes())
    except InputError as error:
        if error.file != str(path):
            raise
    preview(path, 500)


def test_truncated_file_raises_input_error(tmp_path: Path) -> None:
    content = make(tmp_path / "a.copc.laz", 2000, split=2).read_bytes()
    path = tmp_path / "cut.copc.laz"
    for n in [*range(0, 1500, 37), *range(1500, len(content), 997), len(content) - 1]:
        path.write_bytes(content[:n])
        with pytest.raises(InputError):
            all_nodes(path)
        cut_or_sound(path)


@pytest.mark.full
def test_damaged_file_gives_points_or_input_error(tmp_path: Path) -> None:
    content = make(tmp_path / "a.copc.laz", 500, split=2).read_bytes()
    path = tmp_path / "bad.copc.laz"
    rng = np.random.default_rng(3)
    tail = len(content) - 2000
    for number in range(300):
        bad = bytearray(content)
        low, high = [(94, 900), (tail, len(bad)), (900, len(bad))][number % 3]
        for at in rng.integers(low, high, 2):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        cut_or_sound(path)
        if number % 20 == 0:
            try:
                read_model(path)
            except InputError:
                continue


@pytest.mark.parametrize("count", [2**31 - 1, 10**7, -2])
def test_node_with_excessive_point_count_is_rejected(tmp_path: Path, count: int) -> None:
    path = make(tmp_path / "a.copc.laz", 500)
    content = bytearray(path.read_bytes())
    struct.pack_into("<i", content, len(content) - 4, count)
    path.write_bytes(content)
    if count < 0:
        assert copc.nodes(path).points.sum() < 500
        return
    with refused("file.damaged", format="COPC"):
        all_nodes(path)


def test_circular_hierarchy_pages_are_rejected(tmp_path: Path) -> None:
    path = make(tmp_path / "a.copc.laz", 500)
    content = bytearray(path.read_bytes())
    at, size = struct.unpack_from("<2Q", content, 375 + 54 + 40)
    struct.pack_into("<Q2i", content, len(content) - 16, at, size, -1)
    path.write_bytes(content)
    with refused("file.damaged", format="COPC"):
        copc.nodes(path)


def test_withheld_points_are_hidden_in_streamed_and_whole_reads(tmp_path: Path) -> None:
    """They are 1,000 m above the others; rows are the same both ways."""
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = [0.001] * 3
    header.add_extra_dim(laspy.ExtraBytesParams("rough", np.int16))
    las = laspy.LasData(header)
    x, y, z = np.random.default_rng(3).uniform(0, 50, (3, 3000))
    las.rough = np.arange(3000) % 100
    bad = np.arange(3000) % 50 == 0
    z[bad] += 1000
    las.x, las.y, las.z = x, y, z
    las.withheld[bad] = 1
    path = tmp_path / "a.copc.laz"
    write_copc(path, las)
    loaded = read_model(path)
    assert "model.withheld-hidden" in by_code(loaded.warnings)
    cloud = copc.stream(path, 10_000)
    for points in (loaded.data.points, cloud.points):
        assert len(points) == 3000
        assert points[:, 2].max() < 51
    assert "model.withheld-hidden" in by_code(copc.read_crs(path)[1])
