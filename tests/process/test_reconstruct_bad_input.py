"""Whatever is wrong with photos, tables or folders: a sentence, and what can be done is done."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.messages import messages, shown_codes
from tests.photogrammetry import photo_set, rock_face
from tests.process.reconstruction_runs import End, reconstruct, refused, whole
from tests.small_disk import small_disk
from vomstudio.cli import main
from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.progress import InlineExecutor, SilentProgress
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.pipeline.reconstruction import reconstruct as reconstruct_here


def here(photos: Path, out: Path, **settings: object) -> VomError:
    """What the work is refused with, in this process."""
    with pytest.raises(VomError) as caught:
        reconstruct_here(
            photos, out, PipelineSettings("preview", **settings), InlineExecutor(), SilentProgress()
        )  # type: ignore[arg-type]
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)
    return caught.value


def words(*given: object) -> dict[str, Any]:
    """The error of a command line that is refused before any work."""
    stdout, stderr = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(stdout), contextlib.redirect_stderr(stderr):
        code = main(["reconstruct", *map(str, given), "--json"])
    return refused(End(code, json.loads(stdout.getvalue()), stderr.getvalue()))


def only(photos: Path, folder: Path, *numbers: int) -> Path:
    folder.mkdir()
    for number in numbers:
        shutil.copy(photos / f"photo {number}.jpg", folder)
    return folder


# --- photos ------------------------------------------------------------------------------------
@pytest.mark.full
def test_folders_without_enough_photos_are_reported_and_write_nothing(
    photos: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert here(only(photos, tmp_path / "none"), out).code == "photo.none"
    one = only(photos, tmp_path / "one", 1)
    assert here(one, out).code == "alignment.too-few-photos"
    shutil.copy(one / "photo 1.jpg", one / "copy.jpg")
    codes = shown_codes(here(one, out).message)
    assert {"alignment.too-few-photos", "photo.duplicate"} <= codes
    (one / "copy.jpg").write_bytes((photos / "photo 2.jpg").read_bytes()[:9000])
    said = here(one, out).message
    assert "copy.jpg" in said
    assert "photo.truncated" in shown_codes(said)
    assert not out.exists()


def test_missing_or_invalid_photo_folder_is_rejected_on_the_command_line(
    photos: Path, tmp_path: Path
) -> None:
    for path in (tmp_path / "gone", photos / "photo 1.jpg"):
        error = words(path, "-o", tmp_path / "out")
        assert (error["code"], error["file"]) == ("folder.not-of-photos", str(path))


def test_photos_without_overlap_are_reported_with_the_match_count(
    photos: Path, tmp_path: Path
) -> None:
    two = only(photos, tmp_path / "two", 1)
    noise = np.random.default_rng(5).integers(0, 255, (240, 320, 3), np.uint8)
    Image.fromarray(noise).save(two / "b.jpg")
    error = here(two, tmp_path / "out")
    assert error.code == "unmatched"
    assert error.values["least"] > error.values["matches"]
    assert error.file == str(two)


def test_featureless_photos_are_reported(tmp_path: Path) -> None:
    folder = tmp_path / "grey"
    folder.mkdir()
    for name, value in (("a.png", 90), ("b.png", 120)):
        Image.fromarray(np.full((240, 320), value, np.uint8)).save(folder / name)
    said = here(folder, tmp_path / "out").message
    assert "alignment.photo-without-features" in shown_codes(said)
    assert "a.png" in said


@pytest.mark.full
def test_two_photos_make_a_model(photos: Path, tmp_path: Path) -> None:
    end = reconstruct(only(photos, tmp_path / "two", 1, 2), tmp_path / "out")
    assert end.code == 0, end.err
    assert (end.json["photos"], end.json["registered"]) == (2, 2)
    whole(tmp_path / "out")


@pytest.fixture
def mixed(photos: Path, tmp_path: Path) -> Path:
    """Six good photos of several sizes and orientations, and what else lies about in folders."""
    folder = only(photos, tmp_path / "mixed", 1, 2, 3, 4)
    face, views = rock_face.rough_face(9.0, 6.0, 0.03), photo_set.views()
    upright = rock_face.photograph(face, views[4], seed=5)
    turned = np.ascontiguousarray(np.rot90(upright))
    Image.fromarray(turned).save(folder / "photo 5.jpg", quality=95)
    lens = views[5].intrinsics.scaled(480, 360)
    larger = View(views[5].name, lens, views[5].rotation, views[5].translation)
    Image.fromarray(rock_face.photograph(face, larger, seed=6)).save(folder / "photo 6.png")
    good = (photos / "photo 6.jpg").read_bytes()
    (folder / "cut off.jpg").write_bytes(good[:20000])
    (folder / "scrambled.jpg").write_bytes(good[:3000] + os.urandom(5000) + good[-2:])
    (folder / "no picture.jpg").write_bytes(b"\xff\xd8\xff\xe0 nothing")
    (folder / "empty.jpg").touch()
    (folder / "cut off.png").write_bytes((folder / "photo 6.png").read_bytes()[:30000])
    shutil.copy(folder / "photo 1.jpg", folder / "photo 1 again.jpg")
    (folder / "notes.txt").write_text("north face")
    (folder / "raw.nef").write_bytes(b"raw")
    Image.new("L", (100, 100), 255).save(folder / "photo 2_mask.png")
    sky = np.full((240, 320), 255, np.uint8)
    sky[:20] = 0
    Image.fromarray(sky).save(folder / "photo 3_mask.png")
    return folder


@pytest.mark.full
def test_problems_with_some_photos_do_not_stop_the_others(mixed: Path) -> None:
    """And the model may lie in the photos' own folder, without being taken for photos."""
    out = mixed / "model"
    end = reconstruct(mixed, out)
    assert end.code == 0, end.err
    assert "Traceback" not in end.err
    assert end.json["registered"] >= 5
    said = "\n".join(messages(end.json))
    for name in (
        "cut off.jpg",
        "no picture.jpg",
        "empty.jpg",
        "cut off.png",
        "photo 1 again.jpg",
        "raw.nef",
    ):
        assert name in said, name
    assert "mask.other-shape" in shown_codes(said)
    assert "notes.txt" not in said
    whole(out)
    before = end.json["photos"]
    again = reconstruct(mixed, out)
    assert again.code == 0, again.err
    assert again.json["photos"] == before
    assert again.json["registered"] == end.json["registered"]


