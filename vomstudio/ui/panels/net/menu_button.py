"""Button with the menu of overlays, displayed sets, bins and figure commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu, QToolButton

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import BINS, NetViewSettings

_OVERLAYS = {
    "averages": (
        to_translate("Mean values"),
        to_translate("Show n, mean, method, kappa and alpha95 of each set."),
    ),
    "girdles": (
        to_translate("Girdles"),
        to_translate("Draw the best-fit great circle of sets that form girdles."),
    ),
    "maxima": (
        to_translate("Maxima"),
        to_translate("Mark the density maximum of each set or of the contours."),
    ),
    "errors": (
        to_translate("All error ellipses"),
        to_translate("Draw the 95 % ellipses of up to 500 planes and lines."),
    ),
    "intersections": (
        to_translate("Intersections"),
        to_translate("Draw all intersections of up to 300 planes."),
    ),
    "slip planes": (
        to_translate("Planes of striae"),
        to_translate("Draw the planes that contain lineations, as great circles."),
    ),
}


class NetMenuButton(QToolButton):
    """Button with the menu of the net.

    Parameters
    ----------
    names : callable
        Returns the names of all sets, including hidden ones.
    edit_drawings : callable
        Opens the dialog for typed circles and lines, the rotation and the contour levels.
    final_actions : sequence of QAction
        Actions at the end of the menu.
    """

    def __init__(
        self,
        studio: Studio,
        view_settings: NetViewSettings,
        names: Callable[[], Sequence[str]],
        edit_drawings: Callable[[], None],
        final_actions: Sequence[QAction],
    ) -> None:
        super().__init__()
        self._view_settings, self._names = view_settings, names
        tooltip = tr("More: elements, sets, rotation, figure")
        self.setIcon(theme.icon("dots-horizontal"))
        self.setToolTip(tooltip)
        self.setAccessibleName(tooltip)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(self._show_settings)
        self.overlays: dict[str, QAction] = {}
        for name, (title, tooltip) in _OVERLAYS.items():
            action = menu.addAction(tr(title))
            action.setToolTip(tr(tooltip))
            action.setCheckable(True)
            action.triggered.connect(
                lambda is_checked, n=name: view_settings.show_overlay(n, is_checked)
            )
            self.overlays[name] = action
        menu.addSeparator()
        self.drawing_action = menu.addAction(tr("Draw and rotate…"))
        self.drawing_action.triggered.connect(lambda _: edit_drawings())
        self.sets = menu.addMenu(tr("Visible sets"))
        self.bins = menu.addMenu(tr("Rose bins"))
        self._fill_bins()
        menu.addSeparator()
        menu.addActions(list(final_actions))
        self.setMenu(menu)
        studio.settings_changed.connect(self._show_settings)
        self._show_settings()

    def _fill_bins(self) -> None:
        group = QActionGroup(self)
        self.widths: dict[float, QAction] = {}
        for width in BINS:
            action = self.bins.addAction(f"{width:g}°")
            action.setCheckable(True)
            group.addAction(action)
            action.triggered.connect(lambda _=False, w=width: self._view_settings.set_bins(w))
            self.widths[width] = action
        self.bins.addSeparator()
        self.length_weight_action = self.bins.addAction(tr("Weighted by length"))
        self.area_scale_action = self.bins.addAction(tr("Scale by area"))
        for action in (self.length_weight_action, self.area_scale_action):
            action.setCheckable(True)
        view_settings = self._view_settings
        self.length_weight_action.triggered.connect(
            lambda is_checked: view_settings.set_bins(
                view_settings.bin_deg, is_length_weighted=is_checked
            )
        )
        self.area_scale_action.triggered.connect(
            lambda is_checked: view_settings.set_bins(
                view_settings.bin_deg, is_area_scaled=is_checked
            )
        )

    def _show_settings(self) -> None:
        view_settings, is_net = self._view_settings, self._view_settings.view == "net"
        for name, action in self.overlays.items():
            action.setChecked(name in view_settings.overlays)
            action.setEnabled(is_net)
            tooltip = tr(_OVERLAYS[name][1])
            action.setToolTip(tooltip if is_net else Finding("net.only", what=tooltip).message)
        self.widths[view_settings.bin_deg].setChecked(True)
        self.length_weight_action.setChecked(view_settings.is_length_weighted)
        self.area_scale_action.setChecked(view_settings.is_area_scaled)
        self.bins.setEnabled(not is_net)
        self.bins.menuAction().setToolTip(
            tr("Not now: {reason}", reason=Finding("action.no-bins")) if is_net else ""
        )
        self._list_sets()

    def _list_sets(self) -> None:
        self.sets.clear()
        names = list(dict.fromkeys(self._names()))
        for name in names:
            action = self.sets.addAction(name.replace("&", "&&"))
            action.setCheckable(True)
            action.setChecked(name not in self._view_settings.hidden_sets)
            action.triggered.connect(
                lambda is_checked, n=name: self._view_settings.show_set(n, is_checked)
            )
        if self._view_settings.hidden_sets:
            self.sets.addSeparator()
            self.sets.addAction(tr("Show all")).triggered.connect(
                lambda _: self._view_settings.show_all()
            )
        self.sets.setEnabled(bool(names))
        empty_text = tr("Not now: {reason}", reason=Finding("action.net-empty"))
        self.sets.menuAction().setToolTip("" if names else empty_text)
