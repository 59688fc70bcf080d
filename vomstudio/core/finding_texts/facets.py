"""Texts of the findings about facets and fields on a surface."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "cloud.too-few-points": (
        "error",
        to_translate(
            "A surface needs at least {minimum} points with coordinates, but the cloud has {n}."
            " Choose another cloud."
        ),
    ),
    "mesh.no-area": (
        "error",
        to_translate("All faces of the mesh have zero area. Export the model again."),
    ),
    "faces.length-too-small": (
        "error",
        to_translate(
            "The length is far too small for this model. Use a longer one, or cut out a part."
        ),
    ),
    "model.no-colours": (
        "error",
        to_translate(
            "This option needs colours, but the model has none. Use its shape or a field."
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
            "This cloud is streamed in parts, so a patch cannot grow on it. Draw the outline of the"
            " patch instead."
        ),
    ),
    "fields.points-in-line": (
        "error",
        to_translate(
            "The points within {radius_m:g} m are collinear or coincide, so they have no dip. Use"
            " a larger radius."
        ),
    ),
    "fields.too-few-points": (
        "error",
        to_translate("Too few points lie within {radius_m:g} m. Use a larger radius."),
    ),
    "fields.radius-below-faces": (
        "error",
        to_translate(
            "The radius is far smaller than the triangles of the model. Use at least"
            " {minimum_m:.2g} m."
        ),
    ),
    "cloud.noisy": (
        "warning",
        to_translate(
            "The points scatter by {noise_m:.3g} m about the surface, {times:.1f} times their"
            " spacing. Normals are estimated over {width_m:.2g} m, so smaller details are lost."
        ),
    ),
    "cloud.normals-unused": (
        "warning",
        to_translate(
            "The normals in the file deviate from the point surface by {angle_deg:.0f}° (median)"
            " and are not used."
        ),
    ),
    "cloud.normals-partly-unused": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the normals in the file deviate from the point surface by"
            " more than {limit_deg:.0f}° and are not used."
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
            "The points fill a volume instead of forming a surface. Smooth the cloud, or pick"
            " traces by hand."
        ),
    ),
    "facets.none": (
        "warning",
        to_translate(
            "No facets were found. Allow a larger angle or distance, fewer points or a smaller"
            " area, or pick traces by hand."
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
            "Many facets are parts of wavy or curved faces. Allow a larger distance to fit whole"
            " faces, or pick traces by hand."
        ),
    ),
    "fields.few-points": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the surface has no value, because fewer than {minimum}"
            " points lie within the radius or they are collinear."
        ),
    ),
    "fields.single-faces": (
        "warning",
        to_translate(
            "The radius is less than two triangle edges, so values describe single triangles. Use"
            " a larger radius."
        ),
    ),
    "fields.outside-unknown": (
        "warning",
        to_translate(
            "The cloud has no normals, so its outside is assumed to face up. Overhangs are not"
            " recognised, and curvature below them has the wrong sign."
        ),
    ),
    "mesh.faces-apart": (
        "warning",
        to_translate(
            "The faces of the mesh are disconnected ({share_percent:.0f} % of their edges belong"
            " to a single face), so facets cannot grow. Merge duplicate vertices."
        ),
    ),
    "mesh.faces-doubled": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the faces are duplicates, as in a two-sided mesh. Each is"
            " counted once."
        ),
    ),
    "facets.ground": (
        "warning",
        to_translate(
            "{share_percent:.0f} % of the exposed rock dips less than {limit_deg:g}°. If this is"
            " ground, exclude it: {rest_percent:.0f} % of the remaining rock is nearly planar."
        ),
    ),
}
