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

from tests.architecture.opens import calls_in
from tests.messages import refused
from vomstudio.cli import main
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted import budgets
from vomstudio.core.files.untrusted.pictures import (
    MASK_BYTES,
    PHOTO_FORMATS,
    check_picture,
    check_raster,
    decode_picture,
    open_picture,
)
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.pixels import thumbnail
from vomstudio.io.photos.xmp import read_drone_tags
from vomstudio.products.ortho.textures import load_pyramid
from vomstudio.rendering.prepare.textures import load_texture

POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 64 64\n%%EndComments\nshowpage\n"
SOUND = 40
HEADER, TOO_LARGE = "file.picture-header", "file.picture-too-large"


def picture(kind: str, **options: object) -> bytes:
    stream = io.BytesIO()
    pixels = np.arange(SOUND * SOUND * 3, dtype=np.uint8).reshape(SOUND, SOUND, 3)
    Image.fromarray(pixels).save(stream, kind, **options)
    return stream.getvalue()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


DECODERS = {
    "Image.open",
    "PIL.Image.open",
    "ImageFile.Parser",
    "cv2.imread",
    "cv2.imdecode",
    "cv2.imreadmulti",
    "matplotlib.image.imread",
    "plt.imread",
}
CHECKED_BEFORE = {"rasterio.open": "check_raster", "QImageReader": "check_picture"}
"""Libraries that open a name, and what has checked the file."""
PICTURE_CALLS = {*DECODERS, *CHECKED_BEFORE, *CHECKED_BEFORE.values()}


def calls(module: Path) -> set[str]:
    """Return the functions that a module calls, if it names one of `PICTURE_CALLS`."""
    text = module.read_text("utf-8")
    if not any(name in text for name in PICTURE_CALLS):
        return set()
    return {ast.unparse(call.func) for call in calls_in(text)}


def test_only_pictures_module_opens_images() -> None:
    """Every other call would let decoders be chosen by the content, and have no budget."""
    program = Path(__file__).parents[3] / "vomstudio"
    found = {m.relative_to(program).as_posix(): calls(m) for m in program.rglob("*.py")}
    opening = {name for name, made in found.items() if made & DECODERS}
    assert opening == {"core/files/untrusted/pictures.py"}
    for opens, checks in CHECKED_BEFORE.items():
        users = {name for name, made in found.items() if opens in made}
        assert users
        assert {name for name in users if checks not in found[name]} == set(), opens


