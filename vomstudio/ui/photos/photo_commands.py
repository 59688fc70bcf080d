"""Opening a photo in a window of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.open_dialogs import OpenDialogs
from vomstudio.ui.photos.photo_survey import PhotoSurvey
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.ui.photos.photo_window import PhotoWindow


def commands(opening: PhotoOpening, chosen: Callable[[], str | None]) -> list[Command]:
    """chosen : the name of the photo that is selected in the list"""
    return [
        Command("open_photo", tr("&Open photo"), lambda: opening.open(chosen()),
                "image-edit-outline", (),
                tr("In a window of its own, to draw its mask and to mark points."),
                opening.why_not),
        Command("take_in_photos", tr("Re-&import points and masks"), opening.take_in,
                "tray-arrow-down", (),
                tr("Replace those of the project by the control points, marks and masks beside the "
                   "photos."),
                opening.why_not),
    ]  # fmt: skip


class PhotoOpening:
    """The one window in which photos are opened, beside the window of the outcrop."""

    def __init__(self, parent: QWidget, survey: PhotoSurvey, dialogs: OpenDialogs) -> None:
        self._parent, self._survey, self._dialogs = parent, survey, dialogs

    def why_not(self) -> str | None:
        """None where a photo can be opened, else the reason as a sentence."""
        if self._survey.folder is None or not self._survey.rows:
            return tr("Choose a folder of photos first.")
        if not self._survey.document.taken_in:
            return tr("The photos are being read.")
        return None

    def take_in(self) -> None:
        """Import again what lies beside the photos."""
        self._survey.take_in_beside()

    @property
    def opened(self) -> PhotoWindow | None:
        from vomstudio.ui.photos.photo_window import PhotoWindow

        return self._dialogs.shown(PhotoWindow)

    def open(self, name: str | None = None) -> None:
        """The photo of this name, or the first."""
        from vomstudio.ui.photos.photo_window import PhotoWindow

        if self.why_not() is not None:
            return
        wanted = name or self._survey.rows[0].name
        window = self._dialogs.show(PhotoWindow, lambda: PhotoWindow(self._parent, self._survey))
        window.raise_()
        window.activateWindow()
        window.show_photo(wanted)
        window.canvas.setFocus()

    def may_close(self) -> bool:
        """Whether the program may end over what was drawn in photos."""
        window = self.opened
        return window is None or window.close()
