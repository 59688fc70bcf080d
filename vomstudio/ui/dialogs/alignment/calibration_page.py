"""Page with the intrinsics of each camera: values, errors and correlations."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import Qt
from PySide6.QtGui import QBrush, QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.rendering.view.scalars import colormap_table
from vomstudio.studio.jobs.inspection_tasks import AlignedCamera
from vomstudio.ui.base.controls import ComboBox, Label, rich_label, rich_lines
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData

_CELL_PX = 72
STRONG_CORRELATION = 0.9
"""Absolute correlation above which two parameters are poorly separated."""


class CalibrationPage(QWidget):
    """Page with the parameters of a camera, their errors and correlation matrix."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self.camera = ComboBox()
        self.camera.setObjectName("camera")
        self.camera.currentIndexChanged.connect(lambda _: self._show_camera())
        self._summary = rich_label()
        self._summary.setObjectName("calibration_words")
        self._summary.setWordWrap(True)
        self._summary.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.parameters = _create_table()
        self.correlation = _create_table()
        self.correlation.setObjectName("correlation")
        self.correlation.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.correlation.horizontalHeader().setStretchLastSection(False)
        self.correlation.verticalHeader().setDefaultSectionSize(_CELL_PX // 2)
        self._correlation_note = Label()
        self._correlation_note.setWordWrap(True)
        camera_row = QHBoxLayout()
        self._title = Label(tr("Camera"))
        camera_row.addWidget(self._title)
        camera_row.addWidget(self.camera)
        camera_row.addStretch()
        left_column, right_column = QVBoxLayout(), QVBoxLayout()
        left_column.addWidget(_create_heading(tr("Parameters")))
        left_column.addWidget(self.parameters)
        left_column.addStretch()
        right_column.addWidget(_create_heading(tr("Correlation of the estimated parameters")))
        right_column.addWidget(self.correlation)
        right_column.addWidget(self._correlation_note)
        right_column.addStretch()
        tables = QHBoxLayout()
        tables.setSpacing(24)
        tables.addLayout(left_column, 1)
        tables.addLayout(right_column, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(16, 14, 16, 14)
        layout.setSpacing(12)
        layout.addLayout(camera_row)
        layout.addWidget(self._summary)
        layout.addLayout(tables, 1)

    def fill(self) -> None:
        """List the cameras of the reconstruction, and show the first one."""
        cameras = self._data.overview.cameras
        self.camera.clear()
        for number, camera in enumerate(cameras):
            count = len(camera.photos)
            if count == 1:
                text = f"{number + 1}: {camera.photos[0]}"
            else:
                text = tr(
                    "{number}: {count} photos ({first} …)",
                    number=number + 1,
                    count=count,
                    first=camera.photos[0],
                )
            self.camera.addItem(text)
        self._show_camera()

    def _show_camera(self) -> None:
        cameras = self._data.overview.cameras
        row = self.camera.currentIndex()
        if not 0 <= row < len(cameras):
            return
        camera = cameras[row]
        self._summary.setText(self._summary_text(camera))
        self._fill_parameters(camera)
        self._fill_correlation(camera)

    def _summary_text(self, camera: AlignedCamera) -> str:
        focal, sigma = camera.values[0], camera.sigma[0]
        is_fixed = camera.focal == "held"
        if is_fixed:
            focal_text = tr("The focal length was fixed at <b>{focal:,.1f} px</b>.", focal=focal)
        elif sigma is None:
            focal_text = tr(
                "The focal length was estimated as <b>{focal:,.1f} px</b>.", focal=focal
            )
        else:
            focal_text = tr(
                "The focal length was estimated as <b>{focal:,.1f} px</b> ± {sigma:,.1f} px.",
                focal=focal,
                sigma=sigma,
            )
        lines = [focal_text, escape(format_sentence(camera.reason))]
        if camera.exif_px is None:
            lines.append(tr("EXIF contains no focal length."))
        elif not is_fixed:
            lines.append(
                tr(
                    "EXIF states {exif:,.1f} px; the difference is {difference:+.1f} %.",
                    exif=camera.exif_px,
                    difference=100 * (focal / camera.exif_px - 1),
                )
            )
        lines.append(tr("Lens model: {model}.", model=camera.model))
        return " ".join(lines)

    def _fill_parameters(self, camera: AlignedCamera) -> None:
        table = self.parameters
        table.setColumnCount(4)
        table.setHorizontalHeaderLabels([tr("Parameter"), tr("Value"), tr("1 sigma"), tr("State")])
        table.setRowCount(len(camera.names))
        for row, name in enumerate(camera.names):
            value, sigma = camera.values[row], camera.sigma[row]
            is_in_pixels = name[0] in "fc"
            is_estimated = sigma is None or sigma > 0
            if not is_estimated:
                error = "–"
            elif sigma is None:
                error = tr("undetermined")
            else:
                error = f"{sigma:,.2f} px" if is_in_pixels else f"{sigma:.2g}"
            texts = (
                f"{name}   {self._parameter_title(name)}",
                f"{value:,.2f} px" if is_in_pixels else f"{value:.6f}",
                error,
                tr("estimated") if is_estimated else self._fixed_reason(name),
            )
            for column, text in enumerate(texts):
                item = QTableWidgetItem(text)
                if column in (1, 2):
                    item.setTextAlignment(
                        Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                    )
                table.setItem(row, column, item)
        _fit_height(table)

    def _fixed_reason(self, name: str) -> str:
        if name[0] == "f":
            return tr("fixed, see above")
        if name[0] == "c":
            return tr("fixed: not separable from camera rotation")
        return tr("fixed: too few photos")

    def _parameter_title(self, name: str) -> str:
        if name[0] == "f":
            return tr("focal length")
        if name[0] == "c":
            return tr("principal point, {axis}", axis=name[1])
        if name[0] == "k":
            return tr("radial distortion")
        return tr("tangential distortion")

    def _fill_correlation(self, camera: AlignedCamera) -> None:
        matrix = camera.correlation
        estimated_indices = [k for k in range(len(matrix)) if matrix[k][k] is not None]
        table = self.correlation
        names = [camera.names[k] for k in estimated_indices]
        table.setRowCount(len(estimated_indices))
        table.setColumnCount(len(estimated_indices))
        table.setHorizontalHeaderLabels(names)
        table.setVerticalHeaderLabels(names)
        table.verticalHeader().show()
        for k in range(len(estimated_indices)):
            table.setColumnWidth(k, _CELL_PX)
        colors = colormap_table("RdBu_r")
        for i, a in enumerate(estimated_indices):
            for j, b in enumerate(estimated_indices):
                value = matrix[a][b]
                item = QTableWidgetItem("–" if value is None else f"{value:+.2f}")
                item.setTextAlignment(Qt.AlignmentFlag.AlignCenter)
                if value is not None:
                    rgb = [int(v) for v in colors[round(127.5 + 127.5 * max(-1, min(1, value)))]]
                    item.setBackground(QBrush(QColor(*rgb)))
                    is_bright = (
                        sum(w * v for w, v in zip((0.3, 0.59, 0.11), rgb, strict=True)) > 140
                    )
                    item.setForeground(QBrush(QColor("#101010" if is_bright else "#ffffff")))
                table.setItem(i, j, item)
        table.setVisible(bool(estimated_indices))
        _fit_height(table)
        table.setFixedWidth(
            len(estimated_indices) * _CELL_PX + table.verticalHeader().sizeHint().width() + 4
        )
        self._correlation_note.setText(self._correlation_text(camera, len(estimated_indices)))

    def _correlation_text(self, camera: AlignedCamera, estimated_count: int) -> str:
        if estimated_count == 0:
            return tr("No parameter of this camera was estimated.")
        if estimated_count == 1:
            return tr("Correlations need two or more estimated parameters.")
        if camera.strongest is None:
            return ""
        a, b, value = camera.strongest
        if abs(value) > STRONG_CORRELATION:
            return tr(
                "{a} and {b} are strongly correlated ({value:+.2f}), so both are less certain"
                " than stated. Add photos from more directions, some rotated by 90°.",
                a=a,
                b=b,
                value=value,
            )
        return tr(
            "The strongest correlation is between {a} and {b} ({value:+.2f}), which is harmless.",
            a=a,
            b=b,
            value=value,
        )


def _fit_height(table: QTableWidget) -> None:
    """Set the height of a table so that all rows are visible."""
    rows_height = sum(table.rowHeight(row) for row in range(table.rowCount()))
    table.setFixedHeight(rows_height + table.horizontalHeader().sizeHint().height() + 4)


def _create_heading(text: str) -> Label:
    label = rich_label(rich_lines([text], [text]))
    label.setWordWrap(True)
    return label


def _create_table() -> QTableWidget:
    table = QTableWidget()
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
    table.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    table.verticalHeader().hide()
    table.verticalHeader().setDefaultSectionSize(table.fontMetrics().height() + 12)
    table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    table.horizontalHeader().setStretchLastSection(True)
    return table
