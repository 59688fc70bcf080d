"""Texts of the findings about planes and traces."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
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
    "trace.straight": (
        "info",
        to_translate(
            "The trace is straight: its plane contains the line {line}, within {width_deg:.1f}°,"
            " and dips between {low_deg:.0f} and {high_deg:.0f}°."
        ),
    ),
    "trace.compatible-sets": ("info", to_translate("Compatible sets: {sets}.")),
    "trace.no-compatible-set": ("info", to_translate("No set is compatible with the trace.")),
    "trace.plane-of-set": (
        "info",
        to_translate("As a plane of {set} it is {plane} (95 %)."),
    ),
    "trace.accepted": (
        "info",
        to_translate("Proposed by {cost} among lines of at least {length_m:.3g} m, and accepted."),
    ),
    "trace.edited": (
        "info",
        to_translate("Proposed by {cost} among lines of at least {length_m:.3g} m, and edited."),
    ),
    "trace.not-straight": (
        "error",
        to_translate(
            "The trace {trace} is not straight: it has a plane of its own, or none. Choose a"
            " straight one."
        ),
    ),
    "trace.not-a-pair": (
        "error",
        to_translate(
            "“{value}” is not a pair of traces. Name two of them, such as {first},{second}."
        ),
    ),
    "plane.local": (
        "info",
        to_translate(
            "The face bends by {bend_deg:.2g}° from edge to edge, so its plane is local."
            " The attitude over several such faces is known to {regional_deg:.2g}°."
        ),
    ),
    "plane.long-roughness": (
        "warning",
        to_translate(
            "The roughness is as long as the trace, so the wider of the two errors counts."
            " Pick a longer trace."
        ),
    ),
    "plane.too-small": (
        "warning",
        to_translate(
            "The extent is {ratio:.1f} times the resolution of the model (minimum {minimum:g})."
            " Pick a longer one, or use a finer model."
        ),
    ),
    "plane.small": (
        "info",
        to_translate(
            "The extent is {ratio:g} times the resolution of the model ({recommended:g}"
            " recommended). Planes of this size can be expected within {error_deg:.2g}°."
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
            "The resolution of the model is unknown, so the extent was not compared with it."
        ),
    ),
    "plane.in-face": (
        "warning",
        to_translate(
            "The trace follows the outcrop face within {angle_deg:.2g}° and has little"
            " relief out of it. Pick where the trace cuts into the face."
        ),
    ),
    "plane.along-face": (
        "info",
        to_translate(
            "The plane follows the outcrop face within {angle_deg:.2g}°: is that face the"
            " structure itself?"
        ),
    ),
    "plane.three-points": (
        "warning",
        to_translate("Three points fit exactly, so no error can be estimated. Add points."),
    ),
    "plane.three-straight-points": (
        "warning",
        to_translate(
            "Three points nearly on a line hardly determine a plane, and give no error. Add points"
            " where the trace bends."
        ),
    ),
    "plane.three-distinct-points": (
        "warning",
        to_translate("Only 3 of the {n} points differ, so no error can be estimated. Add points."),
    ),
    "plane.too-few-points": (
        "warning",
        to_translate(
            "The plane has fewer than {minimum} independent points, so its scatter may be"
            " small by chance. Add points."
        ),
    ),
    "plane.registration": (
        "warning",
        to_translate(
            "The registration of the model can tilt the plane by {error_deg:.2g}° (limit"
            " {limit_deg:g}°). Register the model better."
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
            " {limit_deg:g}°). Pick a wider one, or use a finer model."
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
            "The points are almost on a line: collinearity {collinearity:.1f}, K {K:.2g} (below"
            " {recommended:g} recommended)."
        ),
    ),
    "plane.unbounded-error": (
        "info",
        to_translate(
            "The scatter is as large as the bend, so the angular error has no bound below 90°."
        ),
    ),
    "plane.levels": (
        "warning",
        to_translate(
            "The points lie in two levels {gap_m:.2g} m apart, and the plane between them."
            " Allow less distance, or paint each level by itself."
        ),
    ),
    "plane.bowed": (
        "warning",
        to_translate(
            "The face continues as a curved surface, so this piece depends on the"
            " thresholds. Use its plane only where you see one."
        ),
    ),
    "plane.earlier-rule": (
        "info",
        to_translate(
            "Resolution and outcrop face were measured by an earlier rule. Update the"
            " surroundings of earlier features."
        ),
    ),
    "plane.to-and-fro": (
        "info",
        to_translate(
            "The points go to and fro as if picked all over a face. If this is not a trace,"
            " use a patch."
        ),
    ),
    "line.plane-error-unknown": (
        "warning",
        to_translate(
            "The error of a plane on which the line depends is unknown, and so is that of"
            " the line. Measure that plane again."
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
            "The line is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°), mostly from"
            " the registration. Register the model better."
        ),
    ),
    "line.uncertain-plane": (
        "warning",
        to_translate(
            "The line is uncertain by {error_deg:.2g}° (limit {limit_deg:g}°), mostly from"
            " its planes. Measure them better."
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
        to_translate(
            "The line is {angle_deg:.2g}° off the plane it should lie on. Pick it on that plane."
        ),
    ),
    "line.scattered-set": (
        "warning",
        to_translate(
            "The planes of one set lie {scatter_deg:.2g}° (RMS) from their mean, like those"
            " of a fold. Use one limb, or the fold axis."
        ),
    ),
    "line.plane-missing": (
        "warning",
        to_translate(
            "The plane of the line was deleted or has no fit, so its rake is unknown."
            " Choose another plane."
        ),
    ),
    "plane.no-band": (
        "error",
        to_translate("The errors of this plane are not known, so it has no band. Add points."),
    ),
    "plane.regression-band": (
        "error",
        to_translate("A plane by regression has no band. Fit it by the moment of inertia (pca)."),
    ),
    "plane.too-uncertain": (
        "error",
        to_translate(
            "The plane may be off by {error_deg:.0f}°, so it cannot be extended. Add points."
        ),
    ),
    "points.collinear": (
        "error",
        to_translate(
            "All points lie on one straight line, which many planes contain. Add a point off the"
            " line."
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
            "The line is perpendicular to the plane, so it has no rake there. Choose another plane."
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
        to_translate("Offsets must rise from 0 to the number of points. Correct them."),
    ),
    "plane.parallel-to-axis": (
        "error",
        to_translate(
            "The plane is parallel to the axis {axis}, so regression of {axis} cannot find it."
            " Use another axis, or the moment of inertia (pca)."
        ),
    ),
    "points.uncertain-about-line": (
        "warning",
        to_translate(
            "The points are nearly on one line, about which the plane may be off by"
            " {error_deg:.0f}° (95 %). Add a point beside the line."
        ),
    ),
    "points.too-near": (
        "warning",
        to_translate(
            "The points are too close together for their error: the plane may be off by"
            " {error_deg:.0f}° (95 %). Add points farther away."
        ),
    ),
    "points.nearly-collinear": (
        "warning",
        to_translate(
            "The points are nearly on one line: an error of {error_m:g} m turns the plane by"
            " {turn_deg:.2g}°. Add one beside the line, or state the error."
        ),
    ),
    "plane.none-fitted": (
        "error",
        to_translate("None of the {count} planes can be fitted. The first: {reason}"),
    ),
    "plane.model-not-open": (
        "error",
        to_translate("The plane was not picked on an open model. Open its model first."),
    ),
}
