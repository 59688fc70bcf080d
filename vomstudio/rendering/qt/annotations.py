"""Labels and symbols of the features over the drawn outcrop: what is shown, where, and what lies
under a pixel. Qt, but no VTK.

Nothing piles up: symbols and labels take places in the image in the order of their importance, and
those that find none are left out, a symbol down to a dot in its type's colour.
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
from vomstudio.rendering.view.decluttering import LabelGrid, by_importance, place_labels
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.symbols import SMALLEST_DISC, Signs, SymbolSet

Project = Callable[[FloatArray], tuple[FloatArray, BoolArray]]

_PATIENCE = 6
"""Frames of a moving view for which something stays though its place is not seen: the depth of a
coarser model comes and goes."""
_ROOM = 13.0
"""Half the side of the square that a symbol keeps free of other symbols, in pixels."""
_DOT = 6.0
_ROOM_FOR_NEW = 10.0
_CAP = 1.2
_FEW = 12
_CASED = 1200
"""Strokes above which symbols have one casing instead of two."""
_REACH = 7.0
_LABEL_GAP = 7.0
_ALONG = (0.25, 0.75, 0.0, 1.0)
"""Where on a feature's line its label and symbol may stand if its anchor is not seen."""
_SYMBOL_GAP = 17.0
# Of thousands of drawings at every change: a loop of Python's own takes three times as long.
_ID, _EXTENT, _LABEL, _SYMBOL = map(attrgetter, ("id", "extent", "label", "symbol"))


@dataclass(frozen=True, eq=False)
class _Ready:
    """The visible drawings, worked out once for all the frames until they change.

    rows : of the drawings, by id
    places : (n, 5, 3) World, where label and symbol may stand: the anchor, then along the line
    sizes : (n, 2) of the labels, in pixels
    """

    drawings: list[FeatureDrawing]
    rows: dict[str, int]
    places: FloatArray
    extents: FloatArray
    sizes: FloatArray
    labelled: BoolArray
    symbol_rows: IntArray
    symbols: SymbolSet
    discs: BoolArray

    @property
    def count(self) -> int:
        return len(self.drawings)

    def among(self, ids: Iterable[str]) -> IntArray:
        """The rows of those of these ids that are here."""
        rows = self.rows
        return np.array([rows[id_] for id_ in ids if id_ in rows], np.int64)

    def flags(self, ids: Iterable[str]) -> BoolArray:
        """(n,) which have one of these ids."""
        found = np.zeros(self.count, np.bool_)
        found[self.among(ids)] = True
        return found

    def numbers(self, known: Mapping[str, int]) -> IntArray:
        """(n,) what is known of each, 0 where nothing is."""
        found = np.zeros(self.count, np.int64)
        here = [(self.rows[id_], number) for id_, number in known.items() if id_ in self.rows]
        if here:
            rows, numbers = np.array(here, np.int64).T
            found[rows] = numbers
        return found


