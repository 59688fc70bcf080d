"""Common attitude of parallel beds, fitted to their traces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.geology.beds.parallel import ParallelBeds, parallel_beds


def fit_common_bed(traces: Sequence[npt.ArrayLike]) -> ParallelBeds:
    """Fit the common attitude of parallel beds to their traces.

    Parameters
    ----------
    traces : sequence of (n, 3) array_like
        Points of each trace in the World frame, m.

    Returns
    -------
    ParallelBeds

    Raises
    ------
    GeometryError
        If there are fewer than two traces, or if they do not determine a plane.
    """
    arrays = [np.atleast_2d(np.asarray(trace, np.float64)) for trace in traces]
    offsets = np.concatenate([[0], np.cumsum([len(array) for array in arrays])])
    names = [str(i) for i in range(len(arrays))]
    return parallel_beds(names, np.concatenate(arrays), offsets)
