"""Main window, which creates the parts and connects them.

The available actions are defined by the commands, and are carried out by the studio and the
panels.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QKeyEvent,
    QKeySequence,
    QShortcut,
)
from PySide6.QtWidgets import QMainWindow

from vomstudio.core.words import tr
from vomstudio.io.settings import Settings
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.search import SearchEntry
from vomstudio.ui.shell import thread_switching, warm_up
from vomstudio.ui.shell.background_imports import BackgroundImports, NetPlaceholder
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.drag_and_drop import dragged_files
from vomstudio.ui.shell.first_paint import FirstPaint
from vomstudio.ui.shell.screens import restore_geometry
from vomstudio.ui.shell.workspaces import Workspaces, stored_geometry
from vomstudio.ui.widgets.failure_notices import can_close, close_all

if TYPE_CHECKING:
    from vomstudio.rendering.qt.viewport import Viewport
    from vomstudio.ui.dialogs.command_palette import Destination
    from vomstudio.ui.panels.net.stereonet_panel import StereonetPanel
    from vomstudio.ui.widgets.type_box import TypeBox

# A viewport that cannot draw must not prevent the net from being shown.
_MAX_WAIT_MS = 5000
# By then a model of the command line is usually open; compiling would delay it.
_COMPILATION_DELAY_MS = 10_000


class MainWindow(QMainWindow):
    """Main window of the program.

    It is created in two steps: first an empty frame that is visible immediately, then its
    contents by `begin`. Its parts do not depend on it, and use it only as a parent widget.
    """

    net: StereonetPanel
    """Panel of the net, which exists once Matplotlib has been imported."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        thread_switching.shorten_switch_interval()
        self._settings = settings
        self._is_filled = False
        self._imports = BackgroundImports()
        self._imports.stereonet_imported.connect(self._add_stereonet)
        self._imports.all_imported.connect(self._imports_done)
        self._is_drawing = False
        self._compilation_timer = QTimer(self, singleShot=True, interval=_COMPILATION_DELAY_MS)
        self._compilation_timer.timeout.connect(self._compile_kernels)
        self.viewport: Viewport | None = None
        self.setWindowTitle(tr("VOM Studio"))
        self.setAcceptDrops(True)
        self.setDockNestingEnabled(True)
        restore_geometry(self, stored_geometry(settings.window))
        starting = Label(tr("VOM Studio is starting…"))
        starting.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setCentralWidget(starting)

    def _fill(self, *, has_paths: bool = False) -> None:
        """Create everything except the viewport and the net. The imports here are slow."""
        from vomstudio.ui.base.studio import Studio

        self.studio = Studio(self._settings)
        if has_paths:
            # Meanwhile, the process that reads the model imports the required libraries.
            warm_up.import_libraries(self.studio)
        self._create_models()
        self.studio.new_project()
        self._make_actions()
        self._create_centre()
        self._make_panels()
        self._fill_docks()
        self._create_bars()
        self._connect_signals()
        self.workspaces.begin()
        self._is_filled = True
        self.studio.project_opened.emit()
        self.actions_table.refresh()

    @property
    def is_filled(self) -> bool:
        """Whether the studio and the panels have been created."""
        return self._is_filled

    # --- parts -------------------------------------------------------------------------------
    def _create_models(self) -> None:
        """Create the objects that several panels or commands share."""
        from vomstudio.ui.commands.project_files import Files
        from vomstudio.ui.outcrop.camera_view import CameraView
        from vomstudio.ui.outcrop.outcrop_view import OutcropView
        from vomstudio.ui.panels.photos.photo_commands import PhotoOpening
        from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
        from vomstudio.ui.shell.photo_tab import PhotoTab

        self.survey = PhotoSurvey(self.studio)
        self.files = Files(self, self.studio, self.survey)
        self.photo_links = self.studio.photo_links
        self.cameras = CameraView(self.studio, self.photo_links)
        self.view = OutcropView(self.studio, self.cameras)
        self.docks = WindowDocks(self)
        self.workspaces = Workspaces(self, self.docks, self._settings.window)
        self._dialogs = OpenDialogs()
        self.photo_opening = PhotoOpening(self.studio, self.survey)
        self.photo_tab = PhotoTab(self.photo_opening, self.docks, self.workspaces, self)

    def _make_actions(self) -> None:
        from vomstudio.ui.panels.in_photos.feature_photo import FeaturePhoto
        from vomstudio.ui.panels.in_photos.sighting_list import SightingList
        from vomstudio.ui.panels.view.view_panel import ViewPanel

        self.view_panel = ViewPanel(self.studio, self.view)
        self._feature_photo = FeaturePhoto(self.studio)
        self._sightings = SightingList(self._feature_photo.images)
        self.actions_table = Actions(self)
        commands = (*self._basic_commands(), *self._photo_commands(), *self._remaining_commands())
        for command in self.photo_tab.adapt_commands(commands):
            self.actions_table.add(command)

    def _basic_commands(self) -> list[Command]:
        from vomstudio.ui.commands import edit as edit_commands
        from vomstudio.ui.commands import files as file_commands
        from vomstudio.ui.commands import models as model_commands
        from vomstudio.ui.commands import tools as tool_commands
        from vomstudio.ui.commands import view as view_commands
        from vomstudio.ui.shell import top_bar

        studio = self.studio
        find = partial(edit_commands.search, self, self.actions_table, self._search_destinations)
        return [
            *file_commands.commands(studio, self.files, self.close),
            *edit_commands.commands(studio, find, self),
            *view_commands.commands(studio, self.view, self.workspaces.show_only_outcrop),
            *top_bar.commands(self.workspaces, self.docks),
            *model_commands.commands(studio, self.files, self.photo_links, self, self.workspaces),
            *tool_commands.commands(studio, self.view_panel, self.docks),
        ]

    def _photo_commands(self) -> list[Command]:
        from vomstudio.ui.commands import outcrop_photos as outcrop_photo_commands
        from vomstudio.ui.commands import reconstruction_results as result_commands
        from vomstudio.ui.commands import survey as survey_commands
        from vomstudio.ui.panels.photos import photo_commands

        studio, survey, dialogs = self.studio, self.survey, self._dialogs
        actions, open_model = self.actions_table.all, self._open_photos
        survey_dialogs = survey_commands.SurveyDialogs(
            self, studio, survey, dialogs, actions, open_model
        )
        return [
            *survey_commands.commands(
                studio, survey, survey_dialogs, open_model, self.files.choose_project_folder
            ),
            *result_commands.commands(studio, survey, self.cameras, dialogs, self),
            *photo_commands.commands(
                self.photo_opening, lambda: self.photos_panel.selected_photo()
            ),
            *self.photo_tab.commands(),
            *outcrop_photo_commands.commands(
                studio, self.photo_links, self._sightings, self._feature_photo, self.docks, self
            ),
        ]

    def _remaining_commands(self) -> list[Command]:
        from vomstudio.ui.commands import compaction as compact_commands
        from vomstudio.ui.commands import display as display_commands
        from vomstudio.ui.commands import features as feature_commands
        from vomstudio.ui.commands import help as help_commands
        from vomstudio.ui.commands import lines as line_commands
        from vomstudio.ui.commands import net as net_commands
        from vomstudio.ui.commands import orthophoto as ortho_commands
        from vomstudio.ui.commands import surfaces
        from vomstudio.ui.commands import types as type_commands
        from vomstudio.ui.panels import tools as tool_panels
        from vomstudio.ui.shell import tour
        from vomstudio.ui.shell.work_panels import work_commands

        studio, view = self.studio, self.view
        self._open_types = partial(feature_commands.open_types_dialog, self, studio, self._dialogs)
        return [
            *ortho_commands.commands(studio, view, self.view_panel, self),
            *work_commands(studio, self._dialogs, self.workspaces, self.docks, self),
            *line_commands.commands(studio, self.view_panel, self),
            *surfaces.commands(studio, self),
            *type_commands.commands(self._type_box),
            *(
                item
                for panel_commands in tool_panels.commands(studio).values()
                for item in panel_commands
            ),
            *net_commands.commands(
                studio,
                lambda: getattr(self, "net", None),
                self,
                self._dialogs,
                self.docks.toggle_center,
                partial(self.docks.bring_forward, "stereonet"),
            ),
            *feature_commands.commands(studio, self._open_types),
            *display_commands.commands(studio, view, self.cameras, self.docks),
            *compact_commands.commands(studio, self),
            *help_commands.commands(self.actions_table, self, self._dialogs, self),
            *tour.commands(studio, self.actions_table.all, view, self.docks, self),
        ]

    def _type_box(self) -> TypeBox | None:
        return self.tool_panel.type_box() if hasattr(self, "tool_panel") else None

    def _search_destinations(self) -> list[Destination]:
        """Return the pages and documents that can be found by the search."""
        from vomstudio.ui.commands.help import document_destinations
        from vomstudio.ui.dialogs.command_palette import Destination

        pages = [
            Destination(
                SearchEntry(f"page_{name}", tr("Page: {name}", name=dock.windowTitle())),
                partial(self.docks.bring_forward, name),
            )
            for name, dock in self.docks.items()
        ]
        return [*pages, *document_destinations(self._dialogs, self)]

    def _create_centre(self) -> None:
        from vomstudio.ui.shell.central_area import CentralArea
        from vomstudio.ui.shell.net_overlay import NetOverlay
        from vomstudio.ui.shell.start_page import StartPage
        from vomstudio.ui.shell.workspace_switching import WorkspaceSwitching
        from vomstudio.ui.widgets.messages_panel import MessageBar

        self.start_page = StartPage(self.studio, self.actions_table.all, self.open_path)
        self._place = CentralArea(self.start_page)
        self.message_bar = MessageBar(self._place.available_area)
        self._place.set_message_bar(self.message_bar)
        self.net_overlay = NetOverlay(self._place.available_area, self.message_bar)
        self.net_overlay.restore(self._settings.window.get("net place", ""))
        # The start page is over the outcrop.
        self.net_overlay.cover(True)
        self.docks.set_hosts(self._place, self.net_overlay)
        self.photo_tab.join(self._place, self.actions_table.viewport_actions())
        self.setCentralWidget(self._place)
        self._workspace_switching = WorkspaceSwitching(
            self.studio, self.survey, self.docks, self.workspaces, self._place
        )
        self.files.choice_started.connect(self.prepare_for_models)
        self.files.opened.connect(self._workspace_switching.path_opened)
        self.files.opened.connect(self.photo_tab.show_outcrop)

    def _make_panels(self) -> None:
        from vomstudio.ui.base.command_targets import current_model
        from vomstudio.ui.panels import tools as tool_panels
        from vomstudio.ui.panels.active_tool_panel import ActiveToolPanel
        from vomstudio.ui.panels.display_panel import DisplayPanel
        from vomstudio.ui.panels.features.project_tree import ProjectTree
        from vomstudio.ui.panels.features.properties_panel import PropertiesPanel
        from vomstudio.ui.panels.features.record_menus import RecordMenus
        from vomstudio.ui.panels.features.table_panel import TablePanel
        from vomstudio.ui.panels.features.tree_photos import TreePhotos
        from vomstudio.ui.panels.in_photos.in_photos_panel import InPhotosPanel
        from vomstudio.ui.panels.photos.photos_panel import PhotosPanel
        from vomstudio.ui.shell.record_actions import record_actions
        from vomstudio.ui.widgets.messages_panel import MessagesPanel

        studio, actions = self.studio, self.actions_table.all
        photos = TreePhotos(
            studio,
            self.survey,
            self.photo_opening,
            actions,
            self._workspace_switching.photos_opened,
        )
        self._menus = RecordMenus(
            studio, self, partial(record_actions, self.actions_table), self._open_types
        )
        self.tree = ProjectTree(studio, self._menus, photos, actions["edit_feature"])
        self.tool_panel = ActiveToolPanel(studio, tool_panels.make_panels(studio, actions))
        self.display_panel = DisplayPanel(studio, actions, partial(current_model, studio))
        self.display_panel.set_clip_callback(actions["clipping_box"].trigger)
        keep_action = actions["keep_intersection"]
        self.properties = PropertiesPanel(studio, actions, keep_action)
        self.table = TablePanel(studio, actions["export_csv"], self._menus, actions["edit_feature"])
        self.photos_panel = PhotosPanel(self.survey, actions)
        photos.photo_selected.connect(self.photos_panel.select_photo)
        self.in_photos = InPhotosPanel(
            studio, self.photo_links, self._feature_photo, self._sightings, actions
        )
        self.messages = MessagesPanel()
        for view in (self.tree.tree, self.table.view):
            # Acts only if the view itself has the focus, because Delete deletes letters in an
            # editor.
            key = QShortcut(QKeySequence.StandardKey.Delete, view)
            key.setContext(Qt.ShortcutContext.WidgetShortcut)
            key.activated.connect(actions["delete"].trigger)

    def _fill_docks(self) -> None:
        from vomstudio.ui.panels.jobs_panel import JobsPanel
        from vomstudio.ui.shell.work_panels import PERMANENT_PAGES, work_panels

        # The net needs matplotlib, which is imported when the net is visible for the first time.
        self._net_placeholder = NetPlaceholder()
        self._net_placeholder.appeared.connect(self._import_net)
        add = self.docks.add
        add("project", tr("Project"), self.tree)
        add("tool", tr("Tool"), self.tool_panel, is_scrollable=True)
        add("stereonet", tr("Stereonet"), self._net_placeholder)
        add("view", tr("View direction"), self.view_panel, is_scrollable=True)
        add("display", tr("Display"), self.display_panel)
        add("properties", tr("Properties"), self.properties)
        add("table", tr("Orientations"), self.table)
        add("photos", tr("Photos"), self.photos_panel)
        add("in_photos", tr("In the photos"), self.in_photos)
        add("jobs", tr("Jobs"), JobsPanel(self.studio))
        add("messages", tr("Messages"), self.messages)
        for name, title, make in work_panels():
            factory = partial(make, self.studio, self.view)
            is_permanent = name in PERMANENT_PAGES
            self.docks.add_lazy_page(name, tr(title), factory, is_permanent=is_permanent)
        self.tool_panel.set_title_callback(self.docks["tool"].setWindowTitle)

    def _create_bars(self) -> None:
        from vomstudio.ui.shell.drawer_bar import DrawerBar
        from vomstudio.ui.shell.menus import fill_menus
        from vomstudio.ui.shell.notices import NoticePresenter
        from vomstudio.ui.shell.status_line import StatusLine
        from vomstudio.ui.shell.tool_rail import ToolRail
        from vomstudio.ui.shell.top_bar import TopBar

        actions, bar = self.actions_table.all, self.message_bar
        fill_menus(self, actions, self.files)
        self.top_bar = TopBar(self, actions)
        self.tool_rail = ToolRail(self.studio, actions, self.workspaces, self.docks)
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, self.tool_rail)
        self.drawer_bar = DrawerBar(self.docks, self.workspaces)
        self.addToolBar(Qt.ToolBarArea.BottomToolBarArea, self.drawer_bar)
        self.status_line = StatusLine(self.studio, actions["declare_frame"])
        self.setStatusBar(self.status_line)
        self._notices = NoticePresenter(self.messages, bar, self.status_line, actions, self.docks)

    def _connect_signals(self) -> None:
        studio = self.studio
        # First, so that nothing of the previous project remains while the next one is shown.
        studio.project_opened.connect(self.docks.renew_pages)
        studio.project_opened.connect(self._dialogs.close_project_dialogs)
        studio.page_requested.connect(self.docks.bring_forward)
        # Earlier, because the next project may already report something while it is opened.
        studio.workspace.projects.leaving.connect(self._notices.end_project)
        studio.notice.connect(self._notices.show)
        self.actions_table.refused.connect(studio.hint)
        studio.history_changed.connect(self._refresh)
        studio.selection_changed.connect(self._refresh)
        studio.project_opened.connect(self._refresh)
        studio.model_loaded.connect(self._refresh)
        studio.edited.connect(self._refresh)
        studio.settings_changed.connect(self.actions_table.refresh)
        # A notice may offer a command that has just become available.
        studio.notice.connect(lambda _: self.actions_table.refresh())
        studio.display.changed.connect(lambda what: self._refresh() if what != "box" else None)
        studio.active_tool_changed.connect(self._handle_tool_change)
        studio.tool_changed_signal.connect(self._refresh)
        studio.tool_changed_signal.connect(self.message_bar.hide_hint)
        # Creating a dialog is slow, so it is not done in the same event as all updates for a new
        # model.
        studio.frame_requested.connect(self.files.declare_frame, Qt.ConnectionType.QueuedConnection)
        studio.recovery_found.connect(
            lambda folders: self._notices.offer_recovery(folders, self.files.open_path)
        )
        studio.jobs_changed.connect(self._show_start_page)
        self.survey.changed.connect(self.actions_table.refresh)
        self.cameras.cameras_loaded.connect(self.actions_table.refresh)
        self.photos_panel.selection_changed.connect(self.cameras.highlight_cameras)
        self.workspaces.changed.connect(self.actions_table.refresh)
        self.photo_tab.changed.connect(self.actions_table.refresh)
        self.photo_tab.photo_hint_changed.connect(self.status_line.show_photo)

    # --- start -------------------------------------------------------------------------------
    def begin(self, paths: list[Path]) -> None:
        """Fill the window, which is already visible, and open the paths of the command line."""
        self._fill(has_paths=bool(paths))
        from vomstudio.rendering.qt.viewport import Viewport
        from vomstudio.ui.outcrop.outcrop_menu import OutcropMenu
        from vomstudio.ui.shell.keyboard_focus import KeyboardFocus
        from vomstudio.ui.shell.photo_tab import create_center_widget_getter

        self.viewport = viewport = Viewport(self, is_lazy=True)
        viewport.setMinimumSize(200, 150)
        self.actions_table.assign_viewport_keys(viewport)
        self._place.set_outcrop(viewport)
        self.start_page.setParent(viewport)
        self.start_page.place_over(viewport)
        self.view.attach_viewport(viewport)
        self._outcrop_menu = OutcropMenu(
            self.studio, viewport, self.view, self.actions_table.all, self._menus
        )
        self._connect_panels(viewport)
        self.view.direction_changed.connect(self.view_panel.show_direction)
        self.view.state_changed.connect(self.actions_table.refresh_camera)
        self.view.connect_camera()
        open_model = (self.studio.project_opened, self.studio.model_loaded, self.files.opened)
        center_widget = create_center_widget_getter(self.photo_tab, viewport)
        self._keyboard = KeyboardFocus(self, center_widget, *open_model)
        self.photo_tab.visible_page_changed.connect(self._keyboard.focus_new_center)
        viewport.setFocus()
        # Only the first window is frozen, because a window that is closed before the process
        # ends must be freed.
        self._is_first_window = thread_switching.is_unfrozen()
        if self._is_first_window:
            thread_switching.freeze_objects()
        for path in paths:
            self.open_path(path)
        # Imported in a thread after the first frame, because the library of the net takes a
        # second.
        viewport.first_frame.connect(self._imports.begin)
        self._refresh()
        if self._net_placeholder.isVisible():
            self._import_net()
        begin_deferred_work = partial(self._begin_deferred_work, tuple(paths))
        if self._is_drawing:
            self._imports.begun.connect(begin_deferred_work)
        else:
            FirstPaint(viewport, begin_deferred_work)

    def _begin_deferred_work(self, paths: tuple[Path, ...]) -> None:
        """Begin the work that can wait until after the first picture."""
        if not self.isVisible():
            return
        # Reads the journals of all abandoned projects.
        self.studio.offer_recovery(paths)
        warm_up.start_worker(self.studio)
        self._compilation_timer.start()

    def _compile_kernels(self) -> None:
        warm_up.compile_kernels(self.studio)

    def prepare_for_models(self) -> None:
        """Import libraries and create the scene while the user is choosing a model."""
        warm_up.import_libraries(self.studio)
        self._draw_outcrop()

    def _draw_outcrop(self) -> None:
        """Create the scene, then the net. An empty window needs neither of them."""
        if self.viewport is not None and not self._is_drawing:
            self._is_drawing = True
            self.viewport.begin_drawing()
            self._imports.start_deadline(_MAX_WAIT_MS)

    def _import_net(self) -> None:
        if self._place.shows_outcrop:
            self._draw_outcrop()
        elif self.viewport is not None:
            self._imports.begin()

    def _connect_panels(self, viewport: Viewport) -> None:
        self.cameras.camera_selected.connect(self.photos_panel.select_photo)
        self.photos_panel.opened.connect(self.photo_opening.open)
        self.workspaces.leaving.connect(viewport.moves.keep_camera)
        overlay = self.net_overlay
        overlay.center_requested.connect(lambda: self.docks.toggle_center("stereonet"))
        overlay.dock_requested.connect(self.actions_table.all["dock_net"].trigger)
        overlay.closed.connect(lambda: self.docks.close_page("stereonet"))
        overlay.placement_changed.connect(viewport.set_covered)
        self.docks.changed.connect(self._cover_net)
        self.docks.changed.connect(self.actions_table.refresh)
        self.photo_tab.visible_page_changed.connect(self._cover_net)
        self._place.page_close_requested.connect(
            lambda: self.docks.toggle_center(self.docks.center_page)
        )
        self._place.outcrop_requested.connect(self.photo_tab.show_outcrop)
        self.display_panel.watch(viewport, self.view.models_box)
        self.in_photos.watch(viewport)
        self.in_photos.list_changed.connect(self.actions_table.refresh)
        self._feature_photo.pointer.connect(self.status_line.show_pointer)
        self.actions_table.assign_viewport_keys(self._feature_photo.canvas)
        viewport.pointer.connect(self.status_line.show_pointer)

    def _add_stereonet(self) -> None:
        if not self._is_filled or not self.isVisible():
            return
        from vomstudio.ui.panels.net.stereonet_panel import StereonetPanel

        self.net = StereonetPanel(self.studio, self.actions_table.all)
        self.net.menu_requested.connect(lambda id_, at: self._menus.create_menu(id_).popup(at))
        self.docks.replace_page("stereonet", self.net)

    def _imports_done(self) -> None:
        # An open model may be freed before the program ends, so it must not be frozen.
        if self._is_filled and self._is_first_window and not self.studio.models:
            thread_switching.freeze_objects()

    # --- what comes in -----------------------------------------------------------------------
    def open_path(self, path: Path) -> None:
        """Open a model, a project or a folder of photos."""
        from vomstudio.ui.commands.survey import is_photo_folder

        if is_photo_folder(path):
            self._open_photos(path)
        else:
            self.files.open_path(path)

    def _open_photos(self, folder: Path) -> None:
        from vomstudio.ui.commands.survey import open_photos

        self._workspace_switching.photos_opened()
        open_photos(self.survey, self.docks, folder)
        if not self._place.shows_outcrop:
            self.photos_panel.table.setFocus()
        elif self.viewport is not None:
            self._keyboard.focus_outcrop()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        if dragged_files(event):
            event.acceptProposedAction()
            if self._is_filled:
                self.prepare_for_models()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        for path in dragged_files(event) if self._is_filled else ():
            self.open_path(path)
        event.acceptProposedAction()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        # An unfinished feature on the outcrop is not discarded from a photo, in which it is
        # invisible.
        has_outcrop_keys = self._is_filled and self.photo_tab.visible_page is None
        is_open = has_outcrop_keys and self.studio.open_tool is not None
        if event.key() == Qt.Key.Key_Escape and is_open:
            self.studio.cancel_tool()
        else:
            super().keyPressEvent(event)

    # --- state -------------------------------------------------------------------------------
    def _handle_tool_change(self, name: str) -> None:
        self._workspace_switching.show_tool_settings(has_panel=name in self.tool_panel.panels)
        self.view.apply_tool(name)
        self._refresh()

    def _cover_net(self) -> None:
        self.net_overlay.cover(not self._place.shows_outcrop or not self.start_page.isHidden())

    def _refresh(self, *_: object) -> None:
        self.actions_table.refresh()
        self.setWindowTitle(self.files.window_title())
        self._show_start_page()

    def _show_start_page(self) -> None:
        from vomstudio.project.records import Model

        studio = self.studio
        is_empty = not (studio.session.of(Model) or studio.jobs.visible() or self.survey.folder)
        self.start_page.setVisible(is_empty)
        self._cover_net()
        # The net of readings without a model can be exported while it is hidden.
        if not self._is_drawing and (not is_empty or studio.session.features()):
            self._draw_outcrop()

    # --- end ---------------------------------------------------------------------------------
    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        if not self._is_filled:
            return
        if not can_close(self, self, [self.photo_opening.may_close, self.files.ask_to_save]):
            event.ignore()
            return
        net = [self.net.close_thread] if hasattr(self, "net") else []
        close_all(
            self,
            self,
            [
                self._store_arrangement,
                self.view.save_camera,
                self._compilation_timer.stop,
                self._imports.stop,
                self.view.close,
                self._feature_photo.close,
                *net,
                self.studio.close,
            ],
        )
        event.accept()

    def _store_arrangement(self) -> None:
        self.workspaces.stop()
        self.studio.settings.window = {
            **self.workspaces.export_state(),
            "net place": self.net_overlay.state(),
        }
        self.studio.keep_settings()
