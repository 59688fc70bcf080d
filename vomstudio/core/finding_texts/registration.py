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
            "{file} cannot be used: {reason}. The errors of the registration are unknown. Restore"
            " the file, or register the model again."
        ),
    ),
    "registration.unknown-version": (
        "warning",
        to_translate(
            "{file} has version {version}, but this program reads {known}. The registration is"
            " not used. Update the program."
        ),
    ),
    "registration.other-frame": (
        "warning",
        to_translate(
            "The registration in {file} is not used: it places the model in {crs}, but {stated}"
            " is specified. Correct one of them."
        ),
    ),
    "registration.incomplete": (
        "warning",
        to_translate(
            "The earlier registration in {file} cannot complete the new one, because the"
            " coordinates in the model file are not World coordinates."
        ),
    ),
    "registration.reference-error": (
        "info",
        to_translate(
            "Including the error of the reference, the model may be rotated by"
            " {rotation95_deg:.2g}° (95 %) and its scale wrong by {scale95_percent:.2g} %."
        ),
    ),
    "registration.compass-alone": (
        "warning",
        to_translate(
            "North depends on compass readings only. A common offset of ± {north_sigma_deg:g}° (1"
            " sigma) is assumed. Specify its actual error (--north-sigma)."
        ),
    ),
    "registration.parallel-level-lines": (
        "warning",
        to_translate(
            "The level lines are parallel to within {apart_deg:.0f}° and count as one. Add a level"
            " line in another direction, or a plumb line."
        ),
    ),
    "registration.photo-upright": (
        "info",
        to_translate(
            "The upright direction of the photos is used as an observation of the vertical, ±"
            " {sigma_deg:g}° (1 sigma)."
        ),
    ),
    "registration.which-end-up": (
        "warning",
        to_translate(
            "The lines tilt the model by {tip_deg:.0f}° and do not show which way is up. Check that"
            " the model is not upside down."
        ),
    ),
    "registration.poor": (
        "warning",
        to_translate(
            "The model may be rotated by {rotation95_deg:.2g}° (95 %), so planes measured on it are"
            " poor. Add points, lines or readings."
        ),
    ),
    "registration.weak-rotation": (
        "warning",
        to_translate(
            "The registration determines azimuth only to about {azimuth_deg:.1f}° and tilt to"
            " {tilt_deg:.1f}°. Dips and dip directions may be wrong by these angles."
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
            " their combined error is {error_px:.0f} pixels (maximum {limit_px:.0f})."
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
            "{positions} GPS positions were not used in the bundle adjustment: blunders cannot be"
            " detected without redundancy. At least {least} are required."
        ),
    ),
    "crs.outside-area": (
        "error",
        to_translate("{photo} was taken outside the area of use of {crs}. Choose another CRS."),
    ),
    "registration.no-observations": (
        "error",
        to_translate(
            "The model cannot be registered without observations. Add points, directions,"
            " lengths or a reference."
        ),
    ),
    "registration.too-few-points": (
        "error",
        to_translate("{count} point is not enough to register a model. Use at least {least}."),
        to_translate("{count} points are not enough to register a model. Use at least {least}."),
    ),
    "registration.points-and-cameras": (
        "warning",
        to_translate(
            "Control points and cameras differ by {turn_deg:.2g}° in rotation and"
            " {scale_percent:+.2g} % in scale. Register with the more accurate ones, and"
            " check with the others."
        ),
    ),
    "registration.scale-contradicted": (
        "warning",
        to_translate(
            "The fixed scale contradicts the other observations, which make the model {times:.4g}"
            " times as large (± {error95_percent:.2g} %, 95 %). Check values and units."
        ),
    ),
    "registration.north-quarter-turn": (
        "warning",
        to_translate(
            "All {readings} are rotated by {turn_deg:+.0f}° ± {error95_deg:.0f}° (95 %), so their"
            " north was not used. Check the columns, then add {correction_deg:+.0f}° to the"
            " azimuths."
        ),
    ),
    "registration.north-turned": (
        "warning",
        to_translate(
            "All {readings} are rotated by {turn_deg:+.1f}° ± {error95_deg:.1f}° (95 %), so"
            " their north was not used. Check --declination, or specify --north-sigma."
        ),
    ),
    "registration.unknown-label": (
        "error",
        to_translate("{label} cannot be left out, because it does not exist. Available: {known}."),
    ),
    "registration.without": (
        "info",
        to_translate("Left out as requested: {labels}."),
    ),
    "registration.pending": (
        "info",
        to_translate("The registration is being computed. Please wait."),
    ),
    "registration.applied": (
        "info",
        *to_translate_n(
            "{model} and its features were placed using {count} observation and rotated by"
            " {turn_deg:.1f}°.",
            "{model} and its features were placed using {count} observations and rotated by"
            " {turn_deg:.1f}°.",
        ),
    ),
    "registration.control-rms": (
        "info",
        to_translate(
            "The RMS error of the control points is {control_m:.3g} m. Check points were not used."
        ),
    ),
    "registration.check-rms": (
        "info",
        to_translate(
            "The RMS error is {control_m:.3g} m at control points and {check_m:.3g} m at check"
            " points."
        ),
    ),
    "registration.positions-rms": (
        "info",
        to_translate("The RMS error of the camera positions is {positions_m:.3g} m."),
    ),
    "registration.left-out": (
        "warning",
        to_translate(
            "Left out, because they contradict the other observations: {labels}. Check the values."
        ),
    ),
    "registration.blunder": (
        "warning",
        to_translate(
            "Significant outliers: {labels}. Without them, the model rotates by {turned_deg:.2g}°"
            " and the scale changes by {scale_percent:+.2g} %. Check the values, or leave them out"
            " (--without)."
        ),
    ),
    "registration.suspect": (
        "warning",
        to_translate(
            "{label} has an error of {error_deg:.0f}°. Without it, the others agree within"
            " {others_deg:.1f}° and the model rotates by {turn_deg:.1f}°. Check it, or use"
            " --without."
        ),
    ),
    "registration.residuals-large": (
        "warning",
        to_translate(
            "The residuals are {times:.1f} times larger than the stated accuracies allow, so all"
            " errors were increased by this factor. Check values and accuracies."
        ),
    ),
    "registration.residuals-small": (
        "warning",
        to_translate(
            "The residuals are {times:,.0f} times smaller than the stated accuracies. Check that"
            " the accuracies are in metres, because all stated errors depend on them."
        ),
    ),
    "registration.readings-copied": (
        "warning",
        to_translate(
            "The readings agree {times:,.0f} times better than their stated accuracies allow, so"
            " they may come from the model itself. Check them."
        ),
    ),
    "registration.ambiguous": (
        "warning",
        to_translate(
            "A different rotation fits equally well. The one that rotates the model least was used."
            " Add a point or a line in another direction."
        ),
    ),
    "registration.error-assumed": (
        "warning",
        to_translate(
            "The accuracy of the {kinds} is unknown, so a typical one was assumed. Specify it."
        ),
    ),
    "registration.points-nowhere": (
        "warning",
        to_translate(
            "The point errors are {share_percent:.0f} % of the points' extent: labels, coordinates"
            " or heights are wrong or from two systems. Compare the table with the model."
        ),
    ),
    "registration.rotation-unknown": (
        "warning",
        to_translate(
            "The rotation of the model is practically unknown. Add more widely spread"
            " observations, or correct those listed above."
        ),
    ),
    "registration.weak-scale": (
        "warning",
        to_translate(
            "The scale is known only to {error95_percent:.1f} % (95 %), which affects lengths and"
            " areas. Place points farther apart, or measure a scale bar."
        ),
    ),
    "registration.weakest-axis": (
        "info",
        to_translate(
            "The model may be rotated by {error95_deg:.2g}° (95 %) about the axis"
            " {trend}/{plunge_deg:02.0f}. Dips and dip directions may be wrong by this angle."
        ),
    ),
    "registration.worth-adding": (
        "info",
        to_translate(
            "Another control point near {x:.1f}, {y:.1f}, {z:.1f} would reduce this error to"
            " {after_deg:.2g}°."
        ),
    ),
    "registration.not-known": (
        "warning",
        to_translate(
            "Not determined by this registration: {parameters}. The values in the model file are"
            " kept."
        ),
    ),
    "registration.vertical": (
        "info",
        to_translate(
            "The vertical is known to ± {error95_deg:.2g}° (95 %), so dips may be wrong by this"
            " angle."
        ),
    ),
    "registration.bowed": (
        "warning",
        to_translate(
            "The model is bowed according to {evidence}: edges are {rise_m:.2g} m off its mean"
            " plane ({where}), dips err by {side_deg:.1f}° ± {error95_deg:.1f}°. Calibrate the"
            " lenses."
        ),
    ),
    "registration.moved": (
        "warning",
        to_translate(
            "The registration moves the model {distance_km:,.1f} km from its coordinates in {crs}."
            " If these are correct, check zone, CRS, unit and column order."
        ),
    ),
    "registration.turned": (
        "warning",
        to_translate(
            "The registration rotates the model by {turn_deg:.0f}° from its orientation in {crs}."
            " If that orientation is correct, check for swapped columns or labels."
        ),
    ),
    "registration.off-model": (
        "error",
        to_translate(
            "The points ({x:,.2f}, {y:,.2f}, {z:,.2f}, …) are far from the model, whose"
            " centre is ({mx:,.2f}, {my:,.2f}, {mz:,.2f}). Use coordinates of the model file."
        ),
    ),
    "registration.upside-down": (
        "warning",
        to_translate(
            "This registration turns the model upside down ({tip_deg:.0f}°). Easting and northing"
            " may be swapped, or heights may be depths. Check the columns."
        ),
    ),
    "registration.upside-down-or-mirror": (
        "warning",
        to_translate(
            "This registration turns the model upside down ({tip_deg:.0f}°), or the points"
            " are mirrored. Swap easting and northing, or add points higher or lower."
        ),
    ),
    "lens.bowing": (
        "warning",
        to_translate(
            "Lens errors (95 %) may make dips at the edge wrong by {side_deg:.1f}° relative to"
            " the middle. Calibrate the lenses, or add oblique photos."
        ),
    ),
    "lens.stretch": (
        "warning",
        to_translate(
            "Lens errors (95 %) can stretch depths by {share_percent:.1f} % and rotate planes by"
            " up to {turn_deg:.1f}°. Calibrate the lens, or add control points."
        ),
    ),
    "attitude.left-out": (
        "warning",
        to_translate(
            "The attitudes of these photos deviate from the others by more than {limit_deg:.0f}°"
            " and were left out: {photos}."
        ),
    ),
    "attitude.yaw-left-out": (
        "warning",
        to_translate(
            "The yaws of these photos deviate from the others by about {off_deg:+d}° and were"
            " left out: {photos}."
        ),
    ),
    "attitude.convention-left-out": (
        "warning",
        to_translate(
            "The attitudes of these photos were left out: {photos}. They would agree with the"
            " others if {change}."
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
        to_translate("These verticals would agree if the photos were rotated by {turns_deg}°."),
    ),
    "attitude.other-convention": (
        "warning",
        to_translate(
            "The attitudes of the photos disagree by {scatter_deg:.0f}°, but would agree within"
            " {least_deg:.1f}° if {change}. Check the convention of the table."
        ),
    ),
    "attitude.turned-photos": (
        "warning",
        to_translate(
            "The verticals of the photos disagree by {scatter_deg:.0f}°, but would agree within"
            " {least_deg:.1f}° if rotated by {turn_deg}°. Check whether a program rotated the"
            " photos."
        ),
    ),
    "attitude.too-steep": (
        "warning",
        to_translate(
            "These photos look too steeply up or down for a compass direction, so only their"
            " vertical is used: {photos}."
        ),
    ),
    "attitude.not-in-photos": (
        "error",
        to_translate(
            "The photos contain no attitudes: no gimbal angles, acceleration or view direction."
            " Specify a table of attitudes."
        ),
    ),
    "attitude.from-drone": (
        "warning",
        to_translate(
            "The yaws of {photos} photos come from a drone's gimbal. True north and the error of"
            " a compass are assumed."
        ),
    ),
    "attitude.north-assumed": (
        "warning",
        to_translate(
            "{photos} photos do not state whether their direction is from true or magnetic north."
            " Magnetic north was assumed."
        ),
    ),
    "reference.apart": (
        "error",
        to_translate(
            "Model and reference do not overlap: their centres are {apart_m:.6g} m apart. Pick"
            " three or more points visible in both."
        ),
    ),
    "reference.nothing-stable": (
        "error",
        to_translate(
            "The mask marks no point of the reference as stable. Check the frame of the mask."
        ),
    ),
    "reference.little-overlap": (
        "error",
        to_translate(
            "Only {share_percent:.1f} % of the model overlaps the reference. Check that both are in"
            " the same frame, or pick three points visible in both."
        ),
    ),
    "reference.few-places": (
        "error",
        to_translate(
            "Model and reference overlap at only {places} positions. Check that both are in the"
            " same frame, or pick three points visible in both."
        ),
    ),
    "reference.little-relief": (
        "error",
        to_translate(
            "The overlap has too little relief to determine {free}. Add points visible in both,"
            " or a reference that shows other faces."
        ),
    ),
    "reference.no-extent": (
        "error",
        to_translate("The model is empty or a single point. Specify another model."),
    ),
    "reference.partial": (
        "warning",
        to_translate(
            "Only {share_percent:.0f} % of the model agrees with the reference within its errors."
        ),
    ),
    "reference.bent": (
        "warning",
        to_translate(
            "Distances to the reference are correlated over more than {side_m:.3g} m: the model"
            " is bent, or parts have moved. Specify the stable part."
        ),
    ),
    "reference.fitted": (
        "info",
        to_translate(
            "Fitted to the reference at {places} positions ({overlap_percent:.0f} % of the"
            " model); residual {rms_m:.3g} m (robust, 1 sigma). Errors are computed from"
            " {blocks} blocks of {block_m:.3g} m."
        ),
    ),
    "reference.no-overlap": (
        "error",
        to_translate(
            "{first} and {second} do not overlap: they are {apart_m:.6g} m apart, and the larger"
            " one is {size_m:.4g} m wide. Use register --pairs, or check units and CRS."
        ),
    ),
    "crs.taken-over": (
        "warning",
        to_translate(
            "{bare} has no coordinate reference system. It is assumed to be {crs}, as in the"
            " other file."
        ),
    ),
    "crs.unclear": (
        "warning",
        to_translate(
            "{first} is in {crs}, {second} in {other}. The two systems are assumed to be the same."
            " Check this."
        ),
    ),
    "crs.different": (
        "error",
        to_translate(
            "{first} is in {crs}, {second} in {other}. Convert one to the coordinate reference"
            " system of the other."
        ),
    ),
    "crs.other-heights": (
        "warning",
        to_translate(
            "The heights refer to different systems ({first}, {second}), so every distance"
            " includes the difference between them."
        ),
    ),
    "cameras.heights": (
        "warning",
        to_translate(
            "The camera heights were used unchanged: {reference}. Sea level and ellipsoid differ"
            " by {geoid} here. Check one height against a map."
        ),
    ),
    "cameras.no-heights": (
        "error",
        to_translate("No camera position has a height. Add heights, or another observation."),
    ),
    "cameras.without-height": (
        "warning",
        to_translate("{count} camera position without a height was left out: {photos}."),
        to_translate("{count} camera positions without a height were left out: {photos}."),
    ),
    "cameras.other-heights": (
        "warning",
        to_translate(
            "The height of {count} photo was left out, because its reference differs from that of"
            " the others ({usual}): {photos}."
        ),
        to_translate(
            "The heights of {count} photos were left out, because their reference differs from that"
            " of the others ({usual}): {photos}."
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
            "The camera positions are in degrees. Specify the projected coordinate reference"
            " system of the model with --crs, such as {zone}."
        ),
    ),
    "cameras.look-up": (
        "warning",
        to_translate(
            "{count} camera points to the sky after registration, so the model may be upside"
            " down. Check for swapped x and y, and check level lines."
        ),
        to_translate(
            "All {count} cameras point to the sky after registration, so the model may be upside"
            " down. Check for swapped x and y, and check level lines."
        ),
    ),
    "cameras.noise": (
        "warning",
        to_translate(
            "Camera positions have errors of {error_m:.3g} m (RMS) over an extent of {extent_m:.3g}"
            " m, so rotation is uncertain. Add control points, or compass readings and a length."
        ),
    ),
    "cameras.unsure": (
        "error",
        to_translate(
            "The errors of the camera positions are as large as the distances between them. The"
            " rotation is uncertain by more than {limit_deg:.0f}°. Add control points."
        ),
    ),
    "cameras.none-known": (
        "error",
        to_translate(
            "No photo in the table ({first}, …; {photos} in all) is among the cameras of the model"
            " ({known}, …). Check the names."
        ),
    ),
    "cameras.unknown-photos": (
        "warning",
        to_translate(
            "{count} photo in the table is not among the cameras of the model and was left out:"
            " {photos}."
        ),
        to_translate(
            "{count} photos in the table are not among the cameras of the model and were left"
            " out: {photos}."
        ),
    ),
    "cameras.no-poses": (
        "error",
        to_translate(
            "The camera file of the model contains only camera centres. Use a file with poses, such"
            " as cameras.json, Metashape XML or COLMAP."
        ),
    ),
    "cameras.missing": (
        "error",
        to_translate(
            "The cameras of the model are unknown. Put cameras.json next to the model, or specify"
            " the camera file."
        ),
    ),
    "compass.radians": (
        "warning",
        to_translate(
            "The angles appear to be in radians: no azimuth is above 6.29 and no dip above 1.58."
            " Multiply them by 57.29578."
        ),
    ),
    "compass.other-azimuth": (
        "warning",
        to_translate(
            "{labels} would agree with the others after adding {turn_deg:+.0f}°: a strike, or the"
            " opposite direction, may have been read as dip direction."
        ),
    ),
    "compass.repeated-names": (
        "warning",
        to_translate(
            "Several readings are called {labels}, so a single one cannot be left out. Give each"
            " its own name."
        ),
    ),
    "line.no-azimuth": (
        "error",
        to_translate(
            "A line with an azimuth needs two points that are not on the same vertical line. Choose"
            " other points."
        ),
    ),
    "line.one-place": (
        "error",
        to_translate(
            "Both ends of the line have the same position on the model. Choose two different"
            " positions."
        ),
    ),
    "length.other-unit": (
        "warning",
        to_translate(
            "{labels}: judging by the points, these lengths are in {unit}, not metres. Convert"
            " them."
        ),
    ),
    "length.unknown-point": (
        "error",
        to_translate(
            "The scale bar refers to the point {label}, which is not among the pairs. Add it,"
            " with its position on the model."
        ),
    ),
    "length.contradicted": (
        "warning",
        to_translate(
            "{label} has a stated length of {stated_m:.4g} m, but the points give {by_points_m:.4g}"
            " m ± {error_m:.2g} m (99.9 %). Measure it again."
        ),
    ),
    "level.away": (
        "warning",
        to_translate(
            "The level lines in {photos} run away from the camera by up to {away_deg:.0f}°, so"
            " perspective tilts them. Mark a horizon instead."
        ),
    ),
    "level.portrait": (
        "warning",
        to_translate(
            "The level lines in {photos} run up and down their photos. Unless these are portrait"
            " photos, mark lines that are level."
        ),
    ),
    "level.upright": (
        "warning",
        to_translate(
            "The lines in {photos} run up and down and are parallel, so they are upright, not"
            " level. Mark level lines."
        ),
    ),
    "level.outside": (
        "error",
        to_translate(
            "The level line from x {x1:.0f}, y {y1:.0f} to x {x2:.0f}, y {y2:.0f} ends outside"
            " {photo}, which has {width} x {height} pixels. Correct it."
        ),
    ),
    "north.true-corrected": (
        "info",
        to_translate(
            "{correction_deg:+.2f}° was added to azimuths from true north, for the convergence of"
            " grid north."
        ),
    ),
    "north.true-unchanged": (
        "info",
        to_translate(
            "Azimuths from true north are unchanged: without a CRS, grid north is true north."
        ),
    ),
    "north.magnetic-corrected": (
        "info",
        to_translate(
            "{correction_deg:+.2f}° was added to azimuths from magnetic north: the declination"
            " ({declination_deg:+.2f}°, {source}) minus the convergence of grid north"
            " ({convergence_deg:+.2f}°)."
        ),
    ),
    "north.declination-added": (
        "info",
        to_translate(
            "The declination ({correction_deg:+.2f}°, {source}) was added to azimuths from"
            " magnetic north. The convergence of grid north is unknown."
        ),
    ),
    "north.true-yaws-corrected": (
        "info",
        to_translate(
            "{minimum_deg:+.1f}° to {maximum_deg:+.1f}° was added to yaws from true north, for"
            " the convergence of grid north at each photo."
        ),
    ),
    "north.magnetic-yaws-corrected": (
        "info",
        to_translate(
            "{minimum_deg:+.1f}° to {maximum_deg:+.1f}° was added to yaws from magnetic north:"
            " the declination minus the convergence of grid north at each photo."
        ),
    ),
    "north.not-corrected": (
        "warning",
        to_translate(
            "{photos} yaws from true or magnetic north were not corrected to grid north, because"
            " their position or date is unknown. Specify --declination or --date, and --crs."
        ),
    ),
    "north.no-declination": (
        "error",
        to_translate(
            "The declination is unknown. Specify it, or the date and the position of the readings"
            " in a CRS."
        ),
    ),
    "date.invalid": (
        "error",
        to_translate("“{text}” is not a date. Use the form 2024-05-12."),
    ),
    "comparison.model-moved": (
        "warning",
        to_translate("The position of the model has changed. Compare it again."),
    ),
    "comparison.outdated": (
        "warning",
        to_translate(
            "The comparison of {day} with {benchmark} is outdated, because the model or its"
            " position has changed. Compare again."
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
        to_translate("Register the model with this fit, or click more points and fit it again."),
    ),
    "fit.click-pairs": (
        "info",
        to_translate(
            "Click {minimum} or more points on both sides, far apart and not collinear. If the"
            " models already overlap, fewer or none are enough."
        ),
    ),
    "fit.ready": (
        "info",
        to_translate("Fit the surfaces, or click more points. A ring shows the expected position."),
    ),
    "comparison.planes-matched": (
        "info",
        to_translate(
            "{n} planes were measured on both models ({named} matched by name, {near} by distance)."
        ),
    ),
    "comparison.planes-unmatched": (
        "info",
        to_translate(
            "Planes without a counterpart: {first} of the model, {second} of the benchmark."
        ),
    ),
    "comparison.planes-agree": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the planes with stated errors agree within these errors."
        ),
    ),
    "comparison.no-planes-matched": (
        "info",
        to_translate("No plane was measured on both models: no names or positions match."),
    ),
    "comparison.no-unit": (
        "warning",
        to_translate(
            "Neither file specifies its unit, so lengths in the options are in model units, not"
            " metres. Specify the unit with --unit."
        ),
    ),
    "comparison.no-points": (
        "error",
        to_translate("{name} has no points. Specify another file."),
    ),
    "comparison.no-overlap": (
        "error",
        to_translate(
            "No point of the model has a counterpart on the benchmark. Convert both to the same"
            " frame, or use a larger radius."
        ),
    ),
    "comparison.partial": (
        "warning",
        to_translate(
            "Only {share_percent:.0f} % of the model has a counterpart on the benchmark. The"
            " other points were not compared."
        ),
    ),
    "comparison.few-points": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the cylinders contain fewer than {count} points of one"
            " model, so they have no level of detection. Use a larger radius."
        ),
    ),
    "comparison.error-assumed": (
        "warning",
        to_translate(
            "The registration error is unknown and was assumed to be 0 in the level of detection."
            " Specify it with --registration-error."
        ),
    ),
    "comparison.large-faces": (
        "warning",
        to_translate(
            "The faces of {name} are large compared with the radius, so points were sampled on"
            " them. The level of detection includes only the mesh roughness."
        ),
    ),
    "points.invalid": (
        "error",
        to_translate("Points need three finite coordinates x, y, z each, as an array (n, 3)."),
    ),
    "line.value-missing": (
        "info",
        to_translate("Enter the known values of the line in the list."),
    ),
    "registration.not-begun": (
        "info",
        to_translate(
            "Read control points from a file, or click a point and enter its coordinates. Known"
            " lines and compass readings register the model only in part."
        ),
    ),
    "control.coordinates-missing": (
        "info",
        to_translate("Enter the coordinates of the points in the list, or read them from a file."),
    ),
    "control.click-points": (
        "info",
        to_translate(
            "Click the points on the outcrop ({found} of {count} are done). After three points (two"
            " if the model is upright), rings show the others."
        ),
    ),
    "registration.with-reference": (
        "info",
        to_translate(
            "Including the registration of the other model, it may be rotated by"
            " {rotation95_deg:.2f}° (95 %)."
        ),
    ),
    "registration.reference-undeclared": (
        "error",
        to_translate(
            "The frame of {model} is not declared, so no other model can be fitted to it."
            " Register it first, or declare its frame."
        ),
    ),
    "registration.fitted": (
        "info",
        to_translate(
            "{model} was fitted to {other}. The model and its features were rotated by"
            " {turn_deg:.2f}°."
        ),
    ),
    "registration.sets-turned": (
        "info",
        to_translate("Mean planes rotated: {sets}."),
    ),
    "registration.without-reference": (
        "info",
        to_translate("The error of the reference model is not included."),
    ),
}
