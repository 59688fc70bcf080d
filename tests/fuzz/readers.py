"""Files of every kind that is read, sound ones made by our own writers, bent and swollen.

    python -m tests.fuzz.readers --files 10000 [--seed N] [--only WORD]

Each file is read in a process with little memory and little time. What ends in an error that is
none of ours, takes too long or too much, or is refused without naming the file, is printed, and is
kept in a folder that is named at the end; the exit code is then 1. `corpus` holds those that once
did; they are read before all others.
"""

from __future__ import annotations

import argparse
import io
import json
import multiprocessing
import random
import resource
import shutil
import struct
import sys
import tempfile
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

CORPUS = Path(__file__).with_name("corpus")
LONGEST_S = 5.0
FREE_BYTES = 500 << 20
_TOKENS = [
    b"\0", b"\xff", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"\0\0\0\x80", b"-1", b"1e999",
    b"nan",
    b"99999999999999999999", b"\n", b" ", b",", b"'", b'"', b"[", b"{", b"<", b">", b"/", b"../",
    b"%",
    b"4294967295", b"0", b"\xed\xa0\x80", b"\xef\xbb\xbf",
]  # fmt: skip


# --- seeds ------------------------------------------------------------------------------------
def seeds() -> dict[str, bytes]:
    """Small sound files by their names: models, tables, photos, control, cameras, settings, XMP."""
    with tempfile.TemporaryDirectory() as place:
        found = {**_models(Path(place)), **_pictures(), **_texts()}
    return found


def _models(folder: Path) -> dict[str, bytes]:
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.writing import write_model

    chance = np.random.default_rng(1)
    x, y = (a.ravel() for a in np.meshgrid(np.arange(8.0), np.arange(8.0)))
    points = np.column_stack([x, y, chance.random(64)]) + [500000.0, 5200000.0, 800.0]
    corner = np.array([i for i in range(55) if i % 8 < 7])
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 8], 1),
            np.stack([corner + 1, corner + 9, corner + 8], 1),
        ]
    ).astype(np.int32)
    mesh = Mesh(points, faces)
    cloud = PointCloud(points, chance.integers(0, 255, (64, 3)).astype(np.uint8))
    for name in ("a.obj", "a.ply", "a.glb"):
        write_model(mesh, "EPSG:32632", folder / name)
    for name in ("b.las", "b.laz", "b.xyz", "b.ply"):
        write_model(cloud, "EPSG:32632", folder / name)
    found = {p.name: p.read_bytes() for p in folder.iterdir() if p.suffix not in (".prj", ".txt")}
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 1, *(points[f] - points[0]).ravel(), 0) for f in faces
    )
    found["a.stl"] = bytes(80) + struct.pack("<I", len(faces)) + triangles
    import rasterio
    from rasterio import Affine

    with rasterio.open(
        folder / "c.tif", "w", driver="GTiff", width=16, height=16, count=1, dtype="float32",
        crs="EPSG:32632", transform=Affine(1, 0, 500000, 0, -1, 5200000), compress="deflate",
    ) as file:  # fmt: skip
        file.write(chance.random((1, 16, 16), np.float32))
    return found | {"c.tif": (folder / "c.tif").read_bytes()}


def _pictures() -> dict[str, bytes]:
    from PIL import Image

    made = {}
    pixels = np.random.default_rng(2).integers(0, 255, (24, 32, 3)).astype(np.uint8)
    xmp = (
        b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf='
        b'"http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description xmlns:drone-dji='
        b'"http://www.dji.com/drone-dji/1.0/" drone-dji:GimbalYawDegree="10.5" '
        b'drone-dji:GimbalPitchDegree="-30.0"/></rdf:RDF></x:xmpmeta>'
    )
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "DJI", "FC3582", 6
    exif.get_ifd(0x8769).update({0x920A: 6.72, 0xA405: 24})
    exif.get_ifd(0x8825).update({1: "N", 2: (46.0, 30.0, 1.5), 3: "E", 4: (7.0, 0.0, 1.0)})
    for name, kind in (("p.jpg", "JPEG"), ("p.png", "PNG"), ("p.tiff", "TIFF")):
        stream = io.BytesIO()
        options = {} if kind == "PNG" else {"xmp": xmp}
        Image.fromarray(pixels).save(stream, kind, exif=exif, **options)
        made[name] = stream.getvalue()
    return made


