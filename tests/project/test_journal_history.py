"""The journal of a project: small rows, detected damage, compaction."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import DocumentError, InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.assets import store_asset
from vomstudio.project.edit import change
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.photo_edits import (
    PointState,
    add_photo_set,
    points_of,
    set_masks,
    set_points,
)
from vomstudio.project.records import Mask, Model, PhotoSet
from vomstudio.project.verify import verify

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


@pytest.fixture
def project(tmp_path: Path) -> Iterator[ProjectFolder]:
    made = ProjectFolder.create(tmp_path / "a.vom")
    made.session.apply(edits.add_model(made.session.records, MODEL))
    yield made
    made.close()


def add_beds(project: ProjectFolder, count: int) -> None:
    for number in range(count):
        project.session.apply(edits.add_trace(project.session.records, bed(f"t{number}")))


def damage(folder: Path, statement: str) -> None:
    db = sqlite3.connect(folder / "journal.sqlite")
    db.execute(statement)
    db.commit()
    db.close()


# --- rows ----------------------------------------------------------------------------------------
@pytest.mark.full
def test_changing_the_set_of_ten_thousand_traces_adds_under_five_megabytes(
    project: ProjectFolder,
) -> None:
    long = tuple((float(i), i * 0.37, i * i * 1e-3) for i in range(40))
    traces = {
        f"trace-{n:012x}": replace(bed(f"trace-{n:012x}"), name=f"B{n}", vertices=long)
        for n in range(10_000)
    }
    project.session.apply(change(project.session.records, "Add traces", traces))
    path = project.folder / "journal.sqlite"
    project.journal.copy_to(project.folder / "before")
    project.session.apply(edits.set_attributes(project.session.records, traces, set_name="J1"))
    project.journal.copy_to(project.folder / "after")
    sizes = [(project.folder / name).stat().st_size for name in ("before", "after")]
    assert path.is_file()
    assert sizes[0] > 10e6
    assert sizes[1] - sizes[0] < 5e6
    played = read_replay(project.folder)
    assert played.records == dict(project.session.records)
    assert played.problems == []


def test_undone_and_redone_field_changes_survive_closing(
    project: ProjectFolder, tmp_path: Path
) -> None:
    add_beds(project, 2)
    session = project.session
    session.apply(edits.set_attributes(session.records, ["t0", "t1"], set_name="A"))
    session.apply(edits.set_attributes(session.records, ["t0"], notes="seen from below"))
    session.apply(edits.set_attributes(session.records, ["t0"], set_name="B"))
    session.undo()
    session.undo()
    session.redo()
    states = []
    expected = dict(session.records)
    project.close()
    again = ProjectFolder.open(tmp_path / "a.vom")
    assert dict(again.session.records) == expected
    again.session.redo()
    states.append(again.session.records["t0"].set_name)
    for _ in range(3):
        again.session.undo()
    states.append(again.session.records["t0"].set_name)
    assert states == ["B", ""]
    again.close()


def test_joined_edits_are_one_step_also_after_a_kill(
    project: ProjectFolder,
) -> None:
    session = project.session
    add_beds(project, 1)
    first = session.apply(edits.set_attributes(session.records, ["t0"], notes="a"))
    second = session.apply(edits.set_attributes(session.records, ["t0"], notes="ab"), joins=first)
    session.apply(edits.set_attributes(session.records, ["t0"], set_name="J"), joins=second)
    assert [len(read_replay(project.folder).done), len(session.done_steps())] == [4, 4]
    assert read_replay(project.folder).records == dict(session.records)
    session.undo()
    assert session.records["t0"] == replace(bed("t0"), name="B01")
    session.redo()
    assert (session.records["t0"].notes, session.records["t0"].set_name) == ("ab", "J")
    assert read_replay(project.folder).records == dict(session.records)


def test_edit_does_not_join_a_saved_one(project: ProjectFolder) -> None:
    session = project.session
    add_beds(project, 1)
    first = session.apply(edits.set_attributes(session.records, ["t0"], notes="a"))
    session.save()
    session.apply(edits.set_attributes(session.records, ["t0"], notes="ab"), joins=first)
    session.discard_unsaved()
    assert session.records["t0"].notes == "a"


# --- damage --------------------------------------------------------------------------------------
def test_changed_number_in_a_row_is_detected_and_the_rest_opens(
    project: ProjectFolder, tmp_path: Path
) -> None:
    add_beds(project, 3)
    project.close()
    damage(
        tmp_path / "a.vom",
        "UPDATE journal SET after = replace(after, '0.51', '0.71') WHERE label LIKE '%B02%'",
    )
    again = ProjectFolder.open(tmp_path / "a.vom")
    (problem,) = again.problems
    assert problem.code == "journal.row-unreadable"
    assert problem.values["reason_code"] == "row.checksum"
    assert "B02" in problem.values["label"]
    assert {f.id for f in again.session.features()} == {"t0", "t2"}
    assert not verify(tmp_path / "a.vom").sound
    again.close()


@pytest.mark.parametrize("column", ["kind", "of_seq", "label", "time", "version", "settings"])
def test_every_column_of_a_row_is_covered_by_its_checksum(
    project: ProjectFolder, tmp_path: Path, column: str
) -> None:
    add_beds(project, 2)
    project.close()
    damage(tmp_path / "a.vom", f"UPDATE journal SET {column} = 7 WHERE seq = 3")
    assert len(verify(tmp_path / "a.vom").problems) >= 1


def test_deleted_row_is_detected(project: ProjectFolder, tmp_path: Path) -> None:
    add_beds(project, 4)
    project.close()
    damage(tmp_path / "a.vom", "DELETE FROM journal WHERE label LIKE '%B02%'")
    (problem,) = verify(tmp_path / "a.vom").problems
    assert (problem.code, problem.values["count"]) == ("journal.rows-missing", 1)


def test_missing_rows_at_the_end_are_reported_and_their_numbers_not_reused(
    project: ProjectFolder, tmp_path: Path
) -> None:
    add_beds(project, 4)
    last = project.session.top
    project.close()
    damage(tmp_path / "a.vom", f"DELETE FROM journal WHERE seq > {last - 2}")
    again = ProjectFolder.open(tmp_path / "a.vom")
    missing = Finding("journal.rows-missing", count=2, first=last - 1, last=last)
    assert missing in again.problems
    add = edits.add_trace(again.session.records, bed("new"))
    assert again.session.apply(add) == last + 1
    again.close()
    assert len(verify(tmp_path / "a.vom").problems) == 1
    assert "new" in read_replay(tmp_path / "a.vom").records


def test_row_from_another_project_is_detected(project: ProjectFolder, tmp_path: Path) -> None:
    """Its own checksum is right, but it does not follow the row before it."""
    add_beds(project, 2)
    other = ProjectFolder.create(tmp_path / "b.vom")
    other.session.apply(edits.add_model(other.session.records, replace(MODEL, name="quarry")))
    add_beds(other, 2)
    row = (
        sqlite3.connect(other.folder / "journal.sqlite")
        .execute("SELECT * FROM journal WHERE label LIKE '%B01%'")
        .fetchone()
    )
    other.close()
    project.close()
    db = sqlite3.connect(tmp_path / "a.vom" / "journal.sqlite")
    db.execute(f"INSERT OR REPLACE INTO journal VALUES ({', '.join('?' * len(row))})", row)
    db.commit()
    db.close()
    assert verify(tmp_path / "a.vom").problems


def test_redone_edits_survive_a_damaged_row_before_them(
    project: ProjectFolder, tmp_path: Path
) -> None:
    add_beds(project, 2)
    session = project.session
    session.undo()
    session.undo()
    session.redo()
    session.redo()
    project.close()
    damage(
        tmp_path / "a.vom",
        "UPDATE journal SET label = 'x' WHERE seq = "
        "(SELECT min(seq) FROM journal WHERE kind = 'redo')",
    )
    played = read_replay(tmp_path / "a.vom")
    assert {"t0", "t1"} <= set(played.records)
    assert [seq for seq, _ in played.done] == sorted(seq for seq, _ in played.done)
    assert len(played.problems) == 1


# --- registrations -------------------------------------------------------------------------------
def test_registration_moves_its_models_and_undo_moves_them_back(
    project: ProjectFolder,
) -> None:
    session = project.session
    east = (
        (1.0, 0.0, 0.0, 500.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 1.0),
    )
    first = Registration("r1", "4 points", "control", Frame("crs", "EPSG:32633"))
    session.apply(edits.set_registration(session.records, first, ["m1"]))
    second = replace(first, matrix=east)
    session.apply(edits.set_registration(session.records, second))
    assert session.records["m1"].to_world == east
    assert session.records["m1"].frame.crs == "EPSG:32633"
    assert read_replay(project.folder).records == dict(session.records)
    session.undo()
    assert session.records["m1"].placement == first
    session.undo()
    assert session.records["m1"].placement == Frame("local")
    session.redo()
    assert read_replay(project.folder).records == dict(session.records)


def test_declaring_a_frame_gives_up_a_registration_only_on_request(
    project: ProjectFolder,
) -> None:
    session = project.session
    registration = Registration("r1", "4 points", "control", Frame("local"))
    session.apply(edits.set_registration(session.records, registration, ["m1"]))
    with refused("model.registered", DocumentError, registration="4 points"):
        edits.declare_frame(session.records, "m1", Frame("local"))
    edit = edits.declare_frame(session.records, "m1", Frame("local"), replaces_registration=True)
    session.apply(edit)
    assert session.records["m1"].registration is None
    session.undo()
    assert session.records["m1"].registration == registration


# --- points, marks and masks ---------------------------------------------------------------------
def test_points_keep_their_ids_when_they_move_are_renamed_or_marked(project: ProjectFolder) -> None:
    session = project.session
    states = [
        PointState("P1", (1.0, 2.0, 3.0), 0.01),
        PointState("P2", (4.0, 5.0, 6.0), check=True),
    ]
    marks = {("P1", "a.jpg"): (10.0, 20.0), ("T", "a.jpg"): (1.0, 2.0)}
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p"), states, marks))
    ids = {p.label: p.id for p in points_of(session.records, "s")}
    assert set(ids) == {"P1", "P2", "T"}
    moved = [replace(states[0], position=(1.5, 2.0, 3.0)), states[1]]
    edit = set_points(session.records, "s", moved, marks, "Move P1")
    assert set(edit.after) == {ids["P1"]}
    renamed = [PointState("Q1", (1.0, 2.0, 3.0), 0.01), states[1]]
    named = {("Q1", "a.jpg"): (10.0, 20.0), ("T", "a.jpg"): (1.0, 2.0)}
    edit = set_points(session.records, "s", renamed, named, "Rename P1")
    assert set(edit.after) == {ids["P1"]}
    session.apply(edit)
    edit = set_points(session.records, "s", states[1:], {}, "Remove points")
    session.apply(edit)
    assert [p.label for p in points_of(session.records, "s")] == ["P2"]
    session.undo()
    session.undo()
    assert {p.label: p.id for p in points_of(session.records, "s")} == ids
    assert read_replay(project.folder).records == dict(session.records)


def test_undo_restores_the_file_of_a_mask(project: ProjectFolder, tmp_path: Path) -> None:
    session = project.session
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    for content in (b"first", b"second"):
        asset = store_asset(project.folder, content, ".png")
        session.apply(set_masks(session.records, "s", {"a.jpg": asset}, "Leave out"))
    session.undo()
    (mask,) = session.of(Mask)
    assert (project.folder / mask.file.path).read_bytes() == b"first"
    session.redo()
    assert verify(project.folder).sound
    (mask,) = session.of(Mask)
    (project.folder / mask.file.path).write_bytes(b"other")
    assert verify(project.folder).problems[0].code == "asset.damaged"
    (project.folder / mask.file.path).unlink()
    assert verify(project.folder).problems[0].code == "asset.missing"


def test_mask_path_outside_the_project_is_rejected(tmp_path: Path) -> None:
    from vomstudio.project.assets import asset_path
    from vomstudio.project.records import Asset

    (tmp_path / "secret.png").write_bytes(b"x")
    (tmp_path / "a.vom").mkdir()
    for path in ("../secret.png", "assets/../../secret.png", str(tmp_path / "secret.png")):
        with pytest.raises(InputError):
            asset_path(tmp_path / "a.vom", Asset(path, 1))


# --- compaction ----------------------------------------------------------------------------------
@pytest.fixture
def used(project: ProjectFolder) -> ProjectFolder:
    """A project with steps that were undone and replaced, some to be done again, and masks."""
    session = project.session
    add_beds(project, 3)
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    for number in range(3):
        asset = store_asset(project.folder, b"mask %d" % number, ".png")
        session.apply(set_masks(session.records, "s", {"a.jpg": asset}, f"Mask {number}"))
        if number == 1:
            session.undo()
    for number in range(4):
        session.apply(edits.set_attributes(session.records, ["t0"], notes=str(number)))
        session.undo()
    session.apply(edits.set_attributes(session.records, ["t1"], notes="last"))
    session.apply(edits.set_attributes(session.records, ["t1"], notes="undone"))
    session.undo()
    session.save()
    return project


def walked(project: ProjectFolder) -> list[dict[str, object]]:
    """The records after each step back, to the first one and forth again to the last."""
    session = project.session
    states: list[dict[str, object]] = [dict(session.records)]
    back = 0
    while session.undo_label is not None:
        session.undo()
        back += 1
        states.append(dict(session.records))
    for _ in range(back):
        session.redo()
    while session.redo_label is not None:
        session.redo()
        states.append(dict(session.records))
        back -= 1
    while dict(session.records) != states[0]:
        session.undo()
    return states


def test_compaction_removes_unreachable_rows_and_reports_them_first(
    used: ProjectFolder, tmp_path: Path
) -> None:
    before = walked(used)
    used.session.save()
    plan = used.compaction()
    assert plan.rows > 10
    assert len(plan.assets) == 1
    rows = sum(1 for _ in used.journal.rows())
    used.compact()
    assert sum(1 for _ in used.journal.rows()) == rows - plan.rows
    assert used.compaction().is_empty
    assert walked(used) == before
    assert verify(used.folder).sound
    used.close()
    assert not list(used.folder.glob("*before*"))
    again = ProjectFolder.open(tmp_path / "a.vom")
    assert walked(again) == before
    again.close()


def test_undoing_a_compaction_keeps_later_edits(used: ProjectFolder) -> None:
    used.session.save()
    rows = [(r.kind, r.label) for r in used.journal.rows()]
    assets = sorted(p.name for p in (used.folder / "assets").iterdir())
    used.compact()
    used.session.redo()
    used.session.apply(edits.set_attributes(used.session.records, ["t2"], notes="since"))
    now = dict(used.session.records)
    used.undo_compaction()
    assert [(r.kind, r.label) for r in used.journal.rows()][: len(rows)] == rows
    assert dict(used.session.records) == now
    assert read_replay(used.folder).records == now
    assert sorted(p.name for p in (used.folder / "assets").iterdir()) == assets
    used.session.undo()
    used.session.undo()
    assert read_replay(used.folder).records == dict(used.session.records)
    with refused("compaction.none", DocumentError):
        used.undo_compaction()


def test_unsaved_project_is_not_compacted(used: ProjectFolder) -> None:
    used.session.apply(edits.set_attributes(used.session.records, ["t2"], notes="new"))
    with refused("compaction.unsaved", DocumentError):
        used.compact()


def test_a_draft_survives_a_compaction(used: ProjectFolder, tmp_path: Path) -> None:
    used.session.set_draft({"tool": "trace", "vertices": [[0.0, 0.0, 0.0]]})
    used.session.save()
    used.compact()
    used.close()
    again = ProjectFolder.open(tmp_path / "a.vom")
    assert again.session.draft is not None
    assert again.session.draft.state["tool"] == "trace"
    again.close()
