"""The kinematic analysis of a slope at each of its facets: the facet's own dip direction and dip
are those of the face, as Menegoni et al. 2021 (An open-source algorithm for 3D rock slope kinematic
analysis, ROKA, Applied Sciences 11, 1698) take them place by place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane, planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import (
    SlopeFace,
    critical_lines,
    flexural_toppling,
    in_face_frame,
    intersections,
    pairs_of_sets,
    planar_sliding,
)
from vomstudio.geology.table_slopes import Face, set_numbers

MODES = ("planar", "wedge", "flexural_toppling", "direct_toppling")
_SAME = 1e-6
"""Sine of the angle between a face and a plane that is the same."""
VERTICAL_DEG = 85.0
"""A plane as steep as this may as well be that of a face which overhangs."""


@dataclass(frozen=True)
class FacetFace:
    """A facet as a slope. plane : its own; overhangs : the rock is above it, so that it faces the
    other way than its plane dips; None where that is not known; area_m2 : None where not known"""

    id: str
    plane: Plane
    area_m2: float | None = None
    overhangs: bool | None = None


@dataclass(frozen=True)
class Share:
    """critical of all `of` planes, or intersections; share : None of nothing"""

    critical: int
    of: int
    share: float | None


@dataclass(frozen=True)
class FacetSlope:
    """face : as it was taken: that of the facet, or a vertical one that faces the same way where
    the facet overhangs"""

    id: str
    face: Face
    overhangs: bool | None
    area_m2: float | None
    planar: Share
    wedge: Share
    flexural_toppling: Share
    direct_toppling: Share


@dataclass(frozen=True, repr=False)
class FacetSlopes(PrintableResult):
    """n : planes. left_out : lines of their table; skipped : facets that are no slope, each `id`
    and `reason`; convention, dropped_lines : of the planes' table as it was read"""

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
        """(facets,) shares of one of MODES, NaN of nothing."""
        found = [getattr(facet, mode).share for facet in self.facets]
        return np.array([np.nan if share is None else share for share in found], np.float64)


def facet_slopes(
    table: OrientationRows,
    faces: Sequence[FacetFace],
    options: SlopeOptions,
    progress: Progress | None = None,
) -> FacetSlopes:
    """Shares of planes, and of intersections of all pairs of them, that are critical at each facet,
    as `table_slope` has them for its attitude; but of planes that are the facets themselves, each
    facet's own is none. A facet without a dip direction is skipped. Raises
    GeometryError for a table without planes and where no facet is a slope."""
    report = progress or Silent()
    rows = np.flatnonzero(table.is_plane)
    if not len(rows):
        raise GeometryError(
            Finding("orientation.no-planes"),
            file=table.path,
            field="element",
        )
    slopes: list[tuple[FacetFace, SlopeFace]] = []
    skipped: list[dict[str, Any]] = []
    for facet in faces:
        try:
            plane = _faced(facet)
            slopes.append((facet, SlopeFace(plane, options)))
        except UsageError as error:
            skipped.append({"id": facet.id, "reason": cause_of(error)})
    if not slopes:
        raise GeometryError(Finding("slope.no-facet"))
    normals = planes_to_normals(table.dip_direction_deg[rows], table.dip_deg[rows])
    sets = set_numbers(table)
    plane_counts, pair_counts = _counts([slope for _, slope in slopes], normals, sets, report)
    place = {table.ids[row]: i for i, row in enumerate(rows)}
    facets = []
    for k, (facet, slope) in enumerate(slopes):
        own = place.get(facet.id)
        of = len(rows)
        if own is not None and _is_face(slope, normals[own]):
            _take_out(own, slope, normals, sets, plane_counts[k], pair_counts[k])
            of -= 1
        planar, flexural = (_share(int(count), of) for count in plane_counts[k])
        pairs = int(pair_counts[k, 0])
        wedge, topple = (_share(int(count), pairs) for count in pair_counts[k, 1:])
        plane = slope.plane
        face = Face(plane.dip_direction_deg, plane.dip_deg, plane.strike_rhr_deg)
        facets.append(
            FacetSlope(
                facet.id, face, facet.overhangs, facet.area_m2, planar, wedge, flexural, topple
            )
        )
    return FacetSlopes(
        n=len(rows),
        left_out=len(table) - len(rows),
        friction_deg=float(options.friction_deg),
        lateral_deg=float(options.lateral_deg),
        limits=options.limits,
        facets=tuple(facets),
        skipped=tuple(skipped),
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(*table.warnings, *_noticed([facet for facet, _ in slopes], len(skipped))),
    )


