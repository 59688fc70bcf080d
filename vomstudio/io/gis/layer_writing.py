"""Writing of layers of vector data with GDAL."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import TargetError
from vomstudio.core.files.names import replace_surrogates
from vomstudio.core.findings import Finding
from vomstudio.geometry.units import WORLD_AXES

VERSION = "1.2"
"""GeoPackage version. QGIS 3.22 warns about version 1.4 and ignores its styles."""


def write_layer(
    path: Path,
    layer: str,
    geometry_type: str,
    geometry: AnyArray,
    columns: Mapping[str, AnyArray],
    crs: str | None,
    *,
    description: str = "",
    append: bool = False,
) -> None:
    """Write a layer to a GeoPackage.

    Parameters
    ----------
    path : Path
    layer : str
        Name of the layer.
    geometry_type : str
    geometry : (n,) array of shapely geometries
    columns : mapping of str to (n,) array
    crs : str or None
        CRS of the layer, or None for a local frame.
    description : str
        Description of the layer.
    append : bool
        Whether to add the layer to the existing layers of the file.

    Raises
    ------
    TargetError
        If the layer cannot be written.
    """
    import shapely
    from pyogrio.errors import DataSourceError, FieldError, GeometryError
    from pyogrio.raw import write

    try:
        write(
            str(path),
            shapely.to_wkb(geometry),
            [_to_encodable(values) for values in columns.values()],
            np.array(list(columns), dtype=object),
            layer=layer,
            driver="GPKG",
            geometry_type=geometry_type,
            # Without a CRS, GDAL would state East and North.
            crs=crs or WORLD_AXES.wkt,
            append=append,
            layer_options={"DESCRIPTION": description},
            dataset_options=None if append else {"VERSION": VERSION},
        )
    except (DataSourceError, FieldError, GeometryError, RuntimeError) as error:
        raise TargetError(
            Finding("output.unwritable", layer=layer, reason=error), file=path
        ) from error


def _to_encodable(values: AnyArray) -> AnyArray:
    """Replace lone surrogates in text; numbers are unchanged."""
    if values.dtype.kind not in "OU":
        return values
    texts = [
        replace_surrogates(value) if isinstance(value, str) else value for value in values.tolist()
    ]
    return np.array(texts, object)
