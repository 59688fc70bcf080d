"""Texts of the findings about patches and facets of a model's surface."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "patch.not-a-place": (
        "error",
        to_translate(
            "“{text}” is not a position with a radius. Use the form x,y,z,r: a World point and a"
            " radius in metres."
        ),
    ),
    "patch.empty": (
        "error",
        to_translate(
            "No part of the model lies within this radius. Choose another position or a larger"
            " radius."
        ),
    ),
    "patch.no-elements": (
        "error",
        to_translate(
            "The outline contains no faces or points of {model}. Place it on the surface of the"
            " model."
        ),
    ),
    "patch.crossing-outline": (
        "error",
        to_translate("The outline crosses itself. Order its points around the patch."),
    ),
    "patch.too-small": (
        "error",
        to_translate(
            "The patch is too small: {count} cells of {cell_m:.3g} m have a height, but {least}"
            " are required. Enlarge it, or use a finer model."
        ),
    ),
    "patch.partly-planar": (
        "warning",
        to_translate(
            "The plane does not fit {share_percent:.0f} % of the patch. Without this part, the"
            " plane rotates by {turn_deg:.1f}°."
        ),
    ),
    "patch.two-planes": (
        "warning",
        to_translate(
            "The patch consists of two planes {angle_deg:.1f}° apart, with {share_percent:.0f} %"
            " and {other_percent:.0f} % of its area. Measure each separately."
        ),
    ),
    "patch.bent": (
        "warning",
        to_translate(
            "The patch is bent: a paraboloid explains {share_percent:.0f} % of its mean square"
            " deviation. The smoothest direction is computed from the residuals."
        ),
    ),
    "facet.no-field": (
        "error",
        to_translate("The model has no field “facet”. Write it with vomstudio facets --labels."),
    ),
    "facet.missing": (
        "error",
        to_translate("The model has no facet {number}. Choose another."),
    ),
    "facet.other-labels": (
        "error",
        to_translate(
            "None of the labels on the model is the id of a facet in {table}. Use a table and"
            " labels from the same run."
        ),
    ),
    "roughness.flat": (
        "info",
        to_translate(
            "The surface is flat to the last digit of its coordinates, so it has no roughness."
        ),
    ),
    "roughness.small-patch": (
        "warning",
        to_translate(
            "The patch is too small: the model resolves only distances above {shortest_m:.3g} m."
            " Enlarge the patch, or use a finer model."
        ),
    ),
    "roughness.short-range": (
        "warning",
        to_translate(
            "Patch and model allow distances from {from_m:.3g} to {to_m:.3g} m, too short a range"
            " for an exponent. Enlarge the patch."
        ),
    ),
    "roughness.below-noise": (
        "warning",
        to_translate(
            "The roughness does not exceed the model's noise of {noise_m:.3g} m over a range of"
            " distances. Use a finer model."
        ),
    ),
    "roughness.several-exponents": (
        "warning",
        to_translate(
            "The exponent of the deviations is {short:.2f} at short and {long:.2f} at long"
            " distances, so no single exponent fits. The surface may have grooves, waves or steps."
        ),
    ),
    "roughness.invalid-exponent": (
        "warning",
        to_translate(
            "The exponent of the deviations is {exponent:.2f}, outside 0 to 1. The surface is bent"
            " or smooth at this scale."
        ),
    ),
    "roughness.direction-below-noise": (
        "warning",
        to_translate(
            "The roughness does not exceed the model's noise of {noise_m:.3g} m, so the smoothest"
            " direction is unknown. Use a finer model."
        ),
    ),
    "roughness.no-direction": (
        "info",
        to_translate("The surface is equally rough in all directions (p = {p:.2g})."),
    ),
    "measurable.length-assumed": (
        "info",
        to_translate(
            "No trace length was specified, so {times:g} times the resolution of the model is used."
        ),
    ),
    "measurable.shares": (
        "info",
        to_translate(
            "{good_percent:.0f} % of the surface would give a good plane (95 % error up to 5°),"
            " {doubtful_percent:.0f} % a doubtful one, {poor_percent:.0f} % a poor one,"
            " {none_percent:.0f} % none."
        ),
    ),
    "measurable.trace-share": (
        "info",
        to_translate(
            "Traces alone would give good planes on {good_percent:.0f} % of the surface; on"
            " {exposed_percent:.0f} %, the plane itself is exposed."
        ),
    ),
    "sample.tally": (
        "info",
        to_translate(
            "The true value is within the stated 95 % region in {held} of {count} checks. About 1"
            " in 20 should be outside."
        ),
    ),
    "sample.photo-model": (
        "info",
        to_translate(
            "The model from the sample's photos differs from the outcrop by {model_mm:.0f} mm, and"
            " its cameras from the true ones by {cameras_mm:.0f} mm (medians)."
        ),
    ),
    "sample.photo-planes": (
        "info",
        to_translate(
            "{held} of {count} planes on this model agree with the true planes within their total"
            " error (95 %). The largest error is {worst_deg:.1f}°."
        ),
    ),
    "sample.pick-without-plane": (
        "error",
        to_translate("The pick {pick} has no plane. {reason}"),
    ),
}
