"""What of a benchmark lies opposite the points of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Opposite:
    """distance : (n,) signed, positive on the side to which the benchmark's normals point; NaN of
        places that are not finite
    beside : (n,) how far beyond the benchmark's edge a place lies, along its surface
    normal : (n, 3) unit normals of the benchmark there
    """

    distance: Array
    beside: Array
    normal: Array
