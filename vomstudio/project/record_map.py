"""The records of an open project as everybody reads them, with indices that follow every change."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Hashable, ItemsView, Iterator, KeysView, Mapping, ValuesView
from types import MappingProxyType
from typing import Any, TypeVar, overload

from vomstudio.project.records import Feature, Record

T = TypeVar("T")
D = TypeVar("D")
K = TypeVar("K", bound=Hashable)


class RecordMap(Mapping[str, Record]):
    """Records by id, in the order in which they came; only the session that owns them changes them.

    An edit touches few records of many thousand, so neither are they copied for it nor is any
    question answered by looking at all of them: which records are of a class, and which numbers the
    names that begin with a letter have, is found once and kept up from then on.
    revision : grows with every change
    """

    def __init__(self, records: Mapping[str, Record]) -> None:
        self._records = dict(records)
        self._of: dict[type[Any], dict[str, Any]] = {}
        self._numbers: dict[str, Counter[int]] = {}
        self._counts: dict[Callable[[Record], Hashable], Counter[Any]] = {}
        self._once: dict[Callable[[RecordMap], Any], Any] = {}
        self.revision = 0

    def take(self, after: Mapping[str, Record | None]) -> None:
        """For the session: put these records in, take those out that are None."""
        self.revision += 1
        self._once = {}
        for id_, new in after.items():
            old = self._records.get(id_)
            if new is None:
                self._records.pop(id_, None)
            else:
                self._records[id_] = new
            for cls, kept in self._of.items():
                if isinstance(new, cls):
                    # A record of another class stood there: it is not where this one would come.
                    if old is not None and id_ not in kept:
                        self._of = {}
                        break
                    kept[id_] = new
                else:
                    kept.pop(id_, None)
            for key_of, counts in self._counts.items():
                for record, more in ((old, -1), (new, 1)):
                    key = None if record is None else key_of(record)
                    if key is not None:
                        counts[key] += more
                        if not counts[key]:
                            del counts[key]
            for prefix, numbers in self._numbers.items():
                if (number := number_of(prefix, old)) is not None:
                    numbers[number] -= 1
                    if not numbers[number]:
                        del numbers[number]
                if (number := number_of(prefix, new)) is not None:
                    numbers[number] += 1

    def of(self, cls: type[T]) -> list[T]:
        """The records of a class, in the order in which they came."""
        kept = self._of.get(cls)
        if kept is None:
            kept = {id_: r for id_, r in self._records.items() if isinstance(r, cls)}
            self._of[cls] = kept
        return list(kept.values())

    def highest_number(self, prefix: str) -> int:
        """Of the features that are named by this prefix and a number; 0 where there is none."""
        numbers = self._numbers.get(prefix)
        if numbers is None:
            numbers = Counter(
                number
                for record in self._records.values()
                if (number := number_of(prefix, record)) is not None
            )
            self._numbers[prefix] = numbers
        return max(numbers, default=0)

    def counted(self, key_of: Callable[[Record], K | None]) -> Mapping[K, int]:
        """How many records have each key; those of which it is None are not counted."""
        if key_of not in self._counts:
            keys = map(key_of, self._records.values())
            self._counts[key_of] = Counter(key for key in keys if key is not None)
        return MappingProxyType(self._counts[key_of])

    def once(self, work_out: Callable[[RecordMap], T]) -> T:
        """What a function of the records gives, worked out once until they change."""
        if work_out not in self._once:
            self._once[work_out] = work_out(self)
        found: T = self._once[work_out]
        return found

    # --- a mapping; those of Mapping itself are slower ----------------------------------------
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
        """The record of an id, else `default`."""
        return self._records.get(id_, default)

    def keys(self) -> KeysView[str]:
        """The ids."""
        return self._records.keys()

    def values(self) -> ValuesView[Record]:
        """The records."""
        return self._records.values()

    def items(self) -> ItemsView[str, Record]:
        """Ids with their records."""
        return self._records.items()


def highest_number(records: Mapping[str, Record], prefix: str) -> int:
    """Of the features that are named by this prefix and a number; 0 where there is none."""
    if isinstance(records, RecordMap):
        return records.highest_number(prefix)
    numbers = (number_of(prefix, record) for record in records.values())
    return max((number for number in numbers if number is not None), default=0)


def number_of(prefix: str, record: Record | None) -> int | None:
    """Of a feature that is named by this prefix and a number; None for others."""
    if not isinstance(record, Feature) or not record.name.startswith(prefix):
        return None
    digits = record.name[len(prefix) :]
    return int(digits) if re.fullmatch(r"\d+", digits) else None
