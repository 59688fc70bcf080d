"""Dialogs beside the window: of each kind one is open, and asked for again it comes forward."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import TypeVar

from PySide6.QtWidgets import QWidget
from shiboken6 import isValid

from vomstudio.ui.base.long_boxes import fit_to_screen

D = TypeVar("D", bound=QWidget)


class OpenDialogs:
    """The dialogs that are open. It keeps none alive: a closed dialog is freed with its data."""

    def __init__(self) -> None:
        self._dialogs: dict[tuple[type[QWidget], Hashable], weakref.ref[QWidget]] = {}

    def find_visible(self, kind: type[D], about: Hashable = None) -> D | None:
        """The dialog of this kind that is on the screen. about: what there may be one each for."""
        made = self._find(kind, about)
        return made if made is not None and made.isVisible() else None

    def show(self, kind: type[D], make: Callable[[], D], about: Hashable = None) -> D:
        """Bring the dialog forward, or make it and show it."""
        there = self.find_visible(kind, about)
        if there is not None:
            there.raise_()
            there.activateWindow()
            return there
        if (hidden := self._find(kind, about)) is not None:
            hidden.deleteLater()
        made = make()
        self._dialogs[kind, about] = weakref.ref(made)
        fit_to_screen(made)
        made.show()
        return made

    def _find(self, kind: type[D], about: Hashable) -> D | None:
        kept = self._dialogs.get((kind, about))
        made = None if kept is None else kept()
        return made if isinstance(made, kind) and isValid(made) else None
