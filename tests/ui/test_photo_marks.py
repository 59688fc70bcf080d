"""Marks on the disk: at once, whole, and nothing of anybody's lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from vomstudio.errors import InputError, TargetError
from vomstudio.io.control.control_files import crs_of, read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_marks
from vomstudio.ui.photos import photo_marks
from vomstudio.ui.photos.edit_history import EditHistory
from vomstudio.ui.photos.photo_marks import MarkFiles, PhotoMarks

PHOTOS = ("a.jpg", "sub/b.jpg")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "photos").mkdir()
    return tmp_path / "photos"


def opened(folder: Path, said: list | None = None) -> PhotoMarks:
    files = MarkFiles(folder, lambda: folder.parent / "project" / "kept")
    made = PhotoMarks(files, PHOTOS, EditHistory())
    if said is not None:
        made.said.connect(lambda text, level: said.append((level, text)))
    made.read()
    return made


def mark(marks: PhotoMarks, label: str, photo: str = "a.jpg", x: float = 1.25) -> None:
    marks.change("mark", photo, marks.marking.marked(label, photo, (x, 2.5)))


def test_every_change_is_on_the_disk_at_once(folder, qtbot) -> None:
    marks = opened(folder)
    mark(marks, "A")
    assert read_marks(folder / "marks.csv") == [Mark("A", "a.jpg", 1.25, 2.5)]
    assert not (folder / "control.csv").exists()
    marks.change("place", "", marks.marking.placed(ControlPoint("A", (1.0, 2.0, 3.0))))
    assert read_control(folder / "control.csv") == [ControlPoint("A", (1.0, 2.0, 3.0))]
    again = opened(folder)
    assert again.marking == marks.marking
    marks._history.undo()
    assert not (folder / "control.csv").exists()
    marks._history.undo()
    assert not (folder / "marks.csv").exists()
    marks._history.redo()
    assert read_marks(folder / "marks.csv") == [Mark("A", "a.jpg", 1.25, 2.5)]


def test_a_drag_is_one_step_and_written_at_its_end(folder, qtbot) -> None:
    marks = opened(folder)
    mark(marks, "A")
    for i in range(5):
        made = marks.marking.marked("A", "a.jpg", (10.0 + i, 2.5))
        marks.change("drag", "a.jpg", made, "drag", goes_on=True)
    assert read_marks(folder / "marks.csv")[0].x == 1.25
    marks.change("drag", "a.jpg", marks.marking, "drag")
    assert read_marks(folder / "marks.csv")[0].x == 14.0
    marks._history.undo()
    assert read_marks(folder / "marks.csv")[0].x == 1.25


def test_a_folder_that_cannot_be_written_is_told_and_the_project_keeps_the_marks(
    folder, qtbot, monkeypatch
) -> None:
    write = photo_marks.write_marks

    def refused(path: Path, marks):
        if path.parent == folder:
            raise TargetError("no permission to write here; choose another folder.", file=path)
        return write(path, marks)

    monkeypatch.setattr(photo_marks, "write_marks", refused)
    said: list = []
    marks = opened(folder, said)
    mark(marks, "A")
    kept = folder.parent / "project" / "kept" / "marks.csv"
    assert read_marks(kept) == [Mark("A", "a.jpg", 1.25, 2.5)]
    assert not marks.unsaved
    assert any("cannot be written" in text for _, text in said)
    assert marks.files.found("marks.csv") == kept
    said.clear()
    mark(marks, "B")
    assert len(read_marks(kept)) == 2
    assert not said, "told once"
    assert opened(folder).marking.labels == ("A", "B")


def test_what_can_be_written_nowhere_is_tried_again(folder, qtbot, monkeypatch) -> None:
    def refused(path: Path, marks):
        raise TargetError("the disk is full; free some space or write elsewhere.", file=path)

    said: list = []
    marks = opened(folder, said)
    with monkeypatch.context() as full:
        full.setattr(photo_marks, "write_marks", refused)
        mark(marks, "A")
        assert "disk is full" in marks.unsaved
        assert said[-1][0] == "error"
        assert not marks.save_again()
    assert marks.marking.labels == ("A",), "it is still in the window"
    mark(marks, "B")
    assert not marks.unsaved
    assert len(read_marks(folder / "marks.csv")) == 2


def test_a_table_that_cannot_be_read_is_put_aside_before_it_is_replaced(folder, qtbot) -> None:
    (folder / "marks.csv").write_text("label,photo,x,y\nA,a.jpg,left,2\n")
    said: list = []
    marks = opened(folder, said)
    assert "'left' is not a number" in said[0][1]
    assert "left" in (folder / "marks.csv").read_text()
    mark(marks, "B")
    assert read_marks(folder / "marks.csv") == [Mark("B", "a.jpg", 1.25, 2.5)]
    assert "left" in (folder / "marks.csv.bak").read_text()


def test_marks_in_photos_that_are_not_there_are_kept(folder, qtbot) -> None:
    write_marks(folder / "marks.csv", [Mark("A", "gone.jpg", 1, 2), Mark("A", "b.jpg", 3, 4)])
    said: list = []
    marks = opened(folder, said)
    assert marks.marking.of("A") == {"gone.jpg": (1.0, 2.0), "sub/b.jpg": (3.0, 4.0)}
    assert "gone.jpg" in said[0][1]
    mark(marks, "B")
    assert {m.photo for m in read_marks(folder / "marks.csv")} == {"gone.jpg", "sub/b.jpg", "a.jpg"}


def test_the_tables_that_the_model_is_placed_by_are_taken_over_and_never_written(
    folder, qtbot
) -> None:
    """With their CRS, without which the model would be in a local frame."""
    control, marks_ = folder.parent / "control.csv", folder.parent / "marks.csv"
    control.write_text("# EPSG:32633: surveyed\nlabel,x,y,z\nA,1,2,3\n")
    write_marks(marks_, [Mark("A", "a.jpg", 1, 2)])
    before = control.read_bytes(), marks_.read_bytes()
    marks = PhotoMarks(
        MarkFiles(folder, lambda: folder.parent / "kept", control, marks_), PHOTOS, EditHistory()
    )
    marks.read()
    assert [p.label for p in marks.marking.control] == ["A"]
    assert marks.save_again()
    assert not any(folder.iterdir()), "nothing has changed"
    mark(marks, "B")
    assert (control.read_bytes(), marks_.read_bytes()) == before
    assert [m.label for m in read_marks(folder / "marks.csv")] == ["A", "B"]
    assert crs_of(folder / "control.csv") == "EPSG:32633"
    again = opened(folder)
    assert again.marking == marks.marking
    again.change("place", "", again.marking.placed(ControlPoint("C", (4.0, 5.0, 6.0))))
    assert crs_of(folder / "control.csv") == "EPSG:32633"
    assert not list(folder.glob("*.bak*")), "a table of our own needs no copy"


def test_points_of_another_crs_are_not_mixed_in(folder, qtbot) -> None:
    one, other = folder.parent / "one.csv", folder.parent / "other.csv"
    one.write_text("# EPSG:32633\nlabel,x,y,z\nA,1,2,3\n")
    other.write_text("# EPSG:32632\nlabel,x,y,z\nB,1,2,3\n")
    marks = opened(folder)
    marks.import_points(one)
    with pytest.raises(InputError, match="EPSG:32632, the points that are here are in EPSG:32633"):
        marks.import_points(other)
    assert [p.label for p in read_control(folder / "control.csv")] == ["A"]
