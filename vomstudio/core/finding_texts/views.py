"""Texts of the findings about orthophotos, elevation models and drawings on them."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "view.direction-unmeasured": (
        "info",
        to_translate("The view was set by hand and is not derived from measurements."),
    ),
    "model.no-surface": (
        "error",
        to_translate("The model has no surface. Choose one with faces or points."),
    ),
    "transform.not-a-matrix": (
        "error",
        to_translate("The transform to World is not a matrix of 4 x 4 finite numbers. Correct it."),
    ),
    "view.not-a-part": (
        "error",
        to_translate(
            "“{text}” is not a part of a view. Use the form x,y,z,width,height: a World point and"
            " two lengths in metres."
        ),
    ),
    "view.part-empty": (
        "error",
        to_translate("This part of the view does not contain the model. Choose another part."),
    ),
    "view.no-pixels": (
        "error",
        to_translate(
            "The model is not visible in any pixel of this view. Choose another part, a finer"
            " ground sampling distance or another direction."
        ),
    ),
    "view.edge-on": (
        "warning",
        to_translate(
            "The model is nearly flat and seen edge-on, so the view shows only its edge. Look"
            " perpendicular to its mean plane: --plane {plane}."
        ),
    ),
    "view.not-placed": (
        "warning",
        to_translate(
            "The model was reconstructed without control points or GPS, so north is unknown, and"
            " the unit too unless --unit is specified."
        ),
    ),
    "view.axis-conditional": (
        "warning",
        to_translate(
            "A view along this axis is only conditionally valid: {verdict} (see vomstudio fold)."
        ),
    ),
    "view.axis-not-valid": (
        "warning",
        to_translate("A view along this axis is not valid: {verdict} (see vomstudio fold)."),
    ),
    "view.axis-error": (
        "warning",
        to_translate(
            "The 95 % error of the axis, {error_deg:.1f}°, shortens lengths in the tilt direction"
            " by {share_percent:.1f} % and displaces points by up to {displacement:.3g} {unit}"
            " (depth {depth:.3g} {unit})."
        ),
    ),
    "view.axis-error-unknown": (
        "warning",
        to_translate(
            "The direction error is unknown. An error of {error_deg:.1f}° would shorten lengths in"
            " the tilt direction by {share_percent:.1f} % and displace points up to"
            " {displacement:.3g} {unit} (depth {depth:.3g} {unit})."
        ),
    ),
    "view.off-axis": (
        "warning",
        to_translate(
            "The view is {off_deg:.0f}° off the axis of domain {domain}, {axis} ({description})."
        ),
    ),
    "view.off-axis-cost": (
        "warning",
        to_translate(
            "An error of {error_deg:.0f}° in the direction shortens lengths in the tilt"
            " direction by {share_percent:.1f} % and displaces points by up to {displacement:.3g}"
            " {unit} (depth {depth:.3g} {unit})."
        ),
    ),
    "view.chosen": (
        "info",
        to_translate("Selected direction: {description}"),
    ),
    "view.as-given": (
        "info",
        to_translate("The viewer looks along the given direction."),
    ),
    "view.against-normal": (
        "info",
        to_translate("The viewer looks against the upward normal of the plane."),
    ),
    "view.down-plunge": (
        "info",
        to_translate("{share_percent:.0f} % of the visible surface faces the viewer."),
    ),
    "view.down-plunge-estimated": (
        "info",
        to_translate(
            "{share_percent:.0f} % of the visible surface faces the viewer (estimated normals,"
            " assumed to point up)."
        ),
    ),
    "view.down-plunge-unseen": (
        "info",
        to_translate("No part of the surface is visible from this direction."),
    ),
    "view.up-plunge": (
        "info",
        to_translate(
            "Seen down-plunge, {share_percent:.0f} % of the visible surface faces away"
            " from the viewer."
        ),
    ),
    "view.up-plunge-estimated": (
        "info",
        to_translate(
            "Seen down-plunge, {share_percent:.0f} % of the visible surface faces away from the"
            " viewer (estimated normals, assumed to point up)."
        ),
    ),
    "view.flipped": (
        "info",
        to_translate("The view was flipped on request. Before: {reason}"),
    ),
    "gsd.texture": (
        "info",
        to_translate(
            "The ground sampling distance is {gsd:g} {unit} per pixel, the resolution of the"
            " texture on the surface."
        ),
    ),
    "gsd.edges": (
        "info",
        to_translate(
            "The ground sampling distance is {gsd:g} {unit} per pixel, the mean edge length of the"
            " mesh."
        ),
    ),
    "gsd.spacing": (
        "info",
        to_translate(
            "The ground sampling distance is {gsd:g} {unit} per pixel, the mean point spacing of"
            " the cloud."
        ),
    ),
    "gsd.size": (
        "info",
        to_translate(
            "The ground sampling distance is {gsd:g} {unit} per pixel, a thousandth of the size of"
            " the model."
        ),
    ),
    "gsd.limited": (
        "info",
        to_translate(
            "The ground sampling distance is {gsd:g} {unit} per pixel, the finest that needs"
            " fewer than {limit} million pixels."
        ),
    ),
    "ortho.written": (
        "info",
        to_translate(
            "{file} was saved: {width} × {height} pixels of {gsd:g} {unit}, coverage"
            " {coverage_percent:.0f} %."
        ),
    ),
    "gsd.too-many-pixels": (
        "error",
        to_translate(
            "A ground sampling distance of {gsd_m:g} m needs {megapixels:.0f} million pixels (limit"
            " {limit} million). Use {least_m:g} m or more."
        ),
    ),
    "raster.no-crs": (
        "warning",
        to_translate(
            "The model has no coordinate reference system (CRS). The raster is written in the"
            " model's coordinates, without a CRS."
        ),
    ),
    "raster.too-many-cells": (
        "error",
        to_translate(
            "The raster would have {count:,} cells (at most {maximum:,}). Use larger cells (--gsd)."
        ),
    ),
    "dem.no-heights": (
        "error",
        to_translate(
            "No cell has a height: the surface is seen edge-on, or smaller than a cell. Choose"
            " another reference plane or a smaller --gsd."
        ),
    ),
    "dem.points-in-line": (
        "error",
        to_translate(
            "Seen along the normal of this plane, the points are collinear or fewer than three."
            " Choose another reference plane."
        ),
    ),
    "dem.too-many-contours": (
        "error",
        to_translate(
            "Contours every {spacing_m:g} m would need more than {maximum} levels over"
            " {range_m:.4g} m of height. Choose a larger contour interval."
        ),
    ),
    "dem.no-contours": (
        "warning",
        to_translate(
            "No contour line lies within the range of heights. Choose a smaller contour interval."
        ),
    ),
    "texture.not-drawn": (
        "warning",
        to_translate("This texture cannot be read. Its faces are drawn without it."),
    ),
    "interpretation.legend-alone": (
        "error",
        to_translate(
            "A legend alone would be empty. Add traces, patches or symbols to the drawing."
        ),
    ),
    "interpretation.not-in-view": (
        "warning",
        to_translate("No requested feature lies in the view, so no drawing is written."),
    ),
    "interpretation.partly-in-view": (
        "warning",
        *to_translate_n(
            "{count} feature lies outside the view and is not drawn.",
            "{count} features lie outside the view and are not drawn.",
        ),
    ),
    "domain.none": (
        "error",
        to_translate(
            "No feature belongs to a domain. Assign domains first (Properties > Domain, or a"
            " column called domain)."
        ),
    ),
    "domain.unknown": (
        "error",
        to_translate("No feature belongs to the domain {domain}. Choose one of: {domains}."),
    ),
    "domain.no-axis": (
        "error",
        to_translate(
            "Domain {domain} has no axis of its own ({reason}). Specify a view direction."
        ),
    ),
    "domain.ends-at-faults": (
        "info",
        to_translate("Domain {domain} ends at {faults}."),
    ),
    "domain.no-fault-between": (
        "info",
        to_translate(
            "No fault separates domain {domain} from {others}, so it ends halfway to their"
            " nearest features."
        ),
    ),
    "domain.on-both-sides": (
        "info",
        *to_translate_n(
            "{count} feature lies on both sides of the plane and is unchanged.",
            "{count} features lie on both sides of the plane and are unchanged.",
        ),
    ),
    "sidecar.other-file": (
        "error",
        to_translate(
            "This is not the sidecar of an orthophoto. Choose the file NAME.json that was written"
            " with the orthophoto."
        ),
    ),
    "sidecar.no-place": (
        "error",
        to_translate(
            "The sidecar does not specify the position of the pixels on the model. Create the"
            " orthophoto again."
        ),
    ),
    "drawing.not-finite": (
        "error",
        to_translate("The drawing has coordinates that are not finite numbers. Save it again."),
    ),
    "drawing.other-picture": (
        "error",
        to_translate("The lines were drawn on another orthophoto. Choose its sidecar (NAME.json)."),
    ),
    "drawing.several-pictures": (
        "error",
        to_translate(
            "{count} pictures in the drawing, at different positions, may be the orthophoto. Keep"
            " only the one on which the lines were drawn, linked as {name}."
        ),
    ),
    "drawing.on-map": (
        "error",
        to_translate(
            "The drawing is in map coordinates ({crs}), but the orthophoto is in those of its view"
            " plane. Draw in the coordinates of the GeoTIFF."
        ),
    ),
    "drawing.off-surface": (
        "error",
        to_translate(
            "None of the lines lies on the surface. Check that the model and the sidecar belong to"
            " the orthophoto."
        ),
    ),
    "drawing.points-off-surface": (
        "warning",
        *to_translate_n(
            "{count} point is off the surface and was left out.",
            "{count} points are off the surface and were left out.",
        ),
    ),
    "drawing.lines-off-surface": (
        "warning",
        *to_translate_n(
            "{count} line has fewer than two points on the surface and was left out.",
            "{count} lines have fewer than two points on the surface and were left out.",
        ),
    ),
    "drawing.layers-left-out": (
        "warning",
        *to_translate_n(
            "The layer {names} was not drawn on this orthophoto and is left out.",
            "The layers {names} were not drawn on this orthophoto and are left out.",
        ),
    ),
    "drawing.unit-converted": (
        "info",
        to_translate("The drawing is in units of {unit_m:g} m and was converted to metres."),
    ),
}
