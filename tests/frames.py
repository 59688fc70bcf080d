"""Beds of known attitude, in any coordinate reference system, as clouds and tables."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pyproj import CRS, Transformer

Array = npt.NDArray[np.float64]
ZONE = "EPSG:32633"
ORIGIN = np.array([500_000.0, 5_094_000.0, 300.0])
"""On the central meridian of `ZONE`, 46 degrees north."""
DIP_DIRECTION_DEG, DIP_DEG = 60.0, 30.0
"""Attitude of `bed_points`."""


def bed_grid(
    dip_deg: float = 30.0, side_m: float = 20.0, step_m: float = 0.5, origin: Array = ORIGIN
) -> Array:
    """Return a square grid of points (n, 3) on a bed that dips to the east."""
    steps = np.arange(0.0, side_m, step_m)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    return origin + np.column_stack([x, y, -np.tan(np.radians(dip_deg)) * x])


def bed_points(count: int, seed: int, origin: Array = ORIGIN) -> Array:
    """Return points (count, 3) at random places of 40 m by 40 m, on a bed of 060/30."""
    x, y = np.random.default_rng(seed).uniform(0.0, 40.0, (2, count))
    azimuth, dip = np.radians([DIP_DIRECTION_DEG, DIP_DEG])
    z = -np.tan(dip) * (x * np.sin(azimuth) + y * np.cos(azimuth))
    return origin + np.column_stack([x, y, z])


def convert(points: Array, crs: str, zone: str = ZONE) -> Array:
    """Convert x and y of points (n, 3 k) from a metric zone; heights stay as they are."""
    flat = points.reshape(-1, 3)
    transformer = Transformer.from_crs(zone, crs, always_xy=True)
    x, y = transformer.transform(flat[:, 0], flat[:, 1])
    return np.column_stack([x, y, flat[:, 2]]).reshape(points.shape)


def write_prj(path: Path, crs: str, version: str = "WKT2_2019") -> None:
    """Write the CRS of a file beside it."""
    path.with_suffix(".prj").write_text(CRS.from_user_input(crs).to_wkt(version))


def write_cloud(path: Path, points: Array, crs: str | None) -> Path:
    """Write points as rows of x, y and z, with a .prj if there is a CRS."""
    np.savetxt(path, points, fmt="%.9f")
    if crs is not None:
        write_prj(path, crs)
    return path


def write_table(
    path: Path, rows: Iterable[Iterable[float | str]], crs: str | None, header: str = "x,y,z"
) -> Path:
    """Write rows below a header, with a .prj if there is a CRS."""
    lines = [
        ",".join(cell if isinstance(cell, str) else f"{cell:.9f}" for cell in row) for row in rows
    ]
    path.write_text("\n".join([header, *lines]) + "\n")
    if crs is not None:
        write_prj(path, crs)
    return path
