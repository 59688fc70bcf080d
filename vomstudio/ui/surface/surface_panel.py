"""The dock of the surface: its fields, and the facets and traces that are proposed on it."""

from __future__ import annotations

from PySide6.QtWidgets import QTabWidget, QWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.window_protocols import Docks
from vomstudio.ui.surface.facets_panel import FacetsPanel
from vomstudio.ui.surface.fields_panel import FieldsPanel
from vomstudio.ui.surface.traces_panel import TracesPanel
from vomstudio.words import tr

_DOCK = "surface"


class SurfacePanel(QTabWidget):
    """A page for each."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self.setDocumentMode(True)
        self.fields, self.facets = FieldsPanel(studio), FacetsPanel(studio)
        self.addTab(self.fields, tr("Fields"))
        self.traces = TracesPanel(studio)
        self.addTab(self.facets, tr("Facets"))
        self.addTab(self.traces, tr("Proposed traces"))
        studio.surface_wanted.connect(self._bring)

    def _bring(self, page: str) -> None:
        pages: dict[str, QWidget] = {"facets": self.facets, "traces": self.traces}
        self.setCurrentWidget(pages.get(page, self.fields))


def commands(studio: Studio, docks: Docks) -> list[Command]:
    """They show the dock in the workspace where somebody is."""

    def show(page: str) -> None:
        docks.bring_forward(_DOCK)
        studio.surface_wanted.emit(page)

    def no_model() -> str | None:
        return None if studio.models else tr("Open a model first.")

    return [
        Command("surface_fields", tr("Surface f&ields…"), lambda: show("fields"),
                "palette-outline", (),
                tr("Paint dip, dip direction, curvature, roughness or planarity on the outcrop."),
                no_model),
        Command("propose_facets", tr("Propose fa&cets…"), lambda: show("facets"),
                "vector-polygon", (),
                tr("Find near-planar pieces of the outcrop, look at them, and accept or reject "
                   "each."), no_model),
        Command("propose_traces", tr("Propose &traces…"), lambda: show("traces"),
                "vector-polyline", (),
                tr("Look for lines that stand out of the noise, and accept, edit or reject each."),
                no_model),
    ]  # fmt: skip
