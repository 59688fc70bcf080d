"""Panels and commands that need the studio and little else, each with its place: new ones of that
kind are added here, and the window stays as it is."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.open_dialogs import OpenDialogs
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.window_protocols import Docks, Workspaces
from vomstudio.ui.scene.outcrop_view import OutcropView
from vomstudio.words import to_translate

Make = Callable[[Studio], QWidget]


def work_panels(view: OutcropView) -> tuple[tuple[str, str, Make], ...]:
    """Name of the dock, title and maker of each; they scroll. view : from which planes are taken"""
    from vomstudio.ui.analyse.repeats_panel import RepeatsPanel
    from vomstudio.ui.analyse.sets_panel import SetsPanel
    from vomstudio.ui.analyse.slopes_panel import SlopesPanel
    from vomstudio.ui.analyse.statistics_panel import StatisticsPanel
    from vomstudio.ui.registration.compare_panel import ComparePanel
    from vomstudio.ui.sections.bed_log_panel import BedLogPanel
    from vomstudio.ui.sections.displacement_panel import DisplacementPanel
    from vomstudio.ui.sections.elevation_panel import ElevationPanel
    from vomstudio.ui.sections.fractures_panel import FracturesPanel
    from vomstudio.ui.sections.looked_at_panel import LookedAtPanel
    from vomstudio.ui.sections.section_panel import SectionPanel
    from vomstudio.ui.sections.three_points_panel import ThreePointsPanel
    from vomstudio.ui.surface.surface_panel import SurfacePanel

    return (
        ("statistics", to_translate("Statistics"), StatisticsPanel),
        ("sets", to_translate("Sets"), SetsPanel),
        ("slopes", to_translate("Slopes"), SlopesPanel),
        ("section", to_translate("Section"), lambda studio: SectionPanel(studio, view.direction)),
        ("fractures", to_translate("Fractures"),
         lambda studio: FracturesPanel(studio, view.direction)),
        ("repeats", to_translate("Repeats"), lambda studio: RepeatsPanel(studio, view)),
        ("looked_at", to_translate("Looked at"),
         lambda studio: LookedAtPanel(studio, view.direction)),
        ("displacement", to_translate("Fault displacement"), DisplacementPanel),
        ("three_points", to_translate("Three points"), ThreePointsPanel),
        ("bed_log", to_translate("Log"), BedLogPanel),
        ("elevation", to_translate("Elevation model"),
         lambda studio: ElevationPanel(studio, view.direction)),
        ("surface", to_translate("Surface"), SurfacePanel),
        ("compare", to_translate("Compare"), ComparePanel),
    )  # fmt: skip


def work_commands(
    studio: Studio, dialogs: OpenDialogs, workspaces: Workspaces, docks: Docks, parent: QWidget
) -> list[Command]:
    """parent : of the dialogs"""
    from vomstudio.ui.analyse import fit_commands, profile_dialog, sets_panel
    from vomstudio.ui.registration import commands as registration_commands
    from vomstudio.ui.sections import panel_commands
    from vomstudio.ui.surface import surface_panel

    return [
        profile_dialog.command(studio, dialogs, parent),
        sets_panel.command(studio, workspaces, docks),
        *panel_commands.commands(studio, workspaces, docks),
        *fit_commands.commands(studio, parent),
        *surface_panel.commands(studio, docks),
        *registration_commands.commands(studio, dialogs, workspaces, docks, parent),
    ]
