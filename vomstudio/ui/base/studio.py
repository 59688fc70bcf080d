"""Workspace for the window, with Qt signals and short names for its parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from vomstudio.io.settings import Settings
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Record
from vomstudio.project.session import Session
from vomstudio.studio.notices import Notice
from vomstudio.studio.tools.tool_context import Tool
from vomstudio.studio.workspace import Workspace
from vomstudio.ui.base.qt_owner import QtOwner

__all__ = ["Notice", "Studio"]


class Studio(QObject):
    """Workspace as used by widgets.

    Widgets connect to these signals, not to a session, because the project may change.
    """

    project_opened = Signal()
    edited = Signal(object)  # Edit
    history_changed = Signal()
    selection_changed = Signal(object)  # tuple of ids
    model_loaded = Signal(str)
    frame_requested = Signal(str)
    next_type_changed = Signal()
    tool_changed_signal = Signal()
    active_tool_changed = Signal(str)
    preview = Signal(object)  # Preview | None
    sets_requested = Signal()
    """Emitted to request a proposal of sets."""
    sets_proposed = Signal(object)
    """Emits the names of proposed sets with the ids of their planes for a preview; None ends the
    preview."""
    planes_proposed = Signal(str, object)
    """Emits the name of a panel with its ProposedPlanes, which the net shows; None hides them."""
    proposals_picked = Signal(object, bool)
    """Emits the ids of proposals that were picked on the net, and whether they are added to the
    selection."""
    page_requested = Signal(str)
    """Emitted with the name of a page that is to be shown."""
    surface_page_requested = Signal(str)
    """Emitted to request a page of the surface dock: "fields", "facets" or "traces"."""
    extension_shown = Signal(object)
    """Emits the ExtendedLines of an extended plane, or None to remove them."""
    surface_clicked = Signal(object)
    """Emits the hit of a click on the outcrop that selects no feature while no tool is active."""
    notice = Signal(object)  # Notice
    settings_changed = Signal()
    """Emitted when settings change, except for the list of recent projects."""
    recent_changed = Signal()
    visibility_changed = Signal(object)  # tuple of ids
    hidden_elements_changed = Signal(str)
    """Emits the id of a model whose hidden faces or points have changed."""
    layers_written = Signal(str)
    recovery_found = Signal(object)  # list of folders
    jobs_changed = Signal()

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        owner = QtOwner(self)
        self.workspace = Workspace(settings, owner.post, owner.later, owner.run_and_wait)
        self.settings = settings
        # Widgets with a filter, and functions that return the features hidden by it.
        self.filters: list[tuple[QWidget, Callable[[Iterable[str]], set[str]]]] = []
        self.results_folder: Path | None = None
        """Folder of the result that was written last in the project."""
        self._bind_methods()
        self._connect_signals()
        self.workspace.projects.leaving.connect(self._forget_results_folder)

    def _bind_methods(self) -> None:
        """Bind the methods of the workspace that widgets use."""
        w = self.workspace
        self.jobs, self.loader, self.selection = w.jobs, w.loader, w.selection
        self.display, self.photo_links = w.display, w.photos
        self.fields, self.facets = w.fields, w.facets
        self.proposed_traces, self.fold = w.proposed_traces, w.fold
        self.models, self.tools = w.models.open_models, w.tools.tools
        self.get_tool = w.tools.of

        self.new_project, self.open_project = w.projects.new, w.projects.open
        self.save, self.save_as, self.discard = w.projects.save, w.projects.save_as, w.discard
        self.offer_recovery, self.close = w.offer_recovery, w.close
        self.remember, self.keep_settings = w.preferences.remember, w.preferences.keep
        self.store_window = w.preferences.store_window

        self.apply, self.attempt = w.editing.apply, w.editing.attempt
        self.undo, self.redo = w.history.undo, w.history.redo
        self.undo_edit, self.redo_edit = w.history.undo_edit, w.history.redo_edit
        self.delete_selected = w.delete_selected

        self.open_path, self.open_model = w.models.open_path, w.models.open_model
        self.locate_model, self.copy_model = w.models.locate, w.models.copy

        self.visible, self.set_visible = w.visibility.visible, w.visibility.set_visible
        self.show_only, self.show_all = w.visibility.show_only, w.visibility.show_all

        self.measured, self.measure = w.derived.measured, w.derived.measure
        self.affected_ids, self.subject = w.derived.affected_ids, w.derived.subject
        self.nearest_pick = w.derived.nearest_pick
        self.is_north_known, self.are_metres_known = (
            w.derived.is_north_known,
            w.derived.are_metres_known,
        )
        self.turn_findings = w.derived.turn_findings
        self.crs_codes = w.derived.crs_codes
        self.frame_name, self.write_layers = w.derived.frame_name, w.layers.write

        self.activate, self.pointer, self.set_next_type = (
            w.tools.activate,
            w.tools.pointer,
            w.tools.set_next_type,
        )
        self.finish_tool, self.cancel_tool = w.tools.finish, w.tools.cancel
        self.undo_click = w.tools.undo_click
        self.surface, self.format_attitude = w.tools.surface, w.tools.format_attitude
        self.tool_changed = w.tools.tool_changed

        self.info, self.warn = w.notices.info, w.notices.warn
        self.hint, self.fail = w.notices.hint, w.notices.fail
        self.written = w.notices.written

    def _connect_signals(self) -> None:
        w = self.workspace
        w.project_opened.connect(self.project_opened.emit)
        w.edited.connect(self.edited.emit)
        w.history_changed.connect(self.history_changed.emit)
        w.recovery_found.connect(self.recovery_found.emit)
        w.selection.changed.connect(self.selection_changed.emit)
        w.models.loaded.connect(self.model_loaded.emit)
        w.models.frame_needed.connect(self.frame_requested.emit)
        w.tools.next_type_changed.connect(self.next_type_changed.emit)
        w.tools.changed.connect(self.tool_changed_signal.emit)
        w.tools.active_changed.connect(self.active_tool_changed.emit)
        w.tools.preview.connect(self.preview.emit)
        w.notices.posted.connect(self.notice.emit)
        w.preferences.changed.connect(self.settings_changed.emit)
        w.preferences.recent_changed.connect(self.recent_changed.emit)
        w.visibility.changed.connect(self.visibility_changed.emit)
        w.elements.hidden_changed.connect(self.hidden_elements_changed.emit)
        w.layers.written.connect(self.layers_written.emit)
        w.jobs.changed.connect(self.jobs_changed.emit)

    def _forget_results_folder(self) -> None:
        self.results_folder = None

    # --- state of the current project and tool -----------------------------------------------
    @property
    def has_project(self) -> bool:
        return self.workspace.projects.is_open

    @property
    def project(self) -> ProjectFolder:
        return self.workspace.projects.project

    @property
    def session(self) -> Session:
        return self.workspace.projects.session

    @property
    def records(self) -> Mapping[str, Record]:
        return self.workspace.projects.records

    @property
    def measurements(self) -> Measurements:
        return self.workspace.derived.measurements

    @property
    def hidden(self) -> set[str]:
        return self.workspace.visibility.hidden

    @property
    def has_work_to_save(self) -> bool:
        return self.workspace.has_work_to_save

    @property
    def tool_name(self) -> str:
        return self.workspace.tools.active_name

    @property
    def tool(self) -> Tool | None:
        """Active tool, or None while navigating."""
        return self.workspace.tools.active

    @property
    def can_select_by_click(self) -> bool:
        """Whether a click on the outcrop selects the feature under the cursor."""
        return self.workspace.tools.can_select_by_click

    @property
    def open_tool(self) -> Tool | None:
        """Tool with an unfinished feature, or None if no feature is open."""
        return self.workspace.tools.open_tool

    @property
    def undo_label(self) -> str | None:
        """Label of the step that undo would revert, including steps of an open feature."""
        return self.workspace.history.undo_label

    @property
    def redo_label(self) -> str | None:
        return self.workspace.history.redo_label

    @property
    def next_type_id(self) -> str:
        return self.workspace.tools.next_type_id

    @property
    def next_set(self) -> str:
        return self.workspace.tools.next_set
