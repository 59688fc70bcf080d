"""Messages to the user, without saying how they are shown."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import UNCODED, Message
from vomstudio.errors import VomError
from vomstudio.io.project.journal_failures import NotWritten
from vomstudio.signals import Signal

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
    """

    message: Message | VomError
    level: str = "info"
    action: str = ""

    @property
    def text(self) -> str:
        """The translated sentences."""
        return str(self.message)

    @property
    def code(self) -> str:
        """The code of the finding or error; ``uncoded`` for a sentence."""
        return UNCODED if isinstance(self.message, str) else self.message.code


class Notices:
    """Passes notices on to whoever listens to `told`."""

    def __init__(self) -> None:
        self.told: Signal[Notice] = Signal()

    def tell(self, notice: Notice) -> None:
        """Pass a notice on."""
        self.told.emit(notice)

    def info(self, message: Message) -> None:
        """Report what was done."""
        self.told.emit(Notice(message))

    def hint(self, message: Message) -> None:
        """Show a notice that disappears by itself."""
        self.told.emit(Notice(message, "hint"))

    def warn(self, message: Message | VomError, level: str = "warning") -> None:
        """Show a warning, or a notice of another level."""
        self.told.emit(Notice(message, level))

    def fail(self, error: VomError) -> None:
        """The message of an error, with what helps where a project cannot be written."""
        helps = SAVE_AS if isinstance(error, NotWritten) else ""
        self.told.emit(Notice(error, "error", helps))