class Annotations:
    def __init__(self) -> None:
        self.labels = painting.LabelCache()
        self.label_boxes: list[tuple[str, QRectF]] = []
        self._numbers: dict[tuple[str, float], QPixmap] = {}
        self._dots: dict[tuple[tuple[float, float, float], float, float], QPixmap] = {}
        self._ready: _Ready | None = None
        self._before: _Ready | None = None
        self._corners: dict[str, int] = {}
        self._labels_shown: dict[str, int] = {}
        self._symbols_shown: dict[str, int] = {}
        self._stood: dict[str, int] = {}
        self._strokes: FloatArray = np.zeros((0, 2, 2))
        self._owners: IntArray = np.zeros(0, np.int64)

    def forget(self) -> None:
        """The drawings have changed."""
        self._before = self._ready or self._before
        self._ready = None

    def forget_font(self) -> None:
        self.labels.clear()
        self._numbers.clear()
        self._before = self._ready = None

    def at(self, x: float, y: float) -> str | None:
        """The feature whose label or symbol lies under a pixel."""
        for key, box in self.label_boxes:
            if box.contains(x, y):
                return key
        if self._ready is None or not len(self._strokes):
            return None
        a, b = self._strokes[:, 0], self._strokes[:, 1]
        ab, point = b - a, np.array([x, y])
        square = np.maximum(np.einsum("ij,ij->i", ab, ab), 1e-12)
        t = np.clip(np.einsum("ij,ij->i", point - a, ab) / square, 0.0, 1.0)
        off = np.hypot(*(a + t[:, None] * ab - point).T)
        best = int(np.argmin(off))
        if off[best] > _REACH:
            return None
        return self._ready.drawings[int(self._owners[best])].id

    def paint(
        self,
        painter: QPainter,
        features: Mapping[str, FeatureDrawing],
        selected: frozenset[str],
        camera: Camera,
        project: Project,
        size: tuple[float, float],
        *,
        kept_free: Iterable[QRectF] = (),
        moving: bool = False,
    ) -> None:
        """project : pixels of World points, and whether they are seen."""
        self.label_boxes = []
        self._strokes, self._owners = np.zeros((0, 2, 2)), np.zeros(0, np.int64)
        ready = self._ready or self._prepare(features)
        self._ready = ready
        if not ready.drawings:
            return
        ratio = painter.device().devicePixelRatioF()
        count = len(ready.drawings)
        pixels, there = project(ready.places.reshape(-1, 3))
        at = self._stand(ready, there.reshape(count, -1), moving)
        anchors = pixels.reshape(count, -1, 2)[np.arange(count), at]
        seen = there.reshape(count, -1)[np.arange(count), at]
        chosen = ready.flags(selected)
        grid = LabelGrid(*size)
        for box in kept_free:
            grid.block(box.x(), box.y(), box.width(), box.height())
        gap = _LABEL_GAP
        if len(ready.symbol_rows):
            rows = ready.symbol_rows
            signs = ready.symbols.signs(camera, size, ready.places[rows, at[rows]])
            self._paint_symbols(painter, ready, signs, seen, chosen, grid, size, moving)
            if not ready.discs.all():
                gap = _SYMBOL_GAP
        self._paint_labels(painter, ready, anchors, seen, chosen, grid, gap, moving, ratio)

    def _prepare(self, features: Mapping[str, FeatureDrawing]) -> _Ready:
        drawings = [d for d in features.values() if d.visible and (d.label or d.symbol)]
        symbols = list(map(_SYMBOL, drawings))
        known = list(filter(None, symbols))
        places, sizes = self._measure(drawings)
        return _Ready(
            drawings,
            dict(zip(map(_ID, drawings), count(), strict=False)),
            places,
            np.fromiter(map(_EXTENT, drawings), float, len(drawings)),
            sizes,
            np.fromiter(map(bool, map(_LABEL, drawings)), np.bool_, len(drawings)),
            np.flatnonzero(np.fromiter(map(bool, symbols), np.bool_, len(drawings))),
            SymbolSet(known),
            np.array([s.kind == "disc" for s in known], np.bool_),
        )

    def _measure(self, drawings: list[FeatureDrawing]) -> tuple[FloatArray, FloatArray]:
        """Places and sizes of the labels; of most nothing has changed since the last time."""
        places, sizes = np.zeros((len(drawings), 1 + len(_ALONG), 3)), np.zeros((len(drawings), 2))
        before = self._before
        rows = {} if before is None else dict(zip(map(id, before.drawings), count(), strict=False))
        old = np.fromiter(map(rows.get, map(id, drawings), repeat(-1)), np.int64, len(drawings))
        if before is not None:
            same = old >= 0
            places[same], sizes[same] = before.places[old[same]], before.sizes[old[same]]
        for row in np.flatnonzero(old < 0).tolist():
            places[row], sizes[row] = _places(drawings[row]), self.labels.size(drawings[row].label)
        self._before = None
        return places, sizes

    def _stand(self, ready: _Ready, seen: BoolArray, moving: bool) -> IntArray:
        """(n,) at which of its places each feature is named: where it was last as long as that is
        seen, else at the first that is; so a long trace is named however near the viewer is."""
        last = ready.numbers(self._stood)
        # The anchor again, once everything rests.
        first = last if moving else np.zeros_like(last)
        kept = seen[np.arange(ready.count), first] | ~seen.any(axis=1)
        if moving:
            for shown in (self._labels_shown, self._symbols_shown):
                gone = ready.numbers(shown)
                kept |= (gone > 0) & (gone < _PATIENCE)
        at = np.where(kept, first, np.argmax(seen, axis=1))
        self._stood = {ready.drawings[i].id: int(at[i]) for i in np.flatnonzero(at).tolist()}
        return at

    # --- symbols -----------------------------------------------------------------------------
    def _paint_symbols(
        self,
        painter: QPainter,
        ready: _Ready,
        signs: Signs,
        seen: BoolArray,
        chosen: BoolArray,
        grid: LabelGrid,
        size: tuple[float, float],
        moving: bool,
    ) -> None:
        rows = ready.symbol_rows
        extents = ready.extents[rows]
        with np.errstate(invalid="ignore"):
            inside = (
                (signs.depth > 0.0)
                & (signs.pixels > -20.0).all(axis=1)
                & (signs.pixels < np.array(size) + 20.0).all(axis=1)
            )
        there = self._patient(ready, seen, self._symbols_shown, moving)[rows]
        small = extents < SMALLEST_DISC * signs.metres
        wanted = inside & (there | chosen[rows]) & (~ready.discs | small)
        kept = ready.flags(self._symbols_shown)[rows]
        order = by_importance(chosen[rows], kept, extents, moving=moving)
        # A margin all round: a symbol half out of the image is one all the same.
        room = LabelGrid(size[0] + 40.0, size[1] + 40.0)
        full, dots, discs = [], [], []
        # A few selected ones lie over all others; many of them would pile up too.
        few = np.flatnonzero(chosen[rows])
        certain = set(few.tolist()) if len(few) <= _FEW else set()
        places = signs.pixels.tolist()
        for i in order[wanted[order]].tolist():
            x, y = places[i]
            margin = _ROOM + (6.0 if moving and not kept[i] else 0.0)
            free = room.is_free(x + 20.0 - margin, y + 20.0 - margin, 2 * margin, 2 * margin)
            if ready.discs[i]:
                discs.append(i)
            elif i in certain or free:
                room.block(x + 20.0 - _ROOM, y + 20.0 - _ROOM, 2 * _ROOM, 2 * _ROOM)
                full.append(i)
                grid.block(x - 6.0, y - 6.0, 12.0, 12.0)
            else:
                dots.append(i)
        self._remember(self._symbols_shown, ready, rows[full].tolist(), seen)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colors = [ready.drawings[i].color for i in rows]
        # The first in the order last, over the others.
        self._paint_dots(painter, signs.pixels, discs[::-1], colors, SMALLEST_DISC)
        self._paint_dots(painter, signs.pixels, dots[::-1], colors, _DOT)
        strokes, owners = signs.strokes(full)
        self._paint_strokes(painter, strokes, owners, colors, chosen[rows])
        self._paint_numbers(painter, ready, signs, full, grid)
        dots += discs
        dot_strokes = np.repeat(signs.pixels[dots][:, None], 2, axis=1).reshape(-1, 2, 2)
        self._strokes = np.concatenate([strokes, dot_strokes])
        self._owners = rows[np.concatenate([owners, np.array(dots, np.int64)])]

    def _paint_dots(
        self,
        painter: QPainter,
        pixels: FloatArray,
        dots: list[int],
        colors: list[tuple[float, float, float]],
        width: float,
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        half = width / 2.0 + 1.0
        for i in dots:
            x, y = pixels[i]
            painter.drawPixmap(QPointF(x - half, y - half), self._dot(colors[i], width, ratio))

    def _dot(self, color: tuple[float, float, float], width: float, ratio: float) -> QPixmap:
        """Kept as a small picture: round points take Qt ten times as long."""
        key = (color, width, ratio)
        found = self._dots.get(key)
        if found is None:
            found = _blank(width + 2.0, width + 2.0, ratio)
            inner = QPainter(found)
            inner.setRenderHint(QPainter.RenderHint.Antialiasing)
            inner.setPen(QPen(painting.DARK, 1.2))
            inner.setBrush(painting.to_color(color))
            inner.drawEllipse(QRectF(1.0, 1.0, width, width))
            inner.end()
            self._dots[key] = found
        return found

    def _paint_strokes(
        self,
        painter: QPainter,
        strokes: FloatArray,
        owners: IntArray,
        colors: list[tuple[float, float, float]],
        chosen: BoolArray,
    ) -> None:
        if not len(strokes):
            return
        # Flat ends, drawn a little longer, take a third of the time of round ones.
        along = strokes[:, 1] - strokes[:, 0]
        along *= _CAP / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
        longer = strokes + np.stack([-along, along], axis=1)
        lines = [QLineF(*ends) for ends in longer.reshape(-1, 4).tolist()]
        groups: dict[tuple[bool, tuple[float, float, float]], list[QLineF]] = {}
        for line, owner in zip(lines, owners.tolist(), strict=True):
            groups.setdefault((bool(chosen[owner]), colors[owner]), []).append(line)
        shade = QColor(painting.DARK)
        shade.setAlphaF(0.85)
        # The selected ones over all others.
        for selected in (False, True):
            own = {color: part for (s, color), part in groups.items() if s == selected}
            every = [line for part in own.values() for line in part]
            if not every:
                continue
            wider = 2.0 if selected else 0.0
            # A light casing within the dark one: a symbol may lie on the line of its own trace.
            # Among very many there is time for one of them only.
            casing = [(shade, 6.2), (painting.TEXT, 4.6)]
            for tint, wide in casing if len(every) < _CASED else [(painting.TEXT, 4.6)]:
                painter.setPen(_flat(tint, wide + wider))
                painter.drawLines(every)
            for color, part in own.items():
                painter.setPen(_flat(painting.to_color(color), 3.2 if selected else 2.4))
                painter.drawLines(part)

    def _paint_numbers(
        self, painter: QPainter, ready: _Ready, signs: Signs, full: list[int], grid: LabelGrid
    ) -> None:
        ratio = painter.device().devicePixelRatioF()
        centres = signs.numbers()
        for i in full:
            symbol = ready.drawings[int(ready.symbol_rows[i])].symbol
            if symbol is None or not symbol.text or not np.isfinite(centres[i]).all():
                continue
            picture = self._number(symbol.text, ratio)
            wide, tall = picture.width() / ratio, picture.height() / ratio
            x, y = centres[i][0] - wide / 2.0, centres[i][1] - tall / 2.0
            if grid.take(x + 2.0, y + 4.0, wide - 4.0, tall - 8.0):
                painter.drawPixmap(
                    QPointF(round(x * ratio) / ratio, round(y * ratio) / ratio), picture
                )

    def _number(self, text: str, ratio: float) -> QPixmap:
        found = self._numbers.get((text, ratio))
        if found is None:
            font = painting.system_font(bold=True)
            metrics = QFontMetricsF(font)
            wide, tall = metrics.horizontalAdvance(text) + 6.0, metrics.height() + 4.0
            found = _blank(wide, tall, ratio)
            inner = QPainter(found)
            painting.outlined_text(inner, 3.0, 2.0 + metrics.ascent(), text, font)
            inner.end()
            self._numbers[(text, ratio)] = found
        return found

    # --- labels ------------------------------------------------------------------------------
    def _paint_labels(
        self,
        painter: QPainter,
        ready: _Ready,
        anchors: FloatArray,
        seen: BoolArray,
        chosen: BoolArray,
        grid: LabelGrid,
        gap: float,
        moving: bool,
        ratio: float,
    ) -> None:
        there = self._patient(ready, seen, self._labels_shown, moving)
        kept = ready.flags(self._labels_shown)
        wanted = ready.labelled & (there | chosen) & np.isfinite(anchors).all(axis=1)
        order = by_importance(chosen, kept, ready.extents, moving=moving)
        corners = ready.numbers(self._corners)
        # While the view moves, what is new needs more room, or it would go at the next step.
        clear = np.where(kept | chosen, 0.0, _ROOM_FOR_NEW) if moving else None
        placed = place_labels(grid, anchors, ready.sizes, order[wanted[order]], gap, corners, clear)
        for i, (x, y) in placed.items():
            d = ready.drawings[i]
            picture = self.labels.picture(d.label, d.color, bool(chosen[i]), ratio)
            painter.drawPixmap(QPointF(x, y), picture)
            wide, tall = ready.sizes[i]
            self.label_boxes.append((d.id, QRectF(x, y, float(wide), float(tall))))
        self._remember(self._labels_shown, ready, list(placed), seen)
        self._corners = {ready.drawings[i].id: int(corners[i]) for i in placed}

    # --- memory ------------------------------------------------------------------------------
    def _patient(
        self, ready: _Ready, seen: BoolArray, shown: dict[str, int], moving: bool
    ) -> BoolArray:
        """What is seen, and while the view moves what was shown and seen a few frames ago."""
        if not moving or not shown:
            return seen
        return seen | ready.flags(id_ for id_, gone in shown.items() if gone < _PATIENCE)

    def _remember(
        self, shown: dict[str, int], ready: _Ready, now: Iterable[int], seen: BoolArray
    ) -> None:
        """For each row that is shown, for how many frames it has not been seen."""
        before = dict(shown)
        shown.clear()
        for row in now:
            id_ = ready.drawings[row].id
            shown[id_] = 0 if seen[row] else before.get(id_, 0) + 1


def _flat(color: QColor, width: float) -> QPen:
    pen = QPen(color, width)
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return pen


def _places(drawing: FeatureDrawing) -> FloatArray:
    """(5, 3) World"""
    line = np.asarray(drawing.line, float).reshape(-1, 3)
    anchor = np.asarray(drawing.anchor, float)
    if len(line) < 2:
        return np.repeat(anchor[None], 1 + len(_ALONG), axis=0)
    rows = [round(along * (len(line) - 1)) for along in _ALONG]
    return np.concatenate([anchor[None], line[rows]])


def _blank(width: float, height: float, ratio: float) -> QPixmap:
    """A clear picture of so many logical pixels."""
    made = QPixmap(int(np.ceil(width * ratio)), int(np.ceil(height * ratio)))
    made.setDevicePixelRatio(ratio)
    made.fill(Qt.GlobalColor.transparent)
    return made
