"""Base class of tools that pick vertices: a state machine without Qt or VTK.

A tool is idle until the first click or until a feature is continued. Then either `finish` or
`cancel` ends it. Every step is written to the journal as a draft before it is shown.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import DocumentError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr_n
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import Point
from vomstudio.project.edit import Edit
from vomstudio.project.kind import may_have_plane
from vomstudio.project.measurement import Measurement, world_points
from vomstudio.project.records import FeatureType, Model, PickedFeature, get_feature
from vomstudio.studio.tools.interaction_types import (
    Button,
    DiscardedFeature,
    Hit,
    Pointer,
    PointerEvent,
    Preview,
)
from vomstudio.studio.tools.open_steps import SteppedFeature
from vomstudio.studio.tools.tool_context import ToolContext

F = TypeVar("F", bound=PickedFeature)

BLANK_COLOR = "#e69f00"


class PolylineTool(SteppedFeature[F]):
    """Tool that picks vertices; the unfinished feature is not part of the document.

    Attributes
    ----------
    noun : str
        Name of the feature in undo labels; if "", `name` is used.
    """

    name: ClassVar[str]
    noun: ClassVar[str] = ""
    can_paint: ClassVar[bool] = False

    # --- to be implemented by subclasses ------------------------------------------------------
    def hint(self) -> str:
        raise NotImplementedError

    def finish_problem(self) -> Finding | None:
        raise NotImplementedError

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> F:
        """Create the feature at the first click."""
        raise NotImplementedError

    def _edit(self, feature: F) -> Edit:
        """Create the edit that stores a feature. Raises VomError if the feature is not valid."""
        raise NotImplementedError

    def _extra_state(self, feature: F) -> dict[str, Any]:
        """Return the entries of a draft other than the vertices."""
        raise NotImplementedError

    def _feature_from_draft(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> F:
        """Restore the feature of a draft. May raise KeyError, TypeError, ValueError."""
        raise NotImplementedError

    def _measure_live(self) -> None:
        """Query the surface and measure the feature."""
        assert self._feature is not None
        self.measurement = self._context.measure(self._feature) if self.vertices else None

    def _reading_lines(self) -> tuple[str, ...]:
        """Return the lines of text beside the cursor."""
        raise NotImplementedError

    def _surrounding_patch(self) -> FloatArray | None:
        return None

    def _drawn_lines(self) -> tuple[FloatArray | None, FloatArray | None]:
        """Return World lines that replace the straight segments and the rubber band, or None."""
        return None, None

    def _marked_stretches(self, path: FloatArray | None) -> tuple[FloatArray, ...]:
        """Return parts of the preview, as World lines (k, 3), that may not be on the feature."""
        return ()

    def _color(self) -> str:
        type_id = getattr(self._feature, "type_id", "")
        feature_type = self._context.session.records.get(type_id)
        return feature_type.color if isinstance(feature_type, FeatureType) else BLANK_COLOR

    @property
    def _is_closed(self) -> bool:
        """Whether the line is drawn as a ring."""
        return False

    def set_type(self, type_id: str, set_name: str) -> None:
        """Do nothing; tools whose features have the next type and set override this method."""

    def leave(self) -> None:
        """Deactivate the tool; the open feature remains, with its draft."""

    def document_changed(self) -> None:
        """Do nothing, because an unfinished feature is not part of the document."""

    def cancel_problem(self) -> Finding | None:
        return None if self.is_open else Finding("tool.nothing-open")

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        """Add, insert, mark or move vertices; a double click finishes the feature."""
        if event.handle is not None and self.vertices:
            handle = event.handle - (1 if self._is_closed else 0)
            event = replace(event, handle=handle % len(self.vertices))
        if event.kind is Pointer.MOVE:
            self._move(event)
        elif event.kind is Pointer.CLICK and event.button is Button.LEFT:
            self._click(event)
        elif event.kind is Pointer.DOUBLE_CLICK and event.button is Button.LEFT:
            if self.is_open:
                self.finish()
        elif event.kind is Pointer.DRAG_START and event.handle is not None:
            self._drag_start = self.vertices
            self.current_vertex = event.handle
        elif event.kind is Pointer.DRAG_MOVE and self._drag_start is not None:
            self._drag(event.hit)
        elif event.kind is Pointer.DRAG_END and self._drag_start is not None:
            self._drag(event.hit)
            self._end_drag()

    def _move(self, event: PointerEvent) -> None:
        self._hover_hit = event.hit
        if self.is_open:
            self._show_preview()

    def _click(self, event: PointerEvent) -> None:
        if event.handle is not None and self.is_open:
            self.mark(None if self.current_vertex == event.handle else event.handle)
            return
        hit = event.hit
        if hit is None:
            self._context.hint(Finding("tool.no-surface"))
            return
        if self._feature is None:
            self._begin_feature(hit)
            return
        if hit.model_id != self._feature.model_id:
            self._context.hint(Finding("tool.other-model"))
            return
        if event.ctrl and len(self.vertices) > 1:
            self.insert_vertex(hit.position)
        else:
            self._append(hit.position)

    def _append(self, position: Point) -> None:
        self._set_vertices((*self.vertices, position))

    def _begin_feature(self, hit: Hit) -> None:
        model = self._context.session.records.get(hit.model_id)
        if not isinstance(model, Model):
            self._context.report(Finding("model.removed"))
            return
        self._undone_steps = []
        self._store_step(self._create_feature(model, (hit.position,)), [()], None)

    def _drag(self, hit: Hit | None) -> None:
        index = self.current_vertex
        if self._feature is None or index is None or hit is None:
            return
        if hit.model_id != self._feature.model_id:
            return
        vertices = list(self.vertices)
        vertices[index] = hit.position
        self._feature = self._feature.replace_fields(vertices=tuple(vertices))
        self._measure_live()
        self._show_preview()

    def _end_drag(self) -> None:
        assert self._drag_start is not None
        assert self._feature is not None
        vertices_before, vertices_after, self._drag_start = self._drag_start, self.vertices, None
        if vertices_before != vertices_after:
            self._feature = self._feature.replace_fields(vertices=vertices_before)
            self._set_vertices(vertices_after, self.current_vertex)

    # --- start and end ------------------------------------------------------------------------
    def continue_feature(self, feature_id: str) -> None:
        """Continue a feature of the document. Raises DocumentError."""
        if self.is_open:
            raise DocumentError(Finding("feature.open"))
        feature = self._context.session.records.get(feature_id)
        if not isinstance(feature, self.record):
            raise DocumentError(Finding("tool.other-kind"))
        self._has_stored_feature = True
        # Avoids a rubber band to the last position of the cursor.
        self._hover_hit, self._undone_steps = None, []
        self._store_step(feature, [], None)
        self._has_stored_feature = self._feature is not None

    def finish(self) -> str | None:
        """Finish the open feature and return its id, or show a message and return None."""
        if self._feature is None:
            return None
        # A restored feature may be older than the surface of its model.
        self._measure_live()
        feature, session = self._feature, self._context.session
        try:
            session.apply(self._edit(feature), finishes_draft=True)
        except VomError as error:
            self._context.report(error)
            return None
        self._reset()
        self._context.report_created(feature.id)
        return feature.id

    def cancel(self) -> None:
        """Discard the open feature, which undo restores; a continued feature is unchanged.

        While the journal cannot be written, the feature remains open, because the next start
        would restore it.
        """
        feature, steps, continued = self._feature, self._steps, self._has_stored_feature
        is_changed = not self._is_unchanged()
        if feature is None or not (self._close() and is_changed):
            return

        def restore_work() -> bool:
            self._has_stored_feature = continued
            self._store_step(feature, steps, None)
            self._has_stored_feature = continued and self.is_open
            return self.is_open

        def is_untouched() -> bool:
            return self.is_open and (self._steps, self.vertices) == (steps, feature.vertices)

        subject = f"Discard the open {self.noun or self.name}"
        self._context.report_discarded(
            DiscardedFeature(self.name, subject, restore_work, is_untouched)
        )

    def _close(self) -> bool:
        try:
            self._context.session.set_draft(None)
        except VomError as error:
            self._context.report(error)
            return False
        self._reset()
        return True

    def clear_state(self) -> None:
        """Reset because the project is being closed; the open feature remains as a draft."""
        self._undone_steps = []
        if self._feature is not None:
            self._reset()

    def _reset(self) -> None:
        self._feature, self._has_stored_feature, self._steps, self._undone_steps = (
            None,
            False,
            [],
            [],
        )
        self._drag_start, self.current_vertex, self.measurement = None, None, None
        # The cursor may be anywhere when the next feature starts.
        self._hover_hit = None
        self._context.show(None)
        self._context.tool_changed()

    # --- drafts ------------------------------------------------------------------------------
    def _draft_state(self, feature: F) -> dict[str, Any]:
        return {
            "tool": self.name,
            f"{self.name}_id": feature.id,
            "continued": self._has_stored_feature,
            "model_id": feature.model_id,
            "model_hash": feature.model_hash,
            "vertices": [list(v) for v in feature.vertices],
            **self._extra_state(feature),
        }

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Restore a draft. Return False if it is not valid or its model or tool does not match."""
        records = self._context.session.records
        try:
            if state["tool"] != self.name or not isinstance(records.get(state["model_id"]), Model):
                return False
            vertices = tuple((float(x), float(y), float(z)) for x, y, z in state["vertices"])
            stored_record: Any = records.get(state[f"{self.name}_id"])
            is_continued = bool(state["continued"]) and isinstance(stored_record, self.record)
            feature = self._feature_from_draft(state, vertices)
        except (KeyError, TypeError, ValueError):
            return False
        if not np.isfinite(np.asarray(vertices)).all() or not (vertices or is_continued):
            return False
        if is_continued:
            feature = replace(stored_record, vertices=vertices)
        self._feature, self._has_stored_feature, self.current_vertex = feature, is_continued, None
        self._steps = [vertices[:count] for count in range(len(vertices))]
        if self._has_stored_feature:
            self._steps = []
        self._measure_live()
        self._show_preview()
        self._context.tool_changed()
        return True

    # --- preview ------------------------------------------------------------------------------
    def _model(self) -> Model | None:
        assert self._feature is not None
        model = self._context.session.records.get(self._feature.model_id)
        return model if isinstance(model, Model) else None

    def _hovered_point(self) -> Point | None:
        """Return the position of the cursor on the model of the open feature, or None."""
        model = self._model()
        if self._hover_hit is None or model is None or self._hover_hit.model_id != model.id:
            return None
        return self._hover_hit.position

    def _show_preview(self) -> None:
        if self._feature is None:
            self._context.show(None)
            return
        model, position = self._model(), self._hovered_point()
        cursor = None if position is None or model is None else (model.to_world, [position])
        rubber = None if cursor is None else transform.apply(*cursor)[0]
        line, marked_current_vertex = world_points(self._feature, model), self.current_vertex
        path, ahead = self._drawn_lines()
        if self._is_closed:
            # Close the ring at the last vertex, where the rubber band starts.
            line = np.vstack([line[-1:], line])
            marked_current_vertex = (
                None if marked_current_vertex is None else marked_current_vertex + 1
            )
        self._context.show(
            Preview(
                line=line,
                rubber=rubber,
                path=path,
                ahead=ahead,
                doubtful=self._marked_stretches(path),
                patch=self._surrounding_patch(),
                marked=marked_current_vertex,
                color=rgb(self._color()),
                reading=self._reading_lines(),
                verdict=self._verdict_code(),
                pending_positions=self._pending_positions(),
            )
        )

    def _pending_positions(self) -> FloatArray | None:
        """Return the World positions (k, 3) of clicks that have not taken effect, or None."""
        return None

    def _verdict_code(self) -> str | None:
        """Return the verdict on the feature so far, or None if it cannot be assessed yet."""
        measurement = self.measurement
        return measurement.verdict.quality if measurement and measurement.verdict else None


def draft_type_id(context: ToolContext, state: Mapping[str, Any], default_type_id: str) -> str:
    """Return the type of a draft, or that of the next feature if the type was removed."""
    type_id = str(state["type_id"])
    return (
        type_id
        if isinstance(context.session.records.get(type_id), FeatureType)
        else default_type_id
    )


def rgb(color: str) -> tuple[float, float, float]:
    """Convert a colour "#rrggbb" to red, green and blue values from 0 to 1."""
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def get_plane(context: ToolContext, plane_id: str) -> Measurement | None:
    """Return the measurement of a plane of the document, or None if it does not exist."""
    feature = get_feature(context.session.records, plane_id)
    if feature is None or not may_have_plane(feature):
        return None
    measurement = context.measure(feature)
    return measurement if measurement.plane is not None else None


def points_text(count: int) -> str:
    """Return a number of points as text."""
    return tr_n("{count} point", "{count} points", count)
