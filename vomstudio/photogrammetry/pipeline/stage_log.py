"""Log of the stages of a reconstruction, and notes for its report."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress


class StageLog:
    """Log that writes `log.txt`, forwards progress, and collects `notes` for the user."""

    def __init__(self, path: Path, progress: Progress) -> None:
        self._path, self._progress = path, progress
        self._stage, self._start_time = "", 0.0
        self.notes: list[Finding] = []

    def note(self, message: Finding) -> None:
        """Store a message for the user, unless it is already stored, and log it."""
        if message not in self.notes:
            self.notes.append(message)
            self.log(str(message))

    def log(self, text: str) -> None:
        """Append a line with the time to the log file, ignoring disk errors."""
        line = f"{datetime.now().isoformat(timespec='seconds')}  {text}\n"
        try:
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write(line)
        except OSError:
            # A full disk is reported when results are written.
            pass

    def stage(self, name: str, total: int | None = None) -> None:
        """Log the start of a stage, and forward it to the progress."""
        self.end_stage()
        self._stage, self._start_time = name, time.monotonic()
        self.log(name if total is None else f"{name} ({total})")
        self._progress.stage(name, total)

    def step(self, done_count: int) -> None:
        """Forward a step of the current stage to the progress."""
        self._progress.step(done_count)

    def end_stage(self) -> None:
        """Log how long the stage took."""
        if self._stage:
            self.log(f"{self._stage}: {time.monotonic() - self._start_time:.1f} s")
            self._stage = ""
