"""The main window: docks and menus only. What they do is in the studio and the panels."""

from __future__ import annotations

import base64
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QByteArray, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QShortcut,
)
from PySide6.QtWidgets import (
    QDockWidget,
    QLabel,
    QMainWindow,
    QMenu,
    QMessageBox,
    QSizePolicy,
    QToolBar,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio import __version__
from vomstudio.document.records import (
    FEATURES,
    Dimension,
    Lineation,
    Model,
    Patch,
    Record,
    Trace,
)
from vomstudio.io.settings import Settings
from vomstudio.ui import display_commands, interpreter, photo_commands, theme
from vomstudio.ui.actions import Actions
from vomstudio.ui.wording import drawn_points

if TYPE_CHECKING:
    from vomstudio.rendering.clipping import ClipBox
    from vomstudio.rendering.viewport import Viewport
    from vomstudio.ui.studio import Notice

_LAYOUT_VERSION = 4
_MENUS = (
    ("&File", ("new", "open", "choose_photos", "open_project", "*recent", "*discarded", "|",
               "save", "save_as", "|",
               "import_readings", "|", "export_csv", "export_gpkg", "export_shp", "export_dxf",
               "export_net", "|", "quit")),
    ("&Edit", ("undo", "redo", "|", "delete", "rename", "|", "select_all", "|", "find_command")),
    ("&View", ("home", "frame_selection", "orthographic", "|", "view_top", "view_north",
               "view_east", "view_south", "view_west", "view_bottom", "|", "*display",
               "clipping_box", "clipping_reset", "*planes", "*notation", "trackball", "|",
               "show_chosen", "hide_chosen", "show_only", "show_all", "|", "show_in_photos",
               "previous_photo", "next_photo", "fit_photo", "|", "only_outcrop", "*docks")),
    ("&Photos", ("plan_survey", "video_frames", "choose_photos", "open_photo", "|", "make_settings",
                 "make_model", "pause_model", "|", "show_alignment", "show_tie_points",
                 "open_report")),
    ("&Model", ("declare_frame", "locate", "open_cameras", "find_photos", "|", "copy_model",
                "export_model", "remove_model")),
    ("&Interpret", ("navigate", "trace", "patch", "line", "measure", "|", "finish", "cancel",
                    "continue_trace", "delete_vertex", "|", "continue_patch", "brush_removes",
                    "brush_smaller", "brush_larger", "|", "feature_types")),
    ("&Analyse", ("along_beta", "along_line", "face_plane", "|", "keep_intersection",
                  "intersection_of_sets", "|", "orthophoto", "|", "show_stereonet")),
    ("&Help", ("shortcuts", "save_report", "|", "about")),
)  # fmt: skip

# What everybody knows by its icon: so the bar has room at 1400 pixels.
_ICON_ONLY = ("save", "undo", "redo", "home", "frame_selection")


class MainWindow(QMainWindow):
    """Made in two steps: an empty frame that is on the screen at once, then `begin` fills it."""

    _net_imported = Signal()
    _all_imported = Signal()

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        interpreter.take_short_turns()
        self._settings = settings
        self._filled = False
        self._net_importer: threading.Thread | None = None
        self._net_imported.connect(self._bring_net, Qt.ConnectionType.QueuedConnection)
        self._all_imported.connect(self._be_ready, Qt.ConnectionType.QueuedConnection)
        self._put_away: QByteArray | None = None
        self.viewport: Viewport | None = None
        self.setWindowTitle("VOM Studio")
        self.setAcceptDrops(True)
        self.setDockNestingEnabled(True)
        self.resize(1400, 900)
        self._restore_geometry()
        starting = QLabel(self.tr("VOM Studio is starting…"))
        starting.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setCentralWidget(starting)

    def _fill(self) -> None:
        """Everything but the viewport and the net. What is imported here is not light."""
        from vomstudio.ui.camera_view import CameraView
        from vomstudio.ui.commands import commands
        from vomstudio.ui.files import Files
        from vomstudio.ui.photo_links import PhotoLinks
        from vomstudio.ui.photo_survey import PhotoSurvey
        from vomstudio.ui.studio import Studio

        self.studio = Studio(self._settings)
        self.files = Files(self, self.studio)
        self.survey = PhotoSurvey(self.studio)
        self.photo_links = PhotoLinks(self.studio)
        self.cameras = CameraView(self.studio, self.photo_links)
        self.actions_table = Actions(self)
        for command in commands(self):
            self.actions_table.add(command)
        self.studio.new_project()
        self._make_centre()
        self._make_docks()
        self._make_menus()
        self._make_toolbar()
        self._make_status()
        self._connect()
        # Docks that are tabbed before the window is shown leave a stray tab bar behind.
        docks = self._settings.window.get("docks")
        if docks is None or not self.restoreState(_bytes(docks), _LAYOUT_VERSION):
            self._arrange()
            QTimer.singleShot(0, self._default_sizes)
        else:
            # Sizes hold only once the viewport stands in the centre and has its place.
            QTimer.singleShot(0, lambda: self.restoreState(_bytes(docks), _LAYOUT_VERSION))
        self._filled = True
        self.studio.project_opened.emit()
        self.actions_table.refresh()

    @property
    def filled(self) -> bool:
        """Whether the studio and the panels are there."""
        return self._filled

    # --- parts -------------------------------------------------------------------------------
    def _make_centre(self) -> None:
        from vomstudio.ui.messages_panel import MessageBar
        from vomstudio.ui.start_page import StartPage

        self.start_page = StartPage(self.studio, self.actions_table.all)
        centre = QWidget()
        self._centre = QVBoxLayout(centre)
        self._centre.setContentsMargins(0, 0, 0, 0)
        self._centre.setSpacing(0)
        self._centre.addWidget(self.start_page, 1)
        self.message_bar = MessageBar(centre)
        self.setCentralWidget(centre)

    def _make_docks(self) -> None:
        from vomstudio.ui.display_panel import DisplayPanel
        from vomstudio.ui.feature_commands import open_types
        from vomstudio.ui.in_photos_panel import InPhotosPanel
        from vomstudio.ui.jobs_panel import JobsPanel
        from vomstudio.ui.line_panel import LinePanel
        from vomstudio.ui.measure_panel import MeasurePanel
        from vomstudio.ui.messages_panel import MessagesPanel
        from vomstudio.ui.patch_panel import PatchPanel
        from vomstudio.ui.photos_panel import PhotosPanel
        from vomstudio.ui.project_tree import ProjectTree
        from vomstudio.ui.properties_panel import PropertiesPanel
        from vomstudio.ui.table_panel import TablePanel
        from vomstudio.ui.trace_panel import TracePanel
        from vomstudio.ui.view_panel import ViewPanel

        actions = self.actions_table.all
        self.docks: dict[str, QDockWidget] = {}
        self.tree = ProjectTree(
            self.studio, self._record_actions, lambda type_id: open_types(self, type_id)
        )
        self.trace_panel = TracePanel(self.studio, actions)
        self.patch_panel = PatchPanel(self.studio, actions)
        self.line_panel = LinePanel(self.studio, actions)
        self.measure_panel = MeasurePanel(self.studio, actions)
        self.view_panel = ViewPanel(self.studio, self.look)
        self.display_panel = DisplayPanel(self.studio, actions, self.files.current_model)
        self.display_panel.on_clip_toggled(actions["clipping_box"].trigger)
        self.properties = PropertiesPanel(
            self.studio, actions["declare_frame"], actions["keep_intersection"]
        )
        self.table = TablePanel(self.studio, actions["export_csv"])
        self.photos_panel = PhotosPanel(self.survey, actions)
        self.in_photos = InPhotosPanel(self.studio, self.photo_links, actions)
        self.messages = MessagesPanel()
        for view in (self.tree.tree, self.table.view):
            # Only with the focus on the view itself: in an editor Delete deletes letters.
            key = QShortcut(QKeySequence.StandardKey.Delete, view)
            key.setContext(Qt.ShortcutContext.WidgetShortcut)
            key.activated.connect(actions["delete"].trigger)
        # The net needs matplotlib: its place is kept until the window is on the screen.
        self._net_place = QWidget()
        left, right = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
        bottom = Qt.DockWidgetArea.BottomDockWidgetArea
        self.setCorner(Qt.Corner.BottomLeftCorner, left)
        self.setCorner(Qt.Corner.BottomRightCorner, right)
        self._dock("project", self.tr("Project"), self.tree, left)
        self._dock("trace", self.tr("Trace"), self.trace_panel, left)
        self._dock("patch", self.tr("Patch"), self.patch_panel, left)
        self._dock("line", self.tr("Line"), self.line_panel, left)
        self._dock("measure", self.tr("Measure"), self.measure_panel, left)
        self._dock("stereonet", self.tr("Stereonet"), self._net_place, right)
        self._dock("view", self.tr("View direction"), self.view_panel, right)
        self._dock("display", self.tr("Display"), self.display_panel, right)
        self._dock("properties", self.tr("Properties"), self.properties, right)
        self._dock("table", self.tr("Orientations"), self.table, bottom)
        self._dock("photos", self.tr("Photos"), self.photos_panel, bottom)
        self._dock("in_photos", self.tr("In the photos"), self.in_photos, bottom)
        self._dock("jobs", self.tr("Jobs"), JobsPanel(self.studio.jobs), bottom)
        self._dock("messages", self.tr("Messages"), self.messages, bottom)

    def _dock(self, name: str, title: str, widget: QWidget, area: Qt.DockWidgetArea) -> None:
        dock = QDockWidget(title, self)
        dock.setObjectName(name)
        dock.setWidget(widget)
        self.addDockWidget(area, dock)
        self.docks[name] = dock

    def _arrange(self) -> None:
        docks = self.docks
        self.tabifyDockWidget(docks["stereonet"], docks["view"])
        self.tabifyDockWidget(docks["view"], docks["display"])
        self.tabifyDockWidget(docks["table"], docks["photos"])
        self.tabifyDockWidget(docks["photos"], docks["in_photos"])
        self.tabifyDockWidget(docks["in_photos"], docks["jobs"])
        self.tabifyDockWidget(docks["jobs"], docks["messages"])
        for tool in ("patch", "line", "measure"):
            self.tabifyDockWidget(docks["trace"], docks[tool])
        docks["trace"].raise_()
        docks["stereonet"].raise_()
        docks["table"].raise_()

    def _default_sizes(self) -> None:
        docks, wide, high = self.docks, Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        self.resizeDocks([docks["project"], docks["stereonet"]], [288, 326], wide)
        self.resizeDocks([docks["project"], docks["trace"]], [300, 500], high)
        self.resizeDocks([docks["stereonet"], docks["properties"]], [400, 400], high)
        self.resizeDocks([docks["table"]], [190], high)

    def _make_menus(self) -> None:
        for title, names in _MENUS:
            menu = self.menuBar().addMenu(self.tr(title))
            menu.setToolTipsVisible(True)
            for name in names:
                if name == "|":
                    menu.addSeparator()
                elif name.startswith("*"):
                    self._submenu(menu, name[1:])
                else:
                    menu.addAction(self.actions_table.all[name])

    def _submenu(self, menu: QMenu, name: str) -> None:
        if name == "recent":
            recent = menu.addMenu(self.tr("Open &recent"))
            recent.aboutToShow.connect(lambda: self.files.fill_recent(recent))
        elif name == "discarded":
            discarded = menu.addMenu(self.tr("&Bring back discarded work"))
            discarded.aboutToShow.connect(lambda: self.files.fill_discarded(discarded))
        elif name == "display":
            display = menu.addMenu(self.tr("&Display"))
            display_commands.fill_menu(self, display)
        elif name == "planes":
            planes = menu.addMenu(self.tr("&Planes as"))
            planes.setToolTipsVisible(True)
            for each in ("planes_discs", "planes_symbols", "planes_neither"):
                planes.addAction(self.actions_table.all[each])
        elif name == "notation":
            notation = menu.addMenu(self.tr("&Notation"))
            for each in ("notation_dipdir", "notation_strike", "notation_quadrant"):
                notation.addAction(self.actions_table.all[each])
        else:
            docks = menu.addMenu(self.tr("&Panels"))
            for dock in self.docks.values():
                docks.addAction(dock.toggleViewAction())

    def _make_toolbar(self) -> None:
        bar = QToolBar(self.tr("Tools"))
        bar.setObjectName("toolbar")
        bar.setMovable(False)
        names = ("open", "save", "|", "navigate", "trace", "patch", "line", "measure", "|",
                 "undo", "redo", "|", "home", "frame_selection",
                 "orthographic", "*views")  # fmt: skip
        for name in names:
            if name == "|":
                bar.addSeparator()
            elif name == "*views":
                button = QToolButton()
                button.setText(self.tr("Views"))
                button.setIcon(theme.icon("compass-outline"))
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
                button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
                menu = QMenu(button)
                for each in ("top", "north", "east", "south", "west", "bottom"):
                    menu.addAction(self.actions_table.all[f"view_{each}"])
                button.setMenu(menu)
                bar.addWidget(button)
            else:
                bar.addAction(self.actions_table.all[name])
                widget = bar.widgetForAction(self.actions_table.all[name])
                if isinstance(widget, QToolButton) and name not in _ICON_ONLY:
                    widget.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        space = QWidget()
        space.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        bar.addWidget(space)
        find = QToolButton()
        find.setIcon(theme.icon("magnify"))
        find.setText(self.tr("Find a command  Ctrl+K"))
        find.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        find.clicked.connect(self.actions_table.all["find_command"].trigger)
        bar.addWidget(find)
        self.addToolBar(bar)

    def _make_status(self) -> None:
        from vomstudio.ui.status_line import StatusLine

        self.status_line = StatusLine(self.studio, self.actions_table.all["declare_frame"])
        self.setStatusBar(self.status_line)

    def _connect(self) -> None:
        studio = self.studio
        studio.notice.connect(self._notice)
        studio.history_changed.connect(self._refresh)
        studio.selection_changed.connect(self._refresh)
        studio.project_opened.connect(self._refresh)
        studio.model_loaded.connect(self._refresh)
        studio.edited.connect(self._refresh)
        studio.display.changed.connect(lambda what: self._refresh() if what != "box" else None)
        studio.active_tool_changed.connect(self._tool_changed)
        studio.tool_changed_signal.connect(self._refresh)
        studio.tool_changed_signal.connect(self.message_bar.end_hint)
        # A dialog takes long to make: not in the same event as all that a new model brings about.
        studio.frame_wanted.connect(self.files.declare_frame, Qt.ConnectionType.QueuedConnection)
        studio.recovery_found.connect(self.files.offer_recovery)
        studio.jobs.changed.connect(self._show_start_page)
        self.survey.changed.connect(self.actions_table.refresh)
        self.cameras.found.connect(self.actions_table.refresh)
        self.photos_panel.chosen.connect(self.cameras.choose)

    # --- birth -------------------------------------------------------------------------------
    def begin(self, paths: list[Path]) -> None:
        """The window is on the screen: fill it, then open the paths of the command line."""
        self._fill()
        from vomstudio.rendering.viewport import Viewport
        from vomstudio.ui.scene_presenter import ScenePresenter

        self.viewport = viewport = Viewport(self)
        viewport.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        viewport.setMinimumSize(200, 150)
        self.actions_table.give_keys_to(viewport)
        self._centre.replaceWidget(self.start_page, viewport)
        self.start_page.setParent(viewport)
        self.start_page.place_over(viewport)
        self._presenter = ScenePresenter(self.studio, viewport)
        self._presenter.rebuild()
        self.cameras.watch(viewport)
        self.cameras.chosen.connect(self.photos_panel.choose)
        self.photos_panel.opened.connect(lambda name: photo_commands.open_photo(self, name))
        self.display_panel.watch(viewport)
        self.in_photos.watch(viewport)
        self.in_photos.listed.connect(self.actions_table.refresh)
        self.in_photos.pointer.connect(self.status_line.show_pointer)
        self.actions_table.give_keys_to(self.in_photos.canvas)
        viewport.pointer.connect(self.status_line.show_pointer)
        viewport.camera_changed.connect(self._camera_changed)
        viewport.problem.connect(lambda text: self.studio.warn(text))
        viewport.point_budget = self._settings.point_budget
        viewport.gestures.set_turntable(self._settings.turntable)
        viewport.setFocus()
        # A window that is closed before the process ends is not to stay for ever.
        self._first = interpreter.spares_nothing()
        if self._first:
            interpreter.spare_what_is_there()
        self._camera_timer = QTimer(self)
        self._camera_timer.setSingleShot(True)
        self._camera_timer.setInterval(500)
        self._camera_timer.timeout.connect(self._keep_camera)
        self._camera_changed()
        for path in paths:
            self.open_path(path)
        self.studio.offer_recovery()
        # The net's library takes a second to import: after the first frame, and in a thread. A
        # viewport that cannot draw must not keep the net away.
        viewport.first_frame.connect(self._import_net)
        self._net_timer = QTimer(self)
        self._net_timer.setSingleShot(True)
        self._net_timer.timeout.connect(self._import_net)
        self._net_timer.start(5000)
        self._refresh()

    def _import_net(self) -> None:
        if self._net_importer is not None:
            return

        def work() -> None:
            import vomstudio.ui.stereonet_panel  # noqa: F401

            self._net_imported.emit()
            # Wanted as soon as a model is there, when its picture is wanted as well.
            import scipy.sparse.csgraph
            import scipy.spatial  # noqa: F401

            self._all_imported.emit()

        self._net_importer = threading.Thread(target=work, name="net import", daemon=True)
        self._net_importer.start()

    def _bring_net(self) -> None:
        if not self._filled or not self.isVisible():
            return
        from vomstudio.ui.stereonet_panel import StereonetPanel

        self.net = StereonetPanel(self.studio, self.actions_table.all["export_net"])
        self.docks["stereonet"].setWidget(self.net)
        self._net_place.deleteLater()
        # Each lane's worker gets ready for what it will be asked; photos come last.
        for lane, task in (("models", "warm"), ("photos", "compile_kernels")):
            self.studio.jobs.submit(
                lane,
                task,
                {},
                title="Getting ready",
                on_done=lambda _: None,
                on_failed=lambda _: None,
                quiet=True,
            )

    def _be_ready(self) -> None:
        # Nor is a model.
        if self._filled and self._first and not self.studio.models:
            interpreter.spare_what_is_there()

    # --- files -------------------------------------------------------------------------------
    def open_path(self, path: Path) -> None:
        """A model, a project, or a folder of photos."""
        from vomstudio.ui.survey_commands import is_photo_folder, open_photos

        if is_photo_folder(path):
            open_photos(self, path)
        else:
            self.files.open_path(path)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:  # noqa: N802
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:  # noqa: N802
        for url in event.mimeData().urls():
            if url.isLocalFile() and self._filled:
                self.open_path(Path(url.toLocalFile()))
        event.acceptProposedAction()

    def _record_actions(self, record: Record) -> list[QAction]:
        table = self.actions_table
        table.refresh()
        common = ("show_chosen", "hide_chosen", "show_only", "rename", "delete")
        names = (
            ("declare_frame", "locate", "copy_model", "remove_model")
            if isinstance(record, Model)
            else ("frame_selection", "continue_trace", "face_plane", *common)
            if isinstance(record, Trace | Lineation | Dimension)
            else ("frame_selection", "continue_patch", "face_plane", *common)
            if isinstance(record, Patch)
            else ("frame_selection", "along_line", "face_plane", *common)
            if isinstance(record, FEATURES)
            else ()
        )
        return [table.all[name] for name in names]

    # --- view --------------------------------------------------------------------------------
    def look(self, trend_deg: float, plunge_deg: float) -> None:
        if self.viewport is not None:
            self.viewport.set_orthographic(True)
            self.viewport.look_along(trend_deg, plunge_deg)

    def see_all(self) -> None:
        self._presenter.see_all(self.cameras.corners())

    def show_dock(self, name: str) -> None:
        self.docks[name].show()
        self.docks[name].raise_()

    def models_box(self) -> ClipBox | None:
        """Around all visible models."""
        return self._presenter.models_box()

    def clip_holds_something(self) -> bool:
        """Whether the clipping box has a part of the visible models in it."""
        box, around = self.studio.display.box, self.models_box()
        return box is not None and around is not None and box.meets(around)

    def frame_selection(self) -> None:
        import numpy as np

        measured = self.studio.measured(self.studio.selection.ids).values()
        points = [drawn_points(m) for m in measured]
        points = [p for p in points if len(p)]
        if self.viewport is not None and points:
            self.viewport.frame(np.concatenate(points))

    def show_only_outcrop(self) -> None:
        """Hide every panel, or bring back those that were there."""
        if self._put_away is not None:
            # Shown one by one they would share the room anew.
            self.restoreState(self._put_away, _LAYOUT_VERSION)
            self._put_away = None
        else:
            self._put_away = self.saveState(_LAYOUT_VERSION)
            for dock in self.docks.values():
                dock.hide()

    def _camera_changed(self) -> None:
        if self.viewport is not None:
            trend, plunge = self.viewport.view_direction()
            self.view_panel.show_direction(trend, plunge, self.viewport.orthographic)
            self._camera_timer.start()
            self.actions_table.refresh()

    def _keep_camera(self) -> None:
        # Before a model is there the camera looks at nothing: no better than the one that is kept.
        if self.viewport is not None and self.studio.models:
            self.studio.project.journal.set_view("camera", self.viewport.camera_state())

    # --- state -------------------------------------------------------------------------------
    def _notice(self, notice: Notice) -> None:
        self.messages.add(notice)
        if notice.level == "info":
            self.status_line.showMessage(notice.text, 6000)
        elif notice.action:
            action = self.actions_table.all[notice.action]
            self.message_bar.say(notice, (action.text().replace("&", ""), action.trigger))
        else:
            self.message_bar.say(notice)

    def _tool_changed(self, name: str) -> None:
        if name in self.docks:
            self.docks[name].show()
            self.docks[name].raise_()
        if self.viewport is not None:
            picking = name in self.studio.tools
            cursor = Qt.CursorShape.CrossCursor if picking else Qt.CursorShape.ArrowCursor
            self.viewport.setCursor(cursor)
            # A brush paints with the left button.
            self.viewport.gestures.orbit_button = (
                Qt.MouseButton.RightButton if name == "patch" else Qt.MouseButton.LeftButton
            )
        self._refresh()

    def _refresh(self, *_: object) -> None:
        studio = self.studio
        self.actions_table.refresh()
        star = "*" if studio.session.dirty else ""
        self.setWindowTitle(f"{self.files.project_name()}{star} – VOM Studio")
        self._show_start_page()

    def _show_start_page(self) -> None:
        empty = not (
            self.studio.session.of(Model) or self.studio.jobs.visible() or self.survey.folder
        )
        self.start_page.setVisible(empty)

    # --- keys, layout, end -------------------------------------------------------------------
    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        if event.key() == Qt.Key.Key_Escape and self._filled and self.studio.open_tool is not None:
            self.studio.cancel_tool()
            return
        super().keyPressEvent(event)

    def _restore_geometry(self) -> None:
        kept = self._settings.window
        if "geometry" in kept:
            self.restoreGeometry(_bytes(kept["geometry"]))
            # A screen that is gone must not take the window with it.
            if not any(
                screen.geometry().intersects(self.frameGeometry())
                for screen in QGuiApplication.screens()
            ):
                self.move(40, 40)

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802
        if not self._filled:
            event.accept()
            return
        if not photo_commands.may_close(self) or not self.files.ask_to_keep():
            event.ignore()
            return
        docks = self._put_away or self.saveState(_LAYOUT_VERSION)
        self.studio.settings.window = {
            "geometry": _text(self.saveGeometry()),
            "docks": _text(docks),
        }
        self.studio.keep_settings()
        self._keep_camera()
        if self.viewport is not None:
            self._net_timer.stop()
            self.viewport.close()
        self.in_photos.close_threads()
        self.studio.close()
        event.accept()

    def about(self) -> None:
        QMessageBox.about(
            self,
            "VOM Studio",
            f"<b>VOM Studio {__version__}</b><br>Virtual outcrop models of geological structures: "
            "measurements with their errors.<br>BSD-3-Clause.",
        )


def _text(data: QByteArray) -> str:
    return base64.b64encode(data.data()).decode("ascii")


def _bytes(text: str) -> QByteArray:
    return QByteArray(base64.b64decode(text))
