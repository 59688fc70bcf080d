"""Results of reconstructions, and the tables and masks beside photos, become records."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.messages import refused
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.project.imports.sidecar_import import (
    fallback_folder,
    read_sidecars,
    sidecar_tables,
    stored_path,
)
from vomstudio.project.reconstructions import RECONSTRUCTIONS, read_reconstruction
from vomstudio.project.records import ReconstructionRecord

CRS = "EPSG:32633"
POINTS = [
    ControlPoint("P1", (1.0, 2.0, 3.0), 0.01),
    ControlPoint("P2", (4.0, 5.0, 6.0), None, True),
]
MARKS = [Mark("P1", "a.jpg", 1.5, 2.5), Mark("tie", "a.jpg", 3.5, 4.5)]
RESULT: dict[str, Any] = {
    "photos": 3,
    "registered": 2,
    "reprojection_error_px": 0.25,
    "frame": CRS,
    "scaled": True,
    "settings": {"quality": "preview", "seed": 0, "crs": None},
    "versions": {"vomstudio": "0.1.0"},
    "registration": {
        "method": "ground control points",
        "rotation_error_deg": {"about_up": 0.1, "about_east": 0.2, "about_north": 0.3},
        "scale_error": 0.004,
        "rms_control_m": 0.05,
        "rms_check_m": 0.06,
    },
}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "a.vom").mkdir()
    return tmp_path / "a.vom"


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """A folder with two photos, the mask of one, and both tables."""
    folder = tmp_path / "cliff"
    folder.mkdir()
    for name in ("a.jpg", "b.jpg"):
        Image.fromarray(np.full((40, 60, 3), 90, np.uint8)).save(folder / name)
    Image.fromarray(np.full((40, 60), 255, np.uint8)).save(folder / "a_mask.png")
    tables(folder)
    return folder


def tables(folder: Path, points: list[ControlPoint] = POINTS) -> tuple[Path, Path]:
    folder.mkdir(parents=True, exist_ok=True)
    write_control(folder / "control.csv", points, CRS)
    write_marks(folder / "marks.csv", MARKS)
    return folder / "control.csv", folder / "marks.csv"


def reconstruct(
    project: Path, photos: Path, name: str = "cliff-preview", result: Any = RESULT, **more: Any
) -> Path:
    folder = project / RECONSTRUCTIONS / name
    folder.mkdir(parents=True)
    (folder / "request.json").write_text(json.dumps({"photos": str(photos), **more}))
    if result is not None:
        (folder / "reconstruction.json").write_text(json.dumps(result))
    return folder


# --- the result of a run -------------------------------------------------------------------------
def test_reconstruction_result_fields_are_recorded(project: Path, photos: Path) -> None:
    folder = reconstruct(project, photos)
    os.utime(folder / "reconstruction.json", (1_770_112_800, 1_770_112_800))
    made, placed = read_reconstruction(folder, "s", "cliff")
    data = (folder / "reconstruction.json").read_bytes()
    assert made == ReconstructionRecord(
        made.id,
        "s",
        "cliff",
        "cliff-preview",
        "preview",
        hashlib.sha256(data).hexdigest(),
        (("quality", "preview"), ("seed", "0"), ("crs", "")),
        3,
        2,
        0.25,
        "0.1.0",
        "2026-02-03T10:00:00+00:00",
    )
    assert placed == Registration(
        placed.id,
        placed.name,
        "control",
        Frame("crs", CRS),
        reconstruction_id=made.id,
        rotation_error_deg=(0.1, 0.2, 0.3),
        scale_error=0.004,
        rms_control_m=0.05,
        rms_check_m=0.06,
    )
    assert placed.name.endswith(", cliff")
    assert len({made.id, placed.id, read_reconstruction(folder, "s", "cliff")[0].id}) == 3


@pytest.mark.parametrize(
    ("said", "method", "frame"),
    [
        ({"registration": {"method": "camera positions (GPS)"}}, "gps", Frame("crs", CRS)),
        ({"registration": {}, "frame": "local"}, "local", Frame("local")),
        ({"registration": None, "frame": "local", "scaled": False}, "local", Frame()),
        ({"registration": [], "frame": None}, "local", Frame("local")),
        ({"registration": {"method": 5}, "frame": 5, "scaled": False}, "local", Frame()),
    ],
)
def test_registration_frame_claims_only_determined_north_up_and_scale(
    project: Path, photos: Path, said: dict[str, Any], method: str, frame: Frame
) -> None:
    """North, up and metres are claimed only where they were found."""
    folder = reconstruct(project, photos, result=RESULT | said)
    _, placed = read_reconstruction(folder, "s", "cliff")
    assert (placed.method, placed.frame) == (method, frame)
    assert placed.name.endswith(", cliff")
    words = {"gps": "GPS of the cameras", "local": "photos only"}
    assert placed.name.startswith(words[method])


@pytest.mark.parametrize(
    "errors",
    [None, [], {"about_up": 0.1, "about_east": 0.2}]
    + [
        {"about_up": 0.1, "about_east": 0.2, "about_north": 0.3, axis: bad}
        for axis, bad in (("about_up", None), ("about_east", "x"), ("about_north", float("nan")))
    ],
)
def test_partly_unknown_rotation_error_is_unknown(project: Path, photos: Path, errors: Any) -> None:
    said = RESULT["registration"] | {
        "rotation_error_deg": errors,
        "scale_error": float("inf"),
        "rms_check_m": None,
    }
    folder = reconstruct(project, photos, result=RESULT | {"registration": said})
    _, placed = read_reconstruction(folder, "s", "cliff")
    assert placed.rotation_error_deg is None
    assert (placed.scale_error, placed.rms_control_m, placed.rms_check_m) == (None, 0.05, None)


WHOLE = [[1e-6 * (i == j) + 1e-8 for j in range(7)] for i in range(7)]


@pytest.mark.parametrize(
    ("covariance", "centre", "whole"),
    [
        (WHOLE, [4.0, 5.0, 6.0], True),
        (None, None, False),
        ([[1.0] * 7] * 6, [1.0, 2.0], False),
        ([[1.0] * 6 + [None]] * 7, [1.0, "x", 2.0], False),
    ],
)
def test_covariance_is_imported_only_if_complete(
    project: Path, photos: Path, covariance: Any, centre: Any, whole: bool
) -> None:
    said = RESULT["registration"] | {"covariance": covariance, "centre": centre}
    folder = reconstruct(project, photos, result=RESULT | {"registration": said})
    _, placed = read_reconstruction(folder, "s", "cliff")
    assert placed.covariance == (tuple(map(tuple, WHOLE)) if whole else None)
    assert placed.centre == ((4.0, 5.0, 6.0) if whole else None)
    turn = placed.rotation_covariance()
    assert turn is not None
    assert (turn[0, 1] != 0.0) == whole


def test_missing_result_fields_get_default_values(project: Path, photos: Path) -> None:
    folder = reconstruct(project, photos, result={"settings": [], "photos": "3", "versions": 1})
    made, placed = read_reconstruction(folder, "s", "cliff")
    assert (made.quality, made.settings, made.photos, made.registered) == ("", (), 0, 0)
    assert (made.reprojection_error_px, made.software) == (None, "")
    assert (placed.method, placed.frame, placed.rms_control_m) == ("local", Frame(), None)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (None, "reconstruction.unreadable"),
        ("{", "reconstruction.unreadable"),
        ("[]", "reconstruction.invalid"),
    ],
)
def test_unreadable_result_file_is_named(
    project: Path, photos: Path, text: str | None, code: str
) -> None:
    folder = reconstruct(project, photos, result=None)
    if text is not None:
        (folder / "reconstruction.json").write_text(text)
    with refused(code) as caught:
        read_reconstruction(folder, "s", "cliff")
    assert "reconstruction.json" in str(caught.value)


# --- tables and masks ----------------------------------------------------------------------------
def test_tables_next_to_the_photos_take_precedence_over_project_tables(
    project: Path, photos: Path, tmp_path: Path
) -> None:
    control, marks = photos / "control.csv", photos / "marks.csv"
    spare = fallback_folder(project, photos)
    other = fallback_folder(project, tmp_path / "mounted elsewhere" / "cliff")
    assert spare.parent == other.parent == project / "photos"
    assert spare != other
    assert spare.name.startswith("cliff-")
    digest = hashlib.sha256(str(photos).encode()).hexdigest()
    assert spare.name == f"cliff-{digest[:8]}"
    in_spare = tables(spare)
    tables(other)
    assert sidecar_tables(project, photos) == (control, marks)
    control.unlink()
    assert sidecar_tables(project, photos) == (in_spare[0], marks)
    marks.unlink()
    assert sidecar_tables(project, photos) == in_spare
    for path in in_spare:
        path.unlink()
    assert sidecar_tables(project, photos) == (None, None)


def test_points_marks_and_masks_are_read_exactly(project: Path, photos: Path) -> None:
    steps: list[float] = []
    progress = SilentProgress()
    progress.step = steps.append  # type: ignore[method-assign, assignment]
    names = ["sub/a.jpg", "b.jpg"]
    mask = photos / "a_mask.png"
    found = read_sidecars(
        project,
        photos / "control.csv",
        photos / "marks.csv",
        {"sub/a.jpg": mask, "b.jpg": mask},
        names,
        progress,
    )
    assert [(p.label, p.position, p.sigma_m, p.check) for p in found.points] == [
        ("P1", (1.0, 2.0, 3.0), 0.01, False),
        ("P2", (4.0, 5.0, 6.0), None, True),
    ]
    # A mark says which photo of these it means, whatever folder it stands in.
    assert found.marks == (("P1", "sub/a.jpg", 1.5, 2.5), ("tie", "sub/a.jpg", 3.5, 4.5))
    assert found.pixels == {("P1", "sub/a.jpg"): (1.5, 2.5), ("tie", "sub/a.jpg"): (3.5, 4.5)}
    assert (found.crs, found.problems, found.unread_files) == (CRS, (), ())
    assert set(found.masks) == {"sub/a.jpg", "b.jpg"}
    for asset in found.masks.values():
        assert (project / asset.path).read_bytes() == mask.read_bytes()
    assert steps == [0, 1]


def test_mark_in_a_missing_photo_keeps_the_photo_name(project: Path, photos: Path) -> None:
    found = read_sidecars(project, None, photos / "marks.csv", {}, ["other.jpg"])
    assert [photo for _, photo, _, _ in found.marks] == ["a.jpg", "a.jpg"]
    assert (found.points, found.crs) == ((), "")


def test_unreadable_table_is_reported_and_the_others_are_read(project: Path, photos: Path) -> None:
    """Nobody may replace it unasked: the work of a day may be in it."""
    control, marks = photos / "control.csv", photos / "marks.csv"
    (photos / "gone_mask.png").unlink(missing_ok=True)
    masks = {"a.jpg": photos / "a_mask.png", "b.jpg": photos / "gone_mask.png"}
    whole = control.read_text()
    control.write_text("label,x,y,z\nP1,not a number,2,3\n")
    found = read_sidecars(project, control, marks, masks, ["a.jpg"])
    assert (found.points, len(found.marks), set(found.masks)) == ((), 2, {"a.jpg"})
    assert found.unread_files == ("control.csv",)
    assert len(found.problems) == 2
    assert "control.csv" in found.problems[0]
    assert "gone_mask.png" in found.problems[1]
    control.write_text(whole)
    marks.write_text("label,photo,x,y\nP1,a.jpg,left,2\n")
    found = read_sidecars(project, control, marks, {}, ["a.jpg"])
    assert (len(found.points), found.marks, found.unread_files) == (2, (), ("marks.csv",))
    assert len(found.problems) == 1
    assert "marks.csv" in found.problems[0]


def test_mask_file_extension_is_lowercased(project: Path, photos: Path) -> None:
    loud = (photos / "a_mask.png").rename(photos / "A_MASK.PNG")
    found = read_sidecars(project, None, None, {"a.jpg": loud}, ["a.jpg"])
    assert found.masks["a.jpg"].path.endswith(".png")


def test_photo_paths_are_relative_only_inside_the_project(project: Path, photos: Path) -> None:
    assert stored_path(project, project / "in" / "side") == "in/side"
    assert stored_path(project, project / "x" / ".." / "side") == "side"
    assert stored_path(project, photos) == str(photos.resolve())
