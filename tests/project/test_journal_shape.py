"""Journals in which somebody has put programs: refused before one of them runs."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.specimens import figures
from vomstudio.cli import main
from vomstudio.core.errors import InputError
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay

SPECIMENS = Path(__file__).parents[1] / "specimens"
ENDLESS = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n)"

HOSTILE = {
    "a view without end": [
        "ALTER TABLE journal RENAME TO other",
        f"CREATE VIEW journal AS {ENDLESS} SELECT other.* FROM other, n",
    ],
    "a view in the place of the head": [
        "ALTER TABLE head RENAME TO other",
        "CREATE VIEW head AS SELECT * FROM other",
    ],
    "a trigger that takes rows away": [
        "CREATE TRIGGER t AFTER INSERT ON journal BEGIN"
        " DELETE FROM journal WHERE seq < NEW.seq; END"
    ],
    "a trigger without end": [
        f"CREATE TRIGGER t AFTER UPDATE ON head BEGIN INSERT INTO view SELECT 'a', count(*)"
        f" FROM ({ENDLESS} SELECT k FROM n); END"
    ],
    "a column that is worked out": [
        "ALTER TABLE journal ADD COLUMN g TEXT"
        " GENERATED ALWAYS AS (label || zeroblob(900000000)) VIRTUAL"
    ],
    "a condition": [
        "ALTER TABLE view ADD COLUMN c TEXT DEFAULT (1) CHECK (length(zeroblob(900000000)) > 0)"
    ],
    "an index over an expression": ["CREATE INDEX i ON journal (length(label))"],
    "a table of a module": ["CREATE VIRTUAL TABLE f USING fts5(a)"],
}


@pytest.mark.parametrize("how", HOSTILE)
def test_code_in_a_journal_is_not_executed(
    tmp_path: Path, how: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "a.vom"
    shutil.copytree(SPECIMENS / "schema1.vom", folder)
    with closing(sqlite3.connect(folder / "journal.sqlite")) as db, db:
        for words in HOSTILE[how]:
            db.execute(words)
    before = (folder / "journal.sqlite").read_bytes()
    for look in (read_replay, ProjectFolder.open):
        with pytest.raises(InputError) as error:
            look(folder)
        assert error.value.code == "file.unsafe-schema"
        assert error.value.file == str(folder / "journal.sqlite")
    assert main(["project", str(folder), "verify", "--json"]) == 2
    assert "file.unsafe-schema" in capsys.readouterr().out
    assert (folder / "journal.sqlite").read_bytes() == before


@pytest.mark.parametrize("specimen", figures.SPECIMENS)
def test_journals_of_all_versions_have_a_safe_schema(tmp_path: Path, specimen: str) -> None:
    name = f"{specimen}.vom"
    shutil.copytree(SPECIMENS / name, tmp_path / name)
    read_replay(tmp_path / name)
    ProjectFolder.open(tmp_path / name).close()
    with closing(sqlite3.connect(tmp_path / name / "journal.sqlite")) as db:
        # Statistics that SQLite keeps for itself.
        db.execute("ANALYZE")
        db.commit()
    ProjectFolder.open(tmp_path / name).close()
