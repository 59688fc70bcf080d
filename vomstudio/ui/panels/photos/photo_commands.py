"""Commands that open a photo from any photo set of the project."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.records import PhotoSet
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey

if TYPE_CHECKING:
    from vomstudio.ui.panels.photos.photo_page import PhotoPage


def commands(opening: PhotoOpening, selected_photo: Callable[[], str | None]) -> list[Command]:
    """Return the commands that open a photo and import the files beside the photos again.

    Parameters
    ----------
    opening : PhotoOpening
    selected_photo : callable
        Returns the name of the photo that is selected in the list, or None.
    """
    return [
        Command(
            "open_photo",
            tr("&Open photo"),
            lambda: opening.open(selected_photo()),
            "image-edit-outline",
            (),
            tr("Open the photo to draw its mask and mark points."),
            opening.disabled_reason,
        ),
        Command(
            "take_in_photos",
            tr("Re-&import"),
            opening.import_sidecars,
            "tray-arrow-down",
            (),
            tr("Import control points, marks and masks from the photo folder again."),
            opening.disabled_reason,
        ),
    ]


class PhotoOpening(QObject):
    """Controller that opens one photo at a time in a shared page.

    Attributes
    ----------
    page_shown : Signal
        Emitted with the PhotoPage that is to be shown.
    """

    page_shown = Signal(object)

    def __init__(self, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__()
        self._studio, self._survey = studio, survey
        self._page: PhotoPage | None = None
        self._pending_request: tuple[Path, str | None] | None = None
        survey.changed.connect(self._survey_changed)

    def disabled_reason(self) -> Finding | None:
        """Return why no photo can be opened, or None if one can be opened."""
        if self._survey.folder is None or not self._survey.rows:
            return Finding("action.no-photos")
        if not self._survey.document.is_imported:
            return Finding("photos.pending")
        return None

    def import_sidecars(self) -> None:
        """Repeat the import of the files beside the photos."""
        self._survey.import_sidecars()

    @property
    def page(self) -> PhotoPage | None:
        """Page of the open photo, or None if no photo is open."""
        return self._page

    def open(self, name: str | None = None) -> None:
        """Open the photo with this name, or by default the first photo of the panel."""
        from vomstudio.ui.panels.photos.photo_page import PhotoPage

        self._pending_request = None
        if self.disabled_reason() is not None:
            return
        names = [row.name for row in self._survey.rows]
        photo = name if name is not None and name in names else names[0]
        if self._page is None:
            self._page = PhotoPage(self._survey)
            self._page.closed.connect(self._handle_close)
        page = self._page
        self.page_shown.emit(page)
        page.show_photo(photo)
        page.canvas.setFocus()

    def open_set(self, photo_set: PhotoSet) -> bool:
        """Show a photo set in the panel; if its folder is missing, warn and return False."""
        document = self._survey.document
        if (current_set := document.photo_set) is not None and current_set.id == photo_set.id:
            return True
        folder = document.find_folder(photo_set)
        if folder is None:
            self._studio.warn(
                Finding("photo.folder-missing", name=photo_set.name, folder=photo_set.path)
            )
            return False
        self._survey.open(folder)
        return True

    def open_set_photo(self, photo_set: PhotoSet, name: str | None = None) -> None:
        """Show a photo set in the panel and then open one of its photos."""
        if not self.open_set(photo_set):
            return
        if self.disabled_reason() is None:
            self.open(name)
        elif self._survey.folder is not None:
            # The photo is opened once the list has been read.
            self._pending_request = self._survey.folder, name

    def _survey_changed(self) -> None:
        if self._pending_request is None:
            return
        folder, name = self._pending_request
        if folder != self._survey.folder or self._survey.problem:
            self._pending_request = None
        elif self.disabled_reason() is None:
            self.open(name)

    def _handle_close(self) -> None:
        self._page = None

    def may_close(self) -> bool:
        """Close the open photo if possible; return whether it could be closed."""
        page = self._page
        if page is None:
            return True
        if not page.may_close():
            return False
        # This precedes `close`, because exceptions in Qt event handlers do not reach the caller.
        page.end()
        return page.close()
