"""Kinds of features; each module of this package that has a `KIND` defines one of them.

A module contains the record and defines how it is measured, edited and drawn, which figures it has
and what it depends on. A new kind is a new module; no list needs to be updated.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable, Mapping
from importlib import import_module

from vomstudio.project.figures import Figure
from vomstudio.project.kind import (
    Attribute,
    Kind,
    KindGroup,
    get_kind,
    group_and_set,
    has_plane,
    is_picked_plane,
    register,
    visibility_group,
)

__all__ = [
    "ATTRIBUTES",
    "FIGURES",
    "GROUPS",
    "KINDS",
    "PARTS",
    "RECORDS",
    "find_kind",
    "get_kind",
    "group_and_set",
    "has_plane",
    "is_picked_plane",
    "visibility_group",
]


def _load_kinds() -> list[Kind]:
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [import_module(f"{__name__}.{name}") for name in names]
    kinds = [module.KIND for module in modules if hasattr(module, "KIND")]
    return sorted(kinds, key=lambda kind: (kind.order, kind.name))


def _merge_attributes(attribute_lists: Iterable[tuple[Attribute, ...]]) -> tuple[Attribute, ...]:
    """Return each field once, in an order that is consistent with every list."""
    merged_attributes: list[Attribute] = []
    for attributes in attribute_lists:
        fields = [attribute.field for attribute in merged_attributes]
        index = 0
        for attribute in attributes:
            if attribute.field in fields:
                index = fields.index(attribute.field) + 1
                continue
            # Insert before the following fields that are already in the list.
            later_rows = [
                fields.index(attribute.field)
                for attribute in attributes
                if attribute.field in fields[index:]
            ]
            index = min(later_rows, default=len(fields))
            merged_attributes.insert(index, attribute)
            fields.insert(index, attribute.field)
            index += 1
    return tuple(merged_attributes)


KINDS: tuple[Kind, ...] = tuple(_load_kinds())
for _kind in KINDS:
    register(_kind)

RECORDS: Mapping[str, type] = {kind.name: kind.record for kind in KINDS}
"""Record classes by their name on disk."""
PARTS: Mapping[str, type] = {name: part for kind in KINDS for name, part in kind.parts.items()}
"""Classes of fields that are records themselves, by field name."""
FIGURES: Mapping[str, Figure] = {
    figure.name: figure for kind in reversed(KINDS) for figure in kind.figures
}
"""Figures by name; if several kinds have a figure with the same name, that of the first kind."""
ATTRIBUTES: tuple[Attribute, ...] = _merge_attributes(kind.attributes for kind in KINDS)
GROUPS: tuple[KindGroup, ...] = tuple(
    dict.fromkeys(kind.group for kind in KINDS if kind.group is not None)
)
"""Groups of features that have no feature type."""

_KINDS_BY_NAME = {kind.name: kind for kind in KINDS}


def find_kind(name: str) -> Kind | None:
    """Return the kind with this name on disk, or None if the name is unknown."""
    return _KINDS_BY_NAME.get(name)
