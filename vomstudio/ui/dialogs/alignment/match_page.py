"""Page with the matches of two photos."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import ComboBox, ElidedLabel, Label, add_splitter, create_column
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData, Arrays, ShownPhoto
from vomstudio.ui.dialogs.alignment.pair_matrix import PairMatrix
from vomstudio.ui.widgets.number_table import Column, NumberTable
from vomstudio.ui.widgets.pane_painters import combined_painter, dot_painter
from vomstudio.ui.widgets.picture_panes import Links, PicturePanes

_LINE_COUNTS = (60, 250, 1000)
_FEATURE_COLOR = QColor(86, 180, 233, 150)
_MATCH_COLOR = QColor(240, 228, 66, 200)


class MatchPage(QWidget):
    """Page with a matrix and a list of all photo pairs, and the matches of one pair."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._names: list[str] = []
        self._pair: tuple[str, str] | None = None
        self._photos: dict[str, ShownPhoto] = {}
        self._arrays: Arrays | None = None
        self.matrix = PairMatrix()
        self.matrix.pair_selected.connect(self._select_pair)
        self.table = NumberTable(
            (
                Column(tr("Photo 1"), number=False),
                Column(tr("Photo 2"), number=False),
                Column(
                    tr("Inliers"),
                    "{:,}".format,
                    tr("Matches that agree with the epipolar geometry of the two photos."),
                ),
                Column(tr("Matches"), "{:,}".format, tr("Pairs of similar features.")),
                Column(
                    tr("Inlier ratio"),
                    lambda ratio: f"{100 * ratio:.1f} %",
                    tr("Inliers divided by all matches."),
                ),
            ),
            sort_by=2,
            is_descending=True,
        )
        self.table.setObjectName("pair_table")
        self.table.row_selected.connect(lambda values: self.show_pair(values[0], values[1]))
        self.panes = PicturePanes(2)
        self.panes.setObjectName("match_panes")
        self.features = QCheckBox(tr("All features"))
        self.features.setToolTip(tr("All detected features of both photos."))
        self.outliers = QCheckBox(tr("Outliers"))
        self.outliers.setToolTip(
            tr("Matches that disagree with the epipolar geometry, drawn in red.")
        )
        self.line_count_box = ComboBox()
        self.line_count_box.setObjectName("lines")
        for count in _LINE_COUNTS:
            self.line_count_box.addItem(tr("{count:,} lines", count=count), count)
        self.line_count_box.addItem(tr("All lines"), 10**9)
        self.line_count_box.addItem(tr("No lines"), 0)
        self.line_count_box.setToolTip(tr("Maximum number of inliers drawn as lines."))
        self._legend = Label()
        self._summary = ElidedLabel()
        for box in (self.features, self.outliers):
            box.toggled.connect(lambda _: self._draw())
        self.line_count_box.currentIndexChanged.connect(lambda _: self._draw())
        self._hint = ElidedLabel()
        self._hint.setText(tr("Wheel: zoom. Drag: pan. Double-click a match: zoom to both ends."))
        self._arrange_widgets()

    def _arrange_widgets(self) -> None:
        list_area, column = create_column()
        self._legend.setWordWrap(True)
        column.addWidget(self._legend)
        column.addWidget(self.matrix)
        column.addWidget(self.table, 1)
        pair_area, rows = create_column()
        rows.addWidget(self._summary)
        row = QHBoxLayout()
        row.addStretch(1)
        for widget in (self.line_count_box, self.features, self.outliers):
            row.addWidget(widget)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        rows.addWidget(self._hint)
        add_splitter(self, list_area, pair_area, [440, 820])

    # --- selection ---------------------------------------------------------------------------
    def fill(self) -> None:
        """List all pairs, and show the pair with the most inliers."""
        overview = self._data.overview
        self._names = [photo.name for photo in overview.photos]
        min_inliers = overview.weak_below
        weak_count = sum(0 < pair[3] < min_inliers for pair in overview.pairs)
        legend = tr("Inliers of each photo pair; brighter means more.")
        if weak_count:
            legend += " " + tr(
                "Orange: weak pairs with fewer than {weak} inliers ({flagged} of {count}).",
                weak=min_inliers,
                flagged=weak_count,
                count=len(overview.pairs),
            )
        self._legend.setText(legend)
        self.matrix.fill(self._names, overview.pairs, min_inliers)
        rows: list[tuple[tuple[Any, ...], str]] = []
        for i, j, matches, inliers in overview.pairs:
            inlier_ratio = inliers / matches if matches else None
            note = ""
            if 0 < inliers < min_inliers:
                note = tr(
                    "Weak pair: {inliers} inliers, at least {least} required.",
                    inliers=inliers,
                    least=min_inliers,
                )
            rows.append(((self._names[i], self._names[j], inliers, matches, inlier_ratio), note))
        self.table.fill(rows)
        if rows:
            first_row = self.table.numbers.rows[0][0]
            self.table.select_row(lambda values: values is first_row)
        else:
            self.panes.show_message(tr("No photos were matched."))

    def _select_pair(self, i: int, j: int) -> None:
        a, b = self._names[i], self._names[j]
        self.table.select_row(lambda values: values[:2] == (a, b))

    def show_pair(self, a: str, b: str) -> None:
        """Show the matches of two photos, given by their names."""
        self._pair = (a, b)
        self._photos, self._arrays = {}, None
        self.matrix.show_pair(self._names.index(a), self._names.index(b))
        self.panes.show_message(tr("Reading…"))
        self._summary.setText("")
        for name in (a, b):
            self._data.load_photo(name, partial(self._receive_photo, (a, b)))
        self._data.read_pair(a, b, partial(self._receive_arrays, (a, b)), self._show_error)

    def _show_error(self, reason: str) -> None:
        self.panes.show_message(reason)

    def _receive_photo(self, pair: tuple[str, str], photo: ShownPhoto) -> None:
        if pair == self._pair:
            self._photos[photo.name] = photo
            self._draw(is_new=True)

    def _receive_arrays(self, pair: tuple[str, str], arrays: Arrays) -> None:
        if pair == self._pair:
            self._arrays = arrays
            self._draw(is_new=True)

    # --- drawing -----------------------------------------------------------------------------
    def _draw(self, *, is_new: bool = False) -> None:
        if self._pair is None or self._arrays is None or len(self._photos) < 2:
            return
        left_photo, right_photo = (self._photos[name] for name in self._pair)
        arrays = self._arrays
        matches, outliers = arrays["matches"], arrays["refused"]
        line_ends = (
            left_photo.upright_points(arrays["left"][matches[:, 0]]),
            right_photo.upright_points(arrays["right"][matches[:, 1]]),
        )
        line_count = int(self.line_count_box.currentData())
        step = max(1, -(-len(matches) // line_count)) if line_count else 0
        line_indices = np.arange(0, len(matches), step) if step else np.zeros(0, np.int64)
        outlier_ends = None
        if self.outliers.isChecked():
            outlier_ends = (
                left_photo.upright_points(arrays["left"][outliers[:, 0]]),
                right_photo.upright_points(arrays["right"][outliers[:, 1]]),
            )
        painters = []
        for photo, points, inlier_points in (
            (left_photo, "left", line_ends[0]),
            (right_photo, "right", line_ends[1]),
        ):
            marks = dot_painter(inlier_points, _MATCH_COLOR, 2.6)
            if self.features.isChecked():
                marks = combined_painter(
                    dot_painter(photo.upright_points(arrays[points]), _FEATURE_COLOR, 2.4), marks
                )
            painters.append(marks)
        self.panes.set_overlays(painters)
        self.panes.show_links(
            Links(
                *line_ends, _position_colors(line_ends[0], left_photo), line_indices, outlier_ends
            )
        )
        if is_new:
            self.panes.show_message("")
            self.panes.show_pictures([left_photo.picture, right_photo.picture])
        inlier_count, match_count = len(matches), len(matches) + len(outliers)
        self._summary.setText(
            tr(
                "{inliers:,} inliers of {matches:,} matches ({ratio:.1f} %); {left:,} and "
                "{right:,} features",
                inliers=inlier_count,
                matches=match_count,
                ratio=100 * inlier_count / match_count if match_count else 0.0,
                left=len(arrays["left"]),
                right=len(arrays["right"]),
            )
        )


def _position_colors(positions: Any, photo: ShownPhoto) -> Any:
    """Return colours (n, 3) by position, so that match lines can be followed."""
    from vomstudio.rendering.view.scalars import colormap_table

    width, height = photo.picture.size
    table = colormap_table("turbo")
    hue = np.clip(0.7 * positions[:, 0] / width + 0.3 * positions[:, 1] / height, 0, 1)
    # The ends of the colour map are dark. Few distinct colours are drawn faster.
    return table[np.round(20 + 14 * np.round(15 * hue)).astype(np.intp)]
