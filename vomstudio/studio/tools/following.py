"""Base of the tools whose line may follow a contact from click to click."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import IDENTITY, Point
from vomstudio.project.records import Model, Picked
from vomstudio.studio.tools.followed_line import AUTO, FollowedLine, photo_votes
from vomstudio.studio.tools.interaction_types import Button, Pointer, PointerEvent
from vomstudio.studio.tools.polyline import PolylineTool, points_text
from vomstudio.studio.tools.tool_context import ToolContext

F = TypeVar("F", bound=Picked)


class FollowingTool(PolylineTool[F]):
    """Where it follows something its vertices are way-points, and the feature is the path through
    them."""

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._line = FollowedLine(context.paths, self._leg_came, context.say, self._rank)
        self._finish_when_found = False
        # Clicks for the next feature, None for its end.
        self._later: list[PointerEvent | None] = []

    @property
    def cost(self) -> str | None:
        """What is followed between clicks; None for straight pieces."""
        return self._line.cost

    def follow(self, cost: str | None) -> None:
        """Follow something else between clicks, or nothing. What is continued is picked point
        by point."""
        if cost == self._line.cost:
            return
        self._line.cost = cost
        if self._feature is not None:
            self._keep(self._feature, self._steps, self.current_vertex)
        else:
            self._context.tool_changed()

    @property
    def followed_by(self) -> str | None:
        """The cost by which the open feature is followed: where the best is asked for, the best so
        far; None where it is not followed."""
        if self._feature is None or not self.followed:
            return None
        return self._line.by(self._feature.model_id)

    def _rank(
        self, model_id: str, points: FloatArray, way_points: Sequence[Point], cost: str
    ) -> tuple[int, float]:
        """By which lines (n, 3) in a model's file frame are ordered."""
        from vomstudio.extraction.best_cost import rank_of

        model, surface = (
            self._context.session.records.get(model_id),
            self._context.surface(model_id),
        )
        to_world = model.to_world if isinstance(model, Model) else IDENTITY
        scale = transform.scale_of(to_world)
        near = None if surface is None else surface.resolution_near(points)
        resolution = None if near is None else scale * near
        face = None if surface is None else surface.outcrop_normal(points)
        if face is not None:
            start, end = transform.apply(to_world, np.stack([np.zeros(3), face]))
            face = (end - start) / np.linalg.norm(end - start)
        doubtful = self._line.doubtful(model_id, way_points, near or 0.0, cost)
        return rank_of(
            transform.apply(to_world, points), lambda _: resolution, lambda _: face, doubtful
        )[0]

    def _doubtful(self, feature: F, resolution: float) -> tuple[tuple[int, int], ...]:
        """First and last row of the stretches of a feature's path that may be on another contact.
        resolution : of the model around it, file units"""
        return self._line.doubtful(feature.model_id, self._way(feature.vertices), resolution)

    @property
    def in_photos(self) -> bool:
        """A piece whose end was set in a photo is followed in the pixels of that photo."""
        return self._line.in_photos

    def follow_in_photos(self, wanted: bool) -> None:
        """Whether what is clicked in a photo is followed there, or over the surface."""
        if wanted == self._line.in_photos:
            return
        self._line.in_photos = wanted
        if self._feature is not None:
            self._keep(self._feature, self._steps, self.current_vertex)
        else:
            self._context.tool_changed()

    def pointer(self, event: PointerEvent) -> None:
        """As of all; a place in a photo is one of that photo. What is clicked while the open
        feature waits for its way to be kept belongs to the next one."""
        if self._finish_when_found and event.button is Button.LEFT:
            if event.kind is Pointer.DOUBLE_CLICK:
                self.finish()
                return
            if event.kind is Pointer.CLICK and event.hit is not None:
                self._later.append(replace(event, handle=None, ctrl=False))
                self._show_waiting()
                return
        if event.hit is not None and event.kind is not Pointer.DOUBLE_CLICK:
            self._line.set_in(event.photo, event.hit.position)
        super().pointer(event)

    @property
    def votes(self) -> str | None:
        """In which photos the open feature is followed, and what the other photos say of it, in
        sentences; None where it is followed in none."""
        if self._feature is None or not self.followed:
            return None
        ways = self._line.ways(self._feature.model_id, self._way(self.vertices))
        return photo_votes([way for way in ways if way.photo])

    @property
    def followed(self) -> bool:
        """The open feature is a path between its way-points."""
        return self._line.cost is not None and not self._continued and self.open

    @property
    def searching(self) -> bool:
        """A piece of the open feature is still being searched for."""
        return (
            self._feature is not None
            and self.followed
            and self._line.searching(self._feature.model_id, self._way(self.vertices))
        )

    def _verdict(self) -> str | None:
        """The straight way between way-points is no poor trace: it is not what will be there."""
        return None if self.searching else super()._verdict()

    def finish(self) -> str | None:
        """As of all; while a piece is searched for it is finished when that has come."""
        if self._later and self.searching:
            if self._later[-1] is not None:
                self._later.append(None)
            return None
        self._finish_when_found = self.searching
        if self._finish_when_found:
            self._show_waiting()
            return None
        return super().finish()

    def _go_on(self) -> None:
        """Do what was clicked while the feature before was waiting for its way."""
        later, self._later = self._later, []
        if self.open:
            # It could not be kept, and said why: it is not the one that was clicked.
            return
        while later and not self._finish_when_found:
            event, *later = later
            if event is None:
                self.finish()
            else:
                self.pointer(event)
        self._later = later
        if later:
            self._show_waiting()

    def _show_waiting(self) -> None:
        self._show()
        self._context.tool_changed()

    def _searching_words(self) -> tuple[str, ...]:
        """Beside the cursor while a piece is searched for."""
        count = points_text(len(self.vertices))
        if not self._finish_when_found:
            return (count, tr("Searching for the way"))
        waiting = sum(event is not None for event in self._later)
        if not waiting:
            return (count, tr("Kept as soon as the way is found"))
        return (
            count,
            tr_n(
                "Kept as soon as the way is found; {count} click waits for the next one",
                "Kept as soon as the way is found; {count} clicks wait for the next one",
                waiting,
            ),
        )

    # --- taking back what waits --------------------------------------------------------------
    @property
    def undo_label(self) -> str | None:
        if self._later:
            return "Finish the next one" if self._later[-1] is None else "Click for the next one"
        return "Finish" if self._finish_when_found else super().undo_label

    def undo(self) -> bool:
        """As of all; what waits for the way is taken back first."""
        if self._later:
            self._later.pop()
        elif self._finish_when_found:
            self._finish_when_found = False
        else:
            return super().undo()
        self._show_waiting()
        return True

    def cancel(self) -> None:
        """As of all; what waits for the next feature is let go first."""
        if self._later:
            self._later = []
            self._show_waiting()
        else:
            super().cancel()

    def forget(self) -> None:
        self._later = []
        super().forget()

    def _hovered(self) -> Point | None:
        """As of all; what is being finished does not run on to the cursor."""
        return None if self._finish_when_found else super()._hovered()

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
            self._finish_when_found = False
            super().finish()
            self._go_on()

    def _whole(self, feature: F) -> F:
        """With all vertices of the path; itself where it is picked point by point."""
        if not self.followed:
            return feature
        dragged = self._drag_from is not None
        way = self._way(feature.vertices)
        path = self._line.path(feature.model_id, way, live=dragged)
        found = tuple((x, y, z) for x, y, z in path.tolist())
        closed = len(way) > len(feature.vertices) and len(found) > 1
        return feature.but(vertices=found[:-1] if closed else found)

    def _way(self, vertices: Sequence[Point]) -> Sequence[Point]:
        """The way-points; of a ring with the first one once more."""
        return (*vertices, vertices[0]) if self._closed else vertices

    def _followed_words(self, feature: F) -> str:
        """For the notes of what was followed."""
        by, count = self._line.by(feature.model_id), len(feature.vertices)
        said = tr("Followed by {cost} through {count} way-points.", cost=by, count=count)
        if self._line.cost == AUTO:
            said = tr(
                "Followed by {cost}, of all costs the one that tells its plane best, through "
                "{count} way-points.",
                cost=by,
                count=count,
            )
        votes = self.votes
        return said if votes is None else f"{said} {votes}"

    # --- drafts ------------------------------------------------------------------------------
    def _cost_state(self) -> dict[str, Any]:
        """For the draft; nothing where nothing is followed."""
        return {"cost": self._line.cost} if self.followed or self._line.cost else {}

    def _state(self, feature: F) -> dict[str, Any]:
        state = super()._state(feature)
        photos = [self._line.photo_of(place) for place in feature.vertices]
        return {**state, "photos": photos} if any(photos) else state

    def _take_photos(self, state: Mapping[str, Any]) -> None:
        """In which photos the way-points of a draft were set, as far as it says."""
        photos, vertices = state.get("photos"), state.get("vertices")
        if not isinstance(photos, list) or not isinstance(vertices, list):
            return
        for photo, place in zip(photos, vertices, strict=False):
            with suppress(TypeError, ValueError):
                x, y, z = place
                self._line.set_in(str(photo), (float(x), float(y), float(z)))

    def restore(self, state: Mapping[str, Any]) -> bool:
        if state.get("tool") == self.name:
            cost = state.get("cost")
            self._line.cost = cost if isinstance(cost, str) else None
            self._take_photos(state)
        return super().restore(state)

    # --- what is seen ------------------------------------------------------------------------
    def _drawn(self) -> tuple[FloatArray | None, FloatArray | None]:
        feature, model = self._feature, self._model()
        if feature is None or model is None or not self.followed:
            return None, None
        whole = self._way(self._whole(feature).vertices)
        path = np.asarray(whole, np.float64)
        at, ahead = self._hovered(), None
        if at is not None and feature.vertices and self._drag_from is None:
            ahead = self._line.leg(feature.model_id, feature.vertices[-1], at, live=True)
        to_world = model.to_world
        return transform.apply(to_world, path), (
            None if ahead is None else transform.apply(to_world, ahead)
        )
