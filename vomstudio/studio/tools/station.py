"""Tool for stations and samples; each click creates one of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.matrices import Point
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.station import KIND, STATION_KINDS, Station, StationKind
from vomstudio.project.records import Model
from vomstudio.studio.tools.interaction_types import Hit
from vomstudio.studio.tools.polyline import PolylineTool
from vomstudio.studio.tools.tool_entry import ToolEntry


@dataclass(frozen=True)
class NextStation:
    """Attributes of the next station, with the fields of `Station`."""

    what: StationKind = "station"
    number: str = ""
    photo: str = ""


class StationTool(PolylineTool[Station]):
    """Tool that creates stations; a continued station is moved by clicking or dragging."""

    name = "station"
    noun = "field station"
    record = Station

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_station = NextStation()

    def hint(self) -> str:
        if self.is_continued:
            return tr(
                "Field station: click its new position; press Enter to finish, Esc to cancel."
            )
        return tr("Field station: click the position of a station or sample on the outcrop.")

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        return None if self.vertices else Finding("feature.too-few-points", count=1, minimum=1)

    def choose(self, **values: str) -> None:
        """Set `what`, `number` or `photo` of the next station."""
        self.next_station = replace(self.next_station, **values)  # type: ignore[arg-type]
        self._context.tool_changed()

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Station:
        return Station(
            new_id("station"),
            "",
            model.id,
            model.content_hash,
            vertices[:1],
            self.next_station.what,
            self.next_station.number,
            self.next_station.photo,
        )

    def _begin_feature(self, hit: Hit) -> None:
        super()._begin_feature(hit)
        if self._feature is not None and self.finish() is not None:
            self.next_station = replace(
                self.next_station, number=increment_number(self.next_station.number), photo=""
            )
            self._context.tool_changed()

    def _append(self, position: Point) -> None:
        self._set_vertices((position,))

    def insert_vertex(self, position: Point) -> None:
        """Move the station to `position`, because it has a single vertex."""
        self._set_vertices((position,))

    def _edit(self, feature: Station) -> Edit:
        records = self._context.session.records
        if not self._has_stored_feature:
            return edits.add_features(records, [feature])
        return edits.set_line(records, feature.id, feature.vertices)

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: Station) -> dict[str, Any]:
        return {"what": feature.what, "number": feature.number, "photo": feature.photo}

    def clear_state(self) -> None:
        """Reset for another project, which has its own numbers."""
        super().clear_state()
        self.next_station = NextStation()

    def _feature_from_draft(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> Station:
        station_kind = {kind_name: kind_name for kind_name, _ in STATION_KINDS}[state["what"]]
        return Station(
            str(state["station_id"]),
            "",
            str(state["model_id"]),
            str(state["model_hash"]),
            vertices[:1],
            station_kind,
            str(state["number"]),
            str(state["photo"]),
        )

    # --- preview ------------------------------------------------------------------------------
    def _color(self) -> str:
        return KIND.color

    def _reading_lines(self) -> tuple[str, ...]:
        feature = self._feature
        return () if feature is None else (feature.number or feature.name,)


def increment_number(number: str) -> str:
    """Return the label after a numbered label, such as KB-10 after KB-09; "" for others."""
    match = re.search(r"(\d+)(\D*)$", number)
    if match is None:
        return ""
    digits = match.group(1)
    return f"{number[: match.start()]}{int(digits) + 1:0{len(digits)}d}{match.group(2)}"


TOOL = ToolEntry(
    StationTool,
    label=to_translate("Fiel&d station"),
    icon="map-marker",
    key="D",
    tip=to_translate("Click the position of a station or sample; add number and photos."),
    order=36,
)
