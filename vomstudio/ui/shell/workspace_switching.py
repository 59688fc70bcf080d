"""Switching of workspaces and pages according to the user's actions."""

from __future__ import annotations

from PySide6.QtCore import QObject
from PySide6.QtGui import QCursor

from vomstudio.core.words import tr
from vomstudio.project.records import Feature, Model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.shell.central_area import CentralArea
from vomstudio.ui.shell.docks import WindowDocks
from vomstudio.ui.shell.layout import INSPECTOR_TABS
from vomstudio.ui.shell.workspaces import Workspaces

_PHOTOS, _MODEL, _INTERPRET = "photos", "model", "interpret"
_FEATURES, _TOOL, _SELECTION = INSPECTOR_TABS


class WorkspaceSwitching(QObject):
    """Controller that shows the workspace and inspector page that match the user's action."""

    def __init__(
        self,
        studio: Studio,
        survey: PhotoSurvey,
        docks: WindowDocks,
        workspaces: Workspaces,
        area: CentralArea,
    ) -> None:
        super().__init__(area)
        self._studio, self._survey = studio, survey
        self._docks, self._workspaces, self._area = docks, workspaces, area
        self._has_model = self._has_feature = False
        self._is_picking = False
        survey.changed.connect(self.refresh)
        survey.model_created.connect(self.model_created)
        workspaces.changed.connect(self._workspace_changed)
        studio.project_opened.connect(self._project_opened)
        for signal in (studio.edited, studio.model_loaded):
            signal.connect(self._data_changed)
        studio.selection_changed.connect(self._selection_changed)
        studio.tool_changed_signal.connect(self._handle_tool_change)
        workspaces.settled.connect(lambda: studio.store_window(workspaces.export_state()))

    def _project_opened(self) -> None:
        """Show the outcrop, and close the drawer if the project is empty."""
        self._docks.restore_from_center()
        self._data_changed()
        if not self._has_model and self._survey.folder is None:
            self._docks.close_region("drawer")

    # --- what is opened ----------------------------------------------------------------------
    def photos_opened(self) -> None:
        """Show the page of photos after the user has opened a folder of photos."""
        self._workspaces.switch(_MODEL)
        if not self._has_model:
            self._docks.move_to_center(_PHOTOS)
        else:
            self._docks.bring_forward(_PHOTOS)

    def path_opened(self) -> None:
        """Show the outcrop after the user has opened a model or a project."""
        had_photos = self._area.shows_photo or self._docks.center_page == _PHOTOS
        self._docks.restore_from_center()
        if had_photos and self._workspaces.current_workspace.center:
            self._workspaces.switch(_INTERPRET)

    def model_created(self) -> None:
        """Show the model of a finished reconstruction, unless a photo is visible."""
        if self._area.shows_photo:
            return
        self._docks.restore_from_center()
        if self._workspaces.current_workspace.name == _MODEL:
            self._workspaces.switch(_INTERPRET)

    # --- inspector ---------------------------------------------------------------------------
    def show_tool_settings(self, *, has_panel: bool) -> None:
        """Show the settings of a selected tool, or leave the settings if it has no panel."""
        self._is_picking = has_panel
        if has_panel:
            self._docks.restore_from_center()
            self._docks.bring_forward(_TOOL)
        else:
            self._handle_tool_change()

    def _handle_tool_change(self) -> None:
        """Leave the settings of a tool once it has no unfinished feature."""
        is_idle = not self._is_picking and self._studio.open_tool is None
        if is_idle and self._docks.page("inspector") == _TOOL:
            self._show_selection()

    def _selection_changed(self, *_: object) -> None:
        if (
            self._is_picking
            or self._studio.open_tool is not None
            or self._docks.page("inspector") not in INSPECTOR_TABS
        ):
            return
        if not self._is_in_inspector():
            self._show_selection()

    def _show_selection(self) -> None:
        self._docks.bring_forward(_SELECTION if self._studio.selection.ids else _FEATURES)

    def _is_in_inspector(self) -> bool:
        """Return whether the inspector must not change: it is hidden or the user works in it."""
        name = self._docks.page("inspector")
        if not name:
            return True
        dock = self._docks[name]
        focus = dock.window().focusWidget()
        has_focus = focus is not None and dock.isAncestorOf(focus)
        return has_focus or dock.rect().contains(dock.mapFromGlobal(QCursor.pos()))

    # --- empty workspaces --------------------------------------------------------------------
    def _data_changed(self, *_: object) -> None:
        # There may be thousands of records; `any` stops at the first match.
        records = self._studio.records.values()
        self._has_model = any(isinstance(record, Model) for record in records)
        self._has_feature = any(isinstance(record, Feature) for record in records)
        self.refresh()

    def _workspace_changed(self, _: str) -> None:
        page = self._workspaces.current_workspace.center
        if page and not self._has_model and self._survey.folder is not None:
            self._docks.move_to_center(page)
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the purpose of the workspace if it is empty, otherwise hide it."""
        shown_workspace, has_photos = (
            self._workspaces.current_workspace,
            self._survey.folder is not None,
        )
        is_empty = not (
            self._has_model if shown_workspace.required_content == "model" else self._has_feature
        )
        if shown_workspace.center and has_photos:
            is_empty = False
        self._area.show_purpose(tr(shown_workspace.purpose) if is_empty else "")
