"""The menus: which commands each contains."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMenu

from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.commands import display as display_commands
from vomstudio.ui.commands.project_files import Files
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.top_bar import command_names

# "|" is a line between commands, "*" stands before the name of a menu inside the menu, and "+"
# before that of a group of commands that the tools bring.
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
            "take_back_compaction",
            "|",
            "import_readings",
            "import_listed",
            "import_drawing",
            "update_drawn_traces",
            "|",
            "export_csv",
            "export_gpkg",
            "export_shp",
            "export_dxf",
            "export_program",
            "export_net",
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
            "|",
            "view_back",
            "view_forward",
            "|",
            "*views",
            "*display",
            "clipping_box",
            "clipping_reset",
            "*planes",
            "labels",
            "*notation",
            "trackball",
            "|",
            "show_chosen",
            "hide_chosen",
            "show_only",
            "show_all",
            "|",
            "show_in_photos",
            "previous_photo",
            "next_photo",
            "fit_photo",
            "|",
            "outcrop_or_photo",
            "*workspaces",
            "*docks",
            "only_outcrop",
            "page_in_center",
            "net_in_middle",
            "dock_net",
            "reset_panels",
            "*theme",
        ),
    ),
    (
        to_translate("&Photos"),
        (
            "plan_survey",
            "video_frames",
            "choose_photos",
            "open_photo",
            "close_photo",
            "take_in_photos",
            "|",
            "make_settings",
            "make_model",
            "pause_model",
            "|",
            "show_alignment",
            "show_tie_points",
            "open_report",
        ),
    ),
    (
        to_translate("&Model"),
        (
            "declare_frame",
            "convert_model",
            "register_model",
            "fit_model",
            "compare_models",
            "|",
            "locate",
            "open_cameras",
            "find_photos",
            "|",
            "copy_model",
            "export_model",
            "remove_model",
        ),
    ),
    (
        to_translate("&Interpret"),
        (
            "navigate",
            "+tools",
            "|",
            "follow",
            "finish",
            "cancel",
            "continue_trace",
            "delete_vertex",
            "|",
            "+of_tools",
            "surface_fields",
            "propose_facets",
            "propose_traces",
            "measure_thickness",
            "|",
            "feature_types",
            "update_surroundings",
        ),
    ),
    (
        to_translate("&Analyse"),
        (
            "along_beta",
            "along_line",
            "face_plane",
            "|",
            "keep_intersection",
            "part_by_plane",
            "intersection_of_sets",
            "extend_plane",
            "patch_surface",
            "|",
            "propose_sets",
            "count_fractures",
            "looked_at",
            "repeats",
            "fault_displacement",
            "three_points",
            "bed_log",
            "|",
            "orthophoto",
            "elevation_model",
            "section",
            "|",
            "verdict_profile",
            "fit_figure",
            "copy_fit",
            "|",
            "type_on_net",
            "copy_net",
            "rose_diagram",
            "net_contours",
            "figure_style",
            "show_stereonet",
        ),
    ),
    (
        to_translate("&Help"),
        ("documentation", "first_tour", "explain", "shortcuts", "save_report", "|", "about"),
    ),
)

# With more of its commands a tool would make the menu Interpret higher than a laptop's screen.
MAX_TOOL_ENTRIES = 8

# Menus inside a menu that are lists of commands.
_INNER = {
    "views": (
        "view_top",
        "view_north",
        "view_east",
        "view_south",
        "view_west",
        "view_bottom",
    ),
    "planes": ("planes_discs", "planes_symbols", "planes_neither"),
    "notation": ("notation_dipdir", "notation_strike", "notation_quadrant"),
    "theme": ("theme_system", "theme_light", "theme_dark"),
}

FillMenu = Callable[[QMenu], None]
Groups = Mapping[str, Sequence[str]]
"""Names of commands, and lines between them, by the name of the group."""


def fill_menus(
    window: QMainWindow,
    studio: Studio,
    files: Files,
    docks: WindowDocks,
    actions: Mapping[str, QAction],
    tool_commands: Mapping[str, Sequence[Command]],
) -> None:
    """Fill the menu bar. The commands of each tool, `of_tools`, are in its menu if they are
    many."""
    names = {tool: [command.name for command in some] for tool, some in tool_commands.items()}
    groups = {
        "workspaces": command_names(),
        "tools": [entry.name for entry in TOOLS],
        **names,
        "of_tools": [
            entry
            for tool, some in names.items()
            for entry in ([f"*{tool}"] if len(some) > MAX_TOOL_ENTRIES else [*some, "|"])
        ],
    }
    fill_menu_bar(
        window,
        actions,
        fresh={"recent": files.fill_recent, "discarded": files.fill_discarded},
        once={
            "display": lambda menu: display_commands.fill_menu(menu, actions, studio),
            "docks": docks.fill_menu,
        },
        groups=groups,
    )


def fill_menu_bar(
    window: QMainWindow,
    actions: Mapping[str, QAction],
    *,
    fresh: Mapping[str, FillMenu],
    once: Mapping[str, FillMenu],
    groups: Groups,
) -> None:
    """fresh : what fills a menu inside a menu whenever it is opened; once : what fills it now"""
    for title, names in MENUS:
        menu = window.menuBar().addMenu(tr(title))
        menu.setToolTipsVisible(True)
        for name in _expand_groups(names, groups):
            if name == "|":
                menu.addSeparator()
            elif name.startswith("*"):
                _add_menu(menu, name[1:], actions, fresh, once, groups)
            else:
                menu.addAction(actions[name])


def _expand_groups(names: Sequence[str], groups: Groups) -> Iterator[str]:
    for name in names:
        yield from groups[name[1:]] if name.startswith("+") else (name,)


def _add_menu(
    menu: QMenu,
    name: str,
    actions: Mapping[str, QAction],
    fresh: Mapping[str, FillMenu],
    once: Mapping[str, FillMenu],
    groups: Groups,
) -> None:
    titles = {
        "recent": tr("Open &recent"),
        "discarded": tr("&Restore discarded work"),
        "display": tr("&Display"),
        "views": tr("&Standard views"),
        "planes": tr("&Planes as"),
        "notation": tr("&Notation"),
        "docks": tr("&Panels"),
        "workspaces": tr("&Workspaces"),
        "theme": tr("Th&eme"),
        "select": tr("Se&lect on the surface"),
    }
    inner = menu.addMenu(titles[name])
    if name in fresh:
        fill = fresh[name]
        inner.aboutToShow.connect(lambda: fill(inner))
    elif name in once:
        once[name](inner)
    else:
        inner.setToolTipsVisible(True)
        inner.addActions([actions[each] for each in groups.get(name, _INNER.get(name, ()))])
