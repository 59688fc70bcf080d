"""Features of a project as GeoDataFrames, and for plots."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vomstudio.api.tables import frame
from vomstudio.geometry.plane_discs import disc_of_fit
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.gis.layers import Layer
from vomstudio.project.figures import Subject
from vomstudio.project.kind import get_color
from vomstudio.project.kinds import KINDS, get_kind
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.tables.orientation_table import COLUMNS
from vomstudio.project.tables.project_layers import project_layers
from vomstudio.project.tables.project_table import ProjectTable, project_table

if TYPE_CHECKING:
    from geopandas import GeoDataFrame
    from pandas import DataFrame

    from vomstudio.rendering.plots.plotting import DrawnFeature

Records = Mapping[str, Record]
_DEFAULT_COLOR = "#ffffff"


def orientations(
    records: Records, measurements: Measurements, geometry: Literal["plane", "line"]
) -> GeoDataFrame:
    """Return the orientation table of planes or lines, with points in the column `geometry`.

    Parameters
    ----------
    records : Records
    measurements : Measurements
    geometry : {"plane", "line"}

    Returns
    -------
    GeoDataFrame
    """
    import shapely

    table = project_table(records, measurements)
    rows = [row for row in table.rows if row["element"] == geometry]
    dataframe = frame(rows, (*COLUMNS, *table.extra_columns))
    positions = [
        None if row["x"] is None else shapely.Point(row["x"], row["y"], row["z"]) for row in rows
    ]
    geodataframe = _create_geodataframe(dataframe, positions, table)
    geodataframe.attrs["registrations"] = list(table.registrations)
    return geodataframe


def shapes(
    records: Records,
    measurements: Measurements,
    name: Literal["traces", "patches", "stations", "contacts", "lithologies"],
) -> GeoDataFrame:
    """Return a layer of points, lines or rings, as in the GeoPackage.

    Parameters
    ----------
    records : Records
    measurements : Measurements
    name : {"traces", "patches", "stations", "contacts", "lithologies"}
        Name of the layer.

    Returns
    -------
    GeoDataFrame
    """
    import pandas

    table = project_table(records, measurements)
    layers = [layer for layer in project_layers(records, table, measurements) if layer.name == name]
    columns: dict[str, Any] = {column: [] for column in _columns(name)}
    geometry: list[Any] = []
    if layers:
        columns |= layers[0].columns
        geometry = _geometry(layers[0])
    return _create_geodataframe(pandas.DataFrame(columns), geometry, table)


def _create_geodataframe(
    dataframe: DataFrame, geometry: list[Any], table: ProjectTable
) -> GeoDataFrame:
    from geopandas import GeoDataFrame, GeoSeries

    # Coordinates are in metres, also if the unit of the CRS is a foot.
    crs = world_crs(table.crs, table.unit_m)
    series = GeoSeries(geometry, index=dataframe.index, crs=crs)
    geodataframe = GeoDataFrame(dataframe, geometry=series)
    geodataframe.attrs["north"] = table.north
    return geodataframe


def _columns(name: str) -> list[str]:
    layers = [
        feature_kind.layer
        for feature_kind in KINDS
        if feature_kind.layer is not None and feature_kind.layer.name == name
    ]
    return [figure.name for figure in layers[0].figures if not layers[0].sparse]


def _geometry(layer: Layer) -> list[Any]:
    import shapely

    if layer.kind == "point":
        return [shapely.Point(shape[0]) for shape in layer.shapes]
    create_geometry = shapely.LineString if layer.kind == "line" else shapely.Polygon
    return [create_geometry(shape) for shape in layer.shapes]


def drawings(records: Records, measurements: Measurements) -> list[DrawnFeature]:
    """Return all features with a position for a plot.

    Parameters
    ----------
    records : Records
    measurements : Measurements

    Returns
    -------
    list of DrawnFeature
    """
    features = [r for r in records.values() if isinstance(r, Feature)]
    measurements_by_id = measurements.of(records, [feature.id for feature in features])
    drawn_features = [_create_drawing(feature, records, measurements_by_id) for feature in features]
    return [drawn_feature for drawn_feature in drawn_features if drawn_feature is not None]


def _create_drawing(
    feature: Feature, records: Records, measurements_by_id: Mapping[str, Measurement]
) -> DrawnFeature | None:
    from vomstudio.rendering.plots.plotting import DrawnFeature

    measurement, feature_kind = measurements_by_id[feature.id], get_kind(feature)
    sketch = feature_kind.sketch(Subject(feature, measurement, records), measurements_by_id.get)
    if sketch is None:
        return None
    label = _attitude_text(measurement) if sketch.label is None else sketch.label
    return DrawnFeature(
        feature.id,
        np.asarray(sketch.line, np.float64),
        disc_of_fit(measurement.fit),
        np.asarray(sketch.anchor, np.float64),
        f"{feature.name}  {label}".strip(),
        get_color(feature, records) or _DEFAULT_COLOR,
    )


def _attitude_text(measurement: Measurement) -> str:
    if measurement.plane is None and measurement.line is None:
        return ""
    return measurement.attitude()
