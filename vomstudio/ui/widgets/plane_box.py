"""List of the planes of the project, with an entry for the selected plane."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtGui import QIcon

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import has_plane
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, escape_markup
from vomstudio.ui.base.number_formatting import (
    extent_points,
    natural_sort_key,
    orientation_text,
)
from vomstudio.ui.base.studio import Studio

SELECTED = "*"
FAULT = "fault"
"""Id of the fault type, and the word by which other fault types are recognised."""


def _distance_m(measurement: Measurement, position: FloatArray | None) -> float:
    """Return the smallest distance from a feature to the centroid of points, in metres.

    It is infinite if the feature or `position` has no points.
    """
    points = extent_points(measurement)
    if position is None or not len(points):
        return math.inf
    centre = position.mean(axis=0)
    return float(np.linalg.norm(points - centre, axis=1).min())


class PlaneBox(ComboBox):
    """List of planes.

    Parameters
    ----------
    empty_text : str or None
        Text of the entry for no plane, or None if a plane is required.
    includes_selection : bool
        Whether to start with the entry "selected". While the selection is not a plane (for
        example, a new feature), the last plane is kept.
    """

    plane_selected = Signal(str)  # id of a plane, empty for none

    def __init__(self, studio: Studio, empty_text: str | None, includes_selection: bool) -> None:
        super().__init__()
        self._studio = studio
        self._empty_text = empty_text
        self._last_plane_id = ""
        self._plane_id = ""
        self._is_following = includes_selection
        self.keep_narrow()
        self.activated.connect(self._handle_choice)
        studio.selection_changed.connect(self._follow_selection)
        studio.edited.connect(self._follow_edit)
        studio.project_opened.connect(self._list_planes)
        studio.settings_changed.connect(self._handle_settings_change)
        self.show_plane("")

    def show_plane(self, plane_id: str) -> None:
        """Show a plane without emitting a signal."""
        self._plane_id = plane_id
        if plane_id != self._last_plane_id:
            self._is_following = self._is_following and not plane_id
        self._fill([plane_id] if plane_id else [])

    def showPopup(self) -> None:  # noqa: N802
        """List all planes only when the popup opens, because there may be thousands."""
        self._fill(self._sorted_planes())
        super().showPopup()

    def _sorted_planes(self) -> list[str]:
        """Return the plane ids, nearest first; faults come first if the plane is optional."""
        studio = self._studio
        planes = [f for f in studio.session.features() if has_plane(f)]
        measurements = studio.measured(f.id for f in planes)
        place = self._reference_point()
        distances = {f.id: _distance_m(measurements[f.id], place) for f in planes}
        faults = {
            feature_type.id
            for feature_type in studio.session.of(FeatureType)
            if self._empty_text is not None
            and FAULT in (feature_type.id, *feature_type.name.casefold().split())
        }
        planes.sort(
            key=lambda f: (
                getattr(f, "type_id", "") not in faults,
                distances[f.id],
                natural_sort_key(f.name),
            )
        )
        return [f.id for f in planes]

    def _reference_point(self) -> FloatArray | None:
        """Return the points (n, 3) of the open feature, else of the current feature, or None."""
        measurement = getattr(self._studio.open_tool, "measurement", None)
        current = self._studio.selection.current
        if not isinstance(measurement, Measurement) and current is not None:
            measurement = self._studio.measured([current]).get(current)
        is_placed = isinstance(measurement, Measurement) and len(measurement.points) > 0
        return measurement.points if is_placed and measurement is not None else None

    def _fill(self, ids: list[str]) -> None:
        with QSignalBlocker(self):
            self.clear()
            if self._empty_text is not None:
                self.addItem(self._empty_text, "")
            last_request = (
                self._plane_text(self._last_plane_id) if self._last_plane_id else tr("none yet")
            )
            self.addItem(tr("selected: {plane}", plane=last_request), SELECTED)
            for id_ in ids:
                self.addItem(self._type_icon(id_), self._plane_text(id_), id_)
            if self._is_following and (not self._plane_id or self._plane_id == self._last_plane_id):
                self.setCurrentIndex(self.findData(SELECTED))
            else:
                self.setCurrentIndex(self.findData(self._plane_id))
        self.setToolTip(escape_markup(self.currentText()))

    def _type_icon(self, id_: str) -> QIcon:
        measurement = self._studio.measured([id_]).get(id_)
        verdict = None if measurement is None else measurement.verdict
        return theme.verdict_icon(verdict.quality if verdict else None)

    def _plane_text(self, id_: str) -> str:
        record = self._studio.records.get(id_)
        if not has_plane(record) or record is None:
            return tr("a deleted plane")
        measurements = self._studio.measured([id_])[id_]
        return f"{record.name}  {orientation_text(measurements, self._studio.settings.notation)}"

    def _handle_choice(self, index: int) -> None:
        data = str(self.itemData(index))
        self._is_following = data == SELECTED
        self._plane_id = self._last_plane_id if self._is_following else data
        self.setToolTip(escape_markup(self.currentText()))
        self.plane_selected.emit(self._plane_id)

    def _follow_selection(self, ids: tuple[str, ...]) -> None:
        records = self._studio.records
        last_plane_id = next((i for i in reversed(ids) if has_plane(records.get(i))), None)
        if last_plane_id is None or last_plane_id == self._last_plane_id:
            return
        self._last_plane_id = last_plane_id
        if self._is_following:
            self._plane_id = self._last_plane_id
            self.plane_selected.emit(self._last_plane_id)
        self.show_plane(self._plane_id)

    def _follow_edit(self, edit: Edit) -> None:
        if not {self._last_plane_id, self._plane_id} & set(self._studio.affected_ids(edit)):
            return
        if self._last_plane_id and not has_plane(self._studio.records.get(self._last_plane_id)):
            self._last_plane_id = ""
            if self._is_following:
                self._plane_id = ""
                self.plane_selected.emit("")
        self.show_plane(self._plane_id)

    def _handle_settings_change(self) -> None:
        self.show_plane(self._plane_id)

    def _list_planes(self) -> None:
        self._last_plane_id = ""
        self.show_plane("")
