"""Progress of a command on stderr: an updating line, plain lines, or JSON lines."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from typing import Any, Protocol, TextIO

from vomstudio.cli.common.output import silence_output, to_json
from vomstudio.cli.common.progress_snapshot import MAX_COUNT, Snapshot, StepClock, format_duration
from vomstudio.core.errors import Cancelled
from vomstudio.core.progress import CancelToken, Progress, SilentProgress
from vomstudio.core.threads import start_thread

DELAY_VARIABLE = "VOMSTUDIO_PROGRESS_DELAY_S"
"""Environment variable that overrides `DEFAULT_DELAY_S`; used by tests."""
DEFAULT_DELAY_S = 2.0
MIN_LINE_GAP_S = 3.0
"""Minimum time between two plain lines."""
PLAIN_PERIOD_S = 0.25


class Reporter(Progress, Protocol):
    """Progress of a command, which may consist of numbered parts with their own stages."""

    def part(self, number: int, count: int) -> None:
        """Begin part `number` (from 1) of `count`; subsequent stages belong to this part."""


class SilentReporter(SilentProgress):
    """Reporter that shows nothing."""

    def part(self, number: int, count: int) -> None:
        """Ignore the numbered parts."""


class JsonProgress:
    """Progress as JSON lines on stderr, for programs that start the command."""

    def __init__(self, token: CancelToken | None = None) -> None:
        self._token = token
        self._stage = ""
        self._part: dict[str, int] = {}

    def part(self, number: int, count: int) -> None:
        """Store the numbers, which stage events contain as `part` and `parts`."""
        self._part = {"part": number, "parts": count}

    def stage(self, name: str, total: int | None = None) -> None:
        """Begin a stage and write its event."""
        self._stage = name
        self._emit({"event": "stage", "stage": name, "total": total, **self._part})

    def step(self, done_count: int) -> None:
        """Write an event for the completed steps."""
        self._emit({"event": "step", "stage": self._stage, "done": done_count})

    def _emit(self, event: Mapping[str, Any]) -> None:
        if self._token is not None and self._token.cancelled:
            raise Cancelled()
        print(to_json(event), file=sys.stderr, flush=True)


class StageLines:
    """Reporter that writes a line for every stage as soon as it begins."""

    def __init__(self, stream: TextIO, start_time_s: float) -> None:
        self._stream, self._start_time_s = stream, start_time_s
        self._part = ""

    def part(self, number: int, count: int) -> None:
        """Store the number of the part for subsequent lines."""
        self._part = f"{number}/{count} "

    def stage(self, name: str, total: int | None = None) -> None:
        """Write a line for the stage that begins."""
        elapsed_s = time.monotonic() - self._start_time_s
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(f"[{elapsed_s:.2f} s] {self._part}{name}\n")
            self._stream.flush()

    def step(self, done_count: int) -> None:
        """Ignore the completed steps."""


class Painter(Protocol):
    """Interface for showing snapshots on a stream."""

    period_s: float

    def show(self, snapshot: Snapshot) -> None:
        """Show the current state."""

    def close(self) -> None:
        """Finish the display before other text is written to the stream."""


class PlainLines:
    """Painter for files and pipes, with one line per stage and none for short stages."""

    period_s = PLAIN_PERIOD_S

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._last_stage: tuple[object, str] | None = None
        self._last_time_s = -MIN_LINE_GAP_S

    def show(self, snapshot: Snapshot) -> None:
        """Write a line if a new stage has begun and the last line is not too recent."""
        stage = (snapshot.part, snapshot.stage)
        if not snapshot.stage or stage == self._last_stage:
            return
        if snapshot.elapsed_s - self._last_time_s < MIN_LINE_GAP_S:
            return
        self._last_stage, self._last_time_s = stage, snapshot.elapsed_s
        total = snapshot.total
        count = f" ({total})" if total is not None and 1 < total <= MAX_COUNT else ""
        self._stream.write(f"[{format_duration(snapshot.elapsed_s)}] {snapshot.label}{count}\n")
        self._stream.flush()

    def close(self) -> None:
        """Do nothing, because all lines are complete."""


class ProgressDisplay:
    """Reporter that shows progress on a stream after a command has run for `delay_s`.

    The drawing runs in a thread, so that the elapsed time advances during steps that report
    nothing. No modules are imported for drawing before the delay has passed.
    """

    def __init__(self, stream: TextIO, *, start_time_s: float, delay_s: float) -> None:
        self._stream, self._start_time_s, self._delay_s = stream, start_time_s, delay_s
        self._lock = threading.Lock()
        self._stage, self._clock = "", StepClock(None)
        self._part: tuple[int, int] | None = None
        self._stop_event = threading.Event()

    def __enter__(self) -> ProgressDisplay:
        self._draw_thread = start_thread(self._draw, name="progress")
        return self

    def __exit__(self, *_: object) -> None:
        self._stop_event.set()
        self._draw_thread.join()

    def part(self, number: int, count: int) -> None:
        """Begin a numbered part."""
        with self._lock:
            self._part = (number, count)
            self._stage, self._clock = "", StepClock(None)

    def stage(self, name: str, total: int | None = None) -> None:
        """Begin a stage and its estimate of the remaining time."""
        with self._lock:
            self._stage, self._clock = name, StepClock(total)

    def step(self, done_count: int) -> None:
        """Record the completed steps of the stage."""
        with self._lock:
            self._clock.step(done_count, time.monotonic())

    def _snapshot(self) -> Snapshot:
        with self._lock:
            now_s = time.monotonic()
            step_clock = self._clock
            return Snapshot(
                self._stage,
                step_clock.done,
                step_clock.total,
                self._part,
                now_s - self._start_time_s,
                step_clock.remaining_s(now_s),
            )

    def _draw(self) -> None:
        if self._stop_event.wait(max(0.0, self._start_time_s + self._delay_s - time.monotonic())):
            return
        # The reader of stderr has closed: the command continues, and its exit code is the result.
        with contextlib.suppress(OSError, ValueError):
            painter = choose_painter(self._stream)
            while not self._stop_event.is_set():
                painter.show(self._snapshot())
                self._stop_event.wait(painter.period_s)
            painter.close()


def choose_painter(stream: TextIO) -> Painter:
    """Return a painter that updates one line on suitable terminals, or else `PlainLines`."""
    if not stream.isatty() or (
        os.name == "posix" and os.environ.get("TERM", "") in ("", "dumb", "unknown")
    ):
        return PlainLines(stream)
    try:
        from vomstudio.cli.common.terminal_line import TerminalLine

        return TerminalLine(stream)
    except ImportError:  # An incomplete installation must not end the command.
        return PlainLines(stream)


@contextlib.contextmanager
def reporting(
    *, is_quiet: bool, json_events: bool, start_time_s: float, is_verbose: bool = False
) -> Iterator[Reporter]:
    """Yield the reporter of a command and end its display afterwards.

    Parameters
    ----------
    is_quiet : bool
        Whether to show nothing and suppress the output of libraries.
    json_events : bool
        Whether to write JSON lines.
    start_time_s : float
        Start time of the command (`time.monotonic`).
    is_verbose : bool
        Whether to write a line for every stage.
    """
    if is_quiet:
        with silence_output():
            yield SilentReporter()
    elif json_events:
        yield JsonProgress()
    elif sys.stderr is None:
        yield SilentReporter()
    elif is_verbose:
        yield StageLines(sys.stderr, start_time_s)
    else:
        with ProgressDisplay(sys.stderr, start_time_s=start_time_s, delay_s=_delay_s()) as display:
            yield display


def _delay_s() -> float:
    try:
        return float(os.environ[DELAY_VARIABLE])
    except (KeyError, ValueError):
        return DEFAULT_DELAY_S
