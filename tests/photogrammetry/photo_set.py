"""A folder of small photos of a rock face, with which the whole chain runs in seconds."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from tests.io.photos.photo_maker import exif_bytes, rational, short, text
from tests.photogrammetry import rock_face
from vomstudio.geometry.cameras import View

SIZE = (320, 240)
# 36 mm on film, to the whole millimetre as EXIF wants it.
FOCAL = 320.0
DISTANCE = 6.0
# A pixel on the rock; the tests of resuming compare camera centres with it.
GSD = DISTANCE / FOCAL


def views(count: int = 6) -> list[View]:
    """As the photos were taken."""
    return rock_face.ring_of_views(
        2, count // 2, spread=(3.4, 1.2), distance=DISTANCE, size=SIZE, focal=FOCAL, toward=0.6
    )


def write_photos(folder: Path, count: int = 6, quality: int = 95) -> Path:
    """`count` overlapping JPEG photos, `photo 1.jpg` ..., whose EXIF tells the focal length."""
    folder.mkdir(parents=True, exist_ok=True)
    face = rock_face.rough_face(9.0, 6.0, 0.03)
    said = exif_bytes(
        {0x010F: text("Maker"), 0x0110: text("Model")},
        {0x920A: rational(FOCAL / SIZE[0] * 36), 0xA405: short(round(FOCAL / SIZE[0] * 36))},
    )
    for number, view in enumerate(views(count), start=1):
        picture = rock_face.photograph(face, view, seed=number)
        path = folder / f"photo {number}.jpg"
        Image.fromarray(picture).save(path, quality=quality, exif=said)
    return folder
