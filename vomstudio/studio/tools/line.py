"""Tool for lineations, which yield trend and plunge, rake on a plane, or slip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from textwrap import wrap
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geology.slip import SENSES, SlipSense
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.plane_discs import disc
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.records import Model
from vomstudio.studio.tools.fit_summary import WRAP_WIDTH, first_reason_lines
from vomstudio.studio.tools.polyline import PolylineTool, draft_type_id, get_plane, points_text
from vomstudio.studio.tools.set_memory import SetMemory
from vomstudio.studio.tools.tool_entry import ToolEntry


@dataclass(frozen=True)
class NextLine:
    """Attributes of the next line, with the fields of `Lineation`."""

    type_id: str = "lineation"
    set_name: str = ""
    plane_id: str = ""
    slip: SlipSense = ""


class LineTool(PolylineTool[Lineation]):
    """Tool for lineations of two or more points, with its own current feature type.

    The types are separate because the other tools measure planes.
    """

    name = "line"
    record = Lineation

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_line = NextLine()
        self._sets = SetMemory()

    def hint(self) -> str:
        if self._feature is None:
            return tr("Line: click along a striation, a hinge or another lineation on the outcrop.")
        count = len(self.vertices)
        if count < 2:
            return tr("Line: 1 of at least 2 points. Press Backspace to remove it, Esc to cancel.")
        return tr_n(
            "Line: {count} point. Further points determine its error. Press Enter or double-click"
            " to finish, Esc to cancel; drag a vertex to move it.",
            "Line: {count} points. Further points determine its error. Press Enter or double-click"
            " to finish, Esc to cancel; drag a vertex to move it.",
            count,
        )

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        n_missing = 2 - len(self.vertices)
        if n_missing <= 0:
            return None
        return Finding("feature.too-few-points", count=n_missing, minimum=2)

    @property
    def attributes(self) -> NextLine:
        """Attributes of the open line, or else of the next line."""
        line = self._feature
        if line is None:
            return self.next_line
        return NextLine(line.type_id, line.set_name, line.plane_id, line.slip)

    def choose(self, **values: str) -> None:
        """Set attributes of the next line, and of the open line if it is new.

        A sense of slip requires a plane. The set is remembered for each type.
        """
        if "type_id" in values and "set_name" in values:
            current = self.attributes.type_id, self.attributes.set_name
            set_name = self._sets.choose_set(current, values["type_id"], values["set_name"])
            values["set_name"] = set_name
        self.next_line = _drop_orphan_slip(replace(self.next_line, **values))  # type: ignore[arg-type]
        line = self._feature
        if line is None or self._has_stored_feature:
            self._context.tool_changed()
            return
        attributes = _drop_orphan_slip(replace(self.attributes, **values))  # type: ignore[arg-type]
        if attributes != self.attributes:
            changed_line = replace(
                line,
                type_id=attributes.type_id,
                set_name=attributes.set_name,
                plane_id=attributes.plane_id,
                slip=attributes.slip,
            )
            self._store_step(changed_line, self._steps, self.current_vertex)

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Lineation:
        return Lineation(
            id=new_id("line"),
            name="",
            type_id=self.next_line.type_id,
            model_id=model.id,
            model_hash=model.content_hash,
            vertices=vertices,
            plane_id=self.next_line.plane_id,
            slip=self.next_line.slip,
            set_name=self.next_line.set_name,
        )

    def _edit(self, feature: Lineation) -> Edit:
        if self.measurement is None or self.measurement.problem:
            problem = self.measurement.problem if self.measurement else None
            raise GeometryError(problem or Finding("tool.no-points"))
        records = self._context.session.records
        if not self._has_stored_feature:
            return edits.add_features(records, [feature])
        return edits.set_line(records, feature.id, feature.vertices, resolution=feature.resolution)

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: Lineation) -> dict[str, Any]:
        return {
            "type_id": feature.type_id,
            "set_name": feature.set_name,
            "plane_id": feature.plane_id,
            "slip": feature.slip,
        }

    def clear_state(self) -> None:
        """Reset the attributes, because types, sets and planes belong to a project."""
        super().clear_state()
        self.next_line = NextLine()
        self._sets.clear()

    def _feature_from_draft(
        self, state: Mapping[str, Any], vertices: tuple[Point, ...]
    ) -> Lineation:
        # An unknown sense of slip makes the draft invalid.
        slip = {sense: sense for sense, _ in SENSES}[state["slip"]]
        lineation = Lineation(
            id=str(state["line_id"]),
            name="",
            type_id=draft_type_id(self._context, state, self.next_line.type_id),
            model_id=str(state["model_id"]),
            model_hash=str(state["model_hash"]),
            vertices=vertices,
            plane_id=str(state["plane_id"]),
            slip=slip,
            set_name=str(state["set_name"]),
        )
        self.next_line = NextLine(
            lineation.type_id, lineation.set_name, lineation.plane_id, lineation.slip
        )
        return lineation

    # --- preview ------------------------------------------------------------------------------
    def _measure_live(self) -> None:
        assert self._feature is not None
        surface = self._context.surface(self._feature.model_id)
        if surface is not None and self.vertices:
            resolution = surface.local_resolution(np.asarray(self.vertices, dtype=np.float64))
            self._feature = replace(self._feature, resolution=resolution)
        super()._measure_live()

    def _surrounding_patch(self) -> FloatArray | None:
        """Return a part of the plane that contains the line, or None if no plane is set."""
        plane = get_plane(self._context, self._feature.plane_id if self._feature else "")
        fit = self.measurement.line_fit if self.measurement else None
        if plane is None or plane.plane is None or fit is None:
            return None
        return disc(fit.centroid, plane.plane.normal(), 0.5 * fit.length)

    def _reading_lines(self) -> tuple[str, ...]:
        measurement, count = self.measurement, len(self.vertices)
        position = self._hovered_point()
        is_live = count == 1 and position is not None and position != self.vertices[0]
        if is_live and self._feature is not None and position is not None:
            # The cursor is used as the second point.
            measurement = self._context.measure(
                replace(self._feature, vertices=(*self.vertices, position))
            )
        if measurement is None or measurement.line is None or measurement.line_fit is None:
            if count < 2 or measurement is None or not measurement.problem:
                return (points_text(count),)
            return (points_text(count), *wrap(str(measurement.problem), WRAP_WIDTH))
        lines = [self._context.format_attitude(measurement)]
        if not is_live:
            lines.append(f"n {count}")
        if measurement.rake_deg is not None and self._feature is not None:
            base = self._context.session.records.get(self._feature.plane_id)
            name = base.name if base is not None else tr("its plane")
            lines.append(
                tr(
                    "Rake {rake:.0f}°, {angle:.1f}° off {plane}",
                    rake=measurement.rake_deg,
                    angle=measurement.off_plane_deg,
                    plane=name,
                )
            )
        if measurement.verdict is not None and not is_live:
            lines += first_reason_lines(measurement.verdict)
        return tuple(lines)


def _drop_orphan_slip(line: NextLine) -> NextLine:
    return line if line.plane_id else replace(line, slip="")


TOOL = ToolEntry(
    LineTool,
    label=to_translate("&Line"),
    icon="arrow-top-right",
    key="L",
    tip=to_translate("Click along a lineation to measure its trend, plunge and rake."),
    order=30,
)
