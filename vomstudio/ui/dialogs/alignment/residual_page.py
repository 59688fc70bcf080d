"""Page with the residuals of each photo after the bundle adjustment."""

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

_EXAGGERATION_FACTORS = (1, 10, 20, 50, 100, 200, 500, 1000)
_MAX_VECTORS = 2000
"""Maximum number of vectors; more would hide the photo and each other."""
_COLOR = QColor(240, 228, 66)


class ResidualPage(QWidget):
    """Page with a list of photos and errors, and one photo with residual vectors."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._photo_name = ""
        self._photo: ShownPhoto | None = None
        self._arrays: Arrays | None = None
        self._message = ElidedLabel()
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
                    tr("Distance between the photo's GPS position and its computed position."),
                ),
            ),
            sort_by=2,
            is_descending=True,
        )
        self.table.setObjectName("residual_table")
        self.table.row_selected.connect(lambda values: self.show_photo(values[0]))
        self.factor = ComboBox()
        self.factor.setObjectName("factor")
        self.factor.addItem(tr("Automatic"), 0)
        for value in _EXAGGERATION_FACTORS:
            self.factor.addItem(f"× {value:,}", value)
        self.factor.currentIndexChanged.connect(lambda _: self._draw())
        self.panes = PicturePanes(1)
        self.panes.setObjectName("residual_panes")
        self._arrange_widgets()

    def _arrange_widgets(self) -> None:
        list_area, column = create_column()
        column.addWidget(self._summary)
        column.addWidget(self.table, 1)
        photo_area, rows = create_column()
        row = QHBoxLayout()
        row.addWidget(self._message, 1)
        row.addWidget(Label(tr("Exaggeration")))
        row.addWidget(self.factor)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        add_splitter(self, list_area, photo_area, [520, 740])

    def fill(self) -> None:
        """List the photos, and show the photo with the largest median error."""
        overview = self._data.overview
        rows: list[tuple[tuple[Any, ...], str]] = []
        for photo in overview.photos:
            note = ""
            if photo.part is None:
                note = tr("Not aligned: {reason}", reason=photo.reason or "–")
            elif photo.part > 0:
                note = tr("Aligned in a disconnected component outside the model.")
            values = (
                photo.name,
                photo.tie_points,
                photo.error_px,
                photo.largest_px,
                photo.gps_m,
            )
            rows.append((values, note))
        self._summary.setText(self._summary_text(overview))
        self.table.fill(rows)
        if rows:
            self.table.select_row(lambda values: values[2] is not None)

    def _summary_text(self, overview: AlignmentOverview) -> str:
        error = overview.reprojection_error_px
        if error is None:
            text = tr("{tie_points:,} tie points.", tie_points=overview.tie_points)
        else:
            text = tr(
                "{tie_points:,} tie points, mean reprojection error {error:.2f} px.",
                tie_points=overview.tie_points,
                error=error,
            )
        registration = overview.registration
        if "refused" in registration:
            text += " " + tr(
                "GPS residuals are not available: {reason}",
                reason=format_sentence(registration["refused"]),
            )
        elif registration.get("rms_m") is not None:
            text += " " + tr(
                "RMS residual of the GPS positions: {rms:.2f} m.", rms=registration["rms_m"]
            )
        elif registration.get("rms_control_m") is not None:
            text += " " + tr(
                "RMS residual of the control points: {rms:.3f} m.",
                rms=registration["rms_control_m"],
            )
        return text

    def show_photo(self, name: str) -> None:
        """Show a photo and its residuals."""
        self._photo_name, self._photo, self._arrays = name, None, None
        self._message.setText("")
        self.panes.show_message(tr("Reading…"))
        self._data.load_photo(name, partial(self._receive_photo, name))
        self._data.read_residuals(
            name, partial(self._receive_arrays, name), self.panes.show_message
        )

    def _receive_photo(self, name: str, photo: ShownPhoto) -> None:
        if name == self._photo_name:
            self._photo = photo
            self._draw(is_new=True)

    def _receive_arrays(self, name: str, arrays: Arrays) -> None:
        if name == self._photo_name:
            self._arrays = arrays
            self._draw(is_new=True)

    def _draw(self, *, is_new: bool = False) -> None:
        photo, arrays = self._photo, self._arrays
        if photo is None or arrays is None:
            return
        if is_new:
            self.panes.show_message("")
            self.panes.show_pictures([photo.picture])
        if not len(arrays["pixels"]):
            self._message.setText(tr("This photo has no tie points and is not part of the model."))
            self.panes.set_overlays([])
            return
        lengths = np.linalg.norm(arrays["vectors"], axis=1)
        factor = int(self.factor.currentData())
        if not factor:
            factor = exaggeration(lengths, max(photo.width, photo.height))
        self._message.setText(
            tr(
                "Residuals exaggerated {factor:,} times; median {median:.2f} px, largest "
                "{largest:.1f} px.",
                factor=factor,
                median=float(np.median(lengths)),
                largest=float(lengths.max()),
            )
        )
        step = -(-len(lengths) // _MAX_VECTORS)
        if step > 1:
            note = tr("One in {step} is drawn.", step=step)
            self._message.setText(f"{self._message.text()} {note}")
        positions = photo.upright_points(arrays["pixels"][::step])
        offsets = photo.upright_vectors(arrays["vectors"][::step])
        self.panes.set_overlays([vector_painter(positions, offsets, factor, _COLOR)])
