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
        to_translate("This CRS was selected."),
    ),
    "control.crs-stated": (
        "info",
        to_translate("This CRS is specified in {file}."),
    ),
    "control.crs-local": (
        "info",
        to_translate("No CRS is specified, so the frame is local, in metres."),
    ),
    "control.crs-proposed": (
        "info",
        to_translate(
            "This CRS is proposed: in it, the points are {distance_m:.0f} m from the GPS"
            " positions of the photos."
        ),
    ),
    "control.swapped-columns": (
        "warning",
        to_translate(
            "Two coordinate axes appear to be swapped ({labels}), or heights are depths. Swap the"
            " columns, or change the sign of the heights."
        ),
    ),
    "control.swapped-degrees": (
        "error",
        to_translate(
            "{label}: longitude {longitude:.4f} and latitude {latitude:.4f} appear to be swapped."
            " Swap the columns."
        ),
    ),
    "control.other-unit": (
        "warning",
        to_translate(
            "The coordinates ({axes}) appear to be in {unit}, not metres. Multiply them by"
            " {factor:.4g}."
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
            "The registration scales the model by {scale:.4g}, the factor between metres and"
            " {unit}. If the model is in metres, multiply the coordinates by {factor:.4g}."
        ),
    ),
    "control.some-in-degrees": (
        "warning",
        to_translate(
            "x and y of {labels} appear to be in degrees, the others in metres. Convert them to"
            " the CRS of the others."
        ),
    ),
    "control.height-offset": (
        "warning",
        to_translate(
            "Heights of {labels} fit the others after adding {offset_m:+.3g} m. Ellipsoidal and"
            " orthometric heights, or two benchmarks, may be mixed."
        ),
    ),
    "control.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring control points are correlated ({correlation:.2f}): the"
            " receiver probably drifted. The stated errors include this. Use a base station."
        ),
    ),
    "control.click-error-unknown": (
        "info",
        to_translate(
            "The resolution of the model is unknown, so clicks on it are assumed exact. Enter a"
            " click error if you know it."
        ),
    ),
    "control.marks-scattered": (
        "error",
        to_translate(
            "The marks of the control points scatter by {scatter_px:.0f} px, so they cannot show"
            " the same points. Check labels, photos and poses."
        ),
    ),
    "control.few-marks": (
        "warning",
        to_translate(
            "Points with fewer than two correct marks in aligned photos were not used: {labels}."
            " Mark them again."
        ),
    ),
    "control.marks-disagree": (
        "warning",
        to_translate(
            "These points were not used, because the rays through their marks do not intersect:"
            " {labels}. Check their marks."
        ),
    ),
    "control.too-few": (
        "error",
        to_translate(
            "Only {count} of {total} control points are usable. At least {least} are required,"
            " each marked in {photos} or more photos. {reasons}"
        ),
    ),
    "control.collinear": (
        "error",
        to_translate(
            "The points lie on one line, so the model can rotate about it. Add a point off this"
            " line."
        ),
    ),
    "control.not-located": (
        "error",
        to_translate("The marks do not determine the position of every control point. Check them."),
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
            "The photos contradict the control points. The model was registered by a similarity"
            " transform, without adjustment to the points."
        ),
    ),
    "control.adjusted": (
        "info",
        to_translate(
            "The model was adjusted to the control points. Points left out of the adjustment have"
            " errors of {adjusted_m:.3g} m, or {similarity_m:.3g} m with a similarity."
        ),
    ),
    "control.not-adjusted": (
        "warning",
        to_translate(
            "The model was not adjusted to the control points: points left out would have errors"
            " of {adjusted_m:.3g} m instead of {similarity_m:.3g} m."
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
            "Without check points the registration is not tested independently. Use some"
            " control points as check points."
        ),
    ),
    "control.left-out": (
        "warning",
        to_translate("Points that contradict the others were left out: {labels}."),
    ),
    "control.more-marks": (
        "warning",
        to_translate(
            "These points are marked in fewer than {wanted} photos: {labels}. Mark them in more"
            " photos."
        ),
    ),
    "control.photos-without-pose": (
        "warning",
        to_translate(
            "Marks in these photos are not used, because the model has no cameras with these"
            " names: {photos}. Check the names."
        ),
    ),
    "control.photos-missing": (
        "warning",
        to_translate(
            "Marks in these photos are not used, because the photos are not in the folder:"
            " {photos}."
        ),
    ),
    "control.without-coordinates": (
        "warning",
        to_translate(
            "Marks of {labels} are not used, because these points have no coordinates. Use the"
            " same labels in both tables."
        ),
    ),
    "control.same-spot": (
        "warning",
        to_translate(
            "In {photo} the points {first} and {second} are marked at the same position (x"
            " {x:.0f}, y {y:.0f}). Remove or move one mark."
        ),
    ),
    "control.far-from-photos": (
        "warning",
        to_translate(
            "In {crs} the control points are {distance_km:,.0f} km from the GPS positions of the"
            " photos. Check the CRS and the order of east and north."
        ),
    ),
    "label.invalid": (
        "error",
        to_translate("Enter a label of printable characters, without leading or trailing spaces."),
    ),
    "label.in-use": (
        "error",
        to_translate("The label {label} is in use. Choose another label."),
    ),
    "control.all-check": (
        "error",
        to_translate(
            "All {count} points are check points, so none can register the model. Use at least 3 as"
            " control points."
        ),
    ),
    "control.one-place": (
        "error",
        to_translate(
            "All points have the same position, so they cannot register the model. Correct their"
            " coordinates."
        ),
    ),
    "control.apart": (
        "warning",
        to_translate(
            "{first} are {distance_m:,.0f} m away from {second}: their zones or units may"
            " differ. Convert all to one CRS. Specify --crs to find the wrong ones."
        ),
    ),
    "control.group-swapped": (
        "warning",
        to_translate(
            "x and y appear to be swapped, either for {first} or for {second}. Correct the wrong"
            " ones. Specify --crs to find them."
        ),
    ),
    "control.constant-heights": (
        "warning",
        to_translate(
            "All heights are {height:g}, but the points differ in height on the model. Heights"
            " that were not measured tilt the model. Enter the measured heights."
        ),
    ),
    "control.missing-heights": (
        "warning",
        to_translate(
            "The heights of {labels} ({height:g}) are probably missing values, because the other"
            " points fit without them. Enter these heights, or leave the points out."
        ),
    ),
    "control.similar-labels": (
        "warning",
        to_translate(
            "These labels may refer to the same point: {labels}. Keep one, or use more distinct"
            " labels."
        ),
    ),
    "control.same-coordinates": (
        "warning",
        to_translate(
            "{labels} have the same coordinates. A row may have been copied: correct or remove one."
        ),
    ),
    "control.swapped-labels": (
        "warning",
        to_translate(
            "{first} and {second} appear to be swapped: the points would fit within {after_m:.2g}"
            " m instead of {before_m:.2g} m. Swap these labels."
        ),
    ),
    "control.other-order": (
        "warning",
        to_translate(
            "The rows may be in the wrong order: with the coordinates of {second} for"
            " {first}, and so on, they fit within {after_m:.2g} m instead of {before_m:.2g}"
            " m."
        ),
    ),
    "control.mark-outside": (
        "warning",
        to_translate(
            "The mark of {label} at x {x:.0f}, y {y:.0f} is outside {photo} ({width} x {height}"
            " pixels) and was left out. Correct it."
        ),
    ),
    "control.other-pixels": (
        "error",
        to_translate(
            "The residuals of the marks are {miss_px:.0f} pixels, but would be {better_px:.1f}"
            " pixels if {change}. Correct the marks."
        ),
    ),
    "control.wrong-mark": (
        "warning",
        to_translate(
            "The mark of {label} in {photo} at x {x:.0f}, y {y:.0f} was left out: its other marks"
            " predict x {wanted_x:.0f}, y {wanted_y:.0f}."
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
            "The file contains no control points with coordinates. Add some, or choose another"
            " file."
        ),
    ),
    "control.no-marks": (
        "error",
        to_translate(
            "The file contains no marks of control points in photos. Add some, or choose another"
            " file."
        ),
    ),
    "control.only-marks": (
        "error",
        to_translate(
            "The file contains marks in photos, but no control points. Use it as the marks file."
        ),
    ),
    "control.only-points": (
        "error",
        to_translate(
            "The file contains control points, but no marks in photos. Use it as the control"
            " point file."
        ),
    ),
    "control.unknown-format": (
        "error",
        to_translate("This is not a control point file. Supported formats: {formats}."),
    ),
    "control.no-chunk": (
        "error",
        to_translate("The file has no chunk with markers. Export the markers in Metashape."),
    ),
    "control.several-chunks": (
        "error",
        to_translate("The file has {count} chunks with markers. Export only the chunk you need."),
    ),
    "control.unknown-key": (
        "error",
        to_translate("{name} {key} is missing from the file. Export it again."),
    ),
    "control.no-projection": (
        "error",
        to_translate(
            "The file does not start with its projection, such as EPSG:32633 or WGS84 UTM 33N."
            " Add it as the first line."
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
        to_translate(
            "'{label}' has different coordinates in line {first_line}. Correct one of the lines."
        ),
    ),
    "control.repeated-point": (
        "error",
        to_translate("The point {label} occurs twice. Remove one of them."),
    ),
    "control.not-on-earth": (
        "error",
        to_translate(
            "{label} has no valid longitude and latitude. Correct its coordinates or the CRS."
        ),
    ),
    "control.bar-of-one-point": (
        "error",
        to_translate("The scale bar starts and ends at {label}. Use two different points."),
    ),
    "control.line-without-length": (
        "error",
        to_translate("Both ends of the line have the same position. Correct one of them."),
    ),
    "control.no-model-direction": (
        "error",
        to_translate(
            "The columns model_x, model_y and model_z must contain a plane normal or a line"
            " direction in the frame of the model."
        ),
    ),
    "control.no-photos": (
        "error",
        to_translate("The file lists no photos below the coordinate system. Add them."),
    ),
    "control.marks-missing": (
        "error",
        to_translate(
            "The control points are not marked in photos. Specify the file of marks with --marks."
        ),
    ),
    "control.other-crs": (
        "error",
        to_translate(
            "The coordinates are in {crs}, but the project uses {project_crs}. Convert them to"
            " the project's CRS."
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
        to_translate("{table} next to the photos is not used: {reason}"),
    ),
    "control.pending": (
        "info",
        to_translate("The control points are being checked. Please wait."),
    ),
    "control.no-file": (
        "error",
        to_translate("Choose the control point file."),
    ),
    "control.no-coordinates": (
        "warning",
        to_translate(
            "Enter the coordinates of {label}. A point without coordinates is a tie point."
        ),
    ),
}
