"""Edits stored as pairs of small maps, so that undo only swaps them."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass, replace
from typing import Any

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project.records import Record

Changes = Mapping[str, Record | None]
MAX_NAME_LENGTH = 200
_NAME_FIELDS = ("name", "set_name", "domain", "station", "number", "interpreter")


@dataclass(frozen=True)
class Edit:
    """Change of records.

    `before` and `after` map the same IDs to records, or to None if the record does not exist.
    `label` describes the change for the user ("Add trace B03").
    """

    label: str
    before: Changes
    after: Changes

    def __post_init__(self) -> None:
        if set(self.before) != set(self.after):
            raise ValueError("before and after must name the same records")

    @property
    def ids(self) -> frozenset[str]:
        return frozenset(self.after)

    def inverse(self) -> Edit:
        return Edit(self.label, self.after, self.before)

    def merge_with(self, later_edit: Edit) -> Edit:
        """Return this edit and a later one combined, with the label of the later one."""
        return Edit(
            later_edit.label,
            {**later_edit.before, **self.before},
            {**self.after, **later_edit.after},
        )

    def check(self, records: Mapping[str, Record]) -> None:
        """Check that the records match `before`. Raises DocumentError."""
        for id_, record in self.before.items():
            if (current := records.get(id_)) is not record and current != record:
                raise DocumentError(Finding("edit.stale", label=self.label, record=id_))

    def swap(self, records: MutableMapping[str, Record], *, strict: bool = True) -> None:
        """Change `records` from `before` to `after`.

        If `strict` is set and the records do not match `before`, DocumentError is raised and
        nothing changes.
        """
        if strict:
            self.check(records)
        for id_, record in self.after.items():
            if record is None:
                records.pop(id_, None)
            else:
                records[id_] = record


def change(records: Mapping[str, Record], label: str, after: Changes) -> Edit:
    """Return the edit that replaces records by those in `after`; None removes a record.

    Line breaks in names, which come from pasted text and from tables, become spaces.
    """
    after = {id_: _join_name_lines(record) for id_, record in after.items()}
    return Edit(_join_lines(label), {id_: records.get(id_) for id_ in after}, after)


def _join_name_lines(record: Record | None) -> Record | None:
    values: dict[str, Any] = {
        name: _join_lines(value)
        for name in _NAME_FIELDS
        if isinstance(value := getattr(record, name, None), str) and not value.isprintable()
    }
    return record if record is None or not values else replace(record, **values)


def _join_lines(text: str) -> str:
    return text if text.isprintable() else " ".join(text.splitlines())


def check_name(name: str, field: str = "name", *, may_be_empty: bool = False) -> None:
    """Check a name that a user has typed.

    Raises
    ------
    DocumentError
        If it is empty or has more than `MAX_NAME_LENGTH` characters.
    """
    if not may_be_empty and not name.strip():
        raise DocumentError(Finding("name.empty"), field=field)
    if len(name) > MAX_NAME_LENGTH:
        raise DocumentError(
            Finding("name.too-long", count=len(name), limit=MAX_NAME_LENGTH), field=field
        )
