"""The page with the residuals of each photo after the bundle adjustment."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QHBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.studio.jobs.inspection_tasks import AlignmentOverview
from vomstudio.ui.base.controls import ComboBox, ElidedLabel, Label, add_splitter, create_column
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData, Arrays, ShownPhoto
from vomstudio.ui.dialogs.alignment.residual_scale import exaggeration
from vomstudio.ui.widgets.number_table import Column, NumberTable
from vomstudio.ui.widgets.pane_painters import vector_painter
from vomstudio.ui.widgets.picture_panes import PicturePanes

_FACTORS = (1, 10, 20, 50, 100, 200, 500, 1000)
_MOST = 2000
"""More lines than this hide the photo and each other."""
_COLOR = QColor(240, 228, 66)


class ResidualPage(QWidget):
    """A list of the photos with their errors, and one photo with its residuals as vectors."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._wanted = ""
        self._photo: ShownPhoto | None = None
        self._arrays: Arrays | None = None
        self._said = ElidedLabel()
        self._summary = Label()
        self._summary.setWordWrap(True)
        self.table = NumberTable(
            (
                Column(tr("Photo"), number=False),
                Column(tr("Tie points"), "{:,}".format),
                Column(
                    tr("Median error"),
                    "{:.2f} px".format,
                    tr("Median reprojection error of the tie points."),
                ),
                Column(tr("Max. error"), "{:.1f} px".format, tr("Largest reprojection error.")),
                Column(
                    tr("GPS residual"),
                    "{:.2f} m".format,
                    tr("Distance between the GPS position of the photo and its camera."),
                ),
            ),
            sort_by=2,
            descending=True,
        )
        self.table.setObjectName("residual_table")
        self.table.row_selected.connect(lambda values: self.show_photo(values[0]))
        self.factor = ComboBox()
        self.factor.setObjectName("factor")
        self.factor.addItem(tr("Automatic"), 0)
        for value in _FACTORS:
            self.factor.addItem(f"× {value:,}", value)
        self.factor.currentIndexChanged.connect(lambda _: self._draw())
        self.panes = PicturePanes(1)
        self.panes.setObjectName("residual_panes")
        self._arrange()

    def _arrange(self) -> None:
        side, column = create_column()
        column.addWidget(self._summary)
        column.addWidget(self.table, 1)
        right, rows = create_column()
        row = QHBoxLayout()
        row.addWidget(self._said, 1)
        row.addWidget(Label(tr("Exaggeration")))
        row.addWidget(self.factor)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        add_splitter(self, side, right, [520, 740])

    def fill(self) -> None:
        """Show the photos of the overview, and the one with the largest median error."""
        facts = self._data.overview
        rows: list[tuple[tuple[Any, ...], str]] = []
        for photo in facts.photos:
            note = ""
            if photo.part is None:
                note = tr("Not aligned: {reason}", reason=photo.reason or "–")
            elif photo.part > 0:
                note = tr("Aligned in a disconnected component, which is not part of the model.")
            values = (
                photo.name,
                photo.tie_points,
                photo.error_px,
                photo.largest_px,
                photo.gps_m,
            )
            rows.append((values, note))
        self._summary.setText(self._words(facts))
        self.table.fill(rows)
        if rows:
            self.table.select_row(lambda values: values[2] is not None)

    def _words(self, facts: AlignmentOverview) -> str:
        error = facts.reprojection_error_px
        if error is None:
            words = tr("{tie_points:,} tie points.", tie_points=facts.tie_points)
        else:
            words = tr(
                "{tie_points:,} tie points, mean reprojection error {error:.2f} px.",
                tie_points=facts.tie_points,
                error=error,
            )
        registered = facts.registration
        if "refused" in registered:
            words += " " + tr(
                "There are no GPS residuals: {reason}",
                reason=format_sentence(registered["refused"]),
            )
        elif registered.get("rms_m") is not None:
            words += " " + tr(
                "RMS residual of the GPS positions: {rms:.2f} m.", rms=registered["rms_m"]
            )
        elif registered.get("rms_control_m") is not None:
            words += " " + tr(
                "RMS residual of the control points: {rms:.3f} m.",
                rms=registered["rms_control_m"],
            )
        return words

    def show_photo(self, name: str) -> None:
        """Show the photo of this name and its residuals."""
        self._wanted, self._photo, self._arrays = name, None, None
        self._said.setText("")
        self.panes.show_message(tr("Reading…"))
        self._data.photo(name, partial(self._photo_there, name))
        self._data.residuals(name, partial(self._arrays_there, name), self.panes.show_message)

    def _photo_there(self, name: str, photo: ShownPhoto) -> None:
        if name == self._wanted:
            self._photo = photo
            self._draw(fresh=True)

    def _arrays_there(self, name: str, arrays: Arrays) -> None:
        if name == self._wanted:
            self._arrays = arrays
            self._draw(fresh=True)

    def _draw(self, *, fresh: bool = False) -> None:
        photo, arrays = self._photo, self._arrays
        if photo is None or arrays is None:
            return
        if fresh:
            self.panes.show_message("")
            self.panes.show_pictures([photo.picture])
        if not len(arrays["pixels"]):
            self._said.setText(tr("This photo has no tie points and is not part of the model."))
            self.panes.set_overlays([])
            return
        lengths = np.linalg.norm(arrays["vectors"], axis=1)
        factor = int(self.factor.currentData())
        if not factor:
            factor = exaggeration(lengths, max(photo.width, photo.height))
        self._said.setText(
            tr(
                "Residuals exaggerated {factor:,} times; median {median:.2f} px, largest "
                "{largest:.1f} px.",
                factor=factor,
                median=float(np.median(lengths)),
                largest=float(lengths.max()),
            )
        )
        step = -(-len(lengths) // _MOST)
        if step > 1:
            said = tr("One in {step} is drawn.", step=step)
            self._said.setText(f"{self._said.text()} {said}")
        places = photo.upright_points(arrays["pixels"][::step])
        offsets = photo.upright_vectors(arrays["vectors"][::step])
        self.panes.set_overlays([vector_painter(places, offsets, factor, _COLOR)])
