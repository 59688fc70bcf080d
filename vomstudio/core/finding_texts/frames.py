"""Texts of the findings about frames: CRS, units and up axis."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "coordinate.out-of-range": (
        "error",
        to_translate("{value:g} is not a valid coordinate in metres. Correct or remove it."),
    ),
    "coordinate.far-from-model": (
        "error",
        to_translate(
            "The distance of the point from the model is {times:.0f} times the size of the model."
            " Check the coordinates."
        ),
    ),
    "coordinate.latitude": (
        "error",
        to_translate("The latitude {value:g} is not between -90 and 90. Correct it."),
    ),
    "coordinate.longitude": (
        "error",
        to_translate("The longitude {value:g} is not between -360 and 360. Correct it."),
    ),
    "accuracy.out-of-range": (
        "error",
        to_translate(
            "{value:g} is not a valid accuracy. Enter a value from {minimum:g} to {maximum:g}, or"
            " leave it empty."
        ),
    ),
    "frame.assumed": (
        "warning",
        to_translate(
            "{file} does not specify its frame. Assumed: {assumed}. Change this with --up, --unit"
            " and --crs."
        ),
    ),
    "frame.crs-unit-kept": (
        "info",
        to_translate("The coordinates remain in the unit of the CRS (1 unit = {metres:.9g} m)."),
    ),
    "frame.no-unit": (
        "warning",
        to_translate(
            "The unit of the model is unknown, so lengths in the options are in model units, not"
            " metres. Specify the unit with --unit."
        ),
    ),
    "frame.not-metric": (
        "error",
        to_translate(
            "Lengths in {crs} are up to {scale:.4g} times the true lengths at this location."
            " Convert the coordinates with --to-crs {suggested_crs}."
        ),
    ),
    "frame.undefined-place": (
        "error",
        to_translate(
            "{crs} is not defined at the location of the data. Check the CRS and the coordinates."
        ),
    ),
    "frame.outside-area": (
        "warning",
        to_translate(
            "The data are outside the area of use of {crs}, where lengths are {scale:.5g} times the"
            " true lengths. Check the CRS, or use {suggested_crs}."
        ),
    ),
    "frame.reprojected": (
        "info",
        to_translate("Coordinates were converted from {crs} to {to_crs}."),
    ),
    "frame.unit-converted": (
        "info",
        to_translate(
            "The file specifies x and y in {unit} and heights in {height_unit}. All were"
            " converted to metres."
        ),
    ),
    "frame.maybe-degrees": (
        "warning",
        to_translate(
            "x and y may be in degrees: their range is {span:.2g}, that of the heights"
            " {height:.2g}. Specify --crs and convert with --to-crs."
        ),
    ),
    "frame.crs-replaced": (
        "warning",
        to_translate("{file} specifies {file_crs}, but the given {crs} is used instead."),
    ),
    "frame.crs-unreadable": (
        "warning",
        to_translate("The CRS in the file ({crs}) is unknown. Specify the correct one with --crs."),
    ),
    "frame.crs-unused": (
        "warning",
        to_translate(
            "{file} specifies {crs}, which does not fit the coordinates and is not used. Specify"
            " the correct CRS with --crs."
        ),
    ),
    "frame.height-unit-only": (
        "warning",
        to_translate(
            "Only the heights have a unit ({height_unit}). x and y are assumed to have the same"
            " unit."
        ),
    ),
    "frame.height-unit-replaced": (
        "warning",
        to_translate(
            "The file specifies heights in {height_unit}, but its CRS specifies {crs_unit}. The"
            " unit of the file is used."
        ),
    ),
    "frame.axes-unused": (
        "warning",
        to_translate(
            "The axes of the CRS point west or south, but the coordinates are negative. They are"
            " read as east and north, without this CRS."
        ),
    ),
    "frame.degrees": (
        "error",
        to_translate(
            "x and y are in degrees, so they have no common length scale. Convert them with"
            " --to-crs, for example to {suggested_crs}."
        ),
    ),
    "frame.not-degrees": (
        "error",
        to_translate(
            "The CRS is in degrees, but x and y are too large for degrees. Specify the correct"
            " CRS with --crs."
        ),
    ),
    "frame.geocentric": (
        "error",
        to_translate(
            "The coordinates are geocentric: z points to the pole. Convert them with --to-crs, for"
            " example to a UTM zone."
        ),
    ),
    "frame.depths": (
        "error",
        to_translate(
            "The CRS defines z as depth, positive downwards. Convert depths to heights first."
        ),
    ),
    "frame.other-axes": (
        "error",
        to_translate(
            "The axes of the CRS point west or south, so azimuths would be wrong. Use a CRS with"
            " axes east and north."
        ),
    ),
    "frame.swapped-axes": (
        "error",
        to_translate(
            "The order of x and y does not match {crs}. Swap the two columns, or name them in the"
            " header."
        ),
    ),
    "frame.model-without-crs": (
        "info",
        to_translate(
            "{file} is in {crs}, but its model has no CRS. The coordinates are used unchanged."
        ),
    ),
    "frame.two-crs": (
        "warning",
        to_translate(
            "The file specifies two different coordinate reference systems: {one} and {other}. The"
            " first is used."
        ),
    ),
    "frame.up-by-format": (
        "error",
        to_translate(
            "In this format Y is up, so the model is rotated on reading. If Z is up, first convert"
            " the file with --up z."
        ),
    ),
    "frame.stale-crs-file": (
        "warning",
        to_translate("{file} specifies a CRS, but the model has none. Remove this file."),
    ),
    "frame.unknown-crs": (
        "error",
        to_translate(
            "'{crs}' is not a known CRS. Enter a code such as EPSG:32633, or a zone such as UTM"
            " 33N."
        ),
    ),
    "frame.not-projected": (
        "error",
        to_translate(
            "{crs} has no east and north axes in metres. Choose a projected CRS, such as a UTM"
            " zone."
        ),
    ),
    "frame.other-height-unit": (
        "error",
        to_translate(
            "In {crs}, heights have a different unit from x and y. Convert the heights, and choose"
            " a CRS for x and y only."
        ),
    ),
    "frame.other-crs": (
        "error",
        to_translate(
            "{crs} differs from {stated}, the CRS of {control}. Specify {stated}, or convert the"
            " points."
        ),
    ),
    "frame.no-crs": (
        "error",
        to_translate(
            "The coordinates cannot be converted, because the CRS of the file is unknown. Specify"
            " the CRS with --crs."
        ),
    ),
    "frame.unit-contradiction": (
        "error",
        to_translate("The unit of {crs} is {metres:g} m, not {unit}. Omit --crs or --unit."),
    ),
    "frame.damaged-keys": (
        "error",
        to_translate("The CRS information in the file is damaged. Specify the CRS yourself."),
    ),
    "north.unknown-year": (
        "error",
        to_translate(
            "The magnetic declination is known from {first} to {last}, but not for {year}. Enter"
            " it as a number."
        ),
    ),
    "north.near-pole": (
        "error",
        to_translate(
            "A compass is unreliable this close to a magnetic pole. Use another reference."
        ),
    ),
    "geojson.no-crs": (
        "warning",
        to_translate(
            "The project has no CRS, so GeoJSON coordinates are local metres, which most programs"
            " read as degrees. Register the models, or export a GeoPackage."
        ),
    ),
    "geojson.outside-area": (
        "error",
        to_translate(
            "Some features lie outside the area of use of {crs}. Check the CRS of their models, or"
            " use --projected."
        ),
    ),
    "kml.no-crs": (
        "error",
        to_translate(
            "KML needs longitude and latitude, but some models of the project have no CRS."
            " Register them, or export another format."
        ),
    ),
    "kml.outside-area": (
        "error",
        to_translate(
            "Some features lie outside the area of use of {crs}. Check the CRS of their models."
        ),
    ),
    "place.invalid": (
        "error",
        to_translate(
            "“{text}” is not a position. Enter latitude and longitude in degrees, such as 46.52,"
            " 11.35."
        ),
    ),
}
