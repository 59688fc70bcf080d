"""The planes of features as they are held against others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from vomstudio.geology.model_agreement import OrientedPlane
from vomstudio.project import catalogue
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Typed
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio


def measured_planes(studio: Studio, features: Sequence[Feature]) -> list[OrientedPlane]:
    """Of the features of the project that have a plane."""
    measured: Mapping[str, Measurement] = studio.measured(f.id for f in features)
    return planes_of(studio, ((f, measured[f.id]) for f in features if f.id in measured))


def planes_of(
    studio: Studio, measured: Iterable[tuple[Feature, Measurement]]
) -> list[OrientedPlane]:
    """Of features with their figures, whether they are in the project or not."""
    found = []
    for feature, figures in measured:
        if figures.plane is None:
            continue
        subject = studio.subject(feature, figures)
        points = extent_points(figures)
        found.append(
            OrientedPlane(
                feature.name,
                feature.type_id if isinstance(feature, Typed) else figures.kind,
                figures.plane.normal(),
                points.mean(axis=0) if len(points) else None,
                catalogue.EXTENT.value(subject),
                catalogue.TOTAL.value(subject),
            )
        )
    return found
