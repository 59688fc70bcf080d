"""Steps of an unfinished feature, with undo and redo."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.geometry.matrices import Point
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import PickedFeature
from vomstudio.studio.tools.interaction_types import Hit
from vomstudio.studio.tools.tool_context import ToolContext

F = TypeVar("F", bound=PickedFeature)


def step_label(old_vertices: Sequence[Any], new_vertices: Sequence[Any]) -> str:
    """Return the label of the step between two states of the vertices."""
    if len(new_vertices) > len(old_vertices):
        return f"Add point {len(new_vertices)}"
    return "Delete a point" if len(new_vertices) < len(old_vertices) else "Move a point"


class SteppedFeature(Generic[F]):
    """Unfinished feature that grows by vertices, with steps that can be undone and redone."""

    record: ClassVar[type[Any]]

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._feature: F | None = None
        self._has_stored_feature = False
        self._steps: list[tuple[Point, ...]] = []
        self._undone_steps: list[tuple[F, list[tuple[Point, ...]]]] = []
        self._hover_hit: Hit | None = None
        self._drag_start: tuple[Point, ...] | None = None
        self.current_vertex: int | None = None
        self.measurement: Measurement | None = None

    # --- to be implemented by the tool --------------------------------------------------------
    def _measure_live(self) -> None:
        """Query the surface and measure the feature."""
        raise NotImplementedError

    def _show_preview(self) -> None:
        """Draw the open feature, or remove the drawing if no feature is open."""
        raise NotImplementedError

    def _draft_state(self, feature: F) -> dict[str, Any]:
        """Return the draft of a feature."""
        raise NotImplementedError

    def _close(self) -> bool:
        """Close the feature and its draft. Return False if this cannot be written."""
        raise NotImplementedError

    def cancel(self) -> None:
        """Discard the feature."""
        raise NotImplementedError

    # --- state -------------------------------------------------------------------------------
    @property
    def is_open(self) -> bool:
        """Whether a feature is being picked."""
        return self._feature is not None

    @property
    def is_finishing(self) -> bool:
        """Whether the open feature will be stored as soon as background work is complete."""
        return False

    @property
    def feature(self) -> F | None:
        """Open feature, or None if no feature is open."""
        return self._feature

    @property
    def is_continued(self) -> bool:
        """Whether the open feature is a feature of the document that is being continued."""
        return self._has_stored_feature

    @property
    def vertices(self) -> tuple[Point, ...]:
        """Vertices of the open feature, in the file frame of the model."""
        return self._feature.vertices if self._feature else ()

    @property
    def undo_label(self) -> str | None:
        if self._steps:
            return step_label(self._steps[-1], self.vertices)
        return f"Continue {self._feature.name}" if self._feature and self._is_unchanged() else None

    @property
    def redo_label(self) -> str | None:
        if not self._undone_steps:
            return None
        feature, steps = self._undone_steps[-1]
        return step_label(self.vertices, feature.vertices) if steps else f"Continue {feature.name}"

    def _is_unchanged(self) -> bool:
        stored_record = (
            self._context.session.records.get(self._feature.id) if self._feature else None
        )
        return (
            self._has_stored_feature
            and isinstance(stored_record, PickedFeature)
            and stored_record.vertices == self.vertices
        )

    # --- steps -------------------------------------------------------------------------------
    def mark(self, index: int | None) -> None:
        """Mark the vertex that the Delete key removes, or remove the mark if None."""
        if index != self.current_vertex:
            self.current_vertex = index
            self._show_preview()
            self._context.tool_changed()

    def insert_vertex(self, position: Point) -> None:
        """Insert a vertex into the segment nearest to `position` (model file frame)."""
        index = _nearest_segment(np.asarray(self.vertices), np.asarray(position)) + 1
        self._set_vertices((*self.vertices[:index], position, *self.vertices[index:]), index)

    def move_vertex(self, index: int, position: Point) -> None:
        """Move a vertex to `position` (model file frame)."""
        changed_vertices = list(self.vertices)
        changed_vertices[index] = position
        self._set_vertices(tuple(changed_vertices), index)

    def delete_vertex(self, index: int | None = None) -> None:
        """Delete a vertex, by default the marked vertex.

        A new feature is discarded with its last vertex.
        """
        row_index = self.current_vertex if index is None else index
        if self._feature is None or row_index is None or not 0 <= row_index < len(self.vertices):
            return
        remaining = (*self.vertices[:row_index], *self.vertices[row_index + 1 :])
        if remaining or self._has_stored_feature:
            self._set_vertices(remaining)
        else:
            self.cancel()

    def undo(self) -> bool:
        """Undo the last step of the open feature. Return False if no step can be undone."""
        if self._feature is None or self.undo_label is None:
            return False
        undone_steps = [*self._undone_steps, (self._feature, self._steps)]
        vertices = self._steps[-1] if self._steps else ()
        if not self._steps or not (vertices or self._has_stored_feature):
            self._close()
        else:
            self._store_step(
                self._feature.replace_fields(vertices=vertices), self._steps[:-1], None
            )
        self._undone_steps = undone_steps
        self._context.tool_changed()
        return True

    def redo(self) -> bool:
        """Redo the last undone step. Return False if no step can be redone."""
        if not self._undone_steps:
            return False
        *remaining, (feature, steps) = self._undone_steps
        if self._feature is not None:
            # The type of the feature may have been changed in the meantime.
            feature = self._feature.replace_fields(vertices=feature.vertices)
        stored_record = self._context.session.records.get(feature.id)
        self._has_stored_feature = isinstance(stored_record, self.record)
        self._store_step(feature, steps, None)
        self._has_stored_feature = self._has_stored_feature and self.is_open
        if not self.is_open:
            return False
        self._undone_steps = remaining
        self._context.tool_changed()
        return True

    def _set_vertices(self, vertices: tuple[Point, ...], mark: int | None = None) -> None:
        assert self._feature is not None
        feature = self._feature.replace_fields(vertices=vertices)
        self._undone_steps = []
        self._store_step(feature, [*self._steps, self.vertices], mark)

    def _store_step(self, feature: F, steps: list[tuple[Point, ...]], mark: int | None) -> None:
        """Write the draft, then store and show the feature. Change nothing if writing fails."""
        try:
            self._context.session.set_draft(self._draft_state(feature))
        except VomError as error:
            self._context.report(error)
        else:
            self._feature, self._steps, self.current_vertex = feature, steps, mark
        if self._feature is not None:
            self._measure_live()
            self._show_preview()
        self._context.tool_changed()


def _nearest_segment(line: FloatArray, position: FloatArray) -> int:
    """Return the index of the segment of a line (k, 3) nearest to a position (3,)."""
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum((step**2).sum(axis=1), 1e-300)
    segment_fractions = np.clip(((position - start) * step).sum(axis=1) / length, 0.0, 1.0)
    gap = np.linalg.norm(start + segment_fractions[:, None] * step - position, axis=1)
    return int(gap.argmin())
