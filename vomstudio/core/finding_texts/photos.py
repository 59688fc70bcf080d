"""Texts of the findings about photos and cameras."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "cameras.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring camera positions are correlated ({correlation:.2f}): the"
            " receiver drifted. The stated errors include this. Add control points."
        ),
    ),
    "photo.altitude-sign": (
        "warning",
        to_translate(
            "{photo}: EXIF states a height of {exif_m:+.2f} m, XMP {xmp_m:+.2f} m ({photos}"
            " photos). The XMP heights are used. Check their sign."
        ),
    ),
    "photo.angles-not-measured": (
        "warning",
        to_translate(
            "Yaw, pitch and roll are exactly 0 in {photos} photos ({photo}, ...), so they were not"
            " measured. They are not used."
        ),
    ),
    "photo.angles-in-comment": (
        "info",
        to_translate(
            "The angles of {photos} photos ({photo}, ...) are from EXIF UserComment: yaw from true"
            " north, pitch 0 level and -90 straight down. Check this."
        ),
    ),
    "cameras.opendronemap-angles": (
        "info",
        to_translate(
            "Yaw, pitch and roll of {file} are read as OpenDroneMap writes them: pitch 0 looks"
            " straight down, 90 ahead."
        ),
    ),
    "cameras.yaw-accuracy-unknown": (
        "warning",
        to_translate(
            "The yaws state no accuracy (sigma_yaw), so that of a compass is assumed. State it, or"
            " how far north may be off."
        ),
    ),
    "cameras.pitch-from-nadir": (
        "error",
        to_translate(
            "Pitch is between -90 (straight down) and 90 degrees. These values seem to be counted"
            " from straight down: subtract 90."
        ),
    ),
    "cameras.no-angles": (
        "error",
        to_translate(
            "The lines of the file have no yaw, pitch and roll after x, y and z. Add them."
        ),
    ),
    "photo.none": (
        "error",
        to_translate("The folder has no photos (JPEG, TIFF, PNG). Choose another folder."),
    ),
    "photo.only-other-files": (
        "error",
        *to_translate_n(
            "The folder has no photos (JPEG, TIFF, PNG), only {count} other file. Choose another"
            " folder.",
            "The folder has no photos (JPEG, TIFF, PNG), only {count} other files. Choose another"
            " folder.",
        ),
    ),
    "photo.none-usable": (
        "error",
        *to_translate_n(
            "The folder has no usable photos. {photo} was refused: {reason}",
            "The folder has no usable photos. {count} files were refused, first {photo}: {reason}",
        ),
    ),
    "photo.heif": (
        "error",
        to_translate("HEIF is not supported. Save it as JPEG with its EXIF, at full size."),
    ),
    "photo.raw": (
        "error",
        to_translate("Raw sensor data are not supported. Develop the photo to JPEG or TIFF."),
    ),
    "photo.video": (
        "error",
        to_translate("This is a video. Extract its sharp frames with vomstudio frames."),
    ),
    "photo.other-format": (
        "error",
        to_translate("This format is not supported. Convert the picture to JPEG, TIFF or PNG."),
    ),
    "photo.duplicate": (
        "error",
        to_translate("This is the same photo as {original}. One of them is used."),
    ),
    "photo.panorama": (
        "error",
        to_translate("This is a panorama made of several photos. Use those instead."),
    ),
    "photo.truncated": (
        "error",
        to_translate("The photo is truncated: its last part is missing. Copy it again."),
    ),
    "photo.raster": (
        "error",
        to_translate("This is a map or a height model (GeoTIFF), not a photo. Leave it out."),
    ),
    "photo.colors": (
        "error",
        to_translate("The photo has {mode} colours. Save it as RGB."),
    ),
    "photo.exif-damaged": (
        "warning",
        to_translate("The EXIF data are damaged ({reason}) and were read in part."),
    ),
    "photo.unknown-orientation": (
        "warning",
        to_translate("The orientation tag {tag} is unknown. The photo is used as stored."),
    ),
    "photo.position-without-fix": (
        "warning",
        to_translate("The GPS position has no fix and is not used."),
    ),
    "photo.position-invalid": (
        "warning",
        to_translate("The GPS position {position} is not valid and is not used."),
    ),
    "photo.direction-invalid": (
        "warning",
        to_translate("The direction of the view {value:g} is not an azimuth and is not used."),
    ),
    "photo.enlarged": (
        "warning",
        to_translate(
            "The photo was enlarged from {original} to {size} pixels, which adds no detail."
        ),
    ),
    "photo.cropped": (
        "warning",
        to_translate(
            "The photo was cropped from {original} to {size} pixels, so its principal point is not"
            " near the centre. Use uncropped photos."
        ),
    ),
    "photo.sensor-unused": (
        "warning",
        to_translate(
            "The focal plane resolution implies a sensor of {width_mm:.3g} mm and is not used."
        ),
    ),
    "mask.without-photo": (
        "error",
        to_translate("This is a mask without its photo. Add the photo, or remove the mask."),
    ),
    "mask.unusable": (
        "warning",
        to_translate("The mask {mask} is not used: {reason}"),
    ),
    "mask.scaled": (
        "warning",
        to_translate(
            "The mask has {mask_size} pixels, the photo {photo_size}. The mask is scaled."
        ),
    ),
    "mask.other-shape": (
        "warning",
        to_translate(
            "The mask has {mask_size} pixels, the photo {photo_size}: another aspect ratio. The"
            " mask is not used."
        ),
    ),
    "cameras.centres-in-degrees": (
        "error",
        to_translate(
            "The centres are in longitude and latitude, in which no model is. Export them in the"
            " coordinate system of the model."
        ),
    ),
    "cameras.invalid-pose": (
        "error",
        to_translate("The lens or pose is not valid: {reason}. Correct it."),
    ),
    "cameras.none-aligned": (
        "error",
        to_translate(
            "The file has no photo with a known pose. Align the photos, and export the cameras"
            " again."
        ),
    ),
    "camera.clicked": ("info", to_translate("This is the camera of photo {photo}.")),
    "cameras.none-beside-models": (
        "info",
        to_translate(
            "No open model has its cameras (cameras.json) beside it. Open them with “Open cameras”."
        ),
    ),
    "cameras.none-in-folder": (
        "error",
        to_translate(
            "The folder has no cameras. Name cameras.json, a sparse model of COLMAP, an XML of"
            " Metashape, reconstruction.json or shots.geojson."
        ),
    ),
    "cameras.repeated-photo": (
        "error",
        to_translate("The photo {photo} is in the file twice. Remove one of them."),
    ),
    "cameras.frame": (
        "info",
        to_translate("The cameras of {file} fit the model in this frame: {frame}."),
    ),
    "cameras.not-looking": (
        "warning",
        to_translate(
            "The cameras of {file} do not look at the model: its frame is probably shifted or"
            " turned. Export both in the same frame."
        ),
    ),
    "cameras.several-chunks": (
        "warning",
        to_translate(
            "The file has {count} chunks; the cameras of '{label}', which has the most, are used."
        ),
    ),
    "cameras.several-parts": (
        "warning",
        to_translate(
            "The photos fell into {count} parts; the cameras of the largest one are used."
        ),
    ),
    "cameras.sizes-unknown": (
        "warning",
        to_translate(
            "The file states no sizes of photos, and {count} photos were not found beside it. Only"
            " their positions and attitudes are used."
        ),
    ),
    "cameras.no-photo-list": (
        "error",
        to_translate(
            "The file names no photos. Put list.txt beside it, with the names of its {photos}"
            " photos, one per line."
        ),
    ),
    "cameras.own-frame": (
        "warning",
        to_translate(
            "reconstruction.json has a frame of its own, which differs from map coordinates by the"
            " convergence of meridians. For the georeferenced model name odm_report/shots.geojson."
        ),
    ),
    "cameras.unknown-lens": (
        "warning",
        to_translate(
            "The lens model {model} ({photos} photos) is not known. Marks and level lines in these"
            " photos are used as on straight lines."
        ),
    ),
    "photo.no-camera": (
        "error",
        to_translate("The photo {photo} has no camera in {cameras}. It has those of: {photos}."),
    ),
    "lens.unknown-model": (
        "error",
        to_translate("The lens model {model} is unknown. Choose one of: {models}."),
    ),
    "lens.parameter-count": (
        "error",
        to_translate(
            "The lens model {model} has {needed} parameters, and {given} are given. Correct them."
        ),
    ),
    "points.tables-outdated": (
        "warning",
        to_translate(
            "The points are saved in the project, but the tables beside the photos are not "
            "up to date. {reason}"
        ),
    ),
    "points.table-in-project": (
        "warning",
        to_translate(
            "The folder of the photos cannot be written to. {table} is saved in the project "
            "instead: {folder}"
        ),
    ),
    "points.former-table": (
        "info",
        to_translate(
            "{table} contained values that the project does not have. The former file is "
            "kept as {copy}."
        ),
    ),
    "points.imported": (
        "info",
        *to_translate_n(
            "{count} point was imported.",
            "{count} points were imported.",
        ),
    ),
    "marks.imported": (
        "info",
        *to_translate_n(
            "{count} mark was imported.",
            "{count} marks were imported.",
        ),
    ),
    "mask.files-outdated": (
        "warning",
        to_translate("The masks are saved in the project, but not beside the photos. {reason}"),
    ),
    "mask.former-file": (
        "info",
        to_translate("The former mask is kept as {copy}."),
    ),
    "photo.none-found": (
        "error",
        to_translate("The photos were not found. Choose their folder with “Locate photos”."),
    ),
    "photo.not-shown": (
        "error",
        to_translate("{photo} cannot be shown: {reason}"),
    ),
    "photo.folder-missing": (
        "warning",
        to_translate(
            "The photos {name} are no longer in {folder}. Choose their folder with New "
            "model from photos."
        ),
    ),
    "photo.files-changed": (
        "warning",
        to_translate(
            "Another program has changed files beside the photos: {files}. They are not "
            "used until you import them."
        ),
    ),
    "marks.other-photos": (
        "warning",
        to_translate("Marks in photos that are not in this folder are kept: {photos}."),
    ),
    "mask.repeated": (
        "info",
        *to_translate_n(
            "The shape was drawn in {count} more photo.",
            "The shape was drawn in {count} more photos.",
        ),
    ),
    "mask.repeating": (
        "info",
        *to_translate_n(
            "Masks are being drawn: {done} of {count} photo is done. Wait for the rest.",
            "Masks are being drawn: {done} of {count} photos are done. Wait for the rest.",
        ),
    ),
    "mask.pending": (
        "info",
        to_translate("The mask is being read. Wait until it is shown."),
    ),
    "photos.pending": (
        "info",
        to_translate("The photos are being read. Wait until they are listed."),
    ),
    "mask.size-differs": (
        "info",
        *to_translate_n(
            "{count} photo of another size is unchanged.",
            "{count} photos of another size are unchanged.",
        ),
    ),
}
