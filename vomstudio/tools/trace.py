"""The trace tool: clicks along a line where a surface meets the outcrop become a plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from textwrap import wrap
from typing import Any

import numpy as np

from vomstudio.document import edits
from vomstudio.document.edit import Edit
from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import SURROUNDINGS_RULE, Model, Point
from vomstudio.geometry import transform
from vomstudio.geometry.plane_discs import disc
from vomstudio.tools.fit_summary import WIDTH, error_text, first_reason, indices_text
from vomstudio.tools.followed_line import FollowedLine
from vomstudio.tools.local_surface import around
from vomstudio.tools.polyline import PolylineTool, points_text, type_of_draft
from vomstudio.tools.tool_context import ToolContext
from vomstudio.tools.tool_entry import ToolEntry
from vomstudio.words import to_translate, tr, tr_n


class TraceTool(PolylineTool[Trace]):
    """Picks three points or more; a plane is fitted to them as they come.

    Where it follows a contact its vertices are way-points, and the trace is the path through them.
    """

    name = "trace"
    record = Trace

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._line = FollowedLine(context.paths, self._leg_came, context.say)
        self._finish_when_found = False

    @property
    def cost(self) -> str | None:
        """What is followed between clicks; None for straight pieces."""
        return self._line.cost

    def follow(self, cost: str | None) -> None:
        """Follow something else between clicks, or nothing. A continued trace is picked point by
        point."""
        if cost == self._line.cost:
            return
        self._line.cost = cost
        if self._feature is not None:
            self._keep(self._feature, self._steps, self.current_vertex)
        else:
            self._context.tool_changed()

    @property
    def followed(self) -> bool:
        """The open trace is a path between its way-points."""
        return self._line.cost is not None and not self._continued and self.open

    @property
    def searching(self) -> bool:
        """A piece of the open trace is still being searched for."""
        return (
            self._feature is not None
            and self.followed
            and self._line.searching(self._feature.model_id, self.vertices)
        )

    @property
    def trace(self) -> Trace | None:
        """The open trace."""
        return self._feature

    def hint(self) -> str:
        """What the next click does, for the status line."""
        if self._feature is None:
            return tr("Trace: click along a bed, fault or fracture on the outcrop.")
        count = len(self.vertices)
        if self.followed:
            return tr_n(
                "Trace: {count} way-point. Click the next one on the contact; drag one to move "
                "it; Ctrl+click inserts one; Enter or double click finishes; Esc cancels.",
                "Trace: {count} way-points. Click the next one on the contact; drag one to move "
                "it; Ctrl+click inserts one; Enter or double click finishes; Esc cancels.",
                count,
            )
        if count < 3:
            return tr_n(
                "Trace: {count} of at least 3 points. Go on clicking; Backspace removes the last "
                "point; Esc cancels.",
                "Trace: {count} of at least 3 points. Go on clicking; Backspace removes the last "
                "point; Esc cancels.",
                count,
            )
        return tr_n(
            "Trace: {count} point. Enter or double click finishes; drag a vertex to move it; "
            "Ctrl+click inserts one; Delete removes the marked one; Esc cancels.",
            "Trace: {count} points. Enter or double click finishes; drag a vertex to move it; "
            "Ctrl+click inserts one; Delete removes the marked one; Esc cancels.",
            count,
        )

    def why_not_finish(self) -> str | None:
        if self._feature is None:
            return tr("No trace is being picked.")
        missing = 3 - len(self.vertices)
        if missing <= 0 or (self.followed and len(self.vertices) > 1):
            return None
        return tr_n(
            "A plane needs at least 3 points: pick {count} more.",
            "A plane needs at least 3 points: pick {count} more.",
            missing,
        )

    def _new(self, model: Model, vertices: tuple[Point, ...]) -> Trace:
        return Trace(
            id=edits.new_id("trace"),
            name="",
            type_id=self._context.next_type_id,
            model_id=model.id,
            model_hash=model.content_hash,
            vertices=vertices,
            set_name=self._context.next_set,
            axis="auto",
        )

    def finish(self) -> str | None:
        """As of all; while a piece is searched for it is finished when that has come."""
        self._finish_when_found = self.searching
        return None if self._finish_when_found else super().finish()

    def _reset(self) -> None:
        self._line.forget()
        self._finish_when_found = False
        super()._reset()

    def _leg_came(self) -> None:
        if self._feature is None:
            return
        self._look()
        self._show()
        self._context.tool_changed()
        if self._finish_when_found and not self.searching:
            self.finish()

    def _whole(self, feature: Trace) -> Trace:
        """With all vertices of the path; itself where it is picked point by point."""
        if not self.followed:
            return feature
        dragged = self._drag_from is not None
        path = self._line.path(feature.model_id, feature.vertices, live=dragged)
        return replace(feature, vertices=tuple(map(tuple, path.tolist())))

    def _edit(self, feature: Trace) -> Edit:
        records = self._context.session.records
        if not self._continued:
            if self.followed:
                said = tr(
                    "Followed by {cost} through {count} way-points.",
                    cost=self._line.cost,
                    count=len(feature.vertices),
                )
                feature = replace(self._whole(feature), notes=said)
            return edits.add_trace(records, feature)
        return edits.set_vertices(
            records,
            feature.id,
            feature.vertices,
            resolution=feature.resolution,
            outcrop_normal=feature.outcrop_normal,
            rule=feature.rule,
        )

    # --- drafts ------------------------------------------------------------------------------
    def _more_state(self, feature: Trace) -> dict[str, Any]:
        state = {"type_id": feature.type_id, "set_name": feature.set_name}
        return {**state, "cost": self._line.cost} if self.followed or self._line.cost else state

    def _read(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> Trace:
        return Trace(
            id=str(state["trace_id"]),
            name="",
            type_id=type_of_draft(self._context, state, self._context.next_type_id),
            model_id=str(state["model_id"]),
            model_hash=str(state["model_hash"]),
            vertices=vertices,
            set_name=str(state["set_name"]),
            axis="auto",
        )

    def restore(self, state: Mapping[str, Any]) -> bool:
        cost = state.get("cost")
        self._line.cost = cost if isinstance(cost, str) else None
        if not super().restore(state):
            return False
        if self._feature is not None:
            self._context.set_next(self._feature.type_id, self._feature.set_name)
        return True

    def set_type(self, type_id: str, set_name: str) -> None:
        """The feature type and set of the open trace."""
        if self._feature is not None and not self._continued:
            if (self._feature.type_id, self._feature.set_name) == (type_id, set_name):
                return
            trace = replace(self._feature, type_id=type_id, set_name=set_name)
            self._keep(trace, self._steps, self.current_vertex)

    # --- what is seen ------------------------------------------------------------------------
    def _look(self) -> None:
        """Ask the surface, and fit."""
        assert self._feature is not None
        surface = self._context.surface(self._feature.model_id)
        whole = self._whole(self._feature)
        if surface is not None and self.vertices:
            resolution, normal = around(surface, whole.vertices)
            self._feature = replace(
                self._feature, resolution=resolution, outcrop_normal=normal, rule=SURROUNDINGS_RULE
            )
            whole = replace(
                whole, resolution=resolution, outcrop_normal=normal, rule=SURROUNDINGS_RULE
            )
        if not self.followed:
            super()._look()
            return
        self.measurement = self._context.measure(whole) if whole.vertices else None

    def _drawn(self) -> tuple[np.ndarray | None, np.ndarray | None]:
        feature, model = self._feature, self._model()
        if feature is None or model is None or not self.followed:
            return None, None
        path = np.asarray(self._whole(feature).vertices, np.float64)
        at, ahead = self._hovered(), None
        if at is not None and feature.vertices and self._drag_from is None:
            ahead = self._line.leg(feature.model_id, feature.vertices[-1], at, live=True)
        to_world = model.to_world
        return transform.apply(to_world, path), (
            None if ahead is None else transform.apply(to_world, ahead)
        )

    def _patch(self) -> np.ndarray | None:
        fit = self.measurement.fit if self.measurement else None
        if fit is None or fit.extent is None:
            return None
        verdict = self.measurement.verdict if self.measurement else None
        if verdict is not None and verdict.quality == "poor":
            # It would cover the trace, and tells nothing.
            return None
        return disc(fit.centroid, fit.normal, 0.5 * fit.extent)

    def _reading(self) -> tuple[str, ...]:
        count, measurement = len(self.vertices), self.measurement
        if self.searching:
            return (points_text(count), tr("Searching for the way"))
        if measurement is None or measurement.fit is None or measurement.verdict is None:
            if count < 3 or measurement is None or not measurement.problem:
                return (points_text(count),)
            return (points_text(count), *wrap(measurement.problem, WIDTH))
        fit = measurement.fit
        return (
            self._context.format_plane(measurement),
            error_text(fit),
            indices_text(fit, f"n {fit.n}"),
            *first_reason(measurement.verdict),
        )


TOOL = ToolEntry(
    TraceTool,
    label=to_translate("&Trace"),
    icon="vector-polyline",
    key="T",
    tip=to_translate("Click along a bed, fault or fracture; its plane is fitted as you click."),
    order=10,
)
