"""HEIF photos against the JPEG that they were made from, and against libheif itself.

The files in `heif` show the first sample photo, reduced to 320 x 214 pixels: `level.heic` as the
sensor stored it, `turned.heic` in tiles, shown after a quarter turn as by a phone held upright, and
`opposite.heic` after half a turn.
"""

from __future__ import annotations

import io
import struct
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pi_heif
import pytest
from PIL import Image

import vomstudio as vs
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted import heif
from vomstudio.core.files.untrusted.pictures import decode_picture, open_picture
from vomstudio.core.paths import resource
from vomstudio.io.photos.pixels import grey, open_photo, read_stored_image, thumbnail
from vomstudio.io.photos.reading import read_photo, read_photos

FOLDER = Path(__file__).with_name("heif")
NAMES = {"level.heic": 1, "turned.heic": 6, "opposite.heic": 3}
"""Orientation of each photo."""
SIZE = (320, 214)


def original() -> Path:
    return min(resource("sample", "photos").glob("*.jpg"))


@pytest.fixture(scope="module")
def reduced() -> np.ndarray:
    with Image.open(original()) as image:
        return np.asarray(image.resize(SIZE, Image.Resampling.LANCZOS)).astype(float)


def decoded(path: Path) -> np.ndarray:
    """Return a copy of the pixels as libheif decodes them, which belong to its object."""
    image = pi_heif.open_heif(path)
    return np.array(image)


@pytest.mark.parametrize("name", NAMES)
def test_stored_pixels_match_the_sensor_and_upright_pixels_match_libheif(name, reduced) -> None:
    pixels, size, orientation = read_stored_image(FOLDER / name, 1000)
    assert (size, orientation) == (SIZE, NAMES[name])
    assert np.abs(pixels - reduced).mean() < 6.0
    np.testing.assert_array_equal(thumbnail(FOLDER / name, 1000), decoded(FOLDER / name))


@pytest.mark.parametrize("name", NAMES)
def test_opencv_and_pillow_functions_return_the_same_pixels(name) -> None:
    content = (FOLDER / name).read_bytes()
    with open_photo(FOLDER / name) as image:
        pixels = np.asarray(image)
    rgb = decode_picture(content, cv2.IMREAD_COLOR_RGB, name)
    np.testing.assert_array_equal(rgb, pixels)
    bgr = decode_picture(content, cv2.IMREAD_COLOR, name)
    np.testing.assert_array_equal(bgr, pixels[..., ::-1])
    one_band = decode_picture(content, cv2.IMREAD_GRAYSCALE, name)
    assert np.abs(one_band.astype(int) - grey(FOLDER / name)).max() <= 1


def test_metadata_match_the_jpeg(tmp_path: Path) -> None:
    jpeg = read_photo(original())
    for name in NAMES:
        photo = read_photo(FOLDER / name)
        assert (photo.width, photo.height) == SIZE
        expected = replace(
            jpeg, path=photo.path, name=name, width=320, height=214, orientation=NAMES[name]
        )
        for tag in ("focal_mm", "focal_35mm", "taken_at", "exposure_s", "orientation", "lens"):
            assert getattr(photo, tag) == getattr(expected, tag), tag


def test_folder_lists_photos_of_one_camera_in_any_orientation() -> None:
    folder = read_photos(FOLDER)
    assert [photo.name for photo in folder.photos] == sorted(NAMES)
    assert folder.skipped == []
    assert len(folder.cameras()) == 1


def test_turn_without_orientation_tag_keeps_the_upright_photo(tmp_path: Path) -> None:
    content = (FOLDER / "turned.heic").read_bytes()
    start = (
        content.index(b"Exif\0\0II") if b"Exif\0\0II" in content else content.index(b"Exif\0\0MM")
    )
    exif = content[start:]
    offset = start + heif._orientation_offset(exif)
    order = "<H" if exif[6:8] == b"II" else ">H"
    other = content[:offset] + struct.pack(order, 1) + content[offset + 2 :]
    path = tmp_path / "other.heic"
    path.write_bytes(other)
    pixels, size, orientation = read_stored_image(path, 1000)
    assert (size, orientation) == (SIZE[::-1], 1)
    np.testing.assert_array_equal(pixels, decoded(path))


def test_truncated_photos_are_skipped_with_a_reason(tmp_path: Path) -> None:
    content = (FOLDER / "level.heic").read_bytes()
    (tmp_path / "whole.heic").write_bytes(content)
    (tmp_path / "half.heic").write_bytes(content[: len(content) // 2])
    (tmp_path / "text.heic").write_text("not a picture")
    folder = read_photos(tmp_path)
    assert [photo.name for photo in folder.photos] == ["whole.heic"]
    assert {name: finding.code for name, finding in folder.skipped} == {
        "half.heic": "photo.truncated",
        "text.heic": "picture.unknown-kind",
    }


def test_damaged_pixels_are_reported(tmp_path: Path) -> None:
    content = bytearray((FOLDER / "level.heic").read_bytes())
    start = content.index(b"mdat") + 4
    content[start:] = bytes(len(content) - start)
    path = tmp_path / "damaged.heic"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        grey(path)
    assert caught.value.code == "file.damaged"


def test_enormous_declared_size_is_rejected_before_decoding(tmp_path: Path) -> None:
    content = (FOLDER / "level.heic").read_bytes()
    size = struct.pack(">II", *SIZE)
    assert size in content
    path = tmp_path / "huge.heic"
    path.write_bytes(content.replace(size, struct.pack(">II", 60_000, 60_000)))
    with pytest.raises(InputError) as caught, open_picture(path):
        pass
    assert caught.value.code == "file.picture-too-large"


def test_header_parser_survives_random_damage() -> None:
    content = (FOLDER / "turned.heic").read_bytes()
    rng = np.random.default_rng(4)
    end = content.index(b"mdat")
    for _ in range(400):
        damaged = bytearray(content)
        for place in rng.integers(0, end, rng.integers(1, 6)):
            damaged[place] = rng.integers(256)
        try:
            header = heif.read_header(io.BytesIO(damaged))
        except InputError as error:
            assert error.code == "photo.truncated"  # noqa: PT017
            continue
        assert header is None or 0 <= header.quarter_turns <= 3


def test_survey_check_reads_heif_photos(tmp_path: Path) -> None:
    for name in NAMES:
        (tmp_path / name).write_bytes((FOLDER / name).read_bytes())
    result = vs.check(tmp_path)
    assert len(result.photos) == 3
