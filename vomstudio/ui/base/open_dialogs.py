"""Non-modal dialogs, at most one of each kind and key."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import TypeVar

from PySide6.QtWidgets import QWidget
from shiboken6 import isValid

from vomstudio.ui.base.window_fitting import fit_to_screen

D = TypeVar("D", bound=QWidget)


class OpenDialogs:
    """Weak references to the open dialogs, so that a closed dialog is freed with its data."""

    def __init__(self) -> None:
        self._dialogs: dict[tuple[type[QWidget], Hashable], weakref.ref[QWidget]] = {}
        self._general_kinds: set[type[QWidget]] = set()

    def close_project_dialogs(self) -> None:
        """Close the dialogs that show project data, because another project is being opened."""
        for (dialog_class, _), reference in self._dialogs.items():
            dialog = reference()
            if dialog is not None and isValid(dialog) and dialog_class not in self._general_kinds:
                dialog.close()

    def find_visible(self, dialog_class: type[D], key: Hashable = None) -> D | None:
        """Return the visible dialog of a kind, or None.

        Parameters
        ----------
        dialog_class : type
            Class of the dialog.
        key : hashable, optional
            Distinguishes dialogs of the same kind, for example by the object that they show.
        """
        dialog = self._find_dialog(dialog_class, key)
        return dialog if dialog is not None and dialog.isVisible() else None

    def show(
        self,
        dialog_class: type[D],
        create: Callable[[], D],
        key: Hashable = None,
        *,
        is_general: bool = False,
    ) -> D:
        """Bring the dialog to the front, or create and show it.

        Parameters
        ----------
        dialog_class : type
            Class of the dialog.
        create : callable
            Creates the dialog.
        key : hashable, optional
            Distinguishes dialogs of one class.
        is_general : bool
            Whether the dialog stays open when another project is opened.
        """
        if is_general:
            self._general_kinds.add(dialog_class)
        visible_dialog = self.find_visible(dialog_class, key)
        if visible_dialog is not None:
            visible_dialog.raise_()
            visible_dialog.activateWindow()
            return visible_dialog
        if (hidden_dialog := self._find_dialog(dialog_class, key)) is not None:
            hidden_dialog.deleteLater()
        dialog = create()
        self._dialogs[dialog_class, key] = weakref.ref(dialog)
        fit_to_screen(dialog)
        dialog.show()
        return dialog

    def _find_dialog(self, dialog_class: type[D], key: Hashable) -> D | None:
        reference = self._dialogs.get((dialog_class, key))
        dialog = None if reference is None else reference()
        return dialog if isinstance(dialog, dialog_class) and isValid(dialog) else None
