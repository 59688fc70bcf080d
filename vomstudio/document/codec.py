"""Records as plain JSON values and back. The names here are the names on disk.

A record that comes or goes is written whole. Of a record that changes only the fields that differ
are written, so that giving ten thousand traces another set costs no copy of their vertices.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import lru_cache
from itertools import chain
from types import MappingProxyType
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.document import kinds
from vomstudio.document.edit import Edit
from vomstudio.document.field_types import Reader, field_types
from vomstudio.document.records import (
    Asset,
    Compass,
    FaceGrid,
    FeatureType,
    Frame,
    ImageMark,
    MarkedPoint,
    Mask,
    Model,
    ObservationGroup,
    PhotoSet,
    ReadNorth,
    Reconstruction,
    Record,
    Registration,
    RegistrationPoint,
    VerdictProfile,
)
from vomstudio.errors import DocumentError
from vomstudio.geology.profiles import Thresholds

RECORD_TYPES: dict[str, type] = {
    "model": Model,
    "feature_type": FeatureType,
    **kinds.RECORDS,
    "photo_set": PhotoSet,
    "mask": Mask,
    "marked_point": MarkedPoint,
    "image_mark": ImageMark,
    "reconstruction": Reconstruction,
    "registration": Registration,
    "verdict_profile": VerdictProfile,
    "face_grid": FaceGrid,
    "compass": Compass,
}
"""Every class of record by its name on disk."""
_PARTS: dict[str, type] = {
    "placement": Frame,
    "frame": Frame,
    "file": Asset,
    "limits": Thresholds,
    "read_north": ReadNorth,
    **kinds.PARTS,
}
"""Fields that hold a small record of their own. A placement may be a registration instead, of which
its id is written."""
_LISTS: dict[str, type] = {"control": RegistrationPoint, "observations": ObservationGroup}
"""Fields that hold several small records."""
_NAMES = {cls: name for name, cls in RECORD_TYPES.items()}

Plain = dict[str, Any]

NOTHING: Mapping[str, Record] = MappingProxyType({})


def encode(record: Record) -> Plain:
    """A record as JSON values, with its kind."""
    # dataclasses.asdict copies every number: seconds for a patch of a hundred thousand points.
    values = {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}
    return {"record": _NAMES[type(record)], **_encoded(values)}


def decode(plain: Mapping[str, Any], records: Mapping[str, Record] = NOTHING) -> Record:
    """The record; `records` hold those that it names. Raises DocumentError that names the kind or
    field that cannot be read."""
    values = dict(plain)
    kind = values.pop("record", None)
    cls = RECORD_TYPES.get(kind) if isinstance(kind, str) else None
    if cls is None:
        raise DocumentError(Finding("record.unknown-kind", kind=kind), field="record")
    values = _known(cls, values)
    try:
        record: Record = cls(**_decoded(cls, values, records))
    except TypeError as error:
        raise DocumentError(Finding("record.missing-field", kind=kind, error=error)) from error
    return record


def encode_edit(edit: Edit) -> tuple[Plain, Plain]:
    """The two maps of an edit, id -> None, a whole record, or only the fields that differ."""
    before: Plain = {}
    after: Plain = {}
    for id_, new in edit.after.items():
        old = edit.before[id_]
        if old is None or new is None or type(old) is not type(new):
            before[id_] = None if old is None else encode(old)
            after[id_] = None if new is None else encode(new)
            continue
        names = [
            field.name
            for field in dataclasses.fields(new)
            if getattr(old, field.name) != getattr(new, field.name)
        ]
        before[id_] = _encoded({name: getattr(old, name) for name in names})
        after[id_] = _encoded({name: getattr(new, name) for name in names})
    return before, after


def decode_edit(label: str, before: Plain, after: Plain, records: Mapping[str, Record]) -> Edit:
    """The edit that a row of the journal holds; `records` are those before it, from which changed
    records take the fields that the row does not name. Raises DocumentError."""
    if not (isinstance(before, Mapping) and isinstance(after, Mapping)):
        raise DocumentError(Finding("record.wrong-value"), field="after")
    olds = {id_: _read(id_, before.get(id_), records, records) for id_ in after}
    news: dict[str, Record | None] = {}
    models = {id_ for id_, plain in after.items() if _is_model(plain, records.get(id_))}
    for id_, plain in after.items():
        if id_ not in models:
            news[id_] = _read(id_, plain, records, records)
    # A model may name a registration that comes with the same edit.
    arrived = {id_: record for id_, record in news.items() if record is not None}
    named = {**records, **arrived} if models else records
    for id_ in models:
        news[id_] = _read(id_, after[id_], records, named)
    return Edit(label, olds, {id_: news[id_] for id_ in after})


def _is_model(plain: Plain | None, record: Record | None) -> bool:
    return isinstance(record, Model) or (
        isinstance(plain, Mapping) and plain.get("record") == "model"
    )


def _read(
    id_: str, plain: Plain | None, records: Mapping[str, Record], named: Mapping[str, Record]
) -> Record | None:
    if plain is None:
        return None
    if not isinstance(plain, Mapping):
        raise DocumentError(Finding("record.wrong-value"), field=id_)
    if "record" in plain:
        made = decode(plain, named)
        if made.id != id_:
            raise DocumentError(Finding("record.two-ids"), field="id")
        return made
    record = records.get(id_)
    if record is None:
        raise DocumentError(Finding("record.without-base", record=id_))
    values = _decoded(type(record), _known(type(record), plain), named)
    if values.get("id", id_) != id_:
        raise DocumentError(Finding("record.two-ids"), field="id")
    changed: Record = dataclasses.replace(record, **values)
    return changed


def _known(cls: type, values: Mapping[str, Any]) -> Plain:
    """The fields, after checking their names. Raises DocumentError for an unknown one."""
    unknown = values.keys() - _fields(cls)
    if unknown:
        raise DocumentError(
            Finding("record.unknown-field", kind=_NAMES.get(cls, cls.__name__)),
            field=sorted(unknown)[0],
        )
    return dict(values)


@lru_cache(maxsize=64)
def _fields(cls: type) -> frozenset[str]:
    return frozenset(field.name for field in dataclasses.fields(cls))


@lru_cache(maxsize=64)
def _none_at_first(cls: type) -> frozenset[str]:
    """Fields that hold nothing unless something is said."""
    return frozenset(field.name for field in dataclasses.fields(cls) if field.default is None)


def _encoded(values: Mapping[str, Any]) -> Plain:
    made: Plain = {}
    for name, value in values.items():
        if isinstance(value, Registration):
            made[name] = {"registration": value.id}
        elif name in _PARTS and value is not None:
            made[name] = dataclasses.asdict(value)
        elif name in _LISTS:
            made[name] = [dataclasses.asdict(each) for each in value]
        else:
            made[name] = value
    return made


def _decoded(cls: type, values: Mapping[str, Any], records: Mapping[str, Record]) -> Plain:
    made: Plain = {}
    simple, readers = field_types(cls)
    for name, value in values.items():
        kinds = simple.get(name)
        if kinds is not None:
            if type(value) not in kinds:
                raise _wrong_value(name)
            made[name] = value
        elif name in readers:
            made[name] = _read_field(readers[name], name, value)
        elif value is None and name in _none_at_first(cls):
            made[name] = None
        elif name in _PARTS and value is not None:
            made[name] = _part(name, value, records)
        elif name in _LISTS and isinstance(value, list):
            made[name] = tuple(_small(_LISTS[name], name, each) for each in value)
        elif name in _PARTS or name in _LISTS:
            raise _wrong_value(name)
        else:
            made[name] = _tuples(value)
    return made


def _read_field(read: Reader, name: str, value: Any) -> Any:
    try:
        return read(value)
    except ValueError as error:
        raise _wrong_value(name) from error


def _wrong_value(name: str) -> DocumentError:
    return DocumentError(Finding("record.wrong-value"), field=name)


def _part(name: str, value: Any, records: Mapping[str, Record]) -> Any:
    if isinstance(value, Mapping) and set(value) == {"registration"}:
        named = value["registration"]
        found = records.get(named) if isinstance(named, str) else None
        if not isinstance(found, Registration):
            raise DocumentError(
                Finding("record.missing", kind="registration", id=named), field=name
            )
        return found
    return _small(_PARTS[name], name, value)


def _small(cls: type, name: str, value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise DocumentError(Finding("record.wrong-value"), field=name)
    try:
        return cls(**_decoded(cls, _known(cls, value), NOTHING))
    except TypeError as error:
        raise DocumentError(
            Finding("record.missing-field", error=error, kind=cls.__name__), field=name
        ) from error


def _are_lists_of_numbers(values: list[Any]) -> bool:
    """As the vertices of features are, which make up most of a journal."""
    return set(map(type, values)) == {list} and set(map(type, chain(*values))) <= {float, int}


def _tuples(value: Any) -> Any:
    if isinstance(value, list | tuple):
        if value and type(value[0]) is list and _are_lists_of_numbers(list(value)):
            return tuple(map(tuple, value))
        # Most of a journal are coordinates: numbers are not asked one by one.
        return tuple([_tuples(v) if isinstance(v, list | tuple) else v for v in value])
    return value
