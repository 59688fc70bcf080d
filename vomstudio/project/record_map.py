"""Records of an open project, with indices that are updated with every change."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import (
    Callable,
    Hashable,
    ItemsView,
    Iterable,
    Iterator,
    KeysView,
    Mapping,
    ValuesView,
)
from types import MappingProxyType
from typing import Any, TypeVar, overload

from vomstudio.project.records import Feature, Record

T = TypeVar("T")
D = TypeVar("D")
K = TypeVar("K", bound=Hashable)


class RecordMap(Mapping[str, Record]):
    """Records by ID, in insertion order; only the session that owns them changes them.

    An edit changes only a few of many thousand records. Therefore the mapping is not copied, and
    the indices (records by class, numbers used in names) are built once and then updated.

    Attributes
    ----------
    revision : int
        Counter that increases with every change.
    """

    def __init__(self, records: Mapping[str, Record]) -> None:
        self._records = dict(records)
        self._class_members: dict[type[Any], dict[str, Any]] = {}
        self._indices: dict[type[Any], list[dict[str, Any]]] = {}
        self._numbers: dict[str, Counter[int]] = {}
        self._counts: dict[Callable[[Record], Hashable], Counter[Any]] = {}
        self._cache: dict[Callable[[RecordMap], Any], Any] = {}
        self.revision = 0

    def apply(self, new_records: Mapping[str, Record | None]) -> None:
        """Insert records, and remove those with the value None. Called only by the session."""
        self.revision += 1
        self._cache = {}
        for id_, new_record in new_records.items():
            old_record = self._records.get(id_)
            if new_record is None:
                self._records.pop(id_, None)
            else:
                self._records[id_] = new_record
            is_same_class = type(old_record) is type(new_record)
            if not is_same_class:
                self._update_members(id_, old_record, new_record)
            elif new_record is not None:
                for members in self._class_indices(type(new_record)):
                    members[id_] = new_record
            for get_key, counts in self._counts.items():
                old_key = None if old_record is None else get_key(old_record)
                new_key = None if new_record is None else get_key(new_record)
                if old_key != new_key:
                    _count(counts, old_key, new_key)
            old_name, new_name = (getattr(r, "name", None) for r in (old_record, new_record))
            if not is_same_class or old_name != new_name:
                for prefix, numbers in self._numbers.items():
                    _count(
                        numbers, name_number(prefix, old_record), name_number(prefix, new_record)
                    )

    def _update_members(
        self, id_: str, old_record: Record | None, new_record: Record | None
    ) -> None:
        """Update the indices by class after a record was added, removed or replaced."""
        for cls, members in self._class_members.items():
            if isinstance(new_record, cls):
                # The ID belonged to a record of another class, so its position in the order
                # differs.
                if old_record is not None and id_ not in members:
                    self._class_members, self._indices = {}, {}
                    break
                members[id_] = new_record
            else:
                members.pop(id_, None)

    def _class_indices(self, record_class: type[Any]) -> list[dict[str, Any]]:
        """Return the indices that contain the records of a class."""
        indices = self._indices.get(record_class)
        if indices is None:
            indices = self._indices[record_class] = [
                members
                for cls, members in self._class_members.items()
                if issubclass(record_class, cls)
            ]
        return indices

    def of(self, cls: type[T]) -> list[T]:
        """Return the records of a class in the order in which they were added."""
        members = self._class_members.get(cls)
        if members is None:
            members = {
                id_: record for id_, record in self._records.items() if isinstance(record, cls)
            }
            self._class_members[cls] = members
            self._indices = {}
        return list(members.values())

    def select(self, ids: Iterable[str], cls: type[T]) -> list[T]:
        """Return the records of a class with these IDs, in the order of the IDs."""
        # The window requests thousands of records at once, which needs more time with a loop.
        return [record for record in map(self._records.get, ids) if isinstance(record, cls)]

    def highest_number(self, prefix: str) -> int:
        """Return the highest number in names consisting of a prefix and a number, or 0."""
        numbers = self._numbers.get(prefix)
        if numbers is None:
            numbers = Counter(
                number
                for record in self._records.values()
                if (number := name_number(prefix, record)) is not None
            )
            self._numbers[prefix] = numbers
        return max(numbers, default=0)

    def count_by(self, get_key: Callable[[Record], K | None]) -> Mapping[K, int]:
        """Return the number of records per key, excluding records with the key None."""
        if get_key not in self._counts:
            keys = map(get_key, self._records.values())
            self._counts[get_key] = Counter(key for key in keys if key is not None)
        return MappingProxyType(self._counts[get_key])

    def cached(self, compute: Callable[[RecordMap], T]) -> T:
        """Return the result of a function of the records, which is computed once per revision."""
        if compute not in self._cache:
            self._cache[compute] = compute(self)
        result: T = self._cache[compute]
        return result

    # --- mapping methods; the defaults of Mapping are slower -------------------------------------
    def __getitem__(self, id_: str) -> Record:
        return self._records[id_]

    def __iter__(self) -> Iterator[str]:
        return iter(self._records)

    def __len__(self) -> int:
        return len(self._records)

    def __contains__(self, id_: object) -> bool:
        return id_ in self._records

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._records!r})"

    @overload
    def get(self, id_: str, /) -> Record | None: ...
    @overload
    def get(self, id_: str, default: Record | D, /) -> Record | D: ...
    def get(self, id_: str, default: Any = None, /) -> Any:
        """Return the record with an ID, or `default`."""
        return self._records.get(id_, default)

    def keys(self) -> KeysView[str]:
        """Return the IDs."""
        return self._records.keys()

    def values(self) -> ValuesView[Record]:
        """Return the records."""
        return self._records.values()

    def items(self) -> ItemsView[str, Record]:
        """Return the IDs with their records."""
        return self._records.items()


def _count(counts: Counter[Any], old_key: Any, new_key: Any) -> None:
    """Count a key that has replaced another key; None is not counted."""
    if old_key is not None:
        counts[old_key] -= 1
        if not counts[old_key]:
            del counts[old_key]
    if new_key is not None:
        counts[new_key] += 1


def highest_number(records: Mapping[str, Record], prefix: str) -> int:
    """Return the highest number in names consisting of a prefix and a number, or 0."""
    if isinstance(records, RecordMap):
        return records.highest_number(prefix)
    numbers = (name_number(prefix, record) for record in records.values())
    return max((number for number in numbers if number is not None), default=0)


def name_number(prefix: str, record: Record | None) -> int | None:
    """Return the number in a name that consists of a prefix and a number, or None."""
    if not isinstance(record, Feature) or not record.name.startswith(prefix):
        return None
    digits = record.name[len(prefix) :]
    return int(digits) if re.fullmatch(r"\d+", digits) else None
