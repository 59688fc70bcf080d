"""Drawing of an extended plane: its traces and error band as lines over the texture.

The user compares them with the beds in the texture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.polyline import rgb
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.proposed_trace_drawings import line_area, piece_area

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


class ExtendedPlaneDrawings:
    """Drawing of the extended plane in the viewport; it cannot be picked."""

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        self._studio, self._layer = studio, viewport.features
        self._lines: ExtendedLines | None = None
        self._drawn_keys: set[str] = set()
        studio.extension_shown.connect(self._show)
        studio.project_opened.connect(lambda: self._show(None))
        studio.edited.connect(lambda _: self._redraw())
        studio.visibility_changed.connect(lambda _: self._redraw())

    def _show(self, lines: ExtendedLines | None) -> None:
        self._lines = lines
        self._redraw()

    def _redraw(self) -> None:
        drawings = {drawing.id: drawing for drawing in self._drawings()}
        removed_keys = self._drawn_keys - drawings.keys()
        self._drawn_keys = set(drawings)
        if removed_keys or drawings:
            self._layer.change({**dict.fromkeys(removed_keys), **drawings})

    def _drawings(self) -> list[FeatureDrawing]:
        lines = self._lines
        if lines is None or not isinstance(self._studio.records.get(lines.model_id), Model):
            return []
        visible = self._studio.visible(lines.model_id)
        drawings = []
        for key, area in (
            ("edges", piece_area(lines.edges)),
            ("traces", line_area(lines.traces)),
        ):
            if area is not None:
                drawings.append(
                    FeatureDrawing(
                        f"extended plane:{key}",
                        np.zeros((0, 3)),
                        None,
                        rgb(_COLORS[key]),
                        "",
                        area.origin,
                        visible,
                        area,
                    )
                )
        return drawings
