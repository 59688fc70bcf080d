"""Pictures that state absurd sizes, or are validly compressed to a tiny file: read within a budget.

    python -m tests.fuzz.bent_pictures --files 1000 [--seed N] [--signals 30]

Each file is given to every reader of its format: photos, masks, textures, orthophotos, models of
heights and `info`. Printed is what breaks a promise: more memory
than `ALLOWED` times the budget of the file (`budgets.decoding_limit`) and `FREE_BYTES`, more than
`MAX_S` seconds, an error that is none of ours, a refusal that does not name the file, a valid
picture within half of the budget that is not read. With `--signals` so many files, every other one
of which takes long, are given to the command, which is ended by a signal and must end within 3 s.
The exit code is 1 if any promise is broken.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import select
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tests.fuzz import campaigns
from tests.fuzz.campaigns import Outcome, Report
from tests.fuzz.stopping import until_stopped

ALLOWED, FREE_BYTES = 2.0, 100_000_000
"""Of the budget: the picture, and a copy of it in another mode; and for all else."""
MAX_S = 60.0
MAX_SIDE = 1 << 20
"""Of OpenCV (CV_IO_MAX_IMAGE_HEIGHT)."""
_CHUNK = 1 << 20


# --- making ---------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Bent:
    """A picture.

    Parameters
    ----------
    name : str
        Of the file.
    content : bytes
    how : str
    width, height : int
        That it states.
    is_valid : bool
        Whether it contains all pixels that it states.
    """

    name: str
    content: bytes
    how: str
    width: int
    height: int
    is_valid: bool = False


def _deflated_zeros(count: int) -> bytes:
    """A zlib stream of so many zeros, made of one chunk again and again."""
    packer = zlib.compressobj(9)
    piece = packer.compress(bytes(_CHUNK)) + packer.flush(zlib.Z_FULL_FLUSH)
    again = packer.compress(bytes(_CHUNK)) + packer.flush(zlib.Z_FULL_FLUSH)
    last = packer.compress(bytes(count % _CHUNK)) + packer.flush(zlib.Z_FINISH)
    whole = count // _CHUNK
    body = (piece + again * (whole - 1) if whole else piece[:2]) + last[:-4]
    return body + struct.pack(">I", (count % 65521) << 16 | 1)


def _side(chance: random.Random, largest: int) -> int:
    """Of every magnitude alike."""
    return max(1, min(largest, int(2 ** chance.uniform(0, np.log2(largest)))))


def _sides(chance: random.Random, largest: int) -> tuple[int, int]:
    """Of pictures up to some gigabytes, and of absurd ones."""
    if chance.random() < 0.6:
        pixels = 2 ** chance.uniform(20, 32)
        width = int(np.sqrt(pixels) * 2 ** chance.uniform(-2, 2))
        return min(width, largest), max(1, min(int(pixels / width), largest))
    return _side(chance, largest), _side(chance, largest)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(chance: random.Random) -> Bent:
    """With all of its pixels, or with a header alone."""
    width, height = _sides(chance, 2**31 - 1)
    kind, depth = chance.choice([(0, 1), (0, 8), (0, 16), (2, 8), (2, 16), (3, 8), (6, 16)])
    samples = {0: 1, 2: 3, 3: 1, 6: 4}[kind]
    size = height * (1 + (width * samples * depth + 7) // 8)
    is_valid = size < 6_000_000_000 and chance.random() < 0.7
    data = _deflated_zeros(size) if is_valid else b"\0" * chance.choice([0, 100])
    content = b"\x89PNG\r\n\x1a\n" + _chunk(
        b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, chance.choice([0, 0, 1]))
    )
    if kind == 3:
        content += _chunk(b"PLTE", bytes(768))
    content += _chunk(b"IDAT", data) + _chunk(b"IEND", b"")
    interlaced = content[28] == 1
    return Bent(
        "a.png", content, f"png {width}x{height}", width, height, is_valid and not interlaced
    )


@cache
def _small_jpeg(progressive: bool, grey: bool) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    shape = (40, 40) if grey else (40, 40, 3)
    pixels = np.arange(int(np.prod(shape)), dtype=np.uint32).astype(np.uint8).reshape(shape)
    Image.fromarray(pixels).save(stream, "JPEG", progressive=progressive)
    return stream.getvalue()


def jpeg(chance: random.Random) -> Bent:
    """A small one that states another size, has scans again and again, or parts without end."""
    progressive, grey = chance.random() < 0.5, chance.random() < 0.3
    data = bytearray(_small_jpeg(progressive, grey))
    width, height = _sides(chance, 65_500)
    at = data.index(b"\xff\xc2" if progressive else b"\xff\xc0")
    struct.pack_into(">HH", data, at + 5, height, width)
    how = f"jpeg {width}x{height}"
    if progressive and chance.random() < 0.5:
        begin = data.rindex(b"\xff\xda")
        data[-2:] = data[begin:-2] * chance.choice([50, 5000]) + data[-2:]
        how += " scans"
    if chance.random() < 0.2:
        data[2:2] = b"\xff\xe5\0\2" * chance.choice([100, 50_000])
        how += " parts"
    return Bent("a.jpg", bytes(data), how, width, height)


def tiff(chance: random.Random) -> Bent:
    """Strips or tiles of any size that all name the same bytes, in TIFF or BigTIFF."""
    big, order = chance.random() < 0.3, chance.choice("<>")
    width, height = _sides(chance, 2**31 - 1)
    samples, bits = chance.choice([(1, 1), (1, 8), (3, 8), (4, 8), (1, 16), (1, 32), (40, 8)])
    packing = chance.choice([1, 8, 8, 8, 5, 32773])
    if bits == 1 and chance.random() < 0.5:
        packing = 4
    tiled = chance.random() < 0.4
    rows = chance.choice([1, 16, height, height, _side(chance, 2**31 - 1)])
    across, down = (_side(chance, 2**20) // 16 * 16 + 16, rows // 16 * 16 + 16) if tiled else (0, 0)
    block = (across * down if tiled else width * min(rows, height)) * samples * bits // 8
    blocks = -(-width // across) * -(-height // down) if tiled else -(-height // rows)
    blocks = min(blocks, 5000)
    data = _deflated_zeros(block) if packing == 8 and block < 4_000_000_000 else bytes(400)
    is_float = bits == 32
    wide = "Q" if big else "I"
    start = 16 if big else 8
    places = start + len(data)
    tags: list[tuple[int, int, int, int]] = [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, 1, bits),
        (259, 3, 1, packing),
        (262, 3, 1, 2 if samples == 3 else 1),
        (277, 3, 1, samples),
        (284, 3, 1, 1),
        (339, 3, 1, 3 if is_float else 1),
    ]
    many = (places, places + 4 * blocks) if blocks > 1 else (start, len(data))
    if tiled:
        tags += [(322, 4, 1, across), (323, 4, 1, down)]
        tags += [(324, 4, blocks, many[0]), (325, 4, blocks, many[1])]
    else:
        tags += [(273, 4, blocks, many[0]), (278, 4, 1, rows), (279, 4, blocks, many[1])]
    body = data
    if blocks > 1:
        body += struct.pack(f"{order}{blocks}I", *[start] * blocks)
        body += struct.pack(f"{order}{blocks}I", *[len(data)] * blocks)
    scale = start + len(body)
    body += struct.pack(f"{order}9d", 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 5e5, 5e6, 0.0)
    tags += [(33550, 12, 3, scale), (33922, 12, 6, scale + 24)]
    directory = start + len(body)
    entries = b""
    for tag, kind, count, value in sorted(tags):
        packed = value
        if order == ">" and kind == 3 and count == 1:
            packed = value << (48 if big else 16)
        elif order == ">" and kind == 4 and count == 1 and big:
            packed = value << 32
        entries += struct.pack(f"{order}HH{wide}{wide}", tag, kind, count, packed)
    head = (b"II" if order == "<" else b"MM") + struct.pack(
        order + ("HHHQ" if big else "HI"), *((43, 8, 0, directory) if big else (42, directory))
    )
    number = struct.pack(order + ("Q" if big else "H"), len(tags))
    # Directories in a circle, or the same one again, mostly none.
    following = struct.pack(order + wide, chance.choice([0, 0, 0, directory]))
    how = f"tiff {width}x{height}x{samples}x{bits} packing {packing} block {block / 1e6:.0f} MB"
    return Bent("a.tif", head + body + number + entries + following, how, width, height)


def webp(chance: random.Random) -> Bent:
    """A canvas that nothing fills, or a small picture that states another size."""
    from PIL import Image

    stream = io.BytesIO()
    Image.new("RGB", (40, 40)).save(stream, "WEBP", lossless=chance.random() < 0.5)
    data = bytearray(stream.getvalue())
    width, height = _sides(chance, 16_383)
    if data[12:16] == b"VP8L":
        (packed,) = struct.unpack_from("<I", data, 21)
        packed = packed & ~0xFFFFFFF | (width - 1) | (height - 1) << 14
        struct.pack_into("<I", data, 21, packed)
    else:
        struct.pack_into("<HH", data, 26, width, height)
    if chance.random() < 0.4:
        width, height = _sides(chance, 1 << 24)
        canvas = (width - 1).to_bytes(3, "little") + (height - 1).to_bytes(3, "little")
        data[12:12] = b"VP8X" + struct.pack("<I", 10) + bytes(4) + canvas
    struct.pack_into("<I", data, 4, len(data) - 8)
    return Bent("a.webp", bytes(data), f"webp {width}x{height}", width, height)


def bmp(chance: random.Random) -> Bent:
    """Run lengths, or a header alone."""
    width, height = _sides(chance, 2**31 - 1)
    bits, packing = chance.choice([(8, 1), (8, 0), (24, 0), (32, 0)])
    rle = b"\xff\0" * 2000 + b"\0\1"
    head = struct.pack("<IiiHHIIiiII", 40, width, height, 1, bits, packing, 0, 0, 0, 256, 0)
    body = bytes(1024 if bits == 8 else 0) + rle
    content = (
        b"BM" + struct.pack("<IHHI", 54 + len(body), 0, 0, 54 + 1024 * (bits == 8)) + head + body
    )
    return Bent("a.bmp", content, f"bmp {width}x{height}", width, height)


def tga(chance: random.Random) -> Bent:
    """Run lengths of any size up to 65,535 pixels a side."""
    width, height = _sides(chance, 65_535)
    kind, bits = chance.choice([(10, 24), (10, 32), (11, 8), (2, 24), (3, 8)])
    body = (b"\xff" + bytes(bits // 8)) * min(width * height // 128 + 1, 20_000)
    content = struct.pack("<BBBHHBHHHHBB", 0, 0, kind, 0, 0, 0, 0, 0, width, height, bits, 0) + body
    return Bent("a.tga", content, f"tga {width}x{height}", width, height)


def large() -> Bent:
    """A valid picture just within the budget of its file, which takes seconds to read."""
    side = 11_000
    data = _deflated_zeros(side * (1 + 3 * side))
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    content = b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", data)
    return Bent("a.png", content + _chunk(b"IEND", b""), "large png", side, side, is_valid=True)


MAKERS: list[Callable[[random.Random], Bent]] = [png, tiff, jpeg, tiff, webp, png, tiff, bmp, tga]


def make(number: int, seed: int) -> Bent:
    """Return the picture of a number."""
    return MAKERS[number % len(MAKERS)](random.Random(f"{seed} {number}"))


# --- reading --------------------------------------------------------------------------------------
def _photo(path: Path) -> object:
    from vomstudio.io.photos.pixels import grey, thumbnail
    from vomstudio.io.photos.reading import read_photo

    return read_photo(path), thumbnail(path).shape, grey(path).shape


def _mask(path: Path) -> object:
    from vomstudio.io.photos.drawn_masks import load_mask

    return load_mask(path, 32, 24).shape


def _texture(path: Path) -> object:
    from vomstudio.rendering.prepare.textures import TextureProblem, load_texture

    try:
        return len(load_texture(path, 4096).levels)
    except TextureProblem as problem:
        return _refused(str(problem), path)


def _orthophoto(path: Path) -> object:
    from vomstudio.products.ortho.textures import load_pyramid

    pyramid = load_pyramid(path, 0)
    return None if pyramid is None else pyramid.size


def _decoded(path: Path) -> object:
    import cv2

    from vomstudio.core.files.untrusted.pictures import decode_picture

    pixels = decode_picture(path.read_bytes(), cv2.IMREAD_COLOR, str(path))
    return None if pixels is None else pixels.shape


def _info(path: Path) -> object:
    from vomstudio.cli.info import _describe_picture as picture

    return picture(path)["width"]


def _heights(path: Path) -> object:
    from vomstudio.io.models.opening import read_model

    return len(read_model(path).data.vertices)


def _place(path: Path) -> object:
    from vomstudio.io.gis.raster_georeference import read_map_placement

    return read_map_placement(path)


def _refused(message: str, path: Path) -> object:
    from vomstudio.core.errors import InputError

    raise InputError(message, file=None if path.name in message else path)


READERS: dict[str, Callable[[Path], object]] = {
    "photo": _photo,
    "mask": _mask,
    "texture": _texture,
    "orthophoto": _orthophoto,
    "decoded": _decoded,
    "info": _info,
    "heights": _heights,
    "place": _place,
}
_ONLY_TIFF = {"heights", "place"}
_WHOLE = {"photo", "texture", "decoded"}
"""Readers that read a valid picture, if it is of a format of theirs."""


def _status(name: str) -> int:
    for line in Path("/proc/self/status").read_text("ascii").splitlines():
        if line.startswith(name):
            return int(line.split()[1]) * 1024
    raise OSError(f"no {name}")


def serve() -> None:
    """Read the files that are named on stdin, one after the other; a JSON for each reader."""
    from vomstudio.core.errors import VomError

    small = Path(sys.stdin.readline().strip())
    # What is imported, and compiled, is not a file's.
    for path in sorted(small.iterdir()):
        for name, reader in READERS.items():
            if name not in _ONLY_TIFF or path.suffix == ".tif":
                try:
                    reader(path)
                except VomError:
                    continue
    print("ready", flush=True)
    for line in sys.stdin:
        name, _, told = line.strip().partition(" ")
        # Resets the highest resident memory (proc(5)).
        Path("/proc/self/clear_refs").write_text("5")
        before, begun, path = _status("VmRSS"), time.monotonic(), Path(told)
        code, message = "read", ""
        try:
            found = READERS[name](path)
            code = "read" if found is not None else "left out"
        except VomError as error:
            code, message = error.code, str(error)
        except BaseException as error:  # noqa: BLE001 - that is what is looked for
            place = traceback.extract_tb(error.__traceback__)[-1]
            code, message = "ERROR", f"{error!r:.100} ({place.filename}:{place.lineno})"
        print(
            json.dumps([code, message, time.monotonic() - begun, _status("VmHWM") - before]),
            flush=True,
        )


class Reader:
    """The process that reads; a new one if it does not answer in time."""

    def __init__(self, small: Path) -> None:
        self._small = small
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> Reader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def read(self, name: str, path: Path) -> tuple[str, str, float, int]:
        """Return code, message, seconds and bytes of memory."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "tests.fuzz.bent_pictures", "--child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
            self._say(str(self._small))
            self._hear(300.0)
        self._say(f"{name} {path}")
        line = self._hear(2 * MAX_S)
        if not line:
            self.close()
            return "ERROR", "ended, or hung", 2 * MAX_S, 0
        code, message, seconds, memory = json.loads(line)
        return code, message, seconds, memory

    def _say(self, line: str) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def _hear(self, patience_s: float) -> str:
        assert self._process is not None
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], [], [], patience_s)
        return self._process.stdout.readline() if ready else ""


