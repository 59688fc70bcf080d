"""The sample outcrop is read as it is written, and damage to it is said with the file's name."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.paths import resource
from vomstudio.geology.orientation import Line, Plane
from vomstudio.io.photos.cameras_file import find_photos, read_cameras
from vomstudio.project.sample import (
    read_picks,
    read_true_cameras,
    read_truth,
    sample_control,
    sample_marks,
    sample_model,
    sample_photos,
)

CAMERAS = (
    "# x\nname,x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33,width,height,fx,fy,cx,cy,k1,k2,p1,p2\n"
    "a.jpg,100.5,200.25,-3.5,0,1,0,0,0,1,1,0,0,60,40,50,51,30,20,.1,.2,.3,.4\n"
    "b.jpg,102.5,199.25,-1.5,1,0,0,0,1,0,0,0,1,60,40,50,51,30,20,.1,.2,.3,.4\n"
)
PICKS = (
    "pick,kind,set,horizon,x,y,z\n"
    "A,bedding,west,H1,1,2,3\nA,bedding,west,H1,4,5,6\nB,fault,main,,7,8,9\nA,joint,J1,,1,1,1\n"
)
TRUTH = (
    "# x\nname,kind,dip_direction_deg,dip_deg,trend_deg,plunge_deg,length_m\n"
    "A,bedding,315.5,38.25,,,\nfold axis,line,,,46.5,12.25,\nbedding and fault,line,,,200.5,30.5,\n"
    "displacement,,,,,,2.75\n"
)


def rows(name: str) -> list[dict[str, str]]:
    lines = resource("sample", name).read_text("utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_true_cameras_are_read_with_positions_and_directions(tmp_path: Path) -> None:
    found = read_true_cameras(written(tmp_path, CAMERAS))
    # Metres of which floats keep every digit: a whole metre below everything, not the first photo.
    assert found.origin == (100, 199, -4)
    assert (found.crs, found.photos) == ("EPSG:32633", sample_photos())
    first, second = found.views
    assert (first.name, second.name) == ("a.jpg", "b.jpg")
    np.testing.assert_allclose(first.centre + found.origin, (100.5, 200.25, -3.5), atol=1e-12)
    np.testing.assert_allclose(second.centre + found.origin, (102.5, 199.25, -1.5), atol=1e-12)
    np.testing.assert_array_equal(first.rotation, [[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    lens = first.intrinsics
    assert (lens.model, lens.width, lens.height) == ("OPENCV", 60, 40)
    assert tuple(lens.params) == (50, 51, 30, 20, 0.1, 0.2, 0.3, 0.4)


def test_sample_cameras_match_the_sample_photos() -> None:
    found = read_true_cameras()
    told = rows("cameras_truth.csv")
    assert [view.name for view in found.views] == [row["name"] for row in told]
    assert found.is_scaled
    for view, row in zip(found.views, told, strict=True):
        assert (sample_photos() / view.name).is_file()
        np.testing.assert_allclose(
            view.centre + found.origin, [float(row[a]) for a in "xyz"], atol=1e-6
        )


def test_sample_model_folder_contains_its_cameras() -> None:
    """`write_cameras(path, replace(read_true_cameras(), photos=Path("photos")))` renews them."""
    path = sample_model().with_name("cameras.json")
    beside, told = read_cameras(path), read_true_cameras()
    assert find_photos(beside, path) == sample_photos()
    assert (beside.crs, beside.is_scaled, beside.origin) == (told.crs, told.is_scaled, told.origin)
    for view, true in zip(beside.views, told.views, strict=True):
        assert (view.name, view.intrinsics) == (true.name, true.intrinsics)
        np.testing.assert_allclose(view.centre, true.centre, atol=1e-9)
        np.testing.assert_allclose(view.rotation, true.rotation, atol=1e-12)


def test_picks_are_split_where_the_name_changes(tmp_path: Path) -> None:
    found = read_picks(written(tmp_path, PICKS))
    assert found.names == ("A", "B", "A")
    assert found.kinds == ("bedding", "fault", "joint")
    assert found.sets == ("west", "main", "J1")
    assert found.horizons == ("H1", "", "")
    assert found.offsets.tolist() == [0, 2, 3, 4]
    assert [found.of(i).tolist() for i in range(3)] == [
        [[1, 2, 3], [4, 5, 6]],
        [[7, 8, 9]],
        [[1, 1, 1]],
    ]


def test_all_sample_picks_are_read() -> None:
    found = read_picks()
    told = rows("picks.csv")
    assert len(found.points) == len(told)
    assert len(found.names) == len(set(found.names)) == len({row["pick"] for row in told})
    assert found.points[0].tolist() == [float(told[0][axis]) for axis in "xyz"]


def test_true_planes_are_keyed_by_pick_name(tmp_path: Path) -> None:
    found = read_truth(written(tmp_path, TRUTH))
    assert found.planes == {"A": Plane(315.5, 38.25)}
    assert (found.axis, found.intersection) == (Line(46.5, 12.25), Line(200.5, 30.5))
    assert found.displacement_m == 2.75
    picks = read_picks()
    assert set(picks.names) <= set(read_truth().planes)


@pytest.mark.parametrize(
    ("read", "text"),
    [(read_true_cameras, CAMERAS), (read_picks, PICKS), (read_truth, TRUTH)],
)
def test_damaged_sample_file_is_reported_by_name(
    tmp_path: Path, read: Callable[[Path], Any], text: str
) -> None:
    head, *lines = [line for line in text.splitlines() if not line.startswith("#")]
    cut = ",".join(lines[-1].split(",")[:3])
    for bad in (
        head.replace("name", "label").replace("pick", "label") + "\n" + "\n".join(lines),
        "\n".join([head, *lines[:-1], cut]),
        "\n".join([head, lines[0].replace("2", "two").replace("8", "eight"), *lines[1:]]),
    ):
        with refused("sample.damaged") as caught:
            read(written(tmp_path, bad))
        assert "table.csv" in str(caught.value)


def test_all_sample_files_exist() -> None:
    for path in (sample_model(), sample_control(), sample_marks()):
        assert path.is_file()
    assert sample_model().name == "sample.obj"
    assert [path.name for path in (sample_control(), sample_marks())] == [
        "control.csv",
        "marks.csv",
    ]
    assert len(list(sample_photos().glob("*.jpg"))) == len(read_true_cameras().views)
