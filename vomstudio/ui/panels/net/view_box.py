"""Combo box that selects the view of the net panel: a net, roses or histograms."""

from __future__ import annotations

from vomstudio.core.words import to_translate, tr
from vomstudio.products.net.rose import TITLES
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import NetViewSettings

_PROJECTIONS = (("area", to_translate("Equal area")), ("angle", to_translate("Equal angle")))
_ANGLE_TITLES = {
    "strike": to_translate("Rose of strikes"),
    "dip-direction": to_translate("Rose of dip directions"),
    "trend": to_translate("Rose of trends"),
    "dip": to_translate("Histogram of dips"),
    "plunge": to_translate("Histogram of plunges"),
}
assert _ANGLE_TITLES.keys() == TITLES.keys()


class NetViewBox(ComboBox):
    """Combo box that selects the view and stores it in the settings."""

    def __init__(self, studio: Studio, view_settings: NetViewSettings) -> None:
        super().__init__()
        self._studio, self._view_settings = studio, view_settings
        self.setAccessibleName(tr("View"))
        for projection, title in _PROJECTIONS:
            self.addItem(tr(title), ("net", projection))
        self.insertSeparator(self.count())
        for angle, title in _ANGLE_TITLES.items():
            self.addItem(tr(title), (angle, ""))
        self.keep_narrow()
        self.activated.connect(lambda _: view_settings.show_view(*self.currentData()))
        studio.settings_changed.connect(self._show_settings)
        self._show_settings()

    def _show_settings(self) -> None:
        projection = self._studio.settings.projection
        current = (
            self._view_settings.view,
            projection if self._view_settings.view == "net" else "",
        )
        for row in range(self.count()):
            if self.itemData(row) is not None and tuple(self.itemData(row)) == current:
                self.setCurrentIndex(row)

    @property
    def projection(self) -> str:
        projection = self._studio.settings.projection
        return projection if projection in dict(_PROJECTIONS) else "area"
