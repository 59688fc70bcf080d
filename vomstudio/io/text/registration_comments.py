"""Registration errors stated in an orientation table.

Tables of this program state the covariance of the rotation of each registration in a line of their
`#` comment block. Other tables, or tables without that block, may have a column
`registration_error_deg`. This column contains one half-angle per row and does not determine the
axis, so the rotation is assumed to be equally uncertain about all axes, with the largest error of
any row of the model.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.common_rotation_errors import RotationErrors, group_rotation_errors
from vomstudio.geometry.rotation_errors import CHI2_TWO
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.rows import parse_number
from vomstudio.io.text.tables import TextTable

REGISTRATION_PREFIX = "registration:"
"""First word of a comment that contains the covariance of a registration."""
_ERROR_COLUMN = "registration_error_deg"
_MODEL_COLUMN = "model"


def table_rotation_errors(table: TextTable, rows: IntArray) -> RotationErrors | None:
    """Return the rotation errors of selected rows of a table, or None if not stated."""
    errors = _cells(table, _ERROR_COLUMN, rows)
    models = _cells(table, _MODEL_COLUMN, rows) or [""] * len(rows)
    stated_covariances = _stated_covariances(table.comments)
    values = [math.nan] * len(rows) if errors is None else [_number(cell) for cell in errors]
    max_error_deg: dict[str, float] = {}
    for model, value in zip(models, values, strict=True):
        if value == value:
            max_error_deg[model] = max(max_error_deg.get(model, 0.0), value)
    row_errors: list[tuple[object, FloatArray | None]] = []
    for model, value in zip(models, values, strict=True):
        if model in stated_covariances and (errors is None or value == value):
            row_errors.append(stated_covariances[model])
        elif value == value:
            variance = math.radians(max_error_deg[model]) ** 2 / CHI2_TWO
            row_errors.append((("column", model), variance * np.eye(3)))
        else:
            row_errors.append((None, None))
    rotations = group_rotation_errors(row_errors)
    return rotations if rotations.has_known_errors else None


def stated_bowing_deg(comments: Iterable[str]) -> float | None:
    """Return the bowing of the most strongly bowed model, or None if not stated.

    The bowing is the difference in dip between opposite edges, in degrees.
    """
    values = [item.get("bowed_deg") for item in stated_registrations(comments)]
    angles = [
        float(value) for value in values if isinstance(value, int | float) and 0.0 < value <= 180.0
    ]
    return max(angles) if angles else None


def _stated_covariances(
    comments: Iterable[str],
) -> dict[str, tuple[object, FloatArray]]:
    """Return an ID of the registration and its rotation covariance by model name.

    The covariances (3, 3) are in radians squared. Names that occur repeatedly are omitted.
    """
    stated_covariances: dict[str, tuple[object, FloatArray]] = {}
    repeated_labels = set()
    for index, comment in enumerate(comments):
        for model, covariance in _parse_registration(comment):
            repeated_labels |= {model} & stated_covariances.keys()
            stated_covariances[model] = ("stated", index), covariance
    # Models with the same name cannot be distinguished.
    return {
        model: item for model, item in stated_covariances.items() if model not in repeated_labels
    }


def _parse_registration(comment: str) -> list[tuple[str, FloatArray]]:
    text = comment.lstrip("# \t")
    if not text.startswith(REGISTRATION_PREFIX):
        return []
    try:
        statement = json.loads(text[len(REGISTRATION_PREFIX) :])
        covariance = np.array(statement["rotation_covariance_deg2"], np.float64)
        models = [str(name) for name in statement["models"]]
    except (ValueError, TypeError, KeyError):
        return []
    if covariance.shape != (3, 3) or not np.isfinite(covariance).all():
        return []
    covariance = 0.5 * (covariance + covariance.T)
    if np.linalg.eigvalsh(covariance)[0] < -1e-9 * abs(np.trace(covariance)):
        return []
    return [(model, covariance * math.radians(1.0) ** 2) for model in models]


def stated_registrations(comments: Iterable[str]) -> list[dict[str, Any]]:
    """Return the valid registrations in comments."""
    return [
        json.loads(comment.lstrip("# \t")[len(REGISTRATION_PREFIX) :])
        for comment in comments
        if _parse_registration(comment)
    ]


def _cells(table: TextTable, name: str, rows: IntArray) -> list[str] | None:
    if table.names is None:
        return None
    columns = [
        i for i, title in enumerate(table.names) if normalise_name(title) == normalise_name(name)
    ]
    if len(columns) != 1:
        return None
    cells = table.cells(columns[0])
    return [cells[i] for i in rows]


def _number(cell: str) -> float:
    """Return a half-angle in degrees, or NaN if the cell does not contain one."""
    value = parse_number(cell, decimal_comma=True)
    return value if value is not None and 0.0 <= value <= 90.0 else math.nan
