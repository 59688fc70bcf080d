"""The stereonet dock: what is in the document, linked with table, tree and 3-D."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.backend_bases import MouseEvent
from matplotlib.backends.backend_qtagg import FigureCanvasQTAgg
from matplotlib.figure import Figure
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QPalette, QResizeEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from vomstudio.document.edit import Edit
from vomstudio.document.measurements import Measurement
from vomstudio.document.records import FEATURES, TYPED, FeatureType, Intersection, Reading, Typed
from vomstudio.errors import VomError
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Plane
from vomstudio.products.stereonet import (
    AnyEllipse,
    NetArtists,
    NetContents,
    NetEllipse,
    NetLineEllipse,
    NetSet,
    NetStyle,
    draw_stereonet,
    means_of,
)
from vomstudio.ui import theme
from vomstudio.ui.studio import Studio

_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "diamond": "D", "pentagon": "p",
            "star": "*"}  # fmt: skip


class StereonetPanel(QWidget):
    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.artists: NetArtists | None = None
        self.figure = Figure()
        self.canvas = FigureCanvasQTAgg(self.figure)
        self.canvas.setMinimumSize(220, 220)
        self.canvas.mpl_connect("button_press_event", self._clicked)
        self.canvas.mpl_connect("motion_notify_event", self._moved)
        self._projection = QComboBox()
        self._projection.addItem(self.tr("Equal area"), "area")
        self._projection.addItem(self.tr("Equal angle"), "angle")
        self._projection.setCurrentIndex(self._projection.findData(studio.settings.projection))
        self._projection.activated.connect(self._chosen)
        self._circles = self._toggle("circle-outline", self.tr("Great circles"), True)
        self._poles = self._toggle("circle-medium", self.tr("Poles"), True)
        self._means = self._toggle("sigma", self.tr("Mean of each type"), False)
        self._beta = self._toggle("axis-arrow", self.tr("Beta and pi-plane of the bedding"), True)
        self._under = QLabel()
        self._under.setAlignment(Qt.AlignmentFlag.AlignRight)
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.addWidget(self._projection)
        for button in (self._circles, self._poles, self._means, self._beta):
            row.addWidget(button)
        row.addStretch()
        row.addWidget(self._under)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.canvas, 1)
        layout.addLayout(row)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(30)
        self._timer.timeout.connect(self.redraw)
        studio.project_opened.connect(self._timer.start)
        studio.edited.connect(self._edited)
        studio.visibility_changed.connect(lambda _: self._timer.start())
        studio.settings_changed.connect(self._timer.start)
        studio.selection_changed.connect(self._select)
        self._timer.start()

    def _toggle(self, icon: str, tip: str, on: bool) -> QToolButton:
        button = QToolButton()
        button.setIcon(theme.icon(icon))
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        button.setCheckable(True)
        button.setChecked(on)
        button.toggled.connect(lambda _: self.redraw())
        return button

    def _chosen(self) -> None:
        self._studio.settings.projection = str(self._projection.currentData())
        self._studio.keep_settings()

    def _edited(self, edit: Edit) -> None:
        if self._studio.affected(edit):
            self._timer.start()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self._timer.start()

    # --- drawing -----------------------------------------------------------------------------
    def contents(self) -> NetContents:
        """The visible planes and lines: a set for each feature type, for its lines, and for its
        compass readings."""
        studio = self._studio
        features = [
            f
            for f in studio.session.features()
            if isinstance(f, TYPED) and studio.visible(f.id) and studio.visible(f.type_id)
        ]
        measured = studio.measured(f.id for f in features)
        sets = []
        for kind in studio.session.of(FeatureType):
            own = [f for f in features if f.type_id == kind.id]
            picked = [f for f in own if not isinstance(f, Reading | Intersection)]
            crossings = [f for f in own if isinstance(f, Intersection)]
            readings = [f for f in own if isinstance(f, Reading)]
            sets += _sets(kind, kind.name, picked, measured, _MARKERS.get(kind.symbol, "o"))
            sets += _sets(kind, f"{kind.name} (intersections)", crossings, measured, "X")
            sets += _sets(kind, f"{kind.name} (compass)", readings, measured, "P")
        return NetContents(
            sets=tuple(sets),
            projection=str(self._projection.currentData()),
            circles=None if self._circles.isChecked() else False,
            poles=self._poles.isChecked(),
            means=means_of(sets, studio.settings.notation) if self._means.isChecked() else (),
            fold=self._fold(sets) if self._beta.isChecked() else None,
            selected=frozenset(studio.selection.ids),
            ellipses=self._ellipses(),
            notation=studio.settings.notation,
        )

    def _fold(self, sets: list[NetSet]) -> FoldAxis | None:
        """Of bedding only: kinds are never pooled silently."""
        bedding = self._studio.records.get("bedding")
        name = bedding.name if isinstance(bedding, FeatureType) else ""
        for each in sets:
            if each.name == name and len(each) > 2:
                try:
                    return fold_axis(each.azimuth_deg, each.angle_deg)
                except VomError:
                    return None
        return None

    def _ellipses(self) -> tuple[AnyEllipse, ...]:
        """Of the current plane or line, where its error is known."""
        current = self._studio.selection.current
        if current is None or not isinstance(self._studio.records.get(current), FEATURES):
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
        if self.canvas.width() < 50 or self.canvas.height() < 50:
            return
        dark = self.palette().color(QPalette.ColorRole.Window).lightness() < 128
        ratio = self.canvas.devicePixelRatioF()
        style = NetStyle.dock(dark=dark, dpi=self.figure.dpi / ratio)
        self.artists = draw_stereonet(self.figure, self.contents(), style)
        self.canvas.draw_idle()

    def _select(self, ids: tuple[str, ...]) -> None:
        if self.artists is not None and not self._timer.isActive():
            self.artists.select(ids, self._ellipses())
            self.canvas.draw_idle()

    # --- pointing ----------------------------------------------------------------------------
    def _clicked(self, event: MouseEvent) -> None:
        if self.artists is None or event.button != 1:
            return
        found = self.artists.feature_at(event.x, event.y, 8.0 * self.canvas.devicePixelRatioF())
        adding = bool(
            event.guiEvent.modifiers()
            & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
        )
        if found is not None and adding:
            self._studio.selection.toggle(found)
        elif not adding:
            self._studio.selection.set([] if found is None else [found])

    def _moved(self, event: MouseEvent) -> None:
        line = self.artists.line_at(event.x, event.y) if self.artists else None
        self._under.setText("" if line is None else format_line(line, 0))


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
        result.append(NetSet(name, "plane", azimuth, angle, ids, kind.color, marker))
    if lines:
        azimuth = np.array([line.trend_deg for _, line in lines], dtype=float)
        angle = np.array([line.plunge_deg for _, line in lines], dtype=float)
        ids = tuple(id_ for id_, _ in lines)
        title = f"{name}, lines" if planes else name
        result.append(NetSet(title, "line", azimuth, angle, ids, kind.color, marker))
    return result
