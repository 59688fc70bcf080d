"""Camera angles without EXIF tags, from the text of `UserComment`.

Recognised forms, in any order and with any separators:

- ``Roll 1.5 Pitch -8.0 Yaw 120.0`` (Raspberry Pi and Pixhawk cameras)
- ``Pitch: -8.0, Yaw: 120.0, Roll: 1.5`` and ``yaw=120,pitch=-8,roll=1.5`` (Android camera apps)
- JSON with ``yaw``, ``pitch`` and ``roll``, also as strings, or with ``CameraYaw`` and
  ``CameraPitch`` (Yuneec photos updated from flight logs) or ``camera_pan`` and ``camera_tilt``
  (fixed cameras)

Angles are those of the optical axis in degrees: yaw from true north, pitch 0 for level and -90 for
straight down.
"""

from __future__ import annotations

import math
import re
from typing import Any

Angles = tuple[float, float, float | None]

_MAX_CHARACTERS = 1 << 16
MAX_PITCH_DEG = 93.0
"""Maximum pitch; a gimbal that points straight down may swing slightly beyond the vertical."""
_CAMERA_PREFIXES = ("gimbal", "camera", "")
_AXES = {
    "yaw": 0,
    "heading": 0,
    "azimuth": 0,
    "pan": 0,
    "pitch": 1,
    "tilt": 1,
    "roll": 2,
}
_ANGLE = re.compile(
    r"""(?<![A-Za-z0-9_])
    (?:(gimbal|camera|flight|aircraft|drone|uav|vehicle|body|home)[ _-]?)?
    (yaw|heading|azimuth|pan|pitch|tilt|roll)
    (?:[ _-]?(?:degrees?|deg|angle))?
    [ ]?(?:\([ ]?(?:degrees?|deg|°)[ ]?\))?
    [ ]?["']?[ ]?[:=]?[ ]?["']?[ ]?
    ([+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?)(?!\d|\.\d)""",
    re.IGNORECASE | re.VERBOSE,
)


def comment_text(value: Any) -> str | None:
    """Return the text of a `UserComment` (Exif 3.0, 4.6.6), or None.

    The value is either bytes, the first eight of which state the character code, or text that a
    program wrote without a code.
    """
    if isinstance(value, str):
        text = value
    elif not isinstance(value, bytes):
        return None
    elif value.startswith(b"UNICODE\0"):
        text = _utf16(value[8:])
    else:
        has_code = value.startswith((b"ASCII\0\0\0", b"JIS\0\0\0\0\0", bytes(8)))
        text = (value[8:] if has_code else value).decode("utf-8", "replace")
    return text[:_MAX_CHARACTERS].replace("\0", " ").strip() or None


def comment_angles(text: str | None) -> Angles | None:
    """Return yaw, pitch and roll of the camera in degrees (None if not stated).

    Angles named after the gimbal or camera take precedence over unqualified ones; angles named
    after the aircraft are ignored. Returns None if yaw or pitch is missing, stated twice with
    different values, or impossible.
    """
    if not text:
        return None
    # Remove runs of white space, for which the pattern would take exponential time.
    label = " ".join(text[:_MAX_CHARACTERS].split())
    angles: dict[str, list[set[float]]] = {}
    for prefix, name, number in _ANGLE.findall(label):
        axes = angles.setdefault(prefix.lower(), [set(), set(), set()])
        axes[_AXES[name.lower()]].add(float(number))
    for prefix in _CAMERA_PREFIXES:
        values = angles.get(prefix)
        if values is None or not (values[0] and values[1]):
            continue
        if any(len(axis_values) > 1 for axis_values in values):
            return None
        yaw, pitch, roll = (next(iter(axis_values), None) for axis_values in values)
        assert yaw is not None
        assert pitch is not None
        is_plausible = (
            abs(yaw) <= 360.0 and abs(pitch) <= MAX_PITCH_DEG and abs(roll or 0.0) <= 360.0
        )
        is_finite = all(math.isfinite(v) for v in (yaw, pitch, roll or 0.0))
        return (yaw, pitch, roll) if is_plausible and is_finite else None
    return None


def _utf16(data: bytes) -> str:
    """Decode UTF-16 of unknown byte order: in most characters, the high byte is 0."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    is_big_endian = data[::2].count(0) > data[1::2].count(0)
    return data.decode("utf-16-be" if is_big_endian else "utf-16-le", "replace")
