"""What the user is told of their things."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.errors import VomError
from vomstudio.signals import Signal


@dataclass(frozen=True)
class Notice:
    """What happened to the user's thing. level: "info", "hint" (goes by itself), "warning" or
    "error". action: the name of the action that mends it, offered beside the sentence."""

    text: str
    level: str = "info"
    action: str = ""


class Notices:
    def __init__(self) -> None:
        self.told: Signal[Notice] = Signal()

    def tell(self, notice: Notice) -> None:
        self.told.emit(notice)

    def info(self, text: str) -> None:
        self.told.emit(Notice(text))

    def hint(self, text: str) -> None:
        self.told.emit(Notice(text, "hint"))

    def warn(self, text: str, level: str = "warning") -> None:
        self.told.emit(Notice(text, level))

    def fail(self, error: VomError) -> None:
        self.told.emit(Notice(str(error), "error"))
