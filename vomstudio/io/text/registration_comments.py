"""What an orientation table says of the registrations of its models.

Our own tables state the covariance of each registration's rotation in a line of their `#` block;
other tables, and our own after another program has dropped that block, may have the column
`registration_error_deg` only. That is one half-angle for each row, from which the axis cannot be
told: the rotation is then taken as equally uncertain about all axes, and as its worst row says.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.common_rotation_errors import Turns, together
from vomstudio.geometry.rotation_errors import CHI2_TWO
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.tables import TextTable

MARK = "registration:"
"""First word of a comment with the covariance of a registration."""
_COLUMN = "registration_error_deg"
_MODEL = "model"


def turns_of_table(table: TextTable, kept: IntArray) -> Turns | None:
    """How the rows `kept` of a table turn with their registrations; None where nothing is said."""
    errors = _cells(table, _COLUMN, kept)
    models = _cells(table, _MODEL, kept) or [""] * len(kept)
    stated = _stated(table.comments)
    values = [math.nan] * len(kept) if errors is None else [_number(cell) for cell in errors]
    worst: dict[str, float] = {}
    for model, value in zip(models, values, strict=True):
        if value == value:
            worst[model] = max(worst.get(model, 0.0), value)
    rows: list[tuple[object, FloatArray | None]] = []
    for model, value in zip(models, values, strict=True):
        if model in stated and (errors is None or value == value):
            rows.append(stated[model])
        elif value == value:
            variance = math.radians(worst[model]) ** 2 / CHI2_TWO
            rows.append((("column", model), variance * np.eye(3)))
        else:
            rows.append((None, None))
    turns = together(rows)
    return turns if turns.known else None


def bowed_in(comments: Iterable[str]) -> float | None:
    """By how much dips differ from edge to edge of the worst bowed model, degrees; None where none
    is said to be bowed."""
    told = [each.get("bowed_deg") for each in registrations_in(comments)]
    found = [float(v) for v in told if isinstance(v, int | float) and 0.0 < v <= 180.0]
    return max(found) if found else None


def _stated(
    comments: Iterable[str],
) -> dict[str, tuple[object, FloatArray]]:
    """By the name of a model: which registration, and its covariance, radians squared."""
    found: dict[str, tuple[object, FloatArray]] = {}
    twice = set()
    for number, comment in enumerate(comments):
        for model, covariance in _registration(comment):
            twice |= {model} & found.keys()
            found[model] = ("stated", number), covariance
    # Two models of one name cannot be told apart by it.
    return {model: each for model, each in found.items() if model not in twice}


def _registration(comment: str) -> list[tuple[str, FloatArray]]:
    text = comment.lstrip("# \t")
    if not text.startswith(MARK):
        return []
    try:
        told = json.loads(text[len(MARK) :])
        covariance = np.array(told["rotation_covariance_deg2"], np.float64)
        models = [str(name) for name in told["models"]]
    except (ValueError, TypeError, KeyError):
        return []
    if covariance.shape != (3, 3) or not np.isfinite(covariance).all():
        return []
    covariance = 0.5 * (covariance + covariance.T)
    if np.linalg.eigvalsh(covariance)[0] < -1e-9 * abs(np.trace(covariance)):
        return []
    return [(model, covariance * math.radians(1.0) ** 2) for model in models]


def registrations_in(comments: Iterable[str]) -> list[dict[str, Any]]:
    """The same read back, of those that can be read."""
    return [
        json.loads(comment.lstrip("# \t")[len(MARK) :])
        for comment in comments
        if _registration(comment)
    ]


def _cells(table: TextTable, name: str, kept: IntArray) -> list[str] | None:
    if table.names is None:
        return None
    columns = [i for i, title in enumerate(table.names) if plain(title) == plain(name)]
    if len(columns) != 1:
        return None
    cells = table.cells(columns[0])
    return [cells[i] for i in kept]


def _number(cell: str) -> float:
    """Not a number for a cell that is none, and for what is no half-angle."""
    value = parse_number(cell, decimal_comma=True)
    return value if value is not None and 0.0 <= value <= 90.0 else math.nan
