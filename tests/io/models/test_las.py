"""LAS and LAZ clouds: exact coordinates, colours, fields, reference systems, damage."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
from pyproj import CRS

from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.preview import preview

N = 120_000


def make(folder: Path, name: str = "cloud.laz", n: int = N, crs: int | None = 32615) -> Path:
    rng = np.random.default_rng(5)
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales = [0.001, 0.001, 0.0005]
    header.offsets = [576000.0, 5188000.0, 0.0]
    header.add_extra_dim(laspy.ExtraBytesParams("facet", np.int32))
    if crs is not None:
        header.add_crs(CRS.from_epsg(crs))
    las = laspy.LasData(header)
    las.X, las.Y, las.Z = (rng.integers(-(10**6), 10**6, n) for _ in range(3))
    las.red, las.green, las.blue = (rng.integers(0, 65536, n) for _ in range(3))
    las.intensity = rng.integers(0, 65536, n)
    las.classification = np.full(n, 2)
    las.gps_time = rng.random(n)
    las.facet = rng.integers(-5, 5, n)
    path = folder / name
    las.write(path)
    return path


def cloud_of(path: Path) -> tuple[PointCloud, dict[str, dict[str, Any]]]:
    loaded = read_model(path)
    assert isinstance(loaded.data, PointCloud)
    return loaded.data, by_code(loaded.warnings)


@pytest.mark.parametrize("name", ["cloud.las", "cloud.laz"])
def test_cloud_matches_laspy(tmp_path: Path, name: str) -> None:
    path = make(tmp_path, name)
    loaded = read_model(path)
    cloud = loaded.data
    assert isinstance(cloud, PointCloud)
    las = laspy.read(path)
    raw = np.stack([np.asarray(las.X), np.asarray(las.Y), np.asarray(las.Z)], axis=1)
    assert np.array_equal(cloud.points, raw * las.header.scales + las.header.offsets)
    assert loaded.crs == "EPSG:32615"
    assert loaded.warnings == ()
    assert cloud.colors is not None
    assert np.array_equal(cloud.colors[:, 1], np.asarray(las.green) >> 8)
    assert set(cloud.fields) == {"intensity", "classification", "gps_time", "facet"}
    for field in cloud.fields:
        assert np.array_equal(cloud.fields[field], np.asarray(las[field]))


def test_8_bit_colors_are_not_read_as_16_bit(tmp_path: Path) -> None:
    path = make(tmp_path, n=50)
    las = laspy.read(path)
    las.red, las.green, las.blue = np.full(50, 255), np.full(50, 128), np.zeros(50)
    las.write(path)
    colors = cloud_of(path)[0].colors
    assert colors is not None
    assert colors[0].tolist() == [255, 128, 0]


def test_all_black_colors_are_dropped_and_reported(tmp_path: Path) -> None:
    path = make(tmp_path, n=50, crs=None)
    las = laspy.read(path)
    las.red = las.green = las.blue = np.zeros(50)
    las.write(path)
    loaded = read_model(path)
    assert loaded.crs is None
    assert loaded.data.colors is None
    assert loaded.warnings[0].code == "model.colors-black"


@pytest.mark.parametrize("share", first_in_default_tier([0.3, 0.6, 0.95], 2))
@pytest.mark.parametrize("name", first_in_default_tier(["cloud.las", "cloud.laz"], 2))
def test_truncated_file_gives_valid_points_and_a_warning(
    tmp_path: Path, name: str, share: float
) -> None:
    path = make(tmp_path, name)
    whole, _ = cloud_of(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    part, findings = cloud_of(path)
    assert (share - 0.02) * N < len(part.points) < N
    assert "model.incomplete" in findings
    assert np.array_equal(part.points, whole.points[: len(part.points)])


@pytest.mark.parametrize("name", ["cloud.las", "cloud.laz"])
def test_las_truncated_anywhere_gives_points_or_input_error(tmp_path: Path, name: str) -> None:
    content = make(tmp_path, name, n=300).read_bytes()
    path = tmp_path / f"cut{name[-4:]}"
    for n in [*range(0, min(len(content), 2000), 23), *range(2000, len(content), 97)]:
        path.write_bytes(content[:n])
        try:
            _, findings = cloud_of(path)
        except InputError as error:
            if error.file != str(path):
                raise
        else:
            assert "model.incomplete" in findings or n > len(content) - 60


@pytest.mark.parametrize("name", ["cloud.las", "cloud.laz"])
def test_excessive_point_count_in_header_is_ignored(tmp_path: Path, name: str) -> None:
    path = make(tmp_path, name, n=300)
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, 107, 2**32 - 1)
    path.write_bytes(content)
    try:
        cloud, findings = cloud_of(path)
    except InputError as error:
        if error.file != str(path):
            raise
    else:
        assert len(cloud.points) <= 300
        assert "model.incomplete" in findings


def test_damaged_headers_give_points_or_input_error(tmp_path: Path) -> None:
    content = make(tmp_path, "cloud.las", n=40).read_bytes()
    path = tmp_path / "bad.las"
    rng = np.random.default_rng(1)
    for _ in range(300):
        bad = bytearray(content)
        for at in rng.integers(0, 700, 3):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            cloud_of(path)
        except InputError:
            continue


@pytest.mark.parametrize("content", [b"LASF", b"nothing of the kind", b"LASF" + b"\0" * 300])
def test_file_that_is_not_las_is_rejected_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "cloud.las"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"cloud\.las"):
        read_model(path)


def test_reading_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    token = CancelToken()
    path = make(tmp_path, n=100)
    token.cancel()
    with pytest.raises(Cancelled):
        read_model(path, SilentProgress(token))


def test_outcrop_cloud_has_expected_points_and_no_crs(data_dir: Path) -> None:
    loaded = read_model(data_dir / "compass_outcrop" / "outcrop.laz")
    assert isinstance(loaded.data, PointCloud)
    assert len(loaded.data.points) == 268_035
    assert loaded.crs is None
    assert loaded.data.colors is not None
    size = loaded.data.bounds[1] - loaded.data.bounds[0]
    assert size.round().tolist()[:2] == [14, 11]


@pytest.mark.slow
def test_a_large_cloud_is_exact_and_has_its_reference_system(data_dir: Path) -> None:
    path = data_dir / "brighton_model" / "load_9.4M.laz"
    loaded = read_model(path)
    assert isinstance(loaded.data, PointCloud)
    assert len(loaded.data.points) == 9_403_930
    assert loaded.crs == "EPSG:32615"
    las = laspy.read(path)
    for axis, name in enumerate("XYZ"):
        values = np.asarray(las[name]) * las.header.scales[axis] + las.header.offsets[axis]
        assert np.array_equal(loaded.data.points[:, axis], values)


@pytest.mark.parametrize("chunks", [0, 5, 2**28, 2**32 - 1])
def test_wrong_chunk_count_in_table_is_ignored(tmp_path: Path, chunks: int) -> None:
    path = make(tmp_path, n=1000)
    whole, _ = cloud_of(path)
    content = bytearray(path.read_bytes())
    (points_at,) = struct.unpack_from("<I", content, 96)
    (table_at,) = struct.unpack_from("<q", content, points_at)
    struct.pack_into("<I", content, table_at + 4, chunks)
    path.write_bytes(content)
    assert np.array_equal(cloud_of(path)[0].points, whole.points)


@pytest.mark.parametrize("size", [0, 1, 2**31, 2**32 - 2, 2**32 - 1])
def test_excessive_chunk_size_is_rejected_before_allocation(tmp_path: Path, size: int) -> None:
    path = make(tmp_path, n=300)
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, content.find(b"laszip encoded") + 52 + 12, size)
    path.write_bytes(content)
    with pytest.raises(InputError):
        read_model(path)


@pytest.mark.full
def test_damaged_laz_gives_points_or_input_error(tmp_path: Path) -> None:
    content = make(tmp_path, n=40).read_bytes()
    path = tmp_path / "bad.laz"
    rng = np.random.default_rng(2)
    for _ in range(200):
        bad = bytearray(content)
        for at in rng.integers(94, len(content), 3):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            cloud_of(path)
        except InputError:
            continue


def marked(
    path: Path, point_format: int, dtype: type, nothing: float, scaled: bool
) -> laspy.LasData:
    """A cloud of which some points are withheld and some values mean that there is none. laspy
    writes the marks, and struct the number that stands for nothing."""
    version = "1.4" if point_format >= 6 else "1.2"
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.scales = [0.01] * 3
    scales = {"scales": np.array([0.5]), "offsets": np.array([10.0])} if scaled else {}
    header.add_extra_dim(laspy.ExtraBytesParams("rough", dtype, **scales))
    las = laspy.LasData(header)
    las.x, las.y, las.z = np.random.default_rng(1).uniform(0, 50, (3, 500))
    stored = np.arange(500).astype(dtype)
    stored[::7] = nothing
    las.points.array["rough"] = stored
    las.withheld[::5] = 1
    las.write(path)
    raw = bytearray(path.read_bytes())
    at = raw.index(b"rough" + bytes(27)) - 4
    form = {"u": "<Q", "i": "<q", "f": "<d"}[np.dtype(dtype).kind]
    raw[at + 3] |= 1
    raw[at + 40 : at + 48] = struct.pack(form, nothing)
    path.write_bytes(raw)
    return las


@pytest.mark.parametrize("ending", ["las", "laz"])
@pytest.mark.parametrize("point_format", [1, 6])
@pytest.mark.parametrize(
    ("dtype", "nothing", "scaled"),
    [(np.int16, -9999, False), (np.uint16, 65535, True), (np.float32, -9999.25, False)],
)
def test_no_data_becomes_nan_and_withheld_points_are_dropped(
    tmp_path: Path, ending: str, point_format: int, dtype: type, nothing: float, scaled: bool
) -> None:
    path = tmp_path / f"a.{ending}"
    las = marked(path, point_format, dtype, nothing, scaled)
    kept = np.arange(500) % 5 != 0
    cloud, findings = cloud_of(path)
    assert findings["model.points-withheld"] == {"count": 100}
    assert np.allclose(cloud.points, las.xyz[kept])
    wanted = np.arange(500.0) * (0.5 if scaled else 1) + (10 if scaled else 0)
    wanted[::7] = np.nan
    assert np.array_equal(cloud.fields["rough"], wanted[kept], equal_nan=True)


def test_cloud_with_only_withheld_points_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "a.las"
    las = marked(path, 6, np.int16, -9999, False)
    las.withheld[:] = 1
    las.write(path)
    with refused("model.all-withheld"):
        read_model(path)


@pytest.mark.parametrize("ending", ["las", "laz"])
@pytest.mark.parametrize("point_format", [1, 6])
@pytest.mark.parametrize(
    ("at", "content"),
    [(2, b"\0\0"), (2, b"\x63"), (4, bytes(32)), (4, b"\xe4\xff")],
    ids=["no bytes", "unknown type", "no name", "name not UTF-8"],
)
def test_invalid_field_descriptions_do_not_lose_the_points(
    tmp_path: Path, ending: str, point_format: int, at: int, content: bytes
) -> None:
    path = tmp_path / f"a.{ending}"
    las = marked(path, point_format, np.int16, -9999, False)
    raw = bytearray(path.read_bytes())
    start = raw.index(b"rough" + bytes(27)) - 4 + at
    raw[start : start + len(content)] = content
    path.write_bytes(raw)
    cloud, findings = cloud_of(path)
    assert np.allclose(cloud.points, las.xyz[np.arange(500) % 5 != 0])
    assert not cloud.fields
    assert "model.fields-damaged" in findings


@pytest.mark.parametrize("length", [0, 10, 19])
def test_records_shorter_than_a_point_are_rejected(tmp_path: Path, length: int) -> None:
    path = tmp_path / "a.las"
    marked(path, 1, np.int16, -9999, False)
    raw = bytearray(path.read_bytes())
    struct.pack_into("<H", raw, 105, length)
    path.write_bytes(raw)
    with refused("file.damaged", format="LAS", field="LAS header"):
        read_model(path)
    assert preview(path) is None
