"""The trace tool: clicks along a line where a surface meets the outcrop become a plane.

A state machine without Qt or VTK. It is idle until the first click or until an old trace is
continued; then exactly one of `finish` or `cancel` ends it. Every step is written to the journal as
a draft before it is shown.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from textwrap import wrap
from typing import Any

import numpy as np

from vomstudio.document import edits
from vomstudio.document.measurements import Measurement, world_points
from vomstudio.document.records import FeatureType, Model, Point, Trace
from vomstudio.errors import DocumentError, VomError
from vomstudio.geometry import transform
from vomstudio.geometry.discs import disc
from vomstudio.tools.context import ToolContext
from vomstudio.tools.types import Button, Hit, Pointer, PointerEvent, Preview

NAME = "trace"


class TraceTool:
    """The unfinished trace is an ordinary Trace record that is not in the document yet."""

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._trace: Trace | None = None
        self._continued = False
        self._steps: list[tuple[Point, ...]] = []
        self._hover: Hit | None = None
        self._drag_from: tuple[Point, ...] | None = None
        self.current_vertex: int | None = None
        self.measurement: Measurement | None = None

    # --- state -------------------------------------------------------------------------------
    @property
    def open(self) -> bool:
        """A trace is being picked."""
        return self._trace is not None

    @property
    def trace(self) -> Trace | None:
        return self._trace

    @property
    def continued(self) -> bool:
        """The open trace is one of the document's, taken up again."""
        return self._continued

    @property
    def vertices(self) -> tuple[Point, ...]:
        """Model file frame."""
        return self._trace.vertices if self._trace else ()

    @property
    def can_undo(self) -> bool:
        return bool(self._steps)

    def hint(self) -> str:
        """What the next click does, for the status line."""
        if self._trace is None:
            return "Trace: click along a bed, fault or fracture on the outcrop"
        count = len(self.vertices)
        if count < 3:
            return (
                f"Trace: {count} point{'s' if count > 1 else ''}; a plane needs 3. "
                "Click on; Backspace takes the last click back; Esc cancels"
            )
        return (
            f"Trace: {count} points. Enter or double click finishes; drag a vertex to move it; "
            "Ctrl+click inserts one; Delete removes the marked one; Esc cancels"
        )

    def why_not_finish(self) -> str | None:
        if self._trace is None:
            return "no trace is being picked"
        missing = 3 - len(self.vertices)
        return None if missing <= 0 else f"a plane needs 3 points; pick {missing} more"

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        if event.kind is Pointer.MOVE:
            self._move(event)
        elif event.kind is Pointer.CLICK and event.button is Button.LEFT:
            self._click(event)
        elif event.kind is Pointer.DOUBLE_CLICK and event.button is Button.LEFT:
            if self.open:
                self.finish()
        elif event.kind is Pointer.DRAG_START and event.handle is not None:
            self._drag_from = self.vertices
            self.current_vertex = event.handle
        elif event.kind is Pointer.DRAG_MOVE and self._drag_from is not None:
            self._drag(event.hit)
        elif event.kind is Pointer.DRAG_END and self._drag_from is not None:
            self._drag(event.hit)
            self._end_drag()

    def _move(self, event: PointerEvent) -> None:
        self._hover = event.hit
        if self.open:
            self._show()

    def _click(self, event: PointerEvent) -> None:
        if event.handle is not None and self.open:
            self.mark(None if self.current_vertex == event.handle else event.handle)
            return
        hit = event.hit
        if hit is None:
            self._context.hint("There is no surface under the cursor: click on the outcrop.")
            return
        if self._trace is None:
            self._begin(hit)
            return
        if hit.model_id != self._trace.model_id:
            self._context.hint(
                "This point lies on another model. A trace belongs to one model: finish it "
                "(Enter) or cancel it (Esc) first."
            )
            return
        if event.ctrl and len(self.vertices) > 1:
            self.insert_vertex(hit.position)
        else:
            self._set_vertices((*self.vertices, hit.position))

    def _begin(self, hit: Hit) -> None:
        model = self._context.session.records.get(hit.model_id)
        if not isinstance(model, Model):
            self._context.say("This model is not part of the project any more.")
            return
        trace = Trace(
            id=edits.new_id("trace"),
            name="",
            type_id=self._context.next_type_id,
            model_id=model.id,
            model_hash=model.content_hash,
            vertices=(hit.position,),
            set_name=self._context.next_set,
        )
        self._keep(trace, [()], None)

    def _drag(self, hit: Hit | None) -> None:
        index = self.current_vertex
        if self._trace is None or index is None or hit is None:
            return
        if hit.model_id != self._trace.model_id:
            return
        moved = list(self.vertices)
        moved[index] = hit.position
        self._trace = replace(self._trace, vertices=tuple(moved))
        self._look()
        self._show()

    def _end_drag(self) -> None:
        assert self._drag_from is not None
        assert self._trace is not None
        before, after, self._drag_from = self._drag_from, self.vertices, None
        if before != after:
            self._trace = replace(self._trace, vertices=before)
            self._set_vertices(after, self.current_vertex)

    def mark(self, index: int | None) -> None:
        """The vertex that Delete removes."""
        if index != self.current_vertex:
            self.current_vertex = index
            self._show()
            self._context.tool_changed()

    # --- steps -------------------------------------------------------------------------------
    def insert_vertex(self, position: Point) -> None:
        """Between the two neighbours whose segment passes nearest to `position`."""
        line = np.asarray(self.vertices)
        start, step = line[:-1], np.diff(line, axis=0)
        length = np.maximum((step**2).sum(axis=1), 1e-300)
        along = np.clip(((np.asarray(position) - start) * step).sum(axis=1) / length, 0.0, 1.0)
        gap = np.linalg.norm(start + along[:, None] * step - np.asarray(position), axis=1)
        at = int(gap.argmin()) + 1
        self._set_vertices((*self.vertices[:at], position, *self.vertices[at:]), at)

    def move_vertex(self, index: int, position: Point) -> None:
        changed = list(self.vertices)
        changed[index] = position
        self._set_vertices(tuple(changed), index)

    def delete_vertex(self, index: int | None = None) -> None:
        """Without an index: the marked vertex."""
        index = self.current_vertex if index is None else index
        if self._trace is None or index is None or not 0 <= index < len(self.vertices):
            return
        left = (*self.vertices[:index], *self.vertices[index + 1 :])
        if left or self._continued:
            self._set_vertices(left)
        else:
            self.cancel()

    def undo(self) -> bool:
        """Take the last step of the open trace back; False where there is none."""
        if self._trace is None or not self._steps:
            return False
        before = self._steps[-1]
        if not before and not self._continued:
            self.cancel()
        else:
            self._keep(replace(self._trace, vertices=before), self._steps[:-1], None)
        return True

    def _set_vertices(self, vertices: tuple[Point, ...], mark: int | None = None) -> None:
        assert self._trace is not None
        trace = replace(self._trace, vertices=vertices)
        self._keep(trace, [*self._steps, self.vertices], mark)

    def _keep(self, trace: Trace, steps: list[tuple[Point, ...]], mark: int | None) -> None:
        """Write the draft, then take it over and show it. What cannot be written is not done."""
        try:
            self._context.session.set_draft(self._state(trace))
        except VomError as error:
            self._context.say(str(error))
        else:
            self._trace, self._steps, self.current_vertex = trace, steps, mark
        if self._trace is not None:
            self._look()
            self._show()
        self._context.tool_changed()

    # --- beginning and end -------------------------------------------------------------------
    def continue_trace(self, trace_id: str) -> None:
        """Take up a trace of the document again."""
        if self.open:
            raise DocumentError("a trace is being picked: finish or cancel it first")
        trace = self._context.session.records.get(trace_id)
        if not isinstance(trace, Trace):
            raise DocumentError("only a trace can be continued")
        self._continued = True
        # No line to where the cursor was last over the outcrop.
        self._hover = None
        self._keep(trace, [], None)
        self._continued = self._trace is not None

    def finish(self) -> str | None:
        """The finished trace's id; None, with the reason said, where it cannot be one yet."""
        if self._trace is None:
            return None
        # A restored trace may be older than its model's surface.
        self._look()
        trace, session = self._trace, self._context.session
        try:
            if self._continued:
                edit = edits.set_vertices(
                    session.records,
                    trace.id,
                    trace.vertices,
                    resolution=trace.resolution,
                    outcrop_normal=trace.outcrop_normal,
                )
            else:
                edit = edits.add_trace(session.records, trace)
            session.apply(edit, finishes_draft=True)
        except VomError as error:
            self._context.say(str(error))
            return None
        self._reset()
        self._context.created(trace.id)
        return trace.id

    def cancel(self) -> None:
        """Give the open trace up; a continued one stays as it was. While the journal cannot be
        written the trace stays open, since the next start would offer it back."""
        if self._trace is None:
            return
        try:
            self._context.session.set_draft(None)
        except VomError as error:
            self._context.say(str(error))
            return
        self._reset()

    def forget(self) -> None:
        """Leave the open trace to its draft: the project is being closed."""
        if self._trace is not None:
            self._reset()

    def _reset(self) -> None:
        self._trace, self._continued, self._steps = None, False, []
        self._drag_from, self.current_vertex, self.measurement = None, None, None
        # The cursor may be anywhere when the next trace is taken up.
        self._hover = None
        self._context.show(None)
        self._context.tool_changed()

    # --- drafts ------------------------------------------------------------------------------
    def _state(self, trace: Trace) -> dict[str, Any]:
        return {
            "tool": NAME,
            "trace_id": trace.id,
            "continued": self._continued,
            "model_id": trace.model_id,
            "model_hash": trace.model_hash,
            "type_id": trace.type_id,
            "set_name": trace.set_name,
            "vertices": [list(v) for v in trace.vertices],
        }

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Go on with a draft; False where it is not one of this tool or its model is gone."""
        records = self._context.session.records
        try:
            if state["tool"] != NAME or not isinstance(records.get(state["model_id"]), Model):
                return False
            vertices = tuple((float(x), float(y), float(z)) for x, y, z in state["vertices"])
            old, type_id = records.get(state["trace_id"]), str(state["type_id"])
            if not isinstance(records.get(type_id), FeatureType):
                type_id = self._context.next_type_id
            continued = bool(state["continued"]) and isinstance(old, Trace)
            trace = Trace(
                id=str(state["trace_id"]),
                name="",
                type_id=type_id,
                model_id=str(state["model_id"]),
                model_hash=str(state["model_hash"]),
                vertices=vertices,
                set_name=str(state["set_name"]),
            )
        except (KeyError, TypeError, ValueError):
            return False
        if not np.isfinite(np.asarray(vertices)).all() or not (vertices or continued):
            return False
        if continued and isinstance(old, Trace):
            trace = replace(old, vertices=vertices)
        self._trace, self._continued, self.current_vertex = trace, continued, None
        self._steps = [vertices[:count] for count in range(len(vertices))]
        if self._continued:
            self._steps = []
        self._look()
        self._show()
        self._context.tool_changed()
        return True

    def set_type(self, type_id: str, set_name: str) -> None:
        """The feature type and set of the open trace."""
        if self._trace is not None and not self._continued:
            if (self._trace.type_id, self._trace.set_name) == (type_id, set_name):
                return
            trace = replace(self._trace, type_id=type_id, set_name=set_name)
            self._keep(trace, self._steps, self.current_vertex)

    # --- what is seen ------------------------------------------------------------------------
    def _look(self) -> None:
        """Ask the surface, and fit."""
        assert self._trace is not None
        surface = self._context.surface(self._trace.model_id)
        resolution, normal = self._trace.resolution, self._trace.outcrop_normal
        if surface is not None and self.vertices:
            points = np.asarray(self.vertices, dtype=np.float64)
            resolution = surface.resolution_near(points)
            found = surface.outcrop_normal(points) if len(points) > 1 else None
            normal = None if found is None else (float(found[0]), float(found[1]), float(found[2]))
        self._trace = replace(self._trace, resolution=resolution, outcrop_normal=normal)
        self.measurement = self._context.measure(self._trace) if self.vertices else None

    def _show(self) -> None:
        if self._trace is None:
            self._context.show(None)
            return
        records = self._context.session.records
        model, kind = records.get(self._trace.model_id), records.get(self._trace.type_id)
        model = model if isinstance(model, Model) else None
        rubber = None
        if self._hover is not None and model is not None and self._hover.model_id == model.id:
            rubber = transform.apply(model.to_world, [self._hover.position])[0]
        self._context.show(
            Preview(
                line=world_points(self._trace, model),
                rubber=rubber,
                patch=self._patch(),
                marked=self.current_vertex,
                color=_rgb(kind.color if isinstance(kind, FeatureType) else "#e69f00"),
                reading=self._reading(),
                verdict=m.verdict.quality if (m := self.measurement) and m.verdict else None,
            )
        )

    def _patch(self) -> np.ndarray | None:
        fit = self.measurement.fit if self.measurement else None
        if fit is None or fit.extent is None:
            return None
        return disc(fit.centroid, fit.normal, 0.5 * fit.extent)

    def _reading(self) -> tuple[str, ...]:
        count, measurement = len(self.vertices), self.measurement
        if measurement is None or measurement.fit is None or measurement.verdict is None:
            why = "" if count < 3 or measurement is None else f": {measurement.problem}"
            return (f"{count} point{'s' if count != 1 else ''}{why}",)
        fit = measurement.fit
        if fit.max_confidence95_deg is None:
            error = "95 %: undefined"
        else:
            error = f"95 %: {fit.max_confidence95_deg:.1f}° × {fit.min_confidence95_deg or 0:.1f}°"
        indices = "   ".join(
            f"{name} {value:.1f}"
            for name, value in (("M", fit.M), ("K", fit.K))
            if value is not None
        )
        return (
            self._context.format_plane(measurement),
            error,
            f"{indices}   n {count}" if indices else f"n {count}",
            *(line for why in measurement.verdict.reasons[:1] for line in wrap(why, 44)),
        )


def _rgb(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue
