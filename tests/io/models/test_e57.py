"""E57 scans: in their place, and one clear sentence without the package that reads them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.opening import read_model

N = 2000
# A quarter turn about z: x becomes y.
QUARTER = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
SHIFT = np.array([576000.0, 5188000.0, 150.0])


def test_missing_package_error_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pye57", None)
    path = tmp_path / "a.e57"
    path.write_bytes(b"ASTM-E57" + bytes(100))
    with pytest.raises(InputError, match=r"vomstudio\[e57\]"):
        read_model(path)


@pytest.mark.parametrize("content", [b"", b"nothing of the kind", b"ASTM-E5"])
def test_file_that_is_not_e57_is_rejected_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.e57"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.e57"):
        read_model(path)


def make(path: Path, scans: int = 1, invalid: int = 0) -> list[dict[str, np.ndarray]]:
    pye57 = pytest.importorskip("pye57", reason="the extra e57 is not installed")
    rng = np.random.default_rng(2)
    written = []
    with pye57.E57(str(path), mode="w") as file:
        for number in range(scans):
            data = {
                name: np.float32(rng.random(N) * 30).astype(float)
                for name in ("cartesianX", "cartesianY", "cartesianZ")
            }
            data["intensity"] = np.float32(rng.random(N)).astype(float)
            for color in ("colorRed", "colorGreen", "colorBlue"):
                data[color] = rng.integers(0, 256, N).astype(np.uint8)
            if invalid:
                data["cartesianInvalidState"] = (np.arange(N) < invalid).astype(np.int8)
            file.write_scan_raw(data, rotation=QUARTER, translation=SHIFT + 10 * number)
            written.append(data)
    return written


def cloud_of(path: Path) -> PointCloud:
    data = read_model(path).data
    assert isinstance(data, PointCloud)
    return data


def test_scans_are_placed_by_their_pose(tmp_path: Path) -> None:
    written = make(tmp_path / "a.e57", 2)
    cloud = cloud_of(tmp_path / "a.e57")
    for number, data in enumerate(written):
        here = cloud.fields["scan"] == number
        x, y, z = (data[f"cartesian{axis}"] for axis in "XYZ")
        expected = np.column_stack([-y, x, z]) + SHIFT + 10 * number
        assert np.abs(cloud.points[here] - expected).max() < 1e-8
        assert cloud.colors is not None
        rgb = [data[name] for name in ("colorRed", "colorGreen", "colorBlue")]
        assert np.array_equal(cloud.colors[here], np.column_stack(rgb))
        assert np.array_equal(cloud.fields["intensity"][here], data["intensity"])


def test_invalid_points_are_left_out_and_counted(tmp_path: Path) -> None:
    make(tmp_path / "a.e57", 1, invalid=7)
    loaded = read_model(tmp_path / "a.e57")
    assert isinstance(loaded.data, PointCloud)
    assert len(loaded.data.points) == N - 7
    assert by_code(loaded.warnings)["model.points-withheld"] == {"count": 7}


def test_points_match_pye57(tmp_path: Path) -> None:
    make(tmp_path / "a.e57")
    import pye57

    with pye57.E57(str(tmp_path / "a.e57")) as file:
        theirs = file.read_scan(0, intensity=True, colors=True, ignore_missing_fields=True)
    expected = np.column_stack([theirs[f"cartesian{axis}"] for axis in "XYZ"])
    assert np.abs(cloud_of(tmp_path / "a.e57").points - expected).max() < 1e-8


def test_damaged_files_raise_input_error(tmp_path: Path) -> None:
    make(tmp_path / "a.e57")
    content = (tmp_path / "a.e57").read_bytes()
    path = tmp_path / "bad.e57"
    for n in range(8, len(content), 4001):
        path.write_bytes(content[:n])
        with pytest.raises(InputError, match=r"bad\.e57"):
            read_model(path)
    rng = np.random.default_rng(1)
    for _ in range(100):
        bad = bytearray(content)
        for at in rng.integers(8, len(bad), 2):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            read_model(path)
        except InputError:
            continue


def test_reading_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    make(tmp_path / "a.e57")
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        read_model(tmp_path / "a.e57", SilentProgress(token))
