"""Records as plain JSON values and back. The names here are the names on disk."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from vomstudio.document import kinds
from vomstudio.document.records import FeatureType, Frame, Model, Record
from vomstudio.errors import DocumentError

_KINDS: dict[str, type] = {
    "model": Model,
    "feature_type": FeatureType,
    **kinds.RECORDS,
}
_PARTS: dict[str, type] = {"frame": Frame, **kinds.PARTS}
_NAMES = {cls: name for name, cls in _KINDS.items()}

Plain = dict[str, Any]


def encode(record: Record) -> Plain:
    """A record as JSON values, with its kind."""
    # dataclasses.asdict copies every number: seconds for a patch of a hundred thousand points.
    values = {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}
    for name in _PARTS.keys() & values.keys():
        values[name] = dataclasses.asdict(values[name])
    return {"record": _NAMES[type(record)], **values}


def decode(plain: Mapping[str, Any]) -> Record:
    """The record; raises DocumentError that names the kind or field that cannot be read."""
    values = dict(plain)
    kind = values.pop("record", None)
    cls = _KINDS.get(kind) if isinstance(kind, str) else None
    if cls is None:
        raise DocumentError(f"a record of unknown kind {kind!r} cannot be read", field="record")
    names = {field.name for field in dataclasses.fields(cls)}
    unknown = set(values) - names
    if unknown:
        raise DocumentError(f"a {kind} has an unknown field", field=sorted(unknown)[0])
    try:
        for name, part in _PARTS.items():
            if name in values:
                values[name] = part(**values[name])
        record: Record = cls(**{name: _tuples(value) for name, value in values.items()})
    except TypeError as error:
        raise DocumentError(f"a {kind} lacks a field: {error}") from error
    return record


def encode_changes(changes: Mapping[str, Record | None]) -> dict[str, Plain | None]:
    return {id_: None if record is None else encode(record) for id_, record in changes.items()}


def decode_changes(plain: Mapping[str, Any]) -> dict[str, Record | None]:
    return {id_: None if value is None else decode(value) for id_, value in plain.items()}


def _tuples(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return tuple(_tuples(item) for item in value)
    return value
