"""Events that a worker sends to its supervisor: one JSON object per line."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from vomstudio.core.errors import VomError, from_dict


@dataclass(frozen=True)
class Stage:
    """A stage begins; `total` counts its steps, None where they cannot be known."""

    job: int
    name: str
    total: int | None


@dataclass(frozen=True)
class Step:
    """`done` steps of the job's stage are complete."""

    job: int
    done: int


@dataclass(frozen=True)
class Done:
    """`result`: plain values on the wire; the supervisor tells of the job's own dataclass."""

    job: int
    result: Any


@dataclass(frozen=True)
class Failed:
    """`error` is `VomError.to_dict()`; `exit_code` is that of the command."""

    job: int
    error: dict[str, Any]
    exit_code: int

    @property
    def message(self) -> str:
        """The message with its place in a file before it, as the window shows it."""
        error = self.to_error()
        return error.message if error.file is None else str(error)

    def to_error(self) -> VomError:
        """Return the error that the job ended with."""
        return from_dict(self.error, self.exit_code)

    @property
    def cancelled(self) -> bool:
        """Whether the user stopped the job."""
        return self.error.get("code") == "cancelled"


@dataclass(frozen=True)
class Fault:
    """A mistake of the program itself, whose trace is in the log; the job ends with an event of its
    own. job: the one that was being done, 0 for none; what: a few words, see `Failure.what`."""

    job: int
    what: str


Event = Stage | Step | Done | Failed
_KINDS: dict[str, type[Any]] = {cls.__name__: cls for cls in (Stage, Step, Done, Failed, Fault)}


def to_line(event: Event | Fault) -> str:
    """One line of JSON, with its end."""
    return json.dumps({"event": type(event).__name__, **asdict(event)}, allow_nan=False) + "\n"


def from_line(line: str) -> Event | Fault:
    """Raises ValueError where the line is not an event."""
    try:
        values = json.loads(line)
        event: Event | Fault = _KINDS[values.pop("event")](**values)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not an event: {line[:80]!r}") from error
    return event
