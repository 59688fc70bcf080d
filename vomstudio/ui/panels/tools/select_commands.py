"""Commands for the selected faces and points of a surface."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import get
from vomstudio.studio.tools.element_selection import COMBINATIONS, Combine
from vomstudio.studio.tools.select import SelectTool
from vomstudio.studio.tools.selection_messages import STEPS, SelectMode
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio

Keys = str | tuple[str, ...]

_MODES: dict[SelectMode, tuple[str, str, str]] = {
    "grow": (
        "auto-fix",
        "G",
        to_translate("A click takes the surface around it as far as it is even."),
    ),
    "rectangle": ("select", "R", to_translate("A drag takes what lies inside a rectangle.")),
    "lasso": ("lasso", "A", to_translate("A drag takes what lies inside the line that is drawn.")),
    "polygon": (
        "vector-polygon",
        "Y",
        to_translate("Clicks are the corners of a polygon; Enter takes what lies inside."),
    ),
}
_COMBINE_TIPS: dict[Combine, tuple[str, str]] = {
    "new": ("selection", to_translate("What is found takes the place of what is chosen.")),
    "add": ("vector-union", to_translate("What is found is added (Shift does so once).")),
    "subtract": (
        "vector-difference-ba",
        to_translate("What is found is taken away (Ctrl does so once)."),
    ),
    "intersect": (
        "vector-intersection",
        to_translate("Only what is found stays chosen (Ctrl+Shift does so once)."),
    ),
}


class _SelectCommands:
    """Commands of the selection tool, with the reasons why they are disabled."""

    def __init__(self, studio: Studio) -> None:
        self._studio, self.tool = studio, studio.tool_of(SelectTool)

    def why_not_selecting(self) -> Finding | None:
        if self._studio.tool_name == self.tool.name:
            return None
        return Finding("action.needs-tool", tool=tr("Select"))

    def why_no_selection(self) -> Finding | None:
        if (reason := self.why_not_selecting()) is not None:
            return reason
        return None if self.tool.count else Finding("action.no-elements")

    def why_no_model(self) -> Finding | None:
        if (reason := self.why_not_selecting()) is not None:
            return reason
        return None if self.tool.changes.data() is not None else Finding("action.no-elements")

    def why_none_hidden(self) -> Finding | None:
        return None if self.tool.changes.anything_hidden() else Finding("action.nothing-hidden")

    def find_patch(self) -> Patch | None:
        """Return the most recently selected patch, or None."""
        studio = self._studio
        patches = (get(studio.records, i, Patch) for i in reversed(studio.selection.ids))
        return next((patch for patch in patches if patch is not None), None)

    def why_no_patch(self) -> Finding | None:
        if (reason := self.why_not_selecting()) is not None:
            return reason
        return None if self.find_patch() is not None else Finding("selection.no-patch")

    def take_patch(self) -> None:
        if (patch := self.find_patch()) is not None:
            self.tool.changes.take_patch(patch)

    # --- commands ----------------------------------------------------------------------------
    def create_mode_command(self, mode: SelectMode) -> Command:
        icon, key, tip = _MODES[mode]
        return Command(
            f"select_{mode}",
            tr(STEPS[mode]),
            lambda: self.tool.set_mode(mode),
            icon=icon,
            shortcut=key,
            tip=tr(tip),
            why_not=self.why_not_selecting,
            is_viewport_key=True,
            is_checked=lambda: self.tool.mode == mode,
        )

    def create_combine_command(self, combination: Combine) -> Command:
        icon, tip = _COMBINE_TIPS[combination]
        return Command(
            f"select_{combination}",
            tr(COMBINATIONS[combination]),
            lambda: self.tool.set_combine(combination),
            icon=icon,
            shortcut=(),
            tip=tr(tip),
            why_not=self.why_not_selecting,
            is_checked=lambda: self.tool.combine == combination,
        )


def commands(studio: Studio) -> list[Command]:
    """Create the commands that the tool adds to the Interpret menu."""
    factory = _SelectCommands(studio)
    tool, changes = factory.tool, factory.tool.changes

    def create_command(
        name: str,
        text: str,
        run: Callable[[], object],
        icon: str,
        key: Keys,
        tip: str,
        why_not: Callable[[], Finding | None] = factory.why_no_selection,
    ) -> Command:
        return Command(
            name,
            text,
            run,
            icon=icon,
            shortcut=key,
            tip=tip,
            why_not=why_not,
            is_viewport_key=bool(key),
        )

    return [
        *(factory.create_mode_command(mode) for mode in _MODES),
        *(factory.create_combine_command(combination) for combination in _COMBINE_TIPS),
        Command(
            "select_through",
            tr("Through the surface"),
            lambda: tool.set_through(not tool.through),
            icon="layers-outline",
            shortcut="V",
            tip=tr("Shapes take what is hidden too; else only what is seen."),
            why_not=factory.why_not_selecting,
            is_viewport_key=True,
            is_checked=lambda: tool.through,
        ),
        create_command(
            "select_wider",
            tr("Widen"),
            changes.wider,
            icon="arrow-expand-all",
            key=("+", "="),
            tip=tr("With those beside the chosen ones."),
        ),
        create_command(
            "select_narrower",
            tr("Narrow"),
            changes.narrower,
            icon="arrow-collapse-all",
            key="-",
            tip=tr("Without those at the edge of what is chosen."),
        ),
        create_command(
            "select_invert",
            tr("Invert"),
            changes.invert,
            icon="select-inverse",
            key="Shift+I",
            tip=tr("What is not chosen, in place of what is."),
        ),
        create_command(
            "select_everything",
            tr("Choose all"),
            changes.everything,
            icon="select-all",
            key=(),
            tip=tr("Every face or point of the model."),
            why_not=factory.why_no_model,
        ),
        create_command(
            "select_patch",
            tr("Take patch"),
            factory.take_patch,
            icon="texture-box",
            key=(),
            tip=tr("The faces or points of the selected patch."),
            why_not=factory.why_no_patch,
        ),
        create_command(
            "hide_elements",
            tr("Hide what is chosen"),
            tool.hide_selected,
            icon="eye-off-outline",
            key="H",
            tip=tr("Hides what is chosen of the model. Undo shows it again."),
        ),
        create_command(
            "isolate_elements",
            tr("Isolate what is chosen"),
            changes.isolate,
            icon="eye-outline",
            key="Shift+H",
            tip=tr(
                "Hides all of the model but what is chosen. Earlier view (Shift+Z) shows it again."
            ),
        ),
        create_command(
            "show_elements",
            tr("Show hidden"),
            changes.show_all,
            icon="eye",
            key="U",
            tip=tr("Shows every face and point again. Undo hides them."),
            why_not=factory.why_none_hidden,
        ),
        create_command(
            "cut_out",
            tr("Cut out"),
            changes.cut_out,
            icon="scissors-cutting",
            key=(),
            tip=tr("Makes a model of what is chosen, with its textures. The original stays."),
        ),
    ]