@pytest.mark.slow
def test_photos_of_100_megapixels_stay_within_laptop_memory(photos: Path, tmp_path: Path) -> None:
    folder = tmp_path / "large"
    folder.mkdir()
    for number in (1, 2, 3, 4):
        with Image.open(photos / f"photo {number}.jpg") as image:
            exif = image.info["exif"]
            image.resize((11648, 8736), Image.Resampling.BICUBIC).save(
                folder / f"{number}.jpg", quality=85, exif=exif
            )
    end = reconstruct(folder, tmp_path / "out")
    assert end.code == 0, end.err
    assert end.json["registered"] == 4
    assert end.json["peak_memory_mb"] < 4000


# --- folders for the model ----------------------------------------------------------------------
def test_photos_are_not_overwritten(photos: Path, tmp_path: Path) -> None:
    for folder in (photos, photos / ".." / photos.name):
        assert words(photos, "-o", folder)["code"] == "folder.of-photos"
    own = only(photos, tmp_path / "own", 1, 2)
    assert here(own, own).code == "folder.not-empty"
    assert here(own, tmp_path).code == "folder.not-empty"


def test_unrelated_folders_are_left_untouched(photos: Path, tmp_path: Path) -> None:
    full = tmp_path / "full"
    full.mkdir()
    (full / "thesis.docx").touch()
    error = here(photos, full)
    assert isinstance(error, TargetError)
    assert error.code == "folder.not-empty"
    assert [p.name for p in full.iterdir()] == ["thesis.docx"]
    (tmp_path / "file").touch()
    assert here(photos, tmp_path / "file").code == "folder.is-file"
    assert here(photos, tmp_path / "file" / "below").code == "folder.is-file"
    error = here(photos, tmp_path / ("x" * 300))
    assert (error.code, error.values["reason"]) == (
        "folder.not-created",
        os.strerror(errno.ENAMETOOLONG),
    )


