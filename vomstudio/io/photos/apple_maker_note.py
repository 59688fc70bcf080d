"""Direction of gravity at the time when an Apple phone took a photo.

The maker note is a TIFF directory after `Apple iOS`. Its tag 8 contains three signed ratios: the
acceleration in units of g along Apple's axes of the phone as seen from its front, with x to the
right, y to the top and z out of the screen (Apple, `CMAcceleration`; in ExifTool's tag names,
"Apple", all signs are reversed). A phone at rest measures the direction of gravity.
"""

from __future__ import annotations

import math
import struct

_SIGNATURE = b"Apple iOS\0"
_ACCELERATION_TAG = 8
_SRATIONAL_TYPE = 10
# Range of the acceleration of a phone at rest, in units of g.
REST_RANGE_G = (0.9, 1.1)

Vector = tuple[float, float, float]


def acceleration(note: object) -> Vector | None:
    """Return the acceleration along Apple's axes of the phone, in units of g.

    Returns None if the maker note is not from Apple or does not contain an acceleration.
    """
    if not isinstance(note, bytes) or not note.startswith(_SIGNATURE) or len(note) < 16:
        return None
    byte_order = {b"MM": ">", b"II": "<"}.get(note[12:14])
    if byte_order is None:
        return None
    try:
        (count,) = struct.unpack_from(byte_order + "H", note, 14)
        for entry in range(count):
            tag, kind, values, offset = struct.unpack_from(
                byte_order + "HHII", note, 16 + 12 * entry
            )
            if (tag, kind, values) == (_ACCELERATION_TAG, _SRATIONAL_TYPE, 3):
                integers = struct.unpack_from(byte_order + "6i", note, offset)
                x, y, z = (
                    numerator / denominator
                    for numerator, denominator in zip(integers[::2], integers[1::2], strict=True)
                )
                return x, y, z
    except (struct.error, ZeroDivisionError):
        pass
    return None


def gravity_in_photo(
    measured_vector: Vector, orientation: int, width: int, height: int
) -> Vector | None:
    """Return the direction of gravity in the frame of the rear camera, as a unit vector (3,).

    The frame is x right, y down, z forward in the photo as stored. The long side of the sensor is
    along the phone, and its top is at the right side of the phone as seen from the front. Programs
    that rotate the pixels upright reset the orientation; therefore the photo is compared with the
    direction of gravity, which points to the bottom for a viewer.

    Parameters
    ----------
    measured_vector : tuple of float
        Acceleration along Apple's axes, in units of g.
    orientation : int
        EXIF orientation, 1 to 8.
    width, height : int
        Size of the photo as stored, in pixels.

    Returns
    -------
    tuple of float or None
        Direction of gravity, or None if the phone was moving.
    """
    size = math.hypot(*measured_vector)
    if not REST_RANGE_G[0] <= size <= REST_RANGE_G[1]:
        return None
    x, y, z = (value / size for value in measured_vector)
    right, down, forward = -y, -x, -z
    quarter_turns = 0
    if orientation == 1 and math.hypot(right, down) > 0.5:
        # Clockwise quarter turns of the pixels that bring gravity to the bottom.
        quarter_turns = round(math.atan2(right, down) / (math.pi / 2)) % 4
        if (quarter_turns % 2 == 1) != (height > width):
            # The phone was oblique when it chose the orientation: the shape decides first, then
            # gravity.
            quarter_turns = 0 if height <= width else 1 if right > 0 else 3
    elif orientation == 1 and height > width:
        quarter_turns = 1
    for _ in range(quarter_turns):
        right, down = -down, right
    return right, down, forward
