"""Texts of the findings about sets of planes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "sets.too-many": (
        "error",
        to_translate("{n} planes cannot form {sets} sets. Use a smaller number."),
    ),
    "sets.too-many-seeds": (
        "error",
        to_translate("{seeds} seeds make more sets than {max_sets}. Leave out seeds."),
    ),
    "sets.seed-not-a-plane": (
        "error",
        to_translate("“{text}” is not a plane. Write dip direction/dip, such as 120/45,300/80."),
    ),
    "sets.equal-seeds": (
        "error",
        to_translate("Two seeds are less than 1 degree apart. Leave out one of them."),
    ),
    "sets.not-a-scanline": (
        "error",
        to_translate("A scanline is two different points in metres: x,y,z,x,y,z."),
    ),
    "sets.no-places": (
        "error",
        to_translate("A scanline requires the places of the planes. Add the columns x, y, z."),
    ),
    "sets.no-scatter": (
        "error",
        to_translate("No set of the table has three planes that scatter about a mean. Add planes."),
    ),
    "sets.empty": ("error", to_translate("The set {set} has no planes. Choose another set.")),
    "sets.no-members": (
        "error",
        to_translate("The set has no planes, so it has no mean. Choose another set."),
    ),
    "sets.unknown": (
        "error",
        to_translate("No plane is in the set “{set}”. The sets are: {sets}."),
    ),
    "rose.negative-weight": ("error", to_translate("Weights must not be negative. Correct them.")),
    "sets.no-orientations": (
        "error",
        to_translate("The set has no orientations. Add at least one."),
    ),
    "orientation.not-a-direction": (
        "error",
        to_translate("Orientation {number} of {n} is not a direction. Leave it out."),
    ),
    "orientation.no-mean": (
        "error",
        to_translate(
            "The orientations cancel out or are spread evenly, so they have no mean. Divide"
            " them into sets."
        ),
    ),
    "net.ellipse-direction": (
        "error",
        to_translate("The direction of an ellipse must not be along its axis. Give one across it."),
    ),
    "bingham.too-few": (
        "info",
        to_translate(
            "Bingham's distribution needs at least {minimum} orientations, and there are {n}."
        ),
    ),
    "bingham.no-scatter": (
        "info",
        to_translate("All orientations are in one plane or line: the concentration is infinite."),
    ),
    "kent.too-few": (
        "info",
        to_translate(
            "Kent's distribution needs at least {minimum} orientations, and there are {n}."
        ),
    ),
    "kent.weighted": (
        "info",
        to_translate("Kent's distribution requires equal weights, and these differ."),
    ),
    "kent.not-clustered": (
        "info",
        to_translate("The cluster is too wide for Kent's distribution (kappa below {minimum:g})."),
    ),
    "kent.round": (
        "info",
        to_translate("The cluster is round, so Fisher's mean describes it (p = {p:.2f})."),
    ),
    "fisher.identical": ("info", to_translate("All orientations are the same: kappa is infinite.")),
    "fisher.too-scattered": (
        "info",
        to_translate("The set is too scattered: no cone contains the mean with 95 % confidence."),
    ),
    "fisher.few-decide": (
        "info",
        to_translate(
            "Weighted by their errors, {n} planes or lines count as {worth:.1f}, too few to show"
            " the natural scatter. Without weights, a cone can be computed."
        ),
    ),
    "fisher.single": ("info", to_translate("A Fisher mean needs at least two orientations.")),
    "fisher.no-mean": ("info", to_translate("The directions cancel out, so they have no mean.")),
    "fisher.girdle": (
        "info",
        to_translate(
            "The set is a girdle, not a cluster (Vollmer P {point:.2f}, G {girdle:.2f}, R"
            " {random:.2f}). The axes of the tensor describe it."
        ),
    ),
    "fisher.uniform": (
        "info",
        to_translate(
            "No orientation is preferred: the scatter is nearly uniform (Vollmer P {point:.2f},"
            " G {girdle:.2f}, R {random:.2f})."
        ),
    ),
    "sets.lines-left-out": (
        "info",
        *to_translate_n(
            "{count} line is left out.",
            "{count} lines are left out.",
        ),
    ),
    "sets.none": (
        "warning",
        to_translate(
            "No set stands out from an even scatter. A set needs at least {minimum} planes."
            " --seeds states sets of your own."
        ),
    ),
    "sets.empty-seed": (
        "warning",
        to_translate("No plane belongs to the seed {number}, so it does not form a set."),
    ),
    "sets.fewer": (
        "warning",
        *to_translate_n(
            "Only {count} set of at least {minimum} planes can be distinguished, not {wanted}.",
            "Only {count} sets of at least {minimum} planes can be distinguished, not {wanted}.",
        ),
    ),
    "sets.girdle": (
        "warning",
        to_translate(
            "No gap separates {sets}: their poles lie along one great circle, like a bent bed,"
            " and may be one girdle with a fold axis."
        ),
    ),
    "sets.each-pick-counts": (
        "warning",
        to_translate(
            "Only places are known, so each pick counts as a discontinuity. If several belong to"
            " one, the spacing is larger and P32 smaller."
        ),
    ),
    "sets.too-few-planes": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes; there is {count} here. Pick more, or "
            "choose others.",
            "Sets need at least {minimum} planes; there are {count} here. Pick more, or "
            "choose others.",
        ),
    ),
    "sets.too-few-without-set": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes, and {count} is without a set. Include "
            "those that have one already.",
            "Sets need at least {minimum} planes, and {count} are without a set. Include "
            "those that have one already.",
        ),
    ),
    "sets.replaced": (
        "info",
        *to_translate_n(
            "{count} plane has a set already, which accepting replaces.",
            "{count} planes have a set already, which accepting replaces.",
        ),
    ),
    "sets.left-out": (
        "info",
        *to_translate_n(
            "{count} plane has a set already and is left out.",
            "{count} planes have a set already and are left out.",
        ),
    ),
    "sets.mixed-types": (
        "warning",
        to_translate(
            "{n} types are pooled ({types}). The mean of a mixture rarely means anything, and no"
            " fold axis is computed."
        ),
    ),
    "sets.type-too-small": (
        "info",
        *to_translate_n(
            "{type} has only {count} plane here and gets no sets.",
            "{type} has only {count} planes here and gets no sets.",
        ),
    ),
    "sets.no-common-frame": (
        "info",
        to_translate(
            "No spacing: the planes are on several models that have no common coordinates."
        ),
    ),
    "sets.not-in-metres": (
        "info",
        to_translate("No spacing: the planes have no coordinates in metres."),
    ),
    "sets.partly-in-metres": (
        "info",
        *to_translate_n(
            "{count} plane has no coordinates in metres. The spacing is that of the others.",
            "{count} planes have no coordinates in metres. The spacing is that of the others.",
        ),
    ),
    "sets.none-distinct": (
        "info",
        to_translate(
            "No set stands out from an even scatter. A set needs at least {minimum} planes, "
            "or a seed."
        ),
    ),
    "sets.parallel": (
        "info",
        to_translate("Where all planes of a set are parallel, κ has no limit."),
    ),
    "sets.accepted": (
        "info",
        to_translate("Accepted: {sets}."),
    ),
    "sets.planes-changed": (
        "info",
        to_translate("The planes have changed. Propose sets again."),
    ),
    "sets.no-proposal": (
        "info",
        to_translate("No sets have been proposed. Propose sets first."),
    ),
    "repeats.not-begun": (
        "info",
        to_translate(
            "No structure was picked again yet. Choose Offer picks again: a tenth of the picks"
            " shows the error of one."
        ),
    ),
}
