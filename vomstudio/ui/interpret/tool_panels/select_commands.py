"""Commands on what is chosen of a surface."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.document.kinds.patch import Patch
from vomstudio.document.records import get
from vomstudio.tools.chosen_elements import COMBINATIONS, Combine
from vomstudio.tools.select import SelectTool
from vomstudio.tools.select_words import STEPS, Way
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.words import to_translate, tr

Keys = str | tuple[str, ...]

WAYS: dict[Way, tuple[str, str, str]] = {
    "grow": ("auto-fix", "G", to_translate(
        "A click takes the surface around it as far as it is even.")),
    "rectangle": ("select", "R", to_translate("A drag takes what lies inside a rectangle.")),
    "lasso": ("lasso", "A", to_translate("A drag takes what lies inside the line that is drawn.")),
    "polygon": ("vector-polygon", "Y", to_translate(
        "Clicks are the corners of a polygon; Enter takes what lies inside.")),
}  # fmt: skip
_COMBINE: dict[Combine, tuple[str, str]] = {
    "new": ("selection", to_translate("What is found takes the place of what is chosen.")),
    "add": ("vector-union", to_translate("What is found is added (Shift does so once).")),
    "subtract": ("vector-difference-ba", to_translate(
        "What is found is taken away (Ctrl does so once).")),
    "intersect": ("vector-intersection", to_translate(
        "Only what is found stays chosen (Ctrl+Shift does so once).")),
}  # fmt: skip


def commands(studio: Studio) -> list[Command]:
    """The commands that the tool adds to the menu Interpret."""
    tool = studio.tool_of(SelectTool)

    def not_selecting() -> str | None:
        if studio.tool_name == tool.name:
            return None
        return tr("Choose the tool Select on surface first.")

    def way_command(way: Way) -> Command:
        icon, key, tip = WAYS[way]
        return Command(
            f"select_{way}", tr(STEPS[way]), lambda: tool.set_way(way), icon, key, tr(tip),
            not_selecting, in_viewport=True, checked=lambda: tool.way == way,
        )  # fmt: skip

    def combine_command(how: Combine) -> Command:
        icon, tip = _COMBINE[how]
        return Command(
            f"select_{how}", tr(COMBINATIONS[how]), lambda: tool.set_combine(how), icon, (),
            tr(tip), not_selecting, checked=lambda: tool.combine == how,
        )  # fmt: skip

    def nothing_chosen() -> str | None:
        return not_selecting() or (None if tool.count else tr("Nothing is chosen."))

    def no_model() -> str | None:
        if (reason := not_selecting()) is not None:
            return reason
        if tool.changes.data() is None:
            return tr("Choose something first, to say which model is meant.")
        return None

    def nothing_hidden() -> str | None:
        return None if tool.changes.anything_hidden() else tr("No face and no point is hidden.")

    def patch() -> Patch | None:
        found = (get(studio.records, i, Patch) for i in reversed(studio.selection.ids))
        return next((each for each in found if each is not None), None)

    def no_patch() -> str | None:
        return not_selecting() or (None if patch() is not None else tr("Select a patch first."))

    def take_patch() -> None:
        if (found := patch()) is not None:
            tool.changes.take_patch(found)

    def plain(name: str, text: str, run: Callable[[], object], icon: str, key: Keys,
              tip: str, why_not: Callable[[], str | None]) -> Command:
        return Command(name, text, run, icon, key, tip, why_not, in_viewport=bool(key))

    changes = tool.changes
    return [
        *(way_command(way) for way in WAYS),
        *(combine_command(how) for how in _COMBINE),
        Command("select_through", tr("Through the surface"),
                lambda: tool.set_through(not tool.through), "layers-outline", "V",
                tr("Shapes take what is hidden too; else only what is seen."), not_selecting,
                in_viewport=True, checked=lambda: tool.through),
        plain("select_wider", tr("Widen"), changes.wider, "arrow-expand-all", ("+", "="),
              tr("With those beside the chosen ones."), nothing_chosen),
        plain("select_narrower", tr("Narrow"), changes.narrower, "arrow-collapse-all", "-",
              tr("Without those at the edge of what is chosen."), nothing_chosen),
        plain("select_invert", tr("Invert"), changes.invert, "select-inverse", "Shift+I",
              tr("What is not chosen, in place of what is."), nothing_chosen),
        plain("select_everything", tr("Whole model"), changes.everything, "select-all", (),
              tr("Every face or point of the model."), no_model),
        plain("select_patch", tr("Take patch"), take_patch, "texture-box", (),
              tr("The faces or points of the selected patch."), no_patch),
        plain("hide_elements", tr("Hide chosen"), tool.hide_chosen, "eye-off-outline", "H",
              tr("Hides what is chosen of the model. Undo shows it again."), nothing_chosen),
        plain("isolate_elements", tr("Isolate"), changes.isolate, "eye-outline", "Shift+H",
              tr("Hides all of the model but what is chosen."), nothing_chosen),
        plain("show_elements", tr("Show hidden"), changes.show_all, "eye", "U",
              tr("Shows every face and point again."), nothing_hidden),
        plain("cut_out", tr("Cut out as model"), changes.cut_out, "scissors-cutting", (),
              tr("Makes a model of what is chosen, with its textures. The original stays."),
              nothing_chosen),
    ]  # fmt: skip
