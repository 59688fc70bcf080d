"""Optional fields for the errors of points and directions."""

from __future__ import annotations

import math

from PySide6.QtWidgets import QLineEdit

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.ui.base.numbers import parse_number


def error_field(name: str, empty_text: str, tooltip: str) -> QLineEdit:
    """Create a field for an error.

    Parameters
    ----------
    empty_text : str
        Placeholder of the empty field.
    """
    field = QLineEdit()
    field.setObjectName(name)
    field.setPlaceholderText(empty_text)
    field.setToolTip(tooltip)
    return field


def read_number(field: QLineEdit, code: str) -> float | None:
    """Return the number in a field, or None if the field is empty.

    Parameters
    ----------
    code : str
        Code of the finding about a text that is not a non-negative number.

    Raises
    ------
    InputError
        If the text is not such a number.
    """
    text = field.text().strip()
    if not text:
        return None
    value = parse_number(text)
    if value is None or not 0.0 <= value < math.inf:
        raise InputError(Finding(code, text=text))
    return value
