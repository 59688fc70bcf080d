"""Results of operations as the objects that ``--json`` prints."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import PurePath
from typing import Any

from vomstudio.core.findings import Finding, to_json_list

HIDDEN_IN_JSON = {"json": "hidden"}
"""Metadata of a field that is omitted from the object."""
OPTIONAL_IN_JSON = {"json": "optional"}
"""Metadata of a field that is omitted from the object if its value is missing or empty."""
FLATTENED_IN_JSON = {"json": "flat"}
"""Metadata of a field that is replaced in the object by the fields of its value."""


class Result:
    """Base class of frozen dataclasses that ``--json`` prints as an object of their fields."""

    def to_dict(self) -> dict[str, Any]:
        """Return the object that ``--json`` prints."""
        return to_dict(self)


def to_dict(result: Any) -> dict[str, Any]:
    """Convert a dataclass to a dict of its fields, in their order.

    Dataclasses, including those in sequences and mappings, become dicts; findings become objects
    with a code; arrays and tuples become lists; paths become text.
    """
    values: dict[str, Any] = {}
    for item in fields(result):
        value, kind = getattr(result, item.name), item.metadata.get("json")
        if kind == "hidden" or (kind == "optional" and value in (None, (), [])):
            continue
        if kind == "flat":
            values |= _to_plain_value(value)
        else:
            values[item.name] = (
                to_json_list(value) if item.name == "warnings" else _to_plain_value(value)
            )
    return values


def _to_plain_value(value: Any) -> Any:
    if is_dataclass(value):
        return value.to_dict() if isinstance(value, Result) else to_dict(value)
    if isinstance(value, Finding):
        return value.to_dict()
    if isinstance(value, list | tuple):
        return [_to_plain_value(item) for item in value]
    if isinstance(value, dict):
        return {key: _to_plain_value(item) for key, item in value.items()}
    if isinstance(value, PurePath):
        return str(value)
    return value.tolist() if hasattr(value, "tolist") else value
