"""Form for the plane and trace length used to map measurable planes."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QLineEdit, QWidget

from vomstudio.core.errors import InputError
from vomstudio.core.words import tr
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.geology.notation import parse_plane
from vomstudio.studio.surfaces.measurable_planes import PLANE_PREFIX, SET_PREFIX
from vomstudio.ui.base.controls import ComboBox, narrow_form
from vomstudio.ui.widgets.options_form import OptionFields

_SELECTED = "selected"


class MeasurablePlane(QWidget):
    """Form for a plane: typed, the mean of a set, or the plane of the selected feature."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._feature = ""
        self.source = ComboBox()
        self.source.setObjectName("measurable_source")
        self.source.keep_narrow()
        self.source.activated.connect(lambda _: self._change_source())
        self.attitude = QLineEdit()
        self.attitude.setObjectName("measurable_attitude")
        self.attitude.setPlaceholderText(tr("dip direction/dip"))
        self.attitude.setToolTip(tr("Enter the attitude, such as 315/38."))
        self.attitude.textChanged.connect(lambda _: self.changed.emit())
        self.options = OptionFields(MeasurableOptions, "measurable")
        self.options.changed.connect(self.changed)
        form = narrow_form()
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("Plane from"), self.source)
        form.addRow(tr("Attitude"), self.attitude)
        self.options.add_rows(form)
        self._form = form
        self.setLayout(form)
        self.list_sources((), "", "")

    def list_sources(self, sets: Sequence[str], feature: str, name: str) -> None:
        """List the available sources of planes.

        Parameters
        ----------
        sets : sequence of str
            Names of the sets in the project.
        feature, name : str
            Id and name of the most recently selected feature, or empty strings if there is none.
        """
        self._feature = feature
        sources = [(tr("entered attitude"), PLANE_PREFIX)]
        sources += [(tr("mean of set {name}", name=item), SET_PREFIX + item) for item in sets]
        if feature:
            sources.append((tr("selected: {name}", name=name), _SELECTED))
        items = [
            (self.source.itemText(i), self.source.itemData(i)) for i in range(self.source.count())
        ]
        if items != sources:
            previous = self.source.currentData()
            with QSignalBlocker(self.source):
                self.source.clear()
                for title, key in sources:
                    self.source.addItem(title, key)
                self.source.setCurrentIndex(max(self.source.findData(previous), 0))
        self._form.setRowVisible(self.attitude, self.source.currentData() == PLANE_PREFIX)

    def plane_source(self) -> str:
        """Return the plane in the form that `measurable_planes.resolve_plane` reads.

        The text is empty if the plane is invalid.
        """
        key = str(self.source.currentData())
        if key == _SELECTED:
            return self._feature
        if key != PLANE_PREFIX:
            return key
        try:
            plane = parse_plane(self.attitude.text().strip(), "dipdir/dip")
        except InputError:
            return ""
        return f"{PLANE_PREFIX}{plane.dip_direction_deg:g}/{plane.dip_deg:g}"

    def show_request(self, source: str, length: float) -> None:
        """Show the plane and trace length of the displayed field."""
        with QSignalBlocker(self.options):
            self.options.show_value("length_m", length)
        if source.startswith(PLANE_PREFIX):
            with QSignalBlocker(self.attitude):
                self.attitude.setText(source.removeprefix(PLANE_PREFIX))
        index = self.source.findData(PLANE_PREFIX if source.startswith(PLANE_PREFIX) else source)
        if index >= 0:
            self.source.setCurrentIndex(index)
        self._form.setRowVisible(self.attitude, self.source.currentData() == PLANE_PREFIX)

    def _change_source(self) -> None:
        self._form.setRowVisible(self.attitude, self.source.currentData() == PLANE_PREFIX)
        self.changed.emit()
