"""A compaction tells before what it takes, takes nothing that can be reached, and can be undone."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import DocumentError, TargetError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import compaction, edits
from vomstudio.project.assets import asset_path, is_intact, store_asset
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.journal.migration import SCHEMA_VERSION
from vomstudio.project.photo_edits import add_photo_set, set_masks
from vomstudio.project.records import Asset, Model, PhotoSet
from vomstudio.project.verify import verify

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
SIDE = {"journal-before-compaction.sqlite", "assets-before-compaction", "journal-compacted.sqlite"}


@pytest.fixture
def project(tmp_path: Path) -> Iterator[ProjectFolder]:
    made = ProjectFolder.create(tmp_path / "a.vom", settings=lambda: {"n": 1})
    made.session.apply(edits.add_model(made.session.records, MODEL))
    yield made
    made.close()


def note(project: ProjectFolder, text: str, id_: str = "t0") -> int:
    session = project.session
    return session.apply(edits.set_attributes(session.records, [id_], notes=text))


def mask(project: ProjectFolder, content: bytes) -> Asset:
    kept = store_asset(project.folder, content, ".png")
    project.session.apply(set_masks(project.session.records, "s", {"a.jpg": kept}, "Leave out"))
    return kept


@pytest.fixture
def worn(project: ProjectFolder) -> ProjectFolder:
    """Row 3 is a model, 4 a bed, 5 a note that was undone (6) and replaced (7), 8 a note that is
    undone (9) and can be done again, 10 the save."""
    session = project.session
    session.apply(edits.add_trace(session.records, bed("t0")))
    note(project, "gone")
    session.undo()
    note(project, "kept")
    note(project, "again")
    session.undo()
    session.save()
    return project


def rows(project: ProjectFolder) -> list[tuple[int, str, int | None, str]]:
    return [(row.seq, row.kind, row.of_seq, row.label) for row in project.journal.rows()]


# --- what it takes -------------------------------------------------------------------------------
def test_compaction_keeps_undo_and_redo_steps_with_times_and_settings(
    worn: ProjectFolder,
) -> None:
    before = {row.seq: row for row in worn.journal.rows()}
    plan = worn.compaction()
    # Two rows of a step that was replaced, and the save at the birth of the project.
    assert (plan.rows, plan.total_rows, plan.assets, plan.asset_bytes) == (3, 10, (), 0)
    assert not plan.is_empty
    assert not worn.is_compacted
    worn.compact()
    assert worn.is_compacted
    assert [(seq, kind, of) for seq, kind, of, _ in rows(worn)] == [
        (1, "do", None),
        (2, "do", None),
        (3, "do", None),
        (4, "do", None),
        (5, "save", None),
        (6, "do", None),
        (7, "undo", 6),
    ]
    for new, old in {1: 1, 2: 3, 3: 4, 4: 7, 6: 8}.items():
        row = next(row for row in worn.journal.rows() if row.seq == new)
        was = before[old]
        assert (row.time, row.version, row.settings) == (was.time, was.version, {"n": 1})
        assert (row.label, row.before, row.after) == (was.label, was.before, was.after)
    # Saving and undoing are of today, and nobody's settings were read for them.
    made = {row.seq: row for row in worn.journal.rows()}
    assert [made[seq].settings for seq in (5, 7)] == [None, None]
    assert min(made[5].time, made[7].time) >= before[10].time
    plan = worn.compaction()
    assert plan.is_empty
    assert (plan.rows, plan.total_rows) == (0, 7)


def test_session_continues_in_the_compacted_journal(worn: ProjectFolder) -> None:
    worn.compact()
    session = worn.session
    assert (session.top, session.saved_top, session.dirty) == (4, 4, False)
    session.redo()
    assert session.records["t0"].notes == "again"
    for _ in range(3):
        session.undo()
    assert "t0" not in session.records
    played = read_replay(worn.folder)
    assert played.records == dict(session.records)
    assert played.problems == []
    assert played.top == session.top


def test_two_redo_steps_keep_their_order(worn: ProjectFolder) -> None:
    worn.session.undo()
    worn.session.save()
    worn.compact()
    for expected in ("kept", "again"):
        worn.session.redo()
        assert worn.session.records["t0"].notes == expected
    assert read_replay(worn.folder).records == dict(worn.session.records)


def test_discarding_returns_to_the_save_made_with_undone_steps_above_it(
    worn: ProjectFolder,
) -> None:
    worn.session.redo()
    worn.session.save()
    worn.compact()
    worn.close()
    again = ProjectFolder.open(worn.folder)
    note(again, "not wanted")
    again.session.discard_unsaved()
    assert again.session.records["t0"].notes == "again"
    worn.__dict__.update(again.__dict__)


def test_views_and_drafts_survive_compaction(worn: ProjectFolder) -> None:
    worn.journal.set_view("camera", [1.5])
    worn.session.set_draft({"tool": "trace", "vertices": [[0.0, 0.0, 0.0]]})
    worn.session.save()
    worn.compact()
    assert worn.journal.view("camera") == [1.5]
    draft = read_replay(worn.folder).draft
    assert draft == worn.session.draft
    assert draft is not None
    add = edits.add_trace(worn.session.records, bed("t1"))
    worn.session.apply(add, finishes_draft=True)
    assert read_replay(worn.folder).draft is None


def test_only_unreachable_files_are_removed_and_their_size_is_reported(
    project: ProjectFolder,
) -> None:
    session = project.session
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    gone = mask(project, b"gone" * 10)
    session.undo()
    now = [mask(project, b"first"), mask(project, b"second"), mask(project, b"undone")]
    session.undo()
    stray = store_asset(project.folder, b"no row names it", ".png")
    session.save()
    plan = project.compaction()
    assert plan.assets == tuple(sorted((gone.path, stray.path)))
    assert plan.asset_bytes == 40 + 15
    project.compact()
    assert {f"assets/{p.name}" for p in (project.folder / "assets").iterdir()} == {
        kept.path for kept in now
    }
    assert verify(project.folder).sound
    assert verify(project.folder).assets == 3
    project.close()
    assert not SIDE & {path.name for path in project.folder.iterdir()}
    assert not (project.folder / gone.path).exists()


def test_plan_that_removes_only_files_is_not_empty(worn: ProjectFolder) -> None:
    worn.compact()
    store_asset(worn.folder, b"x", ".png")
    plan = worn.compaction()
    assert (plan.rows, len(plan.assets)) == (0, 1)
    assert not plan.is_empty


# --- what it refuses -----------------------------------------------------------------------------
def test_journal_with_damaged_rows_is_not_compacted(worn: ProjectFolder) -> None:
    worn.session.problems = ("journal row 5 is damaged",)
    before = rows(worn)
    with refused("compaction.damaged", DocumentError):
        worn.compact()
    worn.session.problems = ()
    assert rows(worn) == before
    assert not worn.is_compacted


@contextlib.contextmanager
def no_space(monkeypatch: pytest.MonkeyPatch, when: str) -> Iterator[None]:
    """The disk is full while rows are written, the old journal is kept, or files take places."""

    def full(*_: object, **__: object) -> None:
        raise (
            OSError(28, "No space left")
            if when == "replacing"
            else TargetError(Finding("disk.full"))
        )

    step = {"writing": "copy_row", "keeping": "copy_to"}.get(when)
    with monkeypatch.context() as patch:
        if step is None:
            patch.setattr(Path, "replace", full)
        else:
            patch.setattr(SqliteJournal, step, full)
        yield


@pytest.mark.parametrize("when", ["writing", "keeping", "replacing"])
def test_failed_compaction_changes_nothing(
    worn: ProjectFolder, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    before, records = rows(worn), dict(worn.session.records)

    with (
        no_space(monkeypatch, when),
        refused("disk.full", TargetError),
    ):
        worn.compact()
    assert not worn.is_compacted
    assert rows(worn) == before
    note(worn, "since")
    assert read_replay(worn.folder).records == dict(worn.session.records)
    worn.session.undo()
    assert dict(worn.session.records) == records
    # The project can still be looked at, closed, and saved elsewhere.
    worn.journal.set_view("camera", [1.5])
    assert worn.journal.view("camera") == [1.5]
    worn.journal.copy_to(worn.folder / "copy.sqlite")
    if when == "writing":
        assert not SIDE & {path.name for path in worn.folder.iterdir()}
    worn.session.save()
    worn.compact()
    assert verify(worn.folder).sound


# --- and back ------------------------------------------------------------------------------------
def test_undoing_compaction_restores_rows_and_files_and_keeps_later_edits(
    worn: ProjectFolder,
) -> None:
    before = rows(worn)
    stray = store_asset(worn.folder, b"no row names it", ".png")
    worn.compact()
    assert (worn.folder / "journal-before-compaction.sqlite").is_file()
    since = note(worn, "since")
    worn.session.undo()
    worn.session.redo()
    worn.session.save()
    assert since == 8
    worn.undo_compaction()
    assert not worn.is_compacted
    assert rows(worn) == [
        *before,
        (11, "do", None, before[4][3]),
        (12, "undo", 11, before[4][3]),
        (13, "redo", 11, before[4][3]),
        (14, "save", None, ""),
    ]
    assert (worn.folder / stray.path).read_bytes() == b"no row names it"
    assert not SIDE & {path.name for path in worn.folder.iterdir()}
    assert (worn.session.top, worn.session.dirty) == (11, False)
    assert worn.session.records["t0"].notes == "since"
    played = read_replay(worn.folder)
    assert (played.records, played.problems) == (dict(worn.session.records), [])
    worn.session.undo()
    assert worn.session.records["t0"].notes == "kept"


@pytest.mark.parametrize("when", ["writing", "replacing"])
def test_failed_undo_of_compaction_can_be_retried_without_duplicates(
    worn: ProjectFolder, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    before = rows(worn)
    worn.compact()
    note(worn, "since")
    now = rows(worn)

    with (
        no_space(monkeypatch, when),
        refused("disk.full", TargetError),
    ):
        worn.undo_compaction()
    assert rows(worn) == now
    assert worn.is_compacted
    assert not (worn.folder / "journal-compacted.sqlite").exists()
    note(worn, "later")
    worn.undo_compaction()
    assert [row[1] for row in rows(worn)] == [row[1] for row in before] + ["do", "do"]
    assert worn.session.records["t0"].notes == "later"
    assert read_replay(worn.folder).records == dict(worn.session.records)
    assert not SIDE & {path.name for path in worn.folder.iterdir()}


def test_file_that_cannot_be_restored_blocks_the_undo_until_it_can(
    project: ProjectFolder,
) -> None:
    """Without it the mask of a step of before would be gone for good at the next closing."""
    session = project.session
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    first = mask(project, b"first")
    session.undo()
    mask(project, b"second")
    session.save()
    project.compact()
    place = project.folder / first.path
    assert not place.exists()
    (place / "in the way").mkdir(parents=True)
    with refused("output.unwritable", TargetError):
        project.undo_compaction()
    note_before = rows(project)
    (place / "in the way").rmdir()
    place.rmdir()
    project.undo_compaction()
    assert is_intact(place)
    assert len(rows(project)) > len(note_before)
    assert not SIDE & {path.name for path in project.folder.iterdir()}


def test_earlier_steps_undone_since_compaction_stay_undone(worn: ProjectFolder) -> None:
    worn.compact()
    worn.session.redo()
    worn.session.undo()
    worn.session.undo()
    worn.undo_compaction()
    assert [row[1:3] for row in rows(worn)[10:]] == [("redo", 8), ("undo", 8), ("undo", 7)]
    assert read_replay(worn.folder).records == dict(worn.session.records)


def test_rows_written_since_compaction_keep_their_time(worn: ProjectFolder) -> None:
    worn.compact()
    note(worn, "since")
    written = list(worn.journal.rows())[-1]
    worn.undo_compaction()
    assert replace(list(worn.journal.rows())[-1], seq=written.seq) == written


def test_compaction_cannot_be_undone_without_its_backup(worn: ProjectFolder) -> None:
    worn.compact()
    now = rows(worn)
    (worn.folder / "journal-before-compaction.sqlite").unlink()
    with refused("compaction.none", DocumentError):
        worn.undo_compaction()
    assert rows(worn) == now


def test_compaction_files_left_by_a_kill_are_removed_at_the_next_closing(
    worn: ProjectFolder,
) -> None:
    for ending in ("", "-wal", "-shm"):
        (worn.folder / f"journal-before-compaction.sqlite{ending}").write_bytes(b"x")
    aside = worn.folder / "assets-before-compaction"
    aside.mkdir()
    (aside / "0.png").write_bytes(b"x")
    compaction.discard_backup(worn.folder)
    assert not SIDE & {path.name for path in worn.folder.iterdir()}
    assert not list(worn.folder.glob("journal-before*"))
    compaction.discard_backup(worn.folder)


def test_partial_journal_left_by_a_kill_does_not_block_compaction(worn: ProjectFolder) -> None:
    (worn.folder / "journal-compacted.sqlite").write_bytes(b"half written")
    worn.compact()
    assert verify(worn.folder).sound


# --- files that rows name ------------------------------------------------------------------------
def test_asset_is_stored_once_under_its_content_hash(tmp_path: Path) -> None:
    first, again = (store_asset(tmp_path, b"mask", ".png") for _ in range(2))
    assert first == again
    assert first.size == 4
    path = asset_path(tmp_path, first)
    assert path == tmp_path / first.path
    assert [p.name for p in (tmp_path / "assets").iterdir()] == [path.name]
    assert path.suffix == ".png"
    assert path.read_bytes() == b"mask"
    assert is_intact(path)
    written = path.stat().st_mtime_ns, path.stat().st_ino
    store_asset(tmp_path, b"mask", ".png")
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == written
    # A kill while it was written leaves a part: the next one is written whole.
    path.write_bytes(b"ma")
    assert not is_intact(path)
    store_asset(tmp_path, b"mask", ".png")
    assert is_intact(path)


def test_missing_asset_is_reported(tmp_path: Path) -> None:
    kept = store_asset(tmp_path, b"mask", ".png")
    (tmp_path / kept.path).unlink()
    with refused("asset.missing") as caught:
        asset_path(tmp_path, kept)
    assert kept.path in str(caught.value)


# --- is it whole? --------------------------------------------------------------------------------
def test_verify_counts_and_checks_a_project(worn: ProjectFolder) -> None:
    session = worn.session
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    kept = [mask(worn, b"first"), mask(worn, b"second"), mask(worn, b"third")]
    session.undo()
    found = verify(worn.folder)
    assert (found.schema, found.models, found.features, found.assets) == (SCHEMA_VERSION, 1, 2, 3)
    # The birth, the model, the bed, its note, another bed, the photos and two masks.
    assert found.steps == 8
    assert found.sound
    assert found.problems == ()
    (worn.folder / kept[2].path).write_bytes(b"other")
    (worn.folder / kept[0].path).unlink()
    found = verify(worn.folder)
    assert not found.sound
    assert len(found.problems) == 2
    damaged = next(p for p in found.problems if p.code == "asset.damaged")
    missing = next(p for p in found.problems if p.code == "asset.missing")
    assert damaged.values["path"].endswith(kept[2].path)
    assert missing.values["file"].endswith(kept[0].path)


def test_file_referenced_only_by_the_last_save_is_needed_for_discarding(
    worn: ProjectFolder,
) -> None:
    session = worn.session
    session.apply(add_photo_set(session.records, PhotoSet("s", "photos", "/p")))
    kept = mask(worn, b"saved")
    session.save()
    session.undo()
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert verify(worn.folder).assets == 1
    (worn.folder / kept.path).unlink()
    assert not verify(worn.folder).sound
