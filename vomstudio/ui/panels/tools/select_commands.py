"""Commands on what is chosen of a surface."""

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

WAYS: dict[SelectMode, tuple[str, str, str]] = {
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
_COMBINE: dict[Combine, tuple[str, str]] = {
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


class _Selecting:
    """What can be done now, and why not."""

    def __init__(self, studio: Studio) -> None:
        self._studio, self.tool = studio, studio.tool_of(SelectTool)

    def not_selecting(self) -> Finding | None:
        if self._studio.tool_name == self.tool.name:
            return None
        return Finding("action.needs-tool", tool=tr("Select"))

    def nothing_chosen(self) -> Finding | None:
        if (reason := self.not_selecting()) is not None:
            return reason
        return None if self.tool.count else Finding("action.no-elements")

    def no_model(self) -> Finding | None:
        if (reason := self.not_selecting()) is not None:
            return reason
        return None if self.tool.changes.data() is not None else Finding("action.no-elements")

    def nothing_hidden(self) -> Finding | None:
        return None if self.tool.changes.anything_hidden() else Finding("action.nothing-hidden")

    def patch(self) -> Patch | None:
        """The last one that is selected."""
        studio = self._studio
        found = (get(studio.records, i, Patch) for i in reversed(studio.selection.ids))
        return next((each for each in found if each is not None), None)

    def no_patch(self) -> Finding | None:
        if (reason := self.not_selecting()) is not None:
            return reason
        return None if self.patch() is not None else Finding("selection.no-patch")

    def take_patch(self) -> None:
        if (found := self.patch()) is not None:
            self.tool.changes.take_patch(found)

    # --- its commands ------------------------------------------------------------------------
    def way(self, way: SelectMode) -> Command:
        icon, key, tip = WAYS[way]
        return Command(
            f"select_{way}",
            tr(STEPS[way]),
            lambda: self.tool.set_mode(way),
            icon,
            key,
            tr(tip),
            self.not_selecting,
            is_viewport_key=True,
            is_checked=lambda: self.tool.mode == way,
        )

    def combine(self, how: Combine) -> Command:
        icon, tip = _COMBINE[how]
        return Command(
            f"select_{how}",
            tr(COMBINATIONS[how]),
            lambda: self.tool.set_combine(how),
            icon,
            (),
            tr(tip),
            self.not_selecting,
            is_checked=lambda: self.tool.combine == how,
        )


def commands(studio: Studio) -> list[Command]:
    """The commands that the tool adds to the menu Interpret."""
    now = _Selecting(studio)
    tool, changes = now.tool, now.tool.changes

    def plain(
        name: str,
        text: str,
        run: Callable[[], object],
        icon: str,
        key: Keys,
        tip: str,
        why_not: Callable[[], Finding | None] = now.nothing_chosen,
    ) -> Command:
        return Command(name, text, run, icon, key, tip, why_not, is_viewport_key=bool(key))

    return [
        *(now.way(way) for way in WAYS),
        *(now.combine(how) for how in _COMBINE),
        Command(
            "select_through",
            tr("Through the surface"),
            lambda: tool.set_through(not tool.through),
            "layers-outline",
            "V",
            tr("Shapes take what is hidden too; else only what is seen."),
            now.not_selecting,
            is_viewport_key=True,
            is_checked=lambda: tool.through,
        ),
        plain(
            "select_wider",
            tr("Widen"),
            changes.wider,
            "arrow-expand-all",
            ("+", "="),
            tr("With those beside the chosen ones."),
        ),
        plain(
            "select_narrower",
            tr("Narrow"),
            changes.narrower,
            "arrow-collapse-all",
            "-",
            tr("Without those at the edge of what is chosen."),
        ),
        plain(
            "select_invert",
            tr("Invert"),
            changes.invert,
            "select-inverse",
            "Shift+I",
            tr("What is not chosen, in place of what is."),
        ),
        plain(
            "select_everything",
            tr("Choose all"),
            changes.everything,
            "select-all",
            (),
            tr("Every face or point of the model."),
            now.no_model,
        ),
        plain(
            "select_patch",
            tr("Take patch"),
            now.take_patch,
            "texture-box",
            (),
            tr("The faces or points of the selected patch."),
            now.no_patch,
        ),
        plain(
            "hide_elements",
            tr("Hide what is chosen"),
            tool.hide_selected,
            "eye-off-outline",
            "H",
            tr("Hides what is chosen of the model. Undo shows it again."),
        ),
        plain(
            "isolate_elements",
            tr("Isolate what is chosen"),
            changes.isolate,
            "eye-outline",
            "Shift+H",
            tr("Hides all of the model but what is chosen. Earlier view (Shift+Z) shows it again."),
        ),
        plain(
            "show_elements",
            tr("Show hidden"),
            changes.show_all,
            "eye",
            "U",
            tr("Shows every face and point again. Undo hides them."),
            now.nothing_hidden,
        ),
        plain(
            "cut_out",
            tr("Cut out"),
            changes.cut_out,
            "scissors-cutting",
            (),
            tr("Makes a model of what is chosen, with its textures. The original stays."),
        ),
    ]
