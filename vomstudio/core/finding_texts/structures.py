"""Texts of the findings about folds, logs and slopes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "fold.too-few-planes": (
        "info",
        to_translate(
            "The axis rests on {n} planes, whose scatter is poorly known. Measure at least"
            " {wanted} before you rely on its 95 % error."
        ),
    ),
    "fold.too-few-sets": (
        "error",
        to_translate("Two or three different sets are needed, such as A,B."),
    ),
    "log.line-not-given": (
        "error",
        to_translate("A log of a project needs one of its lines. Name it with --line."),
    ),
    "log.no-bed": (
        "error",
        to_translate("A log of a table needs the attitude of its beds. Give it with --bed DD/D."),
    ),
    "log.not-a-project": (
        "error",
        to_translate(
            "This option is for a line of a project, and {table} is a table. Leave it out."
        ),
    ),
    "displacement.rake-without-strike": (
        "error",
        to_translate(
            "A horizontal fault has no strike to count a rake from. Give the trend and plunge of"
            " the slip."
        ),
    ),
    "slope.no-face": (
        "error",
        to_translate(
            "Type the attitude of the face, or select a plane that dips as it does and take it."
        ),
    ),
    "slope.horizontal-face": (
        "error",
        to_translate("The face is horizontal, so nothing slides out of it. Give its dip."),
    ),
    "slope.pairs-of-one-set": (
        "info",
        to_translate(
            "{pairs:,} of {all_pairs:,} pairs are planes of one set; their intersections do not"
            " count as wedges."
        ),
    ),
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
    "beds.no-surface": (
        "error",
        to_translate("The traces together do not determine a surface. Add points off them."),
    ),
    "beds.too-few-points": (
        "error",
        to_translate("The points are too few for a surface and its error. Add points."),
    ),
    "beds.too-many": (
        "error",
        to_translate(
            "Planes {thickness_m:g} m apart would be {n:.0f} on this model (maximum {maximum})."
            " Give a larger thickness."
        ),
    ),
    "beds.too-few-traces": (
        "error",
        to_translate("Parallel planes need at least two traces. Add traces."),
    ),
    "beds.empty-trace": (
        "error",
        to_translate("A trace has no points, so it cannot be fitted. Leave it out."),
    ),
    "beds.one-direction": (
        "error",
        to_translate(
            "The traces are straight and parallel, so together they do not determine a plane. Add"
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
            "Both traces lie on the same side of the fault. Choose one on the hanging wall and"
            " one on the footwall."
        ),
    ),
    "displacement.slip-along-bed": (
        "error",
        to_translate(
            "The slip is within {limit_deg:g}° of the bed, whose cut-offs do not determine it."
            " Use another marker."
        ),
    ),
    "displacement.bed-along-fault": (
        "error",
        to_translate(
            "The bed is within {limit_deg:g}° of the fault and has no cut-off there. Use"
            " another marker."
        ),
    ),
    "displacement.bed-down-dip": (
        "error",
        to_translate(
            "The bed runs down the dip of the fault, so its cut-offs show no dip separation."
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
            "All {n} planes are parallel, so they do not define a fold axis. Any direction in the"
            " plane shows true thickness: choose one."
        ),
    ),
    "slope.no-facet": (
        "error",
        to_translate(
            "None of the facets has a dip direction, so none is a slope. Choose other facets."
        ),
    ),
    "fold.one-domain": (
        "error",
        to_translate(
            "The column “{column}” contains only one domain. Name a column with two or more."
        ),
    ),
    "fold.no-verdicts": (
        "error",
        to_translate("The table has no verdicts in a column “quality”. Leave out {option}."),
    ),
    "fold.none-good-enough": (
        "error",
        to_translate("No plane is at least {quality}. Choose a lower quality."),
    ),
    "fold.no-column": (
        "error",
        to_translate(
            "The table has no column {columns} to choose from. Add one, or leave out {option}."
        ),
    ),
    "fold.unknown-kind": (
        "error",
        to_translate("No plane is of the kind “{kind}”. Choose one with --kind: {kinds}."),
    ),
    "fold.shape": (
        "info",
        to_translate(
            "{n} planes: the poles are {rms_deg:.1f}° (RMS) from the great circle, along"
            " {arc_deg:.0f}° of it."
        ),
    ),
    "fold.two-planes": (
        "info",
        to_translate("Two planes always meet in a line, whose error is unknown. Measure more."),
    ),
    "fold.one-plane-turns": (
        "warning",
        to_translate(
            "The verdict depends on one plane: without {plane} beta turns by {turn_deg:.0f}°,"
            " more than its error ({error_deg:.1f}°). Measure more planes like it."
        ),
    ),
    "fold.one-plane-decides": (
        "warning",
        to_translate(
            "The verdict depends on one plane: without {plane} the others are {verdict}. Measure"
            " more planes like it. {reason}"
        ),
    ),
    "fold.one-plane-excludes-cone": (
        "warning",
        to_translate(
            "Only {plane} distinguishes a cone from a cylinder. Measure more planes like it."
            " Without it: {reason}"
        ),
    ),
    "fold.limbs-or-hinge": (
        "warning",
        to_translate(
            "No interlimb angle: the groups of {first} and {second} planes, {apart_deg:.0f}°"
            " apart, may be limb and hinge. Put each limb in its own set."
        ),
    ),
    "fold.mixed-limbs": (
        "warning",
        to_translate(
            "No interlimb angle: one of the groups of {first} and {second} planes has"
            " overturned beds and others. Put each limb in its own set."
        ),
    ),
    "fold.arc-limb": (
        "warning",
        to_translate(
            "No interlimb angle: one of the groups of {first} and {second} planes is an arc."
            " Put each limb in its own set, without the hinge."
        ),
    ),
    "fold.axis-known": (
        "info",
        to_translate(
            "Beta is known to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %). This shortens"
            " lengths by {shortening_percent:.1f} % and displaces by {shift_percent:.0f} % of the"
            " depth of the view."
        ),
    ),
    "fold.axis-weak": (
        "warning",
        to_translate(
            "Beta is known to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %), over"
            " {limit_deg:g}°: too weak to rely on. Measure more planes."
        ),
    ),
    "fold.registration-alone": (
        "info",
        to_translate("The registration can turn beta by {error_deg:.1f}° (95 %)."),
    ),
    "fold.registration": (
        "info",
        to_translate(
            "With the registration, which can turn beta by {error_deg:.1f}° however many planes"
            " there are, it is known to {major_deg:.1f}° by {minor_deg:.1f}° (joint 95 %)."
        ),
    ),
    "fold.registration-weak": (
        "warning",
        to_translate(
            "With the registration, which can turn beta by {error_deg:.1f}°, it is known to"
            " {major_deg:.1f}° by {minor_deg:.1f}°, over {limit_deg:g}°: too weak to rely on."
        ),
    ),
    "fold.strays": (
        "warning",
        *to_translate_n(
            "{count} of {n} planes ({planes}) does not fit the fold of the others: check it."
            " The verdict is theirs; their beta is {trend_deg:azimuth}/{plunge_deg:02.0f},"
            " {turn_deg:.1f}° off.",
            "{count} of {n} planes ({planes}) do not fit the fold of the others: check them."
            " The verdict is theirs; their beta is {trend_deg:azimuth}/{plunge_deg:02.0f},"
            " {turn_deg:.1f}° off.",
        ),
    ),
    "fold.uniform": (
        "warning",
        to_translate(
            "No orientation is preferred: a uniform scatter is as uneven with a probability of"
            " {p:.2f}."
        ),
    ),
    "fold.scattered": (
        "warning",
        to_translate(
            "Nine tenths of the poles lie only within {within_deg:.0f}° of the great circle"
            " ({limit_deg:.0f}° required), and neither a cone nor two axes fit."
        ),
    ),
    "fold.shape-unknown": (
        "warning",
        to_translate(
            "With only {n} planes the shape of the scatter is unknown. Measure at least {minimum}."
        ),
    ),
    "fold.axis-too-uncertain": (
        "warning",
        to_translate(
            "The axis is known only to {error_deg:.0f}° (limit {limit_deg:g}°), too weak to"
            " rely on. Measure more planes."
        ),
    ),
    "fold.cone-or-cylinder": (
        "warning",
        to_translate(
            "The poles do not distinguish a cone from a cylinder: they are too few, or their"
            " arc is too short."
        ),
    ),
    "fold.short-arc": (
        "warning",
        to_translate("The poles cover less than {limit_deg:g}°: nearly one dip."),
    ),
    "fold.cylindrical": (
        "info",
        to_translate(
            "Nine tenths of the poles lie within {within_deg:.1f}° of the great circle"
            " ({limit_deg:.0f}° required)."
        ),
    ),
    "fold.nearly-cylindrical": (
        "warning",
        to_translate(
            "Nine tenths of the poles lie within {within_deg:.1f}° of the great circle"
            " ({limit_deg:.0f}° required): nearly cylindrical."
        ),
    ),
    "fold.no-cone": (
        "info",
        to_translate(
            "No cone fits better: the angle to the axis is {angle_deg:.0f} ± {width_deg:.0f}°"
            " (95 %), p = {p:.2f}."
        ),
    ),
    "fold.cone-possible": (
        "warning",
        to_translate(
            "The poles do not clearly exclude a cone: the angle to the axis is {angle_deg:.0f} ±"
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
            "One dip: the poles scatter by {spread_deg:.1f}° (RMS) about their mean. Any"
            " direction in the bed shows true thickness, such as its strike."
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
            "Two axes, {angle_deg:.0f}° apart, fit better than one: {two_rms_deg:.1f}° (RMS)"
            " instead of {rms_deg:.1f}°. Give each domain its own axis."
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
        to_translate("Two sets always share an axis: the line in which their mean planes meet."),
    ),
    "fold.off-common-plane": (
        "info",
        to_translate(
            "The means of {sets} are {off_deg}° off one plane. If they share an axis, the"
            " probability of this is {p:.2g}."
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
            "No single direction shows all sets edge-on. Give each pair its own axis, as a"
            " section does."
        ),
    ),
    "fold.off-within-errors": (
        "warning",
        to_translate("The means are off one plane, but not by more than their errors."),
    ),
    "fold.one-axis": (
        "info",
        to_translate(
            "One axis fits all domains: if they share it, the probability of such differences is"
            " {p:.2g}."
        ),
    ),
    "fold.domains-differ": (
        "warning",
        to_translate(
            "The domains have different axes. Project each along its own. If they shared one,"
            " the probability of such differences would be {p:.2g}."
        ),
    ),
    "fold.axes-apart": (
        "info",
        to_translate("The axes of the domains differ by up to {angle_deg:.0f}°."),
    ),
    "fold.beds-off-axis": (
        "info",
        to_translate("Beds of one dip are up to {angle_deg:.0f}° from the common axis."),
    ),
    "fold.one-dip-domains": (
        "info",
        to_translate(
            "Two domains of one dip each always share an axis, the line in which they meet. A"
            " fault between them is judged with --sets."
        ),
    ),
    "log.unknown-lithology": (
        "warning",
        to_translate("“{word}” at {boundary} is not a lithology of the forms of StraboSpot."),
    ),
    "log.thickness-uncertain": (
        "warning",
        to_translate("{base} to {top}: the thickness is not larger than its error."),
    ),
    "log.boundaries-moved": (
        "warning",
        to_translate(
            "These boundaries were not in the order of their heights and were sorted:"
            " {boundaries}. Check the bedding and the points."
        ),
    ),
    "beds.no-errors": (
        "warning",
        to_translate("No trace has more than three points, so the errors are unknown. Add points."),
    ),
    "displacement.slip-off-fault": (
        "warning",
        to_translate(
            "The slip leaves the fault by {angle_deg:.1f}° (limit {limit_deg:g}°) and was"
            " projected onto it. Check both."
        ),
    ),
    "displacement.rake-of-vertical-fault": (
        "warning",
        to_translate(
            "The fault is vertical: its rake was counted from the strike {strike_deg:azimuth}. If"
            " it is from {other_deg:azimuth}, give 180 minus the rake."
        ),
    ),
    "displacement.motion-off-fault": (
        "warning",
        *to_translate_n(
            "{count} motion leaves the fault by more than {limit_deg:g}°: {pairs}. Check the"
            " points and the attitude of the fault.",
            "{count} motions leave the fault by more than {limit_deg:g}°: {pairs}. Check the"
            " points and the attitude of the fault.",
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
            "{count} facet is nearly vertical and may overhang, facing the other way. Name the"
            " model with its labels, which show this.",
            "{count} facets are nearly vertical and may overhang, facing the other way. Name"
            " the model with its labels, which show this.",
        ),
    ),
    "slope.overhanging-facets": (
        "warning",
        *to_translate_n(
            "{count} facet overhangs and was taken as a vertical face.",
            "{count} facets overhang and were taken as vertical faces.",
        ),
    ),
    "slope.gentle-face": (
        "warning",
        to_translate(
            "The face dips {dip_deg:g}°, which is not steeper than the friction angle"
            " ({friction_deg:g}°): neither sliding nor toppling is possible."
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
            "Wedges and direct toppling need two planes that meet. Add planes to the table."
        ),
    ),
    "slope.no-errors": (
        "info",
        to_translate("{n:,} planes. None of them has a known error, so no probability is given."),
    ),
    "slope.errors-unknown": (
        "warning",
        *to_translate_n(
            "The error of {count} plane is unknown, and its probability takes it as exact.",
            "The errors of {count} planes are unknown, and the probabilities take them as exact.",
        ),
    ),
    "fold.only-planes": ("info", to_translate("Only planes are used.")),
    "fold.only-set": ("info", to_translate("Only the set “{set}” is used.")),
    "fold.only-named-sets": ("info", to_translate("Only the sets that were named are used.")),
    "fold.only-kind": ("info", to_translate("Only the kind “{kind}” is used.")),
    "fold.only-picks": (
        "info",
        to_translate("Only planes that were picked on the model are used."),
    ),
    "fold.only-quality": (
        "info",
        to_translate("Only planes that are at least {quality} are used."),
    ),
    "fold.bowed": (
        "warning",
        to_translate(
            "The model may be bowed by {bowed_deg:.1f}° from edge to edge, and these poles"
            " cover only {arc_deg:.1f}°: the fold may be the bowing."
        ),
    ),
    "fold.two-dip-domains": (
        "warning",
        to_translate(
            "Two dip domains, {apart_deg:.0f}° apart, are always on a great circle: a"
            " cylindrical fold cannot be tested. Beta is where the limbs meet."
        ),
    ),
    "beds.not-parallel": (
        "warning",
        to_translate(
            "The traces differ by more than their noise (p = {p:.2g}): the beds are wavy, or not"
            " parallel. The error of their mean was widened."
        ),
    ),
    "displacement.net-slip": (
        "info",
        to_translate("Net slip of the hanging wall, {unit}, with 95 % errors."),
    ),
    "displacement.separation": (
        "info",
        to_translate(
            "Dip separation, {unit}, with 95 % errors. It is not a slip, since the direction of"
            " movement is unknown."
        ),
    ),
    "displacement.no-pairs": (
        "error",
        to_translate(
            "Select two traces of one bed, on both sides of the fault, and add them. More "
            "pairs give a mean."
        ),
    ),
    "displacement.no-fault": (
        "error",
        to_translate("Select a plane that was picked on the fault, and take it."),
    ),
    "displacement.not-a-rake": (
        "error",
        to_translate(
            "{value:g} is not a rake from 0 to 180 degrees. Write a direction as trend and "
            "plunge, such as 120/45."
        ),
    ),
    "fold.needs-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} bedding planes; there are {count}. Measure more."
        ),
    ),
    "fold.needs-selected-planes": (
        "error",
        to_translate(
            "A fold axis needs at least {minimum} selected bedding planes; there are "
            "{count}. Select more."
        ),
    ),
    "three-points.too-few": (
        "error",
        to_translate(
            "Pick three points or more of one surface on the outcrop, or type their coordinates."
        ),
    ),
    "three-points.no-error": (
        "info",
        to_translate("The error is unknown. State the error of the points, or add points."),
    ),
}
