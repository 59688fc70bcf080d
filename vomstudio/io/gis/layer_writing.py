"""Layers of vector data into files that GDAL writes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import TargetError
from vomstudio.core.files.names import writable
from vomstudio.core.findings import Finding
from vomstudio.geometry.units import WORLD

VERSION = "1.2"
"""Of GeoPackage. QGIS 3.22 warns of 1.4, and opens its layers without their styles."""


def write_layer(
    part: Path,
    layer: str,
    geometry_type: str,
    geometry: AnyArray,
    columns: Mapping[str, AnyArray],
    crs: str | None,
    *,
    described: str = "",
    append: bool = False,
) -> None:
    """One layer of a GeoPackage. geometry : (n,) of shapely; columns : (n,) each; crs : None for a
    local frame; append : to the
    layers that are there. Raises TargetError."""
    import shapely
    from pyogrio.errors import DataSourceError, FieldError, GeometryError
    from pyogrio.raw import write

    try:
        write(
            str(part),
            shapely.to_wkb(geometry),
            [_writable(values) for values in columns.values()],
            np.array(list(columns), dtype=object),
            layer=layer,
            driver="GPKG",
            geometry_type=geometry_type,
            # Without one, GDAL would say East and North.
            crs=crs or WORLD.wkt,
            append=append,
            layer_options={"DESCRIPTION": described},
            dataset_options=None if append else {"VERSION": VERSION},
        )
    except (DataSourceError, FieldError, GeometryError, RuntimeError) as error:
        raise TargetError(
            Finding("output.unwritable", layer=layer, reason=error), file=part
        ) from error


def _writable(values: AnyArray) -> AnyArray:
    """Texts as any program reads them; numbers as they are."""
    if values.dtype.kind not in "OU":
        return values
    texts = [writable(value) if isinstance(value, str) else value for value in values.tolist()]
    return np.array(texts, object)
