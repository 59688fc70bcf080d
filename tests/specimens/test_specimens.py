"""Specimen projects, one of each released schema, open with the figures recorded beside them."""

from __future__ import annotations

import dataclasses
import gc
import hashlib
import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.specimens import figures
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import VomError
from vomstudio.project import codec
from vomstudio.project.journal.database import read_schema_and_replay
from vomstudio.project.journal.migration import SCHEMA_VERSION
from vomstudio.project.journal.replay import Replay

pytestmark = pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning")

NEWEST = figures.SPECIMENS[-1]


@pytest.fixture(scope="module")
def recorded() -> dict[str, Any]:
    return figures.recorded(NEWEST)


@pytest.fixture
def specimen(tmp_path: Path) -> Path:
    return figures.copy_of(NEWEST, tmp_path)


def hashes(folder: Path) -> dict[str, str]:
    """Of all files but the lock, which says who has the project open."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "lock"
    }


def refusal(folder: Path) -> str:
    """The one sentence with which a project is not opened."""
    with pytest.raises(VomError) as caught:
        figures.open_project(folder).close()
    sentence = str(caught.value)
    assert sentence
    assert "\n" not in sentence
    return sentence


# --- what was measured ----------------------------------------------------------------------------
@pytest.mark.parametrize("name", figures.SPECIMENS)
def test_all_figures_of_a_specimen_match_the_recorded_ones(tmp_path: Path, name: str) -> None:
    found = json.loads(json.dumps(figures.figures_of(figures.copy_of(name, tmp_path))))
    assert list(figures.differences(figures.recorded(name), found)) == []


def test_the_newest_specimen_contains_every_record_field_and_row_kind(specimen: Path) -> None:
    """A failure names what to add in the specimen's script, which is then run."""
    schema, played = read_schema_and_replay(specimen)
    assert (schema, NEWEST) == (SCHEMA_VERSION, f"schema{SCHEMA_VERSION}")
    assert unused_fields(played) == set()
    with closing(sqlite3.connect(specimen / "journal.sqlite")) as db:
        kinds = {kind for (kind,) in db.execute("SELECT DISTINCT kind FROM journal")}
    assert kinds == {"do", "amend", "undo", "redo", "save", "discard", "draft"}
    assert played.draft is not None
    assert played.undone


def unused_fields(played: Replay) -> set[str]:
    """Records of which there is none, and their fields that have their default in all records."""
    used = {(cls.__name__, "") for cls in map(type, played.records.values())}
    for record in played.records.values():
        for field in dataclasses.fields(record):
            if getattr(record, field.name) != field.default:
                used.add((type(record).__name__, field.name))
    every = {
        (cls.__name__, name)
        for cls in codec.RECORD_TYPES.values()
        for name in ("", *(field.name for field in dataclasses.fields(cls)))
    }
    return {".".join(name) for name in every - used}


def test_record_or_field_missing_from_the_specimen_is_reported(specimen: Path) -> None:
    _, played = read_schema_and_replay(specimen)
    played.records = {
        id_: dataclasses.replace(record, domain="") if hasattr(record, "domain") else record
        for id_, record in played.records.items()
        if type(record).__name__ != "Compass"
    }
    unused = unused_fields(played)
    assert {"Compass.", "Compass.north", "Trace.domain", "Reading.domain"} <= unused
    assert "Trace.beds" not in unused


def test_specimen_can_be_undone_to_its_first_row_and_redone(specimen: Path) -> None:
    before = json.loads(json.dumps(figures.figures_of(specimen)))
    opened = figures.open_project(specimen)
    undone = len(figures.walk(opened.session, "undo"))
    assert opened.session.features() == []
    assert undone == len(before["history"]["undo"])
    opened.close()
    # The way back is not forgotten over a closing.
    opened = figures.open_project(specimen)
    for _ in range(undone):
        opened.session.redo()
    opened.close()
    after = json.loads(json.dumps(figures.figures_of(specimen)))
    assert list(figures.differences(before, after)) == []


def test_clicks_of_an_unfinished_trace_are_restored(specimen: Path) -> None:
    opened = figures.open_project(specimen)
    assert opened.session.draft is not None
    assert len(opened.session.draft.state["vertices"]) == 4
    opened.close()


