"""The rotation that tests of registrations share, and a record with all of its fields."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import (
    NorthReference,
    ObservationGroup,
    Registration,
    RegistrationPoint,
)

Array = npt.NDArray[np.float64]
TURN = Rotation.from_euler("zyx", [130.0, 12.0, -7.0], degrees=True).as_matrix()


def similarity(scale: float, turn: Array, shift: Array) -> Array:
    """Return the (4, 4) matrix of a scale, a rotation and a shift."""
    rows = np.eye(4)
    rows[:3, :3], rows[:3, 3] = scale * turn, shift
    return rows


def rows_of(array: Array) -> Any:
    """Return the rows as records contain them."""
    return tuple(map(tuple, array.tolist()))


def registration(**more: Any) -> Registration:
    """Return a registration by points with all of its fields, some of them replaced."""
    rng = np.random.default_rng(4)
    root = rng.normal(size=(7, 7)) * 1e-3
    point = RegistrationPoint(
        "P1", (1.0, 2.0, 3.0), (4e5 + 1, 5e6, 320.5), (0.01, -0.02, 0.0), (0.01, 0.01, 0.03), True
    )
    values: dict[str, Any] = {
        "matrix": rows_of(similarity(2.5, TURN, np.array([4e5, 5e6, 320.0]))),
        "rotation_error_deg": (0.1, 0.2, 0.3),
        "scale_error": 1.3e-3,
        "rms_control_m": 0.011,
        "control": (point,),
        "covariance": rows_of(root @ root.T),
        "centre": (4e5 + 3.0, 5e6 - 4.0, 321.0),
        "reach_m": 12.0,
        "normal": (0.0, -1.0, 0.0),
        "lens_bowing95_deg": 0.4,
        "read_north": NorthReference("magnetic", 3.2, 3.5, day="2024-05-12", doubt_deg=0.5),
        "observations": (
            ObservationGroup("points", ("P1", "Ünkel")),
            ObservationGroup("lengths", ("A - B",)),
        ),
    }
    return Registration(
        "registration-1", "points on cliff", "points", Frame("crs", "EPSG:32633"), **values | more
    )
