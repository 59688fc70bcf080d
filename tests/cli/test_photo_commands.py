"""`vomstudio check`, `plan`, `frames`, and `info` of a folder of photos."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.io.photos import photo_maker
from tests.messages import shown_codes, shown_values
from tests.photogrammetry.surface import wall_maker as wall
from vomstudio.photogrammetry.survey.check_results import ADVICE
from vomstudio.photogrammetry.survey.video import UNCHANGED

SPECIMENS = Path(__file__).parents[1] / "specimens"


@pytest.mark.full
def test_check_reports_all_documented_fields(run, tmp_path: Path) -> None:
    wall.write_set(tmp_path, wall.good_stations()[:4])
    (tmp_path / "broken.jpg").write_bytes(b"\xff\xd8\xff")
    ran = run("check", tmp_path, "--distance", 8, "--json")
    assert ran.code == 0
    found = ran.json
    assert found.keys() >= {"photos", "findings", "verdict"}
    assert [photo["name"] for photo in found["photos"]] == [f"w0{i}.jpg" for i in range(4)]
    for photo in found["photos"]:
        assert photo.keys() >= {"name", "gsd_m", "blur", "views"}
        # 8 m over 720 px.
        assert photo["gsd_m"] == pytest.approx(8 / 720)
    for finding in found["findings"]:
        assert {"code", "severity", "photos", "message", "value"} <= set(finding)
        assert finding["severity"] in ("info", "warning", "error")
    assert "few-photos" in [finding["code"] for finding in found["findings"]]
    assert found["skipped"][0]["name"] == "broken.jpg"
    plain = run("check", tmp_path)
    assert shown_values(plain.out, "few-photos") == {"count": "4"}
    assert ADVICE["few-photos"] in plain.out
    assert "broken.jpg" in plain.err


@pytest.mark.full
def test_check_also_examines_an_alignment(run, tmp_path: Path) -> None:
    from tests.photogrammetry.align.test_scene_check import scene, view

    wall.write_set(tmp_path / "photos", wall.good_stations()[:3])
    views = [view(f"w0{i}.jpg", *s) for i, s in enumerate(wall.good_stations()[:2])]
    (tmp_path / "aligned").mkdir()
    scene(views).save(tmp_path / "aligned")
    ran = run("check", tmp_path / "photos", "--scene", tmp_path / "aligned", "--json")
    codes = {f["code"]: f for f in ran.json["aligned"]["findings"]}
    assert codes["unregistered"]["photos"] == ["w02.jpg"]
    ran = run("check", tmp_path / "photos", "--scene", tmp_path / "photos")
    assert ran.code == 2
    assert "alignment" in ran.said


@pytest.mark.parametrize("distance", ["0", "-3", "nan", "inf", "far"])
def test_check_refuses_invalid_distances(run, tmp_path: Path, distance: str) -> None:
    ran = run("check", tmp_path, "--distance", distance)
    assert ran.code == 2
    assert "--distance" in ran.said


def test_check_without_photos_is_refused(run, tmp_path: Path) -> None:
    assert "photo.none" in shown_codes(run("check", tmp_path).said)
    assert "folder.missing" in shown_codes(run("check", tmp_path / "missing").said)
    failed = run("check", tmp_path, "--json")
    assert (failed.code, failed.json["error"]["code"]) == (2, "photo.none")
    (tmp_path / "a.jpg").write_bytes(b"")
    failed = run("check", tmp_path, "--json")
    assert failed.json["error"]["code"] == "photo.none-usable"


def test_check_reports_progress_as_events(run, tmp_path: Path) -> None:
    import json

    wall.write_set(tmp_path, wall.good_stations()[:2])
    ran = run("check", tmp_path, "--json", "--progress", "json")
    events = [json.loads(line) for line in ran.err.splitlines()]
    stages = [e["stage"] for e in events if e["event"] == "stage"]
    assert stages == ["Reading photos", "Measuring photo quality", "Matching photos"]


def test_plan_reports_all_documented_fields(run) -> None:
    words = ("plan", "--camera", "24x16,24,6000x4000", "--distance", 20, "--width", 30)
    found = run(*words, "--height", 10, "--json").json
    assert found["gsd_m"] == pytest.approx(20 / 6000)
    assert found["footprint_m"] == pytest.approx([20, 40 / 3])
    assert found["spacing_m"] == pytest.approx([6, 4])
    assert found["smallest_plane_m"] == pytest.approx(20 / 6)
    near, far = found["depth_of_field_m"]
    assert near < 20
    assert far is None or far > 20
    assert found["photos"] == len(found["positions"])
    wanted = run(*words[:3], "--gsd", 0.002, "--width", 30, "--height", 10, "--json").json
    assert wanted["distance_m"] == pytest.approx(12)


def test_plan_derives_distance_from_smallest_plane(run) -> None:
    words = ("plan", "--camera", "24x16,24,6000x4000", "--plane", 2, "--width", 30, "--height", 10)
    found = run(*words, "--json").json
    assert found["distance_m"] == pytest.approx(12.0)
    assert found["smallest_plane_m"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    "camera", [["NIKON", "D90", "--focal", "35"], ["Air 2S"], ["24", "24", "6000", "4000"]]
)
def test_plan_accepts_camera_in_every_form(run, camera: list[str]) -> None:
    ran = run("plan", "--distance", 20, "--width", 30, "--height", 10, "--camera", *camera)
    assert ran.code == 0
    assert "GSD" in ran.out


def test_plan_uses_camera_of_photo_and_writes_sheet(run, tmp_path: Path) -> None:
    photo = photo_maker.write_photo(
        tmp_path / "a.jpg", (400, 300), exif={0xA405: photo_maker.short(36)}
    )
    sheet = tmp_path / "sheet.html"
    words = ("plan", "--camera", photo, "--distance", 4, "--width", 9, "--height", 3, "-o", sheet)
    found = run(*words, "--json").json
    assert found["gsd_m"] == pytest.approx(0.01)
    assert found["sheet"] == str(sheet)
    assert sheet.stat().st_size > 10_000
    again = run(*words)
    assert again.code == 2
    assert "--force" in again.said
    assert run(*words, "--force").code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--camera", "Kodak Brownie", "--distance", "3"], "not in the list of cameras"),
        (["--camera", "NIKON D90", "--distance", "3"], "--focal"),
        (["--camera", "1,2", "--distance", "3"], "23.5x15.6"),
        (["--camera", "Air 2S"], "--distance, --gsd, --plane"),
        (["--camera", "Air 2S", "--distance", "0"], "--distance"),
        (["--camera", "Air 2S", "--distance", "3", "-o", "a.doc"], ".pdf"),
        (["--distance", "3"], "--camera"),
    ],
)
def test_plan_refuses_invalid_input_in_one_sentence(run, words: list[str], said: str) -> None:
    ran = run("plan", "--width", 30, "--height", 10, *words)
    assert ran.code == 2
    assert said in ran.said


def test_frames_are_extracted_and_counted(run, tmp_path: Path) -> None:
    from tests.photogrammetry.survey.test_video import film

    video = film(tmp_path / "a.avi", [*np.arange(40) * 12.0, *[468.0] * 20])
    ran = run("frames", video, "-o", tmp_path / "out", "--json")
    assert ran.code == 0
    found = ran.json
    assert len(found["frames"]) == 4
    assert all(Path(frame).is_file() for frame in found["frames"])
    assert found["skipped"] == {UNCHANGED: 2}
    assert "video.not-good-enough" in shown_codes(found["verdict"])
    # They are photos like any other.
    assert run("info", tmp_path / "out", "--json").json["files"][0]["photos"] == 4


def test_frames_of_invalid_video_are_refused(run, tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"no video")
    for words in (
        ("frames", tmp_path / "a.mp4", "-o", tmp_path / "o"),
        ("frames", tmp_path / "b.mp4", "-o", tmp_path / "o"),
    ):
        ran = run(*words)
        assert ran.code == 2
        assert ran.said
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]


def test_info_counts_cameras_positions_and_masks(run, data_dir: Path) -> None:
    (found,) = run("info", data_dir / "panel17", "--json").json["files"]
    assert (found["kind"], found["photos"], found["used"]) == ("photos", 28, 28)
    assert (found["with_gps"], found["with_masks"]) == (5, 28)
    assert [camera["photos"] for camera in found["cameras"]] == [22, 6]
    assert "HUAWEI" in run("info", data_dir / "panel17").out


@pytest.mark.full
def test_check_accepts_folder_of_reconstructed_model(run) -> None:
    photos = SPECIMENS / "photos"
    made = SPECIMENS / "schema1.vom" / "reconstruction" / "photos-preview"
    (frame,) = (made / "work").glob("frame-*")
    found = [run("check", photos, "--scene", each, "--json").json for each in (made, frame)]
    assert found[0]["aligned"]["photos"]
    assert found[0] == found[1]
