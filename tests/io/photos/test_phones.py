"""What phones say of how they were held."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.io.photos import photo_maker as maker
from vomstudio.io.photos.apple_maker_note import acceleration, gravity_in_photo
from vomstudio.io.photos.reading import read_photo

MAIN = {0x010F: maker.text("Apple")}


def phone(folder: Path, note, orientation: int, size=(160, 120), lens="back camera", **gps):
    exif = {0x927C: maker.apple_note(*note), 0xA434: maker.text(lens)}
    main = {**MAIN, 0x0112: maker.short(orientation)}
    path = folder / "IMG_1.jpg"
    return read_photo(maker.write_photo(path, size, main=main, exif=exif, **gps))


@pytest.mark.parametrize(
    ("note", "orientation", "size", "down"),
    [
        # The button to the right: the phone's left side is below, the sensor is upright.
        ((-1, 0, 0), 1, (160, 120), (0, 1, 0)),
        # Upright: its bottom is below, which is the right side of the sensor, turned by viewers.
        ((0, -1, 0), 6, (160, 120), (1, 0, 0)),
        # The button to the left, and upside down.
        ((1, 0, 0), 3, (160, 120), (0, -1, 0)),
        ((0, 1, 0), 8, (160, 120), (-1, 0, 0)),
        # Face up on a table: the camera at the back looks down.
        ((0, 0, -1), 1, (160, 120), (0, 0, 1)),
        # Upright, its top leaning away from the photographer: the camera at the back looks down by
        # 30 degrees, and half of gravity pulls out of it.
        ((0, -0.8660254, -0.5), 6, (160, 120), (0.8660254, 0, 0.5)),
        # Programs that turned the pixels upright: gravity is at the bottom of what is stored.
        ((0, -1, 0), 1, (120, 160), (0, 1, 0)),
        ((1, 0, 0), 1, (160, 120), (0, 1, 0)),
        # The photographer's right side is lower, as in the photo.
        ((0.17364818, -0.98480775, 0), 1, (120, 160), (0.17364818, 0.98480775, 0)),
    ],
)
def test_gravity_direction_in_photo_follows_sensor_and_orientation(
    tmp_path: Path, note, orientation, size, down
) -> None:
    photo = phone(tmp_path, note, orientation, size)
    np.testing.assert_allclose(photo.down, down, atol=1e-6)
    assert np.linalg.norm(photo.down) == pytest.approx(1.0)


def test_moving_phone_or_front_camera_gives_no_gravity_direction(tmp_path: Path) -> None:
    assert phone(tmp_path, (-1.4, 0.3, 0), 1).down is None
    assert phone(tmp_path, (-1, 0, 0), 1, lens="iPhone 12 front camera 2.71mm f/2.2").down is None


def test_directions_state_true_or_magnetic_north(tmp_path: Path) -> None:
    for north, wanted in (("T", "true"), ("M", "magnetic"), (None, None)):
        gps = {**maker.at(45.0, 13.0), **maker.looking(251.25, north)}
        photo = phone(tmp_path, (-1, 0, 0), 1, gps=gps)
        assert (photo.direction_deg, photo.direction_north) == (251.25, wanted)
    photo = phone(tmp_path, (-1, 0, 0), 1, gps=maker.looking(400.0))
    assert photo.direction_deg is None


@pytest.mark.parametrize(
    "note",
    [
        None,
        b"",
        b"Nikon\0\2\0\0\0MM",
        b"Apple iOS\0\0\1XX\0\1",
        b"Apple iOS\0\0\1MM\xff\xff",
        maker.apple_note(1, 0, 0)[2][:-9],
        maker.apple_note(1, 0, 0)[2][:-4] + bytes(4),
    ],
)
def test_damaged_maker_note_gives_no_acceleration(note) -> None:
    assert acceleration(note) is None


def test_image_shape_decides_rotation_of_a_tilted_phone() -> None:
    askew = (-np.sin(np.radians(50)), -np.cos(np.radians(50)), 0.0)
    right, down, _ = gravity_in_photo(askew, 1, 160, 120)
    # The sensor as it is: wider than high.
    assert (right, down) == pytest.approx((np.cos(np.radians(50)), np.sin(np.radians(50))))
    right, down, _ = gravity_in_photo(askew, 1, 120, 160)
    assert down > 0
