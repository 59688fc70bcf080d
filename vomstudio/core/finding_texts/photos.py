"""Texts of the findings about photos and cameras."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "cameras.drift": (
        "warning",
        to_translate(
            "Errors of neighbouring camera positions are correlated ({correlation:.2f}): the"
            " receiver probably drifted. The stated errors include this. Add control points."
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
            "Yaw, pitch and roll are exactly 0 in {photos} photos ({photo}, ...), so they were"
            " probably not measured and are not used."
        ),
    ),
    "photo.angles-in-comment": (
        "info",
        to_translate(
            "The angles of {photos} photos ({photo}, ...) come from EXIF UserComment: yaw from"
            " true north, pitch 0 level and -90 straight down. Check this."
        ),
    ),
    "cameras.opendronemap-angles": (
        "info",
        to_translate(
            "Yaw, pitch and roll in {file} are assumed to follow the OpenDroneMap convention: pitch"
            " 0 is straight down, 90 horizontal."
        ),
    ),
    "cameras.yaw-accuracy-unknown": (
        "warning",
        to_translate(
            "The yaws have no stated accuracy (sigma_yaw), so that of a compass is assumed. Specify"
            " sigma_yaw, or the error of north (--north-sigma)."
        ),
    ),
    "cameras.pitch-from-nadir": (
        "error",
        to_translate(
            "Pitch must be between -90 (straight down) and 90 degrees. These values appear to be"
            " measured from straight down: subtract 90."
        ),
    ),
    "cameras.no-angles": (
        "error",
        to_translate(
            "The lines in the file have no yaw, pitch and roll after x, y and z. Add them."
        ),
    ),
    "photo.none": (
        "error",
        to_translate("The folder has no photos (JPEG, HEIC, TIFF, PNG). Choose another folder."),
    ),
    "photo.only-other-files": (
        "error",
        *to_translate_n(
            "The folder has no photos (JPEG, HEIC, TIFF, PNG), only {count} other file. Choose"
            " another folder.",
            "The folder has no photos (JPEG, HEIC, TIFF, PNG), only {count} other files. Choose"
            " another folder.",
        ),
    ),
    "photo.none-usable": (
        "error",
        *to_translate_n(
            "The folder has no usable photos. {photo} was rejected: {reason}",
            "The folder has no usable photos. {count} files were rejected, first {photo}: {reason}",
        ),
    ),
    "photo.avif": (
        "error",
        to_translate(
            "AVIF is not supported. Save the photo as JPEG at full size, with its EXIF data."
        ),
    ),
    "photo.raw": (
        "error",
        to_translate("Raw files are not supported. Convert the photo to JPEG or TIFF."),
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
        to_translate("This photo is identical to {original}. Only one of them is used."),
    ),
    "photo.panorama": (
        "error",
        to_translate(
            "This is a panorama stitched from several photos. Use the individual photos instead."
        ),
    ),
    "photo.truncated": (
        "error",
        to_translate("The photo is truncated: its end is missing. Copy it again."),
    ),
    "photo.raster": (
        "error",
        to_translate(
            "This is a map or a height model (GeoTIFF), not a photo. Remove it from the folder."
        ),
    ),
    "photo.colors": (
        "error",
        to_translate("The photo has {mode} colours. Save it as RGB."),
    ),
    "photo.exif-damaged": (
        "warning",
        to_translate("The EXIF data are damaged ({reason}) and were only partly read."),
    ),
    "photo.unknown-orientation": (
        "warning",
        to_translate("The orientation tag {tag} is unknown. The photo is not rotated."),
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
        to_translate("The view direction {value:g} is not a valid azimuth and is not used."),
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
            " at its centre. Use uncropped photos."
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
        to_translate("This mask has no photo. Add its photo, or remove the mask."),
    ),
    "mask.unusable": (
        "warning",
        to_translate("The mask {mask} is not used: {reason}"),
    ),
    "mask.scaled": (
        "warning",
        to_translate(
            "The mask has {mask_size} pixels, but the photo has {photo_size}. The mask is scaled."
        ),
    ),
    "mask.other-shape": (
        "warning",
        to_translate(
            "The mask has {mask_size} pixels, but the photo has {photo_size}. Their aspect ratios"
            " differ, so the mask is not used."
        ),
    ),
    "cameras.centres-in-degrees": (
        "error",
        to_translate(
            "The camera centres are in longitude and latitude. Export them in the projected"
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
            "The file contains no aligned photo. Align the photos, and export the cameras again."
        ),
    ),
    "camera.clicked": ("info", to_translate("This is the camera of photo {photo}.")),
    "cameras.none-beside-models": (
        "info",
        to_translate(
            "No open model has a camera file (cameras.json) in its folder. Open one with “Open"
            " cameras”."
        ),
    ),
    "cameras.none-in-folder": (
        "error",
        to_translate(
            "The folder has no cameras. Specify cameras.json, or the camera file exported by the"
            " program that made the model."
        ),
    ),
    "cameras.repeated-photo": (
        "error",
        to_translate("The photo {photo} is in the file twice. Remove one of the two entries."),
    ),
    "cameras.frame": (
        "info",
        to_translate("The cameras in {file} fit the model in this frame: {frame}."),
    ),
    "cameras.not-looking": (
        "warning",
        to_translate(
            "The cameras in {file} do not look at the model, so their frame is probably shifted or"
            " rotated. Export cameras and model in the same frame."
        ),
    ),
    "cameras.several-chunks": (
        "warning",
        to_translate(
            "The file has {count} chunks. The cameras of '{label}', the largest, are used."
        ),
    ),
    "cameras.several-parts": (
        "warning",
        to_translate(
            "The photos form {count} separate parts. The cameras of the largest one are used."
        ),
    ),
    "cameras.sizes-unknown": (
        "warning",
        to_translate(
            "The file does not state the sizes of the photos, and {count} photos were not found"
            " next to it. Only their positions and attitudes are used."
        ),
    ),
    "cameras.lenses-simplified": (
        "warning",
        to_translate(
            "transforms.json cannot store the distortion coefficients k4 to k6 of {photos}. Export"
            " to COLMAP to keep the complete lens model."
        ),
    ),
    "cameras.no-world": (
        "error",
        to_translate("The cameras have no World frame. Register the model first, or omit --world."),
    ),
    "cameras.lenses-missing": (
        "warning",
        to_translate(
            "The lenses {lenses} of the photos {photos} are missing from the file. Only the poses"
            " are used. Export the file again with intrinsics."
        ),
    ),
    "cameras.no-photo-list": (
        "error",
        to_translate(
            "The file does not contain the names of its {photos} photos. Put list.txt next to it,"
            " with one name per line."
        ),
    ),
    "cameras.own-frame": (
        "warning",
        to_translate(
            "reconstruction.json has its own frame, which is rotated relative to map coordinates by"
            " the meridian convergence. For the georeferenced model, use odm_report/shots.geojson."
        ),
    ),
    "cameras.unknown-lens": (
        "warning",
        to_translate(
            "The lens model {model} ({photos} photos) is unknown. Marks and level lines in these"
            " photos are used without distortion correction."
        ),
    ),
    "photo.no-camera": (
        "error",
        to_translate(
            "{cameras} contains no camera for the photo {photo}. Choose one of: {photos}."
        ),
    ),
    "lens.unknown-model": (
        "error",
        to_translate("The lens model {model} is unknown. Choose one of: {models}."),
    ),
    "lens.parameter-count": (
        "error",
        to_translate(
            "The lens model {model} needs {needed} parameters, not {given}. Correct them."
        ),
    ),
    "points.tables-outdated": (
        "warning",
        to_translate(
            "The points are saved in the project, but the tables next to the photos are not up to"
            " date. {reason}"
        ),
    ),
    "points.table-in-project": (
        "warning",
        to_translate(
            "The photo folder is not writable. {table} is saved in the project instead: {folder}"
        ),
    ),
    "points.former-table": (
        "info",
        to_translate(
            "{table} contained values that the project does not have. The previous file is kept"
            " as {copy}."
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
        to_translate("The masks are saved in the project, but not next to the photos. {reason}"),
    ),
    "mask.former-file": (
        "info",
        to_translate("The previous mask is kept as {copy}."),
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
            "The photo set {name} is no longer in {folder}. Choose its folder with New model from"
            " photos."
        ),
    ),
    "photo.files-changed": (
        "warning",
        to_translate(
            "Another program has changed files next to the photos: {files}. They are not used"
            " until you import them."
        ),
    ),
    "marks.other-photos": (
        "warning",
        to_translate("Marks in photos outside this folder are kept: {photos}."),
    ),
    "mask.repeated": (
        "info",
        *to_translate_n(
            "The shape was also drawn in {count} other photo.",
            "The shape was also drawn in {count} other photos.",
        ),
    ),
    "mask.repeating": (
        "info",
        *to_translate_n(
            "Masks are being drawn: {done} of {count} photo. Please wait.",
            "Masks are being drawn: {done} of {count} photos. Please wait.",
        ),
    ),
    "mask.pending": (
        "info",
        to_translate("The mask is being read. Please wait."),
    ),
    "photos.pending": (
        "info",
        to_translate("The photos are being read. Please wait."),
    ),
    "mask.size-differs": (
        "info",
        *to_translate_n(
            "{count} photo of a different size is unchanged.",
            "{count} photos of a different size are unchanged.",
        ),
    ),
}
