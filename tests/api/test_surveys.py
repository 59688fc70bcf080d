"""Photos, checks and plans against the commands."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest

import vomstudio as vs
from tests.messages import refused
from vomstudio.cli.common.output import to_json

PHOTOS = vs.sample("photos")


@pytest.fixture
def three(tmp_path: Path) -> Path:
    folder = tmp_path / "three"
    folder.mkdir()
    for photo in sorted(PHOTOS.glob("*.jpg"))[:3]:
        shutil.copy(photo, folder)
    return folder


def test_photos_match_info_command(command: Any) -> None:
    (told,) = command("info", PHOTOS)["files"]
    found = vs.read_photos(PHOTOS)
    assert len(found.photos) == told["used"]
    assert found.photos[0].focal_px == pytest.approx(told["cameras"][0]["focal_px"])
    assert "photos" in repr(found)
    with refused("folder.missing", file="gone"):
        vs.read_photos("gone")


@pytest.mark.full
def test_check_matches_command_output(command: Any, three: Path) -> None:
    told = command("check", three, "--distance", 15)
    seen: list[str] = []
    found = vs.check(three, distance_m=15, progress=lambda stage, done, total: seen.append(stage))
    assert json.loads(to_json(found.to_dict())) == told
    assert found.verdict == told["verdict"]
    assert [photo.name for photo in found.photos] == [photo["name"] for photo in told["photos"]]
    assert "Measuring photo quality" in seen
    with refused("option.not-a-length", vs.errors.UsageError, field="distance_m", value=-1):
        vs.check(three, distance_m=-1)


def test_plan_matches_command_output(command: Any, tmp_path: Path) -> None:
    words = ["--camera", "23.5x15.6,35,6000x4000", "--distance", 20, "--width", 30, "--height", 10]
    told = command("plan", *words, "-o", tmp_path / "told.svg")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = vs.plan(
            "23.5x15.6,35,6000x4000",
            distance_m=20,
            width_m=30,
            height_m=10,
            sheet=tmp_path / "own.svg",
        )
    assert json.loads(to_json(found.to_dict())) == {k: v for k, v in told.items() if k != "sheet"}
    assert found.photos == told["photos"]
    assert [station.to_dict() for station in found.positions] == told["positions"]
    assert (tmp_path / "own.svg").is_file()


@pytest.mark.parametrize(
    "more",
    [
        {"distance_m": -3},
        {"distance_m": "far"},
        {"overlap": 0.2, "distance_m": 20},
        {},
        {"distance_m": 20, "manner": "kite"},
    ],
)
def test_invalid_plans_are_refused(more: Any) -> None:
    with pytest.raises(vs.errors.VomError):
        vs.plan("23.5x15.6,35,6000x4000", width_m=30, height_m=10, **more)


def test_unknown_camera_is_refused() -> None:
    with refused("plan.unknown-camera", vs.errors.UsageError, camera="Brownie", field="camera"):
        vs.plan("Brownie", distance_m=3, width_m=9, height_m=3)


def test_plan_without_distance_reports_required_arguments() -> None:
    arguments = ("distance_m", "gsd_m", "plane_m")
    with refused("option.none-given", vs.errors.UsageError, options=arguments, field="distance_m"):
        vs.plan("23.5x15.6,35,6000x4000", width_m=30, height_m=10)