def test_exporting_a_specimen_does_not_modify_it(
    specimen: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    before = hashes(specimen.parent)
    table = tmp_path_factory.mktemp("out") / "t.csv"
    code, _ = figures.command("export", specimen, "--to", "csv", "-o", table)
    assert code == 0
    assert hashes(specimen.parent) == before


def killed_copy(specimen: Path) -> Path:
    """The project as a killed program leaves it: its last rows are in the log beside it."""
    opened = figures.open_project(specimen)
    opened.session.set_draft({"tool": "trace", "vertices": [[0.0, 0.0, 0.0]]})
    killed = specimen.with_name("killed.vom")
    killed.mkdir()
    for name in ("journal.sqlite", "journal.sqlite-wal"):
        shutil.copy(specimen / name, killed / name)
    opened.close()
    return killed


def test_rows_written_before_a_kill_are_restored(specimen: Path) -> None:
    killed = killed_copy(specimen)
    assert (killed / "journal.sqlite-wal").stat().st_size > 0
    opened = figures.open_project(killed)
    assert opened.session.draft is not None
    assert opened.session.draft.state == {"tool": "trace", "vertices": [[0.0, 0.0, 0.0]]}
    assert opened.problems == []
    opened.close()


# --- what is newer, damaged, or gone --------------------------------------------------------------
def test_project_of_a_newer_schema_is_rejected_and_not_modified(specimen: Path) -> None:
    journal = specimen / "journal.sqlite"
    db = sqlite3.connect(journal)
    db.execute("PRAGMA user_version = 99")
    db.close()
    before = hashes(specimen)
    assert "newer VOM Studio" in refusal(specimen)
    assert hashes(specimen) == before
    code, said = figures.command("export", specimen, "--to", "csv", "-o", specimen / "t.csv")
    assert (code, said["error"]["code"]) == (2, "project.newer")
    assert "newer" in said["error"]["message"]
    assert hashes(specimen) == before


def test_killed_project_of_a_newer_schema_is_not_modified(specimen: Path) -> None:
    opened = figures.open_project(specimen)
    opened.session.set_draft({"tool": "trace"})
    with closing(sqlite3.connect(specimen / "journal.sqlite")) as later:
        later.execute("PRAGMA user_version = 99")
        killed = specimen.with_name("killed.vom")
        killed.mkdir()
        for name in ("journal.sqlite", "journal.sqlite-wal"):
            shutil.copy(specimen / name, killed / name)
    opened.close()
    before = hashes(killed)
    assert "newer VOM Studio" in refusal(killed)
    # A connection that nobody holds any more is closed when it is found.
    gc.collect()
    after = hashes(killed)
    assert {name: after.get(name) for name in before} == before


@pytest.mark.parametrize("part", [0.5, 0.02, 0.99])
def test_truncated_journal_is_opened_or_rejected_unmodified(specimen: Path, part: float) -> None:
    journal = specimen / "journal.sqlite"
    whole = journal.read_bytes()
    journal.write_bytes(whole[: int(len(whole) * part)])
    before = journal.read_bytes()
    try:
        opened = figures.open_project(specimen)
    except VomError:
        # With a sentence, at the second try too.
        assert "damaged" in refusal(specimen)
        assert journal.read_bytes() == before
    else:
        assert opened.session.problems
        opened.close()


def test_file_that_is_not_a_journal_is_rejected_and_not_modified(specimen: Path) -> None:
    journal = specimen / "journal.sqlite"
    journal.write_bytes(b"notes of the 3rd of May\n" * 40)
    before = hashes(specimen)
    refusal(specimen)
    assert hashes(specimen) == before


@pytest.mark.parametrize(
    "gone",
    first_in_default_tier(
        [
            "project.gpkg",
            "models/face/face.obj",
            "models",
            "models/face/photos",
            "reconstruction",
            "reconstruction/photos-preview/model.obj",
            "reconstruction/photos-preview/reconstruction.json",
            "photos",
            "../photos",
            "../boulder.ply",
        ],
        2,
    ),
)
def test_missing_files_next_to_the_journal_change_no_figure(
    specimen: Path, recorded: dict[str, Any], gone: str
) -> None:
    path = specimen / gone
    if path.is_dir():
        path.rename(specimen.parent / "moved elsewhere")
    else:
        path.unlink()
    opened = figures.open_project(specimen)
    assert opened.session.problems == ()
    opened.close()
    found = json.loads(json.dumps(figures.figures_of(specimen, history=False)))
    was = {part: recorded[part] for part in found}
    assert list(figures.differences(was, found)) == []


def test_models_inside_and_next_to_the_project_are_found(specimen: Path) -> None:
    opened = figures.open_project(specimen)
    models = {r.name: r for r in opened.session.records.values() if hasattr(r, "content_hash")}
    found = {name: opened.find_model(model) for name, model in models.items()}
    opened.close()
    assert found == {
        "face": specimen / "models/face/face.obj",
        "boulder": specimen.parent / "boulder.ply",
        "photos": specimen / "reconstruction/photos-preview/model.obj",
        "hand specimen": None,
    }


def test_model_copies_match_their_recorded_hashes(specimen: Path) -> None:
    """Line endings that git or a mail program changes would make other files of them."""
    opened = figures.open_project(specimen)
    models = [r for r in opened.session.records.values() if hasattr(r, "content_hash")]
    paths = [(model, opened.find_model(model)) for model in models]
    opened.close()
    for model, path in paths:
        if path is not None:
            assert hashlib.sha256(path.read_bytes()).hexdigest() == model.content_hash
