"""Texts of the findings about facets and fields on a surface."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "cloud.too-few-points": (
        "error",
        to_translate(
            "A surface needs at least {minimum} points with coordinates, and the cloud has {n}."
            " Choose another cloud."
        ),
    ),
    "mesh.no-area": (
        "error",
        to_translate("No face of the mesh has an area. Export the model again."),
    ),
    "faces.length-too-small": (
        "error",
        to_translate(
            "The length is far smaller than the model. Give a longer one, or cut out a part."
        ),
    ),
    "model.no-colours": (
        "error",
        to_translate(
            "The model has no colours, which this needs. Use its shape or a field instead."
        ),
    ),
    "model.no-resolution": (
        "error",
        to_translate(
            "The model has too few points to estimate its resolution. Use a denser model."
        ),
    ),
    "trace.too-short": (
        "error",
        to_translate(
            "A trace of {length_m:.3g} m is too short for the resolution of the model"
            " ({resolution_m:.3g} m). Choose a longer one."
        ),
    ),
    "cloud.streamed": (
        "error",
        to_translate(
            "This cloud is loaded piece by piece, so a patch cannot grow over it. Draw its"
            " outline instead."
        ),
    ),
    "fields.points-in-line": (
        "error",
        to_translate(
            "The points within {radius_m:g} m lie on lines or at one place, which have no dip."
            " Choose a larger radius."
        ),
    ),
    "fields.too-few-points": (
        "error",
        to_translate("Too few points are within {radius_m:g} m. Choose a larger radius."),
    ),
    "fields.radius-below-faces": (
        "error",
        to_translate(
            "The radius is far smaller than the triangles of the model. Choose at least"
            " {minimum_m:.2g} m."
        ),
    ),
    "cloud.noisy": (
        "warning",
        to_translate(
            "The points scatter by {noise_m:.3g} m about the surface, {times:.1f} times their"
            " spacing. Normals are estimated over {width_m:.2g} m; narrower pieces are not"
            " distinguished."
        ),
    ),
    "cloud.normals-unused": (
        "warning",
        to_translate(
            "The normals of the file are {angle_deg:.0f}° (median) off the surface of its"
            " points and are not used."
        ),
    ),
    "cloud.normals-partly-unused": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the normals of the file are more than {limit_deg:.0f}°"
            " off the surface of the points and are not used."
        ),
    ),
    "facets.vegetation": (
        "info",
        to_translate(
            "Facets with the colours of grass were left out as vegetation: {share_percent:.0f}"
            " % of the model."
        ),
    ),
    "facets.volume": (
        "warning",
        to_translate(
            "The points fill a volume and do not form a surface at any width. Smooth the cloud,"
            " or pick traces by hand."
        ),
    ),
    "facets.none": (
        "warning",
        to_translate(
            "No facet was found. Allow a larger angle or distance, fewer points or less area,"
            " or pick traces by hand."
        ),
    ),
    "facets.little-planar": (
        "warning",
        to_translate(
            "Only {share_percent:.0f} % of the exposed rock is nearly planar"
            " ({recommended_percent:.0f} % recommended), so facets do not represent it. Pick"
            " traces by hand elsewhere."
        ),
    ),
    "facets.wavy": (
        "warning",
        to_translate(
            "Many facets are pieces of wavy or curved faces. Allow a larger distance for planes"
            " of whole faces, or pick traces by hand."
        ),
    ),
    "fields.few-points": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the places have no value: fewer than {minimum} points are"
            " within the radius, or these are on one line."
        ),
    ),
    "fields.single-faces": (
        "warning",
        to_translate(
            "The radius is less than two edges of the triangles, so values are those of single"
            " triangles. Choose a larger radius."
        ),
    ),
    "fields.outside-unknown": (
        "warning",
        to_translate(
            "The cloud has no normals, so up was taken as its outside: overhangs are not"
            " recognised, and below them the curvature has the opposite sign."
        ),
    ),
    "mesh.faces-apart": (
        "warning",
        to_translate(
            "The faces of the mesh are not connected ({share_percent:.0f} % of their edges belong"
            " to a single face), so facets cannot grow. Merge its vertices."
        ),
    ),
    "mesh.faces-doubled": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the faces have the same corners as others, as on a mesh"
            " with two sides. Each counts once."
        ),
    ),
    "facets.ground": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the exposed rock dips less than {limit_deg:g}°. If this"
            " is ground, leave it out: {rest_percent:.0f} % of the rest is nearly planar."
        ),
    ),
}
