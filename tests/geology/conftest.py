"""The second library, and the real folds, that the geology is held against."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.fixture(scope="session")
def mplstereonet() -> Any:
    with warnings.catch_warnings():
        # It overrides Axes.cla, which matplotlib means to drop; nothing of ours.
        warnings.simplefilter("ignore")
        import mplstereonet as library
    return library


@pytest.fixture(scope="session")
def big_elk(data_dir: Path) -> tuple[np.ndarray, np.ndarray]:
    """Dip directions and dips of 61 beds of the Big Elk anticline."""
    table = np.loadtxt(data_dir / "planes" / "big_elk_strike_dip.txt")
    return (table[:, 0] + 90.0) % 360.0, table[:, 1]
