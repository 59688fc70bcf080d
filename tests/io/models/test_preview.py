"""First pictures of point clouds: real points, all over the file."""

from __future__ import annotations

import time
from pathlib import Path

import laspy
import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models import preview as previews
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.preview import preview

N = 160_000


def make(path: Path, point_format: int, n: int = N) -> Path:
    rng = np.random.default_rng(6)
    header = laspy.LasHeader(version="1.4", point_format=point_format)
    header.scales, header.offsets = [0.001] * 3, [576000.0, 5188000.0, 0.0]
    las = laspy.LasData(header)
    x, y = np.arange(n) / n * 300.0, rng.random(n) * 40.0
    las.X, las.Y, las.Z = (np.rint(v * 1000).astype(np.int32) for v in (x, y, 9 * np.sin(x / 20)))
    las.intensity = rng.integers(1, 65536, n)
    las.classification = rng.integers(0, 31, n)
    if "red" in header.point_format.dimension_names:
        las.red, las.green, las.blue = rng.integers(0, 65536, (3, n))
    las.write(path)
    return path


@pytest.mark.parametrize("point_format", first_in_default_tier([0, 1, 2, 3, 6, 7, 8]))
@pytest.mark.parametrize("ending", first_in_default_tier([".las", ".laz"]))
def test_preview_contains_points_from_the_whole_file(
    tmp_path: Path, ending: str, point_format: int
) -> None:
    path = make(tmp_path / f"a{ending}", point_format)
    cloud = preview(path, 20_000)
    assert cloud is not None
    whole = read_model(path).data
    assert isinstance(whole, PointCloud)
    assert 15_000 < len(cloud.points) <= 20_000

    def rows(given: PointCloud) -> set[tuple[float, ...]]:
        columns = [given.points, given.fields["intensity"], given.fields["classification"]]
        if given.colors is not None:
            columns.append(given.colors)
        return set(map(tuple, np.column_stack(columns).tolist()))

    assert rows(cloud) <= rows(whole)
    assert (cloud.colors is None) == (whole.colors is None)
    # Of every fifty metres along the cliff there is some.
    assert np.histogram(cloud.points[:, 0] - 576000, np.arange(0, 301, 50))[0].min() > 500


@pytest.mark.parametrize("point_format", [3, 7])
def test_only_the_beginnings_of_chunks_are_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, point_format: int
) -> None:
    monkeypatch.setattr(previews, "MAX_UNPACKED_POINTS", 9_000)
    path = make(tmp_path / "a.laz", point_format)
    cloud = preview(path, 4000)
    whole = read_model(path).data
    assert cloud is not None
    assert isinstance(whole, PointCloud)
    assert len(cloud.points) == 4000
    beginnings = np.concatenate([whole.points[k : k + 2250] for k in range(0, N, 50_000)])
    assert set(map(tuple, cloud.points.tolist())) <= set(map(tuple, beginnings.tolist()))


def test_a_small_file_is_shown_whole(tmp_path: Path) -> None:
    for ending in (".las", ".laz"):
        cloud = preview(make(tmp_path / f"a{ending}", 7, 300), 20_000)
        assert cloud is not None
        assert len(cloud.points) == 300


def test_preview_of_unreadable_file_is_none_and_never_raises(tmp_path: Path) -> None:
    path = tmp_path / "a.laz"
    assert preview(path) is None
    for content in (b"", b"LASF", b"LASF" + b"\0" * 300, b"ply\n"):
        path.write_bytes(content)
        assert preview(path) is None
    content = make(path, 7, 2000).read_bytes()
    for n in range(0, len(content), 997):
        path.write_bytes(content[:n])
        assert preview(path) is None
    rng = np.random.default_rng(1)
    for point_format in (3, 7):
        content = make(path, point_format, 300).read_bytes()
        for _ in range(200):
            bad = bytearray(content)
            for at in rng.integers(94, len(bad), 3):
                bad[at] = rng.integers(0, 256)
            path.write_bytes(bad)
            preview(path)


@pytest.mark.slow
def test_nine_million_points_are_previewed_at_once(data_dir: Path) -> None:
    path = data_dir / "brighton_model" / "load_9.4M.laz"
    preview(path)
    started = time.perf_counter()
    cloud = preview(path)
    # A quarter of a second where nothing else runs.
    assert time.perf_counter() - started < 1.5
    assert cloud is not None
    assert len(cloud.points) == 200_000
    whole = read_model(path).data.bounds
    size = whole[1] - whole[0]
    assert (np.abs(cloud.bounds - whole) < 0.05 * size).all()
