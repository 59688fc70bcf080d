"""What is done to a patch that is being painted."""

from __future__ import annotations

from vomstudio.document.kinds.patch import Patch
from vomstudio.document.records import get
from vomstudio.errors import VomError
from vomstudio.tools.patch import PatchTool
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio


def commands(studio: Studio) -> list[Command]:
    tool = studio.tool_of(PatchTool)

    def not_painting() -> str | None:
        return None if studio.tool_name == tool.name else "choose Patch first"

    def chosen() -> Patch | None:
        found = [
            r for i in studio.selection.ids if (r := get(studio.records, i, Patch)) is not None
        ]
        return found[-1] if found else None

    def cannot_continue() -> str | None:
        if studio.open_tool is not None:
            return "something is being picked: finish or cancel it first"
        patch = chosen()
        if patch is None:
            return "select a patch first"
        return None if patch.model_id in studio.models else "the patch's model is not open"

    def take_up() -> None:
        patch = chosen()
        if patch is None:
            return
        studio.activate(tool.name)
        try:
            tool.continue_patch(patch.id)
        except VomError as error:
            studio.fail(error)

    return [
        Command("continue_patch", "Continue the patch", take_up, "brush-variant", (),
                "Take the selected patch up again: paint on, or take away", cannot_continue),
        Command("brush_removes", "Brush takes away",
                lambda: tool.set_removing(not tool.removing), "eraser", (),
                "Strokes take away; without it, those with Ctrl do", not_painting,
                checked=lambda: tool.removing),
        Command("brush_smaller", "Smaller brush", tool.smaller, None, "[", "", not_painting,
                in_viewport=True),
        Command("brush_larger", "Larger brush", tool.larger, None, "]", "", not_painting,
                in_viewport=True),
    ]  # fmt: skip
