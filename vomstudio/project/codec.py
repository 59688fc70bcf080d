"""Conversion of records to and from JSON values; names here are the names on disk.

A record that is added or removed is written completely. For a changed record, only the fields that
differ are written, so assigning ten thousand traces to another set does not copy their vertices.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, cast

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.plain_data import (
    NestedFields,
    PlainValues,
    decode_fields,
    encode_fields,
    known_fields,
)
from vomstudio.geology.profiles import Thresholds
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import (
    NorthReference,
    ObservationGroup,
    Registration,
    RegistrationPoint,
)
from vomstudio.project import kinds
from vomstudio.project.edit import Edit
from vomstudio.project.records import (
    Asset,
    Compass,
    FaceGrid,
    FeatureType,
    ImageMark,
    MarkedPoint,
    Mask,
    Model,
    PhotoSet,
    ReconstructionRecord,
    Record,
    VerdictProfile,
)

RECORD_TYPES: dict[str, type] = {
    "model": Model,
    "feature_type": FeatureType,
    **kinds.RECORDS,
    "photo_set": PhotoSet,
    "mask": Mask,
    "marked_point": MarkedPoint,
    "image_mark": ImageMark,
    "reconstruction": ReconstructionRecord,
    "registration": Registration,
    "verdict_profile": VerdictProfile,
    "face_grid": FaceGrid,
    "compass": Compass,
}
"""Record classes by their name on disk."""
_NESTED = NestedFields(
    parts={
        "placement": Frame,
        "frame": Frame,
        "file": Asset,
        "limits": Thresholds,
        "read_north": NorthReference,
        **kinds.PARTS,
    },
    lists={"control": RegistrationPoint, "observations": ObservationGroup},
)
"""A placement may be a registration instead of a frame; in that case its ID is written."""
_NAMES = {cls: name for name, cls in RECORD_TYPES.items()}

NO_RECORDS: Mapping[str, Record] = MappingProxyType({})


def encode(record: Record) -> PlainValues:
    """Return a record as JSON values, including its kind."""
    # dataclasses.asdict copies every number, which takes seconds for a patch of 100,000 points.
    values = {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}
    return {"record": _NAMES[type(record)], **_encode(values)}


def decode(stored_values: Mapping[str, Any], records: Mapping[str, Record] = NO_RECORDS) -> Record:
    """Return the record from its JSON values; `records` contains the records it refers to.

    Raises a DocumentError that names the kind or field that cannot be read.
    """
    values = dict(stored_values)
    kind = values.pop("record", None)
    cls = RECORD_TYPES.get(kind) if isinstance(kind, str) else None
    if cls is None:
        raise DocumentError(Finding("record.unknown-kind", kind=kind), field="record")
    values = _known_values(cls, values)
    try:
        record: Record = cls(**_decode(cls, values, records))
    except TypeError as error:
        raise DocumentError(Finding("record.missing-field", kind=kind, error=error)) from error
    return record


def encode_edit(edit: Edit) -> tuple[PlainValues, PlainValues]:
    """Encode an edit as two mappings from id to None, a complete record, or changed fields."""
    before: PlainValues = {}
    after: PlainValues = {}
    for id_, new_record in edit.after.items():
        old_record = edit.before[id_]
        if old_record is None or new_record is None or type(old_record) is not type(new_record):
            before[id_] = None if old_record is None else encode(old_record)
            after[id_] = None if new_record is None else encode(new_record)
            continue
        before[id_], after[id_] = map(_encode, _differing_values(old_record, new_record))
    return before, after


def _differing_values(first: Record, second: Record) -> tuple[PlainValues, PlainValues]:
    """Return the values of the fields in which two records of one class differ."""
    # Most values are the same objects, and comparing long lines takes time.
    old_values, new_values = vars(first), vars(second)
    names = [
        name
        for name in _field_names(cast(Hashable, type(first)))
        if (value := old_values[name]) is not (new_value := new_values[name]) and value != new_value
    ]
    return {name: old_values[name] for name in names}, {name: new_values[name] for name in names}


@cache
def _field_names(cls: Hashable) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(cast("type[Record]", cls)))


def decode_edit(
    label: str, before: PlainValues, after: PlainValues, records: Mapping[str, Record]
) -> Edit:
    """Return the edit of a journal row.

    `records` contains the records before the edit; fields of changed records that are not in the
    row are copied from there. Raises DocumentError.
    """
    if not (isinstance(before, Mapping) and isinstance(after, Mapping)):
        raise DocumentError(Finding("record.wrong-value"), field="after")
    old_records = {id_: _read(id_, before.get(id_), records, records) for id_ in after}
    new_records: dict[str, Record | None] = {}
    models = {
        id_ for id_, stored_record in after.items() if _is_model(stored_record, records.get(id_))
    }
    for id_, stored_record in after.items():
        if id_ not in models:
            new_records[id_] = _read(id_, stored_record, records, records)
    # A model may refer to a registration that the same edit adds.
    added_records = {id_: record for id_, record in new_records.items() if record is not None}
    all_records = {**records, **added_records} if models else records
    for id_ in models:
        new_records[id_] = _read(id_, after[id_], records, all_records)
    return Edit(label, old_records, {id_: new_records[id_] for id_ in after})


def _is_model(values: PlainValues | None, record: Record | None) -> bool:
    return isinstance(record, Model) or (
        isinstance(values, Mapping) and values.get("record") == "model"
    )


def _read(
    id_: str,
    stored_record: PlainValues | None,
    records: Mapping[str, Record],
    records_by_id: Mapping[str, Record],
) -> Record | None:
    if stored_record is None:
        return None
    if not isinstance(stored_record, Mapping):
        raise DocumentError(Finding("record.wrong-value"), field=id_)
    if "record" in stored_record:
        decoded_record = decode(stored_record, records_by_id)
        if decoded_record.id != id_:
            raise DocumentError(Finding("record.two-ids"), field="id")
        return decoded_record
    record = records.get(id_)
    if record is None:
        raise DocumentError(Finding("record.without-base", record=id_))
    values = _decode(type(record), _known_values(type(record), stored_record), records_by_id)
    if values.get("id", id_) != id_:
        raise DocumentError(Finding("record.two-ids"), field="id")
    changed_record: Record = dataclasses.replace(record, **values)
    return changed_record


def _known_values(cls: type, values: Mapping[str, Any]) -> PlainValues:
    return known_fields(cls, values, _NAMES.get(cls, cls.__name__))


def _encode(values: Mapping[str, Any]) -> PlainValues:
    plain_fields = encode_fields(values, _NESTED)
    placement = values.get("placement")
    if isinstance(placement, Registration):
        plain_fields["placement"] = {"registration": placement.id}
    return plain_fields


def _decode(cls: type, values: Mapping[str, Any], records: Mapping[str, Record]) -> PlainValues:
    placement = values.get("placement")
    if not isinstance(placement, Mapping) or set(placement) != {"registration"}:
        return decode_fields(cls, values, _NESTED)
    plain_values = {name: value for name, value in values.items() if name != "placement"}
    registration = _registration(placement["registration"], records)
    return decode_fields(cls, plain_values, _NESTED) | {"placement": registration}


def _registration(id_: Any, records: Mapping[str, Record]) -> Registration:
    record = records.get(id_) if isinstance(id_, str) else None
    if not isinstance(record, Registration):
        finding = Finding("record.missing", kind="registration", id=id_)
        raise DocumentError(finding, field="placement")
    return record
