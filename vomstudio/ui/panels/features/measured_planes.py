"""Collection of the planes of features, for comparison with other planes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from vomstudio.geology.model_agreement import OrientedPlane
from vomstudio.project import catalogue
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, TypedFeature
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio


def measured_planes(studio: Studio, features: Sequence[Feature]) -> list[OrientedPlane]:
    """Collect the planes of project features; features without a plane are omitted."""
    measurements: Mapping[str, Measurement] = studio.measured(f.id for f in features)
    return oriented_planes(
        studio, ((f, measurements[f.id]) for f in features if f.id in measurements)
    )


def oriented_planes(
    studio: Studio, measured_features: Iterable[tuple[Feature, Measurement]]
) -> list[OrientedPlane]:
    """Collect the planes of measured features, which need not belong to the project."""
    planes = []
    for feature, figures in measured_features:
        if figures.plane is None:
            continue
        subject = studio.subject(feature, figures)
        points = extent_points(figures)
        planes.append(
            OrientedPlane(
                name=feature.name,
                kind=feature.type_id if isinstance(feature, TypedFeature) else figures.kind,
                normal=figures.plane.normal(),
                position=points.mean(axis=0) if len(points) else None,
                extent_m=catalogue.EXTENT.value(subject),
                error95_deg=catalogue.TOTAL_ERROR.value(subject),
            )
        )
    return planes
