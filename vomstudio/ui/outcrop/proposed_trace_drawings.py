"""Drawings of proposed traces as lines on the surface, coloured by their p-value."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.studio.tools.polyline import rgb
from vomstudio.ui.base.studio import Studio

MAX_P_VALUE = 0.05
_COLORS = {"sure": "#e69f00", "doubtful": "#56b4e9"}
"""Orange and sky blue of the palette of Okabe and Ito."""


class LineDrawings:
    """Drawings of computed lines on the surface, which cannot be picked.

    Subclasses implement `_create_drawings`.
    """

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        self._studio, self._layer = studio, viewport.features
        self._drawn_keys: set[str] = set()
        studio.visibility_changed.connect(lambda _: self._redraw())

    def _redraw(self) -> None:
        drawings = {drawing.id: drawing for drawing in self._create_drawings()}
        removed_keys = self._drawn_keys - drawings.keys()
        self._drawn_keys = set(drawings)
        if removed_keys or drawings:
            self._layer.change({**dict.fromkeys(removed_keys), **drawings})

    def _create_drawings(self) -> Iterator[FeatureDrawing]:
        """Yield the drawings of the current lines."""
        raise NotImplementedError

    def _draw_area(
        self, id_: str, area: Area | None, color: str, model_id: str
    ) -> Iterator[FeatureDrawing]:
        """Yield the drawing of an area, or nothing if `area` is None."""
        if area is not None:
            is_visible = self._studio.visible(model_id)
            points = np.zeros((0, 3))
            yield FeatureDrawing(id_, points, None, rgb(color), "", area.origin, is_visible, area)


class ProposedTraceDrawings(LineDrawings):
    """Drawings of the undecided proposed traces."""

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        super().__init__(studio, viewport)
        studio.proposed_traces.changed.connect(self._redraw)
        self._redraw()

    def _create_drawings(self) -> Iterator[FeatureDrawing]:
        traces = self._studio.proposed_traces
        proposals, open_indices = traces.proposals, sorted(traces.open_rows)
        if proposals is None or not isinstance(self._studio.records.get(proposals.model_id), Model):
            return
        for key, color in _COLORS.items():
            lines = [
                proposals.lines[row].points
                for row in open_indices
                if (proposals.lines[row].doubt <= MAX_P_VALUE) == (key == "sure")
            ]
            id_ = f"proposed traces:{key}"
            yield from self._draw_area(id_, line_area(lines), color, proposals.model_id)


def line_area(lines: Sequence[FloatArray]) -> Area | None:
    """Return World lines (n, 3) as an area for drawing, or None if there are no lines."""
    pieces = [np.stack([line[:-1], line[1:]], axis=1) for line in lines if len(line) > 1]
    return piece_area(np.concatenate(pieces)) if pieces else None


def piece_area(pieces: FloatArray) -> Area | None:
    """Return World segments (k, 2, 3) as an area for drawing, or None for no segments."""
    if not len(pieces):
        return None
    origin = np.floor(pieces[0, 0])
    empty_corners = np.zeros((0, 3, 3), np.float32)
    return Area(origin, empty_corners, (pieces - origin).astype(np.float32))
