"""Base class of tools whose line may follow a contact from click to click."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import IDENTITY, Point
from vomstudio.project.records import Model, PickedFeature
from vomstudio.studio.tools.followed_line import AUTO, FollowedLine, photo_votes
from vomstudio.studio.tools.interaction_types import Button, Pointer, PointerEvent
from vomstudio.studio.tools.polyline import PolylineTool, points_text
from vomstudio.studio.tools.tool_context import ToolContext

F = TypeVar("F", bound=PickedFeature)
UNDO_LABELS = {
    "click-next": to_translate("Click for the next feature"),
    "finish-next": to_translate("Finish the next feature"),
    "finish": to_translate("Finish"),
}
"""Labels of pending clicks that can be undone."""


class FollowingTool(PolylineTool[F]):
    """Tool with a followed line: vertices are way-points, and the path is the feature."""

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._line = FollowedLine(context.paths, self._handle_new_leg, context.report, self._rank)
        self._is_finish_waiting = False
        # Pending clicks for the next feature; None marks its end.
        self._queued_clicks: list[PointerEvent | None] = []
        # Type and set of pending clicks after the tool was left.
        self._queued_type: tuple[str, str] | None = None
        self._is_handling_queue = False

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        n_missing = 3 - len(self.vertices)
        if n_missing <= 0 or (self.is_path and len(self.vertices) > 1):
            return None
        return Finding("feature.too-few-points", count=n_missing, minimum=3)

    def _check_dimension(self, name: str, problem: Finding) -> None:
        """Raise GeometryError if the feature has no points, or if a dimension is 0."""
        measurement = self.measurement
        if measurement is None or measurement.problem:
            measured_problem = None if measurement is None else measurement.problem
            raise GeometryError(measured_problem or Finding("tool.no-points"))
        if not (measurement.dimension or {}).get(name):
            raise GeometryError(problem)

    @property
    def cost(self) -> str | None:
        """Cost that is followed between clicks, or None for straight legs."""
        return self._line.cost

    def follow(self, cost: str | None) -> None:
        """Set the cost that is followed between clicks, or None for straight legs.

        A continued feature is picked point by point.
        """
        if cost == self._line.cost:
            return
        self._line.cost = cost
        if self._feature is not None:
            self._store_step(self._feature, self._steps, self.current_vertex)
        else:
            self._context.tool_changed()

    @property
    def effective_cost(self) -> str | None:
        """Cost by which the open feature is followed (for AUTO, the best so far), or None."""
        if self._feature is None or not self.is_path:
            return None
        return self._line.current_cost(self._feature.model_id)

    def _rank(
        self, model_id: str, points: FloatArray, way_points: Sequence[Point], cost: str
    ) -> tuple[int, float]:
        """Return the rank of a line (n, 3) in the file frame of a model."""
        from vomstudio.extraction.best_cost import rank_path

        model, surface = (
            self._context.session.records.get(model_id),
            self._context.surface(model_id),
        )
        to_world = model.to_world if isinstance(model, Model) else IDENTITY
        scale = transform.scale_factor(to_world)
        near = None if surface is None else surface.local_resolution(points)
        resolution = None if near is None else scale * near
        face = None if surface is None else surface.outcrop_normal(points)
        if face is not None:
            start, end = transform.apply(to_world, np.stack([np.zeros(3), face]))
            face = (end - start) / np.linalg.norm(end - start)
        doubtful = self._line.doubtful(model_id, way_points, near or 0.0, cost)
        return rank_path(
            transform.apply(to_world, points), lambda _: resolution, lambda _: face, doubtful
        )[0]

    def _doubtful_ranges(self, feature: F, resolution: float) -> tuple[tuple[int, int], ...]:
        """Return the first and last rows of path stretches that may follow another contact.

        `resolution` is that of the model around the feature, in file units.
        """
        return self._line.doubtful(feature.model_id, self._way_points(feature.vertices), resolution)

    @property
    def follows_photos(self) -> bool:
        """Whether a leg that ends in a photo is followed in that photo."""
        return self._line.follows_photos

    def follow_in_photos(self, is_enabled: bool) -> None:
        """Set whether legs that end in a photo are followed in it or over the surface."""
        if is_enabled == self._line.follows_photos:
            return
        self._line.follows_photos = is_enabled
        if self._feature is not None:
            self._store_step(self._feature, self._steps, self.current_vertex)
        else:
            self._context.tool_changed()

    def pointer(self, event: PointerEvent) -> None:
        """Handle a pointer event; a position in a photo is recorded with the photo.

        Clicks that are made while the path of the open feature is pending belong to the next
        feature.
        """
        if self._is_finish_waiting and event.button is Button.LEFT:
            if event.kind is Pointer.DOUBLE_CLICK:
                self.finish()
                return
            if event.kind is Pointer.CLICK and event.hit is not None:
                self._queued_type = None
                self._queued_clicks.append(replace(event, handle=None, ctrl=False))
                self._show_waiting_clicks()
                return
        if event.hit is not None and event.kind is not Pointer.DOUBLE_CLICK:
            self._line.set_photo(event.photo, event.hit.position)
        super().pointer(event)

    @property
    def votes(self) -> str | None:
        """Text that names the photos used to follow the feature and the share that others confirm.

        None if the feature is not followed in a photo.
        """
        if self._feature is None or not self.is_path:
            return None
        legs = self._line.stored_legs(self._feature.model_id, self._way_points(self.vertices))
        return photo_votes([leg for leg in legs if leg.photo])

    @property
    def is_path(self) -> bool:
        """Whether the open feature is a path between its way-points."""
        return self._line.cost is not None and not self._has_stored_feature and self.is_open

    @property
    def is_searching(self) -> bool:
        """Whether a leg of the open feature is pending."""
        return (
            self._feature is not None
            and self.is_path
            and self._line.is_searching(self._feature.model_id, self._way_points(self.vertices))
        )

    def _verdict_code(self) -> str | None:
        """Return the verdict on a complete path, or None while a leg is pending."""
        return None if self.is_searching else super()._verdict_code()

    @property
    def is_finishing(self) -> bool:
        """Whether the open feature will be stored as soon as its path is found."""
        return self._is_finish_waiting

    def leave(self) -> None:
        """Discard the pending clicks of an unfinished feature."""
        dropped_count = 0
        while self._queued_clicks and self._queued_clicks[-1] is not None:
            self._queued_clicks.pop()
            dropped_count += 1
        self._queued_type = (self._context.next_type_id, self._context.next_set)
        if dropped_count:
            self._context.hint(Finding("tool.clicks-dropped", count=dropped_count))
            self._show_waiting_clicks()
        super().leave()

    @property
    def _next_type(self) -> tuple[str, str]:
        """Type and set of the next feature, or those set when its clicks were queued."""
        if self._is_handling_queue and self._queued_type is not None:
            return self._queued_type
        return self._context.next_type_id, self._context.next_set

    def _pending_positions(self) -> FloatArray | None:
        hits = [
            event.hit
            for event in self._queued_clicks
            if event is not None and event.hit is not None
        ]
        return self._context.world_positions(hits) if hits else None

    def finish(self) -> str | None:
        """Finish the feature as soon as its pending legs are available.

        Returns its id, or None if legs are pending or the feature could not be stored.
        """
        if self._queued_clicks and self.is_searching:
            if self._queued_clicks[-1] is not None:
                self._queued_clicks.append(None)
            return None
        self._is_finish_waiting = self.is_searching
        if self._is_finish_waiting:
            self._show_waiting_clicks()
            return None
        return super().finish()

    def _handle_queued_clicks(self) -> None:
        """Handle the clicks made while the path of the previous feature was pending."""
        queued_clicks, self._queued_clicks = self._queued_clicks, []
        if self.is_open:
            # The feature could not be finished and has shown the reason; the clicks do not
            # belong to it.
            return
        self._is_handling_queue = True
        while queued_clicks and not self._is_finish_waiting:
            event, *queued_clicks = queued_clicks
            if event is None:
                self.finish()
            else:
                self.pointer(event)
        self._is_handling_queue = False
        self._queued_clicks = queued_clicks
        if queued_clicks:
            self._show_waiting_clicks()

    def _show_waiting_clicks(self) -> None:
        self._show_preview()
        self._context.tool_changed()

    def _search_lines(self) -> tuple[str, ...]:
        """Return the text beside the cursor while a leg is pending."""
        count = points_text(len(self.vertices))
        if not self._is_finish_waiting:
            return (count, Finding("follow.searching").message)
        waiting_count = sum(event is not None for event in self._queued_clicks)
        if not waiting_count:
            return (count, Finding("follow.finishing").message)
        clicks = Finding("follow.clicks-waiting", count=waiting_count)
        return (count, Finding("follow.finishing").message, clicks.message)

    # --- undo of pending clicks ---------------------------------------------------------------
    @property
    def undo_label(self) -> str | None:
        if self._queued_clicks:
            return tr(
                UNDO_LABELS["finish-next" if self._queued_clicks[-1] is None else "click-next"]
            )
        return tr(UNDO_LABELS["finish"]) if self._is_finish_waiting else super().undo_label

    def undo(self) -> bool:
        """Undo the last step, starting with pending clicks.

        Return False if no step can be undone.
        """
        if self._queued_clicks:
            self._queued_clicks.pop()
        elif self._is_finish_waiting:
            self._is_finish_waiting = False
        else:
            return super().undo()
        self._show_waiting_clicks()
        return True

    def cancel(self) -> None:
        """Discard pending clicks, or else the open feature."""
        if self._queued_clicks:
            self._queued_clicks = []
            self._show_waiting_clicks()
        else:
            super().cancel()

    def clear_state(self) -> None:
        self._queued_clicks = []
        super().clear_state()

    def _hovered_point(self) -> Point | None:
        """Return the position of the cursor, or None while the feature is being finished."""
        return None if self._is_finish_waiting else super()._hovered_point()

    def _reset(self) -> None:
        self._line.clear_state()
        self._is_finish_waiting = False
        super()._reset()

    def _handle_new_leg(self) -> None:
        if self._feature is None:
            return
        self._measure_live()
        self._show_preview()
        self._context.tool_changed()
        if self._is_finish_waiting and not self.is_searching:
            self._is_finish_waiting = False
            super().finish()
            self._handle_queued_clicks()

    def _whole_path(self, feature: F) -> F:
        """Return the feature with all vertices of its path."""
        if not self.is_path:
            return feature
        is_dragged = self._drag_start is not None
        way_points = self._way_points(feature.vertices)
        path = self._line.path(feature.model_id, way_points, is_live=is_dragged)
        vertices = tuple((x, y, z) for x, y, z in path.tolist())
        is_ring = len(way_points) > len(feature.vertices) and len(vertices) > 1
        return feature.replace_fields(vertices=vertices[:-1] if is_ring else vertices)

    def _way_points(self, vertices: Sequence[Point]) -> Sequence[Point]:
        """Return the way-points; a ring is closed by its first way-point."""
        return (*vertices, vertices[0]) if self._is_closed else vertices

    def _path_note(self, feature: F) -> str:
        """Return the notes for a followed feature."""
        cost_name, count = self._line.current_cost(feature.model_id), len(feature.vertices)
        code = "follow.by-best-cost" if self._line.cost == AUTO else "follow.by-cost"
        text = Finding(code, cost=cost_name, points=count).message
        votes = self.votes
        return text if votes is None else f"{text} {votes}"

    # --- drafts ------------------------------------------------------------------------------
    def _cost_state(self) -> dict[str, Any]:
        """Return the entries of a draft about the cost; they are empty if no cost is followed."""
        return {"cost": self._line.cost} if self.is_path or self._line.cost else {}

    def _draft_state(self, feature: F) -> dict[str, Any]:
        state = super()._draft_state(feature)
        photos = [self._line.get_photo(position) for position in feature.vertices]
        return {**state, "photos": photos} if any(photos) else state

    def _restore_photos(self, state: Mapping[str, Any]) -> None:
        """Restore the photos of the way-points of a draft."""
        photos, vertices = state.get("photos"), state.get("vertices")
        if not isinstance(photos, list) or not isinstance(vertices, list):
            return
        for photo, position in zip(photos, vertices, strict=False):
            with suppress(TypeError, ValueError):
                x, y, z = position
                self._line.set_photo(str(photo), (float(x), float(y), float(z)))

    def restore(self, state: Mapping[str, Any]) -> bool:
        if state.get("tool") == self.name:
            cost = state.get("cost")
            self._line.cost = cost if isinstance(cost, str) else None
            self._restore_photos(state)
        return super().restore(state)

    # --- preview ------------------------------------------------------------------------------
    def _drawn_lines(self) -> tuple[FloatArray | None, FloatArray | None]:
        feature, model = self._feature, self._model()
        if feature is None or model is None or not self.is_path:
            return None, None
        outline = self._way_points(self._whole_path(feature).vertices)
        path = np.asarray(outline, np.float64)
        position, next_leg = self._hovered_point(), None
        if position is not None and feature.vertices and self._drag_start is None:
            next_leg = self._line.leg(
                feature.model_id, feature.vertices[-1], position, is_live=True
            )
        to_world = model.to_world
        return transform.apply(to_world, path), (
            None if next_leg is None else transform.apply(to_world, next_leg)
        )
