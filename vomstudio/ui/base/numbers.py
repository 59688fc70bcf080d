"""Numbers as users type them, with either decimal mark and with units."""

from __future__ import annotations

import re
from math import isfinite

_METRES_PER_UNIT = {"mm": 0.001, "cm": 0.01, "m": 1.0, "km": 1000.0}
"""Length in metres of each unit that a length field converts."""
_QUANTITY_PATTERN = re.compile(r"(.*[\d.,])\s*([^\d\s.,]+)")


def parse_number(text: str) -> float | None:
    """Parse a number with either decimal mark, or return None.

    Spaces, apostrophes or the other mark may separate thousands. A single mark is the decimal
    mark.

    Parameters
    ----------
    text : str

    Returns
    -------
    float or None
    """
    digits = re.sub(r"[\s'’]", "", text).replace("−", "-")
    marks = re.sub(r"[^.,]", "", digits)
    if len(set(marks)) == 2 or len(marks) > 1:
        decimal_mark = marks[-1] if len(set(marks)) == 2 else ""
        group_mark = "." if decimal_mark == "," else "," if decimal_mark == "." else marks[0]
        integer_digits, _, decimals = (
            digits.rpartition(decimal_mark) if decimal_mark else (digits, "", "")
        )
        if not re.fullmatch(rf"[+-]?\d{{1,3}}(?:{re.escape(group_mark)}\d{{3}})+", integer_digits):
            return None
        digits = integer_digits.replace(group_mark, "") + "." + decimals
    try:
        value = float(digits.replace(",", "."))
    except ValueError:
        return None
    return value if isfinite(value) else None


def parse_quantity(text: str, unit: str) -> float | None:
    """Parse a number that may be followed by a unit, or return None.

    Parameters
    ----------
    text : str
        For example ``30`` or ``30 cm``.
    unit : str
        Unit of the returned number. Lengths in other units are converted to it.

    Returns
    -------
    float or None
        The number in `unit`; None if the text is not a number, or has a unit that cannot be
        converted.
    """
    match = _QUANTITY_PATTERN.fullmatch(text.strip())
    if match is None or not unit:
        return parse_number(text)
    number, typed_unit = parse_number(match[1]), match[2]
    if number is None or typed_unit == unit:
        return number
    if typed_unit in _METRES_PER_UNIT and unit in _METRES_PER_UNIT:
        return number * _METRES_PER_UNIT[typed_unit] / _METRES_PER_UNIT[unit]
    return None


def is_partial_quantity(text: str, unit: str) -> bool:
    """Return whether text is a number followed by the beginning of a unit of length.

    Parameters
    ----------
    text : str
    unit : str
        Unit of the field. The result is False if this is not a unit of length.

    Returns
    -------
    bool
    """
    match = _QUANTITY_PATTERN.fullmatch(text.strip())
    return (
        match is not None
        and unit in _METRES_PER_UNIT
        and parse_number(match[1]) is not None
        and any(name.startswith(match[2]) for name in _METRES_PER_UNIT)
    )


def parse_numbers(text: str) -> list[float] | None:
    """Parse several numbers, or return None if one of them is invalid.

    They are separated by semicolons, else by blanks, else by commas. If the separators are
    semicolons or blanks, a comma inside a number is the decimal mark.
    """
    text = text.strip().rstrip(";, ")
    if ";" in text:
        parts = text.split(";")
    elif re.search(r"\s", text):
        parts = re.split(r",?\s+", text)
    else:
        parts = text.split(",") if text else []
    numbers = [number for word in parts if (number := parse_number(word)) is not None]
    return numbers if len(numbers) == len(parts) else None
