"""Texts of the findings about folds, logs and slopes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "fold.too-few-planes": (
        "info",
        to_translate(
            "The axis is based on {n} planes, whose scatter is poorly known. Measure at least"
            " {wanted} before relying on its 95 % error."
        ),
    ),
    "fold.too-few-sets": (
        "error",
        to_translate("A common axis needs two or three different sets, such as A,B."),
    ),
    "log.line-not-given": (
        "error",
        to_translate("A log from a project needs a line of the project. Specify it with --line."),
    ),
    "log.no-bed": (
        "error",
        to_translate(
            "A log from a table needs the attitude of its beds. Specify it with --bed DD/D."
        ),
    ),
    "log.not-a-project": (
        "error",
        to_translate(
            "This option needs a line of a project, but {table} is a table. Omit the option."
        ),
    ),
    "displacement.rake-without-strike": (
        "error",
        to_translate(
            "A horizontal fault has no strike to measure a rake from. Specify the trend and"
            " plunge of the slip."
        ),
    ),
    "slope.no-face": (
        "error",
        to_translate(
            "Enter the attitude of the face, or use a selected plane that is parallel to it."
        ),
    ),
    "slope.horizontal-face": (
        "error",
        to_translate("The face is horizontal, so nothing can slide out of it. Specify a dip."),
    ),
    "slope.pairs-of-one-set": (
        "info",
        to_translate(
            "{pairs:,} of {all_pairs:,} pairs consist of planes of the same set; their"
            " intersections do not count as wedges."
        ),
    ),
    "fold.planes-not-good": (
        "warning",
        to_translate(
            "{not_good} of {used} planes of the fold axis are not rated good, but have equal"
            " weight. Improve them or leave them out."
        ),
    ),
    "log.beds-not-parallel": (
        "warning",
        to_translate(
            "The {count} bedding traces are not parallel, or too straight (± {error_deg:.1f}° at"
            " best). Use the plane of a bed."
        ),
    ),
    "beds.no-surface": (
        "error",
        to_translate("The combined traces do not determine a surface. Add points off the traces."),
    ),
    "beds.too-few-points": (
        "error",
        to_translate("There are too few points for a surface and its error. Add points."),
    ),
    "beds.too-many": (
        "error",
        to_translate(
            "A thickness of {thickness_m:g} m gives {n:.0f} planes on this model (maximum"
            " {maximum}). Use a larger thickness."
        ),
    ),
    "beds.too-few-traces": (
        "error",
        to_translate("Parallel planes need at least two traces. Add traces."),
    ),
    "beds.empty-trace": (
        "error",
        to_translate("A trace without points cannot be fitted. Remove it."),
    ),
    "beds.one-direction": (
        "error",
        to_translate(
            "The traces are straight and parallel, so they do not determine a common plane. Add"
            " one in another direction."
        ),
    ),
    "fold.parallel-means": (
        "error",
        to_translate(
            "The mean planes of {sets} are parallel, so they have no common axis. Choose other"
            " sets."
        ),
    ),
    "displacement.one-side": (
        "error",
        to_translate(
            "Both traces are on the same side of the fault. Choose one on the hanging wall and"
            " one on the footwall."
        ),
    ),
    "displacement.slip-along-bed": (
        "error",
        to_translate(
            "The slip is within {limit_deg:g}° of the bed, so the cut-offs do not determine it."
            " Use another marker."
        ),
    ),
    "displacement.bed-along-fault": (
        "error",
        to_translate(
            "The bed is within {limit_deg:g}° of the fault and has no cut-off. Use another marker."
        ),
    ),
    "displacement.bed-down-dip": (
        "error",
        to_translate(
            "The bed intersects the fault down its dip, so the cut-offs show no dip separation."
            " Use another marker."
        ),
    ),
    "fold.one-plane": (
        "error",
        to_translate("A fold axis needs at least two planes. Measure more."),
    ),
    "fold.parallel-planes": (
        "error",
        to_translate(
            "All {n} planes are parallel, so they do not define a fold axis. Every direction in"
            " the plane shows true thickness: choose one."
        ),
    ),
    "slope.no-facet": (
        "error",
        to_translate("No facet has a dip direction, so none can be a slope. Choose other facets."),
    ),
    "fold.one-domain": (
        "error",
        to_translate(
            "The column “{column}” contains only one domain. Choose a column with two or more."
        ),
    ),
    "fold.no-verdicts": (
        "error",
        to_translate("The table has no column “quality” with verdicts. Omit {option}."),
    ),
    "fold.none-good-enough": (
        "error",
        to_translate("No plane has at least the quality {quality}. Choose a lower quality."),
    ),
    "fold.no-column": (
        "error",
        to_translate(
            "The table has no column {columns}, which {option} needs. Add one, or omit the option."
        ),
    ),
    "fold.unknown-kind": (
        "error",
        to_translate("No plane has the kind “{kind}”. Choose another with --kind: {kinds}."),
    ),
    "fold.shape": (
        "info",
        to_translate(
            "{n} planes: the poles are {rms_deg:.1f}° (RMS) from the great circle and cover"
            " {arc_deg:.0f}° of it."
        ),
    ),
    "fold.two-planes": (
        "info",
        to_translate(
            "Two planes always intersect in a line, but its error is unknown. Measure more planes."
        ),
    ),
    "fold.one-plane-turns": (
        "warning",
        to_translate(
            "The verdict depends on one plane: without {plane} beta rotates by {turn_deg:.0f}°,"
            " more than its error ({error_deg:.1f}°). Measure more planes with a similar attitude."
        ),
    ),
    "fold.one-plane-decides": (
        "warning",
        to_translate(
            "The verdict depends on one plane: without {plane} the others are {verdict}. Measure"
            " more planes with a similar attitude. {reason}"
        ),
    ),
    "fold.one-plane-excludes-cone": (
        "warning",
        to_translate(
            "Only {plane} distinguishes a cone from a cylinder. Measure more planes with a similar"
            " attitude. Without it: {reason}"
        ),
    ),
    "fold.limbs-or-hinge": (
        "warning",
        to_translate(
            "No interlimb angle: the groups of {first} and {second} planes, {apart_deg:.0f}° apart,"
            " may be a limb and the hinge. Put each limb in its own set."
        ),
    ),
    "fold.mixed-limbs": (
        "warning",
        to_translate(
            "No interlimb angle: one of the groups of {first} and {second} planes mixes"
            " overturned and upright beds. Put each limb in its own set."
        ),
    ),
    "fold.arc-limb": (
        "warning",
        to_translate(
            "No interlimb angle: one of the groups of {first} and {second} planes forms an arc."
            " Put each limb in its own set, without the hinge."
        ),
    ),
    "fold.axis-known": (
        "info",
        to_translate(
            "Beta is known to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %). This shortens"
            " lengths by {shortening_percent:.1f} % and shifts points by {shift_percent:.0f} % of"
            " the view depth."
        ),
    ),
    "fold.axis-weak": (
        "warning",
        to_translate(
            "Beta is known only to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %), above the"
            " limit of {limit_deg:g}°. Measure more planes."
        ),
    ),
    "fold.registration-alone": (
        "info",
        to_translate("The registration alone can rotate beta by {error_deg:.1f}° (95 %)."),
    ),
    "fold.registration": (
        "info",
        to_translate(
            "Including the registration, which can rotate beta by {error_deg:.1f}° whatever the"
            " number of planes, it is known to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %)."
        ),
    ),
    "fold.registration-weak": (
        "warning",
        to_translate(
            "Including the registration, which can rotate beta by {error_deg:.1f}°, it is known"
            " only to {major_deg:.1f}° by {minor_deg:.1f}°, above the limit of {limit_deg:g}°."
        ),
    ),
    "fold.strays": (
        "warning",
        *to_translate_n(
            "{count} of {n} planes ({planes}) does not fit the fold: check it. The verdict is for"
            " the others; their beta is {trend_deg:azimuth}/{plunge_deg:02.0f}, {turn_deg:.1f}°"
            " away.",
            "{count} of {n} planes ({planes}) do not fit the fold: check them. The verdict is for"
            " the others; their beta is {trend_deg:azimuth}/{plunge_deg:02.0f}, {turn_deg:.1f}°"
            " away.",
        ),
    ),
    "fold.uniform": (
        "warning",
        to_translate(
            "No orientation is preferred: data from a uniform distribution are this uneven with a"
            " probability of {p:.2f}."
        ),
    ),
    "fold.scattered": (
        "warning",
        to_translate(
            "90 % of the poles lie within {within_deg:.0f}° of the girdle ({limit_deg:.0f}°"
            " required), and neither a cone nor two axes fit."
        ),
    ),
    "fold.shape-unknown": (
        "warning",
        to_translate(
            "With only {n} planes the shape of the distribution is unknown. Measure at least"
            " {minimum}."
        ),
    ),
    "fold.axis-too-uncertain": (
        "warning",
        to_translate(
            "The axis is known only to {error_deg:.0f}° (limit {limit_deg:g}°). Measure more"
            " planes."
        ),
    ),
    "fold.cone-or-cylinder": (
        "warning",
        to_translate(
            "The poles are too few, or their arc is too short, to distinguish a cone from a"
            " cylinder."
        ),
    ),
    "fold.short-arc": (
        "warning",
        to_translate("The poles cover an arc of less than {limit_deg:g}°, nearly a single dip."),
    ),
    "fold.cylindrical": (
        "info",
        to_translate(
            "90 % of the poles lie within {within_deg:.1f}° of the girdle ({limit_deg:.0f}°"
            " required)."
        ),
    ),
    "fold.nearly-cylindrical": (
        "warning",
        to_translate(
            "90 % of the poles lie within {within_deg:.1f}° of the girdle ({limit_deg:.0f}°"
            " required): nearly cylindrical."
        ),
    ),
    "fold.no-cone": (
        "info",
        to_translate(
            "A cone does not fit better: its half-angle is {angle_deg:.0f} ± {width_deg:.0f}° (95"
            " %), p = {p:.2f}."
        ),
    ),
    "fold.cone-possible": (
        "warning",
        to_translate(
            "The poles do not clearly exclude a cone: its half-angle is {angle_deg:.0f} ±"
            " {width_deg:.0f}° (95 %), p = {p:.2f}."
        ),
    ),
    "fold.axis-uncertain": (
        "warning",
        to_translate(
            "The axis is known to {error_deg:.0f}° ({limit_deg:g}° required). Measure more planes."
        ),
    ),
    "fold.one-dip": (
        "warning",
        to_translate(
            "The planes share one dip: poles scatter by {spread_deg:.1f}° (RMS) about the mean."
            " Every direction in the bed, such as its strike, shows true thickness."
        ),
    ),
    "fold.conical": (
        "warning",
        to_translate(
            "A cone about {trend_deg:azimuth}/{plunge_deg:02.0f} fits better than a cylinder:"
            " {cone_rms_deg:.1f}° (RMS) instead of {rms_deg:.1f}°, half-angle {angle_deg:.0f} ±"
            " {width_deg:.0f}° (95 %), p = {p:.2g}."
        ),
    ),
    "fold.two-axes": (
        "warning",
        to_translate(
            "Two axes {angle_deg:.0f}° apart fit better than one: {two_rms_deg:.1f}° (RMS)"
            " instead of {rms_deg:.1f}°. Use a separate axis for each domain."
        ),
    ),
    "fold.means-of-sets": ("info", to_translate("The axis is computed from the means of {sets}.")),
    "fold.set-of-one-plane": (
        "warning",
        to_translate(
            "A set has only one plane, so the error of the axis is unknown. Measure more planes"
            " of each set."
        ),
    ),
    "fold.two-sets": (
        "info",
        to_translate(
            "Two sets always share an axis: the line of intersection of their mean planes."
        ),
    ),
    "fold.off-common-plane": (
        "info",
        to_translate(
            "The mean poles of {sets} deviate from a great circle by {off_deg}°. If the sets share"
            " an axis, the probability of such deviations is {p:.2g}."
        ),
    ),
    "fold.scatter-assumed": (
        "warning",
        to_translate(
            "Each set is a single plane. A natural scatter of {scatter_deg:g}° is assumed."
        ),
    ),
    "fold.several-axes": (
        "warning",
        to_translate(
            "No single direction shows all sets edge-on. Use a separate axis for each pair of sets."
        ),
    ),
    "fold.off-within-errors": (
        "warning",
        to_translate(
            "The mean poles deviate from a great circle, but not by more than their errors."
        ),
    ),
    "fold.one-axis": (
        "info",
        to_translate(
            "A single axis fits all domains: if they share it, the probability of such"
            " differences is {p:.2g}."
        ),
    ),
    "fold.domains-close": (
        "info",
        to_translate(
            "The domains differ significantly (p = {p:.2g}), but by less than {limit_deg:g}°, so a"
            " single axis is used."
        ),
    ),
    "fold.domains-differ": (
        "warning",
        to_translate(
            "The domains have different axes, so project each along its own. If they shared one,"
            " the probability of such differences would be {p:.2g}."
        ),
    ),
    "fold.axes-apart": (
        "info",
        to_translate("The axes of the domains differ by up to {angle_deg:.0f}°."),
    ),
    "fold.beds-off-axis": (
        "info",
        to_translate("Beds with a single dip are up to {angle_deg:.0f}° from the common axis."),
    ),
    "fold.one-dip-domains": (
        "info",
        to_translate(
            "Two domains that each have a single dip always share an axis, their line of"
            " intersection. To test a fault between them, use --sets."
        ),
    ),
    "log.unknown-lithology": (
        "warning",
        to_translate(
            "“{word}” at {boundary} is not among the lithologies in the StraboSpot forms."
        ),
    ),
    "log.thickness-uncertain": (
        "warning",
        to_translate("{base} to {top}: the thickness does not exceed its error."),
    ),
    "log.boundaries-moved": (
        "warning",
        to_translate(
            "These boundaries were not in order of height and were sorted: {boundaries}. Check"
            " the bedding and the points."
        ),
    ),
    "beds.no-errors": (
        "warning",
        to_translate("No trace has more than three points, so the errors are unknown. Add points."),
    ),
    "displacement.slip-off-fault": (
        "warning",
        to_translate(
            "The slip deviates from the fault by {angle_deg:.1f}° (limit {limit_deg:g}°) and was"
            " projected onto it. Check both."
        ),
    ),
    "displacement.rake-of-vertical-fault": (
        "warning",
        to_translate(
            "The fault is vertical, so its rake was measured from the strike"
            " {strike_deg:azimuth}. If it refers to {other_deg:azimuth}, enter 180 minus the"
            " rake."
        ),
    ),
    "displacement.motion-off-fault": (
        "warning",
        *to_translate_n(
            "{count} slip vector deviates from the fault by more than {limit_deg:g}°: {pairs}."
            " Check the points and the fault's attitude.",
            "{count} slip vectors deviate from the fault by more than {limit_deg:g}°: {pairs}."
            " Check the points and the fault's attitude.",
        ),
    ),
    "slope.horizontal-facets": (
        "info",
        *to_translate_n(
            "{count} facet is horizontal and was skipped.",
            "{count} facets are horizontal and were skipped.",
        ),
    ),
    "slope.vertical-facets": (
        "warning",
        *to_translate_n(
            "{count} facet is nearly vertical and may overhang, facing the opposite way. Specify"
            " the labelled model, which shows this.",
            "{count} facets are nearly vertical and may overhang, facing the opposite way."
            " Specify the labelled model, which shows this.",
        ),
    ),
    "slope.overhanging-facets": (
        "warning",
        *to_translate_n(
            "{count} facet overhangs and is treated as a vertical face.",
            "{count} facets overhang and are treated as vertical faces.",
        ),
    ),
    "slope.gentle-face": (
        "warning",
        to_translate(
            "The face dips {dip_deg:g}°, which does not exceed the friction angle"
            " ({friction_deg:g}°), so neither sliding nor toppling is possible."
        ),
    ),
    "slope.parallel-pairs": (
        "info",
        *to_translate_n(
            "{count} pair of planes is parallel and has no intersection.",
            "{count} pairs of planes are parallel and have no intersection.",
        ),
    ),
    "slope.no-pairs": (
        "warning",
        to_translate(
            "Wedges and direct toppling need two planes that intersect. Add planes to the table."
        ),
    ),
    "slope.no-errors": (
        "info",
        to_translate("None of the {n:,} planes has a known error, so no probability is computed."),
    ),
    "slope.errors-unknown": (
        "warning",
        *to_translate_n(
            "The error of {count} plane is unknown, so its probability assumes no error.",
            "The errors of {count} planes are unknown, so their probabilities assume no error.",
        ),
    ),
    "fold.only-planes": ("info", to_translate("Only planes are used.")),
    "fold.only-set": ("info", to_translate("Only the set “{set}” is used.")),
    "fold.only-named-sets": ("info", to_translate("Only the specified sets are used.")),
    "fold.only-kind": ("info", to_translate("Only planes of the kind “{kind}” are used.")),
    "fold.only-picks": (
        "info",
        to_translate("Only planes picked on the model are used."),
    ),
    "fold.only-quality": (
        "info",
        to_translate("Only planes with at least the quality {quality} are used."),
    ),
    "fold.bowed": (
        "warning",
        to_translate(
            "The model may be bowed by {bowed_deg:.1f}° from edge to edge, and these poles cover"
            " only {arc_deg:.1f}°, so the fold may be an artefact."
        ),
    ),
    "fold.two-dip-domains": (
        "warning",
        to_translate(
            "Poles of two dip domains, {apart_deg:.0f}° apart, always lie on a great circle, so"
            " cylindricity cannot be tested. Beta is the intersection of the limbs."
        ),
    ),
    "beds.not-parallel": (
        "warning",
        to_translate(
            "The traces differ by more than their noise (p = {p:.2g}): the beds are wavy or not"
            " parallel. The error of their mean was increased."
        ),
    ),
    "displacement.net-slip": (
        "info",
        to_translate("Net slip of the hanging wall, {unit}, with 95 % errors."),
    ),
    "displacement.separation": (
        "info",
        to_translate(
            "Dip separation, {unit}, with 95 % errors. The net slip is unknown, because the slip"
            " direction is unknown."
        ),
    ),
    "displacement.no-pairs": (
        "error",
        to_translate(
            "Select two traces of the same bed, one on each side of the fault, and add them as a"
            " pair. Several pairs give a mean."
        ),
    ),
    "displacement.no-fault": (
        "error",
        to_translate(
            "No fault has been chosen. Select a plane that was picked on the fault, and click Use"
            " selected."
        ),
    ),
    "displacement.not-a-rake": (
        "error",
        to_translate(
            "{value:g} is not a valid rake. Enter 0 to 180 degrees, or a direction as trend and"
            " plunge, such as 120/45."
        ),
    ),
    "fold.needs-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} bedding planes (measured: {count}). Measure more."
        ),
    ),
    "fold.needs-selected-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} bedding planes (selected: {count}). Select more."
        ),
    ),
    "three-points.too-few": (
        "error",
        to_translate(
            "Pick three or more points of one surface on the outcrop, or enter their coordinates."
        ),
    ),
    "three-points.no-error": (
        "info",
        to_translate("The error is unknown. Enter the error of the points, or add points."),
    ),
}
