"""The commands that show a page of the surface's panel."""

from __future__ import annotations

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import why_no_model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks

_DOCK = "surface"


def commands(studio: Studio, docks: Docks) -> list[Command]:
    """They show the dock in the workspace where somebody is."""

    def show(page: str) -> None:
        docks.bring_forward(_DOCK)
        studio.surface_page_requested.emit(page)

    def no_model() -> Finding | None:
        return why_no_model(studio)

    return [
        Command(
            "surface_fields",
            tr("Surface f&ields…"),
            lambda: show("fields"),
            "palette-outline",
            (),
            tr("Paint dip, dip direction, curvature, roughness or planarity on the outcrop."),
            no_model,
        ),
        Command(
            "propose_facets",
            tr("Propose fa&cets…"),
            lambda: show("facets"),
            "vector-polygon",
            (),
            tr("Find near-planar pieces of the outcrop, look at them, and accept or reject each."),
            no_model,
        ),
        Command(
            "propose_traces",
            tr("Propose &traces…"),
            lambda: show("traces"),
            "vector-polyline",
            (),
            tr("Look for lines that stand out of the noise, and accept, edit or reject each."),
            no_model,
        ),
    ]
