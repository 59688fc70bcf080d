"""Commands of the Photos panel."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QDialog, QFileDialog

from vomstudio.document.records import Model
from vomstudio.io.project.folder import SUFFIX, is_project
from vomstudio.photogrammetry.base.stage_folders import is_aligned
from vomstudio.rendering.view.scalars import FieldStyle
from vomstudio.ui.common.actions import Command

if TYPE_CHECKING:
    from vomstudio.ui.shell.main_window import MainWindow

# Five photos with their thumbnails.
_HEIGHT = 320
SPARSE, REPORT = "sparse.ply", "report.html"


def commands(w: MainWindow) -> list[Command]:
    return [
        Command("choose_photos", "New model from &photos…", lambda: _choose(w),
                "image-multiple-outline", "Ctrl+Shift+I",
                "A folder of photos: what they are worth, and the model they make"),
        Command("plan_survey", "&Plan a survey…", lambda: _plan(w), "clipboard-text-outline", (),
                "Before going out: distance, positions, number of photos, control points, and a "
                "field sheet"),
        Command("video_frames", "Frames from a &video…", lambda: _video(w), "movie-open-outline",
                (), "The sharp frames of a video, as photos of a model"),
        Command("make_settings", "&Settings of the model…", lambda: _settings(w), "tune", (),
                "Quality, ground control, coordinate system, threads and memory",
                lambda: _nothing_to_make(w)),
        Command("make_model", "&Make the model", lambda: w.survey.make(), "cube-scan", (),
                "Align the photos and make a dense, textured model, in the background",
                lambda: w.survey.why_not_make()),
        Command("pause_model", "Pause", lambda: w.survey.pause(), "pause", (),
                "Stop for now; what is finished is kept",
                lambda: None if w.survey.making else "no model is being made"),
        Command("show_alignment", "&Alignment…", lambda: _show_alignment(w), "vector-link", (),
                "What the photos have in common, how well they fit, and their depth maps",
                lambda: _not_aligned(w)),
        Command("show_tie_points", "Show &tie points", lambda: _show_tie_points(w),
                "dots-hexagon", (),
                "The points that join the photos, coloured by their error in pixels",
                lambda: _no_tie_points(w)),
        Command("open_report", "&Report", lambda: _open_report(w), "file-document-outline", (),
                "All figures of the reconstruction as one page", lambda: _no_report(w)),
    ]  # fmt: skip


def _plan(w: MainWindow) -> None:
    from vomstudio.ui.survey.planner_dialog import PlannerDialog

    _show(w, PlannerDialog)


def _video(w: MainWindow) -> None:
    from vomstudio.ui.survey.video_dialog import VideoDialog

    _show(w, VideoDialog)


def _settings(w: MainWindow) -> None:
    from vomstudio.ui.survey.make_dialog import MakeDialog

    _show(w, MakeDialog)


def _show(w: MainWindow, kind: Callable[[MainWindow], QDialog]) -> None:
    """The one that is open already comes forward."""
    for shown in w.findChildren(QDialog):
        if type(shown) is kind and shown.isVisible():
            shown.raise_()
            shown.activateWindow()
            return
    kind(w).show()


def _nothing_to_make(w: MainWindow) -> str | None:
    if w.survey.making is not None:
        return "a model is being made"
    return None if w.survey.rows else "choose a folder of photos first"


def is_photo_folder(path: Path) -> bool:
    """A folder that is no project."""
    return path.is_dir() and path.suffix != SUFFIX and not is_project(path)


def open_photos(w: MainWindow, folder: Path) -> None:
    w.survey.open(folder)
    w.show_dock("photos")
    dock = w.docks["photos"]
    if dock.height() < _HEIGHT and not dock.isFloating():
        w.resizeDocks([dock], [_HEIGHT], Qt.Orientation.Vertical)


NOT_ALIGNED = "the photos have not been aligned yet; make the model first"


def _results(w: MainWindow) -> Path | None:
    """Where a reconstruction is: of the photos in the panel, else of a model that is open."""
    out = w.survey.out()
    if out is not None and is_aligned(out):
        return out
    return out if out is not None and w.survey.rows else w.cameras.folder()


def _not_aligned(w: MainWindow) -> str | None:
    out = _results(w)
    if out is None:
        return "choose a folder of photos and make their model first"
    return None if is_aligned(out) else NOT_ALIGNED


def _show_alignment(w: MainWindow) -> None:
    from vomstudio.ui.alignment.alignment_dialog import AlignmentDialog

    out = _results(w)
    if out is None:
        return
    for shown in w.findChildren(AlignmentDialog):
        if shown.folder == out and shown.isVisible():
            shown.raise_()
            shown.activateWindow()
            return
    AlignmentDialog(w, w.studio, out).show()


def _no_tie_points(w: MainWindow) -> str | None:
    out = _results(w)
    if out is None:
        return "choose a folder of photos and make their model first"
    return None if (out / SPARSE).exists() else NOT_ALIGNED


def _show_tie_points(w: MainWindow) -> None:
    """As a model of its own, in the frame of the model that was made of the same photos."""
    out = _results(w)
    if out is None:
        return
    folder, studio = out.resolve(), w.studio
    # Links may lead to the same folder: paths are compared as they truly are.
    models = {
        model.id: path.resolve()
        for model in studio.session.of(Model)
        if (path := studio.project.find_model(model)) is not None
    }
    there = next((i for i, path in models.items() if path == folder / SPARSE), None)
    if there is not None:
        studio.set_visible([there], True)
        studio.display.show_field(there, FieldStyle("error_px"))
        return
    like = next((i for i, path in models.items() if path.parent == folder), None)
    name = studio.records[like].name if like is not None else folder.name

    def opened(model_id: str) -> None:
        studio.display.show_field(model_id, FieldStyle("error_px"))

    studio.open_model(out / SPARSE, w.tr("{0} tie points").format(name), like=like, then=opened)


def _no_report(w: MainWindow) -> str | None:
    out = _results(w)
    if out is not None and (out / REPORT).exists():
        return None
    return "the report is written when the model is finished"


def _open_report(w: MainWindow) -> None:
    if (out := _results(w)) is not None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(out / REPORT)))


def _choose(w: MainWindow) -> None:
    name = QFileDialog.getExistingDirectory(
        w, w.tr("A folder of photos"), w.files.folder(), QFileDialog.Option.ShowDirsOnly
    )
    if name:
        open_photos(w, Path(name))
