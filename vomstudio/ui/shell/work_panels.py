"""Panels and commands that mainly depend on the studio.

New panels and commands of this kind are added here, without changes to the window.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from PySide6.QtWidgets import QWidget

from vomstudio.core.words import to_translate
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks, WorkspaceSwitcher
from vomstudio.ui.outcrop.outcrop_view import OutcropView

PanelFactory = Callable[[Studio, OutcropView], QWidget]
ArgumentsGetter = Callable[[OutcropView], tuple[object, ...]]


PERMANENT_PAGES = ("second_view",)
"""Pages that stay when another project is opened, because they hold graphics memory."""


def work_panels() -> tuple[tuple[str, str, PanelFactory], ...]:
    """Return the dock name, title and factory of each scrolling panel.

    A panel is imported when it is created, because most panels are rarely used.
    """
    position = _create_factory
    return (
        (
            "statistics",
            to_translate("Statistics"),
            position("panels.statistics.statistics_panel.StatisticsPanel"),
        ),
        ("sets", to_translate("Sets"), position("panels.sets.sets_panel.SetsPanel")),
        ("slopes", to_translate("Slopes"), position("panels.slopes.slopes_panel.SlopesPanel")),
        (
            "section",
            to_translate("Section"),
            position("panels.sections.section_panel.SectionPanel", _view_direction),
        ),
        (
            "fractures",
            to_translate("Fractures"),
            position("panels.fractures.fractures_panel.FracturesPanel", _view_direction),
        ),
        (
            "repeats",
            to_translate("Repeats"),
            position("panels.repeatability_panel.RepeatsPanel", _view_argument),
        ),
        (
            "looked_at",
            to_translate("Coverage"),
            position("panels.coverage.coverage_panel.CoveragePanel", _view_direction),
        ),
        (
            "displacement",
            to_translate("Fault displacement"),
            position("panels.displacement_panel.DisplacementPanel"),
        ),
        (
            "three_points",
            to_translate("Three points"),
            position("panels.three_points_panel.ThreePointsPanel"),
        ),
        ("bed_log", to_translate("Log"), position("panels.logs.log_panel.BedLogPanel")),
        (
            "elevation",
            to_translate("Elevation model"),
            position("panels.sections.elevation_panel.ElevationPanel", _view_direction),
        ),
        ("surface", to_translate("Surface"), position("panels.surface.surface_panel.SurfacePanel")),
        (
            "second_view",
            to_translate("Second view"),
            position("panels.view.second_view_panel.SecondViewPanel", _view_argument),
        ),
        (
            "compare",
            to_translate("Compare"),
            position("panels.comparison.compare_panel.ComparePanel"),
        ),
    )


def _no_arguments(_: OutcropView) -> tuple[object, ...]:
    return ()


def _view_direction(view: OutcropView) -> tuple[object, ...]:
    return (view.view_direction,)


def _view_argument(view: OutcropView) -> tuple[object, ...]:
    return (view,)


def _create_factory(
    class_path: str, find_arguments: ArgumentsGetter = _no_arguments
) -> PanelFactory:
    """Return the factory of a panel.

    Parameters
    ----------
    class_path : str
        Module below `vomstudio.ui` and class of the panel.
    find_arguments : callable
        Returns the arguments of the class after the studio.
    """
    module, _, class_name = class_path.rpartition(".")

    def make(studio: Studio, view: OutcropView) -> QWidget:
        panel: QWidget = getattr(import_module(f"vomstudio.ui.{module}"), class_name)(
            studio, *find_arguments(view)
        )
        return panel

    return make


def work_commands(
    studio: Studio,
    dialogs: OpenDialogs,
    workspaces: WorkspaceSwitcher,
    docks: Docks,
    parent: QWidget,
) -> list[Command]:
    """Return the commands that mainly depend on the studio, with dialogs of `parent`."""
    from vomstudio.ui.commands import fits as fit_commands
    from vomstudio.ui.commands import model_comparison as registration_commands
    from vomstudio.ui.commands import panels as panel_commands
    from vomstudio.ui.commands import surface_pages as surface_commands
    from vomstudio.ui.dialogs import profile_dialog

    return [
        profile_dialog.command(studio, dialogs, parent),
        *panel_commands.commands(studio, workspaces, docks),
        *fit_commands.commands(studio, parent),
        *surface_commands.commands(studio, docks),
        *registration_commands.commands(studio, dialogs, workspaces, docks, parent),
    ]
