"""The display panel: mode, point size, lighting, scalar field and its range, clipping box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QLocale, QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QCheckBox,
    QDoubleSpinBox,
    QFormLayout,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.coordinate_limits import check_coordinates, check_near_model
from vomstudio.project.records import Model
from vomstudio.rendering.view.clipping import FACES, ClipBox
from vomstudio.rendering.view.scalars import (
    ELEVATION,
    PALETTES,
    PERCENTILES,
    FieldStyle,
    Scale,
    field_names,
    field_title,
)
from vomstudio.studio import display
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import why_no_model
from vomstudio.ui.base.controls import (
    ComboBox,
    DoubleSpinBox,
    Label,
    Scrolling,
    allow,
    as_words,
    narrow_form,
)
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.axis_titles import axes_of

if TYPE_CHECKING:
    from vomstudio.rendering.qt.display import ModelAppearance
    from vomstudio.rendering.qt.viewport import Viewport

# Of a field in the narrowest dock.
_LEAST_WIDTH = 64
_KIND_NAMES = {
    "diverging": to_translate("Diverging about zero"),
    "cyclic": to_translate("Cyclic"),
    "categories": to_translate("One colour for each class"),
}


class DisplayPanel(QWidget):
    """current : gives the model whose field is chosen here"""

    def __init__(
        self,
        studio: Studio,
        actions: dict[str, QAction],
        current: Callable[[], Model | None],
    ) -> None:
        super().__init__()
        explain(self, "window.md#look-as-you-need")
        self._models_box: Callable[[], ClipBox | None] = lambda: None
        self._studio, self._display, self._current = studio, studio.display, current
        self._view_display: ModelAppearance | None = None
        page = QWidget()
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addLayout(self._make_look())
        layout.addWidget(self._make_field())
        layout.addWidget(self._make_clip(actions["clipping_reset"]))
        layout.addStretch()
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(Scrolling(page))
        for signal in (
            self._display.changed,
            studio.model_loaded,
            studio.selection_changed,
            studio.edited,
            studio.project_opened,
        ):
            signal.connect(self.refresh)
        self.refresh()

    def watch(self, viewport: Viewport, models_box: Callable[[], ClipBox | None]) -> None:
        """Show the field ranges of this viewport from now on. models_box : around all visible
        models"""
        self._models_box = models_box
        self._view_display = viewport.display
        viewport.field_shown.connect(self.refresh)

    # --- parts -------------------------------------------------------------------------------
    def _make_look(self) -> QFormLayout:
        self.mode = ComboBox()
        for value, text in display.MODES.items():
            self.mode.addItem(tr(text), value)
        self.mode.activated.connect(self._mode_chosen)
        self.points = DoubleSpinBox()
        self.points.setMinimumWidth(_LEAST_WIDTH)
        self.points.setRange(0.0, 20.0)
        self.points.setDecimals(0)
        self.points.setSpecialValueText(tr("Automatic (fill gaps)"))
        self.points.setSuffix(tr(" px"))
        self.points.valueChanged.connect(lambda v: self._display.set_point_size(v or None))
        self.lit = QCheckBox(tr("Lit"))
        self.lit.clicked.connect(lambda on: self._display.set_lit(self._mode_now(), on))
        self.eye_dome = QCheckBox(tr("Eye-dome lighting"))
        self.eye_dome.clicked.connect(self._display.set_eye_dome)
        row = QHBoxLayout()
        row.addWidget(self.lit)
        row.addWidget(self.eye_dome, 1)
        form = narrow_form()
        form.addRow(tr("Mode"), self.mode)
        form.addRow(tr("Point size"), self.points)
        form.addRow(tr("Lighting"), row)
        return form

    def _make_field(self) -> QGroupBox:
        self.field_box = QGroupBox()
        self.field = ComboBox()
        self.field.setObjectName("field")
        self.field.activated.connect(self._field_chosen)
        self.palette_box = ComboBox()
        self.palette_box.activated.connect(
            lambda _: self._restyle(palette=self.palette_box.currentData())
        )
        self.low, self.high = QLineEdit(), QLineEdit()
        for edit, name in ((self.low, "low"), (self.high, "high")):
            edit.setObjectName(f"field_{name}")
            edit.setToolTip(tr("Leave empty to use the percentile."))
            edit.editingFinished.connect(lambda e=edit, n=name: self._typed(e, n))
        self.first, self.last = DoubleSpinBox(), DoubleSpinBox()
        for spin in (self.first, self.last):
            spin.setMinimumWidth(_LEAST_WIDTH)
            spin.setRange(0.0, 100.0)
            spin.setDecimals(1)
            spin.setSuffix(" %")
            spin.setKeyboardTracking(False)
            spin.valueChanged.connect(self._percent_chosen)
        self.whole = QToolButton()
        self.whole.setIcon(theme.icon("restore"))
        self.whole.setToolTip(tr("Reset the range to the percentiles 2 and 98."))
        self.whole.clicked.connect(
            lambda: self._restyle(low=None, high=None, percentiles=PERCENTILES)
        )
        form = narrow_form()
        form.addRow(tr("Field"), self.field)
        form.addRow(tr("Colour map"), self.palette_box)
        form.addRow(tr("Range"), _pair(self.low, self.high, tr("to")))
        percentiles = _pair(self.first, self.last, tr("to"), self.whole)
        form.addRow(tr("Percentiles"), percentiles)
        self.field_box.setLayout(form)
        form.setContentsMargins(8, 4, 8, 6)
        return self.field_box

    def _make_clip(self, reset: QAction) -> QGroupBox:
        self.clip = QGroupBox(tr("Clipping box"))
        self.clip.setCheckable(True)
        self.clip.setToolTip(tr("Shows only what lies between these sides."))
        self.clip.clicked.connect(self._clip_toggled)
        grid = QGridLayout(self.clip)
        grid.setContentsMargins(8, 4, 8, 6)
        grid.setSpacing(3)
        self._axes = [Label() for _ in range(3)]
        self.faces: list[QDoubleSpinBox] = []
        for k, (axis, side) in enumerate(FACES):
            spin = DoubleSpinBox()
            spin.setObjectName(f"clip_{'xyz'[axis]}{side}")
            spin.setRange(-1e9, 1e9)
            spin.setDecimals(2)
            spin.setStepType(QDoubleSpinBox.StepType.DefaultStepType)
            spin.setKeyboardTracking(False)
            spin.setLocale(QLocale.c())
            spin.setMinimumWidth(_LEAST_WIDTH)
            spin.valueChanged.connect(lambda value, n=k: self._face_typed(n, value))
            self.faces.append(spin)
            grid.addWidget(spin, axis, 1 + side)
        for axis, label in enumerate(self._axes):
            grid.addWidget(label, axis, 0)
        self.handles = QCheckBox(tr("Handles in the view"))
        self.handles.clicked.connect(self._display.set_handles)
        button = QPushButton(tr("Fit to models"))
        button.clicked.connect(reset.trigger)
        grid.addWidget(self.handles, 3, 0, 1, 2)
        grid.addWidget(button, 3, 2)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(2, 1)
        self._toggle_clip: Callable[[], None] = lambda: None
        return self.clip

    def on_clip_toggled(self, toggle: Callable[[], None]) -> None:
        """toggle : switches the clipping box on or off"""
        self._toggle_clip = toggle

    # --- what is done here -------------------------------------------------------------------
    def _mode_chosen(self, _: int) -> None:
        mode = self.mode.currentData()
        if mode == "field":
            self._display.show_field(*self._style_now()) if self._has_model() else None
        else:
            self._display.set_mode(mode)

    def _mode_now(self) -> str:
        models = [m.data for m in self._studio.models.values()]
        return display.mode_shown(self._display.mode, models)

    def _has_model(self) -> bool:
        model = self._current()
        return model is not None and model.id in self._studio.models

    def _style_now(self) -> tuple[str, FieldStyle]:
        model = self._current()
        assert model is not None
        style = self._display.styles.get(model.id)
        if style is None:
            style = FieldStyle(display.default_field(self._studio.models[model.id].data))
        return model.id, style

    def _field_chosen(self, _: int) -> None:
        model = self._current()
        if model is not None:
            self._display.show_field(model.id, FieldStyle(self.field.currentData()))

    def _restyle(self, **values: object) -> None:
        if not self._has_model():
            return
        model_id, style = self._style_now()
        changed = replace(style, **values)  # type: ignore[arg-type]
        if changed != style:
            self._display.show_field(model_id, changed)

    def _typed(self, edit: QLineEdit, name: str) -> None:
        if not edit.isModified():
            return
        edit.setModified(False)
        text = edit.text().strip().replace(",", ".").replace("−", "-")
        try:
            value = float(text) if text else None
            if value is not None and not isfinite(value):
                raise ValueError(text)
        except ValueError:
            self._studio.warn(Finding("number.invalid", text=text))
            self.refresh()
            return
        style = self._style_now()[1]
        low = value if name == "low" else style.low
        high = value if name == "high" else style.high
        scale = self._scale()
        if scale is not None:
            ends = (scale.low if low is None else low, scale.high if high is None else high)
            if not ends[0] < ends[1]:
                self._studio.warn(Finding("display.crossed-limits"))
                self.refresh()
                return
        self._restyle(**{name: value})

    def _percent_chosen(self, _: float) -> None:
        first, last = self.first.value(), self.last.value()
        if first < last:
            self._restyle(percentiles=(first, last), low=None, high=None)
        else:
            self.refresh()

    def _clip_toggled(self, _: bool) -> None:
        self._toggle_clip()
        self.refresh()

    def _face_typed(self, face: int, value: float) -> None:
        box = self._display.box
        if box is not None:
            axis, side = FACES[face]
            if (said := self._why_not_there(axis, value)) is not None:
                self._studio.warn(said)
                self._show_clip()
                return
            self._display.set_clip(box.move_face(axis, side, value))

    def _why_not_there(self, axis: int, value: float) -> Finding | None:
        """Return a finding if a face of the box would be far from all models."""
        around = self._models_box()
        if around is None:
            return check_coordinates((value,))
        bounds = np.array([around.low, around.high])
        point = bounds.mean(axis=0)
        point[axis] = value
        return check_near_model(point.tolist(), bounds)

    # --- what is shown here ------------------------------------------------------------------
    def _scale(self) -> Scale | None:
        model = self._current()
        if model is None or self._view_display is None:
            return None
        return self._view_display.scale_of(model.id)

    def refresh(self, *what: object) -> None:
        """Show the settings as they are now. what : as in `Display.changed`."""
        if what == ("box",):
            self._show_clip()
            return
        shown = self._display
        models = [m.data for m in self._studio.models.values()]
        mode = display.mode_shown(shown.mode, models)
        reasons = []
        for k, value in enumerate(display.MODES):
            why = display.why_not_mode(value, models)
            flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
            wanted = flags if why is None else Qt.ItemFlag.NoItemFlags
            self.mode.model().item(k).setFlags(wanted)  # type: ignore[attr-defined]
            self.mode.setItemData(k, str(why or ""), Qt.ItemDataRole.ToolTipRole)
            if why is not None and models:
                reasons.append(f"{tr(display.MODES[value])}: {why}")
        self.mode.setCurrentIndex(self.mode.findData(mode))
        self.mode.setToolTip(as_words("\n".join(reasons)))
        allow(self.mode, why_no_model(self._studio))
        with QSignalBlocker(self.points):
            self.points.setValue(shown.point_size or 0.0)
        for box, why, on in (
            (self.lit, display.why_not_lit(models), shown.lit[mode]),
            (self.eye_dome, display.why_not_eye_dome(models), shown.eye_dome),
        ):
            allow(box, why)
            box.setChecked(on)
        self._show_field()
        self._show_clip()

    def _show_field(self) -> None:
        model = self._current()
        opened = None if model is None else self._studio.models.get(model.id)
        why = why_no_model(self._studio)
        if opened is None and why is None:
            why = Finding("model.not-open")
        allow(self.field_box, why)
        if model is None or opened is None:
            self.field_box.setTitle(tr("Scalar field"))
            self.field.clear()
            return
        self.field_box.setTitle(tr("Scalar field of {model}", model=model.name))
        with QSignalBlocker(self.field):
            self.field.clear()
            for name in field_names(opened.data):
                self.field.addItem(
                    tr("Elevation (Z)") if name == ELEVATION else field_title(name), name
                )
        style = self._style_now()[1]
        if self.field.findData(style.name) < 0:
            # A project keeps how a field is shown, and the field itself only where a file has it.
            with QSignalBlocker(self.field):
                self.field.addItem(
                    tr("{field}: not there, calculate it again", field=field_title(style.name)),
                    style.name,
                )
        self.field.setCurrentIndex(self.field.findData(style.name))
        scale = self._scale()
        kind = scale.kind if scale is not None else "sequential"
        with QSignalBlocker(self.palette_box):
            self.palette_box.clear()
            for name in PALETTES.get(kind, ()):
                self.palette_box.addItem(name, name)
            if kind in _KIND_NAMES and kind not in PALETTES:
                self.palette_box.addItem(tr(_KIND_NAMES[kind]))
            place = self.palette_box.findData(style.palette)
            self.palette_box.setCurrentIndex(max(place, 0))
        ranged = kind in ("sequential", "diverging")
        ends = scale.end_texts() if scale is not None and ranged else ("", "")
        for edit, value, text in (
            (self.low, style.low, ends[0]),
            (self.high, style.high, ends[1]),
        ):
            if not edit.hasFocus() or not edit.isModified():
                edit.setText("" if value is None else _short(value))
                edit.setCursorPosition(0)
            edit.setPlaceholderText(text)
        for spin, percent in zip((self.first, self.last), style.percentiles, strict=True):
            with QSignalBlocker(spin):
                spin.setValue(percent)
        for widget in (self.low, self.high, self.first, self.last, self.whole):
            allow(widget, None if ranged else Finding("action.field-without-ends"))

    def _show_clip(self) -> None:
        box: ClipBox | None = self._display.box
        self.clip.setChecked(self._display.clipping)
        allow(self.clip, why_no_model(self._studio))
        for label, text in zip(self._axes, axes_of(self._studio).titles, strict=True):
            label.setText(text)
        self.handles.setChecked(self._display.handles)
        if box is None:
            return
        span = max(b - a for a, b in zip(box.low, box.high, strict=True))
        for spin, (axis, side) in zip(self.faces, FACES, strict=True):
            with QSignalBlocker(spin):
                spin.setSingleStep(max(0.01, round(span / 100.0, 2)))
                spin.setValue((box.low, box.high)[side][axis])


def _short(value: float) -> str:
    """No more digits than a narrow field shows; of large numbers those behind the point as well."""
    return f"{value:.6g}" if abs(value) < 1e5 else f"{value:.10g}"


def _pair(first: QWidget, second: QWidget, between: str, after: QWidget | None = None) -> QWidget:
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(first, 1)
    layout.addWidget(Label(between))
    layout.addWidget(second, 1)
    if after is not None:
        layout.addWidget(after)
    return row
