"""The page with the matches of two photos."""

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

_LINES = (60, 250, 1000)
_FEATURE = QColor(86, 180, 233, 150)
_MATCH = QColor(240, 228, 66, 200)


class MatchPage(QWidget):
    """A matrix and a list of all pairs of photos, and one pair side by side with its matches."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._names: list[str] = []
        self._wanted: tuple[str, str] | None = None
        self._photos: dict[str, ShownPhoto] = {}
        self._arrays: Arrays | None = None
        self.matrix = PairMatrix()
        self.matrix.chosen.connect(self._cell_chosen)
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
                    tr("Inliers over all matches."),
                ),
            ),
            sort_by=2,
            descending=True,
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
        self.lines = ComboBox()
        self.lines.setObjectName("lines")
        for count in _LINES:
            self.lines.addItem(tr("{count:,} lines", count=count), count)
        self.lines.addItem(tr("All lines"), 10**9)
        self.lines.addItem(tr("No lines"), 0)
        self.lines.setToolTip(tr("How many of the inliers are drawn as lines."))
        self._legend = Label()
        self._said = ElidedLabel()
        for box in (self.features, self.outliers):
            box.toggled.connect(lambda _: self._draw())
        self.lines.currentIndexChanged.connect(lambda _: self._draw())
        self._hint = ElidedLabel()
        self._hint.setText(
            tr("Wheel: zoom. Drag: pan. Double-click on a match: zoom to both ends.")
        )
        self._arrange()

    def _arrange(self) -> None:
        side, column = create_column()
        self._legend.setWordWrap(True)
        column.addWidget(self._legend)
        column.addWidget(self.matrix)
        column.addWidget(self.table, 1)
        right, rows = create_column()
        row = QHBoxLayout()
        row.addWidget(self._said, 1)
        for widget in (self.lines, self.features, self.outliers):
            row.addWidget(widget)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        rows.addWidget(self._hint)
        add_splitter(self, side, right, [440, 820])

    # --- choosing ----------------------------------------------------------------------------
    def fill(self) -> None:
        """Show the pairs of the overview, and the one with the most inliers."""
        facts = self._data.overview
        self._names = [photo.name for photo in facts.photos]
        weak = facts.weak_below
        flagged = sum(0 < pair[3] < weak for pair in facts.pairs)
        words = tr("Inliers of each pair of photos; the brighter, the more.")
        if flagged:
            words += " " + tr(
                "Orange: weak pairs with fewer than {weak} inliers ({flagged} of {count}).",
                weak=weak,
                flagged=flagged,
                count=len(facts.pairs),
            )
        self._legend.setText(words)
        self.matrix.fill(self._names, facts.pairs, weak)
        rows: list[tuple[tuple[Any, ...], str]] = []
        for i, j, tried, kept in facts.pairs:
            share = kept / tried if tried else None
            note = ""
            if 0 < kept < weak:
                note = tr(
                    "Weak pair: {inliers} inliers, at least {least} are needed.",
                    inliers=kept,
                    least=weak,
                )
            rows.append(((self._names[i], self._names[j], kept, tried, share), note))
        self.table.fill(rows)
        if rows:
            first = self.table.numbers.rows[0][0]
            self.table.select_row(lambda values: values is first)
        else:
            self.panes.show_message(tr("No photos were matched."))

    def _cell_chosen(self, i: int, j: int) -> None:
        a, b = self._names[i], self._names[j]
        self.table.select_row(lambda values: values[:2] == (a, b))

    def show_pair(self, a: str, b: str) -> None:
        """Show two photos by their names."""
        self._wanted = (a, b)
        self._photos, self._arrays = {}, None
        self.matrix.show_pair(self._names.index(a), self._names.index(b))
        self.panes.show_message(tr("Reading…"))
        self._said.setText("")
        for name in (a, b):
            self._data.photo(name, partial(self._photo_there, (a, b)))
        self._data.pair(a, b, partial(self._arrays_there, (a, b)), self._failed)

    def _failed(self, why: str) -> None:
        self.panes.show_message(why)

    def _photo_there(self, wanted: tuple[str, str], photo: ShownPhoto) -> None:
        if wanted == self._wanted:
            self._photos[photo.name] = photo
            self._draw(fresh=True)

    def _arrays_there(self, wanted: tuple[str, str], arrays: Arrays) -> None:
        if wanted == self._wanted:
            self._arrays = arrays
            self._draw(fresh=True)

    # --- drawing -----------------------------------------------------------------------------
    def _draw(self, *, fresh: bool = False) -> None:
        if self._wanted is None or self._arrays is None or len(self._photos) < 2:
            return
        left, right = (self._photos[name] for name in self._wanted)
        arrays = self._arrays
        matches, refused = arrays["matches"], arrays["refused"]
        ends = (
            left.upright_points(arrays["left"][matches[:, 0]]),
            right.upright_points(arrays["right"][matches[:, 1]]),
        )
        shown = int(self.lines.currentData())
        step = max(1, -(-len(matches) // shown)) if shown else 0
        drawn = np.arange(0, len(matches), step) if step else np.zeros(0, np.int64)
        faint = None
        if self.outliers.isChecked():
            faint = (
                left.upright_points(arrays["left"][refused[:, 0]]),
                right.upright_points(arrays["right"][refused[:, 1]]),
            )
        painters = []
        for photo, points, own in ((left, "left", ends[0]), (right, "right", ends[1])):
            marks = dot_painter(own, _MATCH, 2.6)
            if self.features.isChecked():
                marks = combined_painter(
                    dot_painter(photo.upright_points(arrays[points]), _FEATURE, 2.4), marks
                )
            painters.append(marks)
        self.panes.set_overlays(painters)
        self.panes.show_links(Links(*ends, _by_place(ends[0], left), drawn, faint))
        if fresh:
            self.panes.show_message("")
            self.panes.show_pictures([left.picture, right.picture])
        count, tried = len(matches), len(matches) + len(refused)
        self._said.setText(
            tr(
                "{inliers:,} inliers of {matches:,} matches ({ratio:.1f} %); {left:,} and "
                "{right:,} features",
                inliers=count,
                matches=tried,
                ratio=100 * count / tried if tried else 0.0,
                left=len(arrays["left"]),
                right=len(arrays["right"]),
            )
        )


def _by_place(places: Any, photo: ShownPhoto) -> Any:
    """Colours (n, 3) by where places (n, 2) lie in a photo, so that lines can be followed."""
    from vomstudio.rendering.view.scalars import map_table

    wide, high = photo.picture.size
    table = map_table("turbo")
    at = np.clip(0.7 * places[:, 0] / wide + 0.3 * places[:, 1] / high, 0, 1)
    # Its ends are dark; few colours are drawn faster.
    return table[np.round(20 + 14 * np.round(15 * at)).astype(np.intp)]
