"""Commands that show a panel of the Analyse, Interpret or Views workspace."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import PickedFeature, TypedFeature
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_model_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks, WorkspaceSwitcher


def commands(studio: Studio, workspaces: WorkspaceSwitcher, docks: Docks) -> list[Command]:
    def model_finding() -> Finding | None:
        return missing_model_finding(studio)

    def missing_lines_finding() -> Finding | None:
        if any(get_kind(f).layer is not None for f in studio.session.of(PickedFeature)):
            return None
        return Finding("traces.none")

    def missing_planes_finding() -> Finding | None:
        if any(get_kind(f).net is not None for f in studio.session.of(TypedFeature)):
            return None
        return Finding("planes.none")

    def panel_command(workspace: str, dock: str) -> Callable[[], None]:
        def show() -> None:
            workspaces.switch(workspace)
            docks.bring_forward(dock)

        return show

    def propose_sets() -> None:
        analysis_command("sets")()
        studio.sets_requested.emit()

    view_command = partial(panel_command, "results")
    analysis_command = partial(panel_command, "results")
    return [
        Command(
            "propose_sets",
            tr("Propose &sets…"),
            propose_sets,
            icon="scatter-plot-outline",
            tip=tr("Group planes into sets and review the proposal on the net."),
            disabled_reason=missing_planes_finding,
        ),
        Command(
            "elevation_model",
            tr("&Elevation model…"),
            view_command("elevation"),
            icon="image-filter-hdr",
            tip=tr("Make a raster of heights over any plane, as GeoTIFF."),
            disabled_reason=model_finding,
        ),
        Command(
            "section",
            tr("Se&ction…"),
            view_command("section"),
            icon="box-cutter",
            tip=tr("Cut the model along a plane or line, and project features."),
            disabled_reason=model_finding,
        ),
        Command(
            "count_fractures",
            tr("F&ractures…"),
            analysis_command("fractures"),
            icon="grid",
            tip=tr("Count traces and measure their length, nodes and spacing."),
            disabled_reason=missing_lines_finding,
        ),
        Command(
            "looked_at",
            tr("Co&verage…"),
            analysis_command("looked_at"),
            icon="grid",
            tip=tr("Divide the face into cells and mark the inspected ones."),
            disabled_reason=model_finding,
        ),
        Command(
            "repeats",
            tr("Repeat&ability…"),
            analysis_command("repeats"),
            icon="replay",
            tip=tr("Repeat some picks and compare the spread with the stated errors."),
            disabled_reason=missing_lines_finding,
        ),
        Command(
            "fault_displacement",
            tr("Fault &displacement…"),
            analysis_command("displacement"),
            icon="arrow-split-horizontal",
            tip=tr("Compute net slip, throw and heave from cut-off traces."),
            disabled_reason=missing_lines_finding,
        ),
        Command(
            "three_points",
            tr("T&hree points…"),
            panel_command("interpret", "three_points"),
            icon="vector-triangle",
            tip=tr("Fit a plane through three or more points, with its error."),
        ),
        Command(
            "bed_log",
            tr("&Log…"),
            view_command("bed_log"),
            icon="layers-triple-outline",
            tip=tr("Measure true bed thicknesses along a line."),
            disabled_reason=model_finding,
        ),
    ]
