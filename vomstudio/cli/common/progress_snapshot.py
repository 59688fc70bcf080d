"""State of a command's progress, and an estimate of the remaining time."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.cli.common.output import escape_for_terminal
from vomstudio.core.words import tr

MAX_COUNT = 9999
"""Maximum number of steps shown as a count; larger totals are shown as a share."""
MIN_STEPS_FOR_ESTIMATE = 3
MIN_TIME_FOR_ESTIMATE_S = 2.0


@dataclass(frozen=True)
class Snapshot:
    """State of a command's progress at a moment in time.

    Parameters
    ----------
    stage : str
        Name of the stage, or empty before the first stage.
    done, total : int
        Completed steps of the stage, and its total number of steps (None if unknown).
    part : tuple of int, optional
        Number of the part and total number of parts.
    elapsed_s : float
        Time since the command started.
    remaining_s : float, optional
        Estimated time to the end of the stage, or None before it can be estimated.
    """

    stage: str
    done: int
    total: int | None
    part: tuple[int, int] | None
    elapsed_s: float
    remaining_s: float | None

    @property
    def label(self) -> str:
        """Name of the stage with the number of its part, escaped for a terminal."""
        name = escape_for_terminal(" ".join(self.stage.split())) or tr("Working")
        if self.part is None:
            return name
        number, count = self.part
        return tr("Step {number}/{count}: {stage}", number=number, count=count, stage=name)


class StepClock:
    """Estimator of the remaining time of a stage from the steps completed so far."""

    def __init__(self, total: int | None) -> None:
        self.total = total
        self.done = 0
        self._first_step: tuple[int, float] | None = None
        self._last_time_s = 0.0
        self._increase_count = 0

    def step(self, done_count: int, now_s: float) -> None:
        """Record that `done_count` steps are completed."""
        if self._first_step is None:
            # A resumed stage begins at a number greater than 0.
            self._first_step, self._last_time_s = (done_count, now_s), now_s
        elif done_count > self.done:
            self._increase_count += 1
            self._last_time_s = now_s
        self.done = done_count

    def remaining_s(self, now_s: float) -> float | None:
        """Estimate the remaining time; None if it is too early or all steps are completed."""
        if (
            self.total is None
            or self._first_step is None
            or self._increase_count < MIN_STEPS_FOR_ESTIMATE
        ):
            return None
        if self.done >= self.total:
            return None
        first_count, first_time_s = self._first_step
        steps = self.done - first_count
        if steps <= 0 or self._last_time_s - first_time_s < MIN_TIME_FOR_ESTIMATE_S:
            return None
        # A step that takes longer than the previous mean also slows down the remaining steps.
        min_step_s = (now_s - first_time_s) / (steps + steps / self._increase_count)
        step_duration_s = max((self._last_time_s - first_time_s) / steps, min_step_s)
        return max(0.0, step_duration_s * (self.total - self.done) - (now_s - self._last_time_s))


def format_duration(seconds: float) -> str:
    """Format a duration as m:ss or h:mm:ss."""
    minutes, second = divmod(int(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02d}:{second:02d}" if hours else f"{minute}:{second:02d}"
