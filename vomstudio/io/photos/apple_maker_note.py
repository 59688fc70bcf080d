"""Where gravity pulled when an Apple phone took a photo.

Its maker note is a TIFF directory behind `Apple iOS`, whose tag 8 holds three signed ratios: the
acceleration in units of g, by Apple's axes of the phone as seen from its front: x to the right, y
to the top, z out of the face (Apple, `CMAcceleration`; ExifTool's tag names, "Apple": there with
all signs reversed). A phone at rest shows the direction in which things fall.
"""

from __future__ import annotations

import math
import struct

_HEAD = b"Apple iOS\0"
_ACCELERATION = 8
_SIGNED_RATIOS = 10
# Units of g between which a phone counts as held still.
_AT_REST = (0.9, 1.1)

Vector = tuple[float, float, float]


def acceleration(note: object) -> Vector | None:
    """By Apple's axes of the phone, in units of g; None where the note is none of Apple's, or says
    nothing."""
    if not isinstance(note, bytes) or not note.startswith(_HEAD) or len(note) < 16:
        return None
    order = {b"MM": ">", b"II": "<"}.get(note[12:14])
    if order is None:
        return None
    try:
        (count,) = struct.unpack_from(order + "H", note, 14)
        for entry in range(count):
            tag, kind, values, at = struct.unpack_from(order + "HHII", note, 16 + 12 * entry)
            if (tag, kind, values) == (_ACCELERATION, _SIGNED_RATIOS, 3):
                numbers = struct.unpack_from(order + "6i", note, at)
                x, y, z = (a / b for a, b in zip(numbers[::2], numbers[1::2], strict=True))
                return x, y, z
    except (struct.error, ZeroDivisionError):
        pass
    return None


def down_in_photo(measured: Vector, orientation: int, width: int, height: int) -> Vector | None:
    """(3,) the direction in which things fall, in the frame of the camera at the back (x right, y
    down, z forward, in the photo as it is stored), a unit vector; None where the phone moved too
    much for that.

    orientation : EXIF's, 1 to 8; width, height : of the photo as stored
    The sensor's long side lies along the phone, and its top at the phone's right side seen from the
    front. Programs that turn the pixels upright reset the orientation: the photo is then held
    against the direction of gravity, which a viewer sees at the bottom.
    """
    size = math.hypot(*measured)
    if not _AT_REST[0] <= size <= _AT_REST[1]:
        return None
    x, y, z = (value / size for value in measured)
    right, down, ahead = -y, -x, -z
    turns = 0
    if orientation == 1 and math.hypot(right, down) > 0.5:
        # To the bottom of what is seen, by quarter turns clockwise of the pixels.
        turns = round(math.atan2(right, down) / (math.pi / 2)) % 4
        if (turns % 2 == 1) != (height > width):
            # Held askew at the moment when the phone chose: the shape decides, then the bottom.
            turns = 0 if height <= width else 1 if right > 0 else 3
    elif orientation == 1 and height > width:
        turns = 1
    for _ in range(turns):
        right, down = -down, right
    return right, down, ahead
