"""The process is killed, for real, at every moment: what was on the screen is offered back."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.journeys.recorded import LAST, make_studio, on_screen
from vomstudio.project.folder import untitled_projects

ROOT = Path(__file__).resolve().parents[2]


@contextlib.contextmanager
def child(*words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.journeys.recorded", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        process.wait()
        process.stdin.close()
        process.stdout.close()


def said(process: subprocess.Popen[str]) -> dict[str, Any]:
    line = process.stdout.readline()
    assert line, "the session ended early"
    return json.loads(line)


def go(process: subprocess.Popen[str]) -> None:
    process.stdin.write("\n")
    process.stdin.flush()


def kill(process: subprocess.Popen[str]) -> None:
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


def offered_back(named: Path | None) -> dict[str, Any]:
    """What the next start brings, by the way a user has: the offer, or the project's name."""
    studio = make_studio()
    offers: list[list[Path]] = []
    studio.recovery_found.connect(offers.append)
    if named is None:
        studio.new_project()
        studio.offer_recovery()
        assert offers, "nothing was offered"
        folder = offers[0][0]
    else:
        folder = named
    studio.open_path(folder)
    assert studio.project.folder == folder
    assert studio.session.problems == ()
    screen = on_screen(studio)
    studio.project.close()
    return screen


def whole_session(*words: str) -> list[dict[str, Any]]:
    """Every state of the screen, from one run that is left to its end."""
    screens = []
    with child("studio", *words) as process:
        for line in process.stdout:
            screens.append(json.loads(line))
            if screens[-1]["event"] == LAST:
                break
    return screens


def kill_after(number: int, named: Path | None) -> None:
    words = ["studio", "--step", *(["--named", str(named)] if named else [])]
    with child(*words) as process:
        last = said(process)
        for _ in range(number):
            go(process)
            last = said(process)
        kill(process)
    assert offered_back(named) == last["screen"], f"killed after {last['event']} ({number})"


def moments(*numbers: int, often: tuple[int, ...]) -> list[Any]:
    """After so many events; those that are not `often` are slow tests, and so are all others."""
    return [pytest.param(n, marks=[] if n in often else [pytest.mark.slow]) for n in numbers]


@pytest.mark.full
@pytest.mark.parametrize("number", moments(4, 13, 30, 46, 67, often=(13, 46)))
def test_untitled_work_is_offered_after_a_kill(own_folders, qapp, number):
    kill_after(number, None)


@pytest.mark.full
@pytest.mark.parametrize("number", moments(7, 26, 57, 73, 79, often=(26, 79)))
def test_named_work_is_restored_after_a_kill(own_folders, qapp, tmp_path, number):
    kill_after(number, tmp_path / "cliff.vom")


@pytest.mark.full
@pytest.mark.slow
@pytest.mark.parametrize("named", [False, True], ids=["untitled", "named"])
def test_a_kill_after_any_event_loses_nothing(tmp_path, monkeypatch, qapp, named):
    monkeypatch.setenv("VOMSTUDIO_SETTINGS", str(tmp_path / "settings.toml"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "whole"))
    count = len(whole_session())
    assert count > 30
    for number in range(1, count):
        monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / f"{number}"))
        kill_after(number, tmp_path / f"p{number}.vom" if named else None)


@pytest.mark.full
@pytest.mark.slow
def test_kill_at_any_moment_keeps_shown_state_or_the_next_step(
    tmp_path, monkeypatch, qapp, own_folders
):
    """Not between two events but anywhere: a row may be on the disk that was not shown yet."""
    screens = [s["screen"] for s in whole_session()]
    chance = random.Random(7)
    for run in range(12):
        monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / f"run{run}"))
        with child("studio", "--step") as process:
            count = 0
            said(process)
            for _ in range(chance.randrange(2, len(screens) - 1)):
                go(process)
                said(process)
                count += 1
            go(process)
            time.sleep(chance.random() * 0.004)
            kill(process)
        # A drag is one event for a person and several for the program, never half of it here.
        assert offered_back(None) in screens[count : count + 2]


@pytest.mark.full
def test_killed_empty_window_offers_nothing_to_recover(own_folders, qapp):
    with child("studio", "--step") as process:
        said(process)
        kill(process)
    assert untitled_projects(finished=False) == []


def descendants(pid: int) -> list[int]:
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                words = (entry / "stat").read_text().rsplit(")", 1)[1].split()
                if int(words[1]) == pid:
                    found.append(int(entry.name))
    return found


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def window_killed_after(number: int, folder: Path, named: Path | None = None) -> None:
    words = ["window", "--step", "--models", str(folder / "models")]
    words += ["--named", str(named)] if named else []
    with child(*words) as process:
        last = said(process)
        for _ in range(number):
            go(process)
            last = said(process)
        workers = descendants(process.pid)
        assert workers, "the window has no worker process"
        kill(process)
    end = time.monotonic() + 10
    while any(alive(pid) for pid in workers):
        assert time.monotonic() < end, "a worker outlives its killed window"
        time.sleep(0.05)
    assert last["screen"]["models"]
    assert offered_back(named) == last["screen"]


def test_killing_the_full_window_keeps_its_open_trace(own_folders, qapp, tmp_path):
    window_killed_after(10, tmp_path)


@pytest.mark.full
@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 3, 6, 7, 8, 11])
def test_killing_the_full_window_loses_nothing(own_folders, qapp, tmp_path, number):
    window_killed_after(number, tmp_path, None if number % 2 else tmp_path / "cliff.vom")
