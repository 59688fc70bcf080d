"""A lock keeps others out, and never its owner."""

from __future__ import annotations

import contextlib
import random
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.core.files.lock import ProjectLock


def whole(folder: Path) -> bytes:
    ProjectLock(folder / "lock").release()
    return (folder / "lock").read_bytes()


def test_damaged_lock_can_be_acquired(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    good = whole(tmp_path)
    chance = random.Random(1)
    cases = [b"", b"hello", b"\0" * 4096, good[:-1], good[: len(good) // 2]]
    for _ in range(200):
        data = bytearray(good)
        for _ in range(chance.choice([1, 3, 20, 200])):
            at = chance.randrange(len(data) if chance.random() < 0.5 else 120)
            data[at] = chance.randrange(256)
        cases.append(bytes(data))
    for data in cases:
        path.write_bytes(data)
        lock = ProjectLock(path)
        with refused("project.locked"):
            ProjectLock(path)
        lock.release()


@pytest.mark.parametrize(
    "statement", ["CREATE TABLE holder (a, b, c)", "CREATE VIEW holder AS SELECT 1"]
)
def test_lock_with_other_schema_can_be_acquired(tmp_path: Path, statement: str) -> None:
    db = sqlite3.connect(tmp_path / "lock")
    db.execute(statement)
    db.close()
    ProjectLock(tmp_path / "lock").release()


def test_lock_held_by_another_process_is_refused_until_it_ends(tmp_path: Path) -> None:
    code = (
        "import sys, pathlib; from vomstudio.core.files.lock import ProjectLock;"
        "lock = ProjectLock(pathlib.Path(sys.argv[1])); print('held', flush=True);"
        "sys.stdin.read()"
    )
    root = Path(__file__).resolve().parents[3]
    with subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "lock")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=root,
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with refused("project.locked"):
            ProjectLock(tmp_path / "lock")
        other.kill()
    # Whoever is killed holds nothing any more.
    ProjectLock(tmp_path / "lock").release()


def test_lock_creation_error_is_reported(tmp_path: Path) -> None:
    (tmp_path / "lock").mkdir()
    with refused("project.unwritable", TargetError):
        ProjectLock(tmp_path / "lock")


@pytest.mark.parametrize(
    "words",
    [
        "CREATE TRIGGER t AFTER INSERT ON holder BEGIN INSERT INTO holder SELECT k, k FROM"
        " (WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT k FROM n); END",
        "CREATE INDEX i ON holder (length(host))",
        "CREATE TABLE other (a)",
    ],
)
def test_lock_with_foreign_schema_objects_is_recreated(tmp_path: Path, words: str) -> None:
    path = tmp_path / "lock"
    ProjectLock(path).release()
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute(words)
    lock = ProjectLock(path)
    with refused("project.locked"):
        ProjectLock(path)
    lock.release()
    with contextlib.closing(sqlite3.connect(path)) as db:
        assert len(db.execute("SELECT * FROM sqlite_master").fetchall()) == 1
