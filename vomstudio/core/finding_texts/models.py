"""Texts of the findings about meshes and point clouds."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "model.entities-left-out": (
        "warning",
        to_translate(
            "{count} entities are left out ({entities}). Only points and faces are read: save"
            " solids as meshes, and explode blocks."
        ),
    ),
    "model.no-entities": (
        "error",
        to_translate(
            "The drawing contains only {entities} and no points or faces. Save solids as meshes,"
            " and explode blocks."
        ),
    ),
    "model.columns-left-out": (
        "warning",
        to_translate(
            "Columns left out: {columns}. Only columns with a number for every point are read."
        ),
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
        to_translate(
            "The file is truncated: only {count} of its points or faces were read. Copy it again."
        ),
    ),
    "texture.by-name": (
        "warning",
        to_translate(
            "{file}: the texture '{missing}' of material '{material}' is missing. '{picture}' has"
            " a similar name and is used instead. Check it."
        ),
    ),
    "model.unsupported": (
        "error",
        to_translate(
            "The file uses {feature}, which is not supported. Export it without this feature, or"
            " in another format."
        ),
    ),
    "model.extension-unsupported": (
        "warning",
        to_translate(
            "The file uses the extension '{extension}', which is not supported. Check whether the"
            " model is complete."
        ),
    ),
    "model.part-missing": (
        "error",
        to_translate(
            "A file that belongs to the model is missing: {reason}. Put it next to the model."
        ),
    ),
    "model.no-points": (
        "error",
        to_translate("The file has no points with valid coordinates. Export the model again."),
    ),
    "model.no-faces": (
        "error",
        to_translate("The file has no faces. Export the model again."),
    ),
    "model.no-coordinates": (
        "error",
        to_translate(
            "The points in the file have no x, y and z coordinates. Export the model again."
        ),
    ),
    "model.all-withheld": (
        "error",
        to_translate(
            "All points are marked as withheld. Unmark the points you need and export the file"
            " again."
        ),
    ),
    "model.too-many-elements": (
        "error",
        to_translate("The model has more than {limit:,} vertices or faces. Divide it into tiles."),
    ),
    "model.incomplete": (
        "warning",
        to_translate(
            "The file is truncated: it has {count:,} of the {promised:,} {element} stated in its"
            " header. Copy it again."
        ),
    ),
    "model.maybe-cut-short": (
        "warning",
        to_translate(
            "The file does not end with {end}, so it may be truncated. Compare the number of"
            " faces with the program that wrote the file."
        ),
    ),
    "model.trailing-bytes": (
        "warning",
        *to_translate_n(
            "Data after the {count:,} face stated in the header are ignored.",
            "Data after the {count:,} faces stated in the header are ignored.",
        ),
    ),
    "model.opened-as-cloud": (
        "warning",
        to_translate("The file has no valid faces. It is opened as a point cloud."),
    ),
    "model.points-invalid": (
        "warning",
        *to_translate_n(
            "{count:,} point without valid coordinates is left out.",
            "{count:,} points without valid coordinates are left out.",
        ),
    ),
    "model.points-withheld": (
        "warning",
        *to_translate_n(
            "{count:,} point marked as withheld or invalid is left out.",
            "{count:,} points marked as withheld or invalid are left out.",
        ),
    ),
    "model.withheld-hidden": (
        "warning",
        to_translate("Points marked as withheld are not shown."),
    ),
    "model.points-far-away": (
        "warning",
        *to_translate_n(
            "{count:,} point is left out: its coordinates are too large for metres.",
            "{count:,} points are left out: their coordinates are too large for metres.",
        ),
    ),
    "model.loose-points-left-out": (
        "warning",
        *to_translate_n(
            "{count:,} point that belongs to no face is left out.",
            "{count:,} points that belong to no face are left out.",
        ),
    ),
    "model.scan-left-out": (
        "warning",
        to_translate("Scan {number} has no coordinates and is left out."),
    ),
    "model.faces-without-vertices": (
        "warning",
        *to_translate_n(
            "{count:,} face is left out: it refers to missing vertices.",
            "{count:,} faces are left out: they refer to missing vertices.",
        ),
    ),
    "model.faces-incomplete": (
        "warning",
        *to_translate_n(
            "{count:,} face with fewer than three corners is left out.",
            "{count:,} faces with fewer than three corners are left out.",
        ),
    ),
    "model.faces-invalid": (
        "warning",
        *to_translate_n(
            "{count:,} face is left out: one of its corners has no valid coordinates.",
            "{count:,} faces are left out: some of their corners have no valid coordinates.",
        ),
    ),
    "model.faces-without-area": (
        "warning",
        *to_translate_n(
            "{count:,} face has no area: two of its corners are the same vertex.",
            "{count:,} faces have no area: two of their corners are the same vertex.",
        ),
    ),
    "model.no-face-indices": (
        "warning",
        to_translate("The faces have no list property 'vertex_indices' and are left out."),
    ),
    "model.lines-left-out": (
        "warning",
        *to_translate_n(
            "{count:,} line or point element in the file is left out.",
            "{count:,} line or point elements in the file are left out.",
        ),
    ),
    "model.values-not-numbers": (
        "warning",
        *to_translate_n(
            "{count:,} value is not a number (line {line}).",
            "{count:,} values are not numbers (first in line {line}).",
        ),
    ),
    "model.text-lines-left-out": (
        "warning",
        *to_translate_n(
            "{count:,} line was not recognised and is left out.",
            "{count:,} lines were not recognised and are left out.",
        ),
    ),
    "model.short-lines": (
        "warning",
        *to_translate_n(
            "{count:,} line has too few values.",
            "{count:,} lines have too few values.",
        ),
    ),
    "model.columns-as-colors": (
        "warning",
        to_translate(
            "Columns {first} to {last} have no names. They are read as red, green and blue."
        ),
    ),
    "model.columns-as-normals": (
        "warning",
        to_translate("Columns {first} to {last} have no names. They are read as normals."),
    ),
    "model.colors-not-numbers": (
        "warning",
        to_translate("The colours are not used: some of them are not numbers."),
    ),
    "model.normals-not-numbers": (
        "warning",
        to_translate("The normals are not used: some of them are not numbers."),
    ),
    "model.colors-black": (
        "warning",
        to_translate("All colours are black, so they are not used."),
    ),
    "model.face-colors-unused": (
        "warning",
        to_translate("The faces have their own colours or attributes, which are not used."),
    ),
    "model.fields-left-out": (
        "warning",
        to_translate("These point fields are not read: {fields}."),
    ),
    "model.fields-limited": (
        "warning",
        to_translate(
            "The file has {count:,} values per point, of which the first {limit:,} are read."
        ),
    ),
    "model.fields-damaged": (
        "warning",
        to_translate("The description of the point fields is invalid, so they are not read."),
    ),
    "model.elements-left-out": (
        "warning",
        to_translate("These elements of the file are not read: {elements}."),
    ),
    "model.attributes-unused": (
        "warning",
        to_translate(
            "The attribute table (.dbf) does not match the shapes and is not used. Copy all files"
            " of the shapefile."
        ),
    ),
    "model.pose-unused": (
        "warning",
        to_translate("The file has a skeleton. The model is shown without its pose."),
    ),
    "model.origin-invalid": (
        "warning",
        to_translate(
            "{file} has no valid origin (offset x y z), so the coordinates are not shifted."
        ),
    ),
    "model.origin-unused": (
        "warning",
        to_translate(
            "{file} has a different origin from the model file. The origin of the model file is"
            " used."
        ),
    ),
    "model.maybe-lying": (
        "warning",
        to_translate(
            "The surface faces along Z, but in this format Y is up. If the model lies on its"
            " side, convert it with --up z."
        ),
    ),
    "model.cache-unwritable": (
        "error",
        to_translate(
            "The cache cannot be written ({reason}). Free some disk space or move the project."
        ),
    ),
    "model.cache-damaged": (
        "error",
        to_translate("The cache is damaged: {reason}. Open the original model file."),
    ),
    "model.file-changed": (
        "error",
        to_translate(
            "The file has changed since the selection was made, so nothing was cut. Open the"
            " model again."
        ),
    ),
    "model.other-selection": (
        "error",
        to_translate(
            "The selection has {selected:,} elements, but the model has {count:,}. Make the"
            " selection on this model."
        ),
    ),
    "model.empty-selection": (
        "error",
        to_translate("Nothing is selected. Select a part of the model."),
    ),
    "model.exceeds-format": (
        "error",
        to_translate(
            "The model is too large for the format {format}. Use another format ({alternatives}),"
            " or divide the model."
        ),
    ),
    "model.not-finite": (
        "error",
        *to_translate_n(
            "{count} point has a coordinate that is not finite (row {first_row}, counted from 0)."
            " Correct or remove it.",
            "{count} points have coordinates that are not finite (first: row {first_row}, counted"
            " from 0). Correct or remove them.",
        ),
    ),
    "model.field-renamed": (
        "warning",
        to_translate("The field '{field}' is called '{new}' in this format."),
    ),
    "model.field-rounded": (
        "warning",
        to_translate("The field '{field}' is rounded to {precision}."),
    ),
    "model.positions-rounded": (
        "warning",
        to_translate("Coordinates are rounded by up to {rounding_mm:.2g} mm."),
    ),
    "model.normals-as-fields": (
        "warning",
        to_translate("Normals are written as the fields normal_x, normal_y and normal_z."),
    ),
    "model.fields-not-written": (
        "warning",
        to_translate("This format does not support fields. Left out: {fields}."),
    ),
    "model.textures-not-written": (
        "warning",
        to_translate("This format does not support textures. Left out: {images}."),
    ),
    "model.materials-not-written": (
        "warning",
        to_translate(
            "This format does not support materials without a texture. Left out: {materials}."
        ),
    ),
    "model.normals-not-written": (
        "warning",
        to_translate("This format does not support point normals. They are left out."),
    ),
    "model.colors-not-written": (
        "warning",
        to_translate("This format does not support vertex colours of meshes. They are left out."),
    ),
    "model.colors-reduced": (
        "warning",
        to_translate("Colours are reduced to the 255 colours of DXF release 12."),
    ),
    "model.faces-not-written": (
        "warning",
        *to_translate_n(
            "This format does not support faces. The vertices are written without the {count:,}"
            " face of the mesh.",
            "This format does not support faces. The vertices are written without the {count:,}"
            " faces of the mesh.",
        ),
    ),
    "texture.unusable": (
        "warning",
        to_translate("The texture of material '{material}' is not used: {reason}."),
    ),
    "texture.substituted": (
        "warning",
        to_translate("The texture of material '{material}' is replaced: {reason}. Check it."),
    ),
    "texture.only-colors": (
        "warning",
        to_translate(
            "Only colour textures are used. Normal, occlusion and emission maps are ignored."
        ),
    ),
    "texture.no-coordinates": (
        "warning",
        *to_translate_n(
            "{count:,} face corner has no texture, because it refers to missing texture"
            " coordinates (line {line}).",
            "{count:,} face corners have no texture, because they refer to missing texture"
            " coordinates (first in line {line}).",
        ),
    ),
    "texture.unknown-number": (
        "warning",
        *to_translate_n(
            "{count:,} face has no texture, because its texture number is not in the header.",
            "{count:,} faces have no texture, because their texture numbers are not in the header.",
        ),
    ),
    "texture.no-numbers": (
        "warning",
        to_translate("There are several textures but no 'texnumber' per face. The first is used."),
    ),
    "texture.shift-unused": (
        "warning",
        to_translate(
            "The shift or scale of the texture of material '{material}' ({statement}) is not"
            " applied."
        ),
    ),
    "texture.unreadable": (
        "error",
        to_translate(
            "The texture cannot be read ({reason}). Restore it, or save it as JPEG or PNG."
        ),
    ),
    "material.too-many-files": (
        "warning",
        to_translate(
            "The file refers to {count:,} material files, of which the first {limit:,} are read."
        ),
    ),
    "material.no-file": (
        "warning",
        to_translate(
            "The file uses materials without a material file (mtllib). They are shown in grey."
        ),
    ),
    "material.missing": (
        "warning",
        to_translate("These materials are in no material file and are shown in grey: {names}."),
    ),
    "material.file-unusable": (
        "warning",
        to_translate("A material file is not used: {reason}."),
    ),
    "material.file-substituted": (
        "warning",
        to_translate("A material file is replaced: {reason}."),
    ),
    "material.color-invalid": (
        "warning",
        to_translate("{file}, line {line}: the colour '{color}' cannot be read and is not used."),
    ),
    "dem.picture": (
        "error",
        to_translate(
            "This is a picture ({bands} bands of {kind}), not a height model. Open the model it"
            " was made from."
        ),
    ),
    "dem.depths": (
        "error",
        to_translate(
            "These are depths of an oblique picture, not heights. Open the model it was made from."
        ),
    ),
    "dem.not-heights": (
        "error",
        to_translate("The values are {kind}, which cannot be heights. Export the file as Float32."),
    ),
    "dem.too-small": (
        "error",
        to_translate("A single row of pixels does not define a surface. Export a larger part."),
    ),
    "dem.no-place": (
        "error",
        to_translate(
            "The raster has no valid position and pixel size. Export it as a GeoTIFF with both."
        ),
    ),
    "dem.first-band": (
        "warning",
        to_translate("Only the first of {count} bands is read as heights."),
    ),
    "dem.reduced": (
        "warning",
        to_translate(
            "Only {columns:,} x {rows:,} of {width:,} x {height:,} pixels are read (one in {step}"
            " in both directions). Open a part of the file to read every pixel."
        ),
    ),
    "dem.scale-unused": (
        "warning",
        to_translate("The file states a height scale of 0, which is not used."),
    ),
    "dem.no-data-value": (
        "warning",
        *to_translate_n(
            "{count:,} pixel with the value {value:g} is treated as no data.",
            "{count:,} pixels with the value {value:g} are treated as no data.",
        ),
    ),
    "dem.unit-unknown": (
        "warning",
        to_translate("The unit of the heights ({unit}) is unknown. The unit of the CRS is used."),
    ),
    "dem.pixels-left-out": (
        "warning",
        *to_translate_n(
            "{count:,} pixel is left out: a value beyond ±100 km cannot be a height.",
            "{count:,} pixels are left out: values beyond ±100 km cannot be heights.",
        ),
    ),
    "display.texture-unreadable": (
        "warning",
        to_translate(
            "The texture {file} cannot be read ({reason}). The surface is drawn without it."
        ),
    ),
    "display.texture-too-large": (
        "warning",
        to_translate(
            "The texture {file} has {width} × {height} pixels, which is too large to draw. The"
            " surface is drawn without it."
        ),
    ),
    "display.texture-reduced": (
        "warning",
        to_translate(
            "The texture {file} has {width} × {height} pixels, but the graphics card supports"
            " {limit} per side. It is shown at 1/{factor} of its resolution."
        ),
    ),
    "display.texture-damaged": (
        "warning",
        to_translate("The texture {file} is damaged ({reason}). The surface is drawn without it."),
    ),
    "display.points-missing": (
        "warning",
        to_translate("No more points of a cloud can be loaded. {reason}"),
    ),
    "display.part-missing": (
        "warning",
        to_translate("Part of a cloud is not shown. {reason}"),
    ),
    "display.not-prepared": (
        "warning",
        to_translate("The model could not be prepared for display. {reason}"),
    ),
    "display.field-not-shown": (
        "warning",
        to_translate("The scalar field {field} cannot be shown. {reason}"),
    ),
}
