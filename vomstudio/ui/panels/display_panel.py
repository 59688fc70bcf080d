"""Display panel: mode, point size, lighting, scalar field, colour range and clipping box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
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
from vomstudio.rendering.view.clipping import BOX_FACES, ClipBox
from vomstudio.rendering.view.scalars import (
    DEFAULT_PERCENTILES,
    ELEVATION,
    PALETTES,
    FieldStyle,
    Scale,
    field_names,
    field_title,
)
from vomstudio.studio import display
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import missing_model_finding
from vomstudio.ui.base.controls import (
    ComboBox,
    DoubleSpinBox,
    Label,
    PanelScrollArea,
    escape_markup,
    narrow_form,
    set_enabled,
)
from vomstudio.ui.base.feature_colors import COLOR_MODES
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.axis_titles import project_axes

if TYPE_CHECKING:
    from vomstudio.rendering.qt.display import ModelAppearance
    from vomstudio.rendering.qt.viewport import Viewport

# Width of a field in the narrowest dock.
_MIN_FIELD_WIDTH_PX, _SUFFIX_WIDTH_PX = 64, 8
_KIND_NAMES = {
    "diverging": to_translate("Diverging about zero"),
    "cyclic": to_translate("Cyclic"),
    "categories": to_translate("One colour per class"),
}


class DisplayPanel(QWidget):
    """Panel with the display settings.

    Parameters
    ----------
    studio : Studio
    actions : dict of QAction
    find_current_model : callable
        Returns the model whose scalar field is displayed, or None.
    """

    def __init__(
        self,
        studio: Studio,
        actions: dict[str, QAction],
        find_current_model: Callable[[], Model | None],
    ) -> None:
        super().__init__()
        set_help_topic(self, "window.md#change-the-display")
        self._models_box: Callable[[], ClipBox | None] = lambda: None
        self._studio, self._display, self._find_current_model = (
            studio,
            studio.display,
            find_current_model,
        )
        self._actions = actions
        self._view_display: ModelAppearance | None = None
        page = QWidget()
        layout = QVBoxLayout(page)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addLayout(self._make_appearance_form())
        layout.addWidget(self._make_field_group())
        layout.addWidget(self._make_clipping_group(actions["clipping_reset"]))
        layout.addStretch()
        outer_layout = QVBoxLayout(self)
        outer_layout.setContentsMargins(0, 0, 0, 0)
        outer_layout.addWidget(PanelScrollArea(page))
        for signal in (
            self._display.changed,
            studio.model_loaded,
            studio.selection_changed,
            studio.edited,
            studio.project_opened,
            studio.settings_changed,
        ):
            signal.connect(self.refresh)
        self.refresh()

    def watch(self, viewport: Viewport, models_box: Callable[[], ClipBox | None]) -> None:
        """Connect the panel to the viewport whose field ranges it shows.

        Parameters
        ----------
        viewport : Viewport
        models_box : callable
            Returns the bounding box of all visible models, or None.
        """
        self._models_box = models_box
        self._view_display = viewport.display
        viewport.field_shown.connect(self.refresh)

    # --- parts -------------------------------------------------------------------------------
    def _make_appearance_form(self) -> QFormLayout:
        self.mode = ComboBox()
        for value, text in display.MODES.items():
            self.mode.addItem(tr(text), value)
        self.mode.activated.connect(self._change_mode)
        self.point_size = DoubleSpinBox()
        self.point_size.setMinimumWidth(_MIN_FIELD_WIDTH_PX)
        self.point_size.setRange(0.0, 20.0)
        self.point_size.setDecimals(0)
        self.point_size.setSpecialValueText(tr("Automatic (fill gaps)"))
        self.point_size.setSuffix(tr(" px"))
        self.point_size.valueChanged.connect(lambda v: self._display.set_point_size(v or None))
        self.lighting = QCheckBox(tr("Lit"))
        self.lighting.clicked.connect(
            lambda is_checked: self._display.set_lit(self._current_mode(), is_checked)
        )
        self.eye_dome = QCheckBox(tr("Eye-dome lighting"))
        self.eye_dome.clicked.connect(self._display.set_eye_dome)
        row = QHBoxLayout()
        row.addWidget(self.lighting)
        row.addWidget(self.eye_dome, 1)
        form = narrow_form()
        form.addRow(tr("Mode"), self.mode)
        form.addRow(tr("Point size"), self.point_size)
        form.addRow(tr("Lighting"), row)
        self.colors = ComboBox()
        self.colors.setObjectName("feature_colors")
        self.colors.setToolTip(tr("Colours of the features in the outcrop, net and table."))
        for value, title in COLOR_MODES.items():
            self.colors.addItem(tr(title), value)
        self.colors.activated.connect(
            lambda _: self._actions[f"color_by_{self.colors.currentData()}"].trigger()
        )
        form.addRow(tr("Colour by"), self.colors)
        return form

    def _make_field_group(self) -> QGroupBox:
        self.field_box = QGroupBox()
        self.field = ComboBox()
        self.field.setObjectName("field")
        self.field.activated.connect(self._change_field)
        self.palette_box = ComboBox()
        self.palette_box.activated.connect(
            lambda _: self._restyle(palette=self.palette_box.currentData())
        )
        self.low, self.high = QLineEdit(), QLineEdit()
        for edit, name in ((self.low, "low"), (self.high, "high")):
            edit.setObjectName(f"field_{name}")
            edit.setToolTip(tr("Leave empty to use the percentile."))
            edit.editingFinished.connect(lambda e=edit, n=name: self._set_limit(e, n))
        self.first_percentile, self.last_percentile = DoubleSpinBox(), DoubleSpinBox()
        for spin in (self.first_percentile, self.last_percentile):
            spin.setMinimumWidth(_MIN_FIELD_WIDTH_PX + _SUFFIX_WIDTH_PX)
            spin.setRange(0.0, 100.0)
            spin.setDecimals(1)
            spin.setSuffix(" %")
            spin.setKeyboardTracking(False)
            spin.valueChanged.connect(self._change_percentiles)
        self.reset_range = QToolButton()
        self.reset_range.setIcon(theme.icon("restore"))
        self.reset_range.setToolTip(tr("Reset the range to the 2nd and 98th percentiles."))
        self.reset_range.clicked.connect(
            lambda: self._restyle(low=None, high=None, percentiles=DEFAULT_PERCENTILES)
        )
        form = narrow_form()
        form.addRow(tr("Field"), self.field)
        form.addRow(tr("Colour map"), self.palette_box)
        form.addRow(tr("Range"), _pair_row(self.low, self.high, tr("to")))
        percentiles = _pair_row(
            self.first_percentile, self.last_percentile, tr("to"), self.reset_range
        )
        form.addRow(tr("Percentiles"), percentiles)
        self.field_box.setLayout(form)
        form.setContentsMargins(8, 4, 8, 6)
        return self.field_box

    def _make_clipping_group(self, reset_action: QAction) -> QGroupBox:
        self.clip = QGroupBox(tr("Clipping box"))
        self.clip.setCheckable(True)
        self.clip.setToolTip(tr("Show only the part inside this box."))
        self.clip.clicked.connect(self._toggle_clipping)
        grid = QGridLayout(self.clip)
        grid.setContentsMargins(8, 4, 8, 6)
        grid.setSpacing(3)
        self._axis_labels = [Label() for _ in range(3)]
        self.faces: list[QDoubleSpinBox] = []
        for k, (axis, side) in enumerate(BOX_FACES):
            spin = DoubleSpinBox()
            spin.setObjectName(f"clip_{'xyz'[axis]}{side}")
            spin.setRange(-1e9, 1e9)
            spin.setDecimals(2)
            spin.setStepType(QDoubleSpinBox.StepType.DefaultStepType)
            spin.setKeyboardTracking(False)
            spin.setMinimumWidth(_MIN_FIELD_WIDTH_PX)
            spin.valueChanged.connect(lambda value, n=k: self._move_face(n, value))
            self.faces.append(spin)
            grid.addWidget(spin, axis, 1 + side)
        for axis, label in enumerate(self._axis_labels):
            grid.addWidget(label, axis, 0)
        self.handles = QCheckBox(tr("Show handles"))
        self.handles.clicked.connect(self._display.set_handles)
        button = QPushButton(tr("Fit to models"))
        button.clicked.connect(reset_action.trigger)
        grid.addWidget(self.handles, 3, 0, 1, 2)
        grid.addWidget(button, 3, 2)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(2, 1)
        self._clip_callback: Callable[[], None] = lambda: None
        return self.clip

    def set_clip_callback(self, callback: Callable[[], None]) -> None:
        """Set the function that switches the clipping box on or off."""
        self._clip_callback = callback

    # --- actions -----------------------------------------------------------------------------
    def _change_mode(self, _: int) -> None:
        mode = self.mode.currentData()
        if mode == "field":
            self._display.show_field(*self._current_style()) if self._has_model() else None
        else:
            self._display.set_mode(mode)

    def _current_mode(self) -> str:
        models = [m.data for m in self._studio.models.values()]
        return display.effective_mode(self._display.mode, models)

    def _has_model(self) -> bool:
        model = self._find_current_model()
        return model is not None and model.id in self._studio.models

    def _current_style(self) -> tuple[str, FieldStyle]:
        model = self._find_current_model()
        assert model is not None
        style = self._display.styles.get(model.id)
        if style is None:
            style = FieldStyle(display.default_field(self._studio.models[model.id].data))
        return model.id, style

    def _change_field(self, _: int) -> None:
        model = self._find_current_model()
        if model is not None:
            self._display.show_field(model.id, FieldStyle(self.field.currentData()))

    def _restyle(self, **values: object) -> None:
        if not self._has_model():
            return
        model_id, style = self._current_style()
        changed_style = replace(style, **values)  # type: ignore[arg-type]
        if changed_style != style:
            self._display.show_field(model_id, changed_style)

    def _set_limit(self, edit: QLineEdit, name: str) -> None:
        if not edit.isModified():
            return
        edit.setModified(False)
        text = edit.text().strip()
        value = parse_number(text)
        if text and value is None:
            self._studio.warn(Finding("number.invalid", text=text))
            self.refresh()
            return
        style = self._current_style()[1]
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

    def _change_percentiles(self, _: float) -> None:
        first_percentile, last_percentile = (
            self.first_percentile.value(),
            self.last_percentile.value(),
        )
        if first_percentile < last_percentile:
            self._restyle(percentiles=(first_percentile, last_percentile), low=None, high=None)
        else:
            self.refresh()

    def _toggle_clipping(self, _: bool) -> None:
        self._clip_callback()
        self.refresh()

    def _move_face(self, face: int, value: float) -> None:
        box = self._display.box
        if box is not None:
            axis, side = BOX_FACES[face]
            if (problem := self._move_problem(axis, value)) is not None:
                self._studio.warn(problem)
                self._show_clip()
                return
            self._display.set_clip(box.move_face(axis, side, value))

    def _move_problem(self, axis: int, value: float) -> Finding | None:
        """Return why a face of the clipping box cannot be moved to a coordinate, or None."""
        models_box = self._models_box()
        if models_box is None:
            return check_coordinates((value,))
        bounds = np.array([models_box.low, models_box.high])
        point = bounds.mean(axis=0)
        point[axis] = value
        return check_near_model(point.tolist(), bounds)

    # --- display -----------------------------------------------------------------------------
    def _scale(self) -> Scale | None:
        model = self._find_current_model()
        if model is None or self._view_display is None:
            return None
        return self._view_display.color_scale(model.id)

    def refresh(self, *changes: object) -> None:
        """Show the current settings. `changes` are the arguments of `Display.changed`."""
        if changes == ("box",):
            self._show_clip()
            return
        self.colors.setCurrentIndex(self.colors.findData(self._studio.settings.color_by))
        settings = self._display
        models = [m.data for m in self._studio.models.values()]
        mode = display.effective_mode(settings.mode, models)
        reasons = []
        for k, value in enumerate(display.MODES):
            reason = display.mode_problem(value, models)
            flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
            item_flags = flags if reason is None else Qt.ItemFlag.NoItemFlags
            self.mode.model().item(k).setFlags(item_flags)  # type: ignore[attr-defined]
            self.mode.setItemData(k, str(reason or ""), Qt.ItemDataRole.ToolTipRole)
            if reason is not None and models:
                reasons.append(f"{tr(display.MODES[value])}: {reason}")
        self.mode.setCurrentIndex(self.mode.findData(mode))
        self.mode.setToolTip(escape_markup("\n".join(reasons)))
        set_enabled(self.mode, missing_model_finding(self._studio))
        with QSignalBlocker(self.point_size):
            self.point_size.setValue(settings.point_size or 0.0)
        for box, reason, is_on in (
            (self.lighting, display.lighting_problem(models), settings.lit[mode]),
            (self.eye_dome, display.eye_dome_problem(models), settings.eye_dome),
        ):
            set_enabled(box, reason)
            box.setChecked(is_on)
        self._show_field()
        self._show_clip()

    def _show_field(self) -> None:
        model = self._find_current_model()
        open_model = None if model is None else self._studio.models.get(model.id)
        reason = missing_model_finding(self._studio)
        if open_model is None and reason is None:
            reason = Finding("model.not-open")
        set_enabled(self.field_box, reason)
        if model is None or open_model is None:
            self._clear_field()
            return
        self.field_box.setTitle(tr("Scalar field of {model}", model=model.name))
        with QSignalBlocker(self.field):
            self.field.clear()
            for name in field_names(open_model.data):
                self.field.addItem(
                    tr("Elevation (Z)") if name == ELEVATION else field_title(name), name
                )
        style = self._current_style()[1]
        if self.field.findData(style.name) < 0:
            # A project stores the display style of a field, but not always its values.
            with QSignalBlocker(self.field):
                self.field.addItem(
                    Finding("field.not-calculated", field=field_title(style.name)).message,
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
            index = self.palette_box.findData(style.palette)
            self.palette_box.setCurrentIndex(max(index, 0))
        has_range = kind in ("sequential", "diverging")
        ends = scale.end_texts() if scale is not None and has_range else ("", "")
        for edit, value, text in (
            (self.low, style.low, ends[0]),
            (self.high, style.high, ends[1]),
        ):
            if not edit.hasFocus() or not edit.isModified():
                edit.setText("" if value is None else _number_text(value))
                edit.setCursorPosition(0)
            edit.setPlaceholderText(text)
        for spin, percent in zip(
            (self.first_percentile, self.last_percentile), style.percentiles, strict=True
        ):
            with QSignalBlocker(spin):
                spin.setValue(percent)
        for widget in (
            self.low,
            self.high,
            self.first_percentile,
            self.last_percentile,
            self.reset_range,
        ):
            set_enabled(widget, None if has_range else Finding("action.field-without-ends"))

    def _clear_field(self) -> None:
        self.field_box.setTitle(tr("Scalar field"))
        self.field.clear()
        self.palette_box.clear()
        for edit in (self.low, self.high):
            edit.clear()
            edit.setPlaceholderText("")
        percentiles = FieldStyle("").percentiles
        for spin, percent in zip(
            (self.first_percentile, self.last_percentile), percentiles, strict=True
        ):
            with QSignalBlocker(spin):
                spin.setValue(percent)

    def _show_clip(self) -> None:
        box: ClipBox | None = self._display.box
        self.clip.setChecked(self._display.clipping)
        set_enabled(self.clip, missing_model_finding(self._studio))
        for label, text in zip(self._axis_labels, project_axes(self._studio).titles, strict=True):
            label.setText(text)
        self.handles.setChecked(self._display.handles)
        if box is None:
            for spin in self.faces:
                with QSignalBlocker(spin):
                    spin.setValue(0.0)
            return
        span = max(b - a for a, b in zip(box.low, box.high, strict=True))
        for spin, (axis, side) in zip(self.faces, BOX_FACES, strict=True):
            with QSignalBlocker(spin):
                spin.setSingleStep(max(0.01, round(span / 100.0, 2)))
                spin.setValue((box.low, box.high)[side][axis])


def _number_text(value: float) -> str:
    """Format a number for a narrow field, keeping the decimals of large numbers."""
    return f"{value:.6g}" if abs(value) < 1e5 else f"{value:.10g}"


def _pair_row(
    first_widget: QWidget,
    second_widget: QWidget,
    separator: str,
    extra_widget: QWidget | None = None,
) -> QWidget:
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(first_widget, 1)
    layout.addWidget(Label(separator))
    layout.addWidget(second_widget, 1)
    if extra_widget is not None:
        layout.addWidget(extra_widget)
    return row
