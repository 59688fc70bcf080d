"""A thread that computes in which photos points are visible, and the features of a photo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QObject, Signal

from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.ui.common.photo_canvas import Drawn
from vomstudio.ui.common.worker_thread import Work, WorkerThread
from vomstudio.workspace.photos import ModelPhotos

Array = npt.NDArray[np.float64]

_MOST_EDGES = 3000  # of a patch
_STEP_PX = 5.0
_AT_ONCE = 25


@dataclass(frozen=True, eq=False)
class _Places:
    """World points (n, 3) that photos shall show; token: given back with the answer."""

    token: int
    photos: ModelPhotos
    points: Array


@dataclass(frozen=True, eq=False)
class _Features:
    """Features to be drawn over one photo, the most wanted first."""

    view: int
    photos: ModelPhotos
    drawings: Sequence[FeatureDrawing]


class SightingThread(QObject):
    """Answers two kinds of questions, and of each kind only the newest.

    sighted : token and the sightings of a place; drawn : view and its features so far
    """

    sighted = Signal(int, object)
    drawn = Signal(int, object)

    def __init__(self) -> None:
        super().__init__()
        self._places: _Places | None = None
        self._features: _Features | None = None
        self._worker = WorkerThread("in photos", self._take)

    def find(self, token: int, photos: ModelPhotos, points: Array) -> None:
        with self._worker.lock:
            self._places = _Places(token, photos, points)
        self._worker.wake()

    def draw(self, view: int, photos: ModelPhotos, drawings: Sequence[FeatureDrawing]) -> None:
        with self._worker.lock:
            self._features = _Features(view, photos, drawings)
        self._worker.wake()

    def close(self) -> None:
        self._worker.close()

    # --- in the thread -----------------------------------------------------------------------
    def _take(self) -> Work | None:
        if self._places is not None:
            places, self._places = self._places, None
            return partial(self._find, places)
        if self._features is not None:
            features, self._features = self._features, None
            return partial(self._draw_all, features)
        return None

    def _find(self, places: _Places) -> None:
        self.sighted.emit(places.token, places.photos.views.sightings(places.points))

    def _draw_all(self, features: _Features) -> None:
        made: list[Drawn] = []
        for number, drawing in enumerate(features.drawings, start=1):
            made += _drawn(features.photos, features.view, drawing)
            with self._worker.lock:
                if self._worker.closed or self._features is not None:
                    return
            if number % _AT_ONCE == 0:
                self.drawn.emit(features.view, list(made))
        self.drawn.emit(features.view, made)


def _drawn(photos: ModelPhotos, view: int, drawing: FeatureDrawing) -> list[Drawn]:
    """A feature over a photo; nothing where it does not reach into it."""
    views = photos.views
    pairs = False
    if len(drawing.line) > 1:
        pixels, seen = views.course(view, drawing.line, _STEP_PX)
    elif drawing.area is not None:
        edges = drawing.area.border[:: max(1, len(drawing.area.border) // _MOST_EDGES)]
        world = drawing.area.origin + edges.reshape(-1, 3).astype(np.float64)
        pixels, seen = views.pixels(view, world), views.shows(view, world)
        pairs = True
    else:
        return []
    if not seen.any():
        return []
    anchor = None
    if views.shows(view, drawing.anchor[None])[0]:
        anchor = views.pixels(view, drawing.anchor[None])[0]
    elif not pairs:
        rows = np.flatnonzero(seen)
        anchor = pixels[rows[len(rows) // 2]]
    return [Drawn(drawing.id, pixels, seen, drawing.color, drawing.label, anchor, pairs)]
