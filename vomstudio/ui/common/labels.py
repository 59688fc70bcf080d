"""Words on labels and tooltips as they are.

Qt takes text for HTML where it looks like some, and fetches the pictures that it names: a feature
called `<img src="/dev/zero">` would keep the window busy without end.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from html import escape

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QWidget


class Label(QLabel):
    """Shows its text as it is, until `setTextFormat` says that it is HTML; then the words in it
    that are not our own are escaped by whoever puts them there."""

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setTextFormat(Qt.TextFormat.PlainText)
        if text:
            self.setText(text)


def rich_lines(lines: Sequence[str], bold: Collection[str] = ()) -> str:
    """HTML that shows lines as they are, some of them bold."""
    shown = ((escape(line), line in bold) for line in lines)
    return "<br>".join(f"<b>{line}</b>" if heavy else line for line, heavy in shown)


def rich_label(text: str = "") -> Label:
    """For HTML."""
    label = Label()
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setText(text)
    return label


def as_words(text: str) -> str:
    """For a tooltip or message box, which decide by themselves: text in which Qt sees no HTML. A
    mark without width stands behind each `<`."""
    return text.replace("<", "<\N{WORD JOINER}")
