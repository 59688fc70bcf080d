"""Commands that activate a tool, and commands for the open feature."""

from __future__ import annotations

from typing import Any

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.records import PaintedFeature
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.polyline import PolylineTool
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.studio.tools.tool_entry import ToolEntry
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_feature_finding, missing_model_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.commands.deletion import delete_selected
from vomstudio.ui.panels.view.view_panel import ViewPanel

_NO_OPEN_FEATURE = Finding("tool.nothing-open")


class _OpenFeature:
    """Actions on the open feature, or on the selected feature if it can be continued."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio

    @property
    def tool(self) -> PolylineTool[Any] | None:
        """Polyline tool that has the open feature, or None."""
        tool = self._studio.open_tool
        return tool if isinstance(tool, PolylineTool) else None

    def missing_feature_finding(self) -> Finding | None:
        return _NO_OPEN_FEATURE if self._studio.open_tool is None else None

    def finish_problem(self) -> Finding | None:
        tool = self._studio.open_tool or self._studio.tool
        return _NO_OPEN_FEATURE if tool is None else tool.finish_problem()

    def cancel_problem(self) -> Finding | None:
        tool = self._studio.open_tool or self._studio.tool
        return _NO_OPEN_FEATURE if tool is None else tool.cancel_problem()

    def missing_vertex_finding(self) -> Finding | None:
        if (tool := self.tool) is None:
            return _NO_OPEN_FEATURE
        if tool.current_vertex is None:
            return Finding("action.no-vertex")
        return None

    def delete_problem(self) -> Finding | None:
        return (
            self.missing_vertex_finding()
            if self.tool is not None
            else missing_feature_finding(self._studio)
        )

    def continue_problem(self) -> Finding | None:
        if self._studio.open_tool is not None:
            return Finding("feature.open")
        target = self._find_editable_feature()
        if target is None:
            return Finding("action.nothing-to-continue")
        record = self._studio.records.get(target[0])
        if isinstance(record, PaintedFeature) and record.model_id not in self._studio.models:
            return Finding("model.not-open", model=record.model_id)
        return None

    def _find_editable_feature(self) -> tuple[str, str] | None:
        """Return the most recently selected feature that a tool can edit.

        Returns
        -------
        tuple of (str, str) or None
            Id of the feature and name of the tool, or None if no such feature is selected.
        """
        studio = self._studio
        for id_ in reversed(studio.selection.ids):
            for name, tool in studio.tools.items():
                if isinstance(tool, PolylineTool | PlaneTool) and isinstance(
                    studio.records.get(id_), tool.record
                ):
                    return id_, name
        return None

    def continue_feature(self) -> None:
        """Activate the tool of the selected feature and continue that feature."""
        target = self._find_editable_feature()
        if target is None:
            return
        id_, name = target
        self._studio.activate(name)
        tool = self._studio.tools[name]
        try:
            if isinstance(tool, PolylineTool | PlaneTool):
                tool.continue_feature(id_)
        except VomError as error:
            self._studio.fail(error)

    def delete_vertex(self) -> None:
        if (tool := self.tool) is not None:
            tool.delete_vertex()

    def delete(self) -> None:
        """Delete the marked vertex of the open feature, or else the selected features."""
        if self.tool is not None:
            self.delete_vertex()
        else:
            delete_selected(self._studio)


class _ContactFollowing:
    """Contact following with the active tool, or else with the trace tool."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio
        self._last_cost = "colour"

    @property
    def tool(self) -> FollowingTool[Any]:
        active_tool = self._studio.tool
        return (
            active_tool
            if isinstance(active_tool, FollowingTool)
            else self._studio.get_tool(TraceTool)
        )

    def disabled_reason(self) -> Finding | None:
        if self.tool.is_continued:
            return Finding("follow.continued")
        return missing_model_finding(self._studio)

    def toggle(self) -> None:
        """Switch following with the last cost on or off.

        The trace tool is activated if the active tool cannot follow, because the switch would
        otherwise have no visible effect.
        """
        is_active = isinstance(self._studio.tool, FollowingTool)
        cost = self.tool.cost
        self._last_cost = cost or self._last_cost
        if not is_active:
            self._studio.activate(TraceTool.name)
        self.tool.follow(None if cost and is_active else self._last_cost)


