"""The tool of lithologies: clicks around a part of the outcrop that is one rock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.document import edits
from vomstudio.document.edit import Edit
from vomstudio.document.kinds.lithology import KIND, Lithology, words
from vomstudio.document.records import Model, Point
from vomstudio.errors import GeometryError
from vomstudio.geology.beds.lithologies import color_of_rock
from vomstudio.tools.following import FollowingTool
from vomstudio.tools.polyline import points_text
from vomstudio.tools.tool_entry import ToolEntry
from vomstudio.words import to_translate, tr, tr_n


class LithologyTool(FollowingTool[Lithology]):
    """Picks three points or more; the area of the surface inside comes as they do."""

    name = "lithology"
    record = Lithology

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_lithology = ""

    @property
    def lithology(self) -> str:
        """The rock of the open area, else of the next one."""
        return self._feature.lithology if self._feature else self.next_lithology

    def hint(self) -> str:
        if self._feature is None:
            return tr("Rock area: click around a part of the outcrop that is one rock.")
        return tr_n(
            "Rock area: {count} corner. Enter or double click finishes; drag a vertex to move it; "
            "Ctrl+click inserts one; Esc cancels.",
            "Rock area: {count} corners. Enter or double click finishes; drag a vertex to move it; "
            "Ctrl+click inserts one; Esc cancels.",
            len(self.vertices),
        )

    def why_not_finish(self) -> str | None:
        if self._feature is None:
            return tr("No rock area is being picked.")
        missing = 3 - len(self.vertices)
        if missing <= 0 or (self.followed and len(self.vertices) > 1):
            return None
        return tr_n(
            "An outline needs at least 3 points: pick {count} more.",
            "An outline needs at least 3 points: pick {count} more.",
            missing,
        )

    def choose(self, lithology: str) -> None:
        """The rock of the next area, and of the open one where it is new."""
        self.next_lithology = lithology
        feature = self._feature
        if feature is None or self._continued or feature.lithology == lithology:
            self._context.tool_changed()
            return
        changed = replace(feature, lithology=lithology)
        self._keep(changed, self._steps, self.current_vertex)

    @property
    def _closed(self) -> bool:
        return len(self.vertices) > 2 or (self.followed and len(self.vertices) > 1)

    def _new(self, model: Model, vertices: tuple[Point, ...]) -> Lithology:
        return Lithology(
            edits.new_id("lithology"), "", model.id, model.content_hash, vertices,
            self.next_lithology,
        )  # fmt: skip

    def _look(self) -> None:
        """Ask the surface for the area, and measure; not while a corner is being dragged."""
        assert self._feature is not None
        whole = self._whole(self._feature)
        surface = self._context.surface(self._feature.model_id)
        area = None
        if surface is not None and self._drag_from is None and not self.searching:
            area = surface.area_inside(np.asarray(whole.vertices, np.float64).reshape(-1, 3))
        self._feature = replace(self._feature, area=area)
        whole = replace(whole, area=area)
        self.measurement = self._context.measure(whole) if whole.vertices else None

    def _edit(self, feature: Lithology) -> Edit:
        measured = self.measurement
        if measured is None or measured.problem:
            problem = None if measured is None else measured.problem
            raise GeometryError(problem or tr("No points have been picked."))
        if not (measured.dimension or {}).get("outline_m2"):
            raise GeometryError(tr("The outline has no area. Pick points around the rock."))
        records = self._context.session.records
        if self._continued:
            return edits.change_feature(records, feature)
        if self.followed:
            feature = replace(self._whole(feature), notes=self._followed_words(feature))
        return edits.add_features(records, [feature])

    # --- drafts ------------------------------------------------------------------------------
    def _more_state(self, feature: Lithology) -> dict[str, Any]:
        return {"lithology": feature.lithology, **self._cost_state()}

    def _read(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> Lithology:
        self.next_lithology = str(state["lithology"])
        return Lithology(
            str(state["lithology_id"]), "", str(state["model_id"]), str(state["model_hash"]),
            vertices, self.next_lithology,
        )  # fmt: skip

    # --- what is seen ------------------------------------------------------------------------
    def _color(self) -> str:
        return color_of_rock(self.lithology) or KIND.color

    def _reading(self) -> tuple[str, ...]:
        count, measured = len(self.vertices), self.measurement
        first = (self.lithology,) if self.lithology else ()
        if self.searching:
            return (*first, points_text(count), tr("Searching for the way"))
        if measured is None or not measured.dimension:
            return (*first, points_text(count))
        return (*first, points_text(count), *words(measured)[:1])


TOOL = ToolEntry(
    LithologyTool,
    label=to_translate("&Rock area"),
    icon="layers",
    key="Shift+R",
    tip=to_translate("Click around one rock; the area is measured on the surface of the model."),
    order=28,
    in_bar=False,
)
