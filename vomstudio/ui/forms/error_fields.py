"""Fields for the errors of points and directions, which may stay empty."""

from __future__ import annotations

import math
from collections.abc import Iterable

from PySide6.QtWidgets import QLineEdit

from vomstudio.document.measurement import Measurement
from vomstudio.errors import InputError
from vomstudio.ui.common.vertex_table import parse_number

_OF_ANY_PLACE = 1.0 / math.sqrt(12.0)
"""Standard deviation of what lies anywhere within a length of 1."""


def error_field(name: str, empty: str, tip: str) -> QLineEdit:
    """empty : what it says while nothing was typed"""
    field = QLineEdit()
    field.setObjectName(name)
    field.setPlaceholderText(empty)
    field.setToolTip(tip)
    return field


def number_in(field: QLineEdit, otherwise: str) -> float | None:
    """None where it is empty. Raises InputError, with the sentence `otherwise`, for what is no
    number of 0 or more."""
    text = field.text().strip()
    if not text:
        return None
    value = parse_number(text)
    if value is None or not 0.0 <= value < math.inf:
        raise InputError(otherwise)
    return value


def scatter_of(measured: Iterable[Measurement]) -> float:
    """The likely standard deviation of a point picked on these features, metres: the largest
    scatter about a plane of theirs, or what the resolution of their models leaves, which is up to
    half of it to either side; 0 where nothing is known."""
    known = [0.0]
    for each in measured:
        known.append((each.resolution_m or 0.0) * _OF_ANY_PLACE)
        known.append((each.fit.rms or 0.0) if each.fit is not None else 0.0)
    return max(known)
