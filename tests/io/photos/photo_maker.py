"""Photos with EXIF written by hand, for tests."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

TEXTURE = np.random.default_rng(7).integers(0, 255, (64, 64), np.uint8)


def rationals(*pairs: tuple[int, int], signed: bool = False) -> tuple[int, int, bytes]:
    """Type, count and data of an EXIF field; zero denominators are allowed."""
    return (
        (10 if signed else 5),
        len(pairs),
        b"".join(struct.pack("<ii" if signed else "<II", *pair) for pair in pairs),
    )


def rational(value: float, denominator: int = 10000) -> tuple[int, int, bytes]:
    return rationals((round(value * denominator), denominator))


def short(value: int) -> tuple[int, int, bytes]:
    return 3, 1, struct.pack("<H", value)


def long(value: int) -> tuple[int, int, bytes]:
    return 4, 1, struct.pack("<I", value)


def text(value: str) -> tuple[int, int, bytes]:
    data = value.encode() + b"\0"
    return 2, len(data), data


def byte(value: int) -> tuple[int, int, bytes]:
    return 1, 1, bytes([value])


Fields = Mapping[int, tuple[int, int, bytes]]


def exif_bytes(main: Fields = {}, exif: Fields = {}, gps: Fields = {}) -> bytes:  # noqa: B006
    """A little-endian TIFF structure with the three directories (TIFF 6.0, section 2)."""

    def directory(fields: Fields, at: int) -> bytes:
        ordered = sorted(fields.items())
        extra_at = at + 2 + 12 * len(ordered) + 4
        entries, extra = b"", b""
        for tag, (kind, count, data) in ordered:
            entries += struct.pack("<HHI", tag, kind, count)
            if len(data) <= 4:
                entries += data.ljust(4, b"\0")
            else:
                entries += struct.pack("<I", extra_at + len(extra))
                extra += data + b"\0" * (len(data) % 2)
        return struct.pack("<H", len(ordered)) + entries + b"\0\0\0\0" + extra

    pointers = {0x8769: long(0), 0x8825: long(0)}
    first = directory({**main, **pointers}, 8)
    exif_at = 8 + len(first)
    second = directory(exif, exif_at)
    gps_at = exif_at + len(second)
    first = directory({**main, 0x8769: long(exif_at), 0x8825: long(gps_at)}, 8)
    return b"Exif\0\0II*\0\x08\0\0\0" + first + second + directory(gps, gps_at)


def at(latitude: float, longitude: float, altitude: float | None = None, ref: int = 0) -> Fields:
    """GPS fields of a place."""

    def dms(value: float) -> tuple[int, int, bytes]:
        value = abs(value)
        minutes = (value - int(value)) * 60
        seconds = (minutes - int(minutes)) * 60
        return rationals((int(value), 1), (int(minutes), 1), (round(seconds * 1e6), 10**6))

    fields: dict[int, tuple[int, int, bytes]] = {
        1: text("N" if latitude >= 0 else "S"),
        2: dms(latitude),
        3: text("E" if longitude >= 0 else "W"),
        4: dms(longitude),
    }
    if altitude is not None:
        fields |= {5: byte(ref), 6: rational(altitude, 1000)}
    return fields


def picture(width: int, height: int, seed: int = 0) -> np.ndarray:
    """Noise of its own for every seed, so that no two photos are the same file."""
    rng = np.random.default_rng(seed)
    small = rng.integers(0, 255, (height // 8 + 1, width // 8 + 1, 3), np.uint8)
    return small.repeat(8, 0).repeat(8, 1)[:height, :width]


def write_photo(
    path: Path, size: tuple[int, int] = (160, 120), seed: int = 0, **options: Any
) -> Path:
    """options: main, exif, gps (fields), xmp (bytes), pixels."""
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = options.pop("pixels", None)
    image = Image.fromarray(picture(*size, seed) if pixels is None else pixels)
    xmp = options.pop("xmp", None)
    data = exif_bytes(**options) if options else None
    extra: dict[str, Any] = {} if data is None else {"exif": data}
    if xmp is not None:
        extra["xmp"] = xmp
    image.save(path, **extra)
    return path


def drone_xmp(**tags: object) -> bytes:
    """A packet as DJI writes it."""
    said = "\n".join(f'drone-dji:{key}="{value}"' for key, value in tags.items())
    return (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF '
        'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description '
        f'xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/" {said}/></rdf:RDF></x:xmpmeta>'
    ).encode()


def apple_note(right: float, top: float, out: float) -> tuple[int, int, bytes]:
    """The field of an Apple maker note with an acceleration by the phone's axes, after ExifTool's
    "Apple" tags: a big-endian directory with tag 1 (version) before tag 8 (three signed ratios)."""
    version = struct.pack(">HHIi", 1, 9, 1, 14)
    at_ = 16 + 2 * 12 + 4
    entry = struct.pack(">HHII", 8, 10, 3, at_)
    ratios = b"".join(struct.pack(">ii", round(v * 10**6), 10**6) for v in (right, top, out))
    note = b"Apple iOS\0\0\1MM" + struct.pack(">H", 2) + version + entry + bytes(4) + ratios
    return 7, len(note), note


def looking(direction: float, north: str | None = "T") -> Fields:
    """GPS fields of the azimuth of a view."""
    fields: dict[int, tuple[int, int, bytes]] = {17: rational(direction, 1000)}
    if north is not None:
        fields[16] = text(north)
    return fields
