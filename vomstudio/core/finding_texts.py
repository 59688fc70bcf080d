"""The catalogue of findings: severity and text of every code.

A text says what happened, with the value or file, and what to do, in at most 25 words (STYLE of the
project). Placeholders are those of `str.format`.
"""

from __future__ import annotations

from typing import Literal

from vomstudio.words import to_translate

TEXTS: dict[str, tuple[Literal["info", "warning", "error"], str]] = {
    "uncoded": ("warning", "{text}"),
    # --- frames --------------------------------------------------------------------------------
    "frame.assumed": (
        "warning",
        to_translate(
            "{file} does not state its frame. In use: {up} up, unit {unit}, CRS {crs}. Options"
            " --up, --unit and --crs change this."
        ),
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
            "The axes of the stated CRS point west or south, so azimuths would be wrong. Use a"
            " CRS with axes east and north."
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
    # --- control points and cameras ---------------------------------------------------------------
    "control.swapped-columns": (
        "warning",
        to_translate(
            "Two axes of the coordinates look exchanged ({labels}), or heights are depths. Exchange"
            " the columns, or change the sign of the heights."
        ),
    ),
    "control.swapped-degrees": (
        "error",
        to_translate(
            "{label}: longitude {longitude:.4f} and latitude {latitude:.4f} look exchanged."
            " Exchange the columns."
        ),
    ),
    "control.other-unit": (
        "warning",
        to_translate(
            "Coordinates ({axes}) look like {unit}, not metres. Multiply them by {factor:.4g}."
        ),
    ),
    "control.far-away": (
        "warning",
        to_translate(
            "{labels}: {distance_m:,.0f} m from the other points, which lie within {extent_m:,.0f}"
            " m. Check the digits and the zone."
        ),
    ),
    "control.scale-of-unit": (
        "warning",
        to_translate(
            "The registration scales the model by {scale:.4g}, as from metres to {unit}. If the"
            " model is in metres, multiply the coordinates by {factor:.4g}."
        ),
    ),
    "control.some-in-degrees": (
        "warning",
        to_translate(
            "x and y of {labels} look like degrees, those of the others like metres. Convert them"
            " to the CRS of the others."
        ),
    ),
    "control.height-offset": (
        "warning",
        to_translate(
            "Heights of {labels} fit the others with {offset_m:+.3g} m added. Ellipsoidal and"
            " orthometric heights, or two benchmarks, may be mixed."
        ),
    ),
    "control.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring control points are correlated ({correlation:.2f}), as by a"
            " drifting receiver. The stated errors include this. Use a base station."
        ),
    ),
    "cameras.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring camera positions are correlated ({correlation:.2f}): the"
            " receiver drifted. The stated errors include this. Add control points."
        ),
    ),
    "control.click-error-unknown": (
        "info",
        to_translate(
            "The click on the model is taken as exact, since its resolution is not known. Give the"
            " click error if there is one."
        ),
    ),
    "control.mark-scatter": (
        "warning",
        to_translate(
            "Marks of the control points scatter by {scatter_px:.0f} px. The stated errors include"
            " this. Check the marks, and the poses of the photos."
        ),
    ),
    "control.marks-scattered": (
        "error",
        to_translate(
            "The marks of the control points are {scatter_px:.0f} px off each other: they cannot"
            " show the same points. Check labels, photos and poses."
        ),
    ),
    "control.few-marks": (
        "warning",
        to_translate(
            "Points with fewer than two right marks in photos of the model were not used: {labels}."
            " Mark them again."
        ),
    ),
    "control.marks-disagree": (
        "warning",
        to_translate(
            "The marks of these points do not meet in one place, so the points were not used:"
            " {labels}. Check their marks."
        ),
    ),
    # --- lines ---------------------------------------------------------------------------------
    "trace.beside": (
        "warning",
        to_translate(
            "Points {start} to {end} are {offset_m:.2g} m beside the plane of the rest, behind rock"
            " without a contact. Set a way-point there, on the right contact."
        ),
    ),
    "lines.not-planar": (
        "warning",
        to_translate(
            "The lines are three-dimensional. They were analysed on the plane {plane}: scatter"
            " {scatter_m:.2g} m, {shortening_percent:.1f} % shorter than in space. --plane sets"
            " another."
        ),
    ),
    "lines.no-plane": (
        "error",
        to_translate(
            "The lines lie on one straight line, so they define no plane. State their plane"
            " (--plane DD/D)."
        ),
    ),
    "lines.no-heights": (
        "warning",
        to_translate(
            "Lines without heights: {lines}. They cannot be placed on the plane {plane}. Export"
            " them with heights."
        ),
    ),
    "lines.edge-on": (
        "error",
        to_translate(
            "The {option} is seen edge-on on the plane {plane} of the lines. Give it with heights"
            " (a circle as X,Y,Z,R)."
        ),
    ),
    "lines.closed": (
        "warning",
        to_translate(
            "Closed lines, such as outlines of patches, are not traces. Left out: {lines}."
        ),
    ),
    # --- folds ---------------------------------------------------------------------------------
    "fold.too-few-planes": (
        "info",
        to_translate(
            "The axis rests on {n} planes, whose scatter is poorly known. Measure at least"
            " {wanted} before you rely on its 95 % error."
        ),
    ),
    # --- slopes --------------------------------------------------------------------------------
    "slope.pairs-of-one-set": (
        "info",
        to_translate(
            "{pairs:,} of {all_pairs:,} pairs are planes of one set; their intersections do not"
            " count as wedges."
        ),
    ),
    # --- logs ----------------------------------------------------------------------------------
    "fold.planes-not-good": (
        "warning",
        to_translate(
            "{not_good} of {used} planes of the fold axis are not good, and count like the others."
            " Improve them or leave them out."
        ),
    ),
    "log.beds-not-parallel": (
        "warning",
        to_translate(
            "The {count} traces of the bedding are not parallel, or too straight (±"
            " {error_deg:.1f}° at best). Take the plane of a bed."
        ),
    ),
    # --- drawings ------------------------------------------------------------------------------
    "drawing.unchanged": (
        "info",
        to_translate("Features of the project that the drawing shows unchanged: {count}."),
    ),
    "drawing.edited": (
        "warning",
        to_translate(
            "Traces that were edited in the drawing: {names} ({count} in all). Update edited traces"
            " (--update) changes them in the project."
        ),
    ),
    # --- photos --------------------------------------------------------------------------------
    "photo.altitude-sign": (
        "warning",
        to_translate(
            "{photo}: EXIF states a height of {exif_m:+.2f} m, XMP {xmp_m:+.2f} m ({photos}"
            " photos). The XMP heights are used. Check their sign."
        ),
    ),
    "photo.angles-not-measured": (
        "warning",
        to_translate(
            "Yaw, pitch and roll are exactly 0 in {photos} photos ({photo}, ...), so they were not"
            " measured. They are not used."
        ),
    ),
    "photo.angles-in-comment": (
        "info",
        to_translate(
            "The angles of {photos} photos ({photo}, ...) are from EXIF UserComment: yaw from true"
            " north, pitch 0 level and -90 straight down. Check this."
        ),
    ),
    # --- registrations -------------------------------------------------------------------------
    "registration.other-model": (
        "warning",
        to_translate(
            "{file} belongs to other files ({models}), so its errors are not used. Register the"
            " model again, or delete the file."
        ),
    ),
    "registration.damaged": (
        "warning",
        to_translate(
            "{file} cannot be used: {reason}. The model has no errors of registration. Restore the"
            " file, or register the model again."
        ),
    ),
    "registration.unknown-version": (
        "warning",
        to_translate(
            "{file} has version {version}, this program reads {known}. Its registration is not"
            " used. Update the program."
        ),
    ),
    "registration.other-frame": (
        "warning",
        to_translate(
            "The registration in {file} is not used: it places the model in {crs}, but {stated} is"
            " stated. Correct one of them."
        ),
    ),
    "registration.incomplete": (
        "warning",
        to_translate(
            "The earlier registration in {file} is not used for what the new one leaves free,"
            " because the coordinates of the file are not those of World."
        ),
    ),
    "registration.reference-error": (
        "info",
        to_translate(
            "With the error of the reference the model may be turned by {rotation95_deg:.2g}°"
            " (95 %) and its scale may be off by {scale95_percent:.2g} %."
        ),
    ),
    "registration.compass-alone": (
        "warning",
        to_translate(
            "North rests on compass readings alone: a common offset of ± {north_sigma_deg:g}°"
            " (1 sigma) is assumed. State how far they may all be off (--north-sigma)."
        ),
    ),
    "registration.parallel-level-lines": (
        "warning",
        to_translate(
            "The level lines run within {apart_deg:.0f}° of each other and count as one. Add a"
            " level line across them, or a plumb line."
        ),
    ),
    "registration.photo-upright": (
        "info",
        to_translate(
            "How the photos were held counts as an observation of the vertical, ± {sigma_deg:g}°"
            " (1 sigma)."
        ),
    ),
    "registration.which-end-up": (
        "warning",
        to_translate(
            "The lines tip the model by {tip_deg:.0f}° and do not show which end is up. Check that"
            " the model is not upside down."
        ),
    ),
    "registration.poor": (
        "warning",
        to_translate(
            "The model may be turned by {rotation95_deg:.2g}° (95 %), which makes planes on it"
            " poor. Add points, lines or readings."
        ),
    ),
    # --- files -----------------------------------------------------------------------------------
    "file.other-kind": (
        "error",
        to_translate("Cannot read this kind of file here: {title}. {remedy}"),
    ),
    "drawing.no-lines": (
        "warning",
        to_translate(
            "{count} bodies and surfaces of the drawing are left out ({entities}): they have no"
            " lines."
        ),
    ),
    "drawing.only-bodies": (
        "error",
        to_translate(
            "The drawing has no such lines, only {count} bodies and surfaces ({entities}). Extract"
            " their edges as lines in CAD."
        ),
    ),
    "model.entities-left-out": (
        "warning",
        to_translate(
            "{count} entities are left out ({entities}). A model consists of points and faces: save"
            " solids as meshes, and blocks exploded."
        ),
    ),
    "model.no-entities": (
        "error",
        to_translate(
            "The drawing has no points or faces, only: {entities}. Save solids as meshes, and"
            " blocks exploded."
        ),
    ),
    "model.columns-left-out": (
        "warning",
        to_translate("Columns left out: {columns}. Only those with a number per point are read."),
    ),
    "model.other-shapes": (
        "error",
        to_translate(
            "The shapefile contains {shapes}. A model needs points with heights (PointZ,"
            " MultiPointZ) or faces (MultiPatch)."
        ),
    ),
    "model.rings-left-out": (
        "warning",
        to_translate(
            "{count} polygons with more than four corners are left out. Triangulate them first."
        ),
    ),
    "model.cut-short": (
        "warning",
        to_translate("The file ends too early: {count} of its points or faces were read."),
    ),
    "texture.by-name": (
        "warning",
        to_translate(
            "{file}: the texture '{missing}' of material '{material}' is missing. '{picture}' is"
            " used because of its name. Check it."
        ),
    ),
    # --- files ---------------------------------------------------------------------------------
    "file.unsafe-schema": (
        "error",
        to_translate(
            "The file contains the {kind} '{name}', which can run without end or hide rows."
            " Export its tables to a new file, or ask for another copy."
        ),
    ),
    "file.picture-too-large": (
        "error",
        to_translate(
            "The picture of {width} x {height} pixels needs {needed_mb} MB; for this file"
            " {limit_mb} MB are allowed. Reduce it, or close other programs."
        ),
    ),
    "file.picture-header": (
        "error",
        to_translate(
            "The header of the picture is not valid: {reason}. Save it again with another program."
        ),
    ),
    "file.memory-exceeded": (
        "error",
        to_translate(
            "Reading was stopped: it takes more memory than the size of the file justifies. Export"
            " the file again."
        ),
    ),
}
