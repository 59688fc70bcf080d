"""An edit is a pair of small maps, so undoing it is a swap and nobody has to write an undo."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project.records import Record

Changes = Mapping[str, Record | None]


@dataclass(frozen=True)
class Edit:
    """`before` and `after` map the same ids to records, None where there is none. `label` says in
    the user's words what is done ("Add trace B03")."""

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
        """Both as one, under the later label."""
        return Edit(later.label, {**later.before, **self.before}, {**self.after, **later.after})

    def check(self, records: Mapping[str, Record]) -> None:
        """Raises DocumentError where the records are not what `before` says."""
        for id_, record in self.before.items():
            if records.get(id_) != record:
                raise DocumentError(Finding("edit.stale", label=self.label, record=id_))

    def swap(self, records: MutableMapping[str, Record], *, strict: bool = True) -> None:
        """Bring `records` from `before` to `after`. Strict: raises DocumentError, with nothing
        changed, where the records are not what `before` says."""
        if strict:
            self.check(records)
        for id_, record in self.after.items():
            if record is None:
                records.pop(id_, None)
            else:
                records[id_] = record


def change(records: Mapping[str, Record], label: str, after: Changes) -> Edit:
    """The edit that brings `records` to `after` in the ids that `after` names."""
    return Edit(label, {id_: records.get(id_) for id_ in after}, dict(after))
