"""Points and marks of photos: records of the project, and tables beside the photos that follow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.messages import refused, shown_codes
from vomstudio.core.errors import TargetError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.io.control import writing
from vomstudio.io.control.control_files import read_control, read_crs, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_marks
from vomstudio.io.settings import Settings
from vomstudio.project.imports.sidecar_import import read_sidecars, sidecar_tables, stored_path
from vomstudio.project.photo_edits import add_photo_set
from vomstudio.project.records import PhotoSet
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_exports import PhotoExports
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks
from vomstudio.ui.panels.photos.photo_row import PhotoRow

PHOTOS = ("a.jpg", "sub/b.jpg")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "photos").mkdir()
    return tmp_path / "photos"


class Opened:
    """A project in which a folder of photos is looked at, as PhotoSurvey does it."""

    def __init__(
        self, studio: Studio, folder: Path, given: tuple[Path, Path] | None = None
    ) -> None:
        self.studio, self.folder = studio, folder
        self.said: list[tuple[str, Finding]] = []
        self.document = PhotoDocument(studio)
        self.exports = PhotoExports(self.document)
        self.exports.message.connect(lambda message, level: self.said.append((level, message)))
        self.document.set_folder(folder)
        project = studio.project.folder
        own = sidecar_tables(project, folder)
        taken = own == (None, None) and given is not None
        beside = read_sidecars(project, *(given if taken else own), {}, PHOTOS)
        self.problems = beside.problems
        made = PhotoSet(new_id("photos"), "photos", stored_path(project, folder), beside.crs)
        studio.attempt(add_photo_set, made, beside.points, beside.pixels)
        self.document.set_folder(folder)
        rows = [PhotoRow(n, str(folder / n), 100, 80, "", "", "", False, None) for n in PHOTOS]
        self.exports.begin(rows, is_external=taken, sidecars=beside)
        self.marks = PhotoMarks(self.document, PHOTOS)

    @property
    def spare(self) -> Path:
        (found,) = (self.studio.project.folder / "photos").iterdir()
        return found


@pytest.fixture
def studio(own_folders: Path, qtbot: object) -> Iterator[Studio]:
    made = Studio(Settings())
    made.new_project()
    yield made
    made.close()


@pytest.fixture
def opened(studio: Studio, folder: Path) -> Opened:
    return Opened(studio, folder)


def mark(marks: PhotoMarks, label: str, photo: str = "a.jpg", x: float = 1.25) -> None:
    marks.change("mark", marks.marking.set_mark(label, photo, (x, 2.5)))


def test_every_mark_change_is_an_undo_step_and_updates_the_tables(opened, folder) -> None:
    marks, studio = opened.marks, opened.studio
    mark(marks, "A")
    assert read_marks(folder / "marks.csv") == [Mark("A", "a.jpg", 1.25, 2.5)]
    assert not (folder / "control.csv").exists()
    marks.change("place", marks.marking.set_coordinates(ControlPoint("A", (1.0, 2.0, 3.0))))
    assert read_control(folder / "control.csv") == [ControlPoint("A", (1.0, 2.0, 3.0))]
    assert studio.session.undo_label == "place"
    studio.undo()
    assert not (folder / "control.csv").exists()
    studio.undo()
    assert not (folder / "marks.csv").exists()
    assert marks.marking.labels == ()
    studio.redo()
    assert read_marks(folder / "marks.csv") == [Mark("A", "a.jpg", 1.25, 2.5)]


def test_marks_survive_the_loss_of_their_tables_and_of_the_window(opened, folder) -> None:
    mark(opened.marks, "A")
    (folder / "marks.csv").unlink()
    project = opened.studio.project.folder
    # As after a kill: the journal alone.
    from vomstudio.project.journal.database import read_replay

    assert any(getattr(r, "label", "") == "A" for r in read_replay(project).records.values())


def test_dragging_a_mark_is_one_undo_step_saved_at_its_end(opened, folder) -> None:
    marks = opened.marks
    mark(marks, "A")
    for i in range(5):
        made = marks.marking.set_mark("A", "a.jpg", (10.0 + i, 2.5))
        marks.change("drag", made, "drag", is_ongoing=True)
    assert read_marks(folder / "marks.csv")[0].x == 1.25
    marks.change("drag", marks.marking, "drag")
    assert read_marks(folder / "marks.csv")[0].x == 14.0
    opened.studio.undo()
    assert read_marks(folder / "marks.csv")[0].x == 1.25


def test_consecutive_nudges_are_one_undo_step(opened) -> None:
    marks = opened.marks
    mark(marks, "A")
    for i in range(5):
        marks.change("nudge", marks.marking.set_mark("A", "a.jpg", (2.0 + i, 2.5)), "nudged")
    assert marks.marking.of("A") == {"a.jpg": (6.0, 2.5)}
    opened.studio.undo()
    assert marks.marking.of("A") == {"a.jpg": (1.25, 2.5)}
    opened.studio.redo()
    assert marks.marking.of("A") == {"a.jpg": (6.0, 2.5)}


def test_tables_of_a_read_only_folder_are_saved_in_the_project(opened, folder, monkeypatch) -> None:
    write = writing.write_marks

    def refused(path: Path, marks):
        if path.parent == folder:
            raise TargetError(Finding("disk.no-permission"), file=path)
        return write(path, marks)

    monkeypatch.setattr(writing, "write_marks", refused)
    mark(opened.marks, "A")
    kept = opened.spare / "marks.csv"
    assert read_marks(kept) == [Mark("A", "a.jpg", 1.25, 2.5)]
    assert not opened.exports.problem
    assert [(level, message.code) for level, message in opened.said] == [
        ("warning", "points.table-in-project")
    ]
    assert opened.exports.table("marks.csv") == kept
    opened.said.clear()
    mark(opened.marks, "B")
    assert len(read_marks(kept)) == 2
    assert not opened.said, "told once"


def test_failed_table_export_is_reported_and_retried(opened, folder, monkeypatch) -> None:
    def refused(path: Path, marks):
        raise TargetError(Finding("disk.full"), file=path)

    with monkeypatch.context() as full:
        full.setattr(writing, "write_marks", refused)
        mark(opened.marks, "A")
        assert opened.exports.problem.values["reason_code"] == "disk.full"
        assert opened.said[-1][1].code == "points.tables-outdated"
        assert opened.said[-1][1].values["reason_code"] == "disk.full"
    assert opened.marks.marking.labels == ("A",)
    mark(opened.marks, "B")
    assert not opened.exports.problem
    assert len(read_marks(folder / "marks.csv")) == 2


def test_unreadable_table_is_backed_up_before_it_is_replaced(studio, folder) -> None:
    (folder / "marks.csv").write_text("label,photo,x,y\nA,a.jpg,left,2\n")
    opened = Opened(studio, folder)
    assert "table.not-a-number" in shown_codes(opened.problems[0])
    assert "left" in (folder / "marks.csv").read_text()
    mark(opened.marks, "B")
    assert read_marks(folder / "marks.csv") == [Mark("B", "a.jpg", 1.25, 2.5)]
    assert "left" in (folder / "marks.csv.bak").read_text()


def test_table_changed_by_another_program_is_backed_up(opened, folder) -> None:
    mark(opened.marks, "A")
    write_marks(folder / "marks.csv", [Mark("X", "a.jpg", 9.0, 9.0)])
    mark(opened.marks, "B")
    assert {m.label for m in read_marks(folder / "marks.csv")} == {"A", "B"}
    assert "X" in (folder / "marks.csv.bak").read_text()


TABLES = {
    "control.csv": "# EPSG:32633\nlabel,x,y,z\nA,1,2,3\nB,4,5,6\n",
    "marks.csv": "label,photo,x,y\nA,a.jpg,1.5,2\nT,b.jpg,3,4\n",
}


def looked_at_again(opened: Opened, folder: Path, changed: dict[str, str]) -> list[str]:
    """Which files are told to be another program's, once these are there."""
    for name, text in changed.items():
        (folder / name).write_text(text)
    exports = PhotoExports(opened.document)
    exports.begin(list(opened.exports._rows.values()), is_external=False)
    return exports.foreign_files


