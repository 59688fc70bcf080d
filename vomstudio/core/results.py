"""Results of operations as the objects that ``--json`` prints."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from vomstudio.core.findings import Finding, plain


def to_dict(
    result: Any, flatten: str | None = None, leave_out: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return a result as a dict of its fields, in their order.

    Parameters
    ----------
    result : dataclass
        Fields that are dataclasses, also inside sequences and mappings, become dicts; warnings
        and other findings become objects with a code. Arrays stay whole.
    flatten : str, optional
        A field whose own fields take its place.
    leave_out : tuple of str
        Fields that the object does not have.
    """
    values: dict[str, Any] = {}
    for each in fields(result):
        if each.name == flatten:
            values |= to_dict(getattr(result, each.name))
        elif each.name == "warnings":
            values["warnings"] = plain(result.warnings)
        elif each.name not in leave_out:
            values[each.name] = _plain(getattr(result, each.name))
    return values


def _plain(value: Any) -> Any:
    if isinstance(value, Finding):
        return value.to_dict()
    if is_dataclass(value):
        return value.to_dict() if hasattr(value, "to_dict") else to_dict(value)
    if type(value) in (list, tuple):
        return type(value)(map(_plain, value))
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return value
