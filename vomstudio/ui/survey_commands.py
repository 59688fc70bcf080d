"""Commands of the Photos panel."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog

from vomstudio.io.project import SUFFIX, is_project
from vomstudio.ui.actions import Command

if TYPE_CHECKING:
    from vomstudio.ui.main_window import MainWindow

# Five photos with their thumbnails.
_HEIGHT = 320


def commands(w: MainWindow) -> list[Command]:
    return [
        Command("choose_photos", "New model from &photos…", lambda: _choose(w),
                "image-multiple-outline", "Ctrl+Shift+I",
                "A folder of photos: what they are worth, and the model they make"),
        Command("make_model", "&Make the model", lambda: w.survey.make(), "cube-scan", (),
                "Align the photos and make a dense, textured model, in the background",
                lambda: w.survey.why_not_make()),
        Command("pause_model", "Pause", lambda: w.survey.pause(), "pause", (),
                "Stop for now; what is finished is kept",
                lambda: None if w.survey.making else "no model is being made"),
    ]  # fmt: skip


def is_photo_folder(path: Path) -> bool:
    """A folder that is no project."""
    return path.is_dir() and path.suffix != SUFFIX and not is_project(path)


def open_photos(w: MainWindow, folder: Path) -> None:
    w.survey.open(folder)
    w.show_dock("photos")
    dock = w.docks["photos"]
    if dock.height() < _HEIGHT and not dock.isFloating():
        w.resizeDocks([dock], [_HEIGHT], Qt.Orientation.Vertical)


def _choose(w: MainWindow) -> None:
    name = QFileDialog.getExistingDirectory(
        w, w.tr("A folder of photos"), w.files.folder(), QFileDialog.Option.ShowDirsOnly
    )
    if name:
        open_photos(w, Path(name))
