"""Texts of the findings about meshes and clouds."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

TEXTS: dict[str, Entry] = {
    "model.entities-left-out": (
        "warning",
        to_translate(
            "{count} entities are left out ({entities}). A model consists of points and faces: save"
            " solids as meshes, and blocks exploded."
        ),
    ),
    "model.no-entities": (
        "error",
        to_translate(
            "The drawing has no points or faces, only: {entities}. Save solids as meshes, and"
            " blocks exploded."
        ),
    ),
    "model.columns-left-out": (
        "warning",
        to_translate("Columns left out: {columns}. Only those with a number per point are read."),
    ),
    "model.other-shapes": (
        "error",
        to_translate(
            "The shapefile contains {shapes}. A model needs points with heights (PointZ,"
            " MultiPointZ) or faces (MultiPatch)."
        ),
    ),
    "model.rings-left-out": (
        "warning",
        to_translate(
            "{count} polygons with more than four corners are left out. Triangulate them first."
        ),
    ),
    "model.cut-short": (
        "warning",
        to_translate("The file ends too early: {count} of its points or faces were read."),
    ),
    "texture.by-name": (
        "warning",
        to_translate(
            "{file}: the texture '{missing}' of material '{material}' is missing. '{picture}' is"
            " used because of its name. Check it."
        ),
    ),
}
