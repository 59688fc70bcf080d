"""Tool for rock areas, which outlines a part of the outcrop with a single lithology."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geology.beds.lithologies import lithology_color
from vomstudio.geometry.matrices import Point
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.lithology import KIND, Lithology, words
from vomstudio.project.records import Model
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.polyline import points_text
from vomstudio.studio.tools.tool_entry import ToolEntry

MAX_SYNCHRONOUS_FACES = 30_000
"""Maximum number of faces for which the area inside an outline is computed immediately, within a
few hundredths of a second."""
_Outline = tuple[str, tuple[Point, ...]]
"""Id of the model, and the vertices of the outline."""


class LithologyTool(FollowingTool[Lithology]):
    """Tool for outlines of three or more points.

    On a large model, the area inside an outline is computed in the background, one outline at a
    time.
    """

    name = "lithology"
    noun = "rock area"
    record = Lithology

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_lithology = ""
        self._cached_area: tuple[_Outline, float | None] | None = None
        self._next_outline: _Outline | None = None
        self._pending_outline: _Outline | None = None

    @property
    def is_searching(self) -> bool:
        """Whether a leg of the path or the area is pending."""
        return super().is_searching or self._next_outline is not None

    def _reset(self) -> None:
        self._next_outline = None
        super()._reset()

    @property
    def lithology(self) -> str:
        """Lithology of the open area, or else of the next area."""
        return self._feature.lithology if self._feature else self.next_lithology

    def hint(self) -> str:
        if self._feature is None:
            return tr("Rock area: click around an area of a single rock type.")
        return tr_n(
            "Rock area: {count} corner. Press Enter or double-click to finish, Esc to cancel; drag"
            " a vertex to move it, Ctrl+click to insert one.",
            "Rock area: {count} corners. Press Enter or double-click to finish, Esc to cancel;"
            " drag a vertex to move it, Ctrl+click to insert one.",
            len(self.vertices),
        )

    def choose(self, lithology: str) -> None:
        """Set the lithology of the next area, and of the open area if it is new."""
        self.next_lithology = lithology
        feature = self._feature
        if feature is None or self._has_stored_feature or feature.lithology == lithology:
            self._context.tool_changed()
            return
        changed_feature = replace(feature, lithology=lithology)
        self._store_step(changed_feature, self._steps, self.current_vertex)

    @property
    def _is_closed(self) -> bool:
        return len(self.vertices) > 2 or (self.is_path and len(self.vertices) > 1)

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Lithology:
        return Lithology(
            new_id("lithology"),
            "",
            model.id,
            model.content_hash,
            vertices,
            self.next_lithology,
        )

    def _measure_live(self) -> None:
        """Measure the outline, and request its area unless a corner is being dragged."""
        assert self._feature is not None
        complete_feature = self._whole_path(self._feature)
        area, self._next_outline = None, None
        if self._drag_start is None and not super().is_searching:
            area = self._measured_area((complete_feature.model_id, complete_feature.vertices))
        self._feature = replace(self._feature, area=area)
        complete_feature = replace(complete_feature, area=area)
        self.measurement = (
            self._context.measure(complete_feature) if complete_feature.vertices else None
        )

    def _measured_area(self, outline: _Outline) -> float | None:
        """Return the area inside an outline, or request it and return None if it is unknown."""
        if self._cached_area is None or self._cached_area[0] != outline:
            if len(outline[1]) < 3 or self._context.surface(outline[0]) is None:
                return None
            self._next_outline = outline
            self._measure_next_area()
        cached_area = self._cached_area
        return cached_area[1] if cached_area is not None and cached_area[0] == outline else None

    def _measure_next_area(self) -> None:
        outline = self._next_outline
        if outline is None or self._pending_outline is not None:
            return
        surface = self._context.surface(outline[0])
        if surface is None:
            self._store_area(outline, None)
            return
        self._pending_outline = outline
        ring = np.array(outline[1], np.float64)
        if surface.count <= MAX_SYNCHRONOUS_FACES:
            self._pending_outline, self._next_outline = None, None
            self._cached_area = outline, surface.area_inside(ring)
            return
        self._context.run_in_background(
            lambda: surface.area_inside(ring), partial(self._store_area, outline)
        )

    def _store_area(self, outline: _Outline, area: float | None) -> None:
        self._pending_outline = None
        self._cached_area = outline, area
        if self._next_outline == outline:
            self._next_outline = None
            self._handle_new_leg()
        else:
            self._measure_next_area()

    def _edit(self, feature: Lithology) -> Edit:
        self._check_dimension("outline_m2", Finding("tool.no-area"))
        records = self._context.session.records
        if self._has_stored_feature:
            return edits.change_feature(records, feature)
        if self.is_path:
            feature = replace(self._whole_path(feature), notes=self._path_note(feature))
        return edits.add_features(records, [feature])

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: Lithology) -> dict[str, Any]:
        return {"lithology": feature.lithology, **self._cost_state()}

    def _feature_from_draft(
        self, state: Mapping[str, Any], vertices: tuple[Point, ...]
    ) -> Lithology:
        self.next_lithology = str(state["lithology"])
        return Lithology(
            str(state["lithology_id"]),
            "",
            str(state["model_id"]),
            str(state["model_hash"]),
            vertices,
            self.next_lithology,
        )

    # --- preview ------------------------------------------------------------------------------
    def _color(self) -> str:
        return lithology_color(self.lithology) or KIND.color

    def _reading_lines(self) -> tuple[str, ...]:
        count, measurement = len(self.vertices), self.measurement
        name = (self.lithology,) if self.lithology else ()
        if super().is_searching:
            return (*name, *self._search_lines())
        if measurement is None or not measurement.dimension:
            return (*name, points_text(count))
        return (*name, points_text(count), *words(measurement)[:1])


TOOL = ToolEntry(
    LithologyTool,
    label=to_translate("&Rock area"),
    icon="layers",
    key="Shift+R",
    tip=to_translate("Outline an area of a single rock type, measured on the surface."),
    order=28,
)
