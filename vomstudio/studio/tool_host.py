"""Host of the tools, which switches between them and stores or discards the open feature."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal, group_notifications
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.project.kinds import visibility_group
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import Feature, FeatureType, Model, get
from vomstudio.project.selection import Selection
from vomstudio.project.session import Session
from vomstudio.studio.background import Background
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.models import Models
from vomstudio.studio.notices import Notices
from vomstudio.studio.path_finding import PathFinding
from vomstudio.studio.preferences import Preferences
from vomstudio.studio.projects import Projects
from vomstudio.studio.surfaces.outcrop_elements import ModelElements
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.element_tool import ElementTool
from vomstudio.studio.tools.interaction_types import (
    Button,
    DiscardedFeature,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.studio.tools.set_memory import SetMemory
from vomstudio.studio.tools.tool_context import Tool
from vomstudio.studio.visibility import Visibility

T = TypeVar("T")

NAVIGATE = "navigate"
"""Name of the state in which no tool is active."""


class ToolHost:
    """Host of the tools, which also implements their `ToolContext`.

    Attributes
    ----------
    changed : Signal
        Emitted when the state of a tool changes.
    undo_changed : Signal
        Emitted after `changed`, because undo may refer to a step of a tool.
    active_changed : Signal
        Emitted when another tool becomes active.
    next_type_changed : Signal
        Emitted when the feature type or the set of the next feature changes.
    preview : Preview or None
        Preview of the unfinished feature.
    feature_discarded : Signal
        Emits unfinished work that was discarded.
    """

    def __init__(
        self,
        projects: Projects,
        models: Models,
        derived: DerivedQuantities,
        selection: Selection,
        preferences: Preferences,
        notices: Notices,
        paths: PathFinding,
        elements: ModelElements,
        background: Background,
        visibility: Visibility,
        post: Callable[[Callable[[], None]], None],
    ) -> None:
        self.changed: Signal[()] = Signal()
        self.undo_changed: Signal[()] = Signal()
        self.active_changed: Signal[str] = Signal()
        self.next_type_changed: Signal[()] = Signal()
        self.preview: Signal[Preview | None] = Signal()
        self.feature_discarded: Signal[DiscardedFeature] = Signal()
        self._projects, self._models, self._derived = projects, models, derived
        self._selection, self._preferences, self._notices = selection, preferences, notices
        self.paths, self.elements, self._background = paths, elements, background
        self._visibility, self._post = visibility, post
        self._queued_events: list[PointerEvent | None] = []
        self._tool_preview: Preview | None = None
        self.active_name = NAVIGATE
        self.next_type_id = "bedding"
        self.next_set = ""
        self._sets = SetMemory()
        self._next_types_by_tool: dict[str, tuple[str, str]] = {}
        self.tools: dict[str, Tool] = {entry.name: entry.tool(self) for entry in TOOLS}

    def of(self, record_type: type[T]) -> T:
        """Return the tool that is an instance of a class."""
        return next(tool for tool in self.tools.values() if isinstance(tool, record_type))

    # --- active tool --------------------------------------------------------------------------
    def activate(self, name: str) -> None:
        """Activate a tool; NAVIGATE deactivates all.

        The open feature of another tool is finished if it is complete, and otherwise discarded,
        which can be undone. It stays open while navigating. Pending clicks for another tool are
        discarded.
        """
        if name == self.active_name:
            return
        self._drop_waiting_clicks()
        if (previous := self.active) is not None:
            previous.leave()
        open_tool = self.open_tool
        if open_tool is not None and self.tools.get(name) is not open_tool:
            if name == NAVIGATE and open_tool.is_finishing:
                pass
            elif name == NAVIGATE:
                self._notices.info(Finding("tool.draft-kept"))
            elif not self._close(open_tool):
                self.hint(Finding("feature.open"))
                self.active_changed.emit(self.active_name)
                return
        self._next_types_by_tool[self.active_name] = (self.next_type_id, self.next_set)
        self.active_name = name
        self.active_changed.emit(name)
        # Each tool has its own type and set, because beds may be traced while joints are
        # painted.
        type_and_set = self._next_types_by_tool.get(name)
        is_free = self.open_tool is None or self.open_tool.is_finishing
        if name != NAVIGATE and is_free and type_and_set is not None:
            self.next_type_id, self.next_set = type_and_set
            self.keep_next_type()
            self.next_type_changed.emit()

    def _close_busy_tool(self, tool: Tool) -> bool:
        """Finish or discard the open feature of a tool. Return False while it is being finished."""
        return not tool.is_finishing and self._close(tool) and not tool.is_open

    def _close(self, tool: Tool) -> bool:
        """Finish the open feature of a tool, or discard it. Return whether this was possible."""
        if not tool.is_finishing and tool.finish_problem() is None:
            tool.finish()
        if tool.is_open and not tool.is_finishing:
            tool.cancel()
            if not tool.is_open:
                self._notices.info(Finding("tool.discarded"))
        return tool.is_finishing or not tool.is_open

    @property
    def active(self) -> Tool | None:
        """Active tool, or None while navigating."""
        return self.tools.get(self.active_name)

    @property
    def can_select_by_click(self) -> bool:
        """Whether clicks select features: while navigating, or if a tool requests a feature."""
        return self.active is None or bool(getattr(self.active, "selects_feature", False))

    @property
    def open_tool(self) -> Tool | None:
        """Tool with an unfinished feature, or None if no tool has one."""
        return next((tool for tool in self.tools.values() if tool.is_open), None)

    def finish(self) -> None:
        """Finish the open feature, or else the current action of the active tool."""
        if self._queued_events:
            self._queued_events.append(None)
        elif (tool := self.open_tool or self.active) is not None:
            tool.finish()

    def cancel(self) -> None:
        """Discard the open feature, or else cancel the current action of the active tool."""
        if self._queued_events:
            self._drop_waiting_clicks()
        elif (tool := self.open_tool or self.active) is not None:
            tool.cancel()

    @property
    def has_waiting_clicks(self) -> bool:
        """Whether clicks are pending until the feature of another tool is stored."""
        return bool(self._queued_events)

    def undo_click(self) -> None:
        """Remove the last pending click, or undo the last step of the open feature."""
        if self._queued_events:
            self._queued_events.pop()
            self.show(self._tool_preview)
            self.tool_changed()
        elif (tool := self.open_tool) is not None:
            tool.undo()

    def pointer(self, event: PointerEvent) -> None:
        """Pass a pointer event to the active tool.

        While the path of another tool's feature is being searched, clicks are queued, because only
        one feature can be open.
        """
        tool, busy_tool = self.active, self.open_tool
        if tool is None:
            return
        if busy_tool is not None and busy_tool is not tool and not busy_tool.is_finishing:
            self._close(busy_tool)
            busy_tool = self.open_tool
        if busy_tool is None or busy_tool is tool:
            tool.pointer(event)
        elif event.kind is Pointer.CLICK and event.button is Button.LEFT and event.hit:
            self._queued_events.append(event)
            self.show(self._tool_preview)
            self.tool_changed()
        elif event.kind is Pointer.DRAG_START:
            self.hint(Finding("tool.path-pending"))

    def _drop_waiting_clicks(self) -> None:
        if self._queued_events:
            self._queued_events.clear()
            self.show(self._tool_preview)
            self.tool_changed()

    def _pass_waiting_clicks(self) -> None:
        """Pass the pending clicks to the active tool once no other tool has an open feature."""
        while self._queued_events and (tool := self.active) is not None:
            busy_tool = self.open_tool
            if (
                busy_tool is not None
                and busy_tool is not tool
                and not self._close_busy_tool(busy_tool)
            ):
                return
            event = self._queued_events.pop(0)
            self.show(self._tool_preview)
            if event is None:
                tool.finish()
            else:
                tool.pointer(event)

    def set_next_type(self, type_id: str, set_name: str) -> None:
        """Set the type and set of the next feature, and of the open feature if it is new.

        A set that was not changed together with the type is replaced by the last set of the type.
        """
        current = self.next_type_id, self.next_set
        self.copy_next_type(type_id, self._sets.choose_set(current, type_id, set_name))

    def copy_next_type(self, type_id: str, set_name: str) -> None:
        """Set the type and set of the next feature exactly, as for a repeat of a feature."""
        self.next_type_id, self.next_set = type_id, set_name
        for tool in self.tools.values():
            if tool is self.active or not tool.is_finishing:
                tool.set_type(type_id, set_name)
        self.next_type_changed.emit()

    def begin(self) -> None:
        """Reset the types, sets and active tool for another project."""
        self.activate(NAVIGATE)
        self._next_types_by_tool.clear()
        self._sets.clear()
        self.next_type_id, self.next_set = "bedding", ""
        self.keep_next_type()
        self.next_type_changed.emit()

    def keep_next_type(self) -> None:
        """Choose another type for the next feature if the present type was removed."""
        if self.next_type_id not in self._projects.records:
            self.next_type_id = self._projects.of(FeatureType)[0].id

    def document_changed(self) -> None:
        """Notify the tools of a change of the document."""
        for tool in self.tools.values():
            tool.document_changed()

    # --- change of the project ----------------------------------------------------------------
    def clear_state(self) -> None:
        """Close the tools with the project; an unfinished feature is stored as a draft."""
        self._queued_events.clear()
        for tool in self.tools.values():
            tool.clear_state()
        self.paths.clear_state()

    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore an unfinished feature from its draft."""
        name = str(state.get("tool"))
        tool = self.tools.get(name)
        if tool is not None:
            self.activate(name)
        if tool is None or not tool.restore(state):
            self._notices.warn(Finding("tool.draft-unreadable"))
            return
        self.tool_changed()
        if isinstance(tool, ElementTool):
            self._notices.info(Finding("tool.selection-restored", count=tool.count))
            return
        count = len(state.get("vertices", ()))
        self._notices.info(Finding("tool.draft-restored", count=count))

    # --- ToolContext -------------------------------------------------------------------------
    @property
    def session(self) -> Session:
        return self._projects.session

    def surface(self, model_id: str) -> SelectableSurface | None:
        return self._models.surface(model_id)

    def run_in_background(
        self, work: Callable[[], T], finished_callback: Callable[[T | None], object]
    ) -> None:
        self._background.run(work, finished_callback, lambda _: finished_callback(None))

    def measure(self, feature: Feature) -> Measurement:
        return self._derived.measure(feature)

    def format_attitude(self, measurement: Measurement) -> str:
        text = measurement.attitude(self._preferences.settings.notation)
        if self._derived.is_north_known():
            return text
        return tr("{attitude} (local frame)", attitude=text)

    def world_positions(self, hits: Sequence[Hit]) -> FloatArray:
        models = [get(self.session.records, hit.model_id, Model) for hit in hits]
        return np.array(
            [
                transform.apply(model.to_world, [hit.position])[0]
                for hit, model in zip(hits, models, strict=True)
                if model is not None
            ]
        ).reshape(-1, 3)

    def feature_positions(self) -> dict[str, FloatArray]:
        visible = self._visibility.visible
        features = [
            f for f in self.session.features() if visible(f.id) and visible(visibility_group(f))
        ]
        measurements = self._derived.measured(f.id for f in features)
        points = {f.id: np.asarray(measurements[f.id].points).reshape(-1, 3) for f in features}
        return {id_: point.mean(axis=0) for id_, point in points.items() if len(point)}

    def select(self, feature_ids: Sequence[str], combination: Combine) -> None:
        current, other_ids = self._selection.ids, set(feature_ids)
        if combination == "add":
            self._selection.set((*current, *feature_ids))
        elif combination == "new":
            self._selection.set(feature_ids)
        else:
            self._selection.set(
                i for i in current if (i in other_ids) is (combination == "intersect")
            )

    def show(self, preview: Preview | None) -> None:
        self._tool_preview = preview
        hits = [event.hit for event in self._queued_events if event is not None and event.hit]
        if hits:
            preview = preview or Preview(np.zeros((0, 3)))
            positions = self.world_positions(hits)
            if preview.pending_positions is not None:
                positions = np.concatenate([preview.pending_positions, positions])
            preview = replace(preview, pending_positions=positions)
        self.preview.emit(preview)

    def report(self, message: Finding | VomError) -> None:
        self._notices.warn(message)

    def hint(self, message: Finding) -> None:
        self._notices.hint(message)

    def tool_changed(self) -> None:
        with group_notifications():
            self.changed.emit()
            self.undo_changed.emit()
        if self._queued_events:
            # The tool may still be finishing its feature.
            self._post(self._pass_waiting_clicks)

    def report_discarded(self, discarded_work: DiscardedFeature) -> None:
        self.feature_discarded.emit(discarded_work)
        self.undo_changed.emit()

    def report_created(self, feature_id: str) -> None:
        self._selection.set((feature_id,))
