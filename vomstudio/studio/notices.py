"""Messages to the user, without saying how they are shown."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal
from vomstudio.project.journal.failures import NotWritten

SAVE_AS = "save_as"
"""The command that helps where a project cannot be written."""
UPDATE_DRAWN = "update_drawn_traces"
"""The command that gives traces the vertices of an imported drawing."""
CONVERT = "convert_model"
"""The command that converts a model that is not metric."""


@dataclass(frozen=True)
class Notice:
    """A message for the user.

    level : "info", "hint" (disappears by itself), "warning" or "error"
    action : name of a command that helps, offered beside the message
    more : findings that are shown below the message, since the bar shows the newest notice only
    """

    message: Finding | VomError
    level: str = "info"
    action: str = ""
    more: tuple[Finding, ...] = ()

    @property
    def text(self) -> str:
        """The translated sentences, each on its line."""
        return "\n".join(map(str, (self.message, *self.more)))

    @property
    def code(self) -> str:
        """The code of the finding or error."""
        return self.message.code


class Notices:
    """Passes notices on to whoever listens to `told`."""

    def __init__(self) -> None:
        self.told: Signal[Notice] = Signal()

    def tell(self, notice: Notice) -> None:
        """Pass a notice on."""
        self.told.emit(notice)

    def info(self, message: Finding) -> None:
        """Report what was done."""
        self.told.emit(Notice(message))

    def hint(self, message: Finding) -> None:
        """Show a notice that disappears by itself."""
        self.told.emit(Notice(message, "hint"))

    def warn(self, message: Finding | VomError, level: str = "warning") -> None:
        """Show a warning, or a notice of another level."""
        self.told.emit(Notice(message, level))

    def fail(self, error: VomError) -> None:
        """The message of an error, with what helps where a project cannot be written."""
        helps = SAVE_AS if isinstance(error, NotWritten) else ""
        self.told.emit(Notice(error, "error", helps))
