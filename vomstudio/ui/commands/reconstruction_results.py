"""Commands for the results of a reconstruction: alignment, tie points and report."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.base.stage_folders import is_aligned
from vomstudio.project.records import Model
from vomstudio.rendering.view.scalars import FieldStyle
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.camera_view import CameraView
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.widgets.html_page import open_page

TIE_POINT_FILE, REPORT_FILE = "sparse.ply", "report.html"


def commands(
    studio: Studio,
    survey: PhotoSurvey,
    cameras: CameraView,
    dialogs: OpenDialogs,
    parent: QWidget,
) -> list[Command]:
    """Create the commands for the results of a reconstruction."""

    def find_results() -> Path | None:
        """Return the reconstruction folder of the Photos panel, else of an open model, or None."""
        output_folder = survey.output_folder()
        if output_folder is not None and is_aligned(output_folder):
            return output_folder
        return output_folder if output_folder is not None and survey.rows else cameras.folder()

    def alignment_problem() -> Finding | None:
        output_folder = find_results()
        if output_folder is None:
            return Finding("action.no-photos")
        return None if is_aligned(output_folder) else Finding("action.not-aligned")

    def show_alignment() -> None:
        from vomstudio.ui.dialogs.alignment.alignment_dialog import AlignmentDialog

        if (output_folder := find_results()) is not None:
            dialogs.show(
                AlignmentDialog,
                lambda: AlignmentDialog(parent, studio, output_folder),
                output_folder,
            )

    def missing_tie_points_finding() -> Finding | None:
        output_folder = find_results()
        if output_folder is None:
            return Finding("action.no-photos")
        return None if (output_folder / TIE_POINT_FILE).exists() else Finding("action.not-aligned")

    def show_tie_points() -> None:
        if (output_folder := find_results()) is not None:
            _show_tie_points(studio, output_folder)

    def missing_report_finding() -> Finding | None:
        output_folder = find_results()
        if output_folder is not None and (output_folder / REPORT_FILE).exists():
            return None
        return Finding("action.no-report")

    def open_report() -> None:
        if (output_folder := find_results()) is not None:
            open_page(parent, output_folder / REPORT_FILE)

    return [
        Command(
            "show_alignment",
            tr("&Alignment…"),
            show_alignment,
            icon="vector-link",
            tip=tr("Matches, camera calibration, residuals and depth maps."),
            disabled_reason=alignment_problem,
        ),
        Command(
            "show_tie_points",
            tr("Show &tie points"),
            show_tie_points,
            icon="dots-hexagon",
            tip=tr("Show the sparse cloud of tie points, coloured by reprojection error."),
            disabled_reason=missing_tie_points_finding,
        ),
        Command(
            "open_report",
            tr("&Report"),
            open_report,
            icon="file-document-outline",
            tip=tr("Show the report with all figures of the reconstruction."),
            disabled_reason=missing_report_finding,
        ),
    ]


def _show_tie_points(studio: Studio, output_folder: Path) -> None:
    """Open the tie points as a model in the frame of the model made from the same photos."""
    folder = output_folder.resolve()
    # Symbolic links may lead to the same folder, so resolved paths are compared.
    models = {
        model.id: path.resolve()
        for model in studio.session.of(Model)
        if (path := studio.project.find_model(model)) is not None
    }
    existing_id = next((i for i, path in models.items() if path == folder / TIE_POINT_FILE), None)
    if existing_id is not None:
        studio.set_visible([existing_id], True)
        studio.display.show_field(existing_id, FieldStyle("error_px"))
        return
    sibling_id = next((i for i, path in models.items() if path.parent == folder), None)
    name = studio.records[sibling_id].name if sibling_id is not None else folder.name

    def show_errors(model_id: str) -> None:
        studio.display.show_field(model_id, FieldStyle("error_px"))

    studio.open_model(
        output_folder / TIE_POINT_FILE,
        tr("Tie points of {model}", model=name),
        reference_id=sibling_id,
        finished_callback=show_errors,
    )
