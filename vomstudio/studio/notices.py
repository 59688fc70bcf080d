"""Messages to the user, independent of how they are presented."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.project.journal.failures import NotWritten

SAVE_AS = "save_as"
"""Command that is offered if a project cannot be written."""
UPDATE_DRAWN = "update_drawn_traces"
"""Command that updates the vertices of traces from an imported drawing."""
DECLARE_FRAME = "declare_frame"
"""Command that changes the frame of a model."""
CONVERT = "convert_model"
"""Command that converts a model that is not metric."""


@dataclass(frozen=True)
class Notice:
    """Message to the user.

    Parameters
    ----------
    level : {"info", "hint", "warning", "error"}
        A hint disappears by itself.
    action : str
        Name of a command that is offered with the message as a remedy.
    more : tuple of Finding
        Further findings, shown below the message.
    file : Path or None
        Written file, which the notice offers to open.
    """

    message: Finding | VomError
    level: str = "info"
    action: str = ""
    more: tuple[Finding, ...] = ()
    file: Path | None = None

    @property
    def text(self) -> str:
        """Translated sentences of the notice, one per line."""
        return "\n".join(map(str, (self.message, *self.more)))

    @property
    def code(self) -> str:
        """Code of the finding or error."""
        return self.message.code


class Notices:
    """Notices of the application, which are passed on to the listeners of `posted`."""

    def __init__(self) -> None:
        self.posted: Signal[Notice] = Signal()

    def post(self, notice: Notice) -> None:
        """Emit a notice."""
        self.posted.emit(notice)

    def info(self, message: Finding) -> None:
        """Report a completed action."""
        self.posted.emit(Notice(message))

    def written(self, file: str | Path, message: Finding | None = None) -> None:
        """Report a file that was written, by default with the standard message."""
        default = Finding("export.written", file=file)
        self.posted.emit(Notice(message or default, file=Path(file)))

    def hint(self, message: Finding) -> None:
        """Show a notice that disappears by itself."""
        self.posted.emit(Notice(message, "hint"))

    def warn(self, message: Finding | VomError, level: str = "warning") -> None:
        """Show a warning, or a notice of another level."""
        self.posted.emit(Notice(message, level))

    def fail(self, error: VomError) -> None:
        """Show an error, and offer a remedy if the project cannot be written."""
        remedy = SAVE_AS if isinstance(error, NotWritten) else ""
        self.posted.emit(Notice(error, "error", remedy))
