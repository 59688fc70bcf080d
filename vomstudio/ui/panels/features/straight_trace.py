"""What a selected straight trace determines, and what two that cross do, in words."""

from __future__ import annotations

from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_attitude, format_line
from vomstudio.geology.orientation import Line, Plane
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import FeatureType, get
from vomstudio.project.straight_traces import band_of_measured, priors_among
from vomstudio.ui.base.studio import Studio


def band_lines(studio: Studio, feature_id: str, measured: Measurement) -> list[str]:
    """Sentences on the band of planes of a straight trace; none of anything else."""
    band = band_of_measured(measured)
    if band is None:
        return []
    from vomstudio.geology.band_figures import band_lines, describe_band

    features = studio.session.features()
    priors = priors_among(
        features, studio.measured(f.id for f in features), lambda f: _name(studio, f), feature_id
    )
    found = describe_band(band, priors)
    likely = found.likely
    plane = None
    if likely is not None:
        own = Plane(likely.dip_direction_deg, likely.dip_deg)
        plane = format_attitude(own, likely.max_confidence95_deg, studio.settings.notation)
    return band_lines(found, format_line(Line(found.trend_deg, found.plunge_deg)), plane)


def crossing_lines(studio: Studio) -> list[str]:
    """Of two selected straight traces: the plane that contains both."""
    ids = studio.selection.ids
    measured = studio.measured(ids)
    bands = [band_of_measured(measured[id_]) for id_ in ids if id_ in measured]
    if len(ids) != 2 or len(bands) != 2 or bands[0] is None or bands[1] is None:
        return []
    from vomstudio.geology.plane_bands import crossing_plane

    try:
        found = crossing_plane(bands[0], bands[1])
    except GeometryError as error:
        return [str(error)]
    return [
        tr(
            "Both are straight and cross at {angle:.0f}°. If they are of one plane, it is {plane}, "
            "joint 95 %, {smallest:.1f}° at least.",
            angle=found.crossing_deg,
            plane=format_attitude(
                Plane(found.dip_direction_deg, found.dip_deg),
                found.max_confidence95_deg,
                studio.settings.notation,
            ),
            smallest=found.min_confidence95_deg,
        )
    ]


def _name(studio: Studio, feature: object) -> str:
    """Of the type and set of a feature, as on the net."""
    kind = get(studio.records, getattr(feature, "type_id", ""), FeatureType)
    name = "" if kind is None else kind.name
    own = getattr(feature, "set_name", "")
    return f"{name}: {own}" if own else name
