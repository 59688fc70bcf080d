"""Dialog for the north reference of the azimuths on a model and its standard error."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import UsageError, VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.registrations import NorthKind, NorthReference
from vomstudio.project.records import Compass, Model, compass_id
from vomstudio.ui.base.controls import ComboBox, Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic

if TYPE_CHECKING:
    from vomstudio.registration.north import NorthInputs

_NORTHS: tuple[tuple[NorthKind, str], ...] = (
    ("grid", to_translate("Grid north (map, or already corrected)")),
    ("true", to_translate("True north (declination set on compass)")),
    ("magnetic", to_translate("Magnetic north (compass)")),
)
_PLACE = re.compile(
    r"\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([NS]?)\s*[,;\s]\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([EW]?)\s*",
    re.IGNORECASE,
)


class CompassDialog(QDialog):
    """Dialog that edits the north reference of compass readings.

    Attributes
    ----------
    compass : Compass or None
        The accepted record, or None before the dialog is accepted.
    """

    def __init__(
        self,
        parent: QWidget | None,
        model: Model,
        previous_compass: Compass | None,
        find_north_inputs: Callable[[Compass], NorthInputs],
    ) -> None:
        """Show the previous compass record, or the default if none is given.

        Parameters
        ----------
        find_north_inputs : callable
            Returns the location and date of the readings to which a compass record applies.
        """
        super().__init__(parent)
        set_help_topic(self, "registration.md#north")
        self.setWindowTitle(tr("North reference of the readings on {model}", model=model.name))
        self._model, self._find_north_inputs = model, find_north_inputs
        self.compass: Compass | None = None
        initial = previous_compass or Compass(compass_id(model.id), model.id)
        self.north = ComboBox()
        self.north.setObjectName("compass_from")
        for north_kind, title in _NORTHS:
            self.north.addItem(tr(title), north_kind)
        self.north.setCurrentIndex(self.north.findData(initial.north))
        self.day = _field("compass_day", initial.day, tr("such as 2024-05-12"))
        place = "" if initial.place is None else f"{initial.place[1]:.10g}, {initial.place[0]:.10g}"
        self.place = _field("compass_place", place, "")
        self.place.setToolTip(tr("Latitude and longitude in degrees, such as 46.52, 11.35."))
        self.declination = _field("compass_declination", _angle_text(initial.declination_deg), "")
        self.declination.setToolTip(
            tr("Degrees, east positive; if empty, from the magnetic field model.")
        )
        self.doubt = _field("north_doubt", _angle_text(initial.doubt_deg), "")
        self.doubt.setToolTip(
            tr("Common error of all readings (1σ); more readings do not reduce it.")
        )
        self.summary = Label()
        self.summary.setWordWrap(True)
        self.summary.setMinimumHeight(3 * self.summary.fontMetrics().lineSpacing())
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self._form = form = QFormLayout()
        form.addRow(tr("Azimuths refer to"), self.north)
        form.addRow(tr("Date of readings"), self.day)
        form.addRow(tr("Place"), self.place)
        form.addRow(tr("Declination"), self.declination)
        form.addRow(tr("Common error (1σ)"), self.doubt)
        column = QVBoxLayout(self)
        column.addLayout(form)
        column.addWidget(self.summary)
        column.addStretch()
        column.addWidget(self.buttons)
        self.resize(460, 0)
        self.north.currentIndexChanged.connect(self._update_summary)
        for field in (self.day, self.place, self.declination, self.doubt):
            field.textChanged.connect(self._update_summary)
        self._update_summary()

    # --- fields ------------------------------------------------------------------------------
    def parse_fields(self) -> Compass:
        """Create the compass record from the fields.

        Raises
        ------
        UsageError
            If a field cannot be parsed.
        """
        from vomstudio.registration.north import parse_angle, parse_day

        declination, doubt = self.declination.text().strip(), self.doubt.text().strip()
        day = self.day.text().strip()
        if day:
            day = parse_day(day).isoformat()
        return Compass(
            id=compass_id(self._model.id),
            model_id=self._model.id,
            north=self.north.currentData(),
            day=day,
            place=parse_geographic_position(self.place.text()),
            declination_deg=parse_angle(declination) if declination else None,
            doubt_deg=parse_angle(doubt, minimum=0.0) if doubt else None,
        )

    def _update_summary(self, _: object = None) -> None:
        """Show the resulting north correction, or the first invalid field."""
        from vomstudio.registration.north import default_north_sigma_deg
        from vomstudio.studio.placing.read_north import resolve_north

        north_kind: NorthKind = self.north.currentData()
        for field, is_visible in (
            (self.day, north_kind == "magnetic"),
            (self.place, north_kind != "grid"),
            (self.declination, north_kind == "magnetic"),
        ):
            self._form.setRowVisible(field, is_visible)
        default_deg = default_north_sigma_deg(north_kind)
        self.doubt.setPlaceholderText(
            tr("{angle:g}°: compass, nearby rocks and steel", angle=default_deg)
            if default_deg
            else tr("0°: north is exact")
        )
        problem = None
        try:
            compass = self.parse_fields()
            inputs = self._find_north_inputs(compass)
            self._show_placeholders(compass, inputs)
            read_north, text = resolve_north(compass, inputs)
        except VomError as error:
            compass, problem = None, cause_finding(error)
        else:
            doubt = tr(
                "They may have a common error of {angle:g}° (1σ).", angle=read_north.doubt_deg
            )
            self.summary.setText(f"{text} {doubt}")
        self._current = compass
        if problem is not None:
            self.summary.setText(problem.message)
        ok_button = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        set_enabled(ok_button, problem)

    def _show_placeholders(self, compass: Compass, inputs: NorthInputs) -> None:
        """Show the default values of empty fields as placeholders."""
        place = inputs.location
        self.place.setPlaceholderText(
            tr("latitude, longitude, such as 46.52, 11.35")
            if place is None
            else tr(
                "{latitude:.3f}, {longitude:.3f} (model)",
                latitude=place[1],
                longitude=place[0],
            )
        )
        if place is None or inputs.day is None or compass.north != "magnetic":
            self.declination.setPlaceholderText(tr("automatic, or degrees east"))
            return
        from vomstudio.registration.north import declination_deg

        self.declination.setPlaceholderText(
            tr("{angle:+.2f}° from IGRF-14", angle=declination_deg(*place, inputs.day))
        )

    def accept(self) -> None:
        """Store the record in `compass` and close the dialog."""
        if self._current is not None:
            self.compass = self._current
            super().accept()


def _field(name: str, text: str, placeholder: str) -> QLineEdit:
    field = QLineEdit(text)
    field.setObjectName(name)
    field.setPlaceholderText(placeholder)
    return field


def _angle_text(angle_deg: float | None) -> str:
    return "" if angle_deg is None else f"{angle_deg:.10g}"


def parse_geographic_position(text: str) -> tuple[float, float] | None:
    """Parse a geographic position given as latitude and longitude.

    Returns
    -------
    (float, float) or None
        Longitude and latitude in degrees, or None for an empty text.

    Raises
    ------
    UsageError
        If the text has another form or is not a position on Earth.
    """
    from vomstudio.geometry.coordinate_limits import check_longitude_latitude

    if not text.strip():
        return None
    match = _PLACE.fullmatch(text)
    if match is None:
        raise UsageError(Finding("place.invalid", text=text.strip()))
    latitude = float(match[1]) * (-1.0 if match[2].upper() == "S" else 1.0)
    longitude = float(match[3]) * (-1.0 if match[4].upper() == "W" else 1.0)
    if (reason := check_longitude_latitude(longitude, latitude)) is not None:
        raise UsageError(reason)
    return longitude, latitude


def format_north(compass: Compass | None, north_reference: NorthReference | None) -> str:
    """Format the north reference of a compass record for a button.

    If `north_reference` is None, the text reports that the record is incomplete.
    """
    if compass is None:
        return tr("Grid north, assumed exact")
    name = {"grid": tr("Grid north"), "true": tr("True north"), "magnetic": tr("Magnetic north")}
    north = name[compass.north]
    if north_reference is None:
        return tr("{north}: incomplete", north=north)
    doubt = f"± {north_reference.doubt_deg:g}°"
    if compass.north == "grid":
        return f"{north} {doubt}"
    return tr(
        "{north}: {turn:+.1f}° {doubt}", north=north, turn=north_reference.turned_deg, doubt=doubt
    )
