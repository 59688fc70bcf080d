"""The box in which the user chooses what the dock of the net shows: a net, roses or histograms."""

from __future__ import annotations

from vomstudio.core.words import to_translate, tr
from vomstudio.products.net.rose import TITLES
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import NetWishes

_NETS = (("area", to_translate("Equal area")), ("angle", to_translate("Equal angle")))
_SHORT = {
    "strike": to_translate("Rose of strikes"),
    "dip-direction": to_translate("Rose of dip directions"),
    "trend": to_translate("Rose of trends"),
    "dip": to_translate("Histogram of dips"),
    "plunge": to_translate("Histogram of plunges"),
}
assert _SHORT.keys() == TITLES.keys()


class NetViewBox(ComboBox):
    """Keeps what is chosen in the settings, which tell the net."""

    def __init__(self, studio: Studio, wishes: NetWishes) -> None:
        super().__init__()
        self._studio, self._wishes = studio, wishes
        self.setAccessibleName(tr("View"))
        for projection, title in _NETS:
            self.addItem(tr(title), ("net", projection))
        self.insertSeparator(self.count())
        for of, title in _SHORT.items():
            self.addItem(tr(title), (of, ""))
        self.keep_narrow()
        self.activated.connect(lambda _: wishes.show_view(*self.currentData()))
        studio.settings_changed.connect(self._show)
        self._show()

    def _show(self) -> None:
        projection = self._studio.settings.projection
        wanted = (self._wishes.view, projection if self._wishes.view == "net" else "")
        for row in range(self.count()):
            if self.itemData(row) is not None and tuple(self.itemData(row)) == wanted:
                self.setCurrentIndex(row)

    @property
    def projection(self) -> str:
        wanted = self._studio.settings.projection
        return wanted if wanted in dict(_NETS) else "area"
