"""Files whose names are not UTF-8, as Linux lets them be, are read as any other."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.photogrammetry.survey.test_video import film
from vomstudio.core.files.names import utf8_name
from vomstudio.io.gis.raster import read_size_and_bands
from vomstudio.io.models.opening import read_model
from vomstudio.photogrammetry.survey.video import take_frames

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="other systems have no names that are not Unicode"
)


def odd(path: Path) -> Path:
    """The same file under a name in Latin 1."""
    name = os.fsencode(path.parent) + b"/Gel\xe4nde" + os.fsencode(path.suffix)
    shutil.move(path, name)
    return Path(os.fsdecode(name))


def test_utf8_name_is_unchanged(tmp_path: Path) -> None:
    with utf8_name(tmp_path / "Gelände.tif") as named:
        assert named == tmp_path / "Gelände.tif"


def test_height_raster_with_non_utf8_name_is_read(tmp_path: Path) -> None:
    import rasterio

    path = tmp_path / "a.tif"
    transform = rasterio.Affine(2, 0, 500_000, 0, -2, 200_000)
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=5,
        height=4,
        count=1,
        crs="EPSG:32633",
        dtype="float32",
        transform=transform,
    ) as dataset:
        dataset.write(np.arange(20, dtype="float32").reshape(4, 5), 1)
    path = odd(path)
    loaded = read_model(path)
    assert loaded.path == path
    assert (len(loaded.data.vertices), loaded.crs) == (20, "EPSG:32633")
    assert read_size_and_bands(path) == (5, 4, ["F"])


@pytest.mark.parametrize("ending", ["obj", "ply", "stl", "glb", "xyz", "las"])
def test_every_model_format_with_non_utf8_name_is_read(tmp_path: Path, ending: str) -> None:
    import laspy
    import trimesh

    path = tmp_path / f"a.{ending}"
    if ending == "xyz":
        np.savetxt(path, np.eye(3))
    elif ending == "las":
        las = laspy.create(point_format=6)
        las.x = las.y = las.z = np.arange(5.0)
        las.write(path)
    else:
        trimesh.creation.box().export(path)
    assert len(read_model(odd(path)).data.bounds) == 2


@pytest.mark.full
def test_video_with_non_utf8_name_is_read(tmp_path: Path) -> None:
    path = odd(film(tmp_path / "pan.avi", np.arange(100) * 12.0))
    report = take_frames(path, tmp_path / "out", fps=2)
    assert len(report.frames) == 10
    assert all(frame.name.startswith("Gelände_") for frame in report.frames)