def _tool_command(studio: Studio, entry: ToolEntry) -> Command:
    name = entry.name
    return Command(
        name,
        tr(entry.label),
        lambda: studio.activate(name),
        icon=entry.icon,
        shortcut=entry.key,
        tip=tr(entry.tip),
        disabled_reason=lambda: missing_model_finding(studio),
        is_viewport_key=True,
        is_checked=lambda: studio.tool_name == name,
    )


def commands(studio: Studio, directions: ViewPanel, docks: Docks) -> list[Command]:
    """Create the tool commands; `directions` sets the view and `docks` shows the stereonet."""
    open_feature, contact_following = _OpenFeature(studio), _ContactFollowing(studio)

    def measure_thickness() -> None:
        studio.activate("measure")
        studio.get_tool(MeasureTool).choose(kind="thickness")

    return [
        Command(
            "navigate",
            tr("&Navigate"),
            lambda: studio.activate("navigate"),
            icon="cursor-move",
            shortcut="N",
            tip=tr("Orbit, pan and zoom; click a feature to select it."),
            is_viewport_key=True,
            is_checked=lambda: studio.tool_name == "navigate",
        ),
        *(_tool_command(studio, entry) for entry in TOOLS),
        Command(
            "follow",
            tr("&Follow contacts"),
            contact_following.toggle,
            icon="vector-curve",
            shortcut="Shift+T",
            tip=tr("Follow the contact between clicks, or draw straight lines."),
            disabled_reason=contact_following.disabled_reason,
            is_viewport_key=True,
            is_checked=lambda: contact_following.tool.cost is not None,
        ),
        Command(
            "finish",
            tr("Finish"),
            studio.finish_tool,
            icon="check",
            shortcut=("Return", "Enter"),
            tip=tr("Finish and save the open feature."),
            disabled_reason=open_feature.finish_problem,
            is_viewport_key=True,
        ),
        Command(
            "cancel",
            tr("Cancel"),
            studio.cancel_tool,
            icon="close",
            shortcut="Esc",
            tip=tr("Discard the open feature, or the changes to an edited one."),
            disabled_reason=open_feature.cancel_problem,
            is_viewport_key=True,
        ),
        Command(
            "edit_feature",
            tr("&Edit"),
            open_feature.continue_feature,
            icon="pencil-outline",
            tip=tr("Edit the vertices or area of the selected feature (double-click)."),
            disabled_reason=open_feature.continue_problem,
        ),
        Command(
            "delete_vertex",
            tr("Delete vertex"),
            open_feature.delete_vertex,
            icon="vector-polyline-remove",
            tip=tr("Delete the selected vertex of the open feature (Del)."),
            disabled_reason=open_feature.missing_vertex_finding,
        ),
        Command(
            "delete_here",
            tr("Delete"),
            open_feature.delete,
            shortcut="Del",
            tip=tr("Delete the selected vertex of the open feature, or the selected features."),
            disabled_reason=open_feature.delete_problem,
            is_viewport_key=True,
        ),
        Command(
            "undo_click",
            tr("Undo last click"),
            studio.undo_click,
            shortcut="Backspace",
            disabled_reason=open_feature.missing_feature_finding,
            is_viewport_key=True,
        ),
        Command(
            "along_beta",
            tr("Along fold &axis"),
            directions.look_along_beta,
            shortcut="B",
            tip=tr("Look along the fold axis of the bedding (orthographic)."),
            disabled_reason=directions.fold_axis_problem,
            is_viewport_key=True,
        ),
        Command(
            "face_plane",
            tr("Face the &plane"),
            directions.face,
            shortcut="Shift+P",
            tip=tr("Look perpendicular to the selected plane (orthographic)."),
            disabled_reason=directions.plane_problem,
            is_viewport_key=True,
        ),
        Command(
            "measure_thickness",
            tr("Measure &thickness"),
            measure_thickness,
            icon="arrow-expand-vertical",
            tip=tr("Measure the distance between base and top, perpendicular to a plane."),
            disabled_reason=lambda: missing_model_finding(studio),
        ),
        Command("show_stereonet", tr("Show &stereonet"), lambda: docks.bring_forward("stereonet")),
    ]
