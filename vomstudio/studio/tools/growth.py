"""A piece of a surface that grows from a click, and grows anew as its tolerance is turned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.extraction.selection.neighbours import Piece
from vomstudio.geometry import transform
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.interaction_types import Hit
from vomstudio.studio.tools.tool_context import ToolContext

LEAST_ANGLE, LARGEST_ANGLE = 1.0, 90.0
LEAST_DISTANCE, LARGEST_DISTANCE = 1e-4, 1e4
_ANGLE_STEP = 2.0
_DISTANCE_STEP = 1.2
_SPACINGS = 4.0
"""The first distance, in spacings of the model: its noise is below that."""


@dataclass(frozen=True, eq=False)
class Seed:
    """Where it began; how : what is done with what is found."""

    hit: Hit
    how: Combine


class Growth:
    """angle_deg : by which normals may be off the plane of the piece, degrees; distance : by which
    places may, metres, None until a model has suggested one. seed : of the last piece, None once it
    is settled"""

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.angle_deg = 20.0
        self.distance: float | None = None
        self.seed: Seed | None = None

    def set_angle(self, degrees: float) -> None:
        """Within the limits."""
        self.angle_deg = min(max(float(degrees), LEAST_ANGLE), LARGEST_ANGLE)

    def set_distance(self, metres: float) -> None:
        """Within the limits."""
        self.distance = min(max(float(metres), LEAST_DISTANCE), LARGEST_DISTANCE)

    def turn(self, turns: float, *, distance: bool) -> None:
        """By notches of the wheel."""
        if distance:
            self.set_distance(float(f"{(self.distance or 0.1) * _DISTANCE_STEP**turns:.2g}"))
        else:
            self.set_angle(self.angle_deg + _ANGLE_STEP * turns)

    def piece(self, hit: Hit, then: Callable[[], None]) -> Piece | None:
        """What grows from a place; None where it cannot, which is said, or not yet: then `then` is
        called once it can."""
        elements = self._context.elements
        model = get(self._context.session.records, hit.model_id, Model)
        found = elements.neighbours(hit.model_id, then)
        if model is None:
            return None
        if found is None:
            self._context.hint(Finding("neighbours.pending"))
            return None
        if isinstance(found, Finding):
            self._context.say(found)
            return None
        scale = transform.scale_of(model.to_world)
        if self.distance is None:
            wanted = _SPACINGS * elements.spacing(hit.model_id) * scale
            self.set_distance(float(f"{wanted:.2g}") if np.isfinite(wanted) and wanted else 0.1)
        piece = found.piece(
            hit.index,
            angle_deg=self.angle_deg,
            distance=(self.distance or 0.0) / scale,
            left_out=elements.hidden(hit.model_id),
        )
        self._tell(piece)
        return piece if piece.count else None

    def _tell(self, piece: Piece) -> None:
        """Where it is not what anybody wants."""
        if piece.count == 0:
            self._context.hint(Finding("growth.no-plane"))
        elif piece.count == 1:
            self._context.hint(Finding("growth.isolated"))
        elif piece.stopped:
            self._context.hint(Finding("growth.stopped", count=piece.count))
        elif piece.count == len(piece.mask):
            self._context.hint(Finding("growth.whole-model"))
