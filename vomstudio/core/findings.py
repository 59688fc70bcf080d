"""Findings: messages with stable codes and values, returned by operations.

A finding is created where a problem is detected and contains no sentence. Its text is produced
where it is displayed (window, terminal, report, table) from the catalogue in
`vomstudio.core.finding_texts`; scripts and tests use the code and the values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from string import Formatter
from typing import Any

from vomstudio.core.errors import VomError, from_json_values, location_text, to_json_values
from vomstudio.core.finding_texts import TEXTS, Severity, get_texts
from vomstudio.core.words import tr, tr_n

UNCODED_FINDING_CODE = "uncoded"
"""Code of sentences that do not have their own code yet."""
MAX_SHOWN = 8
"""Maximum number of list items that a text names; the remaining items are counted."""


class Finding:
    """Message about one observation of an operation; immutable.

    This class is not a dataclass, so `dataclasses.asdict` leaves the findings in a result
    unchanged.

    Parameters
    ----------
    code : str
        Key in the catalogue, such as ``frame.not-metric``.
    severity : {"info", "warning", "error"}, optional
        Severity. If None, the severity of the catalogue is used.
    **values
        Values of the placeholders in the catalogue, and any other values that a script may need:
        numbers, strings, booleans, None, or lists of these. Other objects, such as paths, are
        stored as text.

    Raises
    ------
    KeyError
        If the catalogue does not contain the code, or if the value of a placeholder is missing.
    """

    __slots__ = ("_values", "code", "severity")

    code: str
    severity: Severity
    _values: tuple[tuple[str, Any], ...]

    def __init__(self, code: str, severity: Severity | None = None, /, **values: Any) -> None:
        default_severity = TEXTS[code][0]
        if not placeholders(code) <= values.keys():
            missing_keys = placeholders(code) - values.keys()
            raise KeyError(f"{code} needs {', '.join(sorted(missing_keys))}")
        object.__setattr__(self, "code", code)
        object.__setattr__(self, "severity", severity or default_severity)
        frozen_values = {name: _freeze(value) for name, value in values.items()}
        object.__setattr__(self, "_values", tuple(frozen_values.items()))

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a finding cannot be changed: {name}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Finding):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        values = "".join(f", {name}={value!r}" for name, value in self._values)
        return f"Finding({self.code!r}, {self.severity!r}{values})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Finding.from_dict, (self.to_dict(),)

    def _key(self) -> tuple[Any, ...]:
        return self.code, self.severity, tuple(sorted(self._values, key=lambda item: item[0]))

    @property
    def values(self) -> dict[str, Any]:
        """Values by name."""
        return dict(self._values)

    @property
    def message(self) -> str:
        """Sentence for the user, in the user's language."""
        values = {name: _display_value(value) for name, value in self._values}
        text, *several = get_texts(self.code)
        if several:
            sentence = tr_n(text, several[0], self.values["count"], **values)
        else:
            sentence = tr(text, **values)
        # The reasons at the end of a text may be empty.
        sentence = sentence.rstrip()
        if self.values.get("file") is None or "{file}" in text:
            return sentence
        missing_fields = {"file", "line", "field"} - placeholders(self.code)
        location = {name: value for name, value in self._values if name in missing_fields}
        return f"{location_text(**location)}: {sentence}"

    def with_file(self, file: str) -> Finding:
        """Return the finding with a file name added if it does not have one yet."""
        values = self.values
        return self if "file" in values else Finding(self.code, self.severity, **values, file=file)

    def __str__(self) -> str:
        return self.message

    def to_dict(self) -> dict[str, Any]:
        """Return the object that ``--json`` prints: code, severity, message and values."""
        values = to_json_values(self.values)
        if self.code == UNCODED_FINDING_CODE:
            values.pop("text")
        return {"code": self.code, "severity": self.severity, "message": self.message} | values

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Finding:
        """Return the finding that `to_dict` represents, for example from another process."""
        reserved = ("code", "severity", "message")
        values: dict[str, Any] = from_json_values(
            {name: value for name, value in row.items() if name not in reserved}
        )
        if row["code"] == UNCODED_FINDING_CODE:
            prefix = f"{values['file']}: " if "file" in values else ""
            values["text"] = row["message"].removeprefix(prefix)
        return cls(row["code"], row["severity"], **values)


def uncoded_finding(text: str) -> Finding:
    """Return a finding for a sentence that does not have a code yet."""
    return Finding(UNCODED_FINDING_CODE, text=text)


def cause_finding(error: VomError) -> Finding:
    """Return the finding of an error without the location of the error."""
    if error.code not in TEXTS:
        return uncoded_finding(error.message)
    # An error from another process states its location only once, even if its text contains it.
    location = _location(error)
    missing_keys = placeholders(error.code) - error.values.keys()
    stated_values = {name: location[name] for name in missing_keys & location.keys()}
    return Finding(error.code, **error.values | stated_values)


def to_finding(error: VomError) -> Finding:
    """Return the finding of an error with the file, line and field of the error.

    A field without a file is an argument, which is not part of a finding.
    """
    if error.code not in TEXTS:
        return uncoded_finding(str(error))
    cause = cause_finding(error)
    if error.file is None or "file" in cause.values:
        return cause
    return Finding(cause.code, cause.severity, **_location(error) | cause.values)


def _location(error: VomError) -> dict[str, Any]:
    location = {"file": error.file, "line": error.line, "field": error.field}
    return {name: value for name, value in location.items() if value is not None}


def to_json_list(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    """Return findings as objects for a JSON file."""
    return [item.to_dict() for item in findings]


def unique_findings(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the unique findings in their original order."""
    return tuple(dict.fromkeys(findings))


@cache
def placeholders(code: str) -> frozenset[str]:
    """Return the names of the placeholders in the texts of a code."""
    texts = get_texts(code)
    names = {name for text in texts for _, name, _, _ in Formatter().parse(text) if name}
    return frozenset(names | ({"count"} if len(texts) > 1 else set()))


_FROZEN_TYPES = frozenset({str, int, float, bool, type(None)})


def _freeze(value: Any) -> Any:
    if type(value) in _FROZEN_TYPES:
        return value
    if isinstance(value, list | tuple):
        return tuple(map(_freeze, value))
    # NumPy scalars have an `item` method.
    value = value.item() if hasattr(value, "item") else value
    return value if value is None or isinstance(value, str | int | float) else str(value)


def _display_value(value: Any) -> Any:
    if isinstance(value, tuple):
        if len(value) <= MAX_SHOWN:
            return ", ".join(map(str, value))
        shown_values = ", ".join(map(str, value[:MAX_SHOWN]))
        return tr("{names} and {count} more", names=shown_values, count=len(value) - MAX_SHOWN)
    if isinstance(value, str):
        # Messages of libraries may have several lines.
        return " ".join(value.split()) if "\n" in value else value
    if isinstance(value, float):
        return _Number(value)
    return tr("none") if value is None else value


class _Number(float):
    """Number that is shown with its significant digits if the text does not specify a format.

    The format ``azimuth`` shows three digits and writes 360 as 000. Numbers below 1e9 have no
    exponent.
    """

    __slots__ = ()

    def __format__(self, format_spec: str) -> str:
        if format_spec == "azimuth":
            return f"{round(self) % 360:03d}"
        text = super().__format__(format_spec or ".12g")
        return f"{float(text):,.0f}" if "e+" in text and abs(self) < 1e9 else text
