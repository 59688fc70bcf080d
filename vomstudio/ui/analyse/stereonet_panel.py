"""The stereonet dock: orientations of the project, linked with table, tree and 3-D view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QAction, QMouseEvent, QPalette
from PySide6.QtWidgets import (
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document.edit import Edit
from vomstudio.document.measurement import Measurement
from vomstudio.document.records import FeatureType, Typed, get_feature
from vomstudio.document.registration_errors import model_of, pole_region, turns_of
from vomstudio.document.straight_traces import band_of_measured
from vomstudio.errors import VomError
from vomstudio.geology.common_turns import Turns
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Plane
from vomstudio.products.net.contents import (
    AnyEllipse,
    NetBand,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    NetSet,
    means_of,
)
from vomstudio.products.net.figure import NetArtists
from vomstudio.products.net.style import NetStyle
from vomstudio.ui.analyse.contour_button import ContourButton
from vomstudio.ui.analyse.net_canvas import DPI, DrawnNet, NetCanvas, NetThread, Wanted
from vomstudio.ui.analyse.net_sets import Groups, alike, on_the_net, proposed_sets, sets_of
from vomstudio.ui.common import theme
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_formatting import natural
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.widgets import ComboBox, ElidedLabel
from vomstudio.words import tr

_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "diamond": "D", "pentagon": "p",
            "star": "*"}  # fmt: skip


# A press that moves further than this draws a lasso.
_CLICK_PX = 4
_FONT_PX = 12.0
# A redraw that takes long comes seldom: it must never hold up a row of picks.
_SOON_MS, _QUICK_MS, _LATEST_MS = 30, 60, 500
_MANY = 300
"""Orientations above which the net is drawn in a thread: Matplotlib takes 0.1 s for 5,000."""


class StereonetPanel(QWidget):
    """The net with its buttons. A click or a lasso selects features."""

    def __init__(self, studio: Studio, export: QAction, propose: QAction) -> None:
        super().__init__()
        explain(self, "numbers.md#the-net")
        self._studio = studio
        self._net: DrawnNet | None = None
        self.canvas = NetCanvas()
        self.canvas.setMinimumSize(220, 220)
        self.canvas.pressed.connect(self._pressed)
        self.canvas.moved.connect(self._moved)
        self.canvas.released.connect(self._released)
        self.canvas.left.connect(self._show_selected)
        self.canvas.painted.connect(self._painted)
        self.canvas.resized.connect(self._soon)
        self._thread = NetThread()
        self._thread.done.connect(self._drawn)
        self._wanted: Wanted | None = None
        self._stale = True
        self._path: list[tuple[float, float]] = []
        self._projection = ComboBox()
        self._projection.addItem(tr("Equal area"), "area")
        self._projection.addItem(tr("Equal angle"), "angle")
        self._projection.setCurrentIndex(self._projection.findData(studio.settings.projection))
        self._projection.activated.connect(self._chosen)
        self._circles = self._toggle(
            "circle-outline", tr("Great circles (hidden where there are many)"), True
        )
        self._poles = self._toggle("circle-medium", tr("Poles"), True)
        self._means = self._toggle("sigma", tr("Mean orientation of each type and set"), False)
        self._beta = self._toggle(
            "axis-arrow", tr("Fold axis (beta) and pi-plane of the bedding"), True
        )
        self.contours = ContourButton(studio)
        self._export = QToolButton()
        self._export.setDefaultAction(export)
        self.propose = QToolButton()
        self.propose.setDefaultAction(propose)
        self._groups: Groups | None = None
        self._under = ElidedLabel()
        self._under.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._under.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.addWidget(self._projection)
        toggles = (self._circles, self._poles, self._means, self._beta)
        for button in (*toggles, self.contours, self.propose, self._export):
            row.addWidget(button)
        row.addWidget(self._under, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.canvas, 1)
        layout.addLayout(row)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(_SOON_MS)
        self._timer.timeout.connect(self.redraw)
        self._emphasis = QTimer(self)
        self._emphasis.setSingleShot(True)
        self._emphasis.setInterval(_SOON_MS)
        self._emphasis.timeout.connect(self._emphasise)
        studio.project_opened.connect(self._soon)
        studio.edited.connect(self._edited)
        studio.visibility_changed.connect(lambda _: self._soon())
        studio.settings_changed.connect(self._soon)
        studio.sets_proposed.connect(self._proposed)
        studio.selection_changed.connect(lambda _: self._select())
        self._soon()

    def _toggle(self, icon: str, tip: str, on: bool) -> QToolButton:
        button = QToolButton()
        button.setIcon(theme.icon(icon))
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        button.setCheckable(True)
        theme.show_toggles(button)
        button.setChecked(on)
        button.toggled.connect(lambda _: self.redraw())
        return button

    def _soon(self) -> None:
        """Draw anew, once for all that happens meanwhile."""
        if not self._timer.isActive():
            self._timer.start()

    def _chosen(self) -> None:
        self._studio.settings.projection = str(self._projection.currentData())
        self._studio.keep_settings()

    def _proposed(self, groups: Groups | None) -> None:
        """Show these planes by their proposed sets, and nothing else, until there are none."""
        if groups != self._groups:
            self._groups = groups
            self._soon()

    def _edited(self, edit: Edit) -> None:
        if self._studio.affected(edit):
            self._soon()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        super().changeEvent(event)
        # The net has the colours of the theme. Qt sends this before all is made, too.
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_timer"):
            self._soon()

    def close_thread(self) -> None:
        """The program ends."""
        self._timer.stop()
        self._emphasis.stop()
        self._thread.close()

    @property
    def artists(self) -> NetArtists | None:
        """The net that is shown; None before the first."""
        return None if self._net is None else self._net.artists

    @property
    def up_to_date(self) -> bool:
        """Whether no other net is wanted or being drawn."""
        timed = self._timer.isActive() or self._emphasis.isActive()
        return not timed and self._wanted is None

    def _painted(self) -> None:
        if self._stale:
            self._soon()

    # --- drawing -----------------------------------------------------------------------------
    def contents(self) -> NetContents:
        """The visible planes and lines: one group for each feature type and set, and within it for
        planes, lines and compass readings."""
        studio = self._studio
        shown = {kind.id: studio.visible(kind.id) for kind in studio.session.of(FeatureType)}
        features = [
            f
            for f in studio.session.records.once(on_the_net)
            if shown.get(f.type_id, True) and studio.visible(f.id)
        ]
        measured = studio.measured(f.id for f in features)
        turned = turns_of(model_of(studio.records, f) for f in features)
        turns = {f.id: row for row, f in enumerate(features)}, turned
        groups: dict[str, dict[str, list[Typed]]] = {}
        for feature in features:
            groups.setdefault(feature.type_id, {}).setdefault(feature.set_name, []).append(feature)
        sets: list[NetSet] = []
        beds: list[NetSet] = []
        for kind in studio.session.of(FeatureType):
            own = groups.get(kind.id, {})
            # The same symbol for a set, whether picked or read on a compass.
            for variant, name in enumerate(sorted(own, key=natural)):
                title = f"{kind.name}: {name}" if name else kind.name
                for look, evidence, own_look in alike(own[name]):
                    marker = look.marker or _MARKERS.get(kind.symbol, "o")
                    new = sets_of(
                        kind, f"{title}{look.suffix}", own_look, measured, marker, turns, variant
                    )
                    if kind.id == "bedding" and evidence == "picked":
                        beds += [s for s in new if s.kind == "plane"]
                    sets += new
        if self._groups is not None:
            sets, beds = proposed_sets(sets, self._groups), []
        return NetContents(
            sets=tuple(sets),
            projection=str(self._projection.currentData()),
            circles=None if self._circles.isChecked() else False,
            poles=self._poles.isChecked(),
            means=means_of(sets, studio.settings.notation) if self._means.isChecked() else (),
            fold=_fold(beds) if self._beta.isChecked() else None,
            contour=self.contours.method,
            contouring=self.contours.contouring,
            selected=frozenset(studio.selection.ids),
            ellipses=self._ellipses(),
            registered=self._registered(),
            notation=studio.settings.notation,
            compact=True,
        )

    def for_print(self) -> NetContents:
        """The contents for a printed figure: with a title, and without selection."""
        project, frame = self._studio.project, self._studio.frame_name()
        return replace(
            self.contents().with_selection(()),
            title="" if project.untitled else project.name,
            notes=(frame,) if frame else (),
            compact=False,
        )

    def _ellipses(self) -> tuple[AnyEllipse, ...]:
        """Of the current plane or line, where its error is known."""
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return ()
        measured = self._studio.measured([current])[current]
        if measured.line is not None:
            return _line_ellipse(measured)
        if (band := band_of_measured(measured)) is not None:
            return (NetBand(band.outline()),)
        fit = measured.fit
        if fit is None or fit.max_confidence95_deg is None or fit.error_rake_deg is None:
            return ()
        return (
            NetEllipse(
                Plane.from_normal(fit.normal),
                fit.max_confidence95_deg,
                fit.min_confidence95_deg or 0.0,
                fit.error_rake_deg,
            ),
        )

    def _registered(self) -> tuple[AnyEllipse, ...]:
        """That of the current plane or line with the error of its registration, where known."""
        records, current = self._studio.records, self._studio.selection.current
        feature = get_feature(records, current)
        if current is None or feature is None:
            return ()
        measured = self._studio.measured([current])[current]
        if measured.registration_error_deg is None:
            return ()
        if measured.line is not None:
            total = measured.total
            return () if total is None else (NetLineEllipse.of(measured.line.vector(), total),)
        pole = pole_region(measured, model_of(records, feature))
        if pole is None or measured.plane is None:
            return ()
        return (NetLineEllipse.of(-measured.plane.normal(), pole),)

    def redraw(self) -> None:
        """Draw the net anew, unless it is hidden; it is then drawn when it is painted next."""
        # Behind another tab nobody sees it (Qt calls it visible): it is drawn when it is painted.
        self._stale = self.canvas.visibleRegion().isEmpty()
        if self._stale or self.canvas.width() < 50 or self.canvas.height() < 50:
            return
        start = perf_counter()
        dark = self.palette().color(QPalette.ColorRole.Window).lightness() < 128
        wanted = Wanted(
            self.contents(),
            NetStyle.dock(dark=dark, dpi=DPI, font_px=_FONT_PX),
            (self.canvas.width(), self.canvas.height()),
            self.canvas.devicePixelRatioF(),
        )
        if _many(wanted.contents):
            self._wanted = wanted
            self._thread.draw(wanted)
        else:
            self._thread.forget()
            self._wanted = None
            self._show(DrawnNet.of(wanted))
        took = 1000.0 * (perf_counter() - start)
        slow = took > _QUICK_MS
        self._timer.setInterval(min(_LATEST_MS, int(5 * took)) if slow else _SOON_MS)

    def _drawn(self, made: tuple[Wanted, DrawnNet]) -> None:
        """The thread has drawn a net."""
        wanted, net = made
        if wanted is not self._wanted:
            return
        self._wanted = None
        if wanted.contents.selected != frozenset(self._studio.selection.ids):
            net.artists.select(self._studio.selection.ids, self._ellipses(), self._registered())
        self._show(net)

    def _show(self, net: DrawnNet) -> None:
        self._net = net
        self.canvas.show_net(net)
        self._show_selected()

    def _select(self) -> None:
        if self._net is not None and _many(self._net.artists.contents):
            # The table and the outcrop come first.
            self._emphasis.start()
        else:
            self._emphasise()

    def _emphasise(self) -> None:
        if self._net is not None and self.up_to_date:
            self._net.artists.select(
                self._studio.selection.ids, self._ellipses(), self._registered()
            )
            self.canvas.show_net(self._net)
        self._show_selected()

    # --- pointing ----------------------------------------------------------------------------
    def _pressed(self, event: QMouseEvent, x: float, y: float) -> None:
        self._path = [(x, y)]
        self.canvas.lasso = [event.position()]

    def _moved(self, x: float, y: float) -> None:
        if self._path:
            self._path.append((x, y))
            if self._is_lasso():
                self.canvas.update()
            return
        line = self.artists.line_at(x, y) if self.artists else None
        if line is None:
            self._show_selected()
        else:
            self._under.setText(format_line(line, 0))

    def _is_lasso(self) -> bool:
        start, far = self._path[0], _CLICK_PX * self.canvas.devicePixelRatioF()
        return any(abs(x - start[0]) > far or abs(y - start[1]) > far for x, y in self._path)

    def _released(self, event: QMouseEvent, x: float, y: float) -> None:
        if not self._path:
            return
        path, is_lasso = self._path, self._is_lasso()
        self._path, self.canvas.lasso = [], []
        self.canvas.update()
        if self.artists is None:
            return
        adding = bool(
            event.modifiers()
            & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
        )
        selection = self._studio.selection
        if is_lasso:
            inside = self.artists.features_within(path)
            # In the order of the records, so that the current one does not hang on chance.
            found = [f.id for f in self._studio.session.features() if f.id in inside]
            selection.set([*selection.ids, *found] if adding else found)
            return
        at = self.artists.feature_at(x, y, 8.0 * self.canvas.devicePixelRatioF())
        if at is not None and adding:
            selection.toggle(at)
        elif not adding:
            selection.set([] if at is None else [at])

    def _show_selected(self) -> None:
        """Name what is selected, in the corner where the direction under the cursor is shown."""
        ids = self._studio.selection.ids
        shown = self.artists.contents if self.artists else None
        known = {i for s in shown.sets for i in s.ids} if shown and ids else set()
        here = [i for i in ids if i in known]
        record = self._studio.records.get(here[-1]) if here else None
        if len(here) > 1:
            text = tr("{count:,} selected", count=len(here))
        elif isinstance(record, Typed):
            text = (
                tr("{feature} ± 95 %", feature=record.name)
                if shown and shown.ellipses
                else record.name
            )
        else:
            text = ""
        self._under.setText(text)


def _many(net: NetContents) -> bool:
    return sum(map(len, net.sets)) > _MANY


def _fold(beds: Sequence[NetSet]) -> FoldAxis | None:
    """Fold axis of picked bedding only: feature types are never pooled silently."""
    azimuth = np.concatenate([np.zeros(0), *(s.azimuth_deg for s in beds)])
    angle = np.concatenate([np.zeros(0), *(s.angle_deg for s in beds)])
    if len(azimuth) < 3:
        return None
    turns = None
    if any(s.registered for s in beds):
        own = [s.turns for s in beds if s.turns is not None]
        turns = Turns(np.concatenate([t.group for t in own]), own[0].rotations)
    try:
        return fold_axis(azimuth, angle, turns)
    except VomError:
        return None


def _line_ellipse(measured: Measurement) -> tuple[NetLineEllipse, ...]:
    line, largest, smallest = (
        measured.line,
        measured.max_confidence95_deg,
        measured.min_confidence95_deg,
    )
    if line is None or largest is None or smallest is None:
        return ()
    # A cone has no larger axis: any direction across it will do.
    axis = measured.confidence_axis
    if axis is None:
        axis = np.cross(line.vector(), np.eye(3)[int(np.argmin(np.abs(line.vector())))])
    return (NetLineEllipse(line, largest, smallest, axis),)