def test_only_tables_with_different_contents_are_foreign(studio, folder) -> None:
    for name, text in TABLES.items():
        (folder / name).write_text(text)
    opened = Opened(studio, folder)
    assert not opened.exports.foreign_files, "they were taken in just now"
    written_anew = {
        "control.csv": "# EPSG:32633\nlabel,x,y,z,sigma\nB,4.0,5.0,6.0,\nA,1.0,2.0,3.0,\n",
        "marks.csv": "label,photo,x,y\nT,sub/b.jpg,3.0,4.0\nA,a.jpg,1.50,2.0\n",
    }
    assert looked_at_again(opened, folder, written_anew) == []
    for name, old, new in (
        ("control.csv", "1,2,3", "1,2,3.5"),
        ("control.csv", "B,4,5,6\n", ""),
        ("control.csv", "EPSG:32633", "EPSG:32632"),
        ("control.csv", "A,1,2,3", "A,1,2,hammer"),
        ("marks.csv", "T,b.jpg,3,4", "T,b.jpg,3,5"),
        ("marks.csv", "T,b.jpg", "T,a.jpg"),
    ):
        changed = TABLES | {name: TABLES[name].replace(old, new)}
        assert looked_at_again(opened, folder, changed) == [name], new


def test_imported_tables_without_a_stored_hash_are_not_foreign(studio, folder) -> None:
    """As in a project without its view state."""
    for name, text in TABLES.items():
        (folder / name).write_text(text)
    opened = Opened(studio, folder)
    opened.document.set_export_hashes({})
    assert looked_at_again(opened, folder, {}) == []


