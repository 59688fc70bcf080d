"""Which control points and marks `vomstudio reconstruct` takes."""

from __future__ import annotations

from pathlib import Path

import pytest

from vomstudio import cli
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction, ReconstructionRequest

PHOTOS = ("a.jpg", "b.jpg")
RESULT = Reconstruction(
    photos=2,
    registered=2,
    unregistered=(),
    survey=SurveyReport("after", (), (), ""),
    alignment_notes=(),
    reprojection_error_px=0.5,
    cameras="",
    sparse="",
    dense="",
    mesh="model.obj",
    dense_points=1,
    faces=1,
    frame="local",
    scaled=True,
    seconds={},
    unit="m",
    unseen_share=0.0,
    texel=0.01,
    photo_pixel=0.005,
    device="cpu",
    peak_memory_mb=1,
    report="report.html",
    poses="",
    folder="",
    warnings=(),
    tie_points=1,
    tie_points_of_3=1,
    photo_rows=(),
    dense_gsd_m=None,
    calibration=(),
    registration={},
    model={},
    settings={},
    versions={},
    drawing={},
    work_mb=1.0,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "photos").mkdir()
    for name in PHOTOS:
        (tmp_path / "photos" / name).touch()
    return tmp_path / "photos"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[ReconstructionRequest]:
    """What the worker would have been asked for."""
    seen: list[ReconstructionRequest] = []

    def run_job(job: object, order: ReconstructionRequest, progress: object) -> Reconstruction:
        seen.append(order)
        return RESULT

    monkeypatch.setattr("vomstudio.studio.jobs.run_job.run_job", run_job)
    return seen


def points(folder: Path, marked: int) -> None:
    labels = ("A", "B", "C")
    write_control(
        folder / "control.csv", [ControlPoint(n, (i, i * i, 0.0)) for i, n in enumerate(labels)]
    )
    write_marks(
        folder / "marks.csv",
        [Mark(label, photo, 1.5, 2.5) for label in labels[:marked] for photo in PHOTOS],
    )


def run(folder: Path, *words: str) -> int:
    return cli.main(["reconstruct", str(folder), "-o", str(folder.parent / "out"), *words])


def test_control_file_in_photo_folder_is_used(folder, asked) -> None:
    points(folder, marked=3)
    assert run(folder) == 0
    assert asked[0].control == folder / "control.csv"
    assert asked[0].marks == folder / "marks.csv"


def test_insufficient_control_is_left_out_with_reason(folder, asked, capsys) -> None:
    points(folder, marked=2)
    assert run(folder) == 0
    assert asked[0].control is None
    assert asked[0].marks == folder / "marks.csv", "they tie photos together"
    assert "C (0 marks)" in capsys.readouterr().err


def test_control_of_other_photos_or_collinear_is_left_out(folder, asked, capsys) -> None:
    points(folder.parent, marked=3)
    (folder / "b.jpg").rename(folder / "c.jpg")
    assert run(folder) == 0
    assert asked[0].control is None
    assert "A (1 mark)" in capsys.readouterr().err
    (folder / "c.jpg").rename(folder / "b.jpg")
    control = [ControlPoint(n, (i, 2.0 * i, 0.0)) for i, n in enumerate("ABC")]
    write_control(folder.parent / "control.csv", control)
    assert run(folder) == 0
    assert asked[1].control is None
    assert "one line" in capsys.readouterr().err


def test_marks_in_photo_folder_are_used_with_control_from_elsewhere(folder, asked) -> None:
    points(folder, marked=3)
    control = folder.parent / "survey" / "points.csv"
    control.parent.mkdir()
    (folder / "control.csv").rename(control)
    assert run(folder, "--gcp", str(control)) == 0
    assert (asked[0].control, asked[0].marks) == (control, folder / "marks.csv")


def test_gcp_none_disables_control(folder, asked) -> None:
    points(folder, marked=3)
    assert run(folder, "--gcp", "none") == 0
    assert asked[0].control is None
    assert asked[0].marks == folder / "marks.csv", "they tie photos together"


def test_marks_alone_are_tie_points(folder, asked) -> None:
    marks = folder.parent / "ties.csv"
    write_marks(marks, [Mark("A", "a.jpg", 1, 2)])
    assert run(folder, "--marks", str(marks)) == 0
    assert (asked[0].control, asked[0].marks) == (None, marks)
    assert run(folder, "--marks", str(folder / "gone.csv")) == 2


def test_marks_in_photo_folder_are_used_without_control(folder, asked) -> None:
    write_marks(folder / "marks.csv", [Mark("A", "a.jpg", 1, 2)])
    assert run(folder) == 0
    assert (asked[0].control, asked[0].marks) == (None, folder / "marks.csv")


def test_without_tables_there_is_no_control(folder, asked) -> None:
    assert run(folder) == 0
    assert (asked[0].control, asked[0].marks) == (None, None)
