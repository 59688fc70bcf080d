"""Features that repeat another feature; a repeated pick is not an additional structure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.edit import Edit, change
from vomstudio.project.records import Feature, Record, RepeatableFeature, get

Records = Mapping[str, Record]
F = TypeVar("F")

COLUMNS = ("repeat_of", "interpreter")
"""Last columns of the orientation table, written if any feature has a value in them."""


def is_repeat(feature: Any, records: Records) -> bool:
    """Return whether a feature repeats an existing feature.

    If the first pick was deleted, the repeat represents the structure.
    """
    if not isinstance(feature, RepeatableFeature) or feature.repeat_of is None:
        return False
    return feature.repeat_of in records


def first_picks(features: Iterable[F], records: Records) -> list[F]:
    """Return the features that do not repeat another one."""
    return [feature for feature in features if not is_repeat(feature, records)]


def repeat_columns(feature: Any, records: Records) -> dict[str, str]:
    """Return the non-empty repeat columns of the orientation table for a feature."""
    if not isinstance(feature, RepeatableFeature):
        return {}
    repeats = feature.repeat_of if is_repeat(feature, records) else None
    values = {"repeat_of": repeats, "interpreter": feature.interpreter}
    return {name: value for name, value in values.items() if value}


def repeatable_features(records: Records) -> list[RepeatableFeature]:
    """Return the features that are not repeats and have not been repeated yet."""
    features = [record for record in records.values() if isinstance(record, RepeatableFeature)]
    repeated_ids = {feature.repeat_of for feature in features if feature.repeat_of}
    return [
        feature
        for feature in features
        if not is_repeat(feature, records) and feature.id not in repeated_ids
    ]


def link_repeat(records: Records, id_: str, first_id: str, interpreter: str = "") -> Edit:
    """Declare that a feature repeats another one, and who picked it.

    The repeat gets the type, set and domain of the first pick, and a name derived from its name.

    Raises
    ------
    DocumentError
        If a feature does not exist, if both are the same or of different kinds, or if the first
        pick is itself a repeat.
    """
    repeated_feature, first_feature = (
        get(records, id_, RepeatableFeature),
        get(records, first_id, RepeatableFeature),
    )
    if (
        repeated_feature is None
        or first_feature is None
        or repeated_feature.id == first_feature.id
        or type(repeated_feature) is not type(first_feature)
    ):
        raise DocumentError(Finding("repeat.other-kind"))
    if is_repeat(first_feature, records):
        raise DocumentError(Finding("repeat.of-repeat", feature=first_feature.name))
    name = f"{first_feature.name} {tr('again')}"
    used_names = {record.name for record in records.values() if isinstance(record, Feature)}
    k = 2
    while name in used_names:
        name, k = f"{first_feature.name} {tr('again')} {k}", k + 1
    values: dict[str, Any] = {"repeat_of": first_feature.id, "interpreter": interpreter or None}
    for field in ("type_id", "set_name", "domain"):
        if hasattr(first_feature, field):
            values[field] = getattr(first_feature, field)
    repeat: Any = replace(repeated_feature, name=name, **values)
    return change(records, f"Repeat {first_feature.name}", {id_: repeat})


def set_interpreter(records: Records, ids: Iterable[str], interpreter: str) -> Edit:
    """Set the interpreter of features. Raises DocumentError if none of the features exists."""
    features = [
        record for id_ in ids if (record := get(records, id_, RepeatableFeature)) is not None
    ]
    if not features:
        raise DocumentError(Finding("selection.empty"))
    new_records: dict[str, Any] = {
        feature.id: feature.replace_fields(interpreter=interpreter or None) for feature in features
    }
    return change(records, f"Change interpreter of {len(features)} features", new_records)
