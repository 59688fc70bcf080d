"""Tool for measuring distances, polylines, areas and thicknesses across a plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.plane_discs import disc
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.dimension import KIND, Dimension, DimensionKind
from vomstudio.project.kinds.dimension import KINDS as DIMENSION_KINDS
from vomstudio.project.length_figures import words
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model
from vomstudio.studio.tools.polyline import PolylineTool, get_plane, points_text
from vomstudio.studio.tools.tool_entry import ToolEntry

KINDS: tuple[DimensionKind, ...] = tuple(kind for kind, _ in DIMENSION_KINDS)
TWO_POINT_KINDS = ("distance", "thickness")
MIN_POINTS = {"distance": 2, "polyline": 2, "area": 3, "thickness": 2}

_HINTS = {
    "distance": to_translate("Measure: click both ends of the distance."),
    "polyline": to_translate("Measure: click along the line to measure its length."),
    "area": to_translate("Measure: click the corners of the area in order."),
    "thickness": to_translate("Measure: click one point on the base and one on the top."),
}


class MeasureTool(PolylineTool[Dimension]):
    """Tool for measurements; a distance or thickness ends with the second point."""

    name = "measure"
    noun = "measurement"
    record = Dimension

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_kind: DimensionKind = "distance"
        self.next_plane_id = ""

    @property
    def kind(self) -> DimensionKind:
        """Kind of the open measurement, or else of the next one."""
        return self._feature.kind if self._feature else self.next_kind

    @property
    def plane_id(self) -> str:
        """Id of the plane across which a thickness is measured, or "" for no plane."""
        return self._feature.plane_id if self._feature else self.next_plane_id

    def hint(self) -> str:
        if (reason := self._missing_plane_finding()) is not None:
            return reason.message
        if self._feature is None:
            return tr(_HINTS[self.kind])
        if self.kind in TWO_POINT_KINDS:
            return tr(
                "Measure: click the other end. Press Backspace to remove the first one, Esc to"
                " cancel."
            )
        return tr_n(
            "Measure: {count} point. Press Enter or double-click to finish, Esc to cancel; drag a"
            " vertex to move it, Ctrl+click to insert one.",
            "Measure: {count} points. Press Enter or double-click to finish, Esc to cancel; drag a"
            " vertex to move it, Ctrl+click to insert one.",
            len(self.vertices),
        )

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        missing_count = MIN_POINTS[self.kind] - len(self.vertices)
        if missing_count > 0:
            return Finding(
                "feature.too-few-points", count=missing_count, minimum=MIN_POINTS[self.kind]
            )
        return self._missing_plane_finding()

    def _missing_plane_finding(self) -> Finding | None:
        if self.kind == "thickness" and get_plane(self._context, self.plane_id) is None:
            return Finding("thickness.no-plane")
        return None

    def choose(self, kind: DimensionKind | None = None, plane_id: str | None = None) -> None:
        """Set the kind or plane of the next measurement, and of the open one if it is new."""
        self.next_kind = self.next_kind if kind is None else kind
        self.next_plane_id = self.next_plane_id if plane_id is None else plane_id
        open_feature = self._feature
        if open_feature is None:
            self._context.tool_changed()
            return
        new_kind = open_feature.kind if kind is None else kind
        new_plane_id = self.next_plane_id if new_kind == "thickness" else ""
        changed_measure = replace(open_feature, kind=new_kind, plane_id=new_plane_id)
        if self._has_stored_feature:
            return
        steps, points = self._steps, self.vertices
        if changed_measure.kind in TWO_POINT_KINDS and len(points) > 2:
            changed_measure = replace(changed_measure, vertices=(points[0], points[-1]))
            steps = [*steps, points]
        if changed_measure != open_feature:
            self._store_step(changed_measure, steps, None)

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Dimension:
        return Dimension(
            id=new_id("dimension"),
            name="",
            kind=self.next_kind,
            model_id=model.id,
            model_hash=model.content_hash,
            vertices=vertices,
            plane_id=self.next_plane_id if self.next_kind == "thickness" else "",
        )

    def _append(self, position: Point) -> None:
        if self.kind not in TWO_POINT_KINDS:
            super()._append(position)
            return
        self._set_vertices((*self.vertices[:1], position))
        if (
            len(self.vertices) == 2
            and not self._has_stored_feature
            and self.finish_problem() is None
        ):
            self.finish()

    def insert_vertex(self, position: Point) -> None:
        """Insert a vertex, except between the ends of a distance or thickness."""
        if self.kind not in TWO_POINT_KINDS:
            super().insert_vertex(position)

    def _edit(self, feature: Dimension) -> Edit:
        if (reason := self.finish_problem()) is not None:
            raise GeometryError(reason)
        measurement = self.measurement
        if measurement is None or measurement.problem:
            problem = None if measurement is None else measurement.problem
            raise GeometryError(problem or Finding("tool.no-points"))
        if max((measurement.dimension or {}).values(), default=0.0) <= 0.0:
            raise GeometryError(Finding("points.coincident"))
        records = self._context.session.records
        if not self._has_stored_feature:
            return edits.add_features(records, [feature])
        return edits.set_line(records, feature.id, feature.vertices, resolution=feature.resolution)

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: Dimension) -> dict[str, Any]:
        return {"kind": feature.kind, "plane_id": feature.plane_id}

    def clear_state(self) -> None:
        """Reset for another project, because the plane belongs to this project."""
        super().clear_state()
        self.next_plane_id = ""

    def _feature_from_draft(
        self, state: Mapping[str, Any], vertices: tuple[Point, ...]
    ) -> Dimension:
        dimension_kind = state["kind"]
        if dimension_kind not in KINDS:
            raise ValueError(dimension_kind)
        self.next_kind, self.next_plane_id = dimension_kind, str(state["plane_id"])
        return Dimension(
            id=str(state["measure_id"]),
            name="",
            kind=dimension_kind,
            model_id=str(state["model_id"]),
            model_hash=str(state["model_hash"]),
            vertices=vertices,
            plane_id=str(state["plane_id"]),
        )

    # --- preview ------------------------------------------------------------------------------
    def _measure_live(self) -> None:
        assert self._feature is not None
        surface = self._context.surface(self._feature.model_id)
        if surface is not None and self.vertices:
            resolution = surface.local_resolution(np.asarray(self.vertices, dtype=np.float64))
            self._feature = replace(self._feature, resolution=resolution)
        super()._measure_live()

    def _color(self) -> str:
        return KIND.color

    @property
    def _is_closed(self) -> bool:
        return self.kind == "area" and len(self.vertices) > 2

    def _surrounding_patch(self) -> FloatArray | None:
        """Return a disc in the plane of a thickness, around its base point, or None."""
        plane = get_plane(self._context, self.plane_id) if self.kind == "thickness" else None
        measurement = self._measured_dimension()
        if (
            plane is None
            or plane.plane is None
            or measurement is None
            or len(measurement.points) < 2
        ):
            return None
        max_distance = float(np.linalg.norm(measurement.points[-1] - measurement.points[0]))
        return disc(measurement.points[0], plane.plane.normal(), max(max_distance, 1e-9))

    def _measured_dimension(self) -> Measurement | None:
        """Return the measurement including the point under the cursor, or None."""
        position, points = self._hovered_point(), self.vertices
        is_complete = self.kind in TWO_POINT_KINDS and len(points) > 1
        if (
            self._feature is None
            or is_complete
            or position is None
            or (points and position == points[-1])
        ):
            return self.measurement
        return self._context.measure(replace(self._feature, vertices=(*points, position)))

    def _reading_lines(self) -> tuple[str, ...]:
        measurement = self._measured_dimension()
        if measurement is None or not measurement.dimension:
            return (points_text(len(self.vertices)),)
        return tuple(words(measurement))


TOOL = ToolEntry(
    MeasureTool,
    label=to_translate("&Measure"),
    icon="ruler",
    key="M",
    tip=to_translate("Measure a distance, length, area, or thickness across a plane."),
    order=40,
)
