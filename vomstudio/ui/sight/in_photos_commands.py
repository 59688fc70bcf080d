"""Commands of the panel that shows the outcrop in its photos."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QFileDialog

from vomstudio.ui.common.actions import Command

if TYPE_CHECKING:
    from vomstudio.ui.shell.main_window import MainWindow

DOCK = "in_photos"
_HEIGHT = 400


def commands(w: MainWindow) -> list[Command]:
    studio = w.studio

    def no_model() -> str | None:
        return None if studio.models else "open a model first"

    def no_photo() -> str | None:
        return None if w.in_photos.list.count() else "no photos are shown"

    return [
        Command("show_in_photos", "Show in the &photos", lambda: show(w), "image-search-outline",
                "Ctrl+Shift+P", "The photos that show what is selected, with the features on them",
                no_model),
        Command("open_cameras", "Open &cameras…", lambda: _open_cameras(w), "camera-outline", (),
                "The cameras.json of the reconstruction that made the model", no_model),
        Command("find_photos", "&Find the photos…", lambda: _find_photos(w),
                "folder-search-outline", (), "The folder in which the photos of the model are now",
                lambda: None if w.photo_links.models() else "open the model's cameras first"),
        Command("previous_photo", "Previous photo", lambda: w.in_photos.list.step(-1),
                "chevron-left",
                "Alt+Left", "", no_photo),
        Command("next_photo", "Next photo", lambda: w.in_photos.list.step(1), "chevron-right",
                "Alt+Right", "", no_photo),
        Command("fit_photo", "The whole photo", lambda: w.in_photos.canvas.fit(),
                "fit-to-screen-outline", "Ctrl+0", "", no_photo),
    ]  # fmt: skip


def show(w: MainWindow) -> None:
    w.show_dock(DOCK)
    # A tab that was never in front has a height of its own until it is laid out.
    QTimer.singleShot(0, lambda: _make_room(w))


def _make_room(w: MainWindow) -> None:
    dock = w.docks[DOCK]
    if dock.height() < _HEIGHT and dock.isVisible() and not dock.isFloating():
        w.resizeDocks([dock], [_HEIGHT], Qt.Orientation.Vertical)


def _open_cameras(w: MainWindow) -> None:
    model = w.files.current_model()
    name, _ = QFileDialog.getOpenFileName(
        w, w.tr("The cameras of the model"), w.files.folder(), w.tr("Cameras (*.json)")
    )
    if name and model is not None:
        show(w)
        w.photo_links.open_cameras(model.id, Path(name))


def _find_photos(w: MainWindow) -> None:
    name = QFileDialog.getExistingDirectory(w, w.tr("The photos of the model"), w.files.folder())
    models = w.photo_links.models()
    if name and models:
        w.photo_links.find_photos(models[0], Path(name))
