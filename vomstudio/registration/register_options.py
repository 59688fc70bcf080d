"""Options of registrations, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import MAX_LENGTH_M, Options, check_requires, option
from vomstudio.core.words import to_translate
from vomstudio.geometry.units import METRES_PER_UNIT

BESIDE = "beside the model"
"""Value that selects the photos next to the model instead of a file of cameras or attitudes."""
MIN_ERROR = 1e-6
"""Minimum one-sigma error that can be stated, metres or degrees."""


@dataclass(frozen=True)
class Observations(Options):
    """Observations that register the model of a file or of a project.

    Raises
    ------
    UsageError
        If a value is outside its bounds, marks are given without control points, or a stable part
        is given without a reference.
    """

    pairs: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("table: label, model_x, model_y, model_z, x, y, z[, use, sigma_x, …]"),
    )
    gcp: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "control points with coordinates; their marks give the positions on the model"
        ),
    )
    marks: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("marks of the control points in the photos"),
        automatic_text=to_translate("in the control point file, or marks.csv next to it"),
    )
    model_cameras: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "cameras of the model: cameras.json, or a file from COLMAP, Metashape, OpenDroneMap,"
            " Meshroom, MicMac, RealityCapture, OpenMVG, Bundler or nerfstudio"
        ),
        automatic_text=to_translate("next to the model"),
    )
    cameras: str | None = option(
        None,
        metavar="FILE",
        flag_value=BESIDE,
        help=to_translate(
            "a table (photo, x, y, z, or photo, longitude, latitude, altitude), a geo.txt, or a"
            " folder of photos with GPS; without FILE, the photos next to the model"
        ),
    )
    attitudes: str | None = option(
        None,
        metavar="FILE",
        flag_value=BESIDE,
        help=to_translate(
            "table: photo, yaw, pitch, roll[, sigma_yaw, …, north], or a folder of photos with"
            " attitudes; without FILE, the photos next to the model"
        ),
    )
    horizon: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("table: photo, x1, y1, x2, y2 (pixels of a level line)"),
    )
    orientations: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "orientation table with model_x, model_y, model_z (plane normals or line directions)"
        ),
    )
    azimuth: Literal["strike", "dipdir"] | None = option(
        None,
        help=to_translate("meaning of a column called azimuth in the orientation table"),
    )
    scale_bars: str | None = option(
        None,
        metavar="FILE",
        help=to_translate("table: from, to, length_m[, sigma_m, use]; labels of the points"),
    )
    scale: tuple[str, ...] = option(
        (),
        metavar="X1,Y1,Z1,X2,Y2,Z2,METRES[,SIGMA]",
        help=to_translate(
            "two points on the model, their distance in metres, and its standard deviation"
            " (default 0.5 %)"
        ),
    )
    bearing: tuple[str, ...] = option(
        (),
        metavar="X1,Y1,Z1,X2,Y2,Z2,DEG[,SIGMA]",
        help=to_translate(
            "two points on the model, the azimuth from the first to the second, and its standard"
            " deviation, degrees (default 3)"
        ),
    )
    level: tuple[str, ...] = option(
        (),
        metavar="X1,Y1,Z1,X2,Y2,Z2[,SIGMA]",
        help=to_translate(
            "two points on the model at the same height, and the standard deviation of their"
            " line, degrees (default 0.5)"
        ),
    )
    plumb: tuple[str, ...] = option(
        (),
        metavar="X1,Y1,Z1,X2,Y2,Z2[,SIGMA]",
        help=to_translate(
            "two points on the model, one vertically above the other, and the standard deviation"
            " of their line, degrees (default 0.5)"
        ),
    )
    reference: str | None = option(
        None,
        metavar="MODEL",
        help=to_translate("fit the model to this registered mesh or cloud of the same rock"),
    )
    stable: str | None = option(
        None,
        metavar="MASK",
        help=to_translate("stable part of the reference: polygons in map view, or a cloud or mesh"),
    )
    north: Literal["grid", "true", "magnetic"] = option(
        "grid", help=to_translate("north reference of azimuths, if not in the table")
    )
    date: str | None = option(
        None,
        metavar="DAY",
        help=to_translate("date of the compass readings, such as 2024-05-12, for the declination"),
    )
    declination_deg: float | None = option(
        None,
        minimum=-180.0,
        maximum=180.0,
        help=to_translate("declination of magnetic north, degrees, east positive"),
        automatic_text=to_translate("IGRF"),
    )
    north_sigma_deg: float | None = option(
        None,
        minimum=0.0,
        maximum=180.0,
        help=to_translate(
            "standard deviation of the common offset of all compass readings, degrees"
        ),
        automatic_text=to_translate(
            "10 for photos, 2 for other azimuths from magnetic north, otherwise 0"
        ),
    )
    click_sigma_m: float | None = option(
        None,
        minimum=0.0,
        maximum=MAX_LENGTH_M,
        decimals=4,
        label=to_translate("Click error"),
        tip=to_translate("Error of a click on the model (1σ)"),
        help=to_translate(
            "standard deviation of each coordinate of a point picked on the model, in addition to"
            " the control accuracy, m"
        ),
        automatic_text=to_translate("half the resolution of the model; 0 without a model"),
    )
    crs: str | None = option(
        None,
        metavar="EPSG",
        help=to_translate("projected coordinate reference system of the registered model"),
    )
    to_crs: str | None = option(
        None,
        metavar="EPSG",
        help=to_translate("convert the observed positions to this projected CRS in metres"),
    )
    without: tuple[str, ...] = option(
        (),
        metavar="LABEL",
        help=to_translate("leave out the point, reading, photo or line with this label"),
    )
    robust: bool = option(
        False, help=to_translate("leave out and report outliers among the observations")
    )
    keep_scale: bool = option(
        False,
        label=to_translate("Keep model scale"),
        tip=to_translate("Only rotate and shift the model, as for laser scans"),
        help=to_translate("keep the scale of the model: rotate and shift only"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_requires(self, "marks", "gcp")
        check_requires(self, "stable", "reference")
        errors = {"--north-sigma": self.north_sigma_deg, "--click-sigma": self.click_sigma_m}
        for flag, value in errors.items():
            if value and value < MIN_ERROR:
                raise UsageError(
                    Finding("option.too-small", value=value, minimum=MIN_ERROR),
                    field=flag,
                )


@dataclass(frozen=True)
class RegisterOptions(Observations):
    """Options that register the model of a file."""

    up: Literal["y", "z"] | None = option(
        None,
        choices=("y", "z"),
        help=to_translate("up axis of the model file"),
        automatic_text=to_translate("as defined by its format"),
    )
    unit: str | None = option(
        None,
        choices=tuple(METRES_PER_UNIT),
        help=to_translate("unit of the model file, which fixes the scale"),
        automatic_text=to_translate("the observations determine the scale"),
    )
