"""Station where something was observed or a sample was taken; it has no orientation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry.matrices import Point
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject, text_figure
from vomstudio.project.kind import Attribute, GisLayer, Kind, KindGroup, Lookup, Sketch
from vomstudio.project.measurement import Measurement, MeasurementContext, is_metric, world_lines
from vomstudio.project.records import Feature, PickedFeature

StationKind = Literal["station", "sample"]
STATION_KINDS: tuple[tuple[StationKind, str], ...] = (
    ("station", _("Station")),
    ("sample", _("Sample")),
)
PHOTO_SEPARATOR = "; "
MAX_STATION_DISTANCE_M = 10.0
"""Maximum distance between rows of one station."""
GROUP = KindGroup("stations", _("Stations and samples"), "map-marker")


@dataclass(frozen=True)
class Station(PickedFeature):
    """Station or sample.

    Attributes
    ----------
    vertices : tuple of Point
        Position on the model: one point in the file frame.
    number : str
        Number as written in the field book or on the sample bag. Readings with this number in
        their field `station` belong to the station.
    photo : str
        Names or paths of the photos of the station or sample, separated by semicolons.
    """

    id: str
    name: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    what: StationKind = "station"
    number: str = ""
    photo: str = ""
    notes: str = ""


def measure(context: MeasurementContext, stations: Sequence[Station]) -> list[Measurement]:
    """Return the positions in the World frame; no other quantities are measured."""
    models = [context.model(station.model_id) for station in stations]
    points_of_stations = world_lines(stations, models)
    return [
        Measurement(
            points,
            None,
            None,
            None,
            None,
            None,
            text=_station_text(station),
            metric=is_metric(model),
            kind="station",
        )
        for station, points, model in zip(stations, points_of_stations, models, strict=True)
    ]


def _station_text(station: Station) -> str:
    description = tr(dict(STATION_KINDS)[station.what])
    return f"{description} {station.number}".rstrip()


def position_in_world(subject: Subject) -> FloatArray | None:
    """Return the position (1, 3) of a station in the World frame, or None if unknown."""
    points = subject.measured.points
    return points[:1] if len(points) else None


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the drawing of a station, or None if its position is unknown."""
    points, station = position_in_world(subject), subject.feature
    if points is None:
        return None
    return Sketch(points, points[0], label=station.number or "–")


def station_photos(*stations: Station) -> list[str]:
    """Return the names of the photos of stations.

    Parameters
    ----------
    *stations : Station

    Returns
    -------
    list of str
    """
    names = (
        name.strip()
        for station in stations
        for name in station.photo.split(PHOTO_SEPARATOR.strip())
    )
    return [name for name in names if name]


def merge_stations(features: Sequence[Feature], scale: float) -> list[Feature]:
    """Merge the rows of each station, such as one row per photo, into one station.

    It has the photos and notes of all rows. Rows farther than `MAX_STATION_DISTANCE_M` from the
    first remain separate.

    Parameters
    ----------
    features : sequence of Feature
    scale : float
        Metres per unit of the vertices.

    Returns
    -------
    list of Feature
    """
    merged_stations: dict[object, Feature] = {}
    for feature in features:
        key: object = feature.id
        if isinstance(feature, Station) and (code := feature.number or feature.name):
            key = (feature.what, code.casefold())
            first_station = merged_stations.get(key)
            if isinstance(first_station, Station):
                distance_m = scale * math.dist(first_station.vertices[0], feature.vertices[0])
                if distance_m <= MAX_STATION_DISTANCE_M:
                    merged_stations[key] = replace(
                        first_station,
                        photo=PHOTO_SEPARATOR.join(
                            dict.fromkeys(station_photos(first_station, feature))
                        ),
                        notes="\n".join(
                            dict.fromkeys(filter(None, (first_station.notes, feature.notes)))
                        ),
                    )
                    continue
                key = feature.id
        merged_stations[key] = feature
    return list(merged_stations.values())


def get_readings(station: Station, records: Mapping[str, Any]) -> list[Feature]:
    """Return the readings that were taken at a station, by its number or name.

    Parameters
    ----------
    station : Station
    records : mapping

    Returns
    -------
    list of Feature
    """
    codes = {code.casefold() for code in (station.number, station.name) if code}
    features = (record for record in records.values() if isinstance(record, Feature))
    return [feature for feature in features if getattr(feature, "station", "").casefold() in codes]


def about(subject: Subject) -> list[str]:
    """List the readings that were taken at a station."""
    readings = get_readings(subject.feature, subject.records)
    if not readings:
        return []
    return [
        tr_n(
            "{count} reading: {names}",
            "{count} readings: {names}",
            len(readings),
            names=", ".join(reading.name for reading in readings),
        )
    ]


def _kind_text(subject: Subject) -> str:
    return str(subject.feature.what)


NUMBER = text_figure(
    "number",
    _("Number"),
    _("Number of a station or sample, as written in the field"),
    lambda subject: subject.feature.number or None,
    words=("number",),
)
PHOTO = text_figure(
    "photo",
    _("Photos"),
    _("Names or paths of the photos of a station or sample, separated by semicolons"),
    lambda subject: subject.feature.photo or None,
    words=("photo",),
)
STATION_KIND = replace(
    of.KIND,
    title=_("Kind"),
    explanation=_("Station or sample"),
    value=_kind_text,
    words=(),
    format_text=None,
)
"""Used only in files; elsewhere, `kind` is the feature type."""

KIND = Kind(
    name="station",
    order=62,
    record=Station,
    title=_("Station"),
    icon="map-marker",
    measure=measure,
    figures=(of.ID, of.NAME, NUMBER, *of.PLACE, PHOTO, *of.MODEL_FIGURES, of.NOTES),
    attributes=(
        kind.NAME,
        Attribute("what", _("Kind"), "choice", STATION_KINDS),
        Attribute("number", _("Number")),
        Attribute("photo", _("Photos")),
        kind.NOTES,
    ),
    sketch=sketch,
    class_name=lambda station: str(station.what),
    about=about,
    headline=lambda measured: measured.text,
    tool="station",
    layer=GisLayer(
        "stations",
        "point",
        position_in_world,
        (of.ID, of.NAME, STATION_KIND, NUMBER, PHOTO, of.MODEL, of.NOTES),
    ),
    group=GROUP,
    color="#ffffff",
    prefix=lambda station: str(station.what),
    listed=True,
    drawing_label=lambda station: station.number or station.name,
)
