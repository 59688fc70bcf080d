"""Pictures of strangers: which decoders may see them, and what they may cost."""

from __future__ import annotations

import ast
import io
import os
import struct
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, UnidentifiedImageError

from vomstudio.errors import InputError
from vomstudio.files.pictures import PHOTOS, open_picture
from vomstudio.io.photos.pixels import thumbnail
from vomstudio.io.photos.xmp import read_drone_tags

POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 64 64\n%%EndComments\nshowpage\n"
SOUND = 40


def picture(kind: str, **options: object) -> bytes:
    stream = io.BytesIO()
    pixels = np.arange(SOUND * SOUND * 3, dtype=np.uint8).reshape(SOUND, SOUND, 3)
    Image.fromarray(pixels).save(stream, kind, **options)
    return stream.getvalue()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_nothing_else_opens_pictures() -> None:
    """Every other call of Pillow's `open` would let its decoders be chosen by the content."""
    program = Path(__file__).parents[2] / "vomstudio"
    found = []
    for module in program.rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text("utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in (
                "Image.open",
                "PIL.Image.open",
                "ImageFile.Parser",
                "cv2.imread",
            ):
                found.append(module.relative_to(program).as_posix())
    assert found == ["files/pictures.py"]


def test_a_postscript_called_jpg_starts_no_ghostscript(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started = tmp_path / "started"
    ghostscript = tmp_path / "gs"
    ghostscript.write_text(f"#!/bin/sh\ntouch '{started}'\n")
    ghostscript.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    for name in ("a.jpg", "a.tif", "a.png", "a.eps"):
        (tmp_path / name).write_bytes(POSTSCRIPT)
        with pytest.raises(InputError):
            thumbnail(tmp_path / name)
        with pytest.raises(UnidentifiedImageError):
            open_picture(tmp_path / name)
    assert not started.exists()


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF", "WEBP", "BMP", "TGA"])
def test_what_is_allowed_opens(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.picture"
    path.write_bytes(picture(kind))
    with open_picture(path) as image:
        assert image.size == (SOUND, SOUND)
        assert np.asarray(image.convert("RGB")).shape == (SOUND, SOUND, 3)
    if kind not in PHOTOS:
        with pytest.raises(UnidentifiedImageError):
            open_picture(path, PHOTOS)


def test_filling_between_the_parts_of_a_jpeg_is_short_or_refused() -> None:
    jpeg = picture("JPEG")
    with open_picture(jpeg[:2] + b"\xff" * 1000 + jpeg[2:]) as image:
        assert image.size == (SOUND, SOUND)
    begun = time.monotonic()
    for filling in (b"\xff", b"\0", b"\xff\0"):
        with pytest.raises(OSError, match="mean nothing"):
            open_picture(jpeg[:2] + filling * (60_000_000 // len(filling)) + jpeg[2:])
    assert time.monotonic() - begun < 30  # byte by byte it took minutes


def test_parts_of_a_header_are_counted() -> None:
    jpeg, png = picture("JPEG"), picture("PNG")
    with pytest.raises(OSError, match="more parts"):
        open_picture(jpeg[:2] + b"\xff\xe5\0\2" * 200_000 + jpeg[2:])
    with pytest.raises(OSError, match="more parts"):
        open_picture(png[:33] + chunk(b"abCd", b"") * 200_000 + png[33:])


@pytest.mark.parametrize("wrapped", [True, False])
def test_tags_that_name_the_same_bytes_are_refused(wrapped: bool) -> None:
    """5,000 tags of 60,000 bytes each, all of the same 60,000."""
    rows = b"".join(struct.pack("<HHII", 40_000 + i, 5, 7_000, 8) for i in range(5_000))
    tags = b"II*\0" + struct.pack("<I", 60_016)
    tags += b"\1" * 60_008 + struct.pack("<H", 5_000) + rows + b"\0" * 4
    jpeg = picture("JPEG")
    if wrapped:
        exif, parts = b"Exif\0\0" + tags, b""
        for at in range(0, len(exif), 60_000):
            part = exif[at : at + 60_000]
            part = part if at == 0 else b"Exif\0\0" + part
            parts += b"\xff\xe1" + struct.pack(">H", len(part) + 2) + part
        tags = jpeg[:2] + parts + jpeg[2:]
    with pytest.raises(OSError, match="claim more"):
        open_picture(tags)


def test_pixels_that_the_bytes_cannot_hold_are_refused_before_they_are_reserved() -> None:
    png = bytearray(picture("PNG"))
    head = b"IHDR" + struct.pack(">II", 30_000, 30_000) + bytes(png[24:29])
    png[12:33] = head + struct.pack(">I", zlib.crc32(head))
    with pytest.raises(OSError, match="cannot hold"):
        open_picture(bytes(png))


def test_a_pipe_is_no_picture(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.jpg")
    with pytest.raises(InputError, match="no file with content"):
        open_picture(tmp_path / "a.jpg")


def test_xmp_without_an_end_is_looked_through_once() -> None:
    begun = time.monotonic()
    assert read_drone_tags(b"<x:xmpmeta " * 2_000_000).yaw_deg is None
    assert time.monotonic() - begun < 10  # each beginning looked for its end
