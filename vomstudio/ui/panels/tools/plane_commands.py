"""Commands of the plane tool."""

from __future__ import annotations

from functools import partial

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.select import SelectTool
from vomstudio.studio.tools.selection_messages import ElementMode
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import why_no_model
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
    tool, select = studio.tool_of(PlaneTool), studio.tool_of(SelectTool)

    def why_not_active() -> Finding | None:
        if studio.tool_name == tool.name:
            return None
        return Finding("action.needs-tool", tool=tr("Plane"))

    def why_no_area() -> Finding | None:
        return why_not_active() or (None if tool.count else Finding("plane.nothing-chosen"))

    def activate(mode: ElementMode) -> None:
        studio.activate(tool.name)
        if studio.tool_name == tool.name:
            tool.set_mode(mode)

    def to_selection() -> None:
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
                why_not=lambda: why_no_model(studio),
            )
            for mode, title in _TITLES.items()
        ),
        Command(
            "plane_to_selection",
            tr("Select area"),
            to_selection,
            icon="selection-drag",
            tip=tr("Select these faces or points, to hide them or cut them out."),
            why_not=why_no_area,
        ),
        Command(
            "brush_smaller",
            tr("Smaller brush"),
            tool.smaller,
            shortcut="[",
            why_not=why_not_active,
            is_viewport_key=True,
        ),
        Command(
            "brush_larger",
            tr("Larger brush"),
            tool.larger,
            shortcut="]",
            why_not=why_not_active,
            is_viewport_key=True,
        ),
    ]
