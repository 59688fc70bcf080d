"""Texts of the findings about planes and traces."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "trace.beside": (
        "warning",
        to_translate(
            "Points {start} to {end} cross rock without a contact, {offset_m:.2g} m off the plane"
            " of the others. Add a way-point there on the correct contact."
        ),
    ),
    "lines.not-planar": (
        "warning",
        to_translate(
            "The lines are three-dimensional and were projected onto the plane {plane}: scatter"
            " about it {scatter_m:.2g} m, lengths {shortening_percent:.1f} % shorter. Use --plane"
            " for another plane."
        ),
    ),
    "lines.no-plane": (
        "error",
        to_translate(
            "The lines are all collinear, so they do not define a plane. Specify their plane"
            " (--plane DD/D)."
        ),
    ),
    "lines.no-heights": (
        "warning",
        to_translate(
            "Lines without heights: {lines}. They cannot be projected onto the plane {plane}."
            " Export them with heights."
        ),
    ),
    "lines.edge-on": (
        "error",
        to_translate(
            "Projected onto the plane {plane} of the lines, the {option} is seen edge-on. Specify"
            " it with heights (a circle as X,Y,Z,R)."
        ),
    ),
    "lines.closed": (
        "warning",
        to_translate(
            "Closed lines, such as outlines of patches, are not traces. Left out: {lines}."
        ),
    ),
    "trace.straight": (
        "info",
        to_translate(
            "The trace is straight: its plane contains the line {line} within {width_deg:.1f}°,"
            " and dips between {low_deg:.0f} and {high_deg:.0f}°."
        ),
    ),
    "trace.compatible-sets": ("info", to_translate("Compatible sets: {sets}.")),
    "trace.no-compatible-set": ("info", to_translate("No set is compatible with the trace.")),
    "trace.plane-of-set": (
        "info",
        to_translate("As a plane of {set}, the trace has the attitude {plane} (95 %)."),
    ),
    "trace.accepted": (
        "info",
        to_translate(
            "Proposed with the cost {cost} and a minimum length of {length_m:.3g} m, and accepted."
        ),
    ),
    "trace.edited": (
        "info",
        to_translate(
            "Proposed with the cost {cost} and a minimum length of {length_m:.3g} m, and edited."
        ),
    ),
    "trace.not-straight": (
        "error",
        to_translate(
            "The trace {trace} is not straight: it has its own plane, or none. Choose a straight"
            " trace."
        ),
    ),
    "trace.not-a-pair": (
        "error",
        to_translate(
            "“{value}” is not a pair of traces. Specify two traces, such as {first},{second}."
        ),
    ),
    "plane.local": (
        "info",
        to_translate(
            "The face bends by {bend_deg:.2g}° from edge to edge, so its plane is valid only"
            " locally. As a regional attitude, its error is {regional_deg:.2g}°."
        ),
    ),
    "plane.long-roughness": (
        "warning",
        to_translate(
            "The roughness wavelength is as long as the trace, so the larger of two error estimates"
            " is used. Pick a longer trace."
        ),
    ),
    "plane.too-small": (
        "warning",
        to_translate(
            "The extent is {ratio:.1f} times the resolution of the model (minimum {minimum:g})."
            " Pick a larger feature, or use a finer model."
        ),
    ),
    "plane.small": (
        "info",
        to_translate(
            "The extent is {ratio:g} times the resolution of the model ({recommended:g}"
            " recommended). The expected error of planes of this size is {error_deg:.2g}°."
        ),
    ),
    "plane.not-coplanar": (
        "warning",
        to_translate(
            "The coplanarity is {coplanarity:.1f} (minimum {minimum:g}). Pick points of a single"
            " plane."
        ),
    ),
    "plane.collinear": (
        "warning",
        to_translate(
            "The collinearity is {collinearity:.1f} (maximum {maximum:g}). Add points where the"
            " trace bends, or enlarge the patch."
        ),
    ),
    "plane.unknown-resolution": (
        "info",
        to_translate(
            "The resolution of the model is unknown, so the extent could not be compared with it."
        ),
    ),
    "plane.in-face": (
        "warning",
        to_translate(
            "The trace follows the outcrop face to within {angle_deg:.2g}° and has little relief."
            " Pick points where it cuts into the face."
        ),
    ),
    "plane.along-face": (
        "info",
        to_translate(
            "The plane follows the outcrop face to within {angle_deg:.2g}°. Check whether that face"
            " is the structure itself."
        ),
    ),
    "plane.three-points": (
        "warning",
        to_translate("Three points fit exactly, so no error can be estimated. Add points."),
    ),
    "plane.three-straight-points": (
        "warning",
        to_translate(
            "Three nearly collinear points barely constrain a plane, and their error is unknown."
            " Add points where the trace bends."
        ),
    ),
    "plane.three-distinct-points": (
        "warning",
        to_translate(
            "Only 3 of the {n} points are distinct, so no error can be estimated. Add points."
        ),
    ),
    "plane.too-few-points": (
        "warning",
        to_translate(
            "The plane has fewer than {minimum} independent points, so their scatter may be small"
            " by chance. Add points."
        ),
    ),
    "plane.registration": (
        "warning",
        to_translate(
            "The registration of the model can tilt the plane by {error_deg:.2g}° (limit"
            " {limit_deg:g}°). Improve the registration."
        ),
    ),
    "plane.too-straight": (
        "warning",
        to_translate(
            "The trace is too straight, so its plane is uncertain by {error_deg:.2g}°"
            " (limit {limit_deg:g}°). Add points where it bends or cuts into the face."
        ),
    ),
    "plane.resolution": (
        "warning",
        to_translate(
            "The resolution of the model can tilt the plane by {error_deg:.2g}° (limit"
            " {limit_deg:g}°). Pick a wider feature, or use a finer model."
        ),
    ),
    "plane.uncertain": (
        "warning",
        to_translate(
            "The plane is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°). Add points"
            " where the trace bends."
        ),
    ),
    "plane.uncertain-patch": (
        "warning",
        to_translate(
            "The plane is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°). Enlarge the patch."
        ),
    ),
    "plane.scattered": (
        "info",
        to_translate(
            "The points scatter about the plane: M {M:.1f}, coplanarity {coplanarity:.1f} (M"
            " above {recommended:g} recommended)."
        ),
    ),
    "plane.almost-straight": (
        "info",
        to_translate(
            "The points are nearly collinear: collinearity {collinearity:.1f}, K {K:.2g} (below"
            " {recommended:g} recommended)."
        ),
    ),
    "plane.unbounded-error": (
        "info",
        to_translate(
            "The trace is too straight for its scatter, so the angular error of its plane may reach"
            " 90°."
        ),
    ),
    "plane.levels": (
        "warning",
        to_translate(
            "The points are on two levels {gap_m:.2g} m apart, with the plane between them. Reduce"
            " the Distance setting, or paint each level separately."
        ),
    ),
    "plane.bowed": (
        "warning",
        to_translate(
            "The face continues as a curved surface, so this patch depends on the thresholds. Use"
            " its plane only where the face looks planar."
        ),
    ),
    "plane.earlier-rule": (
        "info",
        to_translate(
            "The resolution and the outcrop face were measured with an earlier method. Use"
            " Interpret > Update earlier features to measure them again."
        ),
    ),
    "plane.to-and-fro": (
        "info",
        to_translate(
            "The points go back and forth, as if picked all over a face. If this is not a trace,"
            " use a patch."
        ),
    ),
    "line.plane-error-unknown": (
        "warning",
        to_translate(
            "The line depends on a plane with unknown error, so its own error is unknown. Measure"
            " that plane again."
        ),
    ),
    "line.two-points": (
        "warning",
        to_translate(
            "Two points fit exactly, so no error can be estimated. Pick more points along the line."
        ),
    ),
    "line.registration": (
        "warning",
        to_translate(
            "The line is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°), mainly because of"
            " the registration. Improve the registration."
        ),
    ),
    "line.uncertain-plane": (
        "warning",
        to_translate(
            "The line is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°), mainly because of"
            " its planes. Improve their picks."
        ),
    ),
    "line.uncertain": (
        "warning",
        to_translate(
            "The line is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°). Pick a"
            " longer or straighter line."
        ),
    ),
    "line.off-plane": (
        "warning",
        to_translate("The line is {angle_deg:.2g}° off its plane. Pick it on that plane."),
    ),
    "line.scattered-set": (
        "warning",
        to_translate(
            "The planes of one set scatter by {scatter_deg:.2g}° (RMS) about their mean, as in a"
            " fold. Use one limb, or the fold axis."
        ),
    ),
    "line.plane-missing": (
        "warning",
        to_translate(
            "The plane of the line was deleted or has no fit, so the rake is unknown. Choose"
            " another plane."
        ),
    ),
    "plane.no-band": (
        "error",
        to_translate("The errors of this plane are unknown, so it has no error band. Add points."),
    ),
    "plane.regression-band": (
        "error",
        to_translate(
            "A plane fitted by regression has no error band. Fit it by the moment of inertia (pca)."
        ),
    ),
    "plane.too-uncertain": (
        "error",
        to_translate(
            "The plane is uncertain by {error_deg:.0f}°, so it cannot be extended. Add points."
        ),
    ),
    "points.collinear": (
        "error",
        to_translate(
            "All points are collinear, so they do not define a plane. Add a point off their line."
        ),
    ),
    "planes.parallel": (
        "error",
        to_translate(
            "The two planes are parallel, so they have no line of intersection. Choose other"
            " planes."
        ),
    ),
    "line.across-plane": (
        "error",
        to_translate(
            "The line is perpendicular to the plane, so it has no rake. Choose another plane."
        ),
    ),
    "plane.parallel-traces": (
        "error",
        to_translate(
            "The two traces are nearly parallel ({angle_deg:.1f}°), so together they do not"
            " determine a plane. Choose another trace."
        ),
    ),
    "points.not-finite": (
        "error",
        to_translate(
            "Some points have coordinates that are not finite numbers. Remove these points."
        ),
    ),
    "points.offsets": (
        "error",
        to_translate("Offsets must increase from 0 to the number of points. Correct them."),
    ),
    "plane.parallel-to-axis": (
        "error",
        to_translate(
            "The plane is parallel to the axis {axis}, so regression along {axis} is impossible."
            " Use another axis, or the moment of inertia (pca)."
        ),
    ),
    "points.uncertain-about-line": (
        "warning",
        to_translate(
            "The points are nearly collinear, so the plane is uncertain by {error_deg:.0f}° (95"
            " %) about their line. Add a point off this line."
        ),
    ),
    "points.too-near": (
        "warning",
        to_translate(
            "The points are too close together relative to their error, so the plane is uncertain"
            " by {error_deg:.0f}° (95 %). Add points farther away."
        ),
    ),
    "points.nearly-collinear": (
        "warning",
        to_translate(
            "The points are nearly collinear: an error of {error_m:g} m rotates the plane by"
            " {turn_deg:.2g}°. Add a point off the line, or enter the error."
        ),
    ),
    "plane.none-fitted": (
        "error",
        to_translate("None of the {count} planes can be fitted. The first problem: {reason}"),
    ),
    "plane.model-not-open": (
        "error",
        to_translate("The model on which the plane was picked is not open. Open it first."),
    ),
}
