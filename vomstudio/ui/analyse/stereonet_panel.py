"""The stereonet dock: orientations of the project, linked with table, tree and 3-D view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from matplotlib.backend_bases import MouseEvent
from matplotlib.backends.backend_qtagg import FigureCanvasQTAgg
from matplotlib.figure import Figure
from PySide6.QtCore import QPointF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAction,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document.edit import Edit
from vomstudio.document.kind import Evidence, NetLook
from vomstudio.document.kinds import KINDS, kind_of
from vomstudio.document.measurement import Measurement
from vomstudio.document.records import FeatureType, Typed, get_feature
from vomstudio.errors import VomError
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Plane
from vomstudio.products.net.contents import (
    AnyEllipse,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    NetSet,
    means_of,
)
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.style import NetStyle
from vomstudio.ui.common import theme
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_formatting import natural
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.widgets import ComboBox
from vomstudio.words import tr

_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "diamond": "D", "pentagon": "p",
            "star": "*"}  # fmt: skip


# A press that moves further than this draws a lasso.
_CLICK_PX = 4
_FONT_PX = 12.0
# A redraw that takes long comes seldom: it must never hold up a row of picks.
_SOON_MS, _QUICK_MS, _LATEST_MS = 30, 60, 500


class NetCanvas(FigureCanvasQTAgg):
    """The net is drawn once; the selection is drawn over it, and the lasso over both."""

    painted = Signal()

    def __init__(self, figure: Figure) -> None:
        super().__init__(figure)
        self.artists: NetArtists | None = None
        self.lasso: list[QPointF] = []
        self.draw_ms = 0.0
        self._clean: Any = None

    def draw(self) -> None:
        start = perf_counter()
        super().draw()
        self._clean = self.copy_from_bbox(self.figure.bbox)
        self._emphasise()
        self.draw_ms = 1000.0 * (perf_counter() - start)

    def show_emphasis(self) -> None:
        """What is selected has changed, and nothing else."""
        if self._clean is None:
            self.draw_idle()
            return
        self.restore_region(self._clean)
        self._emphasise()
        self.update()

    def _emphasise(self) -> None:
        if self.artists is not None:
            for artist in self.artists.emphasis:
                self.artists.axes.draw_artist(artist)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        super().paintEvent(event)
        self.painted.emit()
        if len(self.lasso) > 1:
            painter = QPainter(self)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            color = self.palette().color(QPalette.ColorRole.Highlight)
            painter.setPen(QPen(color, 1.5))
            color.setAlpha(40)
            painter.setBrush(color)
            painter.drawPolygon(QPolygonF(self.lasso))
            painter.end()


class StereonetPanel(QWidget):
    """The net with its buttons. A click or a lasso selects features."""

    def __init__(self, studio: Studio, export: QAction) -> None:
        super().__init__()
        explain(self, "numbers.md#the-net")
        self._studio = studio
        self.artists: NetArtists | None = None
        self.figure = Figure()
        self.canvas = NetCanvas(self.figure)
        self.canvas.setMinimumSize(220, 220)
        self.canvas.setToolTip("")
        self.canvas.mpl_connect("button_press_event", self._pressed)
        self.canvas.mpl_connect("motion_notify_event", self._moved)
        self.canvas.mpl_connect("button_release_event", self._released)
        self.canvas.mpl_connect("figure_leave_event", lambda _: self._show_selected())
        self.canvas.painted.connect(self._painted)
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
        self._export = QToolButton()
        self._export.setDefaultAction(export)
        self._under = QLabel()
        self._under.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._under.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.addWidget(self._projection)
        for button in (self._circles, self._poles, self._means, self._beta, self._export):
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
        studio.project_opened.connect(self._soon)
        studio.edited.connect(self._edited)
        studio.visibility_changed.connect(lambda _: self._soon())
        studio.settings_changed.connect(self._soon)
        studio.selection_changed.connect(self._select)
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

    def _edited(self, edit: Edit) -> None:
        if self._studio.affected(edit):
            self._soon()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self._soon()

    def _painted(self) -> None:
        if self._stale:
            self._soon()

    # --- drawing -----------------------------------------------------------------------------
    def contents(self) -> NetContents:
        """The visible planes and lines: one group for each feature type and set, and within it for
        planes, lines and compass readings."""
        studio = self._studio
        features = [
            f
            for f in studio.session.features()
            if isinstance(f, Typed)
            and kind_of(f).net is not None
            and studio.visible(f.id)
            and studio.visible(f.type_id)
        ]
        measured = studio.measured(f.id for f in features)
        by_type: dict[str, list[Typed]] = {}
        for feature in features:
            by_type.setdefault(feature.type_id, []).append(feature)
        sets: list[NetSet] = []
        beds: list[NetSet] = []
        for kind in studio.session.of(FeatureType):
            own = by_type.get(kind.id, [])
            # The same symbol for a set, whether picked or read on a compass.
            names = sorted({f.set_name for f in own}, key=natural)
            for variant, name in enumerate(names):
                title = f"{kind.name}: {name}" if name else kind.name
                there = [f for f in own if f.set_name == name]
                for look, evidence, alike in _alike(there):
                    marker = look.marker or _MARKERS.get(kind.symbol, "o")
                    new = _sets(kind, f"{title}{look.suffix}", alike, measured, marker, variant)
                    if kind.id == "bedding" and evidence == "picked":
                        beds += [s for s in new if s.kind == "plane"]
                    sets += new
        return NetContents(
            sets=tuple(sets),
            projection=str(self._projection.currentData()),
            circles=None if self._circles.isChecked() else False,
            poles=self._poles.isChecked(),
            means=means_of(sets, studio.settings.notation) if self._means.isChecked() else (),
            fold=_fold(beds) if self._beta.isChecked() else None,
            selected=frozenset(studio.selection.ids),
            ellipses=self._ellipses(),
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

    def redraw(self) -> None:
        """Draw the net anew, unless it is hidden; it is then drawn when it is painted next."""
        # Behind another tab nobody sees it (Qt calls it visible): it is drawn when it is painted.
        self._stale = self.canvas.visibleRegion().isEmpty()
        if self._stale or self.canvas.width() < 50 or self.canvas.height() < 50:
            return
        start = perf_counter()
        dark = self.palette().color(QPalette.ColorRole.Window).lightness() < 128
        ratio = self.canvas.devicePixelRatioF()
        style = NetStyle.dock(dark=dark, dpi=self.figure.dpi / ratio, font_px=_FONT_PX)
        self.artists = self.canvas.artists = draw_stereonet(self.figure, self.contents(), style)
        self._animate()
        self.canvas.draw_idle()
        took = 1000.0 * (perf_counter() - start) + self.canvas.draw_ms
        slow = took > _QUICK_MS
        self._timer.setInterval(min(_LATEST_MS, int(5 * took)) if slow else _SOON_MS)
        self._show_selected()

    def _animate(self) -> None:
        """Emphasis is left out of the net that is kept."""
        for artist in self.artists.emphasis if self.artists else ():
            artist.set_animated(True)

    def _select(self, ids: tuple[str, ...]) -> None:
        if self.artists is not None and not self._timer.isActive():
            self.artists.select(ids, self._ellipses())
            self._animate()
            self.canvas.show_emphasis()
        self._show_selected()

    # --- pointing ----------------------------------------------------------------------------
    def _pressed(self, event: MouseEvent) -> None:
        if event.button == 1:
            self._path = [(event.x, event.y)]
            self.canvas.lasso = [event.guiEvent.position()]

    def _moved(self, event: MouseEvent) -> None:
        if self._path:
            self._path.append((event.x, event.y))
            self.canvas.lasso.append(event.guiEvent.position())
            if self._is_lasso():
                self.canvas.update()
            return
        line = self.artists.line_at(event.x, event.y) if self.artists else None
        if line is None:
            self._show_selected()
        else:
            self._under.setText(format_line(line, 0))

    def _is_lasso(self) -> bool:
        start, far = self._path[0], _CLICK_PX * self.canvas.devicePixelRatioF()
        return any(abs(x - start[0]) > far or abs(y - start[1]) > far for x, y in self._path)

    def _released(self, event: MouseEvent) -> None:
        if event.button != 1 or not self._path:
            return
        path, is_lasso = self._path, self._is_lasso()
        self._path, self.canvas.lasso = [], []
        self.canvas.update()
        if self.artists is None:
            return
        adding = bool(
            event.guiEvent.modifiers()
            & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
        )
        selection = self._studio.selection
        if is_lasso:
            inside = self.artists.features_within(path)
            # In the order of the records, so that the current one does not hang on chance.
            found = [f.id for f in self._studio.session.features() if f.id in inside]
            selection.set([*selection.ids, *found] if adding else found)
            return
        at = self.artists.feature_at(event.x, event.y, 8.0 * self.canvas.devicePixelRatioF())
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


def _alike(features: Sequence[Typed]) -> list[tuple[NetLook, Evidence, list[Typed]]]:
    """Features by where they come from and how their kinds stand on the net, in the order of the
    kinds."""
    result: dict[tuple[NetLook, Evidence], list[Typed]] = {}
    for kind in KINDS:
        if kind.net is not None:
            result.setdefault((kind.net, kind.evidence), [])
    for feature in features:
        kind = kind_of(feature)
        if kind.net is not None:
            result[kind.net, kind.evidence].append(feature)
    return [(look, evidence, own) for (look, evidence), own in result.items()]


def _fold(beds: Sequence[NetSet]) -> FoldAxis | None:
    """Fold axis of picked bedding only: feature types are never pooled silently."""
    azimuth = np.concatenate([np.zeros(0), *(s.azimuth_deg for s in beds)])
    angle = np.concatenate([np.zeros(0), *(s.angle_deg for s in beds)])
    if len(azimuth) < 3:
        return None
    try:
        return fold_axis(azimuth, angle)
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


def _sets(
    kind: FeatureType,
    name: str,
    features: Sequence[Typed],
    measured: Mapping[str, Measurement],
    marker: str,
    variant: int = 0,
) -> list[NetSet]:
    """The planes and the lines among features, each as a set; those without orientation are left
    out."""
    planes = [(f.id, p) for f in features if (p := measured[f.id].plane) is not None]
    lines = [
        (f.id, line)
        for f in features
        if measured[f.id].plane is None and (line := measured[f.id].line) is not None
    ]
    result = []
    if planes:
        azimuth = np.array([p.dip_direction_deg for _, p in planes], dtype=float)
        angle = np.array([p.dip_deg for _, p in planes], dtype=float)
        ids = tuple(id_ for id_, _ in planes)
        result.append(NetSet(name, "plane", azimuth, angle, ids, kind.color, marker, variant))
    if lines:
        azimuth = np.array([line.trend_deg for _, line in lines], dtype=float)
        angle = np.array([line.plunge_deg for _, line in lines], dtype=float)
        ids = tuple(id_ for id_, _ in lines)
        result.append(NetSet(name, "line", azimuth, angle, ids, kind.color, marker, variant))
    return result
