"""Texts of the findings about frames: CRS, units and up axis."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "coordinate.out-of-range": (
        "error",
        to_translate("{value:g} is not a coordinate in metres. Correct or remove it."),
    ),
    "coordinate.far-from-model": (
        "error",
        to_translate(
            "The place is {times:.0f} times the model's size away from it. Check the coordinates."
        ),
    ),
    "coordinate.latitude": (
        "error",
        to_translate("A latitude of {value:g} is not within -90 to 90. Correct it."),
    ),
    "coordinate.longitude": (
        "error",
        to_translate("A longitude of {value:g} is not within -360 to 360. Correct it."),
    ),
    "accuracy.out-of-range": (
        "error",
        to_translate(
            "{value:g} is not a valid accuracy. State one from {minimum:g} to {maximum:g}, or leave"
            " it out."
        ),
    ),
    "frame.assumed": (
        "warning",
        to_translate(
            "{file} does not state its frame. In use: {up} up, unit {unit}, CRS {crs}. Options"
            " --up, --unit and --crs change this."
        ),
    ),
    "frame.crs-unit-kept": (
        "info",
        to_translate("Coordinates stay in the unit of the CRS, {metres:.9g} m."),
    ),
    "frame.no-unit": (
        "warning",
        to_translate(
            "The unit of the model is not known. Lengths given in metres are in that unit. State it"
            " with --unit."
        ),
    ),
    "frame.not-metric": (
        "error",
        to_translate(
            "Lengths in {crs} are up to {scale:.4g} times those on the ground there. Use"
            " {suggested_crs}."
        ),
    ),
    "frame.undefined-place": (
        "error",
        to_translate("{crs} is not defined where the data lie. Check the CRS and the coordinates."),
    ),
    "frame.outside-area": (
        "warning",
        to_translate(
            "The data lie outside the area of use of {crs}; lengths there are {scale:.5g} times"
            " those on the ground. Check the CRS, or use {suggested_crs}."
        ),
    ),
    "frame.reprojected": (
        "info",
        to_translate("Coordinates were converted from {crs} to {to_crs}."),
    ),
    "frame.unit-converted": (
        "info",
        to_translate(
            "The file states x and y in {unit} and heights in {height_unit}. All were converted to"
            " metres."
        ),
    ),
    "frame.maybe-degrees": (
        "warning",
        to_translate(
            "x and y look like degrees: within 180 and 90, spanning {span:.2g} for {height:.2g} of"
            " height. State the CRS with --crs and convert with --to-crs."
        ),
    ),
    "frame.crs-replaced": (
        "warning",
        to_translate("{file} states {file_crs}; the given {crs} is used instead."),
    ),
    "frame.crs-unreadable": (
        "warning",
        to_translate("The stated CRS ({crs}) is not known. State the right one with --crs."),
    ),
    "frame.crs-unused": (
        "warning",
        to_translate(
            "{file} states {crs}, which does not fit the coordinates. It is not used. State the CRS"
            " with --crs."
        ),
    ),
    "frame.height-unit-only": (
        "warning",
        to_translate(
            "Only heights have a stated unit ({height_unit}). x and y are assumed to be in the same"
            " unit."
        ),
    ),
    "frame.height-unit-replaced": (
        "warning",
        to_translate(
            "The file states heights in {height_unit}, its CRS in {crs_unit}. The first is used."
        ),
    ),
    "frame.axes-unused": (
        "warning",
        to_translate(
            "The axes of the stated CRS point west or south, but the coordinates are negative. They"
            " are used as east and north, without this CRS."
        ),
    ),
    "frame.degrees": (
        "error",
        to_translate(
            "x and y are in degrees, which have no scale. Convert them with --to-crs, for example"
            " to {suggested_crs}."
        ),
    ),
    "frame.not-degrees": (
        "error",
        to_translate(
            "The stated CRS is in degrees, but x and y are too large. State the right CRS with"
            " --crs."
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
            "The stated CRS defines z as a depth, positive downwards. Convert depths to heights"
            " first."
        ),
    ),
    "frame.other-axes": (
        "error",
        to_translate(
            "The axes of the stated CRS point west or south, so azimuths would be wrong. Use a CRS"
            " with axes east and north."
        ),
    ),
    "frame.swapped-axes": (
        "error",
        to_translate(
            "x and y are exchanged for {crs}. Exchange the two columns, or name them in the header."
        ),
    ),
    "frame.model-without-crs": (
        "info",
        to_translate(
            "{file} is in {crs}; the data that it belongs to state no CRS. Its coordinates are used"
            " as they are."
        ),
    ),
    "frame.two-crs": (
        "warning",
        to_translate("The file states two different CRS: {one}, and {other}. The first is used."),
    ),
    "frame.up-by-format": (
        "error",
        to_translate(
            "This format defines Y as up, so the model is turned when read. For another axis,"
            " convert it to another format with --up z first."
        ),
    ),
    "frame.stale-crs-file": (
        "warning",
        to_translate("{file} states a CRS that this model does not have. Remove that file."),
    ),
    "frame.unknown-crs": (
        "error",
        to_translate(
            "'{crs}' is not a known CRS. Write a code such as EPSG:32633, or a zone such as UTM"
            " 33N."
        ),
    ),
    "frame.not-projected": (
        "error",
        to_translate(
            "{crs} has no east and north in metres. Choose a projected CRS, such as a UTM zone."
        ),
    ),
    "frame.other-height-unit": (
        "error",
        to_translate(
            "{crs} has heights in another unit than x and y. Convert the heights, and choose the"
            " CRS of x and y alone."
        ),
    ),
    "frame.other-crs": (
        "error",
        to_translate(
            "{crs} is not the CRS of {control}, which is in {stated}. Leave it out, or convert the"
            " points."
        ),
    ),
    "frame.no-crs": (
        "error",
        to_translate("The file states no CRS to convert from. State it with --crs."),
    ),
    "frame.unit-contradiction": (
        "error",
        to_translate("The unit of {crs} is {metres:g} m, not {unit}. Leave out --crs or --unit."),
    ),
    "frame.damaged-keys": (
        "error",
        to_translate("The keys of the CRS in the file are damaged. State the CRS yourself."),
    ),
    "north.unknown-year": (
        "error",
        to_translate(
            "The magnetic declination is known from {first} to {last}, not in {year}. Give it as a"
            " number."
        ),
    ),
    "north.near-pole": (
        "error",
        to_translate(
            "A compass does not show north so near to a magnetic pole. Use another reference."
        ),
    ),
    "kml.no-crs": (
        "error",
        to_translate(
            "KML needs longitude and latitude, and some models of the project have no CRS. Register"
            " them, or export another format."
        ),
    ),
    "kml.outside-area": (
        "error",
        to_translate(
            "Some features are outside the area of use of {crs}. Check the CRS of their models."
        ),
    ),
    "place.invalid": (
        "error",
        to_translate(
            "“{text}” is not a place. Enter latitude and longitude in degrees, such as "
            "46.52, 11.35."
        ),
    ),
}
