"""Messages to the user, without saying how they are shown."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.errors import VomError
from vomstudio.io.project.journal_trouble import NotWritten
from vomstudio.signals import Signal

SAVE_AS = "save_as"
"""The command that helps where a project cannot be written."""
UPDATE_DRAWN = "update_drawn_traces"
"""The command that gives traces the vertices of an imported drawing."""
CONVERT = "convert_model"
"""The command that converts a model that is not metric."""


@dataclass(frozen=True)
class Notice:
    """A message: one or more sentences, translated. level: "info", "hint" (disappears by itself),
    "warning" or "error". action: the name of a command that helps, offered beside the message."""

    text: str
    level: str = "info"
    action: str = ""


class Notices:
    """Passes notices on to whoever listens to `told`."""

    def __init__(self) -> None:
        self.told: Signal[Notice] = Signal()

    def tell(self, notice: Notice) -> None:
        """Pass a notice on."""
        self.told.emit(notice)

    def info(self, text: str) -> None:
        """A notice of what was done."""
        self.told.emit(Notice(text))

    def hint(self, text: str) -> None:
        """A notice that disappears by itself."""
        self.told.emit(Notice(text, "hint"))

    def warn(self, text: str, level: str = "warning") -> None:
        """A warning, or another level."""
        self.told.emit(Notice(text, level))

    def fail(self, error: VomError) -> None:
        """The message of an error, with what helps where a project cannot be written."""
        helps = SAVE_AS if isinstance(error, NotWritten) else ""
        self.told.emit(Notice(str(error), "error", helps))
