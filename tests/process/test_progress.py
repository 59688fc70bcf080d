"""Progress of real commands on terminals, pipes and files."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tiers import first_in_default_tier
from vomstudio.cli.common.reporting import DELAY_VARIABLE
from vomstudio.core.findings import Finding

ROOT = Path(__file__).resolve().parents[2]
POINTS = b"x,y,z\n0,0,0\n1,0,0\n0,1,0\n1,1,0.1\n"
PROGRAM = [sys.executable, "-P", "-m", "vomstudio"]
ERASE = "\r\x1b[2K"
PATIENCE_S = 60.0


def environment(delay_s: float, term: str = "xterm-256color") -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), DELAY_VARIABLE: str(delay_s), "TERM": term}


class Recording:
    """A command on a terminal of its own, and what it wrote there."""

    def __init__(self, words: list[str], delay_s: float, columns: int = 100) -> None:
        self.text = ""
        self.pid, self._terminal = pty.fork()
        if self.pid == 0:
            with contextlib.suppress(BaseException):
                fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 30, columns, 0, 0))
                # The test run itself may ignore them, in the background or under nohup.
                signal.signal(signal.SIGINT, signal.default_int_handler)
                signal.signal(signal.SIGHUP, signal.SIG_DFL)
                os.execve(PROGRAM[0], [*PROGRAM, *words], environment(delay_s))
            os._exit(99)

    def read_until(self, condition: Callable[[str], object]) -> None:
        """Read on until the text satisfies the condition; fail if it never does."""
        end = time.monotonic() + PATIENCE_S
        while not condition(self.text):
            assert time.monotonic() < end, self.text
            assert self._read(), self.text

    def type(self, keys: bytes) -> None:
        os.write(self._terminal, keys)

    def finish(self) -> int:
        """Read to the end and return the exit code."""
        while self._read():
            pass
        end = time.monotonic() + PATIENCE_S
        while os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
            if time.monotonic() > end:
                os.kill(self.pid, signal.SIGKILL)
            time.sleep(0.01)
        _, status = os.waitpid(self.pid, 0)
        os.close(self._terminal)
        return os.waitstatus_to_exitcode(status)

    def _read(self) -> bool:
        if not select.select([self._terminal], [], [], PATIENCE_S)[0]:
            return False
        try:
            data = os.read(self._terminal, 65536)
        except OSError:  # the program has ended
            return False
        self.text += data.decode("utf-8", "replace")
        return bool(data)


@pytest.fixture
def slow(tmp_path: Path) -> Path:
    """A file of points that a command waits for until they are written."""
    pipe = tmp_path / "slow.csv"
    os.mkfifo(pipe)
    return pipe


def test_terminal_shows_progress_in_one_line_and_then_the_result(slow: Path) -> None:
    command = Recording(["fit", str(slow)], 0.0)
    command.read_until(lambda text: text.count(ERASE) > 5 and "Reading slow.csv" in text)
    with open(slow, "wb") as writer:
        writer.write(POINTS)
    assert command.finish() == 0
    frames = command.text.split(ERASE)
    drawn, after = frames[1:-1], frames[-1]
    assert any("Reading slow.csv" in frame for frame in drawn)
    assert all("\n" not in frame for frame in drawn)
    # The line is cleared before anything else is written, and the cursor was never hidden.
    assert "elapsed" not in after
    assert after.count("\n") > 2
    assert "\x1b[?25l" not in command.text


@pytest.mark.parametrize("how", first_in_default_tier(["Ctrl+C", "SIGTERM", "SIGHUP"]))
def test_stopped_command_leaves_a_clean_terminal(slow: Path, how: str) -> None:
    command = Recording(["fit", str(slow)], 0.0)
    with open(slow, "wb") as writer:  # it has opened the file: from here on it reads
        command.read_until(lambda text: text.count(ERASE) > 3)
        if how == "Ctrl+C":
            command.type(b"\x03")
        else:
            os.kill(command.pid, getattr(signal, how))
        writer.flush()
        assert command.finish() == 130
    _, _, end = command.text.rpartition(ERASE)
    assert end == "vomstudio: Cancelled.\r\n"
    assert "\x1b[?25l" not in command.text


def test_progress_is_neither_drawn_nor_imported_before_the_delay(tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_bytes(POINTS)
    script = (
        "import sys; from vomstudio.app import main; code = main(['fit', sys.argv[1], '--json'])\n"
        "print(code, *sorted(sys.modules))"
    )
    ours, theirs = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-c", script, str(points)],
        stdout=subprocess.PIPE,
        stderr=theirs,
        env=environment(600.0),
        text=True,
        timeout=PATIENCE_S,
    )
    os.write(theirs, b"|")
    drawn = os.read(ours, 65536).decode()
    os.close(ours)
    os.close(theirs)
    result, loaded = done.stdout.splitlines()
    assert json.loads(result)["planes"]
    assert loaded.split()[0] == "0"
    assert not [name for name in loaded.split() if name.partition(".")[0] == "rich"]
    assert "\r\x1b" not in drawn
    assert "Reading" not in drawn


def piped(slow: Path, *words: str, delay_s: float = 0.0) -> tuple[bytes, bytes, int]:
    """Output of a command that takes a second, on pipes."""
    process = subprocess.Popen(
        [*PROGRAM, "fit", str(slow), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(delay_s),
    )
    try:
        with open(slow, "wb") as writer:
            time.sleep(1.0)
            writer.write(POINTS)
        out, err = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
        process.communicate()
    return out, err, process.returncode


def test_pipe_gets_plain_progress_lines_beside_the_json(slow: Path) -> None:
    out, err, code = piped(slow, "--json")
    assert code == 0
    assert json.loads(out)["planes"][0]["n_points"] == 4
    lines = err.decode().splitlines()
    assert re.fullmatch(r"\[0:0\d\] Reading slow\.csv", lines[0])
    assert not re.search(rb"[\r\x1b]", err)


def test_json_progress_consists_of_json_lines(slow: Path) -> None:
    out, err, code = piped(slow, "--progress", "json", "--json")
    assert code == 0
    assert json.loads(out)["planes"]
    events = [json.loads(line) for line in err.splitlines()]
    assert events[0] == {"event": "stage", "stage": "Reading slow.csv", "total": None}
    assert {event["event"] for event in events} <= {"stage", "step", "text"}


def test_quiet_writes_nothing_to_stderr(slow: Path) -> None:
    loud = piped(slow, "--json", delay_s=600.0)
    assert loud[1]
    assert piped(slow, "--json", "--quiet") == (loud[0], b"", 0)


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="no descriptors to look at")
def test_quiet_silences_libraries_and_shows_the_failure(tmp_path: Path) -> None:
    noisy = (
        "import os, sys, vomstudio.io.text.tables as t\n"
        "from vomstudio.core.findings import Finding\n"
        "def noise(*a):\n"
        "    os.write(1, b'from C'); os.write(2, b'from C'); print('from Python')\n"
        "    print('from Python', file=sys.stderr); os.system('echo from a child >&2')\n"
        "    raise t.InputError(Finding('file.empty'), file='f.csv')\n"
        "t.read_points = noise\n"
        "from vomstudio.cli import main; sys.exit(main())"
    )
    points = tmp_path / "points.csv"
    points.write_bytes(POINTS)
    done = subprocess.run(
        [sys.executable, "-c", noisy, "fit", str(points), "--quiet"],
        capture_output=True,
        env=environment(0.0),
        text=True,
        timeout=PATIENCE_S,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines() == [f"vomstudio: f.csv: {Finding('file.empty')}"]


@pytest.mark.full
def test_the_demo_numbers_its_steps(tmp_path: Path) -> None:
    command = Recording(["demo", "-o", str(tmp_path / "out"), "--without-photos"], 0.0)
    assert command.finish() == 0
    numbers = [int(n) for n in re.findall(r"Step (\d)/4: ", command.text)]
    assert numbers == sorted(numbers)
    assert set(numbers) >= {1, 2, 4}
    assert "Measuring the sample" in command.text
