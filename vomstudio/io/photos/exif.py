"""EXIF metadata of a photo as plain numbers, with findings about invalid values.

Tags and units follow the Exif standard, CIPA DC-008 (version 3.0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import TYPE_CHECKING, Any

from vomstudio.core.findings import Finding
from vomstudio.io.photos.apple_maker_note import Vector, acceleration
from vomstudio.io.photos.photo import PhotoTags
from vomstudio.io.photos.user_comment import comment_text

if TYPE_CHECKING:
    from PIL import Image

_EXIF_IFD, _GPS_IFD = 0x8769, 0x8825
# Length of FocalPlaneResolutionUnit in millimetres.
_UNITS_MM = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}


@dataclass(frozen=True)
class Exif(PhotoTags):
    """EXIF tags, with None for missing or invalid tags.

    Attributes
    ----------
    focal_plane_px_per_mm : float or None
        Resolution of the sensor along the width of the photo as taken.
    pixels : tuple of int or None
        Width and height as taken, before other programs changed them.
    acceleration : tuple of float or None
        Acceleration of an Apple phone along its own axes, in units of g.
    comment : str or None
        Text of `UserComment`.
    problems : tuple of Finding
        Dropped tags with the reasons.
    """

    make: str | None = None
    model: str | None = None
    focal_plane_px_per_mm: float | None = None
    pixels: tuple[int, int] | None = None
    acceleration: Vector | None = None
    comment: str | None = None
    problems: tuple[Finding, ...] = field(default=())


def read_exif(image: Image.Image) -> Exif:
    """Read the EXIF metadata of an image. Never raises: unreadable values become findings."""
    import warnings

    if image.format == "PNG" and not {"exif", "Raw profile type exif"} & image.info.keys():
        # Pillow would decode the whole image to search for EXIF metadata after it.
        return Exif()
    problems: list[Finding] = []
    groups: list[Mapping[int, Any]] = [{}, {}, {}]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            exif = image.getexif()
            groups[0] = dict(exif)
            groups[1] = dict(exif.get_ifd(_EXIF_IFD))
            groups[2] = dict(exif.get_ifd(_GPS_IFD))
        except Exception as error:  # noqa: BLE001 - Pillow's parser raises whatever it meets
            problems.append(Finding("photo.exif-damaged", reason=type(error).__name__))
    return exif_from_tags(groups[0], groups[1], groups[2], problems)


def exif_from_tags(
    main_tags: Mapping[int, Any],
    exif: Mapping[int, Any],
    gps_tags: Mapping[int, Any],
    problems: list[Finding] | None = None,
) -> Exif:
    """Return the EXIF metadata from the values of the three directories by tag number."""
    problems = [] if problems is None else problems
    tags = {**main_tags, **exif}
    orientation = _whole_number(tags.get(0x0112))
    if orientation not in range(1, 9):
        # 0 and a missing tag mean that the photo is shown as stored.
        if orientation not in (None, 0):
            problems.append(Finding("photo.unknown-orientation", tag=orientation))
        orientation = 1
    latitude, longitude = _position(gps_tags, problems)
    altitude, reference = _altitude(gps_tags) if latitude is not None else (None, None)
    zoom = _positive_number(tags.get(0xA404))
    return Exif(
        make=_text(tags.get(0x010F)),
        model=_text(tags.get(0x0110)),
        serial=_text(tags.get(0xA431)),
        lens=_text(tags.get(0xA434)),
        focal_mm=_positive_number(tags.get(0x920A)),
        focal_35mm=_positive_number(tags.get(0xA405)),
        focal_plane_px_per_mm=_focal_plane(tags),
        pixels=_pixels(tags),
        orientation=orientation or 1,
        taken_at=_date(tags),
        exposure_s=_positive_number(tags.get(0x829A)) or _power(tags.get(0x9201), -1.0),
        f_number=_positive_number(tags.get(0x829D)) or _aperture(tags),
        iso=_positive_number(_first_value(tags.get(0x8827))),
        digital_zoom=zoom,
        latitude_deg=latitude,
        longitude_deg=longitude,
        altitude_m=altitude,
        altitude_reference=reference,
        gps_accuracy_m=_positive_number(gps_tags.get(0x1F)),
        direction_deg=_direction(gps_tags, problems),
        direction_north={"T": "true", "M": "magnetic"}.get(
            (_text(gps_tags.get(0x10)) or "").upper()
        ),
        acceleration=acceleration(tags.get(0x927C)),
        comment=comment_text(tags.get(0x9286)),
        problems=tuple(problems),
    )


def _position(
    gps_tags: Mapping[int, Any], problems: list[Finding]
) -> tuple[float | None, float | None]:
    if 2 not in gps_tags and 4 not in gps_tags:
        return None, None
    status = _text(gps_tags.get(9))
    if status == "V":
        problems.append(Finding("photo.position-without-fix"))
        return None, None
    north, east = (_text(gps_tags.get(tag)) or "" for tag in (1, 3))
    latitude, longitude = _parse_sexagesimal(gps_tags.get(2)), _parse_sexagesimal(gps_tags.get(4))
    if latitude is None or longitude is None:
        problems.append(
            Finding("photo.position-invalid", position=f"{gps_tags.get(2)}, {gps_tags.get(4)}"[:60])
        )
    elif north[:1].upper() not in ("N", "S") or east[:1].upper() not in ("E", "W"):
        problems.append(
            Finding(
                "photo.position-invalid", position=f"{latitude:g} {north}, {longitude:g} {east}"
            )
        )
    elif abs(latitude) > 90 or abs(longitude) > 180:
        problems.append(Finding("photo.position-invalid", position=f"{latitude:g}, {longitude:g}"))
    elif latitude == 0 and longitude == 0:
        problems.append(Finding("photo.position-without-fix"))
    else:
        return (
            -latitude if north[:1].upper() == "S" else latitude,
            -longitude if east[:1].upper() == "W" else longitude,
        )
    return None, None


def _altitude(gps_tags: Mapping[int, Any]) -> tuple[float | None, str | None]:
    value = _number(gps_tags.get(6))
    if value is None:
        return None, None
    raw_reference = gps_tags.get(5, 0)
    code = (
        raw_reference[0]
        if isinstance(raw_reference, bytes) and raw_reference
        else _whole_number(raw_reference)
    )
    # 2 and 3 were introduced with Exif 3.0.
    is_below_sea_level = code in (1, 3)
    reference = (
        "ellipsoid" if code in (2, 3) else "below sea level" if is_below_sea_level else "sea level"
    )
    return (-value if is_below_sea_level else value), reference


def _direction(gps_tags: Mapping[int, Any], problems: list[Finding]) -> float | None:
    value = _number(gps_tags.get(0x11))
    if value is None:
        return None
    if not 0 <= value <= 360:
        problems.append(Finding("photo.direction-invalid", value=value))
        return None
    return value % 360.0


def _parse_sexagesimal(value: Any) -> float | None:
    parts = [_number(part) for part in _sequence(value)[:3]]
    if not parts or parts[0] is None or parts[0] < 0:
        return None
    # Some phones write decimal minutes and set the seconds to 0/0.
    minutes, seconds = ([part or 0.0 for part in parts[1:]] + [0.0, 0.0])[:2]
    return float(parts[0] + minutes / 60.0 + seconds / 3600.0)


def _focal_plane(tags: Mapping[int, Any]) -> float | None:
    pixels_per_unit = _positive_number(tags.get(0xA20E))
    unit = _UNITS_MM.get(_whole_number(tags.get(0xA210)) or 2)
    return pixels_per_unit / unit if pixels_per_unit and unit else None


def _pixels(tags: Mapping[int, Any]) -> tuple[int, int] | None:
    width, height = (_whole_number(tags.get(tag)) for tag in (0xA002, 0xA003))
    return (width, height) if width and height and width > 0 and height > 0 else None


def _date(tags: Mapping[int, Any]) -> datetime | None:
    for tag in (0x9003, 0x9004, 0x0132):
        text = _text(tags.get(tag)) or ""
        try:
            date = datetime.strptime(text[:19].replace("-", ":"), "%Y:%m:%d %H:%M:%S")
        except ValueError:
            continue
        subseconds = _text(tags.get(0x9291)) if tag == 0x9003 else None
        if subseconds and subseconds.isdigit():
            date = date.replace(microsecond=int(float(f"0.{subseconds}") * 1e6))
        return date
    return None


def _aperture(tags: Mapping[int, Any]) -> float | None:
    # For a lens without contacts, f/0 is reported; the APEX value is then invalid.
    return None if 0x829D in tags else _power(tags.get(0x9202), 0.5)


def _power(value: Any, factor: float) -> float | None:
    """Return the power of two that an APEX value denotes, or None if it is not valid."""
    number = _number(value)
    return 2.0 ** (factor * number) if number is not None and abs(number) < 64 else None


def _number(value: Any) -> float | None:
    try:
        number = float(_first_value(value))
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return number if math.isfinite(number) else None


def _positive_number(value: Any) -> float | None:
    number = _number(value)
    return number if number is not None and 0 < number < 1e9 else None


def _whole_number(value: Any) -> int | None:
    number = _number(value)
    return int(number) if number is not None and abs(number) < 2**31 else None


def _sequence(value: Any) -> list[Any]:
    return list(value) if isinstance(value, tuple | list) else [] if value is None else [value]


def _first_value(value: Any) -> Any:
    items = _sequence(value)
    return items[0] if items else None


def _text(value: Any) -> str | None:
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if not isinstance(value, str):
        return None
    text = " ".join(
        "".join(
            character if character.isprintable() else " " for character in value.split("\0")[0]
        ).split()
    )
    return text or None
