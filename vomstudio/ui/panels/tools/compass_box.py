"""What was read by compass: the reading of the selected plane or line, and from which north."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QFormLayout, QHBoxLayout, QLineEdit, QPushButton, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.registrations import ReadNorth
from vomstudio.project import edits
from vomstudio.project.compass_edits import compass_of, set_compass
from vomstudio.project.kinds import kind_of
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Compass, Model, Record, get_feature
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import selected_features
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.compass_dialog import CompassDialog, north_text

if TYPE_CHECKING:
    from vomstudio.registration.north import North


class CompassBox(QWidget):
    """names : of what is in the lists already, which no reading may have; known : what is known of
    place and day of readings by a compass"""

    def __init__(
        self,
        studio: Studio,
        names: Callable[[], Sequence[str]],
        known: Callable[[Compass], North],
    ) -> None:
        super().__init__()
        self._studio, self._names, self._known = studio, names, known
        self._model: Model | None = None
        self._used: ReadNorth | None = None
        self.of = ElidedLabel()
        self.reading = QLineEdit()
        self.reading.setObjectName("compass_reading")
        self.reading.setAccessibleName(tr("What was read by compass"))
        self.reading.returnPressed.connect(self.take)
        self.add = QPushButton(theme.icon("plus"), tr("Add"))
        self.add.setObjectName("add_compass_reading")
        self.add.clicked.connect(lambda _=False: self.take())
        self.north = QPushButton(theme.icon("compass-outline"), "")
        self.north.setObjectName("compass_north")
        self.north.clicked.connect(lambda _=False: self.ask_for_north())
        row = QHBoxLayout()
        row.addWidget(self.reading, 1)
        row.addWidget(self.add)
        self._form = form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.of)
        form.addRow(tr("Was read as"), row)
        form.addRow(tr("North"), self.north)
        self._row = row
        studio.settings_changed.connect(self._show_selected)
        studio.selection_changed.connect(self._selected)

    # --- what is there -----------------------------------------------------------------------
    def show_for(
        self,
        model: Model | None,
        lines: Sequence[KnownLine],
        used: ReadNorth | None,
        *,
        reading: bool,
    ) -> None:
        """reading : planes and lines are chosen to be read; used : how azimuths are counted, None
        where that cannot be said"""
        self._model, self._used = model, used
        counted = any(line.is_read or line.kind == "azimuth" for line in lines)
        self._form.setRowVisible(self.of, reading)
        self._form.setRowVisible(self._row, reading)
        self._form.setRowVisible(self.north, reading or counted)
        self.setVisible(reading or counted)
        said = None if model is None else compass_of(self._studio.records, model.id)
        self.north.setText(north_text(said, used))
        self.north.setToolTip(
            tr("From which north azimuths were read, and how far that may be off for all alike.")
        )
        self.north.setEnabled(model is not None)
        self._show_selected()

    def _selected(self, _: object = None) -> None:
        if not self.isVisible():
            # Nobody sees it; it is brought up to date when it is shown.
            return
        self._show_selected()
        self._take_field_reading()
        if self.reading.isVisible() and self.reading.isEnabled() and self._outcrop_has_focus():
            # What was clicked on the outcrop is typed at once; a list is gone through by its keys.
            self.reading.setFocus()
            self.reading.selectAll()

    def _outcrop_has_focus(self) -> bool:
        from PySide6.QtWidgets import QApplication

        from vomstudio.rendering.qt.viewport import Viewport

        return isinstance(QApplication.focusWidget(), Viewport)

    def _feature(self, model: Model) -> tuple[Record | None, Measurement | None, Finding | None]:
        """What is selected beside readings of the field book, its measurement, and why it cannot
        have been read."""
        from vomstudio.studio.placing.known_planes import why_not_read

        studio = self._studio
        features = selected_features(studio)
        current = next((i for i in reversed(features) if not _is_field_reading(studio, i)), None)
        current = current or studio.selection.current
        record = None if current is None else studio.records.get(current)
        measured = None if current is None else studio.measured([current]).get(current)
        return record, measured, why_not_read(record, model, measured)

    def _take_field_reading(self) -> None:
        """Of a plane or line that is selected together with a reading of the field book, that is
        what was read."""
        from vomstudio.studio.placing.known_planes import field_text, reading_kind

        studio = self._studio
        if self._model is None or self._used is None or not self.reading.isEnabled():
            return
        read = [i for i in selected_features(studio) if _is_field_reading(studio, i)]
        _, measured, _ = self._feature(self._model)
        if len(read) != 1 or measured is None:
            return
        said = field_text(
            studio.measured(read)[read[0]],
            reading_kind(measured),
            self._used.turned_deg,
            studio.settings.notation,
        )
        if said:
            self.reading.setText(said)

    def _show_selected(self) -> None:
        """Name the plane or line that is selected, or say why none can be read."""
        if self._model is None:
            return
        from vomstudio.studio.placing.known_planes import reading_kind
        from vomstudio.ui.base.number_formatting import orientation_text

        record, measured, why = self._feature(self._model)
        notation = self._studio.settings.notation
        example = format_plane(Plane(213.0, 45.0), notation)
        if why is None and record is not None and measured is not None:
            if reading_kind(measured) == "lineation":
                example = "130/25"
            here = orientation_text(measured, notation)
            self.of.setText(
                tr("{feature}, as it stands {orientation}", feature=record.name, orientation=here)
            )
        else:
            self.of.setText("" if why is None else why.message)
        self.of.setToolTip(self.of.text())
        self.reading.setPlaceholderText(tr("such as {example} ± 3", example=example))
        for part in (self.reading, self.add):
            part.setEnabled(why is None)
            part.setToolTip(
                str(why or tr("The reading, and after ± its error in degrees, one sigma."))
            )

    # --- what is done ------------------------------------------------------------------------
    def take(self) -> None:
        """What was typed becomes a reading of the selected plane or line."""
        from vomstudio.studio.placing.known_planes import (
            create_reading,
            parse_reading,
            reading_kind,
        )

        studio = self._studio
        if self._model is None:
            return
        record, measured, why = self._feature(self._model)
        if why is not None or measured is None:
            return
        try:
            said = parse_reading(
                self.reading.text(), reading_kind(measured), studio.settings.notation
            )
        except VomError as error:
            studio.warn(error)
            return
        new = create_reading(record, measured, said, self._names())
        if studio.attempt(edits.add_features, [new]):
            self.reading.clear()

    def ask_for_north(self) -> None:
        """Let the user say from which north azimuths were read."""
        model = self._model
        if model is None:
            return
        before = compass_of(self._studio.records, model.id)
        dialog = CompassDialog(self, model, before, self._known)
        if dialog.exec() and dialog.compass not in (None, before):
            self._studio.attempt(set_compass, dialog.compass)


def _is_field_reading(studio: Studio, id_: str) -> bool:
    feature = get_feature(studio.records, id_)
    return feature is not None and kind_of(feature).evidence == "read"
