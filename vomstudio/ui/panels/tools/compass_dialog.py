"""Dialog that asks from which north azimuths on a model were read, and how far that may be off."""

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
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.registrations import NorthKind, ReadNorth
from vomstudio.project.records import Compass, Model, compass_id
from vomstudio.ui.base.controls import ComboBox, Label, allow
from vomstudio.ui.base.help_links import explain

if TYPE_CHECKING:
    from vomstudio.registration.north import North

_NORTHS: tuple[tuple[NorthKind, str], ...] = (
    ("grid", to_translate("Grid north: from a map, or turned to it already")),
    ("true", to_translate("True north: the declination was set on the compass")),
    ("magnetic", to_translate("Magnetic north: as the compass shows it")),
)
_PLACE = re.compile(
    r"\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([NS]?)\s*[,;\s]\s*([+-]?\d+(?:\.\d+)?)\s*°?\s*([EW]?)\s*",
    re.IGNORECASE,
)


class CompassDialog(QDialog):
    """compass : what was said, None before it was accepted"""

    def __init__(
        self,
        parent: QWidget | None,
        model: Model,
        before: Compass | None,
        known: Callable[[Compass], North],
    ) -> None:
        """known : what is known of place and day of readings by a compass"""
        super().__init__(parent)
        explain(self, "registration.md#north")
        self.setWindowTitle(tr("North of the readings on {model}", model=model.name))
        self._model, self._known = model, known
        self.compass: Compass | None = None
        there = before or Compass(compass_id(model.id), model.id)
        self.north = ComboBox()
        self.north.setObjectName("compass_from")
        for word, title in _NORTHS:
            self.north.addItem(tr(title), word)
        self.north.setCurrentIndex(self.north.findData(there.north))
        self.day = _field("compass_day", there.day, tr("such as 2024-05-12"))
        place = "" if there.place is None else f"{there.place[1]:.10g}, {there.place[0]:.10g}"
        self.place = _field("compass_place", place, "")
        self.place.setToolTip(tr("Latitude and longitude in degrees, such as 46.52, 11.35."))
        self.declination = _field("compass_declination", _angle_text(there.declination_deg), "")
        self.declination.setToolTip(
            tr("Degrees, east positive; empty for that of the model of the Earth's field.")
        )
        self.doubt = _field("north_doubt", _angle_text(there.doubt_deg), "")
        self.doubt.setToolTip(
            tr(
                "One standard error. What the compass is off for all readings alike does not "
                "become less by more readings."
            )
        )
        self.says = Label()
        self.says.setWordWrap(True)
        self.says.setMinimumHeight(3 * self.says.fontMetrics().lineSpacing())
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self._form = form = QFormLayout()
        form.addRow(tr("Azimuths were read from"), self.north)
        form.addRow(tr("Day of the readings"), self.day)
        form.addRow(tr("Place"), self.place)
        form.addRow(tr("Declination"), self.declination)
        form.addRow(tr("All off alike by (1σ)"), self.doubt)
        column = QVBoxLayout(self)
        column.addLayout(form)
        column.addWidget(self.says)
        column.addStretch()
        column.addWidget(self.buttons)
        self.resize(460, 0)
        self.north.currentIndexChanged.connect(self._say)
        for field in (self.day, self.place, self.declination, self.doubt):
            field.textChanged.connect(self._say)
        self._say()

    # --- what is typed -----------------------------------------------------------------------
    def typed(self) -> Compass:
        """What the fields say. Raises UsageError."""
        from vomstudio.registration.north import parse_angle, parse_day

        declination, doubt = self.declination.text().strip(), self.doubt.text().strip()
        day = self.day.text().strip()
        if day:
            day = parse_day(day).isoformat()
        return Compass(
            compass_id(self._model.id),
            self._model.id,
            self.north.currentData(),
            day,
            parse_place(self.place.text()),
            parse_angle(declination) if declination else None,
            parse_angle(doubt, minimum=0.0) if doubt else None,
        )

    def _say(self, _: object = None) -> None:
        """Show what follows, or what is missing."""
        from vomstudio.registration.north import default_north_sigma_deg
        from vomstudio.studio.placing.read_north import resolve_north

        word: NorthKind = self.north.currentData()
        for field, shown in (
            (self.day, word == "magnetic"),
            (self.place, word != "grid"),
            (self.declination, word == "magnetic"),
        ):
            self._form.setRowVisible(field, shown)
        default_deg = default_north_sigma_deg(word)
        self.doubt.setPlaceholderText(
            tr("{angle:g}°: compass, rocks and steel nearby", angle=default_deg)
            if default_deg
            else tr("0°: north is right")
        )
        problem = None
        try:
            made = self.typed()
            known = self._known(made)
            self._show_known(made, known)
            used, said = resolve_north(made, known)
        except VomError as error:
            made, problem = None, cause_of(error)
        else:
            doubt = tr("All of them may be off alike by {angle:g}° (1σ).", angle=used.doubt_deg)
            self.says.setText(f"{said} {doubt}")
        self._made = made
        if problem is not None:
            self.says.setText(problem.message)
        ok = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        allow(ok, problem)

    def _show_known(self, made: Compass, known: North) -> None:
        """In empty fields what holds instead."""
        place = known.place
        self.place.setPlaceholderText(
            tr("latitude, longitude, such as 46.52, 11.35")
            if place is None
            else tr(
                "{latitude:.3f}, {longitude:.3f}: that of the model",
                latitude=place[1],
                longitude=place[0],
            )
        )
        if place is None or known.day is None or made.north != "magnetic":
            self.declination.setPlaceholderText(tr("by day and place, or typed: east positive"))
            return
        from vomstudio.registration.north import declination_deg

        self.declination.setPlaceholderText(
            tr("{angle:+.2f}° by IGRF-14", angle=declination_deg(*place, known.day))
        )

    def accept(self) -> None:
        """Keep it in `compass`."""
        if self._made is not None:
            self.compass = self._made
            super().accept()


def _field(name: str, text: str, empty: str) -> QLineEdit:
    field = QLineEdit(text)
    field.setObjectName(name)
    field.setPlaceholderText(empty)
    return field


def _angle_text(angle_deg: float | None) -> str:
    return "" if angle_deg is None else f"{angle_deg:.10g}"


def parse_place(text: str) -> tuple[float, float] | None:
    """Longitude and latitude of a text that has the latitude first; None for an empty one. Raises
    UsageError."""
    from vomstudio.geometry.coordinate_limits import check_on_earth

    if not text.strip():
        return None
    found = _PLACE.fullmatch(text)
    if found is None:
        raise UsageError(Finding("place.invalid", text=text.strip()))
    latitude = float(found[1]) * (-1.0 if found[2].upper() == "S" else 1.0)
    longitude = float(found[3]) * (-1.0 if found[4].upper() == "W" else 1.0)
    if (why := check_on_earth(longitude, latitude)) is not None:
        raise UsageError(why)
    return longitude, latitude


def north_text(said: Compass | None, used: ReadNorth | None) -> str:
    """What a button says of it. used : None where it cannot be said how azimuths are counted"""
    if said is None:
        return tr("Grid north, not doubted: say if not")
    name = {"grid": tr("Grid north"), "true": tr("True north"), "magnetic": tr("Magnetic north")}
    word = name[said.north]
    if used is None:
        return tr("{north}: more is needed", north=word)
    doubt = f"± {used.doubt_deg:g}°"
    if said.north == "grid":
        return f"{word} {doubt}"
    return tr("{north}: {turn:+.1f}° {doubt}", north=word, turn=used.turned_deg, doubt=doubt)
