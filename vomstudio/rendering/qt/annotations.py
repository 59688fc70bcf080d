"""Labels and symbols of the features over the outcrop, painted with Qt only.

Symbols and labels are placed in order of importance and do not overlap. Labels that do not fit
are omitted, and symbols that do not fit become dots in the colour of their type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import count, repeat
from operator import attrgetter

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen, QPixmap

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.rendering.qt import painting
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.decluttering import LabelGrid, order_by_importance, place_labels
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.symbols import MIN_DISC_PIXELS, ScreenSymbols, SymbolSet

Project = Callable[[FloatArray], tuple[FloatArray, BoolArray]]

MAX_HIDDEN_FRAMES = 6
"""Number of frames for which a label remains after its position has been hidden in a moving
view, because the depth of a coarse model varies."""
SYMBOL_HALF_SIZE = 13.0
"""Half the side of the square around a symbol that is kept free of other symbols, pixels."""
DOT_DIAMETER = 6.0
NEW_LABEL_CLEARANCE = 10.0
CAP_LENGTH = 1.2
MAX_SELECTED_ON_TOP = 12
MAX_DOUBLE_CASED_STROKES = 1200
"""Number of strokes above which symbols have one casing instead of two."""
PICK_DISTANCE_PIXELS = 7.0
LABEL_GAP = 7.0
LINE_POSITIONS = (0.25, 0.75, 0.0, 1.0)
"""Alternative positions of label and symbol along a feature's line if its anchor is hidden."""
SYMBOL_GAP = 17.0
HOVER_GAP = 12.0
"""Distance of the label of a hovered feature from the cursor."""
# Called for thousands of drawings at every change; a Python loop would take three times as long.
MAX_LABELLED_FEATURES = 30
"""Number of features above which only selected features are labelled by default."""
MAX_PLACED_IN_MOTION = 500
"""Number of labels above which only those already shown are moved while the camera moves."""
_GET_ID, _GET_EXTENT, _GET_LABEL, _GET_SYMBOL = map(attrgetter, ("id", "extent", "label", "symbol"))


@dataclass(frozen=True, eq=False)
class _FeatureArrays:
    """Data of the visible drawings, cached until the drawings change.

    Parameters
    ----------
    rows : dict of str to int
        Row of each drawing by id.
    places : (n, 5, 3) float64
        Possible positions of label and symbol in the World frame: the anchor, then points along
        the line.
    sizes : (n, 2) float64
        Sizes of the labels, pixels.
    is_measured : (n,) bool
        Whether `places` and `sizes` are known. They are determined before the first use, because
        most of thousands of features are never labelled.
    """

    drawings: list[FeatureDrawing]
    rows: dict[str, int]
    places: FloatArray
    extents: FloatArray
    sizes: FloatArray
    is_measured: BoolArray
    has_label: BoolArray
    symbol_rows: IntArray
    symbols: SymbolSet
    discs: BoolArray

    @property
    def count(self) -> int:
        return len(self.drawings)

    def replace(self, id_: str, drawing: FeatureDrawing | None) -> bool:
        """Replace or remove a drawing without a symbol. Return False if this is impossible."""
        row = self.rows.get(id_)
        if row is None or self.drawings[row].symbol:
            return False
        if drawing is None:
            del self.rows[id_]
            self.has_label[row] = False
            return True
        if not (drawing.visible and drawing.label) or drawing.symbol:
            return False
        self.drawings[row], self.extents[row] = drawing, drawing.extent
        self.is_measured[row], self.has_label[row] = False, True
        return True

    def find_rows(self, ids: Iterable[str]) -> IntArray:
        """Return the rows of the drawings with these ids, ignoring unknown ids."""
        rows = self.rows
        return np.array([rows[id_] for id_ in ids if id_ in rows], np.int64)

    def flags(self, ids: Iterable[str]) -> BoolArray:
        """Return a mask (n,) of the drawings with these ids."""
        flags = np.zeros(self.count, np.bool_)
        flags[self.find_rows(ids)] = True
        return flags

    def numbers(self, values: Mapping[str, int]) -> IntArray:
        """Return the value (n,) of each drawing, or 0 if `values` does not contain its id."""
        result = np.zeros(self.count, np.int64)
        rows_and_numbers = [
            (self.rows[id_], number) for id_, number in values.items() if id_ in self.rows
        ]
        if rows_and_numbers:
            rows, numbers = np.array(rows_and_numbers, np.int64).T
            result[rows] = numbers
        return result


