"""Texts of the findings about alignments: features, matches, lenses and components."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "alignment.too-few-photos": (
        "error",
        to_translate(
            "Fewer than two photos are usable. A model needs at least two overlapping photos,"
            " preferably ten. {reasons}"
        ),
    ),
    "alignment.no-base": (
        "error",
        to_translate(
            "The photos match, but were all taken from one position. Change position between"
            " photos, with 60 % overlap, instead of turning on the spot."
        ),
    ),
    "alignment.shared-photos": (
        "info",
        to_translate(
            "{count} photo is in several components and was assigned to the largest of them:"
            " {photos}."
        ),
        to_translate(
            "{count} photos are in several components and were assigned to the largest of them:"
            " {photos}."
        ),
    ),
    "alignment.photo-unmatched": (
        "warning",
        to_translate(
            "The photo matches no other photo (at most {matches} matches of {features} features)."
        ),
    ),
    "alignment.photo-not-placed": (
        "warning",
        to_translate(
            "The pose could not be computed: the photo has {matches} matches with another photo,"
            " but too few with the model. Add photos that overlap the model."
        ),
    ),
    "alignment.photo-unreadable": (
        "warning",
        to_translate("The photo cannot be read: {reason}."),
    ),
    "alignment.photo-without-features": (
        "warning",
        to_translate("The photo has no distinct features."),
    ),
    "alignment.photo-masked": (
        "warning",
        to_translate("The mask covers the whole photo."),
    ),
    "alignment.photo-too-large": (
        "warning",
        to_translate("The photo is too large for this computer's memory."),
    ),
    "alignment.photo-left-out": (
        "warning",
        to_translate("{photo} is not aligned. {reason}"),
    ),
    "alignment.newer-version": (
        "error",
        to_translate("This alignment was written by a newer version. Update VOM Studio."),
    ),
    "alignment.damaged": (
        "error",
        to_translate("The alignment is incomplete or damaged ({reason}). Align the photos again."),
    ),
    "alignment.global-mapping": (
        "info",
        to_translate("All poses were computed at once (global mapping)."),
    ),
    "alignment.exif-focal-dropped": (
        "info",
        to_translate(
            "With the EXIF focal length, only {aligned} photos could be aligned; without it,"
            " {aligned_without}."
        ),
    ),
    "alignment.no-matches": (
        "error",
        to_translate("The photos have not been matched. Align them first."),
    ),
    "alignment.matches-unreadable": (
        "error",
        to_translate("The matches cannot be read ({reason}). Align the photos again."),
    ),
    "alignment.matched-all": (
        "info",
        to_translate("All photos were matched with each other ({count} pair)."),
        to_translate("All photos were matched with each other ({count} pairs)."),
    ),
    "alignment.matched-in-sequence": (
        "info",
        to_translate(
            "Each frame was matched with the next {neighbours} frames and some later ones"
            " ({pairs} of {total} pairs)."
        ),
    ),
    "alignment.matched-by-gps": (
        "info",
        to_translate(
            "Each photo was matched with its {neighbours} nearest neighbours by GPS and with the"
            " next photos by name ({pairs} of {total} pairs)."
        ),
    ),
    "alignment.matched-by-likeness": (
        "info",
        to_translate(
            "Each photo was matched with the {neighbours} most similar photos and with the next"
            " photos by name ({pairs} of {total} pairs)."
        ),
    ),
    "alignment.separate-component": (
        "warning",
        to_translate("Photos of a disconnected component are not part of the model: {photos}."),
    ),
    "lens.focal-length": (
        "info",
        to_translate("Focal length of {count} photo: {value}."),
        to_translate("Focal length of {count} photos: {value}."),
    ),
    "lens.focal-estimated": (
        "info",
        to_translate(
            "The focal length is estimated. The view directions vary by {spread_deg:.1f}°."
        ),
    ),
    "lens.focal-estimated-without-exif": (
        "info",
        to_translate(
            "The focal length is missing in EXIF and was estimated. The view directions vary by"
            " {spread_deg:.1f}°."
        ),
    ),
    "lens.focal-weak": (
        "warning",
        to_translate(
            "The focal length was estimated without an EXIF value. View directions vary by only"
            " {spread_deg:.1f}°, so depths may be wrong by 10 % or more."
        ),
    ),
    "lens.focal-assumed": (
        "warning",
        to_translate(
            "A typical focal length was assumed ({focal_mm:.0f} mm, 35 mm equivalent), because"
            " neither EXIF nor the photos determine it. Depths may be wrong."
        ),
    ),
    "lens.focal-held-one-direction": (
        "info",
        to_translate(
            "The focal length is fixed at the EXIF value: it correlates with distance, because view"
            " directions vary by only {spread_deg:.1f}° ({least_deg:.0f}° required)."
        ),
    ),
    "lens.focal-held-few-photos": (
        "info",
        to_translate(
            "The focal length is fixed at the EXIF value: there is only {count} photo from this"
            " camera ({least} required)."
        ),
        to_translate(
            "The focal length is fixed at the EXIF value: there are only {count} photos from this"
            " camera ({least} required)."
        ),
    ),
    "lens.focal-held-uncertain": (
        "info",
        to_translate(
            "The focal length is fixed at the EXIF value: its estimate would have an error of"
            " {error_percent:.1f} %."
        ),
    ),
    "lens.exif-unusable": (
        "info",
        to_translate(
            "The focal length was estimated, because the photos could not be aligned with the"
            " EXIF value."
        ),
    ),
    "lens.exif-contradicted": (
        "info",
        to_translate(
            "The focal length was estimated: the EXIF value is wrong by {off_percent:+.0f} %"
            " (cross-validated reprojection error {before_px:.3f} px with it, {after_px:.3f} px"
            " without it)."
        ),
    ),
    "lens.undetermined": (
        "info",
        to_translate(
            "The lens parameters k2, cx and cy are fixed, because the observations do not"
            " determine them."
        ),
    ),
    "lens.held-by-validation": (
        "info",
        to_translate(
            "The lens parameters k2, cx and cy are fixed: estimating them would give a"
            " cross-validated reprojection error of {after_px:.3f} px instead of {before_px:.3f}"
            " px."
        ),
    ),
    "lens.distortion-estimated": (
        "info",
        to_translate(
            "The distortion k2 was estimated: its effect in the corner is {effect_px:.2f} px,"
            " {times:.1f} times its error."
        ),
    ),
    "lens.distortion-held": (
        "info",
        to_translate(
            "The distortion k2 is fixed: its effect in the corner would be {effect_px:.2f} px,"
            " {times:.1f} times its error ({least_px} px and {least_times:.0f} times required)."
        ),
    ),
    "lens.centre-estimated": (
        "info",
        to_translate(
            "The principal point was estimated ({x_px:+.1f}, {y_px:+.1f} px from the centre, ±"
            " {sigma_px:.1f} px): its effect in the corner is {effect_px:.2f} px."
        ),
    ),
    "lens.centre-held-small": (
        "info",
        to_translate(
            "The principal point is fixed: its estimate ({x_px:+.1f}, {y_px:+.1f} px from the"
            " centre) changes the corners by only {effect_px:.2f} px ({least_px} px required)."
        ),
    ),
    "lens.centre-held-far": (
        "info",
        to_translate(
            "The principal point is fixed: its estimate ({x_px:+.1f}, {y_px:+.1f} px from the"
            " centre, ± {sigma_px:.1f} px) is implausible for a camera."
        ),
    ),
    "lens.centre-held-uncertain": (
        "info",
        to_translate(
            "The principal point is fixed: its estimate ({x_px:+.1f}, {y_px:+.1f} px from the"
            " centre) has an error of {sigma_px:.1f} px (maximum {least_px:.1f} px)."
        ),
    ),
    "lens.several-lenses": (
        "info",
        to_translate(
            "Photos of one size without EXIF come from {lenses} lenses or zoom settings"
            " ({groups}). The mean reprojection error is {after_px:.2f} px instead of"
            " {before_px:.2f} px."
        ),
    ),
    "lens.ground-estimated": (
        "info",
        to_translate(
            "Focal length of {count} photo: {focal_px:.0f} ± {sigma_px:.0f} px"
            " ({change_percent:+.1f} %), estimated with ground control, which constrains it to"
            " {ground_percent:.2f} % ({required_percent:.1f} % required)."
        ),
        to_translate(
            "Focal length of {count} photos: {focal_px:.0f} ± {sigma_px:.0f} px"
            " ({change_percent:+.1f} %), estimated with ground control, which constrains it to"
            " {ground_percent:.2f} % ({required_percent:.1f} % required)."
        ),
    ),
    "lens.ground-held": (
        "info",
        to_translate(
            "Focal length of {count} photo: fixed at {focal_px:.0f} px, because ground control"
            " does not constrain it to {required_percent:.1f} %."
        ),
        to_translate(
            "Focal length of {count} photos: fixed at {focal_px:.0f} px, because ground control"
            " does not constrain it to {required_percent:.1f} %."
        ),
    ),
    "join.by-markers": (
        "info",
        to_translate(
            "Components of {one} and {other} photos were joined by {markers} markers with a"
            " residual of {rms_px:.1f} px (RMS). Their relative rotation is uncertain by"
            " {rotation_deg:.2f}°."
        ),
    ),
    "join.by-control": (
        "info",
        to_translate("Components of {one} and {other} photos were joined by their control points."),
    ),
    "join.few-markers": (
        "warning",
        to_translate(
            "A component of {size} photos is not joined: only {common} of {least} required markers"
            " are in both components. Mark more, far apart, in two photos of each component."
        ),
    ),
    "join.begun-markers": (
        "info",
        to_translate("Component {component} needs more marks of these markers: {markers}."),
    ),
    "join.collinear": (
        "error",
        to_translate(
            "The markers of both components lie on one line, so one component can rotate about"
            " it. Mark a point off this line."
        ),
    ),
    "join.contradicted": (
        "error",
        to_translate(
            "The {markers} common markers contradict the tie points ({after_px:.1f} px instead of"
            " {before_px:.1f} px). Check the marks of {marker}, whose residual is"
            " {residual_px:.0f} px."
        ),
    ),
    "join.rotation": (
        "warning",
        to_translate(
            "The rotation between the components is uncertain by about {rotation_deg:.1f}°. Place"
            " the markers farther apart."
        ),
    ),
    "join.not-joined": (
        "warning",
        to_translate("The component with {photos} was not joined. {reason}"),
    ),
}
