"""Button with the menu of density contours."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenu, QToolButton

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.density import DENSITY_METHODS, SIGMA
from vomstudio.products.net.contents import Contouring
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import NetViewSettings

_METHODS = {
    "": to_translate("No contours"),
    "exponential_kamb": to_translate("Kamb, exponential kernel"),
    "linear_kamb": to_translate("Kamb, linear kernel"),
    "kamb": to_translate("Kamb, plain count"),
    "schmidt": to_translate("Schmidt, 1 % of the area"),
}


_SIGMAS = (1.0, 2.0, 3.0, 4.0, 6.0)
"""Menu choices of the smoothing, in sigmas; a larger value smooths more."""


class ContourButton(QToolButton):
    """Button that selects the contouring method and stores it in the settings.

    Parameters
    ----------
    studio : Studio
    view_settings : NetViewSettings
        Settings that contain the contoured type.
    types : callable
        Returns the names of the types on the net.
    """

    def __init__(
        self, studio: Studio, view_settings: NetViewSettings, types: Callable[[], Sequence[str]]
    ) -> None:
        super().__init__()
        self._studio, self._view_settings, self._types = studio, view_settings, types
        tooltip = tr("Density contours of poles and lines")
        self.setIcon(theme.icon("chart-bell-curve-cumulative"))
        self.setToolTip(tooltip)
        self.setAccessibleName(tooltip)
        self.setCheckable(True)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        theme.highlight_toggles(self)
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        group = QActionGroup(self)
        self.methods = {}
        for method, title in _METHODS.items():
            action = menu.addAction(tr(title))
            action.setCheckable(True)
            group.addAction(action)
            action.triggered.connect(lambda _=False, m=method: self._store_method(m))
            self.methods[method] = action
        menu.addSeparator()
        self.fill_action = menu.addAction(tr("Filled"))
        self.each_set_action = menu.addAction(tr("Each set separately"))
        for action in (self.fill_action, self.each_set_action):
            action.setCheckable(True)
            action.triggered.connect(lambda _=False: self._store_method(self.method or None))
        self.subject = menu.addMenu(tr("Contoured type"))
        self.smoothness = menu.addMenu(tr("Kamb smoothness"))
        sigmas = QActionGroup(self)
        self.sigmas = {}
        for sigma in _SIGMAS:
            number = f"{sigma:g}"
            default_title = tr("{sigma} σ (default)", sigma=number)
            action = self.smoothness.addAction(default_title if sigma == SIGMA else f"{number} σ")
            action.setCheckable(True)
            sigmas.addAction(action)
            action.triggered.connect(lambda _=False, s=sigma: self._store_sigma(s))
            self.sigmas[sigma] = action
        menu.aboutToShow.connect(self._list_types)
        self.setMenu(menu)
        self._show_settings()
        studio.settings_changed.connect(self._show_settings)

    @property
    def method(self) -> str | None:
        """One of `density.DENSITY_METHODS`, or None if no contours are drawn."""
        name = self._studio.settings.contour
        return name if name in DENSITY_METHODS else None

    @property
    def contouring(self) -> Contouring:
        settings = self._studio.settings
        return Contouring(
            filled=settings.contour_filled,
            each_set=settings.contour_each_set,
            sigma=settings.contour_sigma if settings.contour_sigma in _SIGMAS else SIGMA,
        )

    def nextCheckState(self) -> None:  # noqa: N802
        """Open the menu instead of toggling: the check state follows the contouring method."""
        self.showMenu()

    def _store_method(self, method: str | None) -> None:
        settings = self._studio.settings
        settings.contour = method or ""
        settings.contour_filled = self.fill_action.isChecked()
        settings.contour_each_set = self.each_set_action.isChecked()
        self._studio.keep_settings()

    def _store_sigma(self, sigma: float) -> None:
        self._studio.settings.contour_sigma = sigma
        self._studio.keep_settings()

    def _list_types(self) -> None:
        self.subject.clear()
        group = QActionGroup(self.subject)
        choices: list[tuple[str, str | None]] = [
            (tr("Most frequent type"), ""),
            *((name.replace("&", "&&"), name) for name in self._types()),
            (tr("All sets"), None),
        ]
        for title, name in choices:
            action = self.subject.addAction(title)
            action.setCheckable(True)
            action.setChecked(name == self._view_settings.contoured_type)
            group.addAction(action)
            action.triggered.connect(
                lambda _=False, n=name: self._view_settings.select_contoured_type(n)
            )
        self.subject.setEnabled(self.method is not None and not self.each_set_action.isChecked())

    def _show_settings(self) -> None:
        settings = self._studio.settings
        self.methods[self.method or ""].setChecked(True)
        self.fill_action.setChecked(settings.contour_filled)
        self.each_set_action.setChecked(settings.contour_each_set)
        disabled_tip = tr("Not now: {reason}", reason=Finding("action.no-contours"))
        for action in (self.fill_action, self.each_set_action):
            action.setEnabled(self.method is not None)
            action.setToolTip("" if self.method else disabled_tip)
        self.sigmas[self.contouring.sigma].setChecked(True)
        is_smoothed = self.method not in (None, "schmidt")
        self.smoothness.setEnabled(is_smoothed)
        self.smoothness.menuAction().setToolTip(
            "" if is_smoothed else tr("Not now: {reason}", reason=Finding("action.not-smoothed"))
        )
        # The button looks pressed while contours are drawn.
        self.setChecked(self.method is not None)