def _texts() -> dict[str, bytes]:
    lens = {"model": "PINHOLE", "width": 40, "height": 30, "params": [40.0, 40.0, 20.0, 15.0]}
    view = {"name": "p.jpg", "rotation": np.eye(3).tolist(), "translation": [0.0, 0.0, 5.0], **lens}
    cameras = {
        "format": "vomstudio cameras", "version": 1, "crs": None, "scaled": True,
        "origin": [0, 0, 0], "photos": ".", "views": [view],
    }  # fmt: skip
    return {
        "t.csv": b'id,strike,dip,set,note\n1,30,45,S0,a\n2,120,60,S0,"b, c"\n3,211.5,88,J1,\'=d\n',
        "control.csv": b"label,x,y,z,sigma,use\na,500000,5200000,800,0.02,control\n"
        b"b,500010,5200000,801,0.02,check\n",
        "marks.csv": b"label,photo,x,y\na,p.jpg,10.5,11\nb,p.jpg,20,3.25\n",
        "gcp_list.txt": b"EPSG:32632\n500000 5200000 800 10 11 p.jpg a\n"
        b"500010 5200000 801 3 4 p.jpg b\n",
        "cameras.json": json.dumps(cameras).encode(),
        "settings.toml": b"[measuring]\nmethod = 'pca'\n",
        "d.xml": b"<document><chunks/></document>",
    }


# --- bending ----------------------------------------------------------------------------------
def mutated(data: bytes, others: list[bytes], chance: random.Random) -> bytes:
    """Changed in one to eight places: bits, numbers, words, pieces out, again, or of others."""
    made = bytearray(data)
    for _ in range(chance.choice([1, 1, 1, 2, 3, 8])):
        # Headers decide more than what follows them.
        limit = len(made) if chance.random() < 0.5 else min(len(made), 400)
        at = chance.randrange(limit) if limit else 0
        what = chance.randrange(8)
        if what == 0 and made:
            made[at] ^= 1 << chance.randrange(8)
        elif what == 1:
            made[at : at + 4] = chance.choice(_TOKENS)
        elif what == 2:
            made[at:at] = chance.choice(_TOKENS) * chance.choice([1, 2, 100, 20_000])
        elif what == 3:
            del made[at : at + chance.choice([1, 4, 64, 4096])]
        elif what == 4:
            del made[at:]
        elif what == 5:
            piece = bytes(made[at : at + chance.choice([4, 40, 400])])
            made[at:at] = piece * chance.choice([1, 3, 2000])
        elif what == 6:
            other = chance.choice(others)
            begin = chance.randrange(len(other))
            made[at:at] = other[begin : begin + chance.choice([4, 100, 1000])]
        else:
            number = chance.choice([0, 1, 2**16 - 1, 2**31 - 1, 2**32 - 1, 2**63])
            made[at : at + 8] = struct.pack(chance.choice("<>") + "Q", number)
    return bytes(made)


# --- reading ----------------------------------------------------------------------------------
def _read(path: Path) -> None:
    from vomstudio.io.control.control_files import read_control
    from vomstudio.io.models.opening import read_model
    from vomstudio.io.photos.cameras_file import read_cameras
    from vomstudio.io.photos.pixels import thumbnail
    from vomstudio.io.photos.reading import read_photo
    from vomstudio.io.settings import read_settings
    from vomstudio.io.text.orientation_reading import read_orientations

    name, ending = path.name, path.suffix
    if ending in (".jpg", ".png", ".tiff"):
        read_photo(path)
        thumbnail(path)
    elif name == "cameras.json":
        read_cameras(path)
    elif name == "t.csv":
        read_orientations(path)
    elif name == "settings.toml":
        read_settings(path)
    elif ending in (".csv", ".txt", ".xml") and name != "b.xyz":
        read_control(path)
    else:
        read_model(path)


