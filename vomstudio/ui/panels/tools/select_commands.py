"""Commands for faces and points selected with the tools Plane and Select."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import get
from vomstudio.studio.tools.element_selection import COMBINATIONS, Combine
from vomstudio.studio.tools.element_tool import ElementTool
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.select import SelectTool, Target
from vomstudio.studio.tools.selection_messages import ElementMode
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio

Keys = str | tuple[str, ...]

MODE_ICONS: dict[ElementMode, str] = {
    "pick": "auto-fix",
    "rectangle": "select",
    "lasso": "lasso",
    "polygon": "vector-polygon",
}
_MODES: dict[ElementMode, tuple[str, str, str]] = {
    "pick": (
        to_translate("Grow and paint"),
        "G",
        to_translate("Click to select a planar surface; drag to paint one."),
    ),
    "rectangle": (
        to_translate("Draw a rectangle"),
        "R",
        to_translate("Drag a rectangle around an area."),
    ),
    "lasso": (to_translate("Draw a lasso"), "A", to_translate("Draw around an area.")),
    "polygon": (
        to_translate("Draw a polygon"),
        "Y",
        to_translate("Click the corners around an area; Enter closes it."),
    ),
}
_COMBINE_TIPS: dict[Combine, tuple[str, str]] = {
    "new": ("selection", to_translate("The result replaces the selection.")),
    "add": ("vector-union", to_translate("The result is added (hold Shift to add once).")),
    "subtract": (
        "vector-difference-ba",
        to_translate("The result is removed (hold Alt to remove once)."),
    ),
    "intersect": (
        "vector-intersection",
        to_translate("Only the common part stays selected (Alt+Shift: once)."),
    ),
}
_TARGETS: dict[Target, tuple[str, str, str]] = {
    "features": (
        to_translate("Select features"),
        "vector-polyline",
        to_translate("Shapes and clicks select features."),
    ),
    "surface": (
        to_translate("Select the surface"),
        "texture-box",
        to_translate("Shapes select faces or points, to hide or cut them out."),
    ),
}


class _SelectCommands:
    """Commands of the tools Plane and Select, with the reasons why they are disabled."""

    def __init__(self, studio: Studio) -> None:
        self._studio = studio
        self.select, self.plane = studio.get_tool(SelectTool), studio.get_tool(PlaneTool)

    @property
    def tool(self) -> ElementTool:
        """Plane tool while it is active, otherwise the tool Select."""
        return self.plane if self._studio.tool_name == self.plane.name else self.select

    def select_tool_problem(self) -> Finding | None:
        if self._studio.tool_name == self.select.name:
            return None
        return Finding("action.needs-tool", tool=tr("Select"))

    def element_tool_problem(self) -> Finding | None:
        if self._studio.tool_name in (self.select.name, self.plane.name):
            return None
        return Finding("action.needs-tool", tool=tr("Plane"))

    def plane_tool_problem(self) -> Finding | None:
        if self._studio.tool_name == self.plane.name:
            return None
        return Finding("action.needs-tool", tool=tr("Plane"))

    def chosen_elements_problem(self) -> Finding | None:
        if (reason := self.element_tool_problem()) is not None:
            return reason
        return None if self.tool.count else Finding("action.no-elements")

    def missing_selection_finding(self) -> Finding | None:
        if (reason := self.select_tool_problem()) is not None:
            return reason
        return None if self.tool.count else Finding("action.no-elements")

    def missing_model_finding(self) -> Finding | None:
        if (reason := self.element_tool_problem()) is not None:
            return reason
        return None if self.tool.changes.data() is not None else Finding("action.no-elements")

    def hidden_elements_problem(self) -> Finding | None:
        return None if self.tool.changes.has_hidden_elements() else Finding("action.nothing-hidden")

    def find_patch(self) -> Patch | None:
        """Return the most recently selected patch, or None if no patch is selected."""
        studio = self._studio
        patches = (get(studio.records, i, Patch) for i in reversed(studio.selection.ids))
        return next((patch for patch in patches if patch is not None), None)

    def patch_problem(self) -> Finding | None:
        if (reason := self.element_tool_problem()) is not None:
            return reason
        return None if self.find_patch() is not None else Finding("selection.no-patch")

    def select_patch(self) -> None:
        if (patch := self.find_patch()) is not None:
            self.tool.changes.select_patch(patch)

    def measure_plane(self) -> None:
        """Continue with the selection in the plane tool."""
        selection = self.select.release()
        self._studio.activate(self.plane.name)
        if selection is not None:
            self.plane.adopt(selection)

    # --- commands ----------------------------------------------------------------------------
    def create_mode_command(self, mode: ElementMode) -> Command:
        title, key, tooltip = _MODES[mode]
        return Command(
            f"shape_{mode}",
            tr(title),
            lambda: self.tool.set_mode(mode),
            icon=MODE_ICONS[mode],
            shortcut=key,
            tip=tr(tooltip),
            disabled_reason=self.plane_tool_problem
            if mode == "pick"
            else self.element_tool_problem,
            is_viewport_key=True,
            is_checked=lambda: self.tool.mode == mode,
        )

    def create_target_command(self, target: Target) -> Command:
        title, icon, tooltip = _TARGETS[target]
        return Command(
            f"select_{target}",
            tr(title),
            lambda: self.select.set_target(target),
            icon=icon,
            tip=tr(tooltip),
            disabled_reason=self.select_tool_problem,
            is_checked=lambda: self.select.target == target,
        )

    def create_combine_command(self, combination: Combine) -> Command:
        icon, tooltip = _COMBINE_TIPS[combination]
        return Command(
            f"select_{combination}",
            tr(COMBINATIONS[combination]),
            lambda: self.tool.set_combine(combination),
            icon=icon,
            tip=tr(tooltip),
            disabled_reason=self.element_tool_problem,
            is_checked=lambda: self.tool.combine == combination,
        )


def commands(studio: Studio) -> list[Command]:
    """Create the commands of the tools that select faces, points and features."""
    factory = _SelectCommands(studio)

    def create_command(
        name: str,
        text: str,
        run: Callable[[], object],
        icon: str,
        tooltip: str,
        key: Keys = (),
        disabled_reason: Callable[[], Finding | None] = factory.missing_selection_finding,
    ) -> Command:
        return Command(
            name,
            text,
            run,
            icon=icon,
            shortcut=key,
            tip=tooltip,
            disabled_reason=disabled_reason,
            is_viewport_key=bool(key),
        )

    return [
        *(factory.create_target_command(target) for target in _TARGETS),
        *(factory.create_mode_command(mode) for mode in _MODES),
        *(factory.create_combine_command(combination) for combination in _COMBINE_TIPS),
        Command(
            "select_through",
            tr("Through the surface"),
            lambda: factory.tool.set_select_through(not factory.tool.is_through),
            icon="layers-outline",
            shortcut="V",
            tip=tr("Shapes also select hidden elements."),
            disabled_reason=factory.element_tool_problem,
            is_viewport_key=True,
            is_checked=lambda: factory.tool.is_through,
        ),
        create_command(
            "select_wider",
            tr("Expand"),
            lambda: factory.tool.changes.expand(),
            icon="arrow-expand-all",
            key=("+", "="),
            tooltip=tr("Add the neighbours of the selected elements."),
            disabled_reason=factory.chosen_elements_problem,
        ),
        create_command(
            "select_narrower",
            tr("Shrink"),
            lambda: factory.tool.changes.shrink(),
            icon="arrow-collapse-all",
            key="-",
            tooltip=tr("Remove the elements at the edge."),
            disabled_reason=factory.chosen_elements_problem,
        ),
        create_command(
            "select_invert",
            tr("Invert"),
            lambda: factory.tool.changes.invert(),
            icon="select-inverse",
            key="Shift+I",
            tooltip=tr("Invert the selection."),
            disabled_reason=factory.chosen_elements_problem,
        ),
        create_command(
            "select_everything",
            tr("Whole model"),
            lambda: factory.tool.changes.select_all(),
            icon="select-all",
            tooltip=tr("Select every face or point of the model."),
            disabled_reason=factory.missing_model_finding,
        ),
        create_command(
            "select_patch",
            tr("Select plane"),
            factory.select_patch,
            icon="texture-box",
            tooltip=tr("Select the faces or points of the selected plane."),
            disabled_reason=factory.patch_problem,
        ),
        create_command(
            "selection_to_plane",
            tr("Measure plane"),
            factory.measure_plane,
            icon="layers-search-outline",
            tooltip=tr("Fit a plane to the selected faces or points."),
        ),
        create_command(
            "hide_elements",
            tr("Hide selection"),
            factory.select.hide_selected,
            icon="eye-off-outline",
            key="H",
            tooltip=tr("Hide the selected part of the model. Undo restores it."),
        ),
        create_command(
            "isolate_elements",
            tr("Isolate selection"),
            factory.select.changes.isolate,
            icon="eye-outline",
            key="Shift+H",
            tooltip=tr("Hide the rest of the model. Earlier view (Shift+Z) restores it."),
        ),
        create_command(
            "show_elements",
            tr("Show hidden"),
            factory.select.changes.show_all,
            icon="eye",
            key="U",
            tooltip=tr("Show all hidden faces and points. Undo hides them again."),
            disabled_reason=factory.hidden_elements_problem,
        ),
        create_command(
            "cut_out",
            tr("Cut out"),
            factory.select.changes.cut_out,
            icon="scissors-cutting",
            tooltip=tr("Create a model from the selection. The original is kept."),
        ),
    ]
