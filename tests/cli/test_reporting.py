"""Progress of commands: estimates, plain lines, and the line on a terminal."""

from __future__ import annotations

import contextlib
import fcntl
import io
import json
import os
import re
import struct
import termios
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO

import pytest
from rich.cells import cell_len

from vomstudio.cli.common import reporting
from vomstudio.cli.common.progress_snapshot import (
    MIN_STEPS_FOR_ESTIMATE,
    Snapshot,
    StepClock,
    format_duration,
)
from vomstudio.cli.common.reporting import MIN_LINE_GAP_S, PlainLines, choose_painter
from vomstudio.cli.common.terminal_line import TerminalLine, format_rounded_duration

ESCAPE = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


def snapshot(
    stage: str = "Matching photos", done: int = 5, total: int | None = 12, **more: object
) -> Snapshot:
    values = {"part": None, "elapsed_s": 65.0, "remaining_s": 40.0, **more}
    return Snapshot(stage, done, total, **values)  # type: ignore[arg-type]


# Estimates ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("begin", [0, 400])
def test_remaining_time_is_extrapolated_from_equal_steps(begin: int) -> None:
    steps = StepClock(1000)
    for k in range(101):
        steps.step(begin + k, 50.0 + 0.5 * k)
    assert steps.remaining_s(100.0) == pytest.approx(0.5 * (900 - begin))
    # Within a step it runs down.
    assert steps.remaining_s(100.25) == pytest.approx(0.5 * (900 - begin) - 0.25)


def test_no_estimate_is_made_from_too_few_measurements() -> None:
    steps = StepClock(10)
    assert steps.remaining_s(60.0) is None
    for k in range(MIN_STEPS_FOR_ESTIMATE):
        steps.step(k, 10.0 * k)
        assert steps.remaining_s(10.0 * k) is None
    quick = StepClock(1000)
    for k in range(500):
        quick.step(k, 0.001 * k)
    assert quick.remaining_s(0.5) is None
    unknown = StepClock(None)
    for k in range(100):
        unknown.step(k, float(k))
    assert unknown.remaining_s(100.0) is None


def test_long_running_step_increases_the_estimate() -> None:
    steps = StepClock(100)
    for k in range(11):
        steps.step(k, float(k))
    assert steps.remaining_s(10.0) == pytest.approx(90.0)
    assert (steps.remaining_s(50.0) or 0.0) > 200.0
    steps.step(100, 51.0)
    assert steps.remaining_s(51.0) is None


def test_durations_are_formatted_as_clock_times_and_estimates_rounded() -> None:
    assert [format_duration(s) for s in (0.9, 61, 3599.9, 3600, 36061)] == [
        "0:00",
        "1:01",
        "59:59",
        "1:00:00",
        "10:01:01",
    ]
    assert [format_rounded_duration(s) for s in (0, 11, 57, 58, 89, 91, 3569, 3600, 4500)] == [
        "5 s",
        "15 s",
        "60 s",
        "1 min",
        "1 min",
        "2 min",
        "59 min",
        "1 h 0 min",
        "1 h 15 min",
    ]


# Plain lines -------------------------------------------------------------------------------------
def test_short_stages_are_throttled_and_long_ones_all_shown() -> None:
    stream = io.StringIO()
    lines = PlainLines(stream)
    now = 2.0
    for k in range(400):
        lines.show(snapshot(f"Short {k}", elapsed_s=now))
        now += 0.1
    for k in range(4):
        for _ in range(20):
            now += 0.25
            lines.show(snapshot(f"Long {k}", total=None, elapsed_s=now))
    text = stream.getvalue()
    assert text.count("\n") <= 1 + (now - 2.0) / MIN_LINE_GAP_S
    assert [text.count(f"Long {k}\n") for k in range(4)] == [1, 1, 1, 1]
    assert "\r" not in text
    assert "\x1b" not in text


def test_plain_lines_show_part_and_meaningful_totals() -> None:
    stream = io.StringIO()
    for done, part, total in ((0, None, 12), (3, (2, 5), 10**9), (0, None, None), (0, None, 1)):
        PlainLines(stream).show(snapshot(done=done, part=part, total=total))
    assert stream.getvalue().splitlines() == [
        "[1:05] Matching photos (12)",
        "[1:05] Step 2/5: Matching photos",
        "[1:05] Matching photos",
        "[1:05] Matching photos",
    ]


def test_control_characters_in_file_names_are_escaped() -> None:
    stream = io.StringIO()
    PlainLines(stream).show(snapshot("Reading a\x1b]0;mine\x07\nb.csv"))
    assert stream.getvalue() == "[1:05] Reading a\\u001b]0;mine\\u0007 b.csv (12)\n"


# On a terminal -----------------------------------------------------------------------------------
Terminal = tuple[TextIO, Callable[[], str]]


@pytest.fixture
def terminal() -> Iterator[Callable[[int], Terminal]]:
    closing = contextlib.ExitStack()

    def make(columns: int) -> Terminal:
        ours, theirs = os.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        closing.callback(os.close, ours)
        stream = closing.enter_context(os.fdopen(theirs, "w", encoding="utf-8"))

        def read() -> str:
            stream.flush()
            return os.read(ours, 65536).decode()

        return stream, read

    with closing:
        yield make


