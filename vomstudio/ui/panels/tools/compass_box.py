"""Box for compass readings: reading of the selected feature, and north reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QFormLayout, QHBoxLayout, QLineEdit, QPushButton, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.registrations import NorthReference
from vomstudio.project import edits
from vomstudio.project.compass_edits import get_compass, set_compass
from vomstudio.project.kinds import get_kind
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Compass, Model, Record, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import selected_features
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.compass_dialog import CompassDialog, format_north

if TYPE_CHECKING:
    from vomstudio.registration.north import NorthInputs


class CompassBox(QWidget):
    """Box that edits compass readings of planes and lines, and their north reference.

    Parameters
    ----------
    list_names : callable
        Returns the names in use, which a new reading must not have.
    find_north_inputs : callable
        Returns the location and date of the readings to which a compass record applies.
    """

    def __init__(
        self,
        studio: Studio,
        list_names: Callable[[], Sequence[str]],
        find_north_inputs: Callable[[Compass], NorthInputs],
    ) -> None:
        super().__init__()
        self._studio, self._list_names, self._find_north_inputs = (
            studio,
            list_names,
            find_north_inputs,
        )
        self._model: Model | None = None
        self._read_north: NorthReference | None = None
        self.feature_label = ElidedLabel()
        self.reading = QLineEdit()
        self.reading.setObjectName("compass_reading")
        self.reading.setAccessibleName(tr("Compass reading"))
        self.reading.returnPressed.connect(self.add_reading)
        self.add_button = QPushButton(theme.icon("plus"), tr("Add"))
        self.add_button.setObjectName("add_compass_reading")
        self.add_button.clicked.connect(lambda _=False: self.add_reading())
        self.north_button = QPushButton(theme.icon("compass-outline"), "")
        self.north_button.setObjectName("compass_north")
        self.north_button.clicked.connect(lambda _=False: self.edit_north())
        row = QHBoxLayout()
        row.addWidget(self.reading, 1)
        row.addWidget(self.add_button)
        self._form = form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.feature_label)
        form.addRow(tr("Reading"), row)
        form.addRow(tr("North"), self.north_button)
        self._row = row
        studio.settings_changed.connect(self._show_selected)
        studio.selection_changed.connect(self._follow_selection)

    # --- display -----------------------------------------------------------------------------
    def show_model(
        self,
        model: Model | None,
        lines: Sequence[KnownLine],
        read_north: NorthReference | None,
        *,
        is_reading: bool,
    ) -> None:
        """Show the compass readings of a model, or hide the box if they do not apply.

        Parameters
        ----------
        model : Model or None
        lines : sequence of KnownLine
            Known lines and readings on the model.
        read_north : NorthReference or None
            North reference of the azimuths, or None if it is unknown.
        is_reading : bool
            Whether clicks select the planes and lines of new readings.
        """
        self._model, self._read_north = model, read_north
        has_azimuths = any(line.is_read or line.kind == "azimuth" for line in lines)
        self._form.setRowVisible(self.feature_label, is_reading)
        self._form.setRowVisible(self._row, is_reading)
        self._form.setRowVisible(self.north_button, is_reading or has_azimuths)
        self.setVisible(is_reading or has_azimuths)
        compass = None if model is None else get_compass(self._studio.records, model.id)
        self.north_button.setText(format_north(compass, read_north))
        self.north_button.setToolTip(tr("North reference and common error of the azimuths."))
        self.north_button.setEnabled(model is not None)
        self._show_selected()

    def _follow_selection(self, _: object = None) -> None:
        if not self.isVisible():
            # The box is updated when it is shown.
            return
        self._show_selected()
        self._take_field_reading()
        if self.reading.isVisible() and self.reading.isEnabled() and self._outcrop_has_focus():
            # After a click on the outcrop the user types; in a list the keys move the selection.
            self.reading.setFocus()
            self.reading.selectAll()

    def _outcrop_has_focus(self) -> bool:
        from PySide6.QtWidgets import QApplication

        from vomstudio.rendering.qt.viewport import Viewport

        return isinstance(QApplication.focusWidget(), Viewport)

    def _find_feature(
        self, model: Model
    ) -> tuple[Record | None, Measurement | None, Finding | None]:
        """Find the selected plane or line.

        Field-book readings in the selection are skipped.

        Returns
        -------
        Record or None
            The selected plane or line.
        Measurement or None
            Its measurement.
        Finding or None
            Why it cannot have a reading, or None if it can.
        """
        from vomstudio.studio.placing.known_planes import reading_problem

        studio = self._studio
        features = selected_features(studio)
        current = next((i for i in reversed(features) if not _is_field_reading(studio, i)), None)
        current = current or studio.selection.current
        record = None if current is None else studio.records.get(current)
        measurement = None if current is None else studio.measured([current]).get(current)
        return record, measurement, reading_problem(record, model, measurement)

    def _take_field_reading(self) -> None:
        """Enter the field reading that is selected together with a plane or line."""
        from vomstudio.studio.placing.known_planes import field_text, reading_kind

        studio = self._studio
        if self._model is None or self._read_north is None or not self.reading.isEnabled():
            return
        readings = [i for i in selected_features(studio) if _is_field_reading(studio, i)]
        _, measurement, _ = self._find_feature(self._model)
        if len(readings) != 1 or measurement is None:
            return
        text = field_text(
            studio.measured(readings)[readings[0]],
            reading_kind(measurement),
            self._read_north.turned_deg,
            studio.settings.notation,
        )
        if text:
            self.reading.setText(text)

    def _show_selected(self) -> None:
        """Show the name of the selected plane or line, or why it cannot have a reading."""
        if self._model is None:
            return
        from vomstudio.studio.placing.known_planes import reading_kind
        from vomstudio.ui.base.number_formatting import orientation_text

        record, measurement, reason = self._find_feature(self._model)
        notation = self._studio.settings.notation
        example = format_plane(Plane(213.0, 45.0), notation)
        if reason is None and record is not None and measurement is not None:
            if reading_kind(measurement) == "lineation":
                example = "130/25"
            orientation = orientation_text(measurement, notation)
            self.feature_label.setText(
                tr(
                    "{feature}, currently {orientation}",
                    feature=record.name,
                    orientation=orientation,
                )
            )
        else:
            self.feature_label.setText("" if reason is None else reason.message)
        self.feature_label.setToolTip(self.feature_label.text())
        self.reading.setPlaceholderText(tr("such as {example} ± 3", example=example))
        for widget in (self.reading, self.add_button):
            widget.setEnabled(reason is None)
            widget.setToolTip(str(reason or tr("The reading, ± its error in degrees (1σ).")))

    # --- actions -----------------------------------------------------------------------------
    def add_reading(self) -> None:
        """Add the typed value as a reading of the selected plane or line."""
        from vomstudio.studio.placing.known_planes import (
            create_reading,
            parse_reading,
            reading_kind,
        )

        studio = self._studio
        if self._model is None:
            return
        record, measurement, reason = self._find_feature(self._model)
        if reason is not None or measurement is None:
            return
        try:
            reading = parse_reading(
                self.reading.text(), reading_kind(measurement), studio.settings.notation
            )
        except VomError as error:
            studio.warn(error)
            return
        feature = create_reading(record, measurement, reading, self._list_names())
        if studio.attempt(edits.add_features, [feature]):
            self.reading.clear()

    def edit_north(self) -> None:
        """Open the dialog for the north reference of the azimuths."""
        model = self._model
        if model is None:
            return
        previous_compass = get_compass(self._studio.records, model.id)
        dialog = CompassDialog(self, model, previous_compass, self._find_north_inputs)
        if dialog.exec() and dialog.compass not in (None, previous_compass):
            self._studio.attempt(set_compass, dialog.compass)


def _is_field_reading(studio: Studio, id_: str) -> bool:
    feature = get_feature(studio.records, id_)
    return feature is not None and get_kind(feature).evidence == "read"