def _faced(facet: FacetFace) -> Plane:
    """The attitude of the slope. What overhangs is taken as vertical: all that comes out of a
    vertical face comes out of it too."""
    plane = facet.plane
    if not facet.overhangs or plane.undefined:
        return plane
    return Plane((plane.dip_direction_deg + 180.0) % 360.0, 90.0)


def _counts(
    slopes: Sequence[SlopeFace],
    normals: FloatArray,
    sets: IntArray | None,
    progress: Progress,
) -> tuple[IntArray, IntArray]:
    """(facets, 2) of planes: planar, flexural; (facets, 3) of pairs: all that meet, wedge,
    toppling."""
    plane_counts = np.zeros((len(slopes), 2), np.int64)
    pair_counts = np.zeros((len(slopes), 3), np.int64)
    progress.stage(tr("Analysing slopes"), max(pairs_of_sets(len(normals), sets), 1))
    for k, slope in enumerate(slopes):
        turned = in_face_frame(slope, normals)
        plane_counts[k] = (
            planar_sliding(slope, turned).critical.sum(),
            flexural_toppling(slope, turned).critical.sum(),
        )
    # The intersections are the same for all facets, so each is worked out once.
    done = 0
    for lines, sound, pairs in intersections(normals[None], sets):
        met = lines[0][sound[0]]
        pair_counts[:, 0] += len(met)
        pair_counts[:, 1:] += critical_lines(slopes, met)
        done += pairs.shape[1]
        progress.step(done)
    return plane_counts, pair_counts


def _is_face(slope: SlopeFace, normal: FloatArray) -> bool:
    """Whether an upward normal (3,) is that of the face itself."""
    return bool(np.linalg.norm(np.cross(normal, slope.plane.normal())) < _SAME)


def _take_out(
    own: int,
    slope: SlopeFace,
    normals: FloatArray,
    sets: IntArray | None,
    plane_counts: IntArray,
    pair_counts: IntArray,
) -> None:
    """Where the planes are the facets themselves, nothing comes out of a face on its own plane, nor
    along a line that lies in it: neither is counted. own : row of the facet in normals (n, 3)"""
    turned = in_face_frame(slope, normals[own][None])
    plane_counts -= np.array(
        [
            planar_sliding(slope, turned).critical.sum(),
            flexural_toppling(slope, turned).critical.sum(),
        ]
    )
    others = np.arange(len(normals)) != own
    if sets is not None and sets[own] >= 0:
        others &= sets != sets[own]
    lines = np.cross(normals[own], normals[others])
    length = np.linalg.norm(lines, axis=1)
    sound = length > math.radians(ANGLE_TOLERANCE_DEG)
    lines = lines[sound] / length[sound, None]
    lines[lines[:, 2] > 0] *= -1.0
    pair_counts[0] -= len(lines)
    pair_counts[1:] -= critical_lines([slope], lines)[0]


def _share(critical: int, of: int) -> Share:
    return Share(critical, of, critical / of if of else None)


def _noticed(facets: Sequence[FacetFace], skipped: int) -> list[Finding]:
    said = []
    if skipped:
        said.append(Finding("slope.horizontal-facets", count=skipped))
    unknown = sum(f.overhangs is None and f.plane.dip_deg >= VERTICAL_DEG for f in facets)
    if unknown:
        said.append(Finding("slope.vertical-facets", count=unknown))
    over = sum(bool(f.overhangs) for f in facets)
    if over:
        said.append(Finding("slope.overhanging-facets", count=over))
    return said
