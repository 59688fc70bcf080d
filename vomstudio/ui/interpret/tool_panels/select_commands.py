"""Commands on what is chosen of a surface."""

from __future__ import annotations

from vomstudio.tools.chosen_elements import COMBINATIONS, Combine
from vomstudio.tools.select import SelectTool
from vomstudio.tools.select_words import STEPS, Way
from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.words import to_translate, tr

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

    return [
        *(way_command(way) for way in WAYS),
        *(combine_command(how) for how in _COMBINE),
        Command("select_through", tr("Through the surface"),
                lambda: tool.set_through(not tool.through), "layers-outline", "V",
                tr("Shapes take what is hidden too; else only what is seen."), not_selecting,
                in_viewport=True, checked=lambda: tool.through),
    ]  # fmt: skip
