"""Where the (mean) planes of two groups meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import cause_of
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.common_rotation_errors import (
    Moved,
    Turns,
    meeting,
    moved,
    principal_axis,
    region,
    region_of_line,
)
from vomstudio.geology.intersections import (
    UncertainPlane,
    intersection_line,
    mean_plane,
    scatter_deg,
)
from vomstudio.geology.quality import judge_line
from vomstudio.geology.statistics import orientation_tensor
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject, degrees
from vomstudio.project.kind import (
    Kind,
    Lookup,
    NetLook,
    Sketch,
    half_way,
    is_picked_plane,
    planes_among,
)
from vomstudio.project.measurement import (
    Measurement,
    Measuring,
    Records,
    as_uncertain,
    nothing_measured,
)
from vomstudio.project.records import Feature, Group, Typed
from vomstudio.project.registration_errors import model_of, turns_of


@dataclass(frozen=True)
class Intersection(Typed):
    id: str
    name: str
    type_id: str
    first: Group
    second: Group
    set_name: str = ""
    notes: str = ""
    domain: str = ""


def members(records: Records, group: Group) -> list[Feature]:
    """The planes of a group, in the order of the records. Compass readings are no members of a
    group by type: they are another kind of evidence, to be compared, not pooled."""
    if group.feature_id:
        return planes_among(records, [group.feature_id])
    return [
        r
        for r in records.values()
        if isinstance(r, Typed)
        and r.type_id == group.type_id
        and (not group.set_name or r.set_name == group.set_name)
        and is_picked_plane(r)
    ]


def names(feature: Intersection) -> list[str]:
    return [g.feature_id for g in (feature.first, feature.second) if g.feature_id]


def below(records: Records, feature: Intersection) -> list[Feature]:
    return [*members(records, feature.first), *members(records, feature.second)]


def measure(at: Measuring, intersections: Sequence[Intersection]) -> list[Measurement]:
    return [_measure(at, intersection) for intersection in intersections]


def _measure(at: Measuring, feature: Intersection) -> Measurement:
    groups = [members(at.records, group) for group in (feature.first, feature.second)]
    measured = [[at.known[plane.id] for plane in group] for group in groups]
    means = []
    turned = []
    scatter = 0.0
    every = [plane for group in groups for plane in group if at.known[plane.id].plane is not None]
    turns = turns_of(model_of(at.records, plane) for plane in every)
    start = 0
    try:
        for own in measured:
            with_plane = [m for m in own if m.plane is not None]
            if len(with_plane) == 1:
                planes = [as_uncertain(with_plane[0])]
            else:
                # The error of a mean comes from the scatter; their own ones take time.
                planes = [UncertainPlane(_normal(m), None) for m in with_plane]
            sound = [plane for plane in planes if plane is not None]
            means.append(mean_plane(sound))
            scatter = max(scatter, scatter_deg(sound, means[-1]))
            rows = np.arange(start, start + len(with_plane))
            start += len(with_plane)
            turned.append(_turned(sound, turns.of(rows)))
        found = intersection_line(*means)
    except GeometryError as error:
        return nothing_measured(np.zeros((0, 3)), None, cause_of(error), kind="intersection")
    covariance = meeting(*turned).covariance()[0] if turns.known else None
    direction = found.line.vector()
    registration = None if covariance is None else region(direction, covariance).largest_deg
    total = region_of_line(
        direction,
        covariance,
        found.max_confidence95_deg,
        found.min_confidence95_deg,
        found.confidence_axis,
    )
    verdict = judge_line(
        None,
        confidence95_deg=None if total is None else total.largest_deg,
        scatter_deg=scatter,
        registration_deg=registration,
        thresholds=at.thresholds,
    )
    return Measurement(
        _ends(found.line.vector(), means, measured),
        None,
        None,
        None,
        verdict,
        None,
        line=found.line,
        max_confidence95_deg=found.max_confidence95_deg,
        min_confidence95_deg=found.min_confidence95_deg,
        confidence_axis=found.confidence_axis,
        angle_deg=found.angle_deg,
        kind="intersection",
        registration_error_deg=registration,
        total=total,
    )


def _turned(planes: list[UncertainPlane], turns: Turns) -> Moved:
    """The mean of a group's planes as their registrations move it."""
    normals = np.array([plane.normal for plane in planes])
    given = moved(normals, turns)
    if len(planes) == 1:
        return given
    return principal_axis(given, *orientation_tensor(normals), 0)


def _normal(measured: Measurement) -> FloatArray:
    """Of something that has a plane."""
    if measured.fit is not None:
        return measured.fit.normal
    assert measured.plane is not None
    return measured.plane.normal()


def _ends(
    direction: FloatArray, means: list[UncertainPlane], measured: list[list[Measurement]]
) -> FloatArray:
    """(2, 3) ends of a line as long as the longest of the planes, where the two planes through the
    middle of each group meet, or, where that is far away, midway between the groups."""
    extents = [m.fit.extent for own in measured for m in own if m.fit and m.fit.extent]
    centres = []
    for own in measured:
        placed = [m.fit.centroid if m.fit else m.points.mean(axis=0) for m in own if len(m.points)]
        if placed:
            centres.append(np.mean(placed, axis=0))
    if not extents or not centres:
        return np.zeros((0, 3))
    half = 0.5 * max(extents)
    middle = np.mean(centres, axis=0)
    if len(centres) == 2:
        rows = np.array([means[0].normal, means[1].normal])
        gaps = np.einsum("ij,ij->i", rows, np.array(centres) - middle)
        step = np.linalg.lstsq(rows, gaps, rcond=None)[0]
        apart = float(np.linalg.norm(centres[1] - centres[0]))
        if np.linalg.norm(step) <= half + apart:
            middle = middle + step
    return np.array([middle - half * direction, middle + half * direction])


def sketch(subject: Subject, measured: Lookup) -> Sketch | None:
    points = subject.measured.points
    if not len(points):
        return None
    middle = half_way(points)
    return Sketch(points, middle, sign=middle)


def words(measured: Measurement) -> list[str]:
    if measured.angle_deg is None:
        return []
    return [tr("Angle between the planes {angle}", angle=degrees(measured.angle_deg))]


KIND = Kind(
    name="intersection",
    order=50,
    record=Intersection,
    title=_("Intersection"),
    icon="vector-intersection",
    measure=measure,
    figures=(
        *of.NAMED,
        *of.LINE,
        *of.PLACE,
        of.ANGLE,
        *of.CONFIDENCE,
        of.REGISTRATION_ERROR,
        of.TOTAL,
        *of.VERDICT,
        of.FRAME,
        of.NOTES,
    ),
    attributes=(kind.NAME, kind.TYPE, kind.SET, kind.DOMAIN, kind.NOTES),
    sketch=sketch,
    parts={"first": Group, "second": Group},
    words=words,
    orientations=("line",),
    evidence="derived",
    names=names,
    below=below,
    regroups=True,
    net=NetLook(" (intersections)", "X"),
)
