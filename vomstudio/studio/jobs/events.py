"""Events that a worker sends to its supervisor: one JSON object per line."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from vomstudio.core.errors import VomError, from_dict


@dataclass(frozen=True)
class Stage:
    """Start of a stage; `total` is the number of steps, or None if unknown."""

    job: int
    name: str
    total: int | None


@dataclass(frozen=True)
class Step:
    """Progress of the current stage; `done` is the number of completed steps."""

    job: int
    done: int


@dataclass(frozen=True)
class Done:
    """End of a job. The supervisor converts `result` to the job's dataclass."""

    job: int
    result: Any


@dataclass(frozen=True)
class Failed:
    """Failure of a job, with the error as a dictionary and the exit code of the command."""

    job: int
    error: dict[str, Any]
    exit_code: int

    @property
    def message(self) -> str:
        """Message for the window, starting with the location if the error names a file."""
        error = self.to_error()
        return error.message if error.file is None else str(error)

    def to_error(self) -> VomError:
        """Convert to the error of the job."""
        return from_dict(self.error, self.exit_code)

    @property
    def cancelled(self) -> bool:
        """Whether the user stopped the job."""
        return self.error.get("code") == "cancelled"


@dataclass(frozen=True)
class InternalError:
    """Defect of the program; its traceback is in the log.

    The job additionally ends with its own event.

    Parameters
    ----------
    job : int
        Number of the job that was running, or 0 if no job was running.
    cause : str
        Short description, as in `Failure`.
    """

    job: int
    cause: str


Event = Stage | Step | Done | Failed
_KINDS: dict[str, type[Any]] = {
    cls.__name__: cls for cls in (Stage, Step, Done, Failed, InternalError)
}


def to_line(event: Event | InternalError) -> str:
    """Convert an event to a line of JSON, including the line break."""
    return json.dumps({"event": type(event).__name__, **asdict(event)}, allow_nan=False) + "\n"


def from_line(line: str) -> Event | InternalError:
    """Parse a line of JSON. Raises ValueError if it is not an event."""
    try:
        values = json.loads(line)
        event: Event | InternalError = _KINDS[values.pop("event")](**values)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not an event: {line[:80]!r}") from error
    return event
