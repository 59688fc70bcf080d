"""Planes fitted to groups of points, as rows of the orientation table: what `vomstudio fit`
prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.geology.quality import judge
from vomstudio.geometry.plane_figures import Method
from vomstudio.geometry.planes import Axis, PlaneFit, fit_planes
from vomstudio.tables.orientation_table import Row, plane_row

AS_GIVEN = "as given"
"""The frame of points that name none."""

_AXES: tuple[Axis, Axis, Axis] = ("x", "y", "z")


@dataclass(frozen=True)
class FittedPlanes:
    """rows : of the orientation table; skipped : id and reason of each group without a plane"""

    rows: list[Row]
    skipped: list[dict[str, str]]


def fitted_planes(
    ids: Sequence[Any],
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis | Literal["auto"] = "z",
    resolution_m: float | None = None,
) -> FittedPlanes:
    """Fit and judge a plane to each group of points.

    points : (n, 3), m; group i is points[offsets[i]:offsets[i + 1]] and is called ids[i]
    axis : the coordinate that a regression minimises; "auto" takes for each group the one that is
        nearest the normal of its plane by least squares of distances
    resolution_m : of the model that the points were taken from, where it is known
    """
    rows: list[Row] = []
    skipped: list[dict[str, str]] = []
    for name, fit in zip(ids, _fits(points, offsets, method, axis), strict=True):
        if fit.error is not None:
            skipped.append({"id": name, "reason": fit.error})
            continue
        verdict = judge(fit, resolution_m=resolution_m, outcrop_normal=None)
        rows.append(plane_row(fit, verdict, id=name, frame=AS_GIVEN, resolution_m=resolution_m))
    return FittedPlanes(rows, skipped)


def _fits(
    points: npt.ArrayLike, offsets: npt.ArrayLike, method: Method, axis: Axis | Literal["auto"]
) -> list[PlaneFit]:
    if method != "regression" or axis != "auto":
        fits = fit_planes(points, offsets, method=method, axis="z" if axis == "auto" else axis)
        return fits.rows()
    upright = fit_planes(points, offsets)
    steepest = np.abs(np.nan_to_num(upright.normal)).argmax(axis=1)
    by_axis = [fit_planes(points, offsets, method=method, axis=each) for each in _AXES]
    return [by_axis[int(k)][i] for i, k in enumerate(steepest)]