@pytest.mark.parametrize("columns", [0, 200, 80, 60, 40, 20, 8, 3])
def test_terminal_line_fits_width_and_drops_stage_name_last(
    terminal: Callable[[int], Terminal], columns: int
) -> None:
    stream, read = terminal(columns)
    line = TerminalLine(stream)
    wide = snapshot("地層を調べる", part=(2, 5))
    for shown in (snapshot(), wide, snapshot(total=None, remaining_s=None), snapshot("x" * 300)):
        line.show(shown)
        drawn = read()
        assert drawn.startswith("\r\x1b[2K")
        assert drawn.count("\r") == 1
        assert "\n" not in drawn
        assert "\x1b[?25l" not in drawn, "a hidden cursor would outlive an abort"
        text = ESCAPE.sub("", drawn).lstrip("\r")
        assert cell_len(text) < (columns or 80)
    line.show(snapshot())
    text = ESCAPE.sub("", read()).lstrip("\r")
    known = {0: 80, 200: 80}.get(columns, columns)
    assert ("━" in text) == (known >= 80)
    assert ("elapsed 1:05" in text) == (known >= 60)
    assert ("5 of 12" in text) == (known >= 40)
    assert ("Matching" in text) == (known >= 20)
    line.close()
    assert read() == "\r\x1b[2K"


def test_no_color_variable_disables_colour(
    terminal: Callable[[int], Terminal], monkeypatch: pytest.MonkeyPatch
) -> None:
    colour = re.compile(r"\x1b\[(?:\d+;)*(?:3[0-8]|9[0-7])[;\dm]")
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    stream, read = terminal(100)
    TerminalLine(stream).show(snapshot())
    assert colour.search(read())
    monkeypatch.setenv("NO_COLOR", "1")
    TerminalLine(stream).show(snapshot())
    assert not colour.search(read())


def test_a_job_in_the_background_does_not_draw(
    terminal: Callable[[int], Terminal], monkeypatch: pytest.MonkeyPatch
) -> None:
    stream, read = terminal(100)
    line = TerminalLine(stream)
    monkeypatch.setattr("os.tcgetpgrp", lambda _: os.getpgrp() + 1)
    line.show(snapshot())
    line.close()
    stream.write("prompt")
    assert read() == "prompt"


@pytest.mark.parametrize("term", ["dumb", "unknown", ""])
def test_terminals_that_cannot_rewrite_a_line_get_plain_lines(
    terminal: Callable[[int], Terminal], monkeypatch: pytest.MonkeyPatch, term: str
) -> None:
    stream, _ = terminal(100)
    monkeypatch.setenv("TERM", "xterm")
    assert isinstance(choose_painter(stream), TerminalLine)
    monkeypatch.setenv("TERM", term)
    assert isinstance(choose_painter(stream), PlainLines)


# Quiet -------------------------------------------------------------------------------------------
def test_quiet_suppresses_notes_but_not_the_result(run, write) -> None:
    points = write("x,y,z,trace\n0,0,0,a\n1,0,0,a\n0,1,0,a\n1,1,0.1,a\n0,0,0,b\n")
    loud, quiet = run("fit", points), run("fit", points, "--quiet")
    assert loud.err
    assert (quiet.out, quiet.err, quiet.code) == (loud.out, "", 0)
    spoken = run("fit", points, "--json", "-q")
    assert (spoken.err, spoken.json["planes"][0]["n_points"]) == ("", 5)
    silent = run("fit", points, "--quiet", "--progress", "json")
    assert (silent.out, silent.err) == (loud.out, "")


def test_quiet_still_reports_errors(run, write, tmp_path: Path) -> None:
    bad = write("nothing", "bad.obj")
    assert str(bad) in run("fit", tmp_path / "missing.csv", "-q").err + str(bad)
    assert "missing.csv" in run("fit", tmp_path / "missing.csv", "-q").said
    good = write("x,y,z\n0,0,0\n1,0,0\n0,1,0\n1,1,0.1\n", "good.csv")
    some = run("info", good, bad, "-q")
    assert some.code == 2
    assert str(bad) in some.said


def test_quiet_is_accepted_before_and_after_project_action(run, tmp_path: Path) -> None:
    project = tmp_path / "p.vom"
    for words in (["-q", project, "list"], [project, "list", "--quiet"]):
        assert "p.vom" in run("project", *words).said


def test_stage_events_contain_part_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    progress = reporting.JsonProgress()
    progress.stage("Reading", 3)
    progress.part(2, 5)
    progress.stage("Drawing")
    progress.step(1)
    assert [json.loads(line) for line in capsys.readouterr().err.splitlines()] == [
        {"event": "stage", "stage": "Reading", "total": 3},
        {"event": "stage", "stage": "Drawing", "total": None, "part": 2, "parts": 5},
        {"event": "step", "stage": "Drawing", "done": 1},
    ]
