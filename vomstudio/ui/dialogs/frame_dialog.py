"""Dialog that declares the frame of a model whose file does not specify it."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.crs import crs_name, parse_crs
from vomstudio.project.records import Model
from vomstudio.studio.model_loading import OpenModel
from vomstudio.ui.base.controls import ComboBox, Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.window_fitting import fit_height_to_text
from vomstudio.ui.widgets.crs_field import CrsField

_UNITS = (
    (to_translate("metre"), 1.0),
    (to_translate("millimetre"), 0.001),
    (to_translate("centimetre"), 0.01),
    (to_translate("foot"), 0.3048),
    (to_translate("US survey foot"), 1200 / 3937),
    (to_translate("kilometre"), 1000.0),
)
_CRS_CODE_PATTERN = re.compile(r"(EPSG:)?\d{4,}", re.IGNORECASE)


class FrameDialog(QDialog):
    """Dialog for the up axis, unit, and CRS or local frame. `frame` is the accepted frame.

    Parameters
    ----------
    parent : QWidget
    model : Model
    opened_model : OpenModel or None
        Data of the model, if it is loaded.
    project_crs : sequence of str
        CRS of the models of the project; the first one is proposed.
    """

    def __init__(
        self,
        parent: QWidget,
        model: Model,
        opened_model: OpenModel | None,
        project_crs: Sequence[str] = (),
    ) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#frames")
        self.setWindowTitle(tr("Frame of {model}", model=model.name))
        self.setMinimumWidth(480)
        self.frame = model.frame
        # Wait for a pause in typing, because the search for a name reads the whole register.
        self._check_timer = QTimer(self, singleShot=True, interval=300)
        self._check_timer.timeout.connect(self._check)
        intro = Label(_describe_origin(model))
        intro.setWordWrap(True)
        size = Label(_describe_size(opened_model)) if opened_model is not None else Label()
        size.setWordWrap(True)
        self._buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self._buttons.button(QDialogButtonBox.StandardButton.Cancel).setText(tr("Later"))
        self._buttons.accepted.connect(self.accept)
        self._buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(intro)
        layout.addWidget(size)
        for widget in self._make_choices(model.frame.crs, project_crs):
            layout.addWidget(widget)
        layout.addLayout(self._make_form())
        layout.addWidget(self._buttons)
        self._fill(model.frame, opened_model is not None and _has_large_coordinates(opened_model))
        self._check()

    # --- widgets -----------------------------------------------------------------------------
    def _make_choices(self, crs: str | None, project_crs: Sequence[str]) -> tuple[QWidget, ...]:
        """Create the choices, in order from a CRS to an unknown frame."""
        self._crs_button = QRadioButton(tr("Projected coordinates (CRS)"))
        self._local_button = QRadioButton(tr("Local (correct scale, up axis and north)"))
        self._scaled_button = QRadioButton(tr("Scale only (known unit, local orientations)"))
        self._unknown_button = QRadioButton(tr("Unknown (local orientations, model units)"))
        buttons = (self._crs_button, self._local_button, self._scaled_button, self._unknown_button)
        group = QButtonGroup(self)
        for button in buttons:
            group.addButton(button)
            button.toggled.connect(self._check)
        self._crs = CrsField(crs or next(iter(project_crs), ""), project_crs)
        self._crs.setPlaceholderText(tr("Code, name or country"))
        self._crs.setObjectName("frame_crs")
        self._crs.textChanged.connect(self._schedule_check)
        self._crs_message = Label()
        self._crs_message.setWordWrap(True)
        return (self._crs_button, self._crs, self._crs_message, *buttons[1:])

    def _make_form(self) -> QFormLayout:
        self._up_axis_box = ComboBox()
        self._up_axis_box.addItem(tr("Z (x east, y north)"), "z")
        self._up_axis_box.addItem(tr("Y (x east, z south)"), "y")
        self._unit = ComboBox()
        for name, metres in _UNITS:
            self._unit.addItem(tr(name), metres)
        form = QFormLayout()
        form.addRow(tr("Up axis"), self._up_axis_box)
        form.addRow(tr("Unit"), self._unit)
        return form

    def _fill(self, frame: Frame, has_large_coordinates: bool) -> None:
        self._up_axis_box.setCurrentIndex(self._up_axis_box.findData(frame.up_axis))
        self._unit.setCurrentIndex(max(0, self._unit.findData(frame.unit_m)))
        if frame.kind == "crs" or (frame.kind == "undeclared" and has_large_coordinates):
            self._crs_button.setChecked(True)
            self._crs.setFocus()
        elif frame.kind == "local":
            self._local_button.setChecked(True)
        elif frame.kind == "scaled":
            self._scaled_button.setChecked(True)
        else:
            self._unknown_button.setChecked(True)

    # --- validation --------------------------------------------------------------------------
    def _schedule_check(self, text: str) -> None:
        if not text.strip() or _CRS_CODE_PATTERN.fullmatch(text.strip()):
            self._check()
        else:
            ok_button = self._buttons.button(QDialogButtonBox.StandardButton.Ok)
            set_enabled(ok_button, Finding("action.crs-pending"))
            self._check_timer.start()

    def _check(self, *_: object) -> None:
        self._check_timer.stop()
        ok_button = self._buttons.button(QDialogButtonBox.StandardButton.Ok)
        missing_crs_finding = Finding("action.frame-without-crs")
        set_enabled(self._crs, None if self._crs_button.isChecked() else missing_crs_finding)
        unknown_frame_finding = Finding("action.frame-unknown")
        set_enabled(self._unit, unknown_frame_finding if self._unknown_button.isChecked() else None)
        if not self._crs_button.isChecked():
            self._show_message("")
            set_enabled(ok_button, None)
            return
        if not self._crs.text().strip():
            problem = Finding("action.no-crs")
            self._show_message(problem.message)
            set_enabled(ok_button, problem)
            return
        try:
            code, unit = parse_crs(self._crs.text())
        except InputError as error:
            self._show_message(error.message)
            set_enabled(ok_button, cause_finding(error))
            return
        self._show_message(crs_name(code))
        self._unit.setCurrentIndex(max(0, self._unit.findData(unit)))
        set_enabled(ok_button, None)

    def _show_message(self, text: str) -> None:
        self._crs_message.setText(text)
        if self.isVisible():
            fit_height_to_text(self)

    def accept(self) -> None:
        """Set `frame` to the entered frame, and close."""
        up_axis, unit = self._up_axis_box.currentData(), float(self._unit.currentData())
        if self._crs_button.isChecked():
            code, _ = parse_crs(self._crs.text())
            self.frame = Frame("crs", code, unit, up_axis)
        elif self._local_button.isChecked():
            self.frame = Frame("local", None, unit, up_axis)
        elif self._scaled_button.isChecked():
            self.frame = Frame("scaled", None, unit, up_axis)
        else:
            self.frame = Frame("undeclared", None, 1.0, up_axis)
        super().accept()


def _describe_origin(model: Model) -> str:
    """Describe the origin of the model's frame and the effect of declaring a new frame."""
    if model.registration is not None:
        return tr(
            "{model} is registered ({registration}). Declaring a frame replaces this registration.",
            model=model.name,
            registration=model.registration.name,
        )
    if model.frame.kind != "undeclared":
        return tr(
            "The frame determines dip directions and lengths. Undo restores the current frame."
        )
    return tr(
        "The file does not specify its frame. Dip directions and lengths depend on your choice."
    )


def _bounds(opened_model: OpenModel) -> np.ndarray:
    return opened_model.data.bounds


def _has_large_coordinates(opened_model: OpenModel) -> bool:
    return bool(np.abs(_bounds(opened_model)).max() > 1e4)


def _describe_size(opened_model: OpenModel) -> str:
    minimum, maximum = _bounds(opened_model)
    x, y, z = maximum - minimum
    centre = ", ".join(f"{value:,.1f}" for value in (minimum + maximum) / 2)
    size = f"{x:.4g} × {y:.4g} × {z:.4g}"
    if isinstance(opened_model.data, Mesh):
        return tr("Mesh of {size} units (x × y × z), centre at {centre}", size=size, centre=centre)
    return tr(
        "Point cloud of {size} units (x × y × z), centre at {centre}", size=size, centre=centre
    )