def _readers_of(name: str) -> Iterator[str]:
    for reader in READERS:
        if reader not in _ONLY_TIFF or name.endswith(".tif"):
            yield reader


def _write_small(folder: Path) -> None:
    from PIL import Image

    folder.mkdir()
    for name in ("s.png", "s.jpg", "s.tif", "s.webp", "s.bmp", "s.tga"):
        Image.new("RGB", (40, 40)).save(folder / name)


def campaign(count: int, seed: int, report: Report = str) -> Outcome:
    """Read so many files by all their readers.

    Returns
    -------
    Outcome
        Codes of the answers, and the broken promises.
    """
    from vomstudio.core.files.untrusted.budgets import decoding_limit

    counts: Counter[str] = Counter()
    wrong: list[str] = []
    slowest = largest = share = 0.0
    with tempfile.TemporaryDirectory() as made, Reader(Path(made, "small")) as reading:
        _write_small(Path(made, "small"))
        for number in until_stopped(range(count)):
            bent = make(number, seed)
            path = Path(made, bent.name)
            path.write_bytes(bent.content)
            budget = decoding_limit(len(bent.content))
            for name in _readers_of(bent.name):
                code, message, seconds, memory = reading.read(name, path)
                counts[code] += 1
                slowest, largest = max(slowest, seconds), max(largest, memory)
                share = max(share, memory / budget)
                said = ""
                if code == "ERROR":
                    said = message
                elif seconds > MAX_S:
                    said = f"took {seconds:.0f} s"
                elif memory > ALLOWED * budget + FREE_BYTES:
                    said = f"took {memory / 1e6:.0f} MB of {budget / 1e6:.0f} MB"
                elif code not in ("read", "left out") and path.name not in message:
                    said = f"refused without its name: {message}"
                elif (
                    code != "read"
                    and name in _WHOLE
                    and bent.is_valid
                    and 8 * bent.width * bent.height < budget
                    and max(bent.width, bent.height) <= MAX_SIDE
                ):
                    said = f"not read: {message}"
                if said:
                    wrong.append(f"{number} ({bent.how}), {name}: {said}")
                    report(wrong[-1])
            path.unlink()
    report(
        f"slowest {slowest:.1f} s, most memory {largest / 1e6:.0f} MB,"
        f" largest share of a budget {share:.2f}"
    )
    return counts, wrong


def signals(count: int, seed: int, report: Report = str) -> list[str]:
    """End the command while it reads pictures, and return the broken promises."""
    with tempfile.TemporaryDirectory() as made:

        def prepare(number: int) -> tuple[list[str], str]:
            bent = make(number, seed) if number % 2 else large()
            folder = Path(made, str(number))
            folder.mkdir()
            for copy in range(3):
                (folder / f"{copy}{bent.name}").write_bytes(bent.content)
            return ["check", str(folder)], bent.how

        return campaigns.end_by_signals(count, seed, 3.0, prepare, report)


def main() -> int:
    parser = campaigns.parser(__doc__)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        serve()
        return 0
    return campaigns.run(options, campaign, signals)


if __name__ == "__main__":
    sys.exit(main())
