"""Georeference of a raster picture on a map."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.gis.raster import silence_libtiff


def read_map_placement(path: Path) -> dict[str, Any] | None:
    """Return the crs, bounds, units and resolution_m of a TIFF that is a map.

    Returns
    -------
    dict or None
        None unless the rows run from north to south in a projected CRS in metres; the plane of an
        oblique orthophoto is not a map. The bounds do not include heights.
    """
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    from vomstudio.core.files.names import utf8_name
    from vomstudio.core.files.regular import require_regular_siblings
    from vomstudio.core.files.untrusted.pictures import check_raster

    try:
        require_regular_siblings(path)
        check_raster(path)
        with warnings.catch_warnings(), silence_libtiff(), rasterio.Env():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with utf8_name(path) as safe_path, rasterio.open(safe_path, driver="GTiff") as dataset:
                if dataset.crs is None or not dataset.crs.is_projected:
                    return None
                wkt, transform, box = dataset.crs.to_wkt(), dataset.transform, dataset.bounds
        crs, metres = parse_crs(wkt)
    except (RasterioError, InputError, OSError):
        return None
    if metres != 1.0 or transform.b or transform.d or transform.a <= 0 or transform.e >= 0:
        return None
    return {
        "crs": crs,
        "bounds": [[box.left, box.bottom, None], [box.right, box.top, None]],
        "units": ["m", "m", "unknown"],
        "resolution_m": max(transform.a, -transform.e),
    }