def test_postscript_named_jpg_does_not_start_ghostscript(
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
def test_allowed_formats_are_opened(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.picture"
    path.write_bytes(picture(kind))
    with open_picture(path) as image:
        assert image.size == (SOUND, SOUND)
        assert np.asarray(image.convert("RGB")).shape == (SOUND, SOUND, 3)
    if kind not in PHOTO_FORMATS:
        with pytest.raises(UnidentifiedImageError):
            open_picture(path, PHOTO_FORMATS)


def test_long_padding_between_jpeg_segments_is_refused() -> None:
    jpeg = picture("JPEG")
    with open_picture(jpeg[:2] + b"\xff" * 1000 + jpeg[2:]) as image:
        assert image.size == (SOUND, SOUND)
    begun = time.monotonic()
    for filling in (b"\xff", b"\0", b"\xff\0"):
        assert refusal(jpeg[:2] + filling * (60_000_000 // len(filling)) + jpeg[2:]) == HEADER
    assert time.monotonic() - begun < 30  # byte by byte it took minutes


def test_number_of_header_parts_is_limited() -> None:
    jpeg, png = picture("JPEG"), picture("PNG")
    assert refusal(jpeg[:2] + b"\xff\xe5\0\2" * 200_000 + jpeg[2:]) == HEADER
    assert refusal(png[:33] + chunk(b"abCd", b"") * 200_000 + png[33:]) == HEADER


@pytest.mark.parametrize("wrapped", [True, False])
def test_overlapping_tiff_tags_are_refused(wrapped: bool) -> None:
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
    assert refusal(tags) == HEADER


def test_pipe_is_refused_as_image(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.jpg")
    with refused("file.not-regular"):
        open_picture(tmp_path / "a.jpg")


def test_unterminated_xmp_is_scanned_once() -> None:
    begun = time.monotonic()
    assert read_drone_tags(b"<x:xmpmeta " * 2_000_000).yaw_deg is None
    assert time.monotonic() - begun < 10  # each beginning looked for its end


def refusal(content: bytes, **options: int) -> str:
    """The code with which a picture is refused."""
    with pytest.raises(InputError) as error:
        open_picture(content, **options)
    return error.value.code


def png_of(width: int, height: int, *, depth: int = 8, kind: int = 2, data: bytes = b"") -> bytes:
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data)


def tiff_of(width: int, height: int, **tags: int) -> bytes:
    """A TIFF of grey pixels, of which the file holds none."""
    numbers = {"bits": 258, "packing": 259, "rows": 278, "across": 322, "down": 323, "samples": 277}
    entries = {256: width, 257: height, 258: 8, 259: 1, 262: 1, 273: 8, 277: 1, 279: 1}
    entries |= {numbers[name]: value for name, value in tags.items()}
    rows = b"".join(struct.pack("<HHII", tag, 4, 1, entries[tag]) for tag in sorted(entries))
    return b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(entries)) + rows + b"\0" * 4


def jpeg_of(width: int, height: int, **options: object) -> bytes:
    data = bytearray(picture("JPEG", **options))
    at = next(data.index(mark) for mark in (b"\xff\xc0", b"\xff\xc2") if mark in data)
    struct.pack_into(">HH", data, at + 5, height, width)
    return bytes(data)


def webp_of(width: int, height: int) -> bytes:
    data = bytearray(picture("WEBP", lossless=True))
    struct.pack_into("<I", data, 21, (width - 1) | (height - 1) << 14)
    return bytes(data)


def bmp_of(width: int, height: int) -> bytes:
    data = bytearray(picture("BMP"))
    struct.pack_into("<ii", data, 18, width, height)
    return bytes(data)


def tga_of(width: int, height: int) -> bytes:
    data = bytearray(picture("TGA"))
    struct.pack_into("<HH", data, 12, width, height)
    return bytes(data)


@pytest.fixture
def plenty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Free memory that limits nothing."""
    monkeypatch.setattr(budgets, "free_bytes", lambda: 1 << 40)


@pytest.mark.usefixtures("plenty")
@pytest.mark.parametrize("make", [png_of, tiff_of, jpeg_of, webp_of, bmp_of, tga_of])
def test_every_format_is_refused_beyond_its_budget_before_it_is_decoded(make, tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "wall.picture"
    path.write_bytes(make(12_000, 12_000))
    with pytest.raises(InputError) as error:
        open_picture(path)
    assert error.value.code == TOO_LARGE
    assert error.value.file == str(path)
    values = error.value.values
    assert (values["width"], values["height"]) == (12_000, 12_000)
    assert values["needed_mb"] > values["limit_mb"] == 500
    open_picture(make(5000, 5000)).close()


@pytest.mark.usefixtures("plenty")
def test_limit_is_100_times_file_size_plus_500_mb() -> None:
    allowed = png_of(11_200, 11_200)  # 502 MB of four bytes
    assert refusal(allowed) == TOO_LARGE
    larger = png_of(11_200, 11_200, data=bytes(20_000))
    open_picture(larger).close()
    open_picture(allowed, min_pixel_bytes=MASK_BYTES, header_only=True).close()


def test_half_of_the_free_memory_is_never_exceeded(monkeypatch: pytest.MonkeyPatch) -> None:
    content = jpeg_of(5000, 4000)  # 80 MB
    monkeypatch.setattr(budgets, "free_bytes", lambda: 150_000_000)
    assert refusal(content) == TOO_LARGE
    open_picture(content, header_only=True).close()
    monkeypatch.setattr(budgets, "free_bytes", lambda: 170_000_000)
    open_picture(content).close()


@pytest.mark.usefixtures("plenty")
def test_one_bit_mask_of_150_megapixels_is_read() -> None:
    mask = png_of(14_204, 10_652, depth=1, kind=0, data=bytes(20_000))
    assert refusal(mask) == TOO_LARGE  # as a photo
    open_picture(mask, min_pixel_bytes=MASK_BYTES).close()


@pytest.mark.usefixtures("plenty")
@pytest.mark.parametrize(
    "tags",
    [
        {"across": 65_536, "down": 65_536},
        {"samples": 60_000, "bits": 64},
        {"across": 1 << 30, "down": 16},
    ],
)
def test_tile_size_and_band_count_of_small_tiff_count_in_budget(
    tags: dict[str, int], tmp_path: Path
) -> None:
    """A tile of gigabytes, or thousands of bands, in a picture of 100 pixels a side."""
    path = tmp_path / "a.tif"
    path.write_bytes(tiff_of(100, 100, **tags))
    assert refusal(path.read_bytes()) == TOO_LARGE
    for check in (check_picture, check_raster):
        with pytest.raises(InputError) as error:
            check(path)
        assert error.value.code == TOO_LARGE
        assert error.value.file == str(path)


@pytest.mark.usefixtures("plenty")
def test_tiles_beyond_image_edge_count_in_budget() -> None:
    """All of them are decompressed: 7 GB for a picture of 70 megapixels, which took 101 s."""
    open_picture(tiff_of(10_000, 7000, across=256, down=256)).close()
    assert refusal(tiff_of(10_000, 7000, across=1 << 20, down=16)) == TOO_LARGE


@pytest.mark.usefixtures("plenty")
def test_a_raster_that_is_read_in_windows_may_be_larger_than_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.tif"
    path.write_bytes(tiff_of(60_000, 60_000, rows=16) + bytes(40_000_000))
    monkeypatch.setattr(budgets, "free_bytes", lambda: 1 << 30)
    check_raster(path)
    with pytest.raises(InputError):
        check_picture(path)
    # In one strip it has to be decoded as a whole.
    path.write_bytes(tiff_of(60_000, 60_000) + bytes(40_000_000))
    with pytest.raises(InputError):
        check_raster(path)


@pytest.mark.usefixtures("plenty")
def test_progressive_jpeg_counts_coefficients_and_scans() -> None:
    open_picture(jpeg_of(8000, 8000)).close()
    assert refusal(jpeg_of(8000, 8000, progressive=True)) == TOO_LARGE
    data = picture("JPEG", progressive=True)
    last = data[data.rindex(b"\xff\xda") : -2]
    open_picture(data[:-2] + last * 20 + data[-2:]).close()
    assert refusal(data[:-2] + last * 200 + data[-2:]) == HEADER


@pytest.mark.usefixtures("plenty")
def test_opencv_decodes_only_photos_within_budget() -> None:
    import cv2

    for kind in ("JPEG", "PNG", "TIFF"):
        pixels = decode_picture(picture(kind), cv2.IMREAD_COLOR, "a")
        assert pixels is not None
        assert pixels.shape == (SOUND, SOUND, 3)
    for kind in ("WEBP", "BMP"):
        assert decode_picture(picture(kind), cv2.IMREAD_COLOR, "a") is None
    for content in (png_of(12_000, 12_000), tiff_of(1 << 20, 1 << 20), jpeg_of(30_000, 30_000)):
        with pytest.raises(InputError) as error:
            decode_picture(content, cv2.IMREAD_COLOR, "wall.jpg")
        assert (error.value.code, error.value.file) == (TOO_LARGE, "wall.jpg")


def test_circular_tiff_directories_terminate() -> None:
    data = bytearray(tiff_of(40, 40))
    data[-4:] = struct.pack("<I", 8)
    open_picture(bytes(data)).close()


@pytest.mark.parametrize("command", [["info"], ["check"]])
def test_command_refuses_image_with_file_and_code(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Seven kilobytes that took 14 GB."""
    folder = tmp_path / "photos"
    folder.mkdir()
    path = folder / "wall.tif"
    path.write_bytes(tiff_of(60_000, 60_000, bits=1, packing=4, rows=60_000) + bytes(7000))
    asked = path if command == ["info"] else folder
    assert main([*command, str(asked), "--json"]) == 2
    told = capsys.readouterr().out
    assert "wall.tif" in told
    assert TOO_LARGE in told or "60000 x 60000" in told


@pytest.mark.parametrize("mode", ["1", "P", "L", "I;16", "RGBA"])
def test_a_photo_of_any_mode_has_a_thumbnail(mode: str, tmp_path: Path) -> None:
    """Half black and half white; Pillow reduces neither palettes nor single bits."""
    grey = np.zeros((600, 900), np.uint8)
    grey[:, 450:] = 255
    image = Image.fromarray(grey)
    if mode == "I;16":
        image = Image.fromarray(grey.astype(np.uint16) << 8)
    image = image if image.mode == mode else image.convert(mode)
    image.save(tmp_path / "a.png")
    small = thumbnail(tmp_path / "a.png", 64)
    assert small.shape == (43, 64, 3)
    assert small[:, :30].max() == 0
    assert small[:, 34:].min() == 255


@pytest.mark.slow
@pytest.mark.parametrize("quality", [5, 90])
def test_a_photo_of_100_megapixels_is_read(quality: int, tmp_path: Path) -> None:
    rows = np.random.default_rng(0).integers(0, 255, (870, 1160, 3), np.uint8)
    photo = Image.fromarray(rows).resize((11_600, 8_700), Image.Resampling.BILINEAR)
    photo.save(tmp_path / "a.jpg", quality=quality, progressive=quality == 90)
    assert thumbnail(tmp_path / "a.jpg", 256).shape == (192, 256, 3)
    assert load_texture(tmp_path / "a.jpg", 16_384).levels[0].width == 11_600
    assert load_pyramid(tmp_path / "a.jpg", 0) is not None


@pytest.mark.slow
@pytest.mark.parametrize("packing", ["none", "deflate"])
def test_a_geotiff_of_a_gigabyte_is_read(packing: str, tmp_path: Path) -> None:
    import rasterio
    from rasterio.windows import Window

    side, step = 16_384, 2048
    heights = np.random.default_rng(0).normal(500.0, 0.05, (step, side)).astype(np.float32)
    with rasterio.open(
        tmp_path / "a.tif",
        "w",
        driver="GTiff",
        width=side,
        height=side,
        count=1,
        crs="EPSG:32633",
        dtype="float32",
        transform=rasterio.Affine(1, 0, 5e5, 0, -1, 5e6),
        tiled=True,
        compress=packing,
        zlevel=1,
    ) as file:
        for top in range(0, side, step):
            file.write(heights, 1, window=Window(0, top, side, step))
    assert (tmp_path / "a.tif").stat().st_size > (1 << 30 if packing == "none" else 500 << 20)
    loaded = read_model(tmp_path / "a.tif")
    assert len(loaded.data.vertices) > 3_000_000
    (tmp_path / "a.tif").unlink()
