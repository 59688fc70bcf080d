"""Format of an export, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate

ExportFormatName = Literal[
    "csv",
    "gpkg",
    "shp",
    "geojson",
    "dxf",
    "kml",
    "stereonet",
    "orient",
    "faultkin",
    "wintensor",
    "gempy",
    "loopstructural",
    "gems",
]


@dataclass(frozen=True)
class ExportFormat(Options):
    """Format of an export. Raises UsageError if the format is unknown."""

    to: ExportFormatName = option(help=to_translate("target program or format"))
    projected: bool = option(
        False,
        help=to_translate("write GeoJSON in the CRS of the project instead of WGS 84"),
    )
