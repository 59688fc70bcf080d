"""Commands of lines, dimensions and intersections."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.chosen import why_no_model
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.interpret import relations
from vomstudio.ui.scene.view_panel import ViewPanel


def commands(studio: Studio, directions: ViewPanel, parent: QWidget) -> list[Command]:
    """parent : of the dialogs."""

    def not_loaded() -> str | None:
        return why_no_model(studio)

    def too_few_groups() -> str | None:
        if len(relations.groups_of(studio)) > 1:
            return None
        return "pick planes of two feature types or sets first"

    def ask_for_sets() -> None:
        relations.IntersectionDialog(studio, parent).open()

    return [
        Command("line", "&Line", lambda: studio.activate("line"), "arrow-top-right", "L",
                "Click along a striation, hinge or other lineation: trend, plunge, rake on a plane",
                not_loaded, in_viewport=True, checked=lambda: studio.tool_name == "line"),
        Command("measure", "&Measure", lambda: studio.activate("measure"), "ruler", "M",
                "Distance, length, area, thickness across a plane",
                not_loaded, in_viewport=True, checked=lambda: studio.tool_name == "measure"),
        Command("keep_intersection", "&Keep intersection", lambda: relations.keep(studio),
                "vector-intersection", (),
                "The line where the two selected planes meet, as a feature with its error",
                lambda: relations.why_not_keep(studio)),
        Command("intersection_of_sets", "&Intersection of sets…", ask_for_sets,
                "vector-intersection", (),
                "Where the mean planes of two types or sets meet, such as bedding and fault",
                too_few_groups),
        Command("along_line", "Look along the &line", directions.along_line, None, "I",
                "Orthographic view down the selected lineation or intersection",
                directions.why_no_line, in_viewport=True),
    ]  # fmt: skip