class Annotations:
    """Labels, symbols and strokes that are painted over the view."""

    def __init__(self) -> None:
        self.labels = painting.LabelCache()
        self.label_boxes: list[tuple[str, QRectF]] = []
        self.label_mode = "auto"
        """Labelled features: "all", "selected", "none", or "auto" (all if there are only a
        few)."""
        self._numbers: dict[tuple[str, float], QPixmap] = {}
        self._dot_pixmaps: dict[tuple[tuple[float, float, float], float, float], QPixmap] = {}
        self._arrays: _FeatureArrays | None = None
        self._previous_arrays: _FeatureArrays | None = None
        self._corners: dict[str, int] = {}
        self._label_ages: dict[str, int] = {}
        self._symbol_ages: dict[str, int] = {}
        self._position_by_id: dict[str, int] = {}
        self._strokes: FloatArray = np.zeros((0, 2, 2))
        self._owner_rows: IntArray = np.zeros(0, np.int64)
        self._selected_flags: tuple[_FeatureArrays | None, frozenset[str], BoolArray] = (
            None,
            frozenset(),
            np.zeros(0, np.bool_),
        )

    def change(self, changes: Mapping[str, FeatureDrawing | None]) -> None:
        """Replace or remove drawings in the cached data, or discard it if this is impossible."""
        if self._arrays is not None and not all(
            self._arrays.replace(id_, drawing) for id_, drawing in changes.items()
        ):
            self.clear_state()

    def clear_state(self) -> None:
        """Discard the cached data after a change of the drawings."""
        self._previous_arrays = self._arrays or self._previous_arrays
        self._arrays = None

    def forget_font(self) -> None:
        self.labels.clear()
        self._numbers.clear()
        self._previous_arrays = self._arrays = None

    def at(self, x: float, y: float) -> str | None:
        """Return the id of the feature whose label or symbol is at a pixel, or None."""
        for key, box in self.label_boxes:
            if box.contains(x, y):
                return key
        if self._arrays is None or not len(self._strokes):
            return None
        a, b = self._strokes[:, 0], self._strokes[:, 1]
        ab, point = b - a, np.array([x, y])
        squared_lengths = np.maximum(np.einsum("ij,ij->i", ab, ab), 1e-12)
        t = np.clip(np.einsum("ij,ij->i", point - a, ab) / squared_lengths, 0.0, 1.0)
        distance = np.hypot(*(a + t[:, None] * ab - point).T)
        best_row = int(np.argmin(distance))
        if distance[best_row] > PICK_DISTANCE_PIXELS:
            return None
        return self._arrays.drawings[int(self._owner_rows[best_row])].id

    def paint(
        self,
        painter: QPainter,
        features: Mapping[str, FeatureDrawing],
        selected_names: frozenset[str],
        camera: Camera,
        project: Project,
        size: tuple[float, float],
        *,
        reserved_rects: Iterable[QRectF] = (),
        is_moving: bool = False,
    ) -> None:
        """Paint symbols and labels.

        Parameters
        ----------
        painter : QPainter
        features : mapping
            Drawings by feature id.
        selected_names : frozenset of str
            Ids of the selected features.
        camera : Camera
        project : callable
            Function that returns the pixels of points in the World frame, and whether each is
            visible.
        size : tuple of float
            Width and height of the picture.
        reserved_rects : iterable of QRectF, optional
            Rectangles in which no label is placed.
        is_moving : bool, optional
            Whether the camera is moving.
        """
        self.label_boxes = []
        self._strokes, self._owner_rows = np.zeros((0, 2, 2)), np.zeros(0, np.int64)
        arrays = self._arrays or self._prepare(features)
        self._arrays = arrays
        if not arrays.drawings:
            return
        ratio = painter.device().devicePixelRatioF()
        is_selected = self._selection_mask(arrays, selected_names)
        has_label = self._label_mask(arrays, is_selected, is_moving)
        has_label[arrays.symbol_rows] = True
        # Only these are projected, because projecting thousands takes too long for a step of a
        # drag.
        rows = np.flatnonzero(has_label)
        self._measure(arrays, rows)
        pixels, is_visible = project(arrays.places[rows].reshape(-1, 3))
        is_visible = is_visible.reshape(len(rows), arrays.places.shape[1])
        position = np.zeros(arrays.count, np.int64)
        position[rows] = self._choose_positions(arrays, rows, is_visible, is_moving)
        anchors, is_seen = np.full((arrays.count, 2), np.nan), np.zeros(arrays.count, np.bool_)
        anchors[rows] = pixels.reshape(*is_visible.shape, 2)[np.arange(len(rows)), position[rows]]
        is_seen[rows] = is_visible[np.arange(len(rows)), position[rows]]
        grid = LabelGrid(*size)
        for box in reserved_rects:
            grid.block(box.x(), box.y(), box.width(), box.height())
        gap = LABEL_GAP
        if len(arrays.symbol_rows):
            rows = arrays.symbol_rows
            signs = arrays.symbols.signs(camera, size, arrays.places[rows, position[rows]])
            self._paint_symbols(painter, arrays, signs, is_seen, is_selected, grid, size, is_moving)
            if not arrays.discs.all():
                gap = SYMBOL_GAP
        self._paint_labels(
            painter, arrays, anchors, is_seen, is_selected, grid, gap, is_moving, ratio
        )

    def _prepare(self, features: Mapping[str, FeatureDrawing]) -> _FeatureArrays:
        drawings = [d for d in features.values() if d.visible and (d.label or d.symbol)]
        symbols = list(map(_GET_SYMBOL, drawings))
        valid_symbols = list(filter(None, symbols))
        arrays = _FeatureArrays(
            drawings,
            dict(zip(map(_GET_ID, drawings), count(), strict=False)),
            np.zeros((len(drawings), 1 + len(LINE_POSITIONS), 3)),
            np.fromiter(map(_GET_EXTENT, drawings), float, len(drawings)),
            np.zeros((len(drawings), 2)),
            np.zeros(len(drawings), np.bool_),
            np.fromiter(map(bool, map(_GET_LABEL, drawings)), np.bool_, len(drawings)),
            np.flatnonzero(np.fromiter(map(bool, symbols), np.bool_, len(drawings))),
            SymbolSet(valid_symbols),
            np.array([s.kind == "disc" for s in valid_symbols], np.bool_),
        )
        if self._previous_arrays is not None:
            _copy_sizes(self._previous_arrays, arrays)
        self._previous_arrays = None
        return arrays

    def _measure(self, arrays: _FeatureArrays, rows: IntArray) -> None:
        """Compute the positions and sizes of labels that are not yet known."""
        rows = rows[~arrays.is_measured[rows]]
        if not len(rows):
            return
        drawings = [arrays.drawings[row] for row in rows.tolist()]
        arrays.places[rows] = _label_anchors(drawings)
        arrays.sizes[rows] = [self.labels.size(d.label, d.verdict) for d in drawings]
        arrays.is_measured[rows] = True

    def _selection_mask(self, arrays: _FeatureArrays, selected_names: frozenset[str]) -> BoolArray:
        """Return a mask (n,) of the selected drawings, computed once per selection."""
        known_arrays, known_names, flags = self._selected_flags
        if known_arrays is not arrays or known_names is not selected_names:
            flags = arrays.flags(selected_names)
            self._selected_flags = arrays, selected_names, flags
        return flags

    def _label_mask(
        self, arrays: _FeatureArrays, is_selected: BoolArray, is_moving: bool
    ) -> BoolArray:
        """Return a mask (n,) of the drawings that may be labelled if they are in the view."""
        if self.label_mode == "none":
            return np.zeros(arrays.count, np.bool_)
        has_label = arrays.has_label.copy()
        if self._is_selection_only(arrays):
            has_label &= is_selected
        if is_moving and int(has_label.sum()) > MAX_PLACED_IN_MOTION:
            # Placing thousands of labels takes too long for a step of a drag; at rest, all are
            # placed.
            was_shown = arrays.flags(self._label_ages)
            if was_shown.any():
                has_label &= was_shown
        return has_label

    def _choose_positions(
        self, arrays: _FeatureArrays, rows: IntArray, is_visible: BoolArray, is_moving: bool
    ) -> IntArray:
        """Return the index (m,) of each label's position, preferably the previous one.

        If the previous position is hidden, a visible one is chosen, so that a long trace is
        labelled even in a close view.
        """
        last_positions = arrays.numbers(self._position_by_id)[rows]
        # Return to the anchor once the view has come to rest.
        preferred_positions = last_positions if is_moving else np.zeros_like(last_positions)
        is_kept = is_visible[np.arange(len(rows)), preferred_positions] | ~is_visible.any(axis=1)
        if is_moving:
            for ages in (self._label_ages, self._symbol_ages):
                hidden_frames = arrays.numbers(ages)[rows]
                is_kept |= (hidden_frames > 0) & (hidden_frames < MAX_HIDDEN_FRAMES)
        index = np.where(is_kept, preferred_positions, np.argmax(is_visible, axis=1))
        self._position_by_id = {
            arrays.drawings[row].id: number
            for row, number in zip(rows.tolist(), index.tolist(), strict=True)
            if number
        }
        return index

    # --- symbols -----------------------------------------------------------------------------
    def _paint_symbols(
        self,
        painter: QPainter,
        arrays: _FeatureArrays,
        signs: ScreenSymbols,
        is_visible: BoolArray,
        is_selected: BoolArray,
        grid: LabelGrid,
        size: tuple[float, float],
        is_moving: bool,
    ) -> None:
        rows = arrays.symbol_rows
        extents = arrays.extents[rows]
        with np.errstate(invalid="ignore"):
            is_inside = (
                (signs.depth > 0.0)
                & (signs.pixels > -20.0).all(axis=1)
                & (signs.pixels < np.array(size) + 20.0).all(axis=1)
            )
        was_recently_visible = self._recently_visible(
            arrays, is_visible, self._symbol_ages, is_moving
        )[rows]
        is_small = extents < MIN_DISC_PIXELS * signs.metres
        candidates = (
            is_inside & (was_recently_visible | is_selected[rows]) & (~arrays.discs | is_small)
        )
        was_shown = arrays.flags(self._symbol_ages)[rows]
        order = order_by_importance(is_selected[rows], was_shown, extents, is_moving=is_moving)
        # Includes a margin, because a symbol may be partly outside the image.
        available_space = LabelGrid(size[0] + 40.0, size[1] + 40.0)
        full_signs, dots, discs = [], [], []
        # A few selected symbols are drawn over all others, but many would overlap each other.
        selected_rows = np.flatnonzero(is_selected[rows])
        fixed_rows = (
            set(selected_rows.tolist()) if len(selected_rows) <= MAX_SELECTED_ON_TOP else set()
        )
        positions = signs.pixels.tolist()
        for i in order[candidates[order]].tolist():
            x, y = positions[i]
            margin = SYMBOL_HALF_SIZE + (6.0 if is_moving and not was_shown[i] else 0.0)
            is_free = available_space.is_free(
                x + 20.0 - margin, y + 20.0 - margin, 2 * margin, 2 * margin
            )
            if arrays.discs[i]:
                discs.append(i)
            elif i in fixed_rows or is_free:
                available_space.block(
                    x + 20.0 - SYMBOL_HALF_SIZE,
                    y + 20.0 - SYMBOL_HALF_SIZE,
                    2 * SYMBOL_HALF_SIZE,
                    2 * SYMBOL_HALF_SIZE,
                )
                full_signs.append(i)
                grid.block(x - 6.0, y - 6.0, 12.0, 12.0)
            else:
                dots.append(i)
        self._remember(self._symbol_ages, arrays, rows[full_signs].tolist(), is_visible)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colors = [arrays.drawings[i].color for i in rows]
        # The most important symbol is drawn last, over the others.
        self._paint_dots(painter, signs.pixels, discs[::-1], colors, MIN_DISC_PIXELS)
        self._paint_dots(painter, signs.pixels, dots[::-1], colors, DOT_DIAMETER)
        strokes, owners = signs.strokes(full_signs)
        self._paint_strokes(painter, strokes, owners, colors, is_selected[rows])
        self._paint_numbers(painter, arrays, signs, full_signs, grid)
        dots += discs
        dot_strokes = np.repeat(signs.pixels[dots][:, None], 2, axis=1).reshape(-1, 2, 2)
        self._strokes = np.concatenate([strokes, dot_strokes])
        self._owner_rows = rows[np.concatenate([owners, np.array(dots, np.int64)])]

    def _paint_dots(
        self,
        painter: QPainter,
        pixels: FloatArray,
        dots: list[int],
        colors: list[tuple[float, float, float]],
        width: float,
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        half_width = width / 2.0 + 1.0
        for i in dots:
            x, y = pixels[i]
            painter.drawPixmap(
                QPointF(x - half_width, y - half_width), self._dot_pixmap(colors[i], width, ratio)
            )

    def _dot_pixmap(self, color: tuple[float, float, float], width: float, ratio: float) -> QPixmap:
        """Return a dot as a small picture, because Qt draws round points ten times more slowly."""
        key = (color, width, ratio)
        pixmap = self._dot_pixmaps.get(key)
        if pixmap is None:
            pixmap = _blank_pixmap(width + 2.0, width + 2.0, ratio)
            pixmap_painter = QPainter(pixmap)
            pixmap_painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            pixmap_painter.setPen(QPen(painting.DARK, 1.2))
            pixmap_painter.setBrush(painting.to_color(color))
            pixmap_painter.drawEllipse(QRectF(1.0, 1.0, width, width))
            pixmap_painter.end()
            self._dot_pixmaps[key] = pixmap
        return pixmap

    def _paint_strokes(
        self,
        painter: QPainter,
        strokes: FloatArray,
        owners: IntArray,
        colors: list[tuple[float, float, float]],
        is_selected: BoolArray,
    ) -> None:
        if not len(strokes):
            return
        # Slightly longer strokes with flat ends take a third of the time of round ends.
        stroke_vectors = strokes[:, 1] - strokes[:, 0]
        stroke_vectors *= CAP_LENGTH / np.maximum(np.hypot(*stroke_vectors.T), 1e-9)[:, None]
        long_strokes = strokes + np.stack([-stroke_vectors, stroke_vectors], axis=1)
        lines = [QLineF(*ends) for ends in long_strokes.reshape(-1, 4).tolist()]
        groups: dict[tuple[bool, tuple[float, float, float]], list[QLineF]] = {}
        for line, owner in zip(lines, owners.tolist(), strict=True):
            groups.setdefault((bool(is_selected[owner]), colors[owner]), []).append(line)
        shade = QColor(painting.DARK)
        shade.setAlphaF(0.85)
        # Selected strokes are drawn over all others.
        for selected in (False, True):
            selected_groups = {color: part for (s, color), part in groups.items() if s == selected}
            stroke_lines = [line for part in selected_groups.values() for line in part]
            if not stroke_lines:
                continue
            extra_width = 2.0 if selected else 0.0
            # A light casing inside the dark one separates a symbol from the line of its own
            # trace. If there are very many symbols, only one casing is drawn to save time.
            casing = [(shade, 6.2), (painting.TEXT, 4.6)]
            for tint, stroke_width in (
                casing if len(stroke_lines) < MAX_DOUBLE_CASED_STROKES else [(painting.TEXT, 4.6)]
            ):
                painter.setPen(_flat_pen(tint, stroke_width + extra_width))
                painter.drawLines(stroke_lines)
            for color, part in selected_groups.items():
                painter.setPen(_flat_pen(painting.to_color(color), 3.2 if selected else 2.4))
                painter.drawLines(part)

    def _paint_numbers(
        self,
        painter: QPainter,
        arrays: _FeatureArrays,
        signs: ScreenSymbols,
        full_signs: list[int],
        grid: LabelGrid,
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        centres = signs.numbers()
        for i in full_signs:
            symbol = arrays.drawings[int(arrays.symbol_rows[i])].symbol
            if symbol is None or not symbol.text or not np.isfinite(centres[i]).all():
                continue
            picture = self._number(symbol.text, ratio)
            width, height = picture.width() / ratio, picture.height() / ratio
            x, y = centres[i][0] - width / 2.0, centres[i][1] - height / 2.0
            if grid.take(x + 2.0, y + 4.0, width - 4.0, height - 8.0):
                painter.drawPixmap(
                    QPointF(round(x * ratio) / ratio, round(y * ratio) / ratio), picture
                )

    def _number(self, text: str, ratio: float) -> QPixmap:
        pixmap = self._numbers.get((text, ratio))
        if pixmap is None:
            font = painting.system_font(bold=True)
            metrics = QFontMetricsF(font)
            width, height = metrics.horizontalAdvance(text) + 6.0, metrics.height() + 4.0
            pixmap = _blank_pixmap(width, height, ratio)
            pixmap_painter = QPainter(pixmap)
            painting.outlined_text(pixmap_painter, 3.0, 2.0 + metrics.ascent(), text, font)
            pixmap_painter.end()
            self._numbers[(text, ratio)] = pixmap
        return pixmap

    # --- labels ------------------------------------------------------------------------------
    def _is_selection_only(self, arrays: _FeatureArrays) -> bool:
        """Return whether only selected features are labelled to avoid hiding the rock."""
        has_many_labels = int(arrays.has_label.sum()) > MAX_LABELLED_FEATURES
        return self.label_mode == "selected" or (self.label_mode == "auto" and has_many_labels)

    def _paint_labels(
        self,
        painter: QPainter,
        arrays: _FeatureArrays,
        anchors: FloatArray,
        is_visible: BoolArray,
        is_selected: BoolArray,
        grid: LabelGrid,
        gap: float,
        is_moving: bool,
        ratio: float,
    ) -> None:
        was_recently_visible = self._recently_visible(
            arrays, is_visible, self._label_ages, is_moving
        )
        was_shown = arrays.flags(self._label_ages)
        candidates = self._label_mask(arrays, is_selected, is_moving)
        candidates &= (was_recently_visible | is_selected) & np.isfinite(anchors).all(axis=1)
        rows = np.flatnonzero(candidates)
        order = order_by_importance(
            is_selected[rows], was_shown[rows], arrays.extents[rows], is_moving=is_moving
        )
        corners = arrays.numbers(self._corners)
        # While the view moves, a new label needs more space, so that it does not vanish at the
        # next step.
        clearances = (
            np.where(was_shown | is_selected, 0.0, NEW_LABEL_CLEARANCE) if is_moving else None
        )
        placed_labels = place_labels(
            grid, anchors, arrays.sizes, rows[order], gap, corners, clearances
        )
        for i, (x, y) in placed_labels.items():
            d = arrays.drawings[i]
            picture = self.labels.picture(d.label, d.color, bool(is_selected[i]), ratio, d.verdict)
            painter.drawPixmap(QPointF(x, y), picture)
            width, height = arrays.sizes[i]
            self.label_boxes.append((d.id, QRectF(x, y, float(width), float(height))))
        self._remember(self._label_ages, arrays, list(placed_labels), is_visible)
        self._corners = {arrays.drawings[i].id: int(corners[i]) for i in placed_labels}

    def paint_hovered(
        self, painter: QPainter, drawing: FeatureDrawing, x: float, y: float, available_rect: QRectF
    ) -> None:
        """Paint the label of the feature under the cursor beside a pixel, inside `available_rect`.

        Nothing is painted if the feature is already labelled or labels are switched off.
        """
        is_labelled = any(id_ == drawing.id for id_, _ in self.label_boxes)
        if self.label_mode == "none" or not drawing.label or is_labelled:
            return
        width, height = self.labels.size(drawing.label, drawing.verdict)
        x_left = min(max(x + HOVER_GAP, available_rect.left()), available_rect.right() - width)
        y_top = min(
            max(y - HOVER_GAP - height, available_rect.top()), available_rect.bottom() - height
        )
        ratio = painter.device().devicePixelRatioF()
        picture = self.labels.picture(drawing.label, drawing.color, False, ratio, drawing.verdict)
        painter.drawPixmap(QPointF(x_left, y_top), picture)

    # --- memory ------------------------------------------------------------------------------
    def _recently_visible(
        self,
        arrays: _FeatureArrays,
        is_visible: BoolArray,
        hidden_frames_by_id: dict[str, int],
        is_moving: bool,
    ) -> BoolArray:
        """Return a mask (n,) of drawings that are or, in a moving view, recently were visible."""
        if not is_moving or not hidden_frames_by_id:
            return is_visible
        return is_visible | arrays.flags(
            id_
            for id_, hidden_frames in hidden_frames_by_id.items()
            if hidden_frames < MAX_HIDDEN_FRAMES
        )

    def _remember(
        self,
        hidden_frames_by_id: dict[str, int],
        arrays: _FeatureArrays,
        shown_rows: Iterable[int],
        is_visible: BoolArray,
    ) -> None:
        """Update the number of frames for which each drawn label or symbol has been hidden."""
        previous_positions = dict(hidden_frames_by_id)
        hidden_frames_by_id.clear()
        for row in shown_rows:
            id_ = arrays.drawings[row].id
            hidden_frames_by_id[id_] = 0 if is_visible[row] else previous_positions.get(id_, 0) + 1


def _flat_pen(color: QColor, width: float) -> QPen:
    pen = QPen(color, width)
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return pen


def _copy_sizes(source: _FeatureArrays, target: _FeatureArrays) -> None:
    """Copy the positions and sizes of the labels of unchanged drawings."""
    source_rows = dict(zip(map(id, source.drawings), count(), strict=False))
    rows = np.fromiter(
        map(source_rows.get, map(id, target.drawings), repeat(-1)), np.int64, target.count
    )
    is_known = rows >= 0
    is_known[is_known] = source.is_measured[rows[is_known]]
    rows = rows[is_known]
    target.places[is_known], target.sizes[is_known] = source.places[rows], source.sizes[rows]
    target.is_measured[is_known] = True


def _label_anchors(drawings: list[FeatureDrawing]) -> FloatArray:
    """Return the possible label positions (n, 5, 3) of drawings in the World frame."""
    anchors = np.concatenate([np.asarray(d.anchor, float) for d in drawings]).reshape(-1, 3)
    places = np.repeat(anchors[:, None], 1 + len(LINE_POSITIONS), axis=1)
    lines = [np.asarray(d.line, float).reshape(-1, 3) for d in drawings]
    sizes = np.array([len(line) for line in lines], np.int64)
    is_line = sizes >= 2
    starts, last_indices = (np.cumsum(sizes) - sizes)[is_line], sizes[is_line] - 1
    vertices = np.round(np.outer(last_indices, LINE_POSITIONS)).astype(np.int64)
    places[is_line, 1:] = np.concatenate(lines)[starts[:, None] + vertices]
    return places


def _blank_pixmap(width: float, height: float, ratio: float) -> QPixmap:
    """Return a transparent picture of a given size in logical pixels."""
    pixmap = QPixmap(int(np.ceil(width * ratio)), int(np.ceil(height * ratio)))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(Qt.GlobalColor.transparent)
    return pixmap
