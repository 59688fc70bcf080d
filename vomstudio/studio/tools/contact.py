"""Tool for contact lines: clicks along a contact or fault that has no fitted plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geometry.matrices import Point
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.length_figures import words
from vomstudio.project.records import Model
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.studio.tools.polyline import draft_type_id, points_text
from vomstudio.studio.tools.set_memory import SetMemory
from vomstudio.studio.tools.tool_entry import ToolEntry


@dataclass(frozen=True)
class NextContact:
    """Attributes of the next contact line, with the fields of `Contact`."""

    type_id: str = "contact"
    set_name: str = ""


class ContactTool(FollowingTool[Contact]):
    """Tool for contact lines of two or more points, with its own current feature type."""

    name = "contact"
    noun = "contact line"
    record = Contact

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self.next_contact = NextContact()
        self._sets = SetMemory()

    def hint(self) -> str:
        if self._feature is None:
            return tr("Contact line: click along a contact or fault; no plane is fitted.")
        count = len(self.vertices)
        if count < 2:
            return tr("Contact line: click the next point. Press Esc to cancel.")
        return tr_n(
            "Contact line: {count} point. Press Enter or double-click to finish, Esc to cancel;"
            " drag a vertex to move it, Ctrl+click to insert one.",
            "Contact line: {count} points. Press Enter or double-click to finish, Esc to cancel;"
            " drag a vertex to move it, Ctrl+click to insert one.",
            count,
        )

    def finish_problem(self) -> Finding | None:
        if self._feature is None:
            return Finding("tool.nothing-open")
        if len(self.vertices) < 2:
            return Finding("feature.too-few-points", count=2 - len(self.vertices), minimum=2)
        return None

    @property
    def attributes(self) -> NextContact:
        """Type and set of the open line, or else of the next line."""
        line = self._feature
        return self.next_contact if line is None else NextContact(line.type_id, line.set_name)

    def choose(self, **values: str) -> None:
        """Set `type_id` or `set_name` of the next line, and of the open line if it is new.

        The set is remembered for each type.
        """
        if "type_id" in values and "set_name" in values:
            current = self.attributes.type_id, self.attributes.set_name
            set_name = self._sets.choose_set(current, values["type_id"], values["set_name"])
            values["set_name"] = set_name
        self.next_contact = replace(self.next_contact, **values)
        line = self._feature
        if line is None or self._has_stored_feature:
            self._context.tool_changed()
            return
        changed_line = replace(line, **values)  # type: ignore[arg-type]
        if changed_line != line:
            self._store_step(changed_line, self._steps, self.current_vertex)

    def _create_feature(self, model: Model, vertices: tuple[Point, ...]) -> Contact:
        return Contact(
            new_id("contact"),
            "",
            self.next_contact.type_id,
            model.id,
            model.content_hash,
            vertices,
            self.next_contact.set_name,
        )

    def _measure_live(self) -> None:
        assert self._feature is not None
        complete_feature = self._whole_path(self._feature)
        self.measurement = (
            self._context.measure(complete_feature) if complete_feature.vertices else None
        )

    def _edit(self, feature: Contact) -> Edit:
        self._check_dimension("length_m", Finding("points.coincident"))
        records = self._context.session.records
        if self._has_stored_feature:
            return edits.set_line(records, feature.id, feature.vertices)
        if self.is_path:
            feature = replace(self._whole_path(feature), notes=self._path_note(feature))
        return edits.add_features(records, [feature])

    # --- drafts ------------------------------------------------------------------------------
    def _extra_state(self, feature: Contact) -> dict[str, Any]:
        state = {"type_id": feature.type_id, "set_name": feature.set_name}
        return {**state, **self._cost_state()}

    def _feature_from_draft(self, state: Mapping[str, Any], vertices: tuple[Point, ...]) -> Contact:
        contact = Contact(
            str(state["contact_id"]),
            "",
            draft_type_id(self._context, state, self.next_contact.type_id),
            str(state["model_id"]),
            str(state["model_hash"]),
            vertices,
            str(state["set_name"]),
        )
        self.next_contact = NextContact(contact.type_id, contact.set_name)
        return contact

    # --- preview ------------------------------------------------------------------------------
    def _reading_lines(self) -> tuple[str, ...]:
        count, measurement = len(self.vertices), self.measurement
        if self.is_searching:
            return self._search_lines()
        if measurement is None or not measurement.dimension:
            return (points_text(count),)
        return (points_text(count), *words(measurement)[:1])


TOOL = ToolEntry(
    ContactTool,
    label=to_translate("Contact lin&e"),
    icon="vector-line",
    key="E",
    tip=to_translate("Draw a line along a contact or fault, without fitting a plane."),
    order=22,
)