def test_marks_in_missing_photos_are_kept(studio, folder) -> None:
    write_marks(folder / "marks.csv", [Mark("A", "gone.jpg", 1, 2), Mark("A", "b.jpg", 3, 4)])
    opened = Opened(studio, folder)
    marks = opened.marks
    assert marks.marking.of("A") == {"gone.jpg": (1.0, 2.0), "sub/b.jpg": (3.0, 4.0)}
    mark(marks, "B")
    assert {m.photo for m in read_marks(folder / "marks.csv")} == {"gone.jpg", "sub/b.jpg", "a.jpg"}


def test_control_tables_of_the_model_are_imported_and_not_overwritten(studio, folder) -> None:
    """With their CRS, without which the model would be in a local frame."""
    control, marks_ = folder.parent / "control.csv", folder.parent / "marks.csv"
    control.write_text("# EPSG:32633: surveyed\nlabel,x,y,z\nA,1,2,3\n")
    write_marks(marks_, [Mark("A", "a.jpg", 1, 2)])
    before = control.read_bytes(), marks_.read_bytes()
    opened = Opened(studio, folder, (control, marks_))
    marks = opened.marks
    assert [p.label for p in marks.marking.control] == ["A"]
    assert not any(folder.iterdir()), "nothing has changed"
    mark(marks, "B")
    assert (control.read_bytes(), marks_.read_bytes()) == before
    assert [m.label for m in read_marks(folder / "marks.csv")] == ["A", "B"]
    assert read_crs(folder / "control.csv") == "EPSG:32633"
    marks.change("place", marks.marking.set_coordinates(ControlPoint("C", (4.0, 5.0, 6.0))))
    assert read_crs(folder / "control.csv") == "EPSG:32633"
    assert not list(folder.glob("*.bak*")), "a table of our own needs no copy"


def test_points_in_another_crs_are_rejected(opened, folder) -> None:
    one, other = folder.parent / "one.csv", folder.parent / "other.csv"
    one.write_text("# EPSG:32633\nlabel,x,y,z\nA,1,2,3\n")
    other.write_text("# EPSG:32632\nlabel,x,y,z\nB,1,2,3\n")
    marks = opened.marks
    marks.import_points(one)
    with refused("control.other-crs", crs="EPSG:32632", project_crs="EPSG:32633"):
        marks.import_points(other)
    assert [p.label for p in read_control(folder / "control.csv")] == ["A"]
