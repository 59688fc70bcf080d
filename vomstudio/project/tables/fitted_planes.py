"""Planes fitted to groups of points, as rows of the orientation table (`vomstudio fit`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy.typing as npt

from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Plane
from vomstudio.geology.plane_bands import PlaneBand, find_plane_band
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geology.quality import judge
from vomstudio.geometry.plane_figures import Method
from vomstudio.geometry.planes import Axis, fit_planes
from vomstudio.project.tables.orientation_table import Row, plane_row

NO_METADATA: Mapping[str, Mapping[Any, str]] = MappingProxyType({})
_PROGRESS_STEP = 100
FRAME_AS_GIVEN = "as given"
"""Frame of points that do not state one."""


@dataclass(frozen=True)
class FittedPlanes:
    """Planes of groups of points.

    Parameters
    ----------
    rows : list of Row
        Rows of the orientation table.
    skipped : list of dict
        ``id`` and ``reason`` (a finding) of each group without a plane.
    bands : mapping of PlaneBand
        Bands of the planes that a straight group allows, by its id.
    """

    rows: list[Row]
    skipped: list[dict[str, Any]]
    bands: Mapping[Any, PlaneBand]


def fitted_planes(
    ids: Sequence[Any],
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    thresholds: Thresholds = DEFAULTS,
    metadata: Mapping[str, Mapping[Any, str]] = NO_METADATA,
    progress: Progress | None = None,
) -> FittedPlanes:
    """Fit and judge a plane to each group of points.

    Parameters
    ----------
    ids : sequence
        Ids of the groups.
    points : (n, 3) array_like
        Metres; group i is points[offsets[i]:offsets[i + 1]].
    offsets : (m + 1,) array_like of int
    method : Method, optional
        Criterion of the fit.
    axis : str
        Coordinate that a regression minimises; "auto" takes for each group the one nearest the
        normal of its orthogonal least squares plane.
    resolution_m : float or None
        Resolution of the model of the points, if known.
    thresholds : Thresholds
        Thresholds of the profile by which the planes are judged.
    metadata : mapping
        Further values of the groups, by column of the table and by id.
    progress : Progress, optional
    """
    progress = progress or Silent()
    progress.stage(tr("Fitting planes"))
    batch = fit_planes(points, offsets, method=method, axis=axis)
    fits = batch.rows()
    rows: list[Row] = []
    skipped: list[dict[str, Any]] = []
    bands: dict[Any, PlaneBand] = {}
    # Vectorised: single vectors take a hundred times as long.
    planes = iter(Plane.from_normals([fit.normal for fit in fits if fit.error is None]))
    progress.stage(tr("Judging planes"), len(fits))
    for number, (name, fit) in enumerate(zip(ids, fits, strict=True)):
        if number % _PROGRESS_STEP == 0:
            progress.step(number)
        if fit.error is not None:
            skipped.append({"id": name, "reason": fit.error})
            continue
        band = find_plane_band(fit, resolution_m=resolution_m)
        if band is not None:
            bands[name] = band
        verdict = judge(fit, resolution_m=resolution_m, outcrop_normal=None, thresholds=thresholds)
        extra: dict[str, Any] = {
            column: values.get(name) or None for column, values in metadata.items()
        }
        rows.append(
            plane_row(
                fit,
                verdict,
                id=name,
                frame=FRAME_AS_GIVEN,
                resolution_m=resolution_m,
                plane=next(planes),
                **extra,
            )
        )
    return FittedPlanes(rows, skipped, bands)
