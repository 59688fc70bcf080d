"""Small records that several tests make."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.document.kinds.trace import Trace
from vomstudio.document.records import Model, Registration

# A zigzag on a plane that dips, with a little roughness.
ZIGZAG = (
    (0.0, 0.0, 0.0),
    (1.0, 0.2, 0.51),
    (2.0, -0.1, 0.98),
    (2.5, 1.5, 1.27),
    (4.0, 1.2, 2.03),
)


def bed(id_: str, shift: float = 0.0, vertices: tuple | None = None) -> Trace:
    """A bedding trace on model m1."""
    points = vertices or tuple((x, y, z + shift) for x, y, z in ZIGZAG)
    return Trace(id_, "", "bedding", "m1", "0" * 64, points)


def placed(model: Model, matrix: Any) -> Model:
    """The model where a similarity (4, 4) from its file brings it, its frame as it was."""
    rows = tuple(tuple(float(v) for v in row) for row in np.asarray(matrix))
    return replace(model, placement=Registration("r1", "turned", "control", model.frame, rows))
