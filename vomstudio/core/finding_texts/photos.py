"""Texts of the findings about photos and cameras."""

from __future__ import annotations

from vomstudio.core.finding_texts.entry import Entry
from vomstudio.words import to_translate

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
}
