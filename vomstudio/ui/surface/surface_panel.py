"""The dock of the surface: its fields, and the facets and traces that are proposed on it."""

from __future__ import annotations

from PySide6.QtWidgets import QTabWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.widgets import Scrolling
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
        self.traces = TracesPanel(studio)
        # Each scrolls by itself: a page of tabs is not told how high its words are.
        self._pages = {
            "fields": Scrolling(self.fields),
            "facets": Scrolling(self.facets),
            "traces": Scrolling(self.traces),
        }
        self.addTab(self._pages["fields"], tr("Fields"))
        self.addTab(self._pages["facets"], tr("Facets"))
        self.addTab(self._pages["traces"], tr("Proposed traces"))
        studio.surface_wanted.connect(self._bring)

    def _bring(self, page: str) -> None:
        self.setCurrentWidget(self._pages[page])


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
