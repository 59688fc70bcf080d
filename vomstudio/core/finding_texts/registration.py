"""Texts of the findings about registrations."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
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
    "registration.weak-rotation": (
        "warning",
        to_translate(
            "The registration determines the model's azimuth only to about {azimuth_deg:.1f}° and"
            " its tilt to {tilt_deg:.1f}°. Dips and dip directions may be wrong by these angles."
        ),
    ),
    "gps.imprecise": (
        "error",
        to_translate(
            "The accuracy of the GPS positions ({sigma_m:.1f} m) is not better than the spread of"
            " the cameras ({spread_m:.1f} m about their mean). Use control points."
        ),
    ),
    "gps.rotation": (
        "error",
        to_translate(
            "With positions accurate to {sigma_m:.1f} m the model can rotate by {rotation_deg:.0f}°"
            " about the line of the cameras. Use control points."
        ),
    ),
    "gps.mixed-heights": (
        "warning",
        to_translate("Some photos state heights above sea level, others above the ellipsoid."),
    ),
    "gps.missing": (
        "warning",
        to_translate("{count} photo with a pose has no GPS position."),
        to_translate("{count} photos with a pose have no GPS position."),
    ),
    "gps.adjusted": (
        "info",
        to_translate(
            "GPS positions (accuracy {accuracy_m:.2g} m) were used in the bundle adjustment."
        ),
    ),
    "gps.not-useful": (
        "info",
        to_translate(
            "GPS positions (accuracy {accuracy_m:.2g} m) were not used in the bundle adjustment:"
            " together they have an error of {error_px:.0f} pixels (at most {limit_px:.0f} are"
            " useful)."
        ),
    ),
    "gps.contradicts-photos": (
        "info",
        to_translate(
            "GPS positions (accuracy {accuracy_m:.2g} m) were not used in the bundle adjustment:"
            " with them, the reprojection error would be {after_px:.2f} px instead of"
            " {before_px:.2f} px."
        ),
    ),
    "gps.too-few-to-adjust": (
        "info",
        to_translate(
            "{positions} GPS positions were not used in the bundle adjustment: without redundancy a"
            " blunder cannot be detected ({least} are needed)."
        ),
    ),
    "crs.outside-area": (
        "error",
        to_translate("{photo} was taken outside the area of {crs}. Choose another CRS."),
    ),
    "registration.no-observations": (
        "error",
        to_translate("Nothing places the model. Give points, directions, lengths or a reference."),
    ),
    "registration.too-few-points": (
        "error",
        to_translate("{count} point cannot register a model. Use at least {least}."),
        to_translate("{count} points cannot register a model. Use at least {least}."),
    ),
    "registration.points-and-cameras": (
        "warning",
        to_translate(
            "Control points and cameras contradict each other by {turn_deg:.2g}° and"
            " {scale_percent:+.2g} % of the scale. Use the better one, and the other one as a"
            " check."
        ),
    ),
    "registration.scale-contradicted": (
        "warning",
        to_translate(
            "The kept scale is contradicted: the other observations make the model {times:.4g}"
            " times as large (± {error95_percent:.2g} %, 95 %). One is wrong, or in another unit."
        ),
    ),
    "registration.north-quarter-turn": (
        "warning",
        to_translate(
            "All {readings} are turned by {turn_deg:+.0f}° ± {error95_deg:.0f}° (95 %), a quarter"
            " or half turn. Add {correction_deg:+.0f}° after checking the columns. Their north was"
            " not used."
        ),
    ),
    "registration.north-turned": (
        "warning",
        to_translate(
            "All {readings} are turned by {turn_deg:+.1f}° ± {error95_deg:.1f}° (95 %). Check"
            " --declination, or state --north-sigma. Their north was not used."
        ),
    ),
    "registration.unknown-label": (
        "error",
        to_translate("There is no {label} that could be left out. There are {known}."),
    ),
    "registration.without": (
        "info",
        to_translate("Left out as requested: {labels}."),
    ),
    "registration.pending": (
        "info",
        to_translate("The registration is being computed. Wait for the result."),
    ),
    "registration.applied": (
        "info",
        *to_translate_n(
            "{model} was placed by {count} observation and turned by {turn_deg:.1f}°, with all"
            " measurements on it.",
            "{model} was placed by {count} observations and turned by {turn_deg:.1f}°, with"
            " all measurements on it.",
        ),
    ),
    "registration.control-rms": (
        "info",
        to_translate(
            "The RMS of the control points is {control_m:.3g} m. There are no check points."
        ),
    ),
    "registration.check-rms": (
        "info",
        to_translate(
            "The RMS of the control points is {control_m:.3g} m, of the check points"
            " {check_m:.3g} m."
        ),
    ),
    "registration.positions-rms": (
        "info",
        to_translate("The RMS of the camera positions is {positions_m:.3g} m."),
    ),
    "registration.left-out": (
        "warning",
        to_translate(
            "{labels} cannot be right beside the others and took no part. Look the values up."
        ),
    ),
    "registration.blunder": (
        "warning",
        to_translate(
            "{labels}: too far off to be chance. Without it the model turns by {turned_deg:.2g}°,"
            " and the scale changes by {scale_percent:+.2g} %. Check it, or use --without."
        ),
    ),
    "registration.suspect": (
        "warning",
        to_translate(
            "{label}: {error_deg:.0f}° off. Without it the others agree to {others_deg:.1f}° (RMS)"
            " and the model turns by {turn_deg:.1f}°. Check it, or leave it out (--without)."
        ),
    ),
    "registration.residuals-large": (
        "warning",
        to_translate(
            "The residuals are {times:.1f} times what the stated accuracies allow. Check values and"
            " accuracies. All errors were enlarged by this factor."
        ),
    ),
    "registration.residuals-small": (
        "warning",
        to_translate(
            "The residuals are {times:,.0f} times smaller than the stated accuracies. State these"
            " in metres: all stated errors rest on them."
        ),
    ),
    "registration.readings-copied": (
        "warning",
        to_translate(
            "The readings agree {times:,.0f} times better than their stated accuracies allow: they"
            " may have been taken from the model. Check them."
        ),
    ),
    "registration.ambiguous": (
        "warning",
        to_translate(
            "A different rotation fits as well. The one that tilts and turns the model least was"
            " taken. Add a point, or another direction."
        ),
    ),
    "registration.error-assumed": (
        "warning",
        to_translate(
            "The accuracy of the {kinds} is neither stated nor shown by residuals: a usual one was"
            " assumed. State it."
        ),
    ),
    "registration.points-nowhere": (
        "warning",
        to_translate(
            "The points are off by {share_percent:.0f} % of their extent: labels, coordinates or"
            " heights are wrong, or of two systems. Compare the table with the model."
        ),
    ),
    "registration.rotation-unknown": (
        "warning",
        to_translate(
            "The rotation of the model is practically unknown. Add observations that are spread"
            " wider, or correct those named above."
        ),
    ),
    "registration.weak-scale": (
        "warning",
        to_translate(
            "The scale is known only to {error95_percent:.1f} % (95 %), and lengths and areas with"
            " it. Place points farther apart, or measure a scale bar."
        ),
    ),
    "registration.weakest-axis": (
        "info",
        to_translate(
            "The model may be turned by {error95_deg:.2g}° (95 %) about the axis"
            " {trend}/{plunge_deg:02.0f}: dips and dip directions by the same angle."
        ),
    ),
    "registration.worth-adding": (
        "info",
        to_translate(
            "One more control point near {x:.1f}, {y:.1f}, {z:.1f} would lessen that to"
            " {after_deg:.2g}°."
        ),
    ),
    "registration.not-known": (
        "warning",
        to_translate(
            "Not known after this registration: {parameters}. These stay as in the model's file."
        ),
    ),
    "registration.vertical": (
        "info",
        to_translate(
            "The vertical is known to ± {error95_deg:.2g}° (95 %): dips may be wrong by this angle."
        ),
    ),
    "registration.bowed": (
        "warning",
        to_translate(
            "The model is bowed by {evidence}: edges are {rise_m:.2g} m off the mean plane,"
            " {where}, and dips there {side_deg:.1f}° ± {error95_deg:.1f}° off. Calibrate the lens."
        ),
    ),
    "registration.moved": (
        "warning",
        to_translate(
            "The registration moves the model by {distance_km:,.1f} km from its coordinates in"
            " {crs}. Check zone, CRS, unit and column order, unless the file is wrong."
        ),
    ),
    "registration.turned": (
        "warning",
        to_translate(
            "The registration turns the model by {turn_deg:.0f}° from its orientation in {crs}."
            " Check for swapped columns or labels, unless the file is wrong."
        ),
    ),
    "registration.off-model": (
        "error",
        to_translate(
            "The points ({x:,.2f}, {y:,.2f}, {z:,.2f}, …) are far off the model, whose centre is"
            " ({mx:,.2f}, {my:,.2f}, {mz:,.2f}). Give them in the coordinates of its file."
        ),
    ),
    "registration.upside-down": (
        "warning",
        to_translate(
            "This registration turns the model upside down ({tip_deg:.0f}°). Easting and northing"
            " may be exchanged, or heights be depths. Compare the columns with a map."
        ),
    ),
    "registration.upside-down-or-mirror": (
        "warning",
        to_translate(
            "This registration turns the model upside down ({tip_deg:.0f}°), or the points are a"
            " mirror image. Exchange easting and northing, or add points above or below."
        ),
    ),
    "lens.bowing": (
        "warning",
        to_translate(
            "By the errors of the lenses (95 %), dips at an edge may be {side_deg:.1f}° off the"
            " middle. Calibrate them, or add oblique photos."
        ),
    ),
    "lens.stretch": (
        "warning",
        to_translate(
            "The errors of the lenses (95 %) can stretch depths by {share_percent:.1f} %, and turn"
            " planes by up to {turn_deg:.1f}°. Calibrate the lens, or add control."
        ),
    ),
    "attitude.left-out": (
        "warning",
        to_translate(
            "The attitudes of these photos are turned by more than {limit_deg:.0f}° against the"
            " others and were left out: {photos}."
        ),
    ),
    "attitude.yaw-left-out": (
        "warning",
        to_translate(
            "The yaws of these photos are off by about {off_deg:+d}° against the others and were"
            " left out: {photos}."
        ),
    ),
    "attitude.convention-left-out": (
        "warning",
        to_translate(
            "The attitudes of these photos would agree with the others if {change}, and were left"
            " out: {photos}."
        ),
    ),
    "attitude.verticals-left-out": (
        "warning",
        to_translate(
            "The verticals of these photos do not agree with the others and were left out:"
            " {photos}."
        ),
    ),
    "attitude.verticals-turned": (
        "warning",
        to_translate("These verticals would agree if the photos were turned by {turns_deg}°."),
    ),
    "attitude.other-convention": (
        "warning",
        to_translate(
            "The attitudes of the photos disagree by {scatter_deg:.0f}° and would agree within"
            " {least_deg:.1f}° if {change}. Check the convention of the table."
        ),
    ),
    "attitude.turned-photos": (
        "warning",
        to_translate(
            "The verticals of the photos disagree by {scatter_deg:.0f}° and would agree within"
            " {least_deg:.1f}° if turned by {turn_deg}°. Check whether a program turned them"
            " upright."
        ),
    ),
    "attitude.too-steep": (
        "warning",
        to_translate(
            "These photos look up or down too steeply for their compass, and show the vertical"
            " alone: {photos}."
        ),
    ),
    "attitude.not-in-photos": (
        "error",
        to_translate(
            "The photos do not state their attitude: they have no gimbal angles, acceleration or"
            " view direction. Give a table of attitudes."
        ),
    ),
    "attitude.from-drone": (
        "warning",
        to_translate(
            "The yaws of {photos} photos are of a drone's gimbal and were taken as from true north,"
            " with the error of a compass."
        ),
    ),
    "attitude.north-assumed": (
        "warning",
        to_translate(
            "{photos} photos do not state whether their direction is from true or magnetic north:"
            " magnetic was assumed."
        ),
    ),
    "reference.apart": (
        "error",
        to_translate(
            "The model does not lie on the reference: their middles are {apart_m:.6g} m apart. Give"
            " three or more points that are seen in both."
        ),
    ),
    "reference.nothing-stable": (
        "error",
        to_translate(
            "No point of the reference is stable by the mask. Check the frame of the mask."
        ),
    ),
    "reference.little-overlap": (
        "error",
        to_translate(
            "Only {share_percent:.1f} % of the model lies on the reference. Check that both are in"
            " one frame, or give three points that are seen in both."
        ),
    ),
    "reference.few-places": (
        "error",
        to_translate(
            "Only {places} places of the model lie on the reference. Check that both are in one"
            " frame, or give three points that are seen in both."
        ),
    ),
    "reference.little-relief": (
        "error",
        to_translate(
            "The overlap has too little relief to determine {free}. Add points that are seen in"
            " both, or a reference that shows other faces."
        ),
    ),
    "reference.no-extent": (
        "error",
        to_translate("The model is a single point, or empty. Name another model."),
    ),
    "reference.partial": (
        "warning",
        to_translate(
            "Only {share_percent:.0f} % of the model lies on the reference within its errors."
        ),
    ),
    "reference.bent": (
        "warning",
        to_translate(
            "Distances to the reference are alike over more than {side_m:.3g} m: the model is bent,"
            " or parts have changed. Name the stable part."
        ),
    ),
    "reference.fitted": (
        "info",
        to_translate(
            "Fitted to the reference at {places} places ({overlap_percent:.0f} % of the model), off"
            " by {rms_m:.3g} m (robust, 1 sigma). The error is that of {blocks} blocks of"
            " {block_m:.3g} m."
        ),
    ),
    "reference.no-overlap": (
        "error",
        to_translate(
            "{first} and {second} do not overlap: they lie {apart_m:.6g} m apart, and the larger is"
            " {size_m:.4g} m across. Use register --pairs, or check units and CRS."
        ),
    ),
    "crs.taken-over": (
        "warning",
        to_translate(
            "{bare} states no coordinate reference system. It was taken to be in that of the other,"
            " {crs}."
        ),
    ),
    "crs.unclear": (
        "warning",
        to_translate(
            "{first} states {crs}, {second} {other}. They were taken as the same system. Check"
            " this."
        ),
    ),
    "crs.different": (
        "error",
        to_translate(
            "{first} is in {crs}, {second} in {other}. Bring one into the coordinate reference"
            " system of the other."
        ),
    ),
    "crs.other-heights": (
        "warning",
        to_translate(
            "Their heights are of different systems ({first}, {second}): the difference between"
            " these is part of every distance."
        ),
    ),
    "cameras.heights": (
        "warning",
        to_translate(
            "The heights of the cameras were taken as they are: {reference}. Sea level and"
            " ellipsoid differ by {geoid} here. Check one height against a map."
        ),
    ),
    "cameras.no-heights": (
        "error",
        to_translate(
            "None of the camera positions has a height. Give heights, or another observation."
        ),
    ),
    "cameras.without-height": (
        "warning",
        to_translate("{count} camera position without a height was left out: {photos}."),
        to_translate("{count} camera positions without a height were left out: {photos}."),
    ),
    "cameras.other-heights": (
        "warning",
        to_translate(
            "The height of {count} photo has another reference than the others ({usual}), and it"
            " was left out: {photos}."
        ),
        to_translate(
            "The heights of {count} photos have another reference than the others ({usual}), and"
            " they were left out: {photos}."
        ),
    ),
    "cameras.left-out": (
        "warning",
        to_translate(
            "The position of {count} photo contradicts the others and was left out: {photos}."
        ),
        to_translate(
            "The positions of {count} photos contradict the others and were left out: {photos}."
        ),
    ),
    "cameras.in-degrees": (
        "error",
        to_translate(
            "The camera positions are in degrees. Name the projected coordinate reference system of"
            " the model with --crs, such as {zone}."
        ),
    ),
    "cameras.look-up": (
        "warning",
        to_translate(
            "{count} camera looks up to the sky after this registration: the model may be upside"
            " down. Check exchanged x and y, and lines called level."
        ),
        to_translate(
            "All {count} cameras look up to the sky after this registration: the model may be"
            " upside down. Check exchanged x and y, and lines called level."
        ),
    ),
    "cameras.noise": (
        "warning",
        to_translate(
            "The camera positions have errors of {error_m:.3g} m within an extent of {extent_m:.3g}"
            " m (RMS): the rotation is uncertain. Add control points, or compass and length."
        ),
    ),
    "cameras.unsure": (
        "error",
        to_translate(
            "The errors of the camera positions are as large as their distances: the rotation is"
            " uncertain by more than {limit_deg:.0f}°. Add control points."
        ),
    ),
    "cameras.none-known": (
        "error",
        to_translate(
            "None of the {photos} photos of the table is among the cameras of the model ({first},"
            " …). They are called {known}, …. Check the names."
        ),
    ),
    "cameras.unknown-photos": (
        "warning",
        to_translate(
            "{count} photo of the table is not among the cameras of the model and was left out:"
            " {photos}."
        ),
        to_translate(
            "{count} photos of the table are not among the cameras of the model and were left out:"
            " {photos}."
        ),
    ),
    "cameras.no-poses": (
        "error",
        to_translate(
            "The file of the model's cameras has their centres alone. Give a file with poses, such"
            " as cameras.json, Metashape XML or COLMAP."
        ),
    ),
    "cameras.missing": (
        "error",
        to_translate(
            "The cameras of the model are not known. Put its cameras.json beside the model, or name"
            " their file."
        ),
    ),
    "compass.radians": (
        "warning",
        to_translate(
            "The angles look like radians: no azimuth is above 6.29 and no dip above 1.58. Multiply"
            " them by 57.29578."
        ),
    ),
    "compass.other-azimuth": (
        "warning",
        to_translate(
            "{labels} would agree with the others if {turn_deg:+.0f}° were added: a strike, or the"
            " opposite direction, may have been read as dip direction."
        ),
    ),
    "compass.repeated-names": (
        "warning",
        to_translate(
            "Several readings have the name {labels}, so none can be named or left out alone. Give"
            " each its own."
        ),
    ),
    "line.no-azimuth": (
        "error",
        to_translate("A line with an azimuth needs two places that are not above each other."),
    ),
    "line.one-place": (
        "error",
        to_translate("Both ends of a line are at one place of the model. Choose two places."),
    ),
    "length.other-unit": (
        "warning",
        to_translate("{labels}: by the points, not in metres but in {unit}. Convert the lengths."),
    ),
    "length.unknown-point": (
        "error",
        to_translate(
            "The scale bar names the point {label}, which is not among the pairs. Add it, with its"
            " place on the model."
        ),
    ),
    "length.contradicted": (
        "warning",
        to_translate(
            "{label} is given as {stated_m:.4g} m, and by the points it is {by_points_m:.4g} m ±"
            " {error_m:.2g} m (99.9 %). Measure it again."
        ),
    ),
    "level.away": (
        "warning",
        to_translate(
            "The level lines in {photos} run away from the camera by up to {away_deg:.0f}°:"
            " perspective tilts lines on the outcrop. Mark a horizon instead."
        ),
    ),
    "level.portrait": (
        "warning",
        to_translate(
            "The level lines in {photos} run up and down their photos. If these were not held in"
            " portrait, mark lines that are level."
        ),
    ),
    "level.upright": (
        "warning",
        to_translate(
            "The lines in {photos} run up and down their photos and are parallel: they are upright,"
            " not level. Mark level lines."
        ),
    ),
    "level.outside": (
        "error",
        to_translate(
            "The level line from x {x1:.0f}, y {y1:.0f} to x {x2:.0f}, y {y2:.0f} ends outside of"
            " {photo}, which has {width} x {height} pixels. Correct it."
        ),
    ),
    "north.true-corrected": (
        "info",
        to_translate(
            "Azimuths from true north: {correction_deg:+.2f}° was added for the convergence of"
            " grid north."
        ),
    ),
    "north.true-unchanged": (
        "info",
        to_translate("Azimuths from true north are unchanged: without a CRS, grid north is true."),
    ),
    "north.magnetic-corrected": (
        "info",
        to_translate(
            "Azimuths from magnetic north: {correction_deg:+.2f}° was added, the declination"
            " ({declination_deg:+.2f}°, {source}) less the convergence of grid north"
            " ({convergence_deg:+.2f}°)."
        ),
    ),
    "north.declination-added": (
        "info",
        to_translate(
            "Azimuths from magnetic north: the declination ({correction_deg:+.2f}°, {source}) was"
            " added. The convergence of grid north is not known."
        ),
    ),
    "north.true-yaws-corrected": (
        "info",
        to_translate(
            "Yaws from true north: {minimum_deg:+.1f}° to {maximum_deg:+.1f}° was added for the"
            " convergence of grid north at each photo."
        ),
    ),
    "north.magnetic-yaws-corrected": (
        "info",
        to_translate(
            "Yaws from magnetic north: {minimum_deg:+.1f}° to {maximum_deg:+.1f}° was added, the"
            " declination less the convergence of grid north at each photo."
        ),
    ),
    "north.not-corrected": (
        "warning",
        to_translate(
            "{photos} yaws from true or magnetic north were taken as from grid north, since place"
            " or day is unknown. Give --declination or --date, and --crs."
        ),
    ),
    "north.no-declination": (
        "error",
        to_translate(
            "The declination is not known. Give it with --declination, or the day with --date and"
            " the place by --crs and positions."
        ),
    ),
    "date.invalid": (
        "error",
        to_translate("“{text}” is not a day. Write it as 2024-05-12."),
    ),
    "comparison.model-moved": (
        "warning",
        to_translate("The model has been placed anew. Compare it again."),
    ),
    "comparison.outdated": (
        "warning",
        to_translate(
            "The comparison with {benchmark} of {day} is outdated: the model has changed or was "
            "placed anew. Compare again."
        ),
    ),
    "fit.choose-reference": (
        "info",
        to_translate("Choose the reference: another model of the project, or a file."),
    ),
    "fit.running": ("info", to_translate("The surfaces are being fitted.")),
    "fit.click-right": ("info", to_translate("Click the same point on the right.")),
    "fit.click-left": ("info", to_translate("Click the same point on the left.")),
    "fit.finished": (
        "info",
        to_translate("Register the model by this fit, or click more points and fit it again."),
    ),
    "fit.click-pairs": (
        "info",
        to_translate(
            "Click {minimum} or more points on both sides, far apart and not on a line. If the"
            " models already overlap, fewer or none suffice."
        ),
    ),
    "fit.ready": (
        "info",
        to_translate("Fit the surfaces, or click more points. A ring shows the expected place."),
    ),
    "comparison.planes-matched": (
        "info",
        to_translate(
            "{n} planes were measured on both ({named} matched by name, {near} by nearness)."
        ),
    ),
    "comparison.planes-unmatched": (
        "info",
        to_translate("{first} of the model and {second} of the benchmark have no counterpart."),
    ),
    "comparison.planes-agree": (
        "info",
        to_translate("{share_percent:.0f} % of those with stated errors agree within them."),
    ),
    "comparison.no-planes-matched": (
        "info",
        to_translate("No plane was measured on both: none has the same name or place."),
    ),
    "comparison.no-unit": (
        "warning",
        to_translate(
            "Neither file states its unit, so lengths given in metres are in the unit of both."
            " State it with --unit."
        ),
    ),
    "comparison.no-points": (
        "error",
        to_translate("{name} has no points. Name another file."),
    ),
    "comparison.no-overlap": (
        "error",
        to_translate(
            "No point of the model lies opposite the benchmark. Bring both into one frame, or give"
            " a larger radius."
        ),
    ),
    "comparison.partial": (
        "warning",
        to_translate(
            "Only {share_percent:.0f} % of the model has a counterpart on the benchmark. The other"
            " points took no part."
        ),
    ),
    "comparison.few-points": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the cylinders contain fewer than {count} points of one of the"
            " two, so they have no level of detection. Give a larger radius."
        ),
    ),
    "comparison.error-assumed": (
        "warning",
        to_translate(
            "The error of the registration is unknown and was taken as 0 in the level of detection."
            " State it with --registration-error."
        ),
    ),
    "comparison.large-faces": (
        "warning",
        to_translate(
            "The faces of {name} are large beside the radius: points were put into them. The level"
            " of detection contains the roughness of these faces alone."
        ),
    ),
    "points.invalid": (
        "error",
        to_translate("Points need three finite coordinates each, x, y, z, as an array (n, 3)."),
    ),
    "line.value-missing": (
        "info",
        to_translate("Type the known values of the line in the list."),
    ),
    "registration.not-begun": (
        "info",
        to_translate(
            "Read control points from a file, or click a point and type its coordinates. "
            "Known lines and compass readings place the model in part."
        ),
    ),
    "control.coordinates-missing": (
        "info",
        to_translate("Type the coordinates of the points in the list, or read them from a file."),
    ),
    "control.click-points": (
        "info",
        to_translate(
            "Click the points on the outcrop: {found} of {count} are done. After three (two if"
            " the model is upright), rings show the others."
        ),
    ),
    "registration.with-reference": (
        "info",
        to_translate(
            "With the registration of the other model it may be turned by "
            "{rotation95_deg:.2f}° (95 %)."
        ),
    ),
    "registration.reference-undeclared": (
        "error",
        to_translate(
            "The frame of {model} is not declared, so it cannot place another model. Register it "
            "first, or declare its frame."
        ),
    ),
    "registration.fitted": (
        "info",
        to_translate(
            "{model} was fitted to {other}. The model and its measurements were rotated by "
            "{turn_deg:.2f} degrees."
        ),
    ),
    "registration.sets-turned": (
        "info",
        to_translate("Mean planes turned: {sets}."),
    ),
    "registration.without-reference": (
        "info",
        to_translate("The error of the reference model is not included."),
    ),
}
