"""Surface panel with the fields of the surface and proposed facets and traces."""

from __future__ import annotations

from PySide6.QtWidgets import QTabWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import PanelScrollArea
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.surface.facets_panel import FacetsPanel
from vomstudio.ui.panels.surface.fields_panel import FieldsPanel
from vomstudio.ui.panels.surface.traces_panel import TracesPanel


class SurfacePanel(QTabWidget):
    """Tab widget with pages for fields, facets and traces."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self.setDocumentMode(True)
        self.tabBar().setUsesScrollButtons(False)
        self.fields, self.facets = FieldsPanel(studio), FacetsPanel(studio)
        self.traces = TracesPanel(studio)
        # Each page has its own scroll area, since tabs do not support height for width.
        self._pages = {
            "fields": PanelScrollArea(self.fields),
            "facets": PanelScrollArea(self.facets),
            "traces": PanelScrollArea(self.traces),
        }
        self.addTab(self._pages["fields"], tr("Fields"))
        self.addTab(self._pages["facets"], tr("Facets"))
        self.addTab(self._pages["traces"], tr("Traces"))
        studio.surface_page_requested.connect(self._show_page)

    def _show_page(self, page: str) -> None:
        self.setCurrentWidget(self._pages[page])
