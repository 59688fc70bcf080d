"""Commands for lines and intersections."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.notices import UPDATE_DRAWN
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import why_no_model
from vomstudio.ui.base.long_boxes import fit_to_screen
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.commands import domain_splitting
from vomstudio.ui.commands.drawing_import import DrawingImport
from vomstudio.ui.commands.plane_import import ListedImport
from vomstudio.ui.panels.features import plane_relations
from vomstudio.ui.panels.view.view_panel import ViewPanel


def commands(studio: Studio, directions: ViewPanel, parent: QWidget) -> list[Command]:
    """Create the commands for lines, intersections and imported features."""

    def why_too_few_groups() -> Finding | None:
        if len(plane_relations.list_plane_groups(studio)) > 1:
            return None
        return Finding("action.one-group")

    def ask_for_sets() -> None:
        dialog = plane_relations.IntersectionDialog(studio, parent)
        fit_to_screen(dialog)
        dialog.open()

    drawings, lists = DrawingImport(parent, studio), ListedImport(parent, studio)
    return [
        Command(
            "keep_intersection",
            tr("&Keep intersection"),
            lambda: plane_relations.keep_intersection(studio),
            icon="vector-intersection",
            tip=tr("Save the intersection of the two selected planes as a line."),
            why_not=lambda: plane_relations.why_not_keep(studio),
        ),
        Command(
            "intersection_of_sets",
            tr("&Intersection of sets…"),
            ask_for_sets,
            icon="vector-intersection",
            tip=tr("Intersect the mean planes of two types or sets."),
            why_not=why_too_few_groups,
        ),
        Command(
            "part_by_plane",
            tr("S&plit into domains"),
            lambda: domain_splitting.split_domains(studio),
            icon="vector-difference",
            tip=tr("Assign the domains hanging wall and footwall by the selected plane."),
            why_not=lambda: domain_splitting.why_not(studio),
        ),
        Command(
            "import_listed",
            tr("Import &features…"),
            lists.choose,
            icon="map-marker-plus",
            tip=tr("Import traces, planes, stations and areas of other programs."),
            why_not=lambda: why_no_model(studio),
        ),
        Command(
            "import_drawing",
            tr("Import &drawn lines…"),
            drawings.choose,
            icon="vector-polyline-plus",
            tip=tr("Project lines drawn on an orthophoto onto the model as traces."),
            why_not=drawings.why_not,
        ),
        Command(
            UPDATE_DRAWN,
            tr("&Update edited traces"),
            drawings.update,
            icon="vector-polyline-edit",
            tip=tr("Update traces that were edited in the imported drawing."),
            why_not=drawings.why_no_update,
        ),
        Command(
            "along_line",
            tr("Along the &line"),
            directions.look_along_line,
            shortcut="I",
            tip=tr("Look along the selected lineation or intersection (orthographic)."),
            why_not=directions.why_no_line,
            is_viewport_key=True,
        ),
    ]
