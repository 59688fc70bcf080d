"""Texts of the findings about sets of planes."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "sets.too-many": (
        "error",
        to_translate("{n} planes cannot form {sets} sets. Use a smaller number of sets."),
    ),
    "sets.too-many-seeds": (
        "error",
        to_translate("{seeds} seeds define more than {max_sets} sets. Remove some seeds."),
    ),
    "sets.seed-not-a-plane": (
        "error",
        to_translate("“{text}” is not a plane. Enter dip direction/dip, such as 120/45,300/80."),
    ),
    "sets.equal-seeds": (
        "error",
        to_translate("Two seeds are less than 1° apart. Remove one of them."),
    ),
    "sets.not-a-scanline": (
        "error",
        to_translate("A scanline needs two different points in metres: x,y,z,x,y,z."),
    ),
    "sets.no-places": (
        "error",
        to_translate("A scanline needs the positions of the planes. Add the columns x, y, z."),
    ),
    "sets.no-scatter": (
        "error",
        to_translate("No set in the table forms a cluster of at least three planes. Add planes."),
    ),
    "sets.empty": ("error", to_translate("The set {set} has no planes. Choose another set.")),
    "sets.no-members": (
        "error",
        to_translate("The set has no planes, so it has no mean. Choose another set."),
    ),
    "sets.unknown": (
        "error",
        to_translate("No plane belongs to the set “{set}”. The sets are: {sets}."),
    ),
    "rose.negative-weight": ("error", to_translate("Weights must not be negative. Correct them.")),
    "sets.no-orientations": (
        "error",
        to_translate("The set has no orientations. Add at least one."),
    ),
    "orientation.not-a-direction": (
        "error",
        to_translate("Orientation {number} of {n} is not a valid direction. Remove it."),
    ),
    "orientation.no-mean": (
        "error",
        to_translate(
            "The orientations cancel out or are evenly distributed, so they have no mean. Divide"
            " the orientations into sets."
        ),
    ),
    "net.ellipse-direction": (
        "error",
        to_translate(
            "The major axis of an ellipse must not be parallel to the direction of its centre."
            " Choose a perpendicular direction."
        ),
    ),
    "bingham.too-few": (
        "info",
        to_translate(
            "Bingham's distribution needs at least {minimum} orientations, but there are {n}."
        ),
    ),
    "bingham.no-scatter": (
        "info",
        to_translate(
            "All orientations are exactly parallel or coplanar, so the concentration is infinite."
        ),
    ),
    "kent.too-few": (
        "info",
        to_translate(
            "Kent's distribution needs at least {minimum} orientations, but there are {n}."
        ),
    ),
    "kent.weighted": (
        "info",
        to_translate("Kent's distribution needs equal weights, but these differ."),
    ),
    "kent.not-clustered": (
        "info",
        to_translate("The cluster is too wide for Kent's distribution (kappa below {minimum:g})."),
    ),
    "kent.round": (
        "info",
        to_translate("The cluster is round, so a Fisher distribution describes it (p = {p:.2f})."),
    ),
    "fisher.identical": (
        "info",
        to_translate("All orientations are identical, so kappa is infinite."),
    ),
    "fisher.too-scattered": (
        "info",
        to_translate("The set is too scattered: no cone contains the mean with 95 % confidence."),
    ),
    "fisher.few-decide": (
        "info",
        to_translate(
            "Weighted by their errors, {n} planes or lines count as {worth:.1f}, too few to"
            " estimate natural scatter. Without weights, a cone can be computed."
        ),
    ),
    "fisher.single": ("info", to_translate("A Fisher mean needs at least two orientations.")),
    "fisher.no-mean": ("info", to_translate("The directions cancel out, so they have no mean.")),
    "fisher.girdle": (
        "info",
        to_translate(
            "The set is a girdle, not a cluster (Vollmer P {point:.2f}, G {girdle:.2f}, R"
            " {random:.2f}). Use the axes of the tensor instead of a mean."
        ),
    ),
    "fisher.uniform": (
        "info",
        to_translate(
            "No orientation is preferred: the distribution is nearly uniform (Vollmer P"
            " {point:.2f}, G {girdle:.2f}, R {random:.2f})."
        ),
    ),
    "sets.lines-left-out": (
        "info",
        *to_translate_n(
            "{count} line is left out, because only planes are used.",
            "{count} lines are left out, because only planes are used.",
        ),
    ),
    "sets.none": (
        "warning",
        to_translate(
            "No set stands out from a uniform distribution. A set needs at least {minimum}"
            " planes. Define your own sets with --seeds."
        ),
    ),
    "sets.empty-seed": (
        "warning",
        to_translate("No plane belongs to seed {number}, so it does not form a set."),
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
            "No gap separates {sets}: their poles lie along one great circle, as in a folded bed,"
            " and may be one girdle with a fold axis."
        ),
    ),
    "sets.each-pick-counts": (
        "warning",
        to_translate(
            "Only positions are known, so each pick counts as one discontinuity. If several picks"
            " belong to one, the true spacing is larger and P32 smaller."
        ),
    ),
    "sets.too-few-planes": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes, but there is only {count}. Pick more, or choose"
            " other planes.",
            "Sets need at least {minimum} planes, but there are only {count}. Pick more, or"
            " choose other planes.",
        ),
    ),
    "sets.too-few-without-set": (
        "error",
        *to_translate_n(
            "Sets need at least {minimum} planes, but only {count} has no set yet. Include planes"
            " that have a set.",
            "Sets need at least {minimum} planes, but only {count} have no set yet. Include"
            " planes that have a set.",
        ),
    ),
    "sets.replaced": (
        "info",
        *to_translate_n(
            "{count} plane already has a set, which accepting replaces.",
            "{count} planes already have a set, which accepting replaces.",
        ),
    ),
    "sets.left-out": (
        "info",
        *to_translate_n(
            "{count} plane already has a set and is left out.",
            "{count} planes already have a set and are left out.",
        ),
    ),
    "sets.mixed-types": (
        "warning",
        to_translate(
            "{n} types are pooled ({types}). The mean of different types is rarely meaningful,"
            " and no fold axis is computed."
        ),
    ),
    "sets.type-too-small": (
        "info",
        *to_translate_n(
            "{type} has only {count} plane here, too few for sets.",
            "{type} has only {count} planes here, too few for sets.",
        ),
    ),
    "sets.no-common-frame": (
        "info",
        to_translate("No spacing: the planes are on several models without common coordinates."),
    ),
    "sets.not-in-metres": (
        "info",
        to_translate("No spacing: the planes have no coordinates in metres."),
    ),
    "sets.partly-in-metres": (
        "info",
        *to_translate_n(
            "{count} plane has no coordinates in metres. The spacing is computed without it.",
            "{count} planes have no coordinates in metres. The spacing is computed without them.",
        ),
    ),
    "sets.none-distinct": (
        "info",
        to_translate(
            "No set stands out from a uniform distribution. A set needs at least {minimum}"
            " planes, or a seed."
        ),
    ),
    "sets.parallel": (
        "info",
        to_translate("If all planes of a set are parallel, κ is infinite."),
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
            "No structure has been repeated yet. Choose Start re-picking: repeating a tenth of"
            " your picks shows the error of a pick."
        ),
    ),
}
