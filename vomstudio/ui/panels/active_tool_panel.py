"""Panel that shows the controls of the active tool."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from PySide6.QtWidgets import QSizePolicy, QStackedWidget, QWidget

from vomstudio.core.words import tr
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.type_box import TypeBox

Panel = TypeVar("Panel", bound=QWidget)


class ActiveToolPanel(QStackedWidget):
    """Stack that shows the panel of the active tool or of the unfinished feature.

    If neither exists, it shows a hint. Its initial width fits the widest panel.
    """

    def __init__(self, studio: Studio, panels: Mapping[str, QWidget]) -> None:
        """Add the panels of the tools; the keys of `panels` are tool names."""
        super().__init__()
        self._studio, self.panels = studio, dict(panels)
        self._empty_page = QWidget()
        column = narrow_column(self._empty_page)
        column.addWidget(
            hint_label(tr("No tool is active: drag to orbit, click a feature to select it."))
        )
        column.addStretch()
        self.addWidget(self._empty_page)
        for panel in dict.fromkeys(self.panels.values()):
            self.addWidget(panel)
        boxes = {panel: getattr(panel, "type_box", None) for panel in self.panels.values()}
        self._type_boxes = {panel: box for panel, box in boxes.items() if isinstance(box, TypeBox)}
        self._titles = {entry.name: entry.title for entry in TOOLS}
        self._show_title: Callable[[str], None] = lambda _: None
        # The dock is initially as wide as the widest panel, so that the outcrop does not move
        # later.
        self._fit_page(self._empty_page, QSizePolicy.Policy.Preferred)
        studio.active_tool_changed.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.project_opened.connect(self.refresh)

    def set_title_callback(self, callback: Callable[[str], None]) -> None:
        """Set the function that is called with the dock title at every refresh."""
        self._show_title = callback
        self.refresh()

    def panel(self, panel_class: type[Panel]) -> Panel:
        """Return the panel of the given class."""
        return next(panel for panel in self.panels.values() if isinstance(panel, panel_class))

    def type_box(self) -> TypeBox | None:
        """Return the type box of the visible panel, or None if it has no enabled box."""
        panel = self.currentWidget()
        box = None if panel is None else self._type_boxes.get(panel)
        return box if box is not None and box.isEnabled() else None

    def refresh(self, *_: object) -> None:
        """Show the panel of the active tool or of the unfinished feature, or the hint."""
        name = self._studio.tool_name
        if name not in self.panels:
            open_tool = self._studio.open_tool
            name = "" if open_tool is None else open_tool.name
        page = self.panels.get(name, self._empty_page)
        self._show_title(self._titles.get(name, tr("Tool")))
        if page is self.currentWidget():
            return
        self._fit_page(page)
        self.setCurrentWidget(page)

    def _fit_page(
        self, current_page: QWidget, other_width: QSizePolicy.Policy = QSizePolicy.Policy.Ignored
    ) -> None:
        """Exclude hidden pages from the size of the stack, so that they add no scroll bar."""
        ignored_policy, preferred_policy = QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred
        for page in (self._empty_page, *self.panels.values()):
            if page is current_page:
                page.setSizePolicy(preferred_policy, preferred_policy)
            else:
                page.setSizePolicy(other_width, ignored_policy)
