"""Edits as pairs of small maps, so that undo is a swap."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project.records import Record

Changes = Mapping[str, Record | None]


@dataclass(frozen=True)
class Edit:
    """A change of records.

    `before` and `after` map the same ids to records, or to None for a record that does not exist.
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

    def followed_by(self, later: Edit) -> Edit:
        """Return both edits as one, under the later label."""
        return Edit(later.label, {**later.before, **self.before}, {**self.after, **later.after})

    def check(self, records: Mapping[str, Record]) -> None:
        """Check that the records match `before`. Raises DocumentError."""
        for id_, record in self.before.items():
            if records.get(id_) != record:
                raise DocumentError(Finding("edit.stale", label=self.label, record=id_))

    def swap(self, records: MutableMapping[str, Record], *, strict: bool = True) -> None:
        """Change `records` from `before` to `after`.

        If `strict`, raises DocumentError, with nothing changed, unless the records match `before`.
        """
        if strict:
            self.check(records)
        for id_, record in self.after.items():
            if record is None:
                records.pop(id_, None)
            else:
                records[id_] = record


def change(records: Mapping[str, Record], label: str, after: Changes) -> Edit:
    """Return the edit that sets `records` to `after` for the ids in `after`."""
    return Edit(label, {id_: records.get(id_) for id_ in after}, dict(after))
