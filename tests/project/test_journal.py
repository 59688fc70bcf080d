"""The journal on disk: durable, refused where it is not ours, never half written."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import InputError, TargetError
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder, project_folder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


@pytest.fixture
def project(tmp_path):
    project = ProjectFolder.create(tmp_path / "outcrop.vom")
    project.session.apply(edits.add_model(project.session.records, MODEL))
    yield project
    project.close()


def reopen(project: ProjectFolder) -> ProjectFolder:
    project.close()
    return ProjectFolder.open(project.folder)


def test_project_is_unchanged_after_reopening(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    session = project.session
    session.apply(edits.add_model(session.records, MODEL))
    session.apply(edits.add_trace(session.records, bed("t1")))
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.undo()
    session.save()
    records = dict(session.records)
    project = reopen(project)
    assert dict(project.session.records) == records
    assert not project.session.dirty
    project.session.redo()
    assert "t2" in project.session.records
    project.close()


def test_float64_coordinates_are_stored_exactly(project):
    vertices = (
        (576665.7249999999, 5188117.06 + 1e-9, 0.1),
        (1 / 3, 2 / 3, 1e-300),
        (4.0, 5.0, 6.5),
    )
    project.session.apply(edits.add_trace(project.session.records, bed("t1", vertices=vertices)))
    assert read_replay(project.folder).records["t1"].vertices == vertices


def test_an_open_project_can_be_read_by_another_process_but_not_opened(project):
    project.session.apply(edits.add_trace(project.session.records, bed("t1")))
    code = (
        "import sys; from pathlib import Path;"
        "from vomstudio.project.journal.database import read_replay;"
        "from vomstudio.project.folder import ProjectFolder; p = Path(sys.argv[1]);"
        "print(len(read_replay(p).records));"
        "import vomstudio.core.errors\n"
        "try: ProjectFolder.open(p)\n"
        "except vomstudio.core.errors.InputError as e: print(e)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(project.folder)],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
    )
    count, message = done.stdout.splitlines()
    assert int(count) == len(project.session.records)
    assert f"process {os.getpid()}" in message


def test_closed_project_stores_everything_in_one_file(project):
    project.session.apply(edits.add_trace(project.session.records, bed("t1")))
    project.close()
    assert not list(project.folder.glob("journal.sqlite-*"))
    assert "t1" in read_replay(project.folder).records
    reopened = ProjectFolder.open(project.folder)
    project.__dict__.update(reopened.__dict__)


def test_newer_journal_is_rejected(tmp_path):
    ProjectFolder.create(tmp_path / "a.vom").close()
    db = sqlite3.connect(tmp_path / "a.vom" / "journal.sqlite")
    db.execute("PRAGMA user_version = 99")
    db.close()
    with refused("project.newer"):
        ProjectFolder.open(tmp_path / "a.vom")


@pytest.mark.parametrize("content", [b"", b"not a database", b"SQLite format 3\x00" + b"\x00" * 90])
def test_invalid_journal_is_rejected(tmp_path, content):
    folder = tmp_path / "a.vom"
    folder.mkdir()
    (folder / "journal.sqlite").write_bytes(content)
    with pytest.raises(InputError) as refused:
        ProjectFolder.open(folder)
    assert "journal.sqlite" in str(refused.value)


@pytest.mark.parametrize("cut", [0.001, 0.1, 0.12, 0.5, 0.9, 0.9999])
def test_torn_journal_is_rejected_or_opens_with_reported_losses(tmp_path, cut):
    project = ProjectFolder.create(tmp_path / "a.vom")
    project.session.apply(edits.add_model(project.session.records, MODEL))
    for number in range(60):
        project.session.apply(edits.add_trace(project.session.records, bed(f"t{number}")))
    whole_records = dict(project.session.records)
    project.close()
    path = tmp_path / "a.vom" / "journal.sqlite"
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * cut)])
    try:
        project = ProjectFolder.open(tmp_path / "a.vom")
    except InputError as error:
        message = str(error)
    else:
        message = "journal.sqlite"
        # Only the unused end of the file was cut off, or rows that are named.
        lost = set(whole_records) - set(project.session.records)
        assert len(project.problems) >= len(lost)
        assert all(
            project.session.records[i] == whole_records[i] for i in whole_records if i not in lost
        )
        project.close()
    assert "journal.sqlite" in message


@pytest.mark.parametrize("what", ["nothing", "folder", "file"])
def test_path_without_a_project_is_rejected(tmp_path, what):
    path = tmp_path / "x.vom"
    if what == "folder":
        path.mkdir()
    elif what == "file":
        path.write_text("x")
    code = "project.missing" if what == "nothing" else "project.not-a-project"
    with refused(code):
        project_folder(path)


def test_existing_project_is_not_overwritten(tmp_path):
    ProjectFolder.create(tmp_path / "a.vom").close()
    with refused("project.exists", TargetError):
        ProjectFolder.create(tmp_path / "a.vom")


def test_saving_as_copies_the_history_and_leaves_the_old_project_as_saved(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    session = project.session
    session.apply(edits.add_model(session.records, MODEL))
    session.save()
    session.apply(edits.add_trace(session.records, bed("t1")))
    project.save_as(tmp_path / "b.vom")
    session.apply(edits.add_trace(session.records, bed("t2")))
    session.undo()
    session.undo()
    assert not session.of(Trace)
    session.redo()
    project.close()
    assert {"t1"} == {i for i in read_replay(tmp_path / "b.vom").records if i.startswith("t")}
    old = ProjectFolder.open(tmp_path / "a.vom")
    assert not old.session.of(Trace)
    assert not old.session.dirty
    old.session.undo()
    assert "t1" in old.session.records
    old.close()


def test_non_empty_folder_is_not_saved_over(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    (tmp_path / "b.vom").mkdir()
    (tmp_path / "b.vom" / "precious.txt").write_text("x")
    with refused("folder.not-empty", TargetError):
        project.save_as(tmp_path / "b.vom")
    assert (tmp_path / "b.vom" / "precious.txt").read_text() == "x"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.vom", "b.vom"]
    project.close()


_WRITER = """
import sys
from pathlib import Path
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.folder import ProjectFolder
sys.path.insert(0, sys.argv[2])
from tests.samples import bed
project = ProjectFolder.open(Path(sys.argv[1]))
for number in range(10_000):
    trace = bed(f"t{number}")
    project.session.set_draft({"tool": "trace", "number": number})
    project.session.apply(edits.add_trace(project.session.records, trace), finishes_draft=True)
    print(number, flush=True)
"""


def test_edits_shown_before_a_kill_are_kept(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    project.session.apply(edits.add_model(project.session.records, MODEL))
    project.close()
    root = Path(__file__).parents[2]
    for wait_for in (0, 3, 17):
        child = subprocess.Popen(
            [sys.executable, "-c", _WRITER, str(tmp_path / "a.vom"), str(root)],
            stdout=subprocess.PIPE,
            text=True,
            cwd=root,
        )
        shown = -1
        while shown < wait_for:
            shown = int(child.stdout.readline())
        time.sleep(0.003 * wait_for)
        child.send_signal(signal.SIGKILL)
        rest = child.stdout.read().split()
        shown = int(rest[-1]) if rest else shown
        child.stdout.close()
        child.wait()
        project = ProjectFolder.open(tmp_path / "a.vom")
        kept = [t.id for t in project.session.of(Trace)]
        assert kept[: shown + 1] == [f"t{i}" for i in range(shown + 1)]
        assert len(kept) <= shown + 2
        assert not project.session.problems
        for trace in list(project.session.of(Trace)):
            project.session.apply(edits.delete(project.session.records, [trace.id]))
        project.session.save()
        project.close()
