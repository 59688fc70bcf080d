"""Drawing of an extended plane: its traces and error band as lines over the texture.

The user compares them with the beds in the texture.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from vomstudio.core.arrays import FloatArray
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.proposed_trace_drawings import LineDrawings, line_area, piece_area

_COLORS = {"traces": "#e7298a", "edges": "#f0e442"}
"""Colours that differ from the default colours of feature types."""


@dataclass(frozen=True, eq=False)
class ExtendedLines:
    """Lines of an extended plane in the World frame.

    Attributes
    ----------
    traces : sequence of (n, 3) arrays
        Traces of the plane on the surface.
    edges : (k, 2, 3) array
        Line segments along the edges of the error band.
    """

    model_id: str
    traces: Sequence[FloatArray]
    edges: FloatArray


class ExtendedPlaneDrawings(LineDrawings):
    """Drawing of the extended plane in the viewport."""

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        super().__init__(studio, viewport)
        self._lines: ExtendedLines | None = None
        studio.extension_shown.connect(self._show_lines)
        studio.project_opened.connect(lambda: self._show_lines(None))
        studio.edited.connect(lambda _: self._redraw())

    def _show_lines(self, lines: ExtendedLines | None) -> None:
        self._lines = lines
        self._redraw()

    def _create_drawings(self) -> Iterator[FeatureDrawing]:
        lines = self._lines
        if lines is None or not isinstance(self._studio.records.get(lines.model_id), Model):
            return
        areas = {"edges": piece_area(lines.edges), "traces": line_area(lines.traces)}
        for key, area in areas.items():
            id_ = f"extended plane:{key}"
            yield from self._draw_area(id_, area, _COLORS[key], lines.model_id)