def _outcome(path: Path) -> str:
    from vomstudio.errors import VomError

    begun = time.monotonic()
    try:
        _read(path)
        found = "read"
    except VomError as error:
        found = "refused" if path.name in str(error) else f"REFUSED WITHOUT ITS NAME: {error}"
    except MemoryError:
        found = "TOO MUCH MEMORY"
    except Exception as error:  # noqa: BLE001 - that is what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        found = (
            f"ERROR {type(error).__name__}: {str(error)[:100]} ({place.filename}:{place.lineno})"
        )
    spent = time.monotonic() - begun
    return found if spent < LONGEST_S else f"TOOK {spent:.0f} s"


def _serve(link) -> None:  # type: ignore[no-untyped-def]
    """Reads what it is told to, until it is told nothing."""
    while (path := link.recv()) is not None:
        held = _held()
        limit = held + FREE_BYTES + 20 * path.stat().st_size
        resource.setrlimit(resource.RLIMIT_DATA, (limit, resource.RLIM_INFINITY))
        link.send(_outcome(path))
        resource.setrlimit(resource.RLIMIT_DATA, (resource.RLIM_INFINITY,) * 2)


def _held() -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData"):
            return int(line.split()[1]) * 1024
    return 1 << 32


class Reader:
    """A process that reads files; another one takes its place when it dies or hangs."""

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        self._link, theirs = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("spawn").Process(
            target=_serve, args=(theirs,), daemon=True
        )
        self._process.start()
        theirs.close()
        self._fresh = True

    def outcome(self, path: Path) -> str:
        self._link.send(path)
        try:
            # The first file of a process waits for imports.
            if self._link.poll(LONGEST_S * (12 if self._fresh else 4)):
                self._fresh = False
                return str(self._link.recv())
            said = "HANGS"
        except (EOFError, OSError):
            self._process.join()
            said = f"CRASHED ({self._process.exitcode})"
        self._process.kill()
        self._process.join()
        self._start()
        return said

    def close(self) -> None:
        self._process.kill()
        self._process.join()


def campaign(
    count: int, seed: int, *, only: str = "", keep: Callable[[str, bytes], None] | None = None
) -> tuple[Counter[str], list[str]]:
    """How many files were read and refused, and a line for each that did what none may do."""
    sound = {name: data for name, data in seeds().items() if only in name}
    names, counts, wrong = sorted(sound), Counter[str](), list[str]()
    reader = Reader()
    try:
        with tempfile.TemporaryDirectory() as place:
            given = [(p.name.partition("-")[2], p.read_bytes()) for p in sorted(CORPUS.glob("*"))]
            given += [(name, sound[name]) for name in names]
            for number in range(len(given) + count):
                if number < len(given):
                    name, data = given[number]
                else:
                    chance = random.Random(f"{seed} {number - len(given)}")
                    name = chance.choice(names)
                    data = mutated(sound[name], list(sound.values()), chance)
                path = Path(place) / name
                path.write_bytes(data)
                found = reader.outcome(path)
                path.unlink(missing_ok=True)
                counts[found if found.islower() else "wrong"] += 1
                if not found.islower():
                    wrong.append(f"{number} {name} ({len(data)} bytes): {found}")
                    if keep is not None:
                        keep(f"{zlib.crc32(data):08x}-{name}", data)
    finally:
        reader.close()
    return counts, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="part of a seed's name")
    asked = parser.parse_args()
    kept = Path(tempfile.mkdtemp(prefix="vom-fuzz-"))
    begun = time.monotonic()
    counts, wrong = campaign(
        asked.files, asked.seed, only=asked.only, keep=lambda n, d: _keep(kept / n, d)
    )
    print(f"{sum(counts.values())} files in {time.monotonic() - begun:.0f} s: {dict(counts)}")
    for line in wrong:
        print("  ", line)
    if wrong:
        print("kept in", kept)
    else:
        shutil.rmtree(kept)
    return min(len(wrong), 1)


def _keep(path: Path, data: bytes) -> None:
    path.write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
