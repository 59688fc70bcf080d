"""Progress line on a terminal, drawn with rich and updated in place.

`rich.live` hides the cursor while it draws, and it stays hidden if a library aborts the process. A
single line that is rewritten after a carriage return does not need a hidden cursor.
"""

from __future__ import annotations

import math
import os
from typing import TextIO

from rich.cells import cell_len, set_cell_size
from rich.console import Console
from rich.control import Control
from rich.progress_bar import ProgressBar
from rich.segment import ControlType, Segment, Segments
from rich.style import Style

from vomstudio.cli.common.progress_snapshot import MAX_COUNT, Snapshot, format_duration
from vomstudio.core.words import tr

DEFAULT_COLUMNS = 80
"""Width if the terminal does not report one."""
MIN_BAR_CELLS, MAX_BAR_CELLS = 10, 20
_SPINNER_FRAMES, _ASCII_FRAMES = "⠋⠙⠹⠸⠼⠴⠦⠧⠇⠏", "|/-\\"
_SPINNER_STYLE, _FIGURE_STYLE = Style(color="cyan"), Style(dim=True)


class TerminalLine:
    """Painter that rewrites one line: spinner, stage, bar, count, remaining and elapsed time."""

    period_s = 0.1

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._console = Console(file=stream, force_terminal=True, highlight=False)
        self._spinner_frames = (
            _ASCII_FRAMES if self._console.options.ascii_only else _SPINNER_FRAMES
        )
        self._frame_index = 0
        self._has_line = False

    def show(self, snapshot: Snapshot) -> None:
        """Redraw the line if the process is in the foreground."""
        if not self._is_in_foreground():
            return
        self._frame_index += 1
        self._write(self._segments(snapshot, self._columns() - 1))
        self._has_line = True

    def close(self) -> None:
        """Clear the line."""
        if self._has_line and self._is_in_foreground():
            self._write([])

    def _write(self, segments: list[Segment]) -> None:
        erase_control = Control(ControlType.CARRIAGE_RETURN, (ControlType.ERASE_IN_LINE, 2))
        with self._console as console:  # A single write avoids flicker.
            console.control(erase_control)
            console.print(Segments(segments), end="", soft_wrap=True)

    def _segments(self, snapshot: Snapshot, columns: int) -> list[Segment]:
        """Build the line, omitting the bar, then the figures, and truncating the name to fit."""
        spinner = self._spinner_frames[self._frame_index % len(self._spinner_frames)] + " "
        label = snapshot.label
        figures = _figure_texts(snapshot)
        space = columns - cell_len(spinner)
        while figures and cell_len(label) + 2 + cell_len(", ".join(figures)) > space:
            figures.pop()
        text = ", ".join(figures)
        if cell_len(label) > space:
            label = set_cell_size(label, max(0, space - 3)) + "..."[: max(0, space)]
        segments = [Segment(spinner, _SPINNER_STYLE), Segment(label)]
        space -= cell_len(label) + (2 + cell_len(text) if text else 0)
        if (snapshot.total or 0) > 1 and space >= MIN_BAR_CELLS + 2:
            segments += [Segment("  "), *self._bar(snapshot, min(space - 2, MAX_BAR_CELLS))]
        if text:
            segments += [Segment("  "), Segment(text, _FIGURE_STYLE)]
        return segments

    def _bar(self, snapshot: Snapshot, cells: int) -> list[Segment]:
        bar = ProgressBar(total=snapshot.total, completed=snapshot.done, width=cells)
        options = self._console.options.update(width=cells)
        segments = [s for s in self._console.render(bar, options) if s.text != "\n"]
        # Without colours, or in ASCII, the remaining part of the bar is omitted.
        missing_cells = cells - sum(segment.cell_length for segment in segments)
        return [*segments, Segment(" " * missing_cells)]

    def _columns(self) -> int:
        try:
            columns = os.get_terminal_size(self._stream.fileno()).columns
        except (OSError, ValueError):
            columns = 0
        self._console.width = columns or DEFAULT_COLUMNS
        return self._console.width

    def _is_in_foreground(self) -> bool:
        """Return whether the process may draw: background processes of a terminal must not."""
        try:
            return os.tcgetpgrp(self._stream.fileno()) == os.getpgrp()
        except (AttributeError, OSError, ValueError):  # Windows, or not the controlling terminal
            return True


def _figure_texts(snapshot: Snapshot) -> list[str]:
    """Return count, remaining time and elapsed time, in decreasing importance."""
    figures = []
    if snapshot.total is not None and snapshot.total > 1:
        n_done = min(snapshot.done, snapshot.total)
        if snapshot.total <= MAX_COUNT:
            figures.append(tr("{done} of {total}", done=n_done, total=snapshot.total))
        else:
            figures.append(f"{100 * n_done // snapshot.total} %")
    if snapshot.remaining_s is not None:
        figures.append(tr("{time} left", time=format_rounded_duration(snapshot.remaining_s)))
    figures.append(tr("elapsed {time}", time=format_duration(snapshot.elapsed_s)))
    return figures


def format_rounded_duration(seconds: float) -> str:
    """Format an estimated duration, rounded up to 5 s below one minute, else to minutes."""
    if seconds < 57.5:
        return tr("{count} s", count=max(5, 5 * math.ceil(seconds / 5)))
    minutes = max(1, round(seconds / 60))
    if minutes < 60:
        return tr("{count} min", count=minutes)
    return tr("{hours} h {minutes} min", hours=minutes // 60, minutes=minutes % 60)