def test_read_only_disk_is_reported(photos: Path, tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as disk:
        (disk / "empty").mkdir()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        for out in (disk / "new", disk / "empty"):
            error = here(photos, out)
            assert isinstance(error, TargetError)
            assert "read-only" in error.message


@pytest.mark.full
def test_photo_that_disappears_during_the_run_is_reported(photos: Path, tmp_path: Path) -> None:
    folder = only(photos, tmp_path / "going", 1, 2, 3)

    class Vanishing(SilentProgress):
        def stage(self, name: str, total: int | None = None) -> None:
            if name == "Undistorting photos":
                (folder / "photo 2.jpg").unlink()

    with pytest.raises(InputError) as caught:
        reconstruct_here(
            folder, tmp_path / "out", PipelineSettings("preview"), InlineExecutor(), Vanishing()
        )
    assert caught.value.code == "reconstruct.photo-lost"
    assert "photo 2.jpg" in str(caught.value.file)


# --- settings and tables --------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("given", "code"),
    [
        (("--crs", "nonsense"), "frame.unknown-crs"),
        (("--crs", "EPSG:4326"), "frame.not-projected"),
        (("--crs", "EPSG:2229"), "frame.not-in-metres"),
        (("--threads", "0"), "option.out-of-range"),
        (("--threads", "many"), "number.not-whole"),
        (("--seed", "x"), "number.not-whole"),
        (("--quality", "best"), "option.not-a-choice"),
        (("--marks", "gone.csv"), "file.missing"),
        (("--gcp", "gone.csv"), "file.missing"),
    ],
)
def test_invalid_settings_are_reported_with_their_option(
    photos: Path, tmp_path: Path, given: tuple[str, str], code: str
) -> None:
    error = words(photos, "-o", tmp_path / "out", *given)
    assert (error["code"], error["field"]) == (code, given[0])
    assert not (tmp_path / "out").exists()


def test_crs_without_located_photos_is_rejected_before_the_work(
    photos: Path, tmp_path: Path
) -> None:
    error = here(photos, tmp_path / "out", crs="EPSG:32633")
    assert error.code == "gps-few"
    assert (error.values["value"], error.values["total"]) == (0, 6)
    assert not (tmp_path / "out").exists()


GOOD = "label,x,y,z\na,0,0,0\nb,1,0,0\nc,0,0,1\n"


@pytest.mark.parametrize(
    ("control", "marks", "file", "said"),
    [
        ("", "label,photo,x,y\na,photo 1.jpg,1,1\n", "control.csv", ""),
        ("1,2,3\n", "label,photo,x,y\na,photo 1.jpg,1,1\n", "control.csv", "header"),
        ("label,x,y\na,0,0\n", "label,photo,x,y\na,photo 1.jpg,1,1\n", "control.csv", "z"),
        (
            "label,x,y,z\na,0,zero,0\n",
            "label,photo,x,y\na,photo 1.jpg,1,1\n",
            "control.csv, line 2",
            "not a number",
        ),
        (GOOD, "", "marks.csv", ""),
        (GOOD, "label,photo,x,y\n", "marks.csv", "no marks"),
        (GOOD, "label,photo,x,y\na,photo 1.jpg,here,1\n", "marks.csv, line 2", "not a number"),
    ],
)
def test_unreadable_control_tables_are_rejected_before_the_work(
    photos: Path, tmp_path: Path, control: str, marks: str, file: str, said: str
) -> None:
    (tmp_path / "control.csv").write_text(control)
    (tmp_path / "marks.csv").write_text(marks)
    error = here(
        photos,
        tmp_path / "out",
        control=tmp_path / "control.csv",
        marks=tmp_path / "marks.csv",
    )
    assert file in str(error)
    assert said in str(error)
    assert not (tmp_path / "out").exists()


def test_too_few_control_points_are_reported_before_the_work(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "control.csv").write_text(GOOD)
    (tmp_path / "marks.csv").write_text(
        "label,photo,x,y\n" + "".join(f"{k},photo {n}.jpg,5,5\n" for k in "ab" for n in (1, 2))
    )
    error = here(
        photos,
        tmp_path / "out",
        control=tmp_path / "control.csv",
        marks=tmp_path / "marks.csv",
    )
    assert error.code == "control.too-few"
    assert (error.values["count"], error.values["least"]) == (2, 3)
    assert not (tmp_path / "out").exists()


def test_control_without_marks_requests_the_marks_option(photos: Path, tmp_path: Path) -> None:
    (tmp_path / "points.xml").write_text(
        "<DicoAppuisFlottant><OneAppuisDAF><Pt>0 0 0</Pt><NamePt>a</NamePt></OneAppuisDAF>"
        "</DicoAppuisFlottant>"
    )
    error = words(photos, "-o", tmp_path / "out", "--gcp", tmp_path / "points.xml")
    assert error["code"] == "control.marks-missing"
    assert "--marks" in error["message"]


def test_marks_in_missing_photos_are_rejected_with_the_photo_names(
    photos: Path, tmp_path: Path
) -> None:
    (tmp_path / "control.csv").write_text(GOOD)
    (tmp_path / "marks.csv").write_text(
        "label,photo,x,y\n" + "".join(f"{k},other.jpg,5,5\n" for k in "abc")
    )
    said = str(
        here(
            photos,
            tmp_path / "out",
            control=tmp_path / "control.csv",
            marks=tmp_path / "marks.csv",
        )
    )
    assert "other.jpg" in said
