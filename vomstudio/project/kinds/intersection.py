"""Intersection line of the (mean) planes of two groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import cause_finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.geology.common_rotation_errors import (
    RotationErrors,
    VectorsWithDerivatives,
    differentiate_vectors,
    intersect_planes,
    line_confidence_region,
    principal_axis,
    region,
)
from vomstudio.geology.intersections import (
    UncertainPlane,
    intersection_line,
    mean_plane,
    scatter_deg,
)
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.quality import judge_line
from vomstudio.geology.statistics import orientation_tensor
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import (
    Kind,
    Lookup,
    NetAppearance,
    Sketch,
    is_picked_plane,
    midpoint,
    select_plane_features,
)
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    Records,
    empty_measurement,
    plane_with_error,
)
from vomstudio.project.records import Feature, Group, TypedFeature
from vomstudio.project.registration_errors import get_model, get_rotation_errors


@dataclass(frozen=True)
class Intersection(TypedFeature):
    """Intersection line of the (mean) planes of two groups."""

    id: str
    name: str
    type_id: str
    first: Group
    second: Group
    set_name: str = ""
    notes: str = ""
    domain: str = ""


def members(records: Records, group: Group) -> list[Feature]:
    """Return the planes of a group, in the order of the records.

    Compass readings are not members of a group defined by type: they are independent evidence that
    is compared and not pooled.
    """
    if group.feature_id:
        return select_plane_features(records, [group.feature_id])
    return [
        record
        for record in records.values()
        if isinstance(record, TypedFeature)
        and record.type_id == group.type_id
        and (not group.set_name or record.set_name == group.set_name)
        and is_picked_plane(record)
    ]


def dependency_ids(feature: Intersection) -> list[str]:
    """Return the IDs of the features that define the groups; a group by type has none."""
    return [group.feature_id for group in (feature.first, feature.second) if group.feature_id]


def dependencies(records: Records, feature: Intersection) -> list[Feature]:
    """Return the planes in both groups."""
    return [*members(records, feature.first), *members(records, feature.second)]


def measure(
    context: MeasurementContext, intersections: Sequence[Intersection]
) -> list[Measurement]:
    """Measure intersections."""
    return [_measure(context, intersection) for intersection in intersections]


def _measure(context: MeasurementContext, feature: Intersection) -> Measurement:
    groups = [members(context.records, group) for group in (feature.first, feature.second)]
    measurements = [[context.known[plane.id] for plane in group] for group in groups]
    means = []
    moved_means = []
    scatter = 0.0
    planes_with_orientation = [
        plane for group in groups for plane in group if context.known[plane.id].plane is not None
    ]
    rotation_errors = get_rotation_errors(
        get_model(context.records, plane) for plane in planes_with_orientation
    )
    start = 0
    try:
        for group in measurements:
            planar_group = [measurement for measurement in group if measurement.plane is not None]
            if len(planar_group) == 1:
                planes = [plane_with_error(planar_group[0])]
            else:
                # The error of a mean is computed from the scatter; computing the errors of its
                # planes would take too long.
                planes = [
                    UncertainPlane(_fit_normal(measurement), None) for measurement in planar_group
                ]
            usable_planes = [plane for plane in planes if plane is not None]
            means.append(mean_plane(usable_planes))
            scatter = max(scatter, scatter_deg(usable_planes, means[-1]))
            rows = np.arange(start, start + len(planar_group))
            start += len(planar_group)
            moved_means.append(_registered_mean(usable_planes, rotation_errors.of(rows)))
        intersection = intersection_line(*means)
    except GeometryError as error:
        return empty_measurement(np.zeros((0, 3)), None, cause_finding(error), kind="intersection")
    covariance = (
        intersect_planes(*moved_means).covariance()[0] if rotation_errors.has_known_errors else None
    )
    direction = intersection.line.vector()
    registration = None if covariance is None else region(direction, covariance).largest_deg
    total_region = line_confidence_region(
        direction,
        covariance,
        intersection.max_confidence95_deg,
        intersection.min_confidence95_deg,
        intersection.confidence_axis,
    )
    verdict = judge_line(
        None,
        confidence95_deg=None if total_region is None else total_region.largest_deg,
        scatter_deg=scatter,
        registration_deg=registration,
        thresholds=context.thresholds,
    )
    return Measurement(
        _ends(intersection.line.vector(), means, measurements),
        None,
        None,
        None,
        verdict,
        None,
        line=intersection.line,
        max_confidence95_deg=intersection.max_confidence95_deg,
        min_confidence95_deg=intersection.min_confidence95_deg,
        confidence_axis=intersection.confidence_axis,
        angle_deg=intersection.angle_deg,
        kind="intersection",
        registration_error_deg=registration,
        total=total_region,
    )


def _registered_mean(
    planes: list[UncertainPlane], rotation_errors: RotationErrors
) -> VectorsWithDerivatives:
    """Return the mean plane of a group with its derivatives by the rotation errors."""
    normals = np.array([plane.normal for plane in planes])
    moved_normals = differentiate_vectors(normals, rotation_errors)
    if len(planes) == 1:
        return moved_normals
    return principal_axis(moved_normals, *orientation_tensor(normals), 0)


def _fit_normal(measurement: Measurement) -> FloatArray:
    if measurement.fit is not None:
        return measurement.fit.normal
    assert measurement.plane is not None
    return measurement.plane.normal()


def _ends(
    direction: FloatArray, means: list[UncertainPlane], measured_lists: list[list[Measurement]]
) -> FloatArray:
    """Return the ends (2, 3) of the intersection, which is as long as the longest plane.

    The line passes through the intersection of the planes through the centres of the groups or, if
    that is far away, midway between the groups. The result is (0, 3) if no plane has an extent.
    """
    extents = [
        measurement.fit.extent
        for group in measured_lists
        for measurement in group
        if measurement.fit and measurement.fit.extent
    ]
    centres = []
    for group in measured_lists:
        positions = [
            measurement.fit.centroid if measurement.fit else measurement.points.mean(axis=0)
            for measurement in group
            if len(measurement.points)
        ]
        if positions:
            centres.append(np.mean(positions, axis=0))
    if not extents or not centres:
        return np.zeros((0, 3))
    half_length = 0.5 * max(extents)
    centre = np.mean(centres, axis=0)
    if len(centres) == 2:
        rows = np.array([means[0].normal, means[1].normal])
        gaps = np.einsum("ij,ij->i", rows, np.array(centres) - centre)
        step = np.linalg.lstsq(rows, gaps, rcond=None)[0]
        separation = float(np.linalg.norm(centres[1] - centres[0]))
        if np.linalg.norm(step) <= half_length + separation:
            centre = centre + step
    return np.array([centre - half_length * direction, centre + half_length * direction])


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of an intersection, or None if its position is unknown."""
    points = subject.measured.points
    if not len(points):
        return None
    centre = midpoint(points)
    return Sketch(points, centre, sign=centre)


def words(measured: Measurement) -> list[str]:
    """Describe the angle between the two planes."""
    if measured.angle_deg is None:
        return []
    return [tr("Angle between the planes {angle}", angle=format_error_deg(measured.angle_deg))]


KIND = Kind(
    name="intersection",
    order=50,
    record=Intersection,
    title=_("Intersection"),
    icon="vector-intersection",
    measure=measure,
    figures=(
        *of.NAME_FIGURES,
        *of.LINE,
        *of.PLACE,
        of.ANGLE,
        *of.CONFIDENCE,
        of.REGISTRATION_ERROR,
        of.TOTAL_ERROR,
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
    dependency_ids=dependency_ids,
    dependencies=dependencies,
    has_dynamic_dependencies=True,
    net=NetAppearance(" (intersections)", "X"),
)
