"""The button of the net whose menu holds what else can be drawn, counted and written."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu, QToolButton

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.view_settings import BINS, NetWishes

_ASKED = {
    "averages": (
        to_translate("Averages in words"),
        to_translate("n, mean with its method, kappa and alpha95 of each set, under the legend."),
    ),
    "girdles": (
        to_translate("Girdles"),
        to_translate("The great circle that each set fits best, where it is no cluster."),
    ),
    "maxima": (
        to_translate("Densest places"),
        to_translate("Where each set, or all as contoured, is densest, and how dense."),
    ),
    "errors": (
        to_translate("Error ellipses of all"),
        to_translate("The 95 % ellipse of each plane and line, of at most 500."),
    ),
    "intersections": (
        to_translate("Intersections"),
        to_translate("The lines in which each two planes meet, of at most 300 planes."),
    ),
    "slip planes": (
        to_translate("Planes of striae"),
        to_translate("The great circles of the planes on which the rakes of lines are counted."),
    ),
}


class NetMenuButton(QToolButton):
    """names : of the sets that the net has now, hidden or not. last : at the end of the menu"""

    def __init__(
        self,
        studio: Studio,
        wishes: NetWishes,
        names: Callable[[], Sequence[str]],
        type_in: Callable[[], None],
        last: Sequence[QAction],
    ) -> None:
        super().__init__()
        self._wishes, self._names = wishes, names
        tip = tr("More: what is drawn, sets shown, turning, figure")
        self.setIcon(theme.icon("dots-horizontal"))
        self.setToolTip(tip)
        self.setAccessibleName(tip)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(self._show)
        self.asked: dict[str, QAction] = {}
        for name, (title, about) in _ASKED.items():
            action = menu.addAction(tr(title))
            action.setToolTip(tr(about))
            action.setCheckable(True)
            action.triggered.connect(lambda on, n=name: wishes.ask(n, on))
            self.asked[name] = action
        menu.addSeparator()
        self.typed = menu.addAction(tr("Type circles, lines, turning, levels…"))
        self.typed.triggered.connect(lambda _: type_in())
        self.sets = menu.addMenu(tr("Sets shown"))
        self.bins = menu.addMenu(tr("Bins of roses and histograms"))
        self._fill_bins()
        menu.addSeparator()
        menu.addActions(list(last))
        self.setMenu(menu)
        studio.settings_changed.connect(self._show)
        self._show()

    def _fill_bins(self) -> None:
        group = QActionGroup(self)
        self.widths: dict[float, QAction] = {}
        for width in BINS:
            action = self.bins.addAction(f"{width:g}°")
            action.setCheckable(True)
            group.addAction(action)
            action.triggered.connect(lambda _=False, w=width: self._wishes.count_by(w))
            self.widths[width] = action
        self.bins.addSeparator()
        self.by_length = self.bins.addAction(tr("Weighted by length"))
        self.by_area = self.bins.addAction(tr("Areas to scale (else lengths)"))
        for action in (self.by_length, self.by_area):
            action.setCheckable(True)
        wishes = self._wishes
        self.by_length.triggered.connect(lambda on: wishes.count_by(wishes.bin_deg, by_length=on))
        self.by_area.triggered.connect(lambda on: wishes.count_by(wishes.bin_deg, by_area=on))

    def _show(self) -> None:
        wishes, net = self._wishes, self._wishes.view == "net"
        for name, action in self.asked.items():
            action.setChecked(name in wishes.asked)
            action.setEnabled(net)
            about = tr(_ASKED[name][1])
            action.setToolTip(about if net else Finding("net.only", what=about).message)
        self.widths[wishes.bin_deg].setChecked(True)
        self.by_length.setChecked(wishes.by_length)
        self.by_area.setChecked(wishes.by_area)
        self.bins.setEnabled(not net)
        self.bins.menuAction().setToolTip(
            tr("Not now: {reason}", reason=Finding("action.no-bins")) if net else ""
        )
        self._list_sets()

    def _list_sets(self) -> None:
        self.sets.clear()
        names = list(dict.fromkeys(self._names()))
        for name in names:
            action = self.sets.addAction(name.replace("&", "&&"))
            action.setCheckable(True)
            action.setChecked(name not in self._wishes.hidden)
            action.triggered.connect(lambda on, n=name: self._wishes.show_set(n, on))
        if self._wishes.hidden:
            self.sets.addSeparator()
            self.sets.addAction(tr("Show all")).triggered.connect(lambda _: self._wishes.show_all())
        self.sets.setEnabled(bool(names))
        empty = tr("Not now: {reason}", reason=Finding("action.net-empty"))
        self.sets.menuAction().setToolTip("" if names else empty)
