"""Features that repeat another: picks of a structure that was picked before are no further ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.edit import Edit, change
from vomstudio.project.records import Feature, Record, Repeatable, get

Records = Mapping[str, Record]
F = TypeVar("F")

COLUMNS = ("repeat_of", "interpreter")
"""Of the orientation table, behind the others where any feature has one."""


def is_repeat(feature: Any, records: Records) -> bool:
    """Whether it repeats a feature that is there: where the first pick was deleted, the second one
    stands for the structure."""
    if not isinstance(feature, Repeatable) or feature.repeat_of is None:
        return False
    return feature.repeat_of in records


def firsts(features: Iterable[F], records: Records) -> list[F]:
    """Those that repeat no other."""
    return [f for f in features if not is_repeat(f, records)]


def told(feature: Any, records: Records) -> dict[str, str]:
    """What the table says of it beside its orientation; nothing where it is not said."""
    if not isinstance(feature, Repeatable):
        return {}
    repeats = feature.repeat_of if is_repeat(feature, records) else None
    found = {"repeat_of": repeats, "interpreter": feature.interpreter}
    return {name: value for name, value in found.items() if value}


def repeatable_features(records: Records) -> list[Repeatable]:
    """Features that can be offered for a second time: no repeats, and not repeated yet."""
    found = [r for r in records.values() if isinstance(r, Repeatable)]
    done = {r.repeat_of for r in found if r.repeat_of}
    return [r for r in found if not is_repeat(r, records) and r.id not in done]


def link_repeat(records: Records, id_: str, first_id: str, interpreter: str = "") -> Edit:
    """Say that a feature repeats another, and who picked it. It takes the type and set of the
    first. Raises DocumentError for features that are not there, or not of one kind."""
    again, first = get(records, id_, Repeatable), get(records, first_id, Repeatable)
    if again is None or first is None or again.id == first.id or type(again) is not type(first):
        raise DocumentError(Finding("repeat.other-kind"))
    if is_repeat(first, records):
        raise DocumentError(Finding("repeat.of-repeat", feature=first.name))
    name = f"{first.name} {tr('again')}"
    taken = {r.name for r in records.values() if isinstance(r, Feature)}
    k = 2
    while name in taken:
        name, k = f"{first.name} {tr('again')} {k}", k + 1
    values: dict[str, Any] = {"repeat_of": first.id, "interpreter": interpreter or None}
    for field in ("type_id", "set_name", "domain"):
        if hasattr(first, field):
            values[field] = getattr(first, field)
    made: Any = replace(again, name=name, **values)
    return change(records, f"Repeat {first.name}", {id_: made})


def set_interpreter(records: Records, ids: Iterable[str], interpreter: str) -> Edit:
    """Say who picked features. Raises DocumentError where there is none of them."""
    found = [r for id_ in ids if (r := get(records, id_, Repeatable)) is not None]
    if not found:
        raise DocumentError(Finding("selection.empty"))
    after: dict[str, Any] = {r.id: r.but(interpreter=interpreter or None) for r in found}
    return change(records, f"Change interpreter of {len(found)} features", after)
