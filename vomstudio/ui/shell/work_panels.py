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

Make = Callable[[Studio, OutcropView], QWidget]


def work_panels() -> tuple[tuple[str, str, Make], ...]:
    """Name of the dock, title and maker of each; they scroll. Each is imported when it is made:
    most days nobody looks at most of them."""
    return (
        ("statistics", to_translate("Statistics"), _statistics),
        ("sets", to_translate("Sets"), _sets),
        ("slopes", to_translate("Slopes"), _slopes),
        ("section", to_translate("Section"), _section),
        ("fractures", to_translate("Fractures"), _fractures),
        ("repeats", to_translate("Repeats"), _repeats),
        ("looked_at", to_translate("Looked at"), _looked_at),
        ("displacement", to_translate("Fault displacement"), _displacement),
        ("three_points", to_translate("Three points"), _three_points),
        ("bed_log", to_translate("Log"), _bed_log),
        ("elevation", to_translate("Elevation model"), _elevation),
        ("surface", to_translate("Surface"), _surface),
        ("compare", to_translate("Compare"), _compare),
    )


def _statistics(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.analyse.statistics_panel import StatisticsPanel

    return StatisticsPanel(studio)


def _sets(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.analyse.sets_panel import SetsPanel

    return SetsPanel(studio)


def _slopes(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.analyse.slopes_panel import SlopesPanel

    return SlopesPanel(studio)


def _section(studio: Studio, view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.section_panel import SectionPanel

    return SectionPanel(studio, view.direction)


def _fractures(studio: Studio, view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.fractures_panel import FracturesPanel

    return FracturesPanel(studio, view.direction)


def _repeats(studio: Studio, view: OutcropView) -> QWidget:
    from vomstudio.ui.analyse.repeats_panel import RepeatsPanel

    return RepeatsPanel(studio, view)


def _looked_at(studio: Studio, view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.looked_at_panel import LookedAtPanel

    return LookedAtPanel(studio, view.direction)


def _displacement(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.displacement_panel import DisplacementPanel

    return DisplacementPanel(studio)


def _three_points(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.three_points_panel import ThreePointsPanel

    return ThreePointsPanel(studio)


def _bed_log(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.bed_log_panel import BedLogPanel

    return BedLogPanel(studio)


def _elevation(studio: Studio, view: OutcropView) -> QWidget:
    from vomstudio.ui.sections.elevation_panel import ElevationPanel

    return ElevationPanel(studio, view.direction)


def _surface(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.surface.surface_panel import SurfacePanel

    return SurfacePanel(studio)


def _compare(studio: Studio, _view: OutcropView) -> QWidget:
    from vomstudio.ui.registration.compare_panel import ComparePanel

    return ComparePanel(studio)


def work_commands(
    studio: Studio, dialogs: OpenDialogs, workspaces: Workspaces, docks: Docks, parent: QWidget
) -> list[Command]:
    """parent : of the dialogs"""
    from vomstudio.ui.analyse import fit_commands, profile_dialog
    from vomstudio.ui.registration import commands as registration_commands
    from vomstudio.ui.sections import panel_commands
    from vomstudio.ui.surface import commands as surface_commands

    return [
        profile_dialog.command(studio, dialogs, parent),
        *panel_commands.commands(studio, workspaces, docks),
        *fit_commands.commands(studio, parent),
        *surface_commands.commands(studio, docks),
        *registration_commands.commands(studio, dialogs, workspaces, docks, parent),
    ]
