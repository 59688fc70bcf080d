"""Drawing of features over a photo, in a worker thread."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.background import Request
from vomstudio.studio.photos import ModelPhotos
from vomstudio.ui.widgets.photo_canvas import Drawn

_MAX_EDGES = 3000
"""Maximum number of patch edges that are drawn."""
_STEP_PX = 5.0
_BATCH_SIZE = 25


def draw_features(
    request: Request[list[Drawn]],
    photos: ModelPhotos,
    view: int,
    drawings: Sequence[FeatureDrawing],
) -> list[Drawn]:
    """Draw features over a photo in order, and emit the drawings so far after each batch."""
    overlays: list[Drawn] = []
    for number, drawing in enumerate(drawings, start=1):
        overlays += _draw_feature(photos, view, drawing)
        request.check()
        if number % _BATCH_SIZE == 0:
            request.emit(list(overlays))
    return overlays


def _draw_feature(photos: ModelPhotos, view: int, drawing: FeatureDrawing) -> list[Drawn]:
    """Return the drawing of a feature over a photo, or an empty list if it is not visible."""
    views = photos.views
    is_paired = False
    if len(drawing.line) > 1:
        pixels, is_visible = views.project_line(view, drawing.line, _STEP_PX)
    elif drawing.area is not None:
        edges = drawing.area.border[:: max(1, len(drawing.area.border) // _MAX_EDGES)]
        world = drawing.area.origin + edges.reshape(-1, 3).astype(np.float64)
        pixels, is_visible = views.pixels(view, world), views.shows(view, world)
        is_paired = True
    else:
        return []
    if not is_visible.any():
        return []
    anchor = None
    if views.shows(view, drawing.anchor[None])[0]:
        anchor = views.pixels(view, drawing.anchor[None])[0]
    elif not is_paired:
        rows = np.flatnonzero(is_visible)
        anchor = pixels[rows[len(rows) // 2]]
    return [Drawn(drawing.id, pixels, is_visible, drawing.color, drawing.label, anchor, is_paired)]
