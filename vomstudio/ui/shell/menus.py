"""Menus of the main window and their commands."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow

from vomstudio.core.words import to_translate, tr
from vomstudio.ui.commands.project_files import Files

# "|" is a separator between commands, and "*" precedes the name of a submenu.
MENUS = (
    (
        to_translate("&File"),
        (
            "new",
            "open",
            "choose_photos",
            "open_project",
            "*recent",
            "*discarded",
            "|",
            "save",
            "save_as",
            "compact_project",
            "|",
            "import_readings",
            "import_listed",
            "import_drawing",
            "|",
            "export_csv",
            "export_gpkg",
            "export_program",
            "export_net",
            "project_report",
            "copy_export",
            "|",
            "quit",
        ),
    ),
    (
        to_translate("&Edit"),
        ("undo", "redo", "|", "delete", "rename", "|", "select_all", "|", "find_command"),
    ),
    (
        to_translate("&View"),
        (
            "home",
            "frame_selection",
            "orthographic",
            "*views",
            "|",
            "clipping_box",
            "display_settings",
            "labels",
            "*planes",
            "*notation",
            "|",
            "show_only",
            "show_all",
            "show_in_photos",
            "|",
            "only_outcrop",
            "page_in_center",
            "dock_net",
            "second_view",
            "reset_panels",
            "*theme",
        ),
    ),
    (
        to_translate("&Photos"),
        (
            "plan_survey",
            "video_frames",
            "|",
            "make_settings",
            "make_model",
            "|",
            "show_alignment",
            "open_report",
        ),
    ),
    (
        to_translate("&Model"),
        (
            "declare_frame",
            "register_model",
            "fit_model",
            "compare_models",
            "|",
            "locate",
            "open_cameras",
            "|",
            "export_model",
        ),
    ),
    (
        to_translate("&Interpret"),
        (
            "surface_fields",
            "propose_facets",
            "propose_traces",
            "|",
            "feature_types",
            "update_surroundings",
        ),
    ),
    (
        to_translate("&Analyse"),
        (
            "orthophoto",
            "section",
            "elevation_model",
            "bed_log",
            "|",
            "propose_sets",
            "intersection_of_sets",
            "part_by_plane",
            "extend_plane",
            "three_points",
            "|",
            "count_fractures",
            "fault_displacement",
            "looked_at",
            "repeats",
            "|",
            "verdict_profile",
        ),
    ),
    (
        to_translate("&Help"),
        ("documentation", "first_tour", "shortcuts", "save_report", "|", "about"),
    ),
)
"""Commands of each menu. The other commands have a key, or a button in a panel or context menu. The
search finds all commands."""

_SUBMENUS = {
    "views": (
        to_translate("&Standard views"),
        (
            "view_top",
            "view_north",
            "view_east",
            "view_south",
            "view_west",
            "view_bottom",
        ),
    ),
    "planes": (
        to_translate("&Planes as"),
        ("planes_discs", "planes_symbols", "planes_neither"),
    ),
    "notation": (
        to_translate("&Notation"),
        ("notation_dipdir", "notation_strike", "notation_quadrant"),
    ),
    "theme": (to_translate("Th&eme"), ("theme_system", "theme_light", "theme_dark")),
}


def fill_menus(window: QMainWindow, actions: Mapping[str, QAction], files: Files) -> None:
    """Fill the menu bar. Submenus of files are filled each time they are opened."""
    fill = {
        "recent": (tr("Open &recent"), files.fill_recent_menu),
        "discarded": (tr("&Restore discarded work"), files.fill_discarded_menu),
    }
    for title, names in MENUS:
        menu = window.menuBar().addMenu(tr(title))
        menu.setToolTipsVisible(True)
        for name in names:
            if name == "|":
                menu.addSeparator()
            elif name[1:] in fill:
                submenu_title, fill_submenu = fill[name[1:]]
                submenu = menu.addMenu(submenu_title)
                submenu.aboutToShow.connect(partial(fill_submenu, submenu))
            elif name.startswith("*"):
                submenu_title, submenu_commands = _SUBMENUS[name[1:]]
                submenu = menu.addMenu(tr(submenu_title))
                submenu.setToolTipsVisible(True)
                submenu.addActions([actions[item] for item in submenu_commands])
            else:
                menu.addAction(actions[name])
