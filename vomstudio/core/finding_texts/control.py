"""Texts of the findings about control points and marks."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "control.usable": (
        "info",
        to_translate("Usable: {points}, each in {least} to {most} photos."),
    ),
    "control.crs-chosen": (
        "info",
        to_translate("This CRS was chosen."),
    ),
    "control.crs-stated": (
        "info",
        to_translate("This CRS is stated in {file}."),
    ),
    "control.crs-local": (
        "info",
        to_translate("No CRS is stated, so the frame is local, in metres."),
    ),
    "control.crs-proposed": (
        "info",
        to_translate(
            "This CRS is proposed: the points are {distance_m:.0f} m from the photos' GPS positions"
            " in it."
        ),
    ),
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
    "control.click-error-unknown": (
        "info",
        to_translate(
            "The click on the model is taken as exact, since its resolution is not known. Give the"
            " click error if there is one."
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
    "control.too-few": (
        "error",
        to_translate(
            "Only {count} of {total} control points can be used. {least} are needed, each marked in"
            " {photos} or more photos. {reasons}"
        ),
    ),
    "control.collinear": (
        "error",
        to_translate(
            "The points lie on one line, about which the model can rotate. Add a point beside this"
            " line."
        ),
    ),
    "control.not-located": (
        "error",
        to_translate("The marks do not locate all control points in the model. Check them."),
    ),
    "control.contradicts": (
        "error",
        to_translate(
            "The control points contradict each other or the photos by {sigma_m:.3g} m, so the"
            " model can rotate by {rotation_deg:.0f}°. Check coordinates, labels and marks."
        ),
    ),
    "control.contradicts-photos": (
        "warning",
        to_translate(
            "The photos contradict the control points. The model was registered by a similarity and"
            " not adjusted to them."
        ),
    ),
    "control.adjusted": (
        "info",
        to_translate(
            "The model was adjusted to the control points. Points it is not adjusted to are"
            " {adjusted_m:.3g} m off, and {similarity_m:.3g} m by a similarity."
        ),
    ),
    "control.not-adjusted": (
        "warning",
        to_translate(
            "The model was not adjusted to the control points: points it is not adjusted to would"
            " be {adjusted_m:.3g} m off instead of {similarity_m:.3g} m."
        ),
    ),
    "control.tie-points": (
        "info",
        to_translate("{count} point without coordinates is used as a tie point."),
        to_translate("{count} points without coordinates are used as tie points."),
    ),
    "control.no-redundancy": (
        "warning",
        to_translate(
            "{count} points have no redundancy, so a blunder cannot be detected. Use {least} or"
            " more."
        ),
    ),
    "control.no-check-points": (
        "warning",
        to_translate(
            "No check points judge the model independently of those that place it. Leave some out"
            " as check points."
        ),
    ),
    "control.left-out": (
        "warning",
        to_translate("Points that contradict the others were left out: {labels}."),
    ),
    "control.more-marks": (
        "warning",
        to_translate(
            "These points are marked in fewer than {wanted} photos: {labels}. Mark them in more."
        ),
    ),
    "control.photos-without-pose": (
        "warning",
        to_translate(
            "Marks in these photos are not used, since they are not among the cameras of the model:"
            " {photos}. Check the names."
        ),
    ),
    "control.photos-missing": (
        "warning",
        to_translate(
            "Marks in these photos are not used, since they are not in the folder: {photos}."
        ),
    ),
    "control.without-coordinates": (
        "warning",
        to_translate(
            "Marks of these points are not used: {labels}. They have no coordinates. Write labels"
            " alike in both tables."
        ),
    ),
    "control.same-spot": (
        "warning",
        to_translate(
            "In {photo} the points {first} and {second} are marked at the same place (x {x:.0f}, y"
            " {y:.0f}). Remove or move one mark."
        ),
    ),
    "control.far-from-photos": (
        "warning",
        to_translate(
            "In {crs} the control points are {distance_km:,.0f} km from the photos' GPS positions."
            " Check the CRS, and that x and y are east and north."
        ),
    ),
    "label.invalid": (
        "error",
        to_translate(
            "A label must have one or more printable characters, without spaces around them."
        ),
    ),
    "label.in-use": (
        "error",
        to_translate("The label {label} is in use. Choose another label."),
    ),
    "control.all-check": (
        "error",
        to_translate(
            "All {count} points are marked as check, and none places the model. Mark 3 or more as"
            " control."
        ),
    ),
    "control.one-place": (
        "error",
        to_translate(
            "All points are at one place, by which nothing can be placed. Give the coordinates of"
            " each."
        ),
    ),
    "control.apart": (
        "warning",
        to_translate(
            "{first} are {distance_m:,.0f} m away from {second}: they may be of two zones or units."
            " Bring all into one. --crs shows which are right."
        ),
    ),
    "control.group-swapped": (
        "warning",
        to_translate(
            "x and y look exchanged, either of {first} or of {second}. Exchange those that are"
            " wrong. --crs shows which."
        ),
    ),
    "control.constant-heights": (
        "warning",
        to_translate(
            "All heights are {height:g}, but on the model the points differ in height: heights that"
            " were not measured tilt the model. Give the heights."
        ),
    ),
    "control.missing-heights": (
        "warning",
        to_translate(
            "The heights of {labels} ({height:g}) look missing, since the other points fit without"
            " them. Give these heights, or leave the points out."
        ),
    ),
    "control.similar-labels": (
        "warning",
        to_translate(
            "These labels look like those of one point: {labels}. Keep one, or give them different"
            " names."
        ),
    ),
    "control.same-coordinates": (
        "warning",
        to_translate(
            "{labels} have the same coordinates: a row may have been copied. Correct one, or leave"
            " it out."
        ),
    ),
    "control.swapped-labels": (
        "warning",
        to_translate(
            "{first} and {second} look exchanged: the points would fit within {after_m:.2g} m"
            " instead of {before_m:.2g} m. Exchange these labels."
        ),
    ),
    "control.other-order": (
        "warning",
        to_translate(
            "The rows look listed in another order: they would fit within {after_m:.2g} m instead"
            " of {before_m:.2g} m if {first} had the coordinates of {second}, and so on."
        ),
    ),
    "control.mark-outside": (
        "warning",
        to_translate(
            "The mark of {label} at x {x:.0f}, y {y:.0f} is outside of {photo} ({width} x {height}"
            " pixels), and was left out. Correct it."
        ),
    ),
    "control.other-pixels": (
        "error",
        to_translate(
            "The marks do not fit the photos: they are {miss_px:.0f} pixels off, and would be"
            " {better_px:.1f} if {change}. Correct the marks."
        ),
    ),
    "control.wrong-mark": (
        "warning",
        to_translate(
            "The mark of {label} in {photo} at x {x:.0f}, y {y:.0f} contradicts its other marks,"
            " which put it at x {wanted_x:.0f}, y {wanted_y:.0f}. It was left out."
        ),
    ),
    "control.contradicting-marks": (
        "warning",
        to_translate(
            "The marks of {label} contradict each other. Check the one in {photo} at x {x:.0f}, y"
            " {y:.0f}, and the others."
        ),
    ),
    "control.no-points": (
        "error",
        to_translate(
            "The file has no control points with coordinates. Add some, or choose another file."
        ),
    ),
    "control.no-marks": (
        "error",
        to_translate(
            "The file has no marks of control points in photos. Add some, or choose another file."
        ),
    ),
    "control.only-marks": (
        "error",
        to_translate(
            "The file has marks in photos and no control points. Use it as the file of marks."
        ),
    ),
    "control.only-points": (
        "error",
        to_translate(
            "The file has control points and no marks in photos. Use it as the file of control"
            " points."
        ),
    ),
    "control.unknown-format": (
        "error",
        to_translate("This is not a file of control points. Supported: {formats}."),
    ),
    "control.no-chunk": (
        "error",
        to_translate("The file has no chunk with markers. Export the markers in Metashape."),
    ),
    "control.several-chunks": (
        "error",
        to_translate("The file has {count} chunks with markers. Export the one that is needed."),
    ),
    "control.unknown-key": (
        "error",
        to_translate("{name} {key} is not in the file. Export it again."),
    ),
    "control.no-projection": (
        "error",
        to_translate(
            "The file does not begin with its projection, such as EPSG:32633 or WGS84 UTM 33N. Add"
            " it as the first line."
        ),
    ),
    "control.mark-repeated": (
        "error",
        to_translate(
            "'{label}' is already marked in {photo} (line {first_line}). Remove one of the marks."
        ),
    ),
    "control.other-coordinates": (
        "error",
        to_translate("'{label}' has other coordinates in line {first_line}. Correct one of them."),
    ),
    "control.repeated-point": (
        "error",
        to_translate("The point {label} is given twice. Leave one of them out."),
    ),
    "control.not-on-earth": (
        "error",
        to_translate(
            "{label} is not at a longitude and latitude. Correct its coordinates, or the CRS."
        ),
    ),
    "control.bar-of-one-point": (
        "error",
        to_translate("The scale bar begins and ends at {label}. Name two points."),
    ),
    "control.line-without-length": (
        "error",
        to_translate("Both ends of the line are at one place. Correct it."),
    ),
    "control.no-model-direction": (
        "error",
        to_translate(
            "Columns model_x, model_y and model_z must contain the normal of a plane, or the"
            " direction of a line, in the frame of the model."
        ),
    ),
    "control.no-photos": (
        "error",
        to_translate("The file lists no photos below the coordinate system. Add their lines."),
    ),
    "control.marks-missing": (
        "error",
        to_translate(
            "The marks of the control points in photos are missing. Name their file with --marks."
        ),
    ),
    "control.other-crs": (
        "error",
        to_translate(
            "Its coordinates are in {crs}, but the points of the project are in "
            "{project_crs}. Convert them to one CRS."
        ),
    ),
    "control.registers": (
        "info",
        to_translate("Ground control registers the model in {crs}. {summary}"),
    ),
    "control.registers-locally": (
        "info",
        to_translate("Ground control registers the model in a local frame. {summary}"),
    ),
    "control.not-used": (
        "warning",
        to_translate("{table} beside the photos is not used: {reason}"),
    ),
    "control.pending": (
        "info",
        to_translate("The control points are being checked. Wait for the result."),
    ),
    "control.no-file": (
        "error",
        to_translate("Choose the file of the control points."),
    ),
    "control.no-coordinates": (
        "warning",
        to_translate("Enter the coordinates of {label}. Without coordinates it is a tie point."),
    ),
}
