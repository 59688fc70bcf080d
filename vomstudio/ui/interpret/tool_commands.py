"""Taking up a tool, and what is done to the feature that is being picked."""

from __future__ import annotations

from typing import Any

from vomstudio.errors import VomError
from vomstudio.tools.polyline import PolylineTool
from vomstudio.tools.registry import TOOLS
from vomstudio.tools.tool_entry import ToolEntry
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.command_targets import why_no_model, why_none_chosen
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.window_protocols import Docks
from vomstudio.ui.scene.view_panel import ViewPanel

NOTHING_OPEN = "nothing is being picked"


class _Picking:
    """The feature that is being picked, or that can be taken up again."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio

    @property
    def tool(self) -> PolylineTool[Any] | None:
        """The open tool, where it picks vertices."""
        tool = self._studio.open_tool
        return tool if isinstance(tool, PolylineTool) else None

    def why_nothing(self) -> str | None:
        return NOTHING_OPEN if self._studio.open_tool is None else None

    def why_not_finish(self) -> str | None:
        unfinished = self._studio.open_tool or self._studio.tool
        return NOTHING_OPEN if unfinished is None else unfinished.why_not_finish()

    def why_not_cancel(self) -> str | None:
        unfinished = self._studio.open_tool or self._studio.tool
        return NOTHING_OPEN if unfinished is None else unfinished.why_not_cancel()

    def why_no_vertex(self) -> str | None:
        if (tool := self.tool) is None:
            return NOTHING_OPEN
        if tool.current_vertex is None:
            return f"click a vertex of the open {tool.what} first"
        return None

    def why_not_delete(self) -> str | None:
        return self.why_no_vertex() if self.tool is not None else why_none_chosen(self._studio)

    def why_not_continue(self) -> str | None:
        if self._studio.open_tool is not None:
            return "something is being picked: finish or cancel it first"
        return None if self._to_continue() else "select a trace, line or measurement first"

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
        if self.tool is not None:
            self.delete_vertex()
        else:
            self._studio.delete_selected()

    def take_back(self) -> None:
        if (unfinished := self._studio.open_tool) is not None:
            unfinished.undo()


def _taking_up(studio: Studio, entry: ToolEntry) -> Command:
    name = entry.name
    return Command(
        name, entry.label, lambda: studio.activate(name), entry.icon, entry.key, entry.tip,
        lambda: why_no_model(studio), in_viewport=True, checked=lambda: studio.tool_name == name,
    )  # fmt: skip


def commands(studio: Studio, directions: ViewPanel, docks: Docks) -> list[Command]:
    picking = _Picking(studio)

    return [
        Command("navigate", "&Navigate", lambda: studio.activate("navigate"), "cursor-move", "N",
                "Turn, move and zoom; click a plane to select it", in_viewport=True,
                checked=lambda: studio.tool_name == "navigate"),
        *(_taking_up(studio, entry) for entry in TOOLS),
        Command("finish", "Finish", studio.finish_tool, "check", ("Return", "Enter"),
                "Keep what is being picked", picking.why_not_finish, in_viewport=True),
        Command("cancel", "Cancel", studio.cancel_tool, "close", "Esc",
                "Give up what is being picked; a continued one stays as it was",
                picking.why_not_cancel, in_viewport=True),
        Command("continue_trace", "Continue", picking.continue_feature, "vector-polyline-plus", (),
                "Take the selected trace, line or measurement up again: add, move, insert or "
                "delete vertices",
                picking.why_not_continue),
        Command("delete_vertex", "Delete vertex", picking.delete_vertex,
                "vector-polyline-remove", (),
                "The marked vertex of what is being picked (Del in the viewport)",
                picking.why_no_vertex),
        Command("delete_here", "Delete what is marked or selected", picking.delete, None, "Del",
                "The marked vertex of what is being picked, else the selected features",
                picking.why_not_delete, in_viewport=True),
        Command("undo_click", "Take back the last click", picking.take_back, None, "Backspace", "",
                picking.why_nothing, in_viewport=True),
        Command("along_beta", "Look along &beta", directions.along_beta, None, "B",
                "Orthographic view down the fold axis of the bedding", directions.why_no_beta,
                in_viewport=True),
        Command("face_plane", "Face the &plane", directions.face, None, "Shift+P",
                "Orthographic view at right angles to the selected plane",
                directions.why_no_plane, in_viewport=True),
        Command("show_stereonet", "Show the &stereonet", lambda: docks.bring_forward("stereonet")),
    ]  # fmt: skip
