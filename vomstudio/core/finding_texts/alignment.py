"""Texts of the findings about alignments: features, matches, lenses and components."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.core.words import to_translate

TEXTS: dict[str, Entry] = {
    "alignment.too-few-photos": (
        "error",
        to_translate(
            "Fewer than two photos can be used. A model needs two or more that overlap, preferably"
            " ten. {reasons}"
        ),
    ),
    "alignment.no-base": (
        "error",
        to_translate(
            "The photos match, but no pair of them has a base. Move between photos instead of"
            " turning on the spot, with 60 % overlap."
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
            "It matches no other photo (at most {matches} matches of {features} features)."
        ),
    ),
    "alignment.photo-not-placed": (
        "warning",
        to_translate(
            "Its pose could not be computed: it has {matches} matches with another photo, but too"
            " few with the model."
        ),
    ),
    "alignment.photo-unreadable": (
        "warning",
        to_translate("It cannot be read: {reason}."),
    ),
    "alignment.photo-without-features": (
        "warning",
        to_translate("It has no features that could be found in another photo."),
    ),
    "alignment.photo-masked": (
        "warning",
        to_translate("Its mask hides all of it."),
    ),
    "alignment.photo-too-large": (
        "warning",
        to_translate("It is too large for the memory of this computer."),
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
            "With the focal length from EXIF only {aligned} photos could be aligned, without it"
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
            "Each frame was matched with the next {neighbours} and with some later ones ({pairs} of"
            " {total} pairs)."
        ),
    ),
    "alignment.matched-by-gps": (
        "info",
        to_translate(
            "Each photo was matched with its {neighbours} nearest by GPS and with the next ones by"
            " name ({pairs} of {total} pairs)."
        ),
    ),
    "alignment.matched-by-likeness": (
        "info",
        to_translate(
            "Each photo was matched with the {neighbours} most similar and with the next ones by"
            " name ({pairs} of {total} pairs)."
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
            "The focal length is estimated. The view directions spread by {spread_deg:.1f}°."
        ),
    ),
    "lens.focal-estimated-without-exif": (
        "info",
        to_translate(
            "The focal length is estimated, since EXIF does not state it. The view directions"
            " spread by {spread_deg:.1f}°."
        ),
    ),
    "lens.focal-weak": (
        "warning",
        to_translate(
            "The focal length is estimated without EXIF value, from view directions that spread by"
            " only {spread_deg:.1f}°. Depths can be wrong by 10 % or more."
        ),
    ),
    "lens.focal-assumed": (
        "warning",
        to_translate(
            "The focal length of a usual lens is assumed ({focal_mm:.0f} mm, 35 mm equivalent):"
            " neither EXIF nor the photos give it. Depths can be wrong."
        ),
    ),
    "lens.focal-held-one-direction": (
        "info",
        to_translate(
            "The focal length is held at the EXIF value, since it is highly correlated with the"
            " distance: the view directions spread by {spread_deg:.1f}° ({least_deg:.0f}° needed)."
        ),
    ),
    "lens.focal-held-few-photos": (
        "info",
        to_translate(
            "The focal length is held at the EXIF value, since there is only {count} photo of this"
            " camera ({least} required)."
        ),
        to_translate(
            "The focal length is held at the EXIF value, since there are only {count} photos of"
            " this camera ({least} required)."
        ),
    ),
    "lens.focal-held-uncertain": (
        "info",
        to_translate(
            "The focal length is held at the EXIF value, since its error would be"
            " {error_percent:.1f} % if it were estimated."
        ),
    ),
    "lens.exif-unusable": (
        "info",
        to_translate(
            "The focal length is estimated, since photos could not be aligned with the EXIF value."
        ),
    ),
    "lens.exif-contradicted": (
        "info",
        to_translate(
            "The focal length is estimated: the EXIF value is off by {off_percent:+.0f} %"
            " (reprojection error in cross-validation {before_px:.3f} px with it, {after_px:.3f} px"
            " without it)."
        ),
    ),
    "lens.undetermined": (
        "info",
        to_translate(
            "The lens parameters k2, cx and cy are held, since the observations do not determine"
            " them."
        ),
    ),
    "lens.held-by-validation": (
        "info",
        to_translate(
            "The lens parameters k2, cx and cy are held: with them free, the reprojection error in"
            " cross-validation is {after_px:.3f} px instead of {before_px:.3f} px."
        ),
    ),
    "lens.distortion-estimated": (
        "info",
        to_translate(
            "The distortion k2 is estimated: its effect in the corner is {effect_px:.2f} px,"
            " {times:.1f} times its error."
        ),
    ),
    "lens.distortion-held": (
        "info",
        to_translate(
            "The distortion k2 is held: its effect in the corner would be {effect_px:.2f} px,"
            " {times:.1f} times its error ({least_px} px and {least_times:.0f} times required)."
        ),
    ),
    "lens.centre-estimated": (
        "info",
        to_translate(
            "The principal point is estimated ({x_px:+.1f}, {y_px:+.1f} px from the centre, ±"
            " {sigma_px:.1f} px): its effect in the corner is {effect_px:.2f} px."
        ),
    ),
    "lens.centre-held-small": (
        "info",
        to_translate(
            "The principal point is held: estimated ({x_px:+.1f}, {y_px:+.1f} px from the centre),"
            " its effect in the corner would be only {effect_px:.2f} px ({least_px} px required)."
        ),
    ),
    "lens.centre-held-far": (
        "info",
        to_translate(
            "The principal point is held: its estimate ({x_px:+.1f}, {y_px:+.1f} px from the"
            " centre, ± {sigma_px:.1f} px) is farther off than in any good camera."
        ),
    ),
    "lens.centre-held-uncertain": (
        "info",
        to_translate(
            "The principal point is held: its estimate ({x_px:+.1f}, {y_px:+.1f} px from the"
            " centre) has an error of {sigma_px:.1f} px (at most {least_px:.1f} px allowed)."
        ),
    ),
    "lens.several-lenses": (
        "info",
        to_translate(
            "Photos of one size without EXIF were taken with {lenses} lenses or zoom settings"
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
            "Focal length of {count} photo: held at {focal_px:.0f} px, since ground control does"
            " not constrain it to {required_percent:.1f} %."
        ),
        to_translate(
            "Focal length of {count} photos: held at {focal_px:.0f} px, since ground control does"
            " not constrain it to {required_percent:.1f} %."
        ),
    ),
    "join.by-markers": (
        "info",
        to_translate(
            "Components of {one} and {other} photos were joined by {markers} markers with a"
            " residual of {rms_px:.1f} px (rms). Their rotation is uncertain by"
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
            "A component of {size} photos is not joined: {common} of {least} markers are in both."
            " Mark more, not in one line, in two photos of each."
        ),
    ),
    "join.begun-markers": (
        "info",
        to_translate("Component {component} needs more marks of these markers: {markers}."),
    ),
    "join.collinear": (
        "error",
        to_translate(
            "The markers of both components lie on one line, about which one component can rotate."
            " Set a marker beside this line."
        ),
    ),
    "join.contradicted": (
        "error",
        to_translate(
            "The {markers} common markers contradict the tie points ({after_px:.1f} px instead of"
            " {before_px:.1f} px). Check the marks of {marker}, which has a residual of"
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
