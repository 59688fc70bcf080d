"""Tool for known lines, which are picked by two clicks.

A known line is level, vertical or measured. Planes and lines with compass readings are selected
among the features.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vomstudio.core.errors import DocumentError, GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.matrices import Point
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.known_line import CLICKED_KINDS, KIND, KnownKind, KnownLine
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.polyline import PolylineTool, points_text
from vomstudio.studio.tools.tool_entry import ToolEntry

_HINTS = {
    "level": to_translate(
        "Level line: click both ends of a water line, a spirit level or a bed known to be"
        " horizontal."
    ),
    "plumb": to_translate(
        "Plumb line: click both ends of a hanging string or rope, or of a vertical edge."
    ),
    "azimuth": to_translate("Known azimuth: click both ends, in the direction of the azimuth."),
    "length": to_translate("Known length: click both ends of a tape or staff."),
    "plane": to_translate(
        "Plane or line by compass: click the measured trace, patch or line, then enter the reading."
    ),
}


class KnownLineTool(PolylineTool[KnownLine]):
    """Tool for known lines of two points, whose values are entered in the panel.

    The kind "plane" includes all compass readings, even those of lines.
    """

    name = "known_line"
    noun = "known line"
    record = KnownLine

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_kind: KnownKind = "level"

    @property
    def kind(self) -> KnownKind:
        """Kind of the open line, or else of the next line."""
        return self._feature.kind if self._feature else self.next_kind

    @property
    def selects_feature(self) -> bool:
        """Whether clicks select a feature for a compass reading."""
        return self._feature is None and self.next_kind == "plane"

    def choose(self, kind: KnownKind) -> None:
        """Set the kind of the next line, and of the open line if it is new."""
        self.next_kind = kind
        open_feature = self._feature
        is_clicked = any(kind == item for item, _ in CLICKED_KINDS)
        if (
            open_feature is not None
            and not self._has_stored_feature
            and is_clicked
            and open_feature.kind != kind
        ):
            self._store_step(open_feature.replace_fields(kind=kind), self._steps, None)
        self._context.tool_changed()

    def continue_feature(self, feature_id: str) -> None:
        """Continue a feature. Raises DocumentError.

        A compass reading cannot be continued because it has no vertices.
        """
        line = get(self._context.session.records, feature_id, KnownLine)
        if line is not None and line.is_read:
            raise DocumentError(Finding("line.from-compass", name=line.name))
        super().continue_feature(feature_id)

    def hint(self) -> str:
        if self._feature is None:
            return tr(_HINTS[self.kind])
        return tr("Click the other end. Press Backspace to remove the first one, Esc to cancel.")

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        if len(self.vertices) < 2:
            return Finding("feature.too-few-points", count=1, minimum=2)
        return None

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> KnownLine:
        return KnownLine(new_id("line"), "", self.next_kind, model.id, model.content_hash, vertices)

    def _append(self, position: Point) -> None:
        self._set_vertices((*self.vertices[:1], position))
        if len(self.vertices) == 2 and not self._has_stored_feature:
            self.finish()

    def insert_vertex(self, position: Point) -> None:
        """Do nothing, because a known line has no vertices between its ends."""

    def _edit(self, feature: KnownLine) -> Edit:
        if (reason := self.finish_problem()) is not None:
            raise GeometryError(reason)
        if feature.vertices[0] == feature.vertices[1]:
            raise GeometryError(Finding("points.coincident"))
        records = self._context.session.records
        if not self._has_stored_feature:
            return edits.add_features(records, [feature])
        return edits.set_line(records, feature.id, feature.vertices)

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: KnownLine) -> dict[str, Any]:
        return {"kind": feature.kind}

    def _feature_from_draft(
        self, state: Mapping[str, Any], vertices: tuple[Point, ...]
    ) -> KnownLine:
        known_kind = next((item for item, _ in CLICKED_KINDS if item == state["kind"]), None)
        if known_kind is None:
            raise ValueError(state["kind"])
        self.next_kind = known_kind
        return KnownLine(
            str(state[f"{self.name}_id"]),
            "",
            known_kind,
            str(state["model_id"]),
            str(state["model_hash"]),
            vertices,
        )

    # --- preview ------------------------------------------------------------------------------
    def _color(self) -> str:
        return KIND.color

    def _reading_lines(self) -> tuple[str, ...]:
        return (points_text(len(self.vertices)),)


TOOL = ToolEntry(
    KnownLineTool,
    label=to_translate("&Known lines"),
    icon="spirit-level",
    key="K",
    tip=to_translate("Register the model using known lines and compass readings."),
    order=46,
)
