"""Commands of the plane tool."""

from __future__ import annotations

from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.select import SelectTool
from vomstudio.studio.tools.selection_messages import ElementMode
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_model_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.select_commands import MODE_ICONS

_TITLES: dict[ElementMode, str] = {
    "pick": to_translate("Plane: grow and paint"),
    "rectangle": to_translate("Plane: rectangle"),
    "lasso": to_translate("Plane: lasso"),
    "polygon": to_translate("Plane: polygon"),
}


def commands(studio: Studio) -> list[Command]:
    """Create the commands that the plane tool adds to the search.

    Parameters
    ----------
    studio : Studio

    Returns
    -------
    list of Command
    """
    tool, select = studio.get_tool(PlaneTool), studio.get_tool(SelectTool)

    def plane_tool_problem() -> Finding | None:
        if studio.tool_name == tool.name:
            return None
        return Finding("action.needs-tool", tool=tr("Plane"))

    def area_problem() -> Finding | None:
        return plane_tool_problem() or (None if tool.count else Finding("plane.nothing-chosen"))

    def activate(mode: ElementMode) -> None:
        studio.activate(tool.name)
        if studio.tool_name == tool.name:
            tool.set_mode(mode)

    def select_elements() -> None:
        """Select the faces or points of the unfinished plane."""
        selection = tool.release()
        studio.activate(select.name)
        if selection is not None:
            select.set_target("surface")
            select.adopt(selection)

    return [
        *(
            Command(
                f"plane_{mode}",
                tr(title),
                partial(activate, mode),
                icon=MODE_ICONS[mode],
                tip=tr("Measure a plane on the surface in this mode."),
                disabled_reason=lambda: missing_model_finding(studio),
            )
            for mode, title in _TITLES.items()
        ),
        Command(
            "plane_to_selection",
            tr("Select area"),
            select_elements,
            icon="selection-drag",
            tip=tr("Select these faces or points, to hide them or cut them out."),
            disabled_reason=area_problem,
        ),
        Command(
            "brush_smaller",
            tr("Smaller brush"),
            tool.shrink_brush,
            shortcut="[",
            disabled_reason=plane_tool_problem,
            is_viewport_key=True,
        ),
        Command(
            "brush_larger",
            tr("Larger brush"),
            tool.enlarge_brush,
            shortcut="]",
            disabled_reason=plane_tool_problem,
            is_viewport_key=True,
        ),
    ]
