"""Tool that locates control points on the model by clicks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.interaction_types import (
    BrushRing,
    Button,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import StatelessTool, ToolEntry


class ControlTool(StatelessTool):
    """Tool that locates control points; each click is an edit.

    A click locates the current point, and the next point without a location becomes current. If all
    points are located, a click creates a point, whose coordinates are entered afterwards.
    """

    name: ClassVar[str] = "control"
    can_paint: ClassVar[bool] = False

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._current = ""
        self._is_active = False
        self._expected_positions: Mapping[str, FloatArray] = {}
        self._radius = 0.0

    # --- state -------------------------------------------------------------------------------
    @property
    def is_open(self) -> bool:
        return False

    @property
    def current(self) -> ControlPoint | None:
        """Point that the next click locates, or None if it creates a new point."""
        return get(self._context.session.records, self._current, ControlPoint)

    def begin(self) -> None:
        """Activate the tool."""
        self._is_active = True
        self._show_preview()

    def choose(self, id_: str) -> None:
        """Select the point that is located next; "" selects a new point."""
        self._current = id_
        self._show_preview()
        self._context.tool_changed()

    def expect(self, positions: Mapping[str, FloatArray], radius: float) -> None:
        """Set the expected positions of points without a location.

        Parameters
        ----------
        positions : mapping of str to (3,) float64
            Positions in the World frame, keyed by point id.
        radius : float
            Radius of the ring around each position, metres.
        """
        self._expected_positions, self._radius = positions, radius
        self._show_preview()

    def hint(self) -> str:
        point = self.current
        if point is None:
            return tr("Control points: click a point, then enter its coordinates in the list.")
        if point.vertices:
            return tr(
                "Control points: click the new position of {point}.",
                point=point.name,
            )
        if point.id in self._expected_positions:
            return tr(
                "Control points: click {point}; a ring shows its expected position.",
                point=point.name,
            )
        return tr("Control points: click {point} on the outcrop.", point=point.name)

    def finish_problem(self) -> Finding | None:
        return Finding("tool.nothing-open")

    def cancel_problem(self) -> Finding | None:
        return Finding("tool.nothing-open")

    # --- gestures -----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        self._is_active = True
        if event.kind is Pointer.CLICK and event.button is Button.LEFT and event.hit is not None:
            self._place_point(event.hit)

    def _place_point(self, hit: Hit) -> None:
        records = self._context.session.records
        model = get(records, hit.model_id, Model)
        if model is None:
            return
        point = self.current
        if point is not None and point.model_id != model.id:
            self._context.report(
                Finding("feature.on-other-model", feature=point.name, model=model.name)
            )
            return
        try:
            id_ = self._store_edit(self._edit(point, model, hit))
        except VomError as error:
            self._context.report(error)
            return
        self._current = "" if point is None else self._next_point(point)
        self._context.report_created(id_)
        self._show_preview()
        self._context.tool_changed()

    def _edit(self, point: ControlPoint | None, model: Model, hit: Hit) -> Edit:
        records = self._context.session.records
        if point is not None:
            return edits.change_feature(records, replace(point, vertices=(hit.position,)), "Place")
        new_point = ControlPoint(
            new_id("control"), "", model.id, model.content_hash, (hit.position,)
        )
        return edits.add_features(records, [new_point])

    def _store_edit(self, edit: Edit) -> str:
        self._context.session.apply(edit)
        return next(iter(edit.ids))

    def _next_point(self, point: ControlPoint) -> str:
        """Return the id of the next point without a location, or "" if all are located.

        Returning "" prevents an additional click from moving a point.
        """
        points = [p for p in self._context.session.of(ControlPoint) if p.model_id == point.model_id]
        position = next((i for i, p in enumerate(points) if p.id == point.id), 0)
        remaining = [p.id for p in (*points[position:], *points[:position]) if not p.vertices]
        return remaining[0] if remaining else ""

    def _show_preview(self) -> None:
        """Draw a ring at the expected position of the current point."""
        point = self.current
        position = (
            None if point is None or point.vertices else self._expected_positions.get(point.id)
        )
        if not self._is_active:
            return
        self._context.show(
            None
            if position is None
            else Preview(np.zeros((0, 3)), brush=BrushRing(position, self._radius, None))
        )

    # --- change of tool or project ------------------------------------------------------------
    def leave(self) -> None:
        self._is_active = False
        self._context.show(None)

    def document_changed(self) -> None:
        if self._current and self.current is None:
            self._current = ""

    def clear_state(self) -> None:
        self._current, self._expected_positions, self._is_active = "", {}, False


TOOL = ToolEntry(
    ControlTool,
    label=to_translate("&Control points"),
    icon="crosshairs-gps",
    key="C",
    tip=to_translate("Click points with known coordinates to register the model."),
    order=45,
)
