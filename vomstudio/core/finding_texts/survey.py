"""Texts of the findings about photo sets, before and after their alignment.

The codes without a dot belong to the survey check. Each of them has the values ``photos`` (names of
the affected photos; empty for all) and ``value`` (the number on which the finding is based).
"""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate, to_translate_n

TEXTS: dict[str, Entry] = {
    "one-photo": (
        "error",
        to_translate(
            "Depth cannot be determined from a single photo. Take at least two photos of the same"
            " rock, preferably ten."
        ),
    ),
    "few-photos": (
        "warning",
        to_translate(
            "There is only {count} photo. Photograph each part of the rock four or five times:"
            " two or three views have no redundancy."
        ),
        to_translate(
            "There are only {count} photos. Photograph each part of the rock four or five times:"
            " two or three views have no redundancy."
        ),
    ),
    "damaged": (
        "warning",
        to_translate("These photos cannot be decoded and will be left out: {photos}. {reason}"),
    ),
    "duplicates": (
        "info",
        to_translate("These photos are copies of other files and are left out: {photos}."),
    ),
    "no-focal-length": (
        "info",
        to_translate(
            "The focal length of {count} photo is unknown. The alignment must estimate it, which"
            " needs varied view directions, including oblique photos."
        ),
        to_translate(
            "The focal length of {count} photos is unknown. The alignment must estimate it, which"
            " needs varied view directions, including oblique photos."
        ),
    ),
    "several-cameras": (
        "info",
        to_translate(
            "The photos were taken with {value} cameras or settings, each of which is calibrated"
            " separately: {cameras}."
        ),
    ),
    "survey.turned-photos": (
        "info",
        to_translate(
            "Some photos were rotated by a program. Use the camera's original files, so that all"
            " photos share one calibration."
        ),
    ),
    "blurred": (
        "warning",
        to_translate(
            "These photos are blurred by up to {value:.1f} pixels (sharpest quarter of the set:"
            " {sharp:.1f}): {photos}. Leave them out if other photos cover the same area."
        ),
    ),
    "soft": (
        "warning",
        to_translate(
            "All photos lack sharpness: edges are blurred by {value:.1f} pixels (median sigma),"
            " so the true resolution is only {factor:.0f} pixels."
        ),
    ),
    "digital-zoom": (
        "warning",
        to_translate(
            "These photos have a digital zoom of up to {value:.2g}: {photos}. The true pixel size"
            " on the rock is larger by this factor."
        ),
    ),
    "enlarged": (
        "warning",
        to_translate(
            "These photos were enlarged or stitched, which adds no detail: {photos}. Use the"
            " camera's original files."
        ),
    ),
    "exposure": (
        "warning",
        to_translate(
            "These photos are nearly black or mostly overexposed, so nothing can be matched in"
            " them: {photos}."
        ),
    ),
    "brightness-jump": (
        "warning",
        to_translate(
            "These photos are lighter or darker than the others by up to {stops:.1f} stops:"
            " {photos}. This impairs matching and will show in the texture."
        ),
    ),
    "light-changed": (
        "warning",
        to_translate(
            "The light changed by {value:.1f} stops, because of sun and shade or the time between"
            " photos. Moving shadows are matched as if they were rock."
        ),
    ),
    "long-survey": (
        "info",
        to_translate(
            "The photos were taken over {value:.0f} hours, during which shadows move. If you need"
            " several days, use the same time of day."
        ),
    ),
    "unmatched": (
        "warning",
        to_translate(
            "These photos match no other photo: {photos}. They overlap too little, are blurred, or"
            " show something else."
        ),
    ),
    "low-overlap": (
        "warning",
        to_translate(
            "These photos overlap their best neighbour by {overlap:.0f} % or less: {photos}. 60 %"
            " or more is required."
        ),
    ),
    "few-views": (
        "warning",
        to_translate(
            "Half of the rock is covered by {value:.0f} photos or fewer. Every part should be"
            " covered by four or five."
        ),
    ),
    "parts": (
        "warning",
        to_translate(
            "The photos form {value:.0f} disconnected components ({sizes} photos), which become"
            " separate models."
        ),
    ),
    "same-position": (
        "warning",
        to_translate(
            "These photos were taken from the same position as another, but with a different"
            " direction or zoom: {photos}. Take one photo from each position."
        ),
    ),
    "near-identical": (
        "info",
        to_translate(
            "Each of these photos is almost identical to another: {photos}. You can leave out one"
            " photo of each pair."
        ),
    ),
    "one-direction": (
        "warning",
        to_translate(
            "All photos look in the same direction (within {value:.2g}°), so the model may be"
            " bent like a dome. Add oblique photos and check points."
        ),
    ),
    "gsd-spread": (
        "warning",
        to_translate(
            "The ground sampling distances of the photos differ by a factor of {value:.0f}. Keep"
            " the factor below ten."
        ),
    ),
    "no-gps": (
        "info",
        to_translate(
            "The photos have no GPS positions. Scale and orientation need control points, a table"
            " of camera positions, or a measured length and direction."
        ),
    ),
    "gps-equal": (
        "warning",
        to_translate(
            "The GPS positions of all {value} photos are identical, so they cannot register a"
            " model. Use control points."
        ),
    ),
    "gps-few": (
        "info",
        to_translate(
            "Only {value} of {total} photos have a GPS position (latitude, longitude and"
            " altitude). Registration by GPS needs 3 or more."
        ),
    ),
    "collinear": (
        "warning",
        to_translate(
            "The camera positions are collinear, so the model can rotate about their line. Add"
            " control points, or photos from beside the line."
        ),
    ),
    "gps-noise": (
        "warning",
        to_translate(
            "The camera positions extend over {extent_m:,.0f} m with an accuracy of {sigma_m:.2g}"
            " m each, so the model may be rotated by {value:.0f}° (95 %). Use control points."
        ),
    ),
    "gps-registration": (
        "info",
        to_translate(
            "A model registered by the camera positions (accuracy {sigma_m:.2g} m) may be rotated"
            " by up to {value:.1f}° (95 %)."
        ),
    ),
    "focal-vague": (
        "warning",
        to_translate(
            "The focal length of these photos is missing from EXIF and poorly constrained:"
            " {photos}. Depths may be stretched, and dips wrong."
        ),
    ),
    "focal-wrong": (
        "info",
        to_translate(
            "The focal length in EXIF is wrong by {error_percent:+.0f} % for {photos}, which were"
            " zoomed, cropped or resized. The estimated value is used."
        ),
    ),
    "unregistered": (
        "warning",
        to_translate(
            "{value:.0f} of {total} photos could not be aligned: {photos}. They overlap too little"
            " with the others, or are blurred."
        ),
    ),
    "weak-photos": (
        "warning",
        to_translate(
            "These photos have fewer than {least} tie points, so their poses are uncertain:"
            " {photos}."
        ),
    ),
    "weak-poses": (
        "warning",
        to_translate(
            "These photos are weakly connected, so their positions and orientations are uncertain"
            " (up to {value:.1f}°, 95 %): {photos}. Take photos in between."
        ),
    ),
    "high-error": (
        "warning",
        to_translate(
            "The median reprojection error is {value:.1f} pixels: photos may be blurred, the scene"
            " may have moved, or the lens model may be wrong."
        ),
    ),
    "rotation": (
        "warning",
        to_translate(
            "The registration, and every direction on the model, may be wrong by {value:.1f}° (95"
            " %). Add control points that are not collinear."
        ),
    ),
    "control-unused": (
        "warning",
        to_translate("The control points were not used: {reason}"),
    ),
    "gps-unused": (
        "warning",
        to_translate("The GPS positions were not used: {reason}"),
    ),
    "mark-scatter": (
        "warning",
        to_translate(
            "Marks of the control points scatter by {value:.0f} px, which the stated errors"
            " include. Check the marks and the poses of the photos."
        ),
    ),
    "plan.unknown-camera": (
        "error",
        to_translate(
            "“{camera}” is not in the list of cameras (similar: {similar}). Specify a photo"
            " taken with it, or sensor, focal length and pixels (23.5x15.6,35,6000x4000)."
        ),
    ),
    "plan.not-a-camera": (
        "error",
        to_translate(
            "“{camera}” does not describe a camera. Specify sensor width x height in mm, focal"
            " length in mm, pixels, such as 23.5x15.6,35,6000x4000."
        ),
    ),
    "plan.photo-without-camera": (
        "error",
        to_translate(
            "The photo's metadata do not describe its camera. Specify sensor and focal length in"
            " mm, and pixels, such as 23.5x15.6,35,6000x4000."
        ),
    ),
    "plan.no-focal-length": (
        "error",
        to_translate("The {camera} has interchangeable lenses. Specify the focal length in mm."),
    ),
    "plan.fixed-aperture": (
        "warning",
        to_translate("The aperture of the {camera} is fixed, so f/{f_number:g} is used."),
    ),
    "plan.too-many-photos": (
        "error",
        to_translate(
            "This survey would take about {photos:,.0f} photos. Increase the distance, or plan"
            " only part of the outcrop."
        ),
    ),
    "plan.too-close": (
        "error",
        to_translate("The lens cannot focus at this distance. Increase it."),
    ),
    "plan.too-far": (
        "warning",
        to_translate(
            "At {distance:g} m a pixel covers {gsd:.3g} mm. For {wanted:.3g} mm, move to"
            " {closer:.3g} m."
        ),
    ),
    "plan.high-rows": (
        "warning",
        to_translate(
            "The upper rows are up to {height_m:.1f} m above the foot of the outcrop. Use a drone,"
            " a pole, or one row from {distance_m:.0f} m away."
        ),
    ),
    "plan.high-row": (
        "warning",
        to_translate(
            "The row is {height_m:.1f} m above the foot of the outcrop. Use a drone, because"
            " photos from below do not show the tops of ledges."
        ),
    ),
    "plan.narrow-strip": (
        "warning",
        to_translate(
            "The outcrop is a narrow strip, so its control points are nearly in line. Place more"
            " beside or in front of it, and photograph them."
        ),
    ),
    "plan.thin-border": (
        "warning",
        to_translate(
            "Some parts near the border are covered by only {count} photo. Add photos there."
        ),
        to_translate(
            "Some parts near the border are covered by only {count} photos. Add photos there."
        ),
    ),
    "plan.unregistrable": (
        "warning",
        to_translate("The model cannot be registered by camera positions alone."),
    ),
    "plan.rotation": (
        "warning",
        to_translate(
            "Registered by camera positions alone, accurate to {sigma_m:.2g} m, the model may be"
            " rotated by {rotation95_deg:.2g}° (95 %)."
        ),
    ),
    "plan.rotation-by-control": (
        "info",
        to_translate(
            "Registered by the planned control points, accurate to {sigma_m:.2g} m, the model"
            " may be rotated by {rotation95_deg:.2g}° (95 %)."
        ),
    ),
    "plan.nearly-in-line": (
        "warning",
        to_translate(
            "The camera positions are nearly in line. Take a second set of photos from farther"
            " away or higher, with more than 60 % overlap."
        ),
    ),
    "plan.measure-on-site": (
        "info",
        to_translate(
            "Without control points, hold the camera level, and measure one azimuth, one dip and"
            " one length on the outcrop."
        ),
    ),
    "survey.sound": (
        "info",
        to_translate("These photos should give a reliable model."),
    ),
    "survey.reservations": (
        "warning",
        to_translate("These photos can give a model, with limitations: {reasons}."),
    ),
    "survey.incomplete": (
        "error",
        to_translate("These photos will not give a complete model: {reasons}."),
    ),
    "survey.pixel-size": (
        "info",
        to_translate("One pixel covers {pixel}."),
    ),
    "survey.pixel-size-unknown": (
        "info",
        to_translate("The pixel size is unknown, because focal length and distance are unknown."),
    ),
    "survey.pixel-size-at-distance": (
        "info",
        to_translate("At {distance_m:g} m from the rock one pixel would cover {pixel}."),
    ),
    "survey.model-resolution": (
        "info",
        to_translate("The resolution of the model is {size}."),
    ),
    "survey.planes-by-photos": (
        "info",
        to_translate(
            "Planes {size} across should be accurate to {error_deg:.1f}°, and those"
            " {textbook_size} across (the textbook's limit of 1000 pixels) to"
            " {textbook_error_deg:.1f}° (95 %)."
        ),
    ),
    "survey.planes-by-model": (
        "info",
        to_translate(
            "Planes {size} across should be accurate to {error_deg:.1f}°, and those"
            " {textbook_size} across (100 times the resolution) to {textbook_error_deg:.1f}° (95"
            " %)."
        ),
    ),
    "survey.no-planes": (
        "warning",
        to_translate(
            "No plane can be measured to within {wanted_deg:g}°, because the registration may be"
            " wrong by {registration_deg:.1f}° (95 %)."
        ),
    ),
    "video.not-good-enough": (
        "error",
        to_translate(
            "This video is not suitable for a reconstruction. {reasons} Take photos instead, or"
            " record it again, moving slowly and smoothly without stopping."
        ),
    ),
    "video.frames-kept": (
        "info",
        *to_translate_n(
            "{count} frame of {width} × {height} pixels extracted from {seconds:.0f} s.",
            "{count} frames of {width} × {height} pixels extracted from {seconds:.0f} s.",
        ),
    ),
    "video.frames-left-out": (
        "info",
        *to_translate_n(
            "{count} frame left out: {reason}",
            "{count} frames left out: {reason}",
        ),
    ),
    "video.folder-not-empty": (
        "warning",
        to_translate("{folder} contains other files. Write the frames into this folder?"),
    ),
    "video.usable": (
        "info",
        *to_translate_n(
            "{count} frame is usable. It has no position: scale and orientation need control"
            " points or a measured length.",
            "{count} frames are usable. They have no positions: scale and orientation need"
            " control points or a measured length.",
        ),
    ),
    "video.not-a-video": (
        "error",
        to_translate("This file is not a readable video. Export it as MP4, or take photos."),
    ),
    "video.no-frames": (
        "error",
        to_translate("The video has no usable frames. Frames left out: {reasons}."),
    ),
    "video.cut-short": (
        "warning",
        to_translate(
            "The video ends after {frames} of its {total} frames, so it is damaged or incomplete."
        ),
    ),
    "video.few-frames": (
        "error",
        to_translate("Only {count} frame is sharp and distinct, but {least} are required."),
        to_translate("Only {count} frames are sharp and distinct, but {least} are required."),
    ),
    "video.blurred": (
        "warning",
        to_translate("{share_percent:.0f} % of the video is blurred. Move more slowly."),
    ),
    "video.too-fast": (
        "error",
        to_translate(
            "The camera moved too fast {moments} times, so consecutive frames do not overlap"
            " enough."
        ),
    ),
    "video.small": (
        "warning",
        to_translate(
            "The frames have only {width} x {height} pixels. Photos show much more detail."
        ),
    ),
    "video.still": (
        "warning",
        to_translate("The camera stood still for much of the video. Keep moving."),
    ),
    "video.unusual-rate": (
        "warning",
        to_translate("{fps:g} frames per second are unusual. Use 1 to 4."),
    ),
    "plan.no-camera": (
        "error",
        to_translate("Choose a camera, or a photo taken with it."),
    ),
}
