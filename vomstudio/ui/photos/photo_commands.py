"""Opening a photo in a window of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.ui.common.actions import Command

if TYPE_CHECKING:
    from vomstudio.ui.photos.photo_window import PhotoWindow
    from vomstudio.ui.shell.main_window import MainWindow


def commands(w: MainWindow) -> list[Command]:
    return [
        Command("open_photo", "&Open the photo", lambda: open_photo(w), "image-edit-outline", (),
                "In a window of its own: draw what is to be left out, mark points",
                lambda: why_not_open(w)),
        Command("take_in_photos", "&Take in what lies beside the photos",
                lambda: w.survey.take_in_beside(), "tray-arrow-down", (),
                "Control points, marks and masks that another program has written there",
                lambda: why_not_open(w)),
    ]  # fmt: skip


def why_not_open(w: MainWindow) -> str | None:
    if w.survey.folder is None or not w.survey.rows:
        return "choose a folder of photos first"
    if not w.survey.document.taken_in:
        return "the photos are being looked at"
    return None


def opened(w: MainWindow) -> PhotoWindow | None:
    from vomstudio.ui.photos.photo_window import PhotoWindow

    shown = [each for each in w.findChildren(PhotoWindow) if each.isVisible()]
    return shown[0] if shown else None


def open_photo(w: MainWindow, name: str | None = None) -> None:
    """The photo of this name, or that which is chosen in the Photos panel, or the first."""
    from vomstudio.ui.photos.photo_window import PhotoWindow

    if why_not_open(w) is not None:
        return
    wanted = name or w.photos_panel.chosen_photo() or w.survey.rows[0].name
    window = opened(w)
    if window is None:
        window = PhotoWindow(w, w.survey)
        window.show()
    window.raise_()
    window.activateWindow()
    window.show_photo(wanted)
    window.canvas.setFocus()


def may_close(w: MainWindow) -> bool:
    """Whether the program may end over what was drawn in photos."""
    window = opened(w)
    return window is None or window.close()
