"""Commands that choose a tool, and those on the open feature."""

from __future__ import annotations

from typing import Any

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.polyline import PolylineTool
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.studio.tools.tool_entry import ToolEntry
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import why_no_feature, why_no_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.commands.deletion import delete_selected
from vomstudio.ui.panels.view.view_panel import ViewPanel

_NOTHING_OPEN = Finding("tool.nothing-open")


class _OpenFeature:
    """The open feature, or the selected one that can be continued."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio

    @property
    def tool(self) -> PolylineTool[Any] | None:
        """The open tool, where it picks vertices."""
        tool = self._studio.open_tool
        return tool if isinstance(tool, PolylineTool) else None

    def why_nothing(self) -> Finding | None:
        return _NOTHING_OPEN if self._studio.open_tool is None else None

    def why_not_finish(self) -> Finding | None:
        unfinished = self._studio.open_tool or self._studio.tool
        return _NOTHING_OPEN if unfinished is None else unfinished.why_not_finish()

    def why_not_cancel(self) -> Finding | None:
        unfinished = self._studio.open_tool or self._studio.tool
        return _NOTHING_OPEN if unfinished is None else unfinished.why_not_cancel()

    def why_no_vertex(self) -> Finding | None:
        if (tool := self.tool) is None:
            return _NOTHING_OPEN
        if tool.current_vertex is None:
            return Finding("action.no-vertex")
        return None

    def why_not_delete(self) -> Finding | None:
        return self.why_no_vertex() if self.tool is not None else why_no_feature(self._studio)

    def why_not_continue(self) -> Finding | None:
        if self._studio.open_tool is not None:
            return Finding("feature.open")
        return None if self._to_continue() else Finding("action.nothing-to-continue")

    def _to_continue(self) -> tuple[str, str] | None:
        """Id and tool of the last selected feature that was picked vertex by vertex."""
        studio = self._studio
        for id_ in reversed(studio.selection.ids):
            for name, tool in studio.tools.items():
                if isinstance(tool, PolylineTool) and isinstance(
                    studio.records.get(id_), tool.record
                ):
                    return id_, name
        return None

    def continue_feature(self) -> None:
        """Choose the tool of the selected feature and continue it."""
        found = self._to_continue()
        if found is None:
            return
        id_, name = found
        self._studio.activate(name)
        tool = self._studio.tools[name]
        try:
            if isinstance(tool, PolylineTool):
                tool.continue_feature(id_)
        except VomError as error:
            self._studio.fail(error)

    def delete_vertex(self) -> None:
        if (tool := self.tool) is not None:
            tool.delete_vertex()

    def delete(self) -> None:
        """Delete the marked vertex of the open feature, else the selected features."""
        if self.tool is not None:
            self.delete_vertex()
        else:
            delete_selected(self._studio)

    def undo_click(self) -> None:
        if (unfinished := self._studio.open_tool) is not None:
            unfinished.undo()


class _Following:
    """Whether lines follow contacts, and what of them: those of the tool that is active, else
    traces."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio
        self._last = "colour"

    @property
    def tool(self) -> FollowingTool[Any]:
        active = self._studio.tool
        return active if isinstance(active, FollowingTool) else self._studio.tool_of(TraceTool)

    def why_not(self) -> Finding | None:
        if self.tool.continued:
            return Finding("follow.continued")
        return why_no_model(self._studio)

    def toggle(self) -> None:
        """What was followed last is followed again. While no line is being picked traces are: what
        is switched without a tool to show it seems to do nothing."""
        active = isinstance(self._studio.tool, FollowingTool)
        cost = self.tool.cost
        self._last = cost or self._last
        if not active:
            self._studio.activate(TraceTool.name)
        self.tool.follow(None if cost and active else self._last)


def _choose_tool(studio: Studio, entry: ToolEntry) -> Command:
    name = entry.name
    return Command(
        name,
        tr(entry.label),
        lambda: studio.activate(name),
        entry.icon,
        entry.key,
        tr(entry.tip),
        lambda: why_no_model(studio),
        is_viewport_key=True,
        is_checked=lambda: studio.tool_name == name,
    )


def commands(studio: Studio, directions: ViewPanel, docks: Docks) -> list[Command]:
    """directions : looks along fold axes and planes; docks : where the stereonet is shown"""
    picking, following = _OpenFeature(studio), _Following(studio)

    return [
        Command(
            "navigate",
            tr("&Navigate"),
            lambda: studio.activate("navigate"),
            "cursor-move",
            "N",
            tr("Orbit, pan and zoom; click a feature to select it."),
            is_viewport_key=True,
            is_checked=lambda: studio.tool_name == "navigate",
        ),
        *(_choose_tool(studio, entry) for entry in TOOLS),
        Command(
            "follow",
            tr("&Follow contacts"),
            following.toggle,
            "vector-curve",
            "Shift+T",
            tr(
                "A trace, contact line or outline follows the contact from click to click, or "
                "goes straight."
            ),
            following.why_not,
            is_viewport_key=True,
            is_checked=lambda: following.tool.cost is not None,
        ),
        Command(
            "finish",
            tr("Finish"),
            studio.finish_tool,
            "check",
            ("Return", "Enter"),
            tr("Finish the open feature and keep it."),
            picking.why_not_finish,
            is_viewport_key=True,
        ),
        Command(
            "cancel",
            tr("Cancel"),
            studio.cancel_tool,
            "close",
            "Esc",
            tr("Discard the open feature; a continued one stays as it was."),
            picking.why_not_cancel,
            is_viewport_key=True,
        ),
        Command(
            "continue_trace",
            tr("Continue"),
            picking.continue_feature,
            "vector-polyline-plus",
            (),
            tr(
                "Continue the selected trace, line, area or measurement: add, move, insert "
                "or delete vertices."
            ),
            picking.why_not_continue,
        ),
        Command(
            "delete_vertex",
            tr("Delete vertex"),
            picking.delete_vertex,
            "vector-polyline-remove",
            (),
            tr("Delete the marked vertex of the open feature (Del in the viewport)."),
            picking.why_no_vertex,
        ),
        Command(
            "delete_here",
            tr("Delete vertex or features"),
            picking.delete,
            None,
            "Del",
            tr("Delete the marked vertex of the open feature, else the selected features."),
            picking.why_not_delete,
            is_viewport_key=True,
        ),
        Command(
            "undo_click",
            tr("Undo last click"),
            picking.undo_click,
            None,
            "Backspace",
            "",
            picking.why_nothing,
            is_viewport_key=True,
        ),
        Command(
            "along_beta",
            tr("Look along fold axis &beta"),
            directions.along_beta,
            None,
            "B",
            tr("Orthographic view along the fold axis of the bedding."),
            directions.why_no_beta,
            is_viewport_key=True,
        ),
        Command(
            "face_plane",
            tr("Face the &plane"),
            directions.face,
            None,
            "Shift+P",
            tr("Orthographic view perpendicular to the selected plane."),
            directions.why_no_plane,
            is_viewport_key=True,
        ),
        Command("show_stereonet", tr("Show &stereonet"), lambda: docks.bring_forward("stereonet")),
    ]
