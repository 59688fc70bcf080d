"""Files of other projects, such as the test data of their source packages: read as they are, then
bent and swollen as those of `readers`.

    python -m tests.fuzz.others DIR --files 4000 [--seed N] [--only ENDING]

DIR : is searched with all folders below it, for files of endings that are read. A file is read with
those that lie beside it under its name, and where it names others, with all of its folder. What no
reader may do is printed and kept, as `readers` does.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

from tests.fuzz.kinds import READERS, SEALED, Files, seeds
from tests.fuzz.readers import Reader, lay, mutated
from tests.fuzz.stopping import until_stopped

KINDS = {
    ".obj": "a.obj",
    ".ply": "a.ply",
    ".glb": "a.glb",
    ".gltf": "a.gltf",
    ".stl": "a.stl",
    ".las": "b.las",
    ".laz": "b.laz",
    ".xyz": "b.xyz",
    ".pts": "b.xyz",
    ".ptx": "s.ptx",
    ".asc": "c.tif",
    ".tif": "c.tif",
    ".jpg": "p.jpg",
    ".jpeg": "p.jpg",
    ".png": "p.png",
    ".tiff": "p.tiff",
    ".webp": "t.webp",
    ".bmp": "t.bmp",
    ".tga": "t.tga",
    ".csv": "t.csv",
    ".txt": "slips.txt",
    ".xml": "cameras.xml",
    ".json": "cameras.json",
    ".geojson": "l.geojson",
    ".gpkg": "l.gpkg",
    ".shp": "l.shp",
    ".dxf": "l.dxf",
    ".kml": "k.kml",
    ".svg": "drawn.svg",
    ".copc.laz": "d.copc.laz",
    ".e57": "e.e57",
}
"""Whose reader takes files of an ending."""
_NAME_OTHERS = (".obj", ".gltf")
_LARGEST, _MOST_OF_A_KIND = 2 << 20, 60


def found_in(folder: Path, only: str = "") -> dict[str, list[tuple[str, Files]]]:
    """By ending: name and files of each, no more than some of an ending from every folder tree."""
    found = defaultdict(list)
    for path in sorted(folder.rglob("*")):
        ending = ".copc.laz" if path.name.endswith(".copc.laz") else path.suffix.lower()
        if KINDS.get(ending) not in READERS or (only and ending != only):
            continue
        if path.is_symlink() or not path.is_file() or not 0 < path.stat().st_size <= _LARGEST:
            continue
        found[ending].append(path)
    chance = random.Random("others")
    return {
        ending: [
            (path.name, _with_others(path, ending))
            for path in chance.sample(paths, min(len(paths), _MOST_OF_A_KIND))
        ]
        for ending, paths in found.items()
    }


def _with_others(path: Path, ending: str) -> Files:
    beside = path.parent.iterdir() if ending in _NAME_OTHERS else path.parent.glob("*.*")
    files, size = {path.name: path.read_bytes()}, 0
    for other in sorted(beside):
        named = ending in _NAME_OTHERS or other.stem == path.stem
        if not named or not other.is_file() or other.is_symlink() or other.name in files:
            continue
        size += other.stat().st_size
        if size > _LARGEST:
            break
        files[other.name] = other.read_bytes()
    return files


def campaign(
    folder: Path,
    count: int,
    seed: int,
    *,
    only: str = "",
    keep: Callable[[str, bytes], None] | None = None,
) -> tuple[Counter[str], list[str]]:
    """How many files were read and refused, and a line for each that did what none may do."""
    known = found_in(folder, only)
    pieces = [files[name] for group in known.values() for name, files in group]
    sidecar = seeds()["drawn.svg"]["drawn.json"]
    chance = random.Random(f"others {seed}")
    given = [(ending, name, files) for ending, group in known.items() for name, files in group]
    counts, wrong = Counter[str](), list[str]()
    reader = Reader()
    try:
        with tempfile.TemporaryDirectory() as made:
            for number in until_stopped(range(len(given) + count if given else 0)):
                if number < len(given):
                    ending, name, files = given[number]
                else:
                    ending = chance.choice(list(known))
                    name, files = chance.choice(known[ending])
                    bent = mutated(files[name], pieces, chance)
                    files = {**files, name: SEALED.get(ending, bytes)(bent)}
                if ending == ".svg":
                    files = {**files, f"{Path(name).stem}.json": sidecar}
                place = Path(made) / f"f{number}"
                lay(files, place)
                found, _ = reader.outcome(KINDS[ending], place, main=place / name)
                shutil.rmtree(place)
                counts[found if found.islower() else "wrong"] += 1
                if not found.islower():
                    wrong.append(f"{number} {name} ({len(files[name])} bytes): {found}")
                    if keep is not None:
                        keep(f"{zlib.crc32(files[name]):08x}-{name}", files[name])
    finally:
        reader.close()
    return counts, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--files", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", metavar="ENDING")
    asked = parser.parse_args()
    kept = Path(tempfile.mkdtemp(prefix="vom-fuzz-"))

    def keep(name: str, data: bytes) -> None:
        (kept / name).write_bytes(data)

    begun = time.monotonic()
    counts, wrong = campaign(asked.folder, asked.files, asked.seed, only=asked.only, keep=keep)
    print(f"{sum(counts.values())} files in {time.monotonic() - begun:.0f} s: {dict(counts)}")
    for line in wrong:
        print("  ", line)
    if wrong:
        print("kept in", kept)
    else:
        kept.rmdir()
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
