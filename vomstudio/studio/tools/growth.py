"""Growth of an even surface from a click, repeated when a tolerance changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.extraction.selection.neighbours import GrownPiece
from vomstudio.geometry import transform
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.interaction_types import Hit
from vomstudio.studio.tools.tool_context import ToolContext

MIN_ANGLE_DEG, MAX_ANGLE_DEG = 1.0, 90.0
MIN_DISTANCE_M, MAX_DISTANCE_M = 1e-4, 1e4
ANGLE_STEP_DEG = 2.0
DISTANCE_FACTOR = 1.2
DEFAULT_DISTANCE_SPACINGS = 4.0
"""Default distance in multiples of the point spacing; it exceeds the noise of the model."""


@dataclass(frozen=True, eq=False)
class Seed:
    """Seed of a growth, and the combination of its result with the selection."""

    hit: Hit
    combination_mode: Combine


class Growth:
    """Growth of a selection.

    Attributes
    ----------
    angle_deg : float
        Maximum angle between a face normal and the fitted plane, degrees.
    distance : float or None
        Maximum distance from the plane, metres; None until it is derived from a model.
    seed : Seed or None
        Seed of the last piece, or None once the piece is final.
    is_pending : bool
        Whether the last piece is pending until the neighbour graph is built.
    """

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.angle_deg = 20.0
        self.distance: float | None = None
        self.seed: Seed | None = None
        self.is_pending = False

    def set_angle(self, degrees: float) -> None:
        """Set the maximum angle, limited to the permitted range."""
        self.angle_deg = min(max(float(degrees), MIN_ANGLE_DEG), MAX_ANGLE_DEG)

    def set_distance(self, metres: float) -> None:
        """Set the maximum distance, limited to the permitted range."""
        self.distance = min(max(float(metres), MIN_DISTANCE_M), MAX_DISTANCE_M)

    def change_tolerance(self, step_count: float, *, includes_distance: bool) -> None:
        """Change the angle or, if `includes_distance`, the distance by some wheel notches."""
        if includes_distance:
            self.set_distance(float(f"{(self.distance or 0.1) * DISTANCE_FACTOR**step_count:.2g}"))
        else:
            self.set_angle(self.angle_deg + ANGLE_STEP_DEG * step_count)

    def piece(self, hit: Hit, finished_callback: Callable[[], None]) -> GrownPiece | None:
        """Grow a piece from a hit.

        Returns None, after a message, if this is not possible or the neighbour graph is not
        available yet; `finished_callback` is called once the graph is available.
        """
        elements = self._context.elements
        model = get(self._context.session.records, hit.model_id, Model)
        neighbours = elements.neighbours(hit.model_id, finished_callback)
        self.is_pending = model is not None and neighbours is None
        if model is None:
            return None
        if neighbours is None:
            self._context.hint(Finding("neighbours.pending"))
            return None
        if isinstance(neighbours, Finding):
            self._context.report(neighbours)
            return None
        scale = transform.scale_factor(model.to_world)
        if self.distance is None:
            distance = DEFAULT_DISTANCE_SPACINGS * elements.spacing(hit.model_id) * scale
            self.set_distance(
                float(f"{distance:.2g}") if np.isfinite(distance) and distance else 0.1
            )
        piece = neighbours.piece(
            hit.index,
            angle_deg=self.angle_deg,
            distance=(self.distance or 0.0) / scale,
            is_excluded=elements.hidden(hit.model_id),
        )
        self._report_extremes(piece)
        return piece if piece.count else None

    def _report_extremes(self, piece: GrownPiece) -> None:
        """Report a piece that is empty, isolated, truncated, or covers the whole model."""
        if piece.count == 0:
            self._context.hint(Finding("growth.no-plane"))
        elif piece.count == 1:
            self._context.hint(Finding("growth.isolated"))
        elif piece.is_truncated:
            self._context.hint(Finding("growth.stopped", count=piece.count))
        elif piece.count == len(piece.mask):
            self._context.hint(Finding("growth.whole-model"))
