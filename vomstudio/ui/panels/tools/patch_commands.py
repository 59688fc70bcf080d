"""Commands of the patch tool."""

from __future__ import annotations

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import get
from vomstudio.studio.tools.patch import PatchTool
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio


def commands(studio: Studio) -> list[Command]:
    """Create the commands that the patch tool adds to the Interpret menu."""
    tool = studio.tool_of(PatchTool)

    def why_not_painting() -> Finding | None:
        if studio.tool_name == tool.name:
            return None
        return Finding("action.needs-tool", tool=tr("Patch"))

    def find_patch() -> Patch | None:
        records = studio.records
        patches = (get(records, i, Patch) for i in reversed(studio.selection.ids))
        return next((patch for patch in patches if patch is not None), None)

    def why_not_continue() -> Finding | None:
        if studio.open_tool is not None:
            return Finding("feature.open")
        patch = find_patch()
        if patch is None:
            return Finding("selection.no-patch")
        return None if patch.model_id in studio.models else Finding("model.not-open")

    def continue_patch() -> None:
        patch = find_patch()
        if patch is None:
            return
        studio.activate(tool.name)
        try:
            tool.continue_patch(patch.id)
        except VomError as error:
            studio.fail(error)

    return [
        Command(
            "continue_patch",
            tr("Continue patch"),
            continue_patch,
            icon="brush-variant",
            shortcut=(),
            tip=tr("Continue the selected patch: add to it or erase from it."),
            why_not=why_not_continue,
        ),
        Command(
            "brush_removes",
            tr("Erase with brush"),
            lambda: tool.set_removing(not tool.removing),
            icon="eraser",
            shortcut=(),
            tip=tr("Strokes erase. Otherwise only strokes with Ctrl do."),
            why_not=why_not_painting,
            is_checked=lambda: tool.removing,
        ),
        Command(
            "brush_smaller",
            tr("Smaller brush"),
            tool.smaller,
            icon=None,
            shortcut="[",
            tip="",
            why_not=why_not_painting,
            is_viewport_key=True,
        ),
        Command(
            "brush_larger",
            tr("Larger brush"),
            tool.larger,
            icon=None,
            shortcut="]",
            tip="",
            why_not=why_not_painting,
            is_viewport_key=True,
        ),
    ]
