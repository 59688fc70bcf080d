"""Commands for lines and intersections."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.notices import UPDATE_DRAWN
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_model_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.commands import domain_splitting
from vomstudio.ui.commands.drawing_import import DrawingImport
from vomstudio.ui.commands.feature_import import FeatureListImport
from vomstudio.ui.panels.features import plane_relations
from vomstudio.ui.panels.view.view_panel import ViewPanel


def commands(studio: Studio, directions: ViewPanel, parent: QWidget) -> list[Command]:
    """Create the commands for lines, intersections and imported features."""

    def group_count_finding() -> Finding | None:
        if len(plane_relations.list_plane_groups(studio)) > 1:
            return None
        return Finding("action.one-group")

    def ask_for_sets() -> None:
        dialog = plane_relations.IntersectionDialog(studio, parent)
        fit_to_screen(dialog)
        dialog.open()

    drawing_import, feature_import = (
        DrawingImport(parent, studio),
        FeatureListImport(parent, studio),
    )
    return [
        Command(
            "keep_intersection",
            tr("&Keep intersection"),
            lambda: plane_relations.keep_intersection(studio),
            icon="vector-intersection",
            tip=tr("Save the intersection of the two selected planes as a line."),
            disabled_reason=lambda: plane_relations.keep_problem(studio),
        ),
        Command(
            "intersection_of_sets",
            tr("&Intersection of sets…"),
            ask_for_sets,
            icon="vector-intersection",
            tip=tr("Intersect the mean planes of two types or sets."),
            disabled_reason=group_count_finding,
        ),
        Command(
            "part_by_plane",
            tr("S&plit into domains"),
            lambda: domain_splitting.split_domains(studio),
            icon="vector-difference",
            tip=tr("Assign features to the hanging wall or footwall of the selected plane."),
            disabled_reason=lambda: domain_splitting.disabled_reason(studio),
        ),
        Command(
            "import_listed",
            tr("Import &features…"),
            feature_import.choose_file,
            icon="map-marker-plus",
            tip=tr("Import traces, planes, stations and areas from other programs."),
            disabled_reason=lambda: missing_model_finding(studio),
        ),
        Command(
            "import_drawing",
            tr("Import &drawn lines…"),
            drawing_import.choose_file,
            icon="vector-polyline-plus",
            tip=tr("Project lines drawn on an orthophoto onto the model as traces."),
            disabled_reason=drawing_import.disabled_reason,
        ),
        Command(
            UPDATE_DRAWN,
            tr("&Update edited traces"),
            drawing_import.update,
            icon="vector-polyline-edit",
            tip=tr("Update traces that were edited in the imported drawing."),
            disabled_reason=drawing_import.missing_update_finding,
        ),
        Command(
            "along_line",
            tr("Along the &line"),
            directions.look_along_line,
            shortcut="I",
            tip=tr("Look along the selected lineation or intersection (orthographic)."),
            disabled_reason=directions.line_problem,
            is_viewport_key=True,
        ),
    ]
