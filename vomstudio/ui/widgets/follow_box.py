"""Combo box for the property that a line follows between clicks."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.followed_line import AUTO
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.ui.base.controls import ComboBox, allow
from vomstudio.ui.base.studio import Studio

COST_TITLES = (
    (None, to_translate("straight line")),
    (AUTO, to_translate("automatic")),
    ("colour", to_translate("same colour")),
    ("dark", to_translate("dark line")),
    ("light", to_translate("light line")),
    ("gradient", to_translate("brightness edge")),
    ("curvature", to_translate("surface edge")),
)


class FollowBox(ComboBox):
    """List of costs and of the open models' fields, with the data None for a straight line."""

    def __init__(self, studio: Studio, tool: FollowingTool[Any]) -> None:
        super().__init__()
        self.setObjectName(f"{tool.name}_follow")
        self._studio, self._tool = studio, tool
        self._fields: tuple[str, ...] | None = None
        self.setToolTip(tr("Path of the line between clicks (Shift+T)."))
        self.refresh()
        self.currentIndexChanged.connect(lambda _: self._tool.follow(self.currentData()))

    def refresh(self) -> None:
        """Show the current cost of the tool."""
        fields = tuple(
            sorted({name for model in self._studio.models.values() for name in model.data.fields})
        )
        with QSignalBlocker(self):
            if fields != self._fields:
                self._fields = fields
                self.clear()
                for cost, title in COST_TITLES:
                    self.addItem(tr(title), cost)
                for name in fields:
                    self.addItem(tr("low values of {field}", field=name), name)
            titles = dict(COST_TITLES)
            cost_in_use = self._tool.followed_by if self._tool.cost == AUTO else None
            best_cost_name = tr(titles[AUTO])
            if cost_in_use is not None and cost_in_use in titles:
                best_cost_name = tr("automatic: {cost}", cost=tr(titles[cost_in_use]))
            self.setItemText(self.findData(AUTO), best_cost_name)
            self.setCurrentIndex(max(0, self.findData(self._tool.cost)))
        allow(self, Finding("follow.continued") if self._tool.continued else None)
