"""The menus and the toolbar: which commands stand where."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMenu, QSizePolicy, QToolBar, QToolButton, QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.commands import display as display_commands
from vomstudio.ui.commands.project_files import Files
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.workspace_bar import FittingBar, buttons_of, command_names, make_strip

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
            "view_top",
            "view_north",
            "view_east",
            "view_south",
            "view_west",
            "view_bottom",
            "|",
            "*display",
            "clipping_box",
            "clipping_reset",
            "*planes",
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
            "net_in_middle",
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
            "figure_style",
            "show_stereonet",
        ),
    ),
    (
        to_translate("&Help"),
        ("documentation", "first_tour", "explain", "shortcuts", "save_report", "|", "about"),
    ),
)

_TOOLBAR = (
    "open",
    "save",
    "|",
    "navigate",
    "+tools_in_bar",
    "|",
    "undo",
    "redo",
    "|",
    "home",
    "frame_selection",
    "orthographic",
    "*views",
)
# With more of its commands a tool would make the menu Interpret higher than a laptop's screen.
_MOST_OF_A_TOOL = 8
_VIEWS = ("top", "north", "east", "south", "west", "bottom")
# What everybody knows by its icon: so the bar has room at 1400 pixels.
_ICON_ONLY = ("save", "undo", "redo", "home", "frame_selection")

# Menus inside a menu that are lists of commands.
_INNER = {
    "planes": ("planes_discs", "planes_symbols", "planes_neither"),
    "notation": ("notation_dipdir", "notation_strike", "notation_quadrant"),
    "theme": ("theme_system", "theme_light", "theme_dark"),
}

FillMenu = Callable[[QMenu], None]
Groups = Mapping[str, Sequence[str]]
"""Names of commands, and lines between them, by the name of the group."""


def make_bars(
    window: QMainWindow,
    studio: Studio,
    files: Files,
    docks: WindowDocks,
    actions: Mapping[str, QAction],
    of_tools: Mapping[str, Sequence[Command]],
) -> None:
    """Give the window its menus, its toolbar and the strip of workspaces. of_tools : the commands
    of each tool, for the menu; many of them have a menu of their own"""
    names = {tool: [command.name for command in some] for tool, some in of_tools.items()}
    groups = {
        "workspaces": command_names(),
        "tools": [entry.name for entry in TOOLS],
        "tools_in_bar": [entry.name for entry in TOOLS if entry.is_in_toolbar],
        **names,
        "of_tools": [
            entry
            for tool, some in names.items()
            for entry in ([f"*{tool}"] if len(some) > _MOST_OF_A_TOOL else [*some, "|"])
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
    window.addToolBar(make_toolbar(actions, groups))
    window.addToolBarBreak()
    window.addToolBar(make_strip(actions))


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
        for name in _with_groups(names, groups):
            if name == "|":
                menu.addSeparator()
            elif name.startswith("*"):
                _add_menu(menu, name[1:], actions, fresh, once, groups)
            else:
                menu.addAction(actions[name])


def _with_groups(names: Sequence[str], groups: Groups) -> Iterator[str]:
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


def make_toolbar(actions: Mapping[str, QAction], groups: Groups) -> QToolBar:
    """The toolbar with its commands, the menu of views and the search for commands."""
    bar = FittingBar(tr("Tools"), "toolbar")
    for name in _with_groups(_TOOLBAR, groups):
        if name == "|":
            bar.addSeparator()
        elif name == "*views":
            views = _views_button(tr("Views"), actions)
            bar.addWidget(views)
        else:
            bar.addAction(actions[name])
    space = QWidget()
    space.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
    bar.addWidget(space)
    find = QToolButton()
    find.setIcon(theme.icon("magnify"))
    find.setText(tr("Find command  Ctrl+K"))
    find.setToolTip(tr("Find a command by its words (Ctrl+K)."))
    find.clicked.connect(actions["find_command"].trigger)
    bar.addWidget(find)
    # Texts that are missed least go first; those of the tools stay longest.
    bar.drop_texts([find])
    for names in (("orthographic",), ("open", "save"), groups["tools_in_bar"], ("navigate",)):
        own = [actions[name] for name in names if name not in _ICON_ONLY]
        bar.drop_texts([*([views] if "orthographic" in names else []), *buttons_of(bar, own)])
    return bar


def _views_button(text: str, actions: Mapping[str, QAction]) -> QToolButton:
    button = QToolButton()
    button.setText(text)
    button.setIcon(theme.icon("compass-outline"))
    button.setToolTip(tr("Views from the compass directions, from above and from below."))
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    menu = QMenu(button)
    menu.addActions([actions[f"view_{each}"] for each in _VIEWS])
    button.setMenu(menu)
    return button
