"""The kinds of features. Each module of this package that has a `KIND` is one: it holds the record,
and says how it is measured, which figures it has, how it is edited, what it rests on and how it is
drawn. Another kind is another module; nothing has to be entered anywhere.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable, Mapping
from importlib import import_module

from vomstudio.project.figures import Figure
from vomstudio.project.kind import (
    Attribute,
    Kind,
    OwnGroup,
    group_and_set,
    group_of,
    has_plane,
    is_picked_plane,
    kind_of,
    register,
)

__all__ = [
    "ATTRIBUTES",
    "FIGURES",
    "GROUPS",
    "KINDS",
    "PARTS",
    "RECORDS",
    "group_and_set",
    "group_of",
    "has_plane",
    "is_picked_plane",
    "kind_named",
    "kind_of",
]


def _found() -> list[Kind]:
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [import_module(f"{__name__}.{name}") for name in names]
    kinds = [module.KIND for module in modules if hasattr(module, "KIND")]
    return sorted(kinds, key=lambda kind: (kind.order, kind.name))


def _merged(lists: Iterable[tuple[Attribute, ...]]) -> tuple[Attribute, ...]:
    """Each field once, in an order that is that of every list."""
    merged: list[Attribute] = []
    for attributes in lists:
        known = [attribute.field for attribute in merged]
        place = 0
        for attribute in attributes:
            if attribute.field in known:
                place = known.index(attribute.field) + 1
                continue
            # Before what comes next and is there already.
            after = [known.index(a.field) for a in attributes if a.field in known[place:]]
            place = min(after, default=len(known))
            merged.insert(place, attribute)
            known.insert(place, attribute.field)
            place += 1
    return tuple(merged)


KINDS: tuple[Kind, ...] = tuple(_found())
for _kind in KINDS:
    register(_kind)

RECORDS: Mapping[str, type] = {kind.name: kind.record for kind in KINDS}
"""The class of a record by its name on disk."""
PARTS: Mapping[str, type] = {name: part for kind in KINDS for name, part in kind.parts.items()}
"""The class of a field that is a record itself, by the field's name."""
FIGURES: Mapping[str, Figure] = {f.name: f for kind in reversed(KINDS) for f in kind.figures}
"""By name; where kinds have one under the same name, that of the first kind."""
ATTRIBUTES: tuple[Attribute, ...] = _merged(kind.attributes for kind in KINDS)
GROUPS: tuple[OwnGroup, ...] = tuple(
    dict.fromkeys(kind.group for kind in KINDS if kind.group is not None)
)
"""Of features without a feature type."""

_BY_NAME = {kind.name: kind for kind in KINDS}


def kind_named(name: str) -> Kind | None:
    """The kind that has this name on disk."""
    return _BY_NAME.get(name)
