"""XMP packets of drone photos: direction of the camera and accuracy of its position.

The conventions of all vendors are converted to a single one: yaw clockwise from north, pitch of the
optical axis above the horizon (-90 is straight down), roll about the axis.

- DJI and Autel (`GimbalYawDegree` and similar tags): the same.
- Parrot (`CameraYawDegree` and similar tags): the same (Parrot's "Embedded Photo Metadata").
- Skydio (`CameraOrientationNED`: Yaw, Pitch, Roll): the same.
- Pix4D's `Camera` tags (senseFly, Parrot Sequoia, XAG and others): attitude of the aircraft, from
  which the camera points straight down; its roll tilts the view sideways.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from vomstudio.core.errors import InputError
from vomstudio.geology.view_attitudes import nadir_to_view_angles
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.text.xml_tree import Element, parse_xml

MAX_PACKET_BYTES = 4 << 20
_PIX4D = "pix4d.com/camera"
Angles = tuple[float | None, float | None, float | None]


@dataclass(frozen=True)
class DroneTags:
    """Tags that a drone writes in addition to EXIF; None if missing.

    Attributes
    ----------
    has_zero_angles : bool
        Whether yaw, pitch and roll are exactly 0 as written.
    absolute_altitude_m : float or None
        Signed altitude above the reference stated in EXIF.
    relative_altitude_m : float or None
        Height above the take-off position.
    accuracy_m : float or None
        Horizontal standard deviation of the camera position, as stated by the receiver.
    is_ellipsoidal : bool
        Whether heights refer to the ellipsoid.
    focal_px : float or None
        Focal length from the vendor's calibration.
    """

    yaw_deg: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None
    has_zero_angles: bool = False
    absolute_altitude_m: float | None = None
    relative_altitude_m: float | None = None
    accuracy_m: float | None = None
    is_ellipsoidal: bool = False
    focal_px: float | None = None
    is_panorama: bool = False


def read_drone_tags(packet: bytes | str | None) -> DroneTags:
    """Read the tags of an XMP packet; damaged values are ignored."""
    tags = flatten_packet(packet)
    if not tags:
        return DroneTags()
    (yaw, pitch, roll), has_zero_angles = _angles(tags)
    standard_deviations = [_number(tags, name) for name in ("RtkStdLon", "RtkStdLat")]
    valid_standard_deviations = [
        value for value in standard_deviations if value is not None and value > 0
    ]
    accuracy = (
        math.hypot(*valid_standard_deviations) if len(valid_standard_deviations) == 2 else None
    )
    for name in ("GPSXYAccuracy", "GpsHorizontalAccuracy", "GPSHPositioningError"):
        value = _number(tags, name)
        if accuracy is None and value is not None and value > 0:
            accuracy = value
    focal = _number(tags, "CalibratedFocalLength", "CalibratedFocalLength/X")
    return DroneTags(
        yaw_deg=yaw,
        pitch_deg=pitch,
        roll_deg=roll,
        has_zero_angles=has_zero_angles,
        absolute_altitude_m=_number(tags, "AbsoluteAltitude"),
        relative_altitude_m=_number(tags, "RelativeAltitude"),
        accuracy_m=accuracy,
        is_ellipsoidal=tags.get("AltitudeType", "").casefold().startswith("rtk"),
        focal_px=focal if focal is not None and focal > 0 else None,
        is_panorama="ProjectionType" in tags or tags.get("UsePanoramaViewer", "").lower() == "true",
    )


def flatten_packet(packet: bytes | str | None) -> dict[str, str]:
    """Return the properties of a packet by their local names.

    Properties inside structures are named `Struct/Member`.

    Pix4D's properties are prefixed with `Camera:` because other vendors use the same names
    differently.
    """
    if not packet:
        return {}
    data = packet if isinstance(packet, bytes) else packet.encode("utf-8", "replace")
    packet_xml = _text_between(data, b"<x:xmpmeta", b"</x:xmpmeta>") or _text_between(
        data, b"<rdf:RDF", b"</rdf:RDF>"
    )
    if not packet_xml or len(packet_xml) > MAX_PACKET_BYTES:
        return {}
    try:
        root = parse_xml(packet_xml)
    except InputError:
        return {}
    tags: dict[str, str] = {}
    for description in root.iter("{http://www.w3.org/1999/02/22-rdf-syntax-ns#}Description"):
        _collect_tags(description, "", tags)
    return tags


def _text_between(data: bytes, start: bytes, end: bytes) -> bytes:
    """Return the part from the first `start` to the next `end`, in one pass."""
    start_position = data.find(start)
    end_position = data.find(end, start_position) if start_position >= 0 else -1
    return data[start_position : end_position + len(end)] if end_position >= 0 else b""


def _collect_tags(element: Element, prefix: str, tags: dict[str, str]) -> None:
    for key, value in element.items():
        tags.setdefault(prefix + _name(key), value.strip())
    for child in element:
        name = prefix + _name(child.tag)
        if child.text and child.text.strip():
            tags.setdefault(name, child.text.strip())
        if name.count("/") < 4:
            child_prefix = (
                prefix if name.endswith(("Description", "Seq", "Bag", "li")) else name + "/"
            )
            _collect_tags(child, child_prefix, tags)


def _name(key: str) -> str:
    namespace, _, local_name = key.rpartition("}")
    return f"Camera:{local_name}" if _PIX4D in namespace.casefold() else local_name


def _angles(tags: Mapping[str, str]) -> tuple[Angles, bool]:
    """Return yaw, pitch and roll, and whether all are exactly 0 as written."""
    for pattern in (
        "Gimbal{}Degree",
        "Camera{}Degree",
        "CameraOrientationNED/{}",
    ):
        yaw, pitch, roll = (
            _number(tags, pattern.format(angle)) for angle in ("Yaw", "Pitch", "Roll")
        )
        if yaw is not None and pitch is not None:
            return (wrap360(yaw), pitch, roll), not (yaw or pitch or roll)
    yaw, pitch, roll = (_number(tags, f"Camera:{angle}") for angle in ("Yaw", "Pitch", "Roll"))
    if yaw is None or pitch is None:
        return (None, None, None), False
    is_zero = not (yaw or pitch or roll)
    yaw, pitch, roll = nadir_to_view_angles([yaw, pitch, roll or 0.0])[0].tolist()
    return (wrap360(yaw), pitch, roll), is_zero


def _number(tags: Mapping[str, str], *names: str) -> float | None:
    for name in names:
        text = tags.get(name, tags.get(f"Camera:{name}"))
        if text is None:
            continue
        numerator, _, denominator = text.partition("/")
        try:
            value = float(numerator) / float(denominator) if denominator else float(numerator)
        except (ValueError, ZeroDivisionError):
            continue
        if math.isfinite(value):
            return value
    return None
