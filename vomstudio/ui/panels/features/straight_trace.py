"""Descriptions of the plane band of a straight trace and the plane of crossing traces."""

from __future__ import annotations

from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_attitude, format_line
from vomstudio.geology.orientation import Line, Plane
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import FeatureType, get
from vomstudio.project.straight_traces import measured_band, select_priors
from vomstudio.ui.base.studio import Studio


def describe_trace_band(studio: Studio, feature_id: str, measurement: Measurement) -> list[str]:
    """Describe the band of planes of a straight trace; the list is empty for other features."""
    band = measured_band(measurement)
    if band is None:
        return []
    from vomstudio.geology.band_figures import band_findings, describe_band

    features = studio.session.features()
    priors = select_priors(
        features,
        studio.measured(f.id for f in features),
        lambda f: _format_set_name(studio, f),
        feature_id,
    )
    description = describe_band(band, priors)
    likely_estimate = description.likely_set
    plane_text = None
    if likely_estimate is not None:
        likely_plane = Plane(likely_estimate.dip_direction_deg, likely_estimate.dip_deg)
        plane_text = format_attitude(
            likely_plane, likely_estimate.max_confidence95_deg, studio.settings.notation
        )
    line = format_line(Line(description.trend_deg, description.plunge_deg))
    return [item.message for item in band_findings(description, line, plane_text)]


def describe_crossing(studio: Studio) -> list[str]:
    """Describe the plane that contains two selected straight traces, as rich text.

    The list is empty unless exactly two straight traces are selected.
    """
    ids = studio.selection.ids
    measurements = studio.measured(ids)
    bands = [measured_band(measurements[id_]) for id_ in ids if id_ in measurements]
    if len(ids) != 2 or len(bands) != 2 or bands[0] is None or bands[1] is None:
        return []
    from vomstudio.geology.plane_bands import crossing_plane

    try:
        crossing = crossing_plane(bands[0], bands[1])
    except GeometryError as error:
        return [str(error)]
    return [
        tr(
            "Both traces are straight and cross at {angle:.0f}°. If they belong to one plane, it is"
            " {plane} (joint 95 %; at least {smallest:.1f}°).",
            angle=crossing.crossing_deg,
            plane=format_attitude(
                Plane(crossing.dip_direction_deg, crossing.dip_deg),
                crossing.max_confidence95_deg,
                studio.settings.notation,
            ),
            smallest=crossing.min_confidence95_deg,
        )
    ]


def _format_set_name(studio: Studio, feature: object) -> str:
    """Format the type and set of a feature as on the stereonet."""
    feature_type = get(studio.records, getattr(feature, "type_id", ""), FeatureType)
    name = "" if feature_type is None else feature_type.name
    set_name = getattr(feature, "set_name", "")
    return f"{name}: {set_name}" if set_name else name
