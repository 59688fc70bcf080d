"""Combo box for the property that a line follows between clicks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from PySide6.QtCore import QSignalBlocker

from vomstudio.core.findings import Finding
from vomstudio.core.options import find_declaration
from vomstudio.core.words import tr
from vomstudio.extraction.trace_options import COST_TITLES, FollowOptions
from vomstudio.studio.tools.followed_line import AUTO
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.options_form import fill_choices


def field_costs(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return the costs that follow low values of fields.

    Parameters
    ----------
    names : iterable of str
        Names of the fields.

    Returns
    -------
    list of (str, str)
        Title and value of each cost.
    """
    return [(tr("low values of {field}", field=name), name) for name in names]


class FollowBox(ComboBox):
    """List of costs and fields of the open models; the data of a straight line is None."""

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
                fill_choices(self, find_declaration(FollowOptions, "cost"), field_costs(fields))
                self.insertItem(0, tr("straight line"), None)
            cost_in_use = self._tool.effective_cost if self._tool.cost == AUTO else None
            automatic_title = tr(COST_TITLES[AUTO])
            if cost_in_use in COST_TITLES:
                automatic_title = tr("automatic: {cost}", cost=tr(COST_TITLES[cost_in_use]))
            self.setItemText(self.findData(AUTO), automatic_title)
            self.setCurrentIndex(max(0, self.findData(self._tool.cost)))
        set_enabled(self, Finding("follow.continued") if self._tool.is_continued else None)
