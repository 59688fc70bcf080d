"""Kinematic analysis of a slope in which each facet in turn is the slope face.

Menegoni et al. 2021 (An open-source algorithm for 3D rock slope kinematic analysis, ROKA, Applied
Sciences 11, 1698) use local slope faces in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane, planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import (
    SlopeFace,
    count_critical_lines,
    count_pairs_between_sets,
    flexural_toppling,
    intersections,
    planar_sliding,
    to_face_frame,
)
from vomstudio.geology.table_slopes import SlopeAttitude, set_numbers

MODES = ("planar", "wedge", "flexural_toppling", "direct_toppling")
MAX_PARALLEL_SINE = 1e-6
"""Sine of the angle to the face below which a plane is considered to be the face itself."""
MIN_VERTICAL_DEG = 85.0
"""Minimum dip of a plane that may belong to an overhanging face."""


@dataclass(frozen=True)
class FacetFace:
    """Facet that is analysed as a slope face.

    Attributes
    ----------
    plane : Plane
        Plane of the facet.
    area_m2 : float or None
        Area in m2; None if unknown.
    overhangs : bool or None
        True if the rock lies above the facet, which then faces away from its dip direction; None if
        unknown.
    """

    id: str
    plane: Plane
    area_m2: float | None = None
    overhangs: bool | None = None


@dataclass(frozen=True)
class CriticalShare:
    """Number of critical planes or intersections out of a total `of`.

    `share` is undefined (None) if `of` is 0.
    """

    critical: int
    of: int
    share: float | None


@dataclass(frozen=True)
class FacetSlope:
    """Kinematic analysis of a single facet.

    `face` is the plane of the facet, or a vertical plane that faces the same way if the facet
    overhangs.
    """

    id: str
    face: SlopeAttitude
    overhangs: bool | None
    area_m2: float | None
    planar: CriticalShare
    wedge: CriticalShare
    flexural_toppling: CriticalShare
    direct_toppling: CriticalShare


@dataclass(frozen=True, repr=False)
class FacetSlopes(PrintableResult):
    """Kinematic analysis of all facets.

    Attributes
    ----------
    n : int
        Number of planes.
    left_out : int
        Number of rows of the table that were not used.
    skipped : tuple of dict
        `id` and `reason` of the facets that are not analysed as a slope.
    convention, dropped_lines
        Convention and dropped lines of the table of planes.
    """

    n: int
    left_out: int
    friction_deg: float
    lateral_deg: float
    limits: str
    facets: tuple[FacetSlope, ...]
    skipped: tuple[dict[str, Any], ...]
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]

    def shares(self, mode: str) -> FloatArray:
        """Return the critical shares (facets,) of one of MODES; NaN if there are no planes."""
        fractions = [getattr(facet, mode).share for facet in self.facets]
        return np.array([np.nan if share is None else share for share in fractions], np.float64)


def facet_slopes(
    table: OrientationRows,
    faces: Sequence[FacetFace],
    options: SlopeOptions,
    progress: Progress | None = None,
) -> FacetSlopes:
    """Compute the shares of planes and intersections that are critical at each facet.

    The analysis is that of `table_slope`. If the planes are the facets themselves, the plane of a
    facet is ignored in its own analysis. Facets without a dip direction are skipped.

    Parameters
    ----------
    table : OrientationRows
    faces : sequence of FacetFace
    options : SlopeOptions
    progress : Progress, optional

    Returns
    -------
    FacetSlopes

    Raises
    ------
    GeometryError
        If the table has no planes, or if no facet can be analysed as a slope.
    """
    report = progress or SilentProgress()
    rows = np.flatnonzero(table.is_plane)
    if not len(rows):
        raise GeometryError(
            Finding("orientation.no-planes"),
            file=table.path,
            field="element",
        )
    slopes: list[tuple[FacetFace, SlopeFace]] = []
    skipped_facets: list[dict[str, Any]] = []
    for facet in faces:
        try:
            plane = _slope_plane(facet)
            slopes.append((facet, SlopeFace(plane, options)))
        except UsageError as error:
            skipped_facets.append({"id": facet.id, "reason": cause_finding(error)})
    if not slopes:
        raise GeometryError(Finding("slope.no-facet"))
    normals = planes_to_normals(table.dip_direction_deg[rows], table.dip_deg[rows])
    sets = set_numbers(table)
    plane_counts, pair_counts = _count_critical(
        [slope for _, slope in slopes], normals, sets, report
    )
    rows_by_id = {table.ids[row]: i for i, row in enumerate(rows)}
    facets = []
    for k, (facet, slope) in enumerate(slopes):
        facet_row = rows_by_id.get(facet.id)
        n_planes = len(rows)
        if facet_row is not None and _is_face(slope, normals[facet_row]):
            _exclude_own_plane(facet_row, slope, normals, sets, plane_counts[k], pair_counts[k])
            n_planes -= 1
        planar_share, flexural_share = (
            _critical_share(int(count), n_planes) for count in plane_counts[k]
        )
        n_pairs = int(pair_counts[k, 0])
        wedge_share, toppling_share = (
            _critical_share(int(count), n_pairs) for count in pair_counts[k, 1:]
        )
        plane = slope.plane
        face = SlopeAttitude(plane.dip_direction_deg, plane.dip_deg, plane.strike_rhr_deg)
        facets.append(
            FacetSlope(
                facet.id,
                face,
                facet.overhangs,
                facet.area_m2,
                planar_share,
                wedge_share,
                flexural_share,
                toppling_share,
            )
        )
    return FacetSlopes(
        n=len(rows),
        left_out=len(table) - len(rows),
        friction_deg=float(options.friction_deg),
        lateral_deg=float(options.lateral_deg),
        limits=options.limits,
        facets=tuple(facets),
        skipped=tuple(skipped_facets),
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(*table.warnings, *_warnings([facet for facet, _ in slopes], len(skipped_facets))),
    )


def _slope_plane(facet: FacetFace) -> Plane:
    """Return the slope plane of a facet; an overhanging facet is treated as vertical.

    Everything that can slide out of a vertical face can also slide out of an overhang.
    """
    plane = facet.plane
    if not facet.overhangs or plane.undefined:
        return plane
    return Plane((plane.dip_direction_deg + 180.0) % 360.0, 90.0)


def _count_critical(
    slopes: Sequence[SlopeFace],
    normals: FloatArray,
    sets: IntArray | None,
    progress: Progress,
) -> tuple[IntArray, IntArray]:
    """Count the critical planes and pairs of planes for each facet.

    The columns for planes (facets, 2) are planar sliding and flexural toppling; the columns for
    pairs (facets, 3) are all pairs, wedge sliding and direct toppling.
    """
    plane_counts = np.zeros((len(slopes), 2), np.int64)
    pair_counts = np.zeros((len(slopes), 3), np.int64)
    progress.stage(tr("Analysing slopes"), max(count_pairs_between_sets(len(normals), sets), 1))
    for k, slope in enumerate(slopes):
        local_normals = to_face_frame(slope, normals)
        plane_counts[k] = (
            planar_sliding(slope, local_normals).critical.sum(),
            flexural_toppling(slope, local_normals).critical.sum(),
        )
    # The intersections do not depend on the facet, so each is computed only once.
    done_count = 0
    for lines, is_valid, pairs in intersections(normals[None], sets):
        intersection_lines = lines[0][is_valid[0]]
        pair_counts[:, 0] += len(intersection_lines)
        pair_counts[:, 1:] += count_critical_lines(slopes, intersection_lines)
        done_count += pairs.shape[1]
        progress.step(done_count)
    return plane_counts, pair_counts


def _is_face(slope: SlopeFace, normal: FloatArray) -> bool:
    """Return whether an upward normal (3,) is that of the slope face itself."""
    return bool(np.linalg.norm(np.cross(normal, slope.plane.normal())) < MAX_PARALLEL_SINE)


def _exclude_own_plane(
    facet_row: int,
    slope: SlopeFace,
    normals: FloatArray,
    sets: IntArray | None,
    plane_counts: IntArray,
    pair_counts: IntArray,
) -> None:
    """Subtract the plane of a facet and its intersections from the counts.

    Nothing can slide out of a face along its own plane or along a line within it.
    """
    local_normals = to_face_frame(slope, normals[facet_row][None])
    plane_counts -= np.array(
        [
            planar_sliding(slope, local_normals).critical.sum(),
            flexural_toppling(slope, local_normals).critical.sum(),
        ]
    )
    is_other_plane = np.arange(len(normals)) != facet_row
    if sets is not None and sets[facet_row] >= 0:
        is_other_plane &= sets != sets[facet_row]
    lines = np.cross(normals[facet_row], normals[is_other_plane])
    length = np.linalg.norm(lines, axis=1)
    is_valid = length > math.radians(ANGLE_TOLERANCE_DEG)
    lines = lines[is_valid] / length[is_valid, None]
    lines[lines[:, 2] > 0] *= -1.0
    pair_counts[0] -= len(lines)
    pair_counts[1:] -= count_critical_lines([slope], lines)[0]


def _critical_share(critical_count: int, total_count: int) -> CriticalShare:
    return CriticalShare(
        critical_count, total_count, critical_count / total_count if total_count else None
    )


def _warnings(facets: Sequence[FacetFace], skipped_count: int) -> list[Finding]:
    warnings = []
    if skipped_count:
        warnings.append(Finding("slope.horizontal-facets", count=skipped_count))
    n_undetermined = sum(
        facet.overhangs is None and facet.plane.dip_deg >= MIN_VERTICAL_DEG for facet in facets
    )
    if n_undetermined:
        warnings.append(Finding("slope.vertical-facets", count=n_undetermined))
    n_overhanging = sum(bool(facet.overhangs) for facet in facets)
    if n_overhanging:
        warnings.append(Finding("slope.overhanging-facets", count=n_overhanging))
    return warnings
