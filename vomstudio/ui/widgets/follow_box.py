"""A combo box of what a line follows between clicks."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.followed_line import AUTO
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.ui.base.controls import ComboBox, allow
from vomstudio.ui.base.studio import Studio

COSTS = (
    (None, to_translate("nothing: straight between clicks")),
    (AUTO, to_translate("the best of all that follow")),
    ("colour", to_translate("colour like that at the clicks")),
    ("dark", to_translate("dark")),
    ("light", to_translate("light")),
    ("gradient", to_translate("edges of lightness")),
    ("curvature", to_translate("edges of the surface")),
)


class FollowBox(ComboBox):
    """`currentData` is a cost, None for none; the fields of the open models stand below."""

    def __init__(self, studio: Studio, tool: FollowingTool[Any]) -> None:
        super().__init__()
        self.setObjectName(f"{tool.name}_follow")
        self._studio, self._tool = studio, tool
        self._shown: tuple[str, ...] | None = None
        self.setToolTip(tr("What the line follows over the surface from click to click (Shift+T)."))
        self.refresh()
        self.currentIndexChanged.connect(lambda _: self._tool.follow(self.currentData()))

    def refresh(self) -> None:
        """Show what the tool follows now."""
        fields = tuple(
            sorted({name for one in self._studio.models.values() for name in one.data.fields})
        )
        with QSignalBlocker(self):
            if fields != self._shown:
                self._shown = fields
                self.clear()
                for cost, words in COSTS:
                    self.addItem(tr(words), cost)
                for name in fields:
                    self.addItem(tr("low values of {field}", field=name), name)
            called = dict(COSTS)
            now = self._tool.followed_by if self._tool.cost == AUTO else None
            best = tr(called[AUTO])
            if now is not None and now in called:
                best = tr("the best of all: {cost}", cost=tr(called[now]))
            self.setItemText(self.findData(AUTO), best)
            self.setCurrentIndex(max(0, self.findData(self._tool.cost)))
        allow(self, Finding("follow.continued") if self._tool.continued else None)
