"""Commands that show a page of the surface panel."""

from __future__ import annotations

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_model_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks

_DOCK_NAME = "surface"


def commands(studio: Studio, docks: Docks) -> list[Command]:
    """Create the commands, which show the panel in the current workspace."""

    def show(page: str) -> None:
        docks.bring_forward(_DOCK_NAME)
        studio.surface_page_requested.emit(page)

    def model_finding() -> Finding | None:
        return missing_model_finding(studio)

    return [
        Command(
            "surface_fields",
            tr("Surface f&ields…"),
            lambda: show("fields"),
            icon="palette-outline",
            tip=tr("Colour the outcrop by dip, dip direction, curvature, roughness or planarity."),
            disabled_reason=model_finding,
        ),
        Command(
            "propose_facets",
            tr("Propose fa&cets…"),
            lambda: show("facets"),
            icon="vector-polygon",
            tip=tr("Find near-planar parts of the outcrop, and accept or reject each."),
            disabled_reason=model_finding,
        ),
        Command(
            "propose_traces",
            tr("Propose &traces…"),
            lambda: show("traces"),
            icon="vector-polyline",
            tip=tr("Find significant lines on the outcrop, and accept or reject each."),
            disabled_reason=model_finding,
        ),
    ]
