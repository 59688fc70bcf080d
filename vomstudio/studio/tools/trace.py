"""Trace tool, which fits a plane to the intersection of a surface with the outcrop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from textwrap import wrap
from typing import Any

import numpy as np

from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.plane_discs import disc
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import SURROUNDINGS_RULE, Model
from vomstudio.studio.tools.fit_summary import WRAP_WIDTH, first_reason_lines
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.local_surface import measure_surroundings
from vomstudio.studio.tools.polyline import draft_type_id, points_text
from vomstudio.studio.tools.tool_entry import ToolEntry


class TraceTool(FollowingTool[Trace]):
    """Tool for traces of three or more points, to which a plane is fitted live.

    If the tool follows a contact, its vertices are way-points, and the trace is the path through
    them.
    """

    name = "trace"
    record = Trace
    _stretches: tuple[tuple[int, int], ...] = ()
    """First and last vertices of stretches of the open path that may follow another contact."""

    @property
    def trace(self) -> Trace | None:
        """Open trace, or None if no trace is open."""
        return self._feature

    def hint(self) -> str:
        """Describe the effect of the next click for the status line."""
        if self._feature is None:
            return tr("Trace: click along a bed, fault or fracture on the outcrop.")
        count = len(self.vertices)
        if self.is_path:
            return tr_n(
                "Trace: {count} way-point. Click the next one; drag one to move it, Ctrl+click to"
                " insert one; press Enter to finish, Esc to cancel.",
                "Trace: {count} way-points. Click the next one; drag one to move it, Ctrl+click to"
                " insert one; press Enter to finish, Esc to cancel.",
                count,
            )
        if count < 3:
            return tr_n(
                "Trace: {count} of at least 3 points. Continue clicking; press Backspace to remove"
                " the last point, Esc to cancel.",
                "Trace: {count} of at least 3 points. Continue clicking; press Backspace to remove"
                " the last point, Esc to cancel.",
                count,
            )
        return tr_n(
            "Trace: {count} point. Press Enter or double-click to finish, Esc to cancel; drag a"
            " vertex to move it, Ctrl+click to insert one, Delete to remove one.",
            "Trace: {count} points. Press Enter or double-click to finish, Esc to cancel; drag a"
            " vertex to move it, Ctrl+click to insert one, Delete to remove one.",
            count,
        )

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Trace:
        type_id, set_name = self._next_type
        return Trace(
            id=new_id("trace"),
            name="",
            type_id=type_id,
            model_id=model.id,
            model_hash=model.content_hash,
            vertices=vertices,
            set_name=set_name,
            axis="auto",
        )

    def begin_followed_trace(
        self, model: Model, way_points: tuple[Point, ...], cost: str | None, notes: str
    ) -> str | None:
        """Open a new trace that follows a cost through way-points on a model.

        Returns the id of the trace, or None if the trace is not valid. No other trace may be
        open. `notes` describe the origin of the trace.
        """
        self._line.cost = cost
        # Avoids a rubber band to the last position of the cursor.
        self._hover_hit, self._undone_steps = None, []
        self._store_step(replace(self._create_feature(model, way_points), notes=notes), [()], None)
        return None if self._feature is None else self._feature.id

    def _edit(self, feature: Trace) -> Edit:
        records = self._context.session.records
        if not self._has_stored_feature:
            if self.is_path:
                notes = f"{feature.notes} {self._path_note(feature)}".strip()
                feature = replace(self._whole_path(feature), notes=notes, doubtful=self._stretches)
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
    def _extra_state(self, feature: Trace) -> dict[str, Any]:
        state = {"type_id": feature.type_id, "set_name": feature.set_name}
        if feature.notes and not self._has_stored_feature:
            state["notes"] = feature.notes
        return {**state, **self._cost_state()}

    def _feature_from_draft(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> Trace:
        return Trace(
            id=str(state["trace_id"]),
            name="",
            type_id=draft_type_id(self._context, state, self._context.next_type_id),
            model_id=str(state["model_id"]),
            model_hash=str(state["model_hash"]),
            vertices=vertices,
            set_name=str(state["set_name"]),
            notes=str(state.get("notes", "")),
            axis="auto",
        )

    def restore(self, state: Mapping[str, Any]) -> bool:
        if not super().restore(state):
            return False
        if self._feature is not None:
            self._context.set_next_type(self._feature.type_id, self._feature.set_name)
        return True

    def set_type(self, type_id: str, set_name: str) -> None:
        """Set the feature type and set of the open trace if it is new."""
        if self._feature is not None and not self._has_stored_feature:
            if (self._feature.type_id, self._feature.set_name) == (type_id, set_name):
                return
            trace = replace(self._feature, type_id=type_id, set_name=set_name)
            self._store_step(trace, self._steps, self.current_vertex)

    # --- preview ------------------------------------------------------------------------------
    def _measure_live(self) -> None:
        """Query the surface and fit the plane."""
        assert self._feature is not None
        surface = self._context.surface(self._feature.model_id)
        complete_feature = self._whole_path(self._feature)
        self._stretches = ()
        if surface is not None and self.vertices:
            resolution, normal = measure_surroundings(surface, complete_feature.vertices)
            if self.is_path and resolution is not None and self._drag_start is None:
                self._stretches = self._doubtful_ranges(self._feature, resolution)
            self._feature = replace(
                self._feature, resolution=resolution, outcrop_normal=normal, rule=SURROUNDINGS_RULE
            )
            complete_feature = replace(
                complete_feature,
                resolution=resolution,
                outcrop_normal=normal,
                rule=SURROUNDINGS_RULE,
                doubtful=self._stretches,
            )
        if not self.is_path:
            super()._measure_live()
            return
        self.measurement = (
            self._context.measure(complete_feature) if complete_feature.vertices else None
        )

    def _marked_stretches(self, path: np.ndarray | None) -> tuple[np.ndarray, ...]:
        if path is None:
            return ()
        return tuple(path[a : b + 1] for a, b in self._stretches)

    def _surrounding_patch(self) -> np.ndarray | None:
        fit = self.measurement.fit if self.measurement else None
        if fit is None or fit.extent is None:
            return None
        verdict = self.measurement.verdict if self.measurement else None
        if verdict is not None and verdict.quality == "poor":
            # The rubber band would cover the trace without adding information.
            return None
        return disc(fit.centroid, fit.normal, 0.5 * fit.extent)

    def _reading_lines(self) -> tuple[str, ...]:
        count, measurement = len(self.vertices), self.measurement
        if self.is_searching:
            return self._search_lines()
        if measurement is None or measurement.fit is None or measurement.verdict is None:
            if count < 3 or measurement is None or not measurement.problem:
                return (points_text(count),)
            return (points_text(count), *wrap(str(measurement.problem), WRAP_WIDTH))
        return (
            self._context.format_attitude(measurement),
            *first_reason_lines(measurement.verdict),
        )


TOOL = ToolEntry(
    TraceTool,
    label=to_translate("&Trace"),
    icon="vector-polyline",
    key="T",
    tip=to_translate("Click along a bed, fault or fracture to fit its plane."),
    order=10,
)
