"""Planes fitted to groups of points, as rows of the orientation table (`vomstudio fit`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Plane
from vomstudio.geology.plane_bands import PlaneBand, find_plane_band
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geology.quality import Verdict, judge
from vomstudio.geometry.plane_figures import Method
from vomstudio.geometry.planes import Axis, FittedPlane, fit_planes
from vomstudio.project.tables.orientation_table import Row, plane_rows

NO_METADATA: Mapping[str, Mapping[Any, str]] = MappingProxyType({})
_PROGRESS_STEP = 100
FRAME_AS_GIVEN = "as given"
"""Frame of points for which no frame is stated."""


@dataclass(frozen=True)
class FittedPlanes:
    """Planes fitted to groups of points.

    Parameters
    ----------
    rows : list of Row
        Rows of the orientation table.
    skipped : list of dict
        ``id`` and ``reason`` (a finding) of each group that has no plane.
    bands : mapping of PlaneBand
        Bands of planes compatible with straight groups, by group ID.
    warnings : list of tuple of Finding
        Reasons and notes of the verdict of each row.
    """

    rows: list[Row]
    skipped: list[dict[str, Any]]
    bands: Mapping[Any, PlaneBand]
    warnings: list[tuple[Finding, ...]]


def fitted_planes(
    ids: Sequence[Any],
    points: npt.ArrayLike,
    offsets: npt.ArrayLike,
    *,
    method: Method = "pca",
    axis: Axis = "auto",
    resolution_m: float | None = None,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    metadata: Mapping[str, Mapping[Any, str]] = NO_METADATA,
    progress: Progress | None = None,
) -> FittedPlanes:
    """Fit a plane to each group of points and judge it.

    Parameters
    ----------
    ids : sequence
        IDs of the groups.
    points : (n, 3) array_like
        Points in metres; group i is points[offsets[i]:offsets[i + 1]].
    offsets : (m + 1,) array_like of int
    method : Method, optional
        Criterion of the fit.
    axis : str
        Coordinate whose residuals a regression minimises. "auto" selects for each group the one
        nearest to the normal of its orthogonal least-squares plane.
    resolution_m : float or None
        Resolution of the model that contains the points, if known.
    thresholds : Thresholds
        Thresholds of the profile with which the planes are judged.
    metadata : mapping
        Further values of the groups, by table column and group ID.
    progress : Progress, optional
    """
    progress = progress or SilentProgress()
    progress.stage(tr("Fitting planes"))
    batch = fit_planes(points, offsets, method=method, axis=axis)
    fits = batch.rows()
    skipped_groups: list[dict[str, Any]] = []
    names: list[Any] = []
    used_fits: list[FittedPlane] = []
    verdicts: list[Verdict] = []
    bands: dict[Any, PlaneBand] = {}
    progress.stage(tr("Assessing planes"), len(fits))
    for index, (name, fit) in enumerate(zip(ids, fits, strict=True)):
        if index % _PROGRESS_STEP == 0:
            progress.step(index)
        if fit.error is not None:
            skipped_groups.append({"id": name, "reason": fit.error})
            continue
        band = find_plane_band(fit, resolution_m=resolution_m)
        if band is not None:
            bands[name] = band
        names.append(name)
        used_fits.append(fit)
        verdicts.append(
            judge(fit, resolution_m=resolution_m, outcrop_normal=None, thresholds=thresholds)
        )
    # Vectorised: processing single vectors takes a hundred times as long.
    planes = Plane.from_normals([fit.normal for fit in used_fits])
    rows = plane_rows(used_fits, verdicts, planes, resolution_m=resolution_m)
    for name, row in zip(names, rows, strict=True):
        row.update({column: values.get(name) or None for column, values in metadata.items()})
        row.update(id=name, frame=FRAME_AS_GIVEN)
    return FittedPlanes(rows, skipped_groups, bands, [verdict.warnings for verdict in verdicts])
