"""What a report tells, and above all what it keeps to itself."""

from __future__ import annotations

import logging
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from vomstudio.core.failures import crashes, log, log_file, report
from vomstudio.core.failures.redaction import redact
from vomstudio.project.journal.outline import outline
from vomstudio.project.journal.replay import JournalRow


@pytest.fixture
def logging_on(own_folders):
    log.start("test")
    yield
    log.stop()


def test_redacted_paths_keep_only_their_extension():
    home = str(Path.home())
    text = redact(f"'{home}/Val Camonica/cliff 12.obj' /media/anna/disk 1/a.jpg: no")
    assert "Camonica" not in text
    assert "anna" not in text
    assert "disk" not in text
    assert home not in text
    assert text == "'~/….obj' /….jpg: no"


@pytest.mark.parametrize(
    "text",
    [
        r"D:\Surveys\anna\Val Camonica\cliff.obj",
        r"'D:\\Surveys\\anna\\cliff.obj'",
        r"\\server\anna\a.las",
    ],
)
def test_windows_paths_are_redacted(text):
    left = redact(text)
    assert "anna" not in left
    assert "cliff" not in left


def test_paths_of_program_files_stay_readable():
    import numpy

    from vomstudio.ui.base import studio

    text = redact(f'File "{studio.__file__}", line 12, in f\nFile "{numpy.__file__}", line 3, in g')
    own, foreign = Path(studio.__file__), Path(numpy.__file__)
    program, packages = own.parents[2], foreign.parents[1]
    assert re.findall(r'"(.*?)", line (\d+)', text) == [
        (f"<program>/{own.relative_to(program).as_posix()}", "12"),
        (f"<packages>/{foreign.relative_to(packages).as_posix()}", "3"),
    ]


def test_coordinates_are_redacted_but_not_versions():
    text = redact("(432100.25, 5123456, -12.5) [1. 2.5e3] numpy 2.3.4, line 812, 2026-02-03")
    assert text == "(#, #, #) [# #] numpy 2.3.4, line 812, 2026-02-03"


def test_user_given_names_are_redacted():
    text = "Upper Cliff has no fit, nor has Upper"
    left = redact(text, ["Upper", "Upper Cliff"])
    assert left.split("…") == ["", *re.findall(" has no fit, nor has ", text), ""]


def test_file_names_without_path_are_redacted():
    assert redact("anna_west.LAZ and error.py") == "….LAZ and error.py"


def row(kind: str = "do", label: str = "", before=None, after=None) -> JournalRow:
    return JournalRow(7, kind, None, label, before, after, "2026-02-03T10:00:00", "1", {"s": 1})


def test_outline_lists_kinds_and_fields_without_values():
    trace = {
        "record": "trace",
        "name": "Anna's bed",
        "vertices": [[432100.5, 1.0, 2.0]],
        "notes": "",
    }
    moved = {**trace, "vertices": [[432101.5, 1.0, 2.0]]}
    lines = outline(
        [
            row(label="Add bedding trace Anna's bed", before={"t": None}, after={"t": trace}),
            row(label="Change trace Anna's bed", before={"t": trace}, after={"t": moved}),
            row("undo", "Delete 12 features"),
            row("draft", after={"tool": "trace", "vertices": [[432100.5, 1, 2]]}),
        ]
    )
    text = "\n".join(lines)
    assert "432" not in text
    assert "Anna" not in text
    assert all("…" in line for line in lines[:2])
    assert re.findall(r"\w+", lines[0])[-3:] == ["name", "vertices", "notes"]
    assert lines[1].endswith("(vertices)")
    assert " 12 " in lines[2]
    assert lines[3].endswith("vertices 1")


def test_damaged_row_is_outlined():
    (line,) = outline([row(before=[1], after={"t": "nonsense", "u": {"record": "a name!"}})])
    assert "nothing" in line
    assert "a name" not in line


@pytest.mark.expects_log
def test_failed_section_is_reported_and_others_are_included(logging_on):
    def broken():
        raise OSError("no")

    logging.getLogger("vomstudio.test").error("odd: 432100.25")
    text = report.compose([("What was done", broken)])
    assert "## What was done\n\nThis section failed (OSError)." in text
    assert "odd: #" in text
    assert "Python" in text
    assert "numpy" in text
    assert str(Path.home()) not in text


def test_crashed_process_leaves_traceback_and_clean_exit_does_not(own_folders):
    words = (
        "from vomstudio.core.failures import crashes, exception_hooks\n"
        "exception_hooks.install(crashes.WINDOW)\n"
        "import os, sys\n"
        "if 'die' in sys.argv: os.abort()\n"
        "exception_hooks.uninstall()\n"
    )
    subprocess.run([sys.executable, "-c", words], check=True, cwd=os.getcwd())
    assert not crashes.has_new_crash()
    assert crashes.texts() == []
    subprocess.run([sys.executable, "-c", words, "die"], check=False, capture_output=True)
    assert crashes.has_new_crash()
    assert not crashes.has_new_crash(), "told of once"
    ((whose, text),) = crashes.texts()
    assert whose == "window"
    assert "Aborted" in text
    assert "Aborted" in report.compose()


def test_killed_process_is_not_a_crash(own_folders):
    folder = crashes.folder()
    folder.mkdir(parents=True)
    (folder / "window-999999999-20260203100000.txt").touch()
    assert not crashes.has_new_crash()
    assert list(folder.iterdir()) == []


@pytest.mark.expects_log
def test_several_processes_share_a_rotating_log(own_folders, monkeypatch):
    monkeypatch.setattr(log_file, "_MAX_BYTES", 2000)
    first, second = log_file.SharedFile(log.path()), log_file.SharedFile(log.path())
    log.folder().mkdir(parents=True)
    for number in range(60):
        for who, handler in (("first", first), ("second", second)):
            handler.emit(logging.makeLogRecord({"msg": f"{who} says {number} " + "-" * 40}))
    for handler in (first, second):
        handler.close()
    text = log.path().read_text()
    assert "first says 59" in text
    assert "second says 59" in text
    assert len(list(log.folder().glob("vomstudio.log*"))) <= 3


def test_unwritable_log_does_not_raise(own_folders, monkeypatch):
    (own_folders / "file").touch()
    monkeypatch.setattr(log, "folder", lambda: own_folders / "file" / "log")
    log.start("test")
    try:
        logging.getLogger("vomstudio").info("nobody reads this")
        assert log.tail(5) == ""
    finally:
        log.stop()


def test_log_file_is_created_with_first_message(own_folders):
    log.start("test")
    try:
        assert not log.folder().exists()
        for words in ("first", "second"):
            logging.getLogger("vomstudio").info(words)
        assert [line.split()[-1] for line in log.tail(5).splitlines()] == ["first", "second"]
    finally:
        log.stop()
