"""Folders that somebody has prepared: what readers find by name, beside a sound file or in its
place, is a pipe, a device without an end, a folder, a link into nothing, into a circle or to
something else, a file of no sense or of any size; an archive of arrays lies about its members; and
names are no UTF-8.

    python -m tests.fuzz.hostile [--cases 2000] [--seed N] [--only WORD]

Each case is read as in `readers`, with which it shares its limits; 0 cases are all there are.
Prints how many were read and refused, and each that did what none may do; the exit code is then 1.
"""

from __future__ import annotations

import argparse
import io
import os
import random
import shutil
import struct
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.fuzz.kinds import READERS, Files, seeds
from tests.fuzz.readers import Reader, lay

SIDES = (
    ".prj",
    ".qpj",
    ".tfw",
    ".tifw",
    ".wld",
    ".aux.xml",
    ".ovr",
    ".msk",
    ".offset.txt",
    ".xmp",
    ".mtl",
    ".png",
    ".jpg",
    ".cpg",
    ".dbf",
    ".shx",
    ".sbn",
    ".sbx",
    ".qix",
    ".idm",
    ".ind",
    ".json",
    ".txt",
    ".csv",
    ".IMD",
    ".RPB",
    "_RPC.TXT",
    "_rpc.txt",
    "_metadata.xml",
    "_mask.png",
    ".geom",
)
"""Endings that stand in the place of a file's own."""
BEHIND = (".aux.xml", ".ovr", ".msk", ".xmp", ".prj", "-wal", "-journal", "-shm", ".properties")
"""Endings that come behind it."""
IN_FOLDER = (
    "masks",
    "geo.txt",
    "gcp_list.txt",
    "cameras.json",
    "cameras.xml",
    "cameras.txt",
    "points3D.txt",
    "control.csv",
    "marks.csv",
    "settings.ini",
    "settings.toml",
    "metadata.xml",
    "stage.json",
    "request.json",
    "lock",
    "lock-journal",
    "project.gpkg",
    "json.py",
    "METADATA.DIM",
)
LARGE = 1 << 36


# --- what lies where a file should --------------------------------------------------------------
def _pipe(place: Path) -> None:
    os.mkfifo(place)


def _folder(place: Path) -> None:
    place.mkdir()


def _endless(place: Path) -> None:
    place.symlink_to("/dev/zero")


def _circle(place: Path) -> None:
    place.symlink_to(place.name)


def _nowhere(place: Path) -> None:
    place.symlink_to("../../none/at all")


def _up(place: Path) -> None:
    place.symlink_to("..")


def _large(place: Path) -> None:
    with place.open("wb") as file:
        file.truncate(LARGE)


def _nested(place: Path) -> None:
    place.write_bytes(b"<a>" * 200_000 + b"[" * 200_000)


def _no_text(place: Path) -> None:
    place.write_bytes(bytes(range(256)) * 40)


def _asking(place: Path) -> None:
    """Names of files and addresses wherever something is looked for."""
    place.write_bytes(
        b'<PAMDataset><Metadata domain="SUBDATASETS"><MDI key="SUBDATASET_1_NAME">/vsicurl/'
        b"http://127.0.0.1:9/a</MDI></Metadata><PAMRasterBand><Overview file='/dev/zero'/>"
        b"</PAMRasterBand></PAMDataset>\nmtllib ../../../dev/zero\nmap_Kd /dev/zero\n"
        b"newmtl a\nmap_Kd /dev/zero\nmap_Kd ../../x.png\nmap_Kd C:\\x.png\n"
    )


NATURES: dict[str, Callable[[Path], None]] = {
    "a pipe": _pipe,
    "a folder": _folder,
    "without an end": _endless,
    "a circle": _circle,
    "a link into nothing": _nowhere,
    "a link upwards": _up,
    "64 GB of nothing": _large,
    "nested": _nested,
    "no text": _no_text,
    "asking for others": _asking,
}


# --- archives -----------------------------------------------------------------------------------
def archives(data: bytes) -> Iterator[tuple[str, bytes]]:
    """A sound .npz with one lie each: how, and the file."""
    with zipfile.ZipFile(io.BytesIO(data)) as sound:
        members = [(info.filename, sound.read(info)) for info in sound.infolist()]

    def packed(rows: list[tuple[str, bytes]], how: int = zipfile.ZIP_STORED) -> bytes:
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", how) as made:
            for name, content in rows:
                made.writestr(name, content)
        return stream.getvalue()

    def patched(data: bytes, sign: bytes, offset: int, form: str, value: int) -> bytes:
        made, at = bytearray(data), data.find(sign)
        while at >= 0:
            struct.pack_into(form, made, at + offset, value)
            at = data.find(sign, at + 4)
        return bytes(made)

    def shaped(content: bytes, shape: bytes) -> bytes:
        before, _, after = content.partition(b"'shape': (")
        return before + b"'shape': (" + shape + b")" + after.partition(b")")[2][len(shape) :]

    plain = packed(members)
    local, central = b"PK\x03\x04", b"PK\x01\x02"
    yield "a bomb", packed([(n, c + bytes(1 << 27)) for n, c in members[:1]], zipfile.ZIP_DEFLATED)
    yield "encrypted", patched(patched(plain, local, 6, "<H", 1), central, 8, "<H", 1)
    yield "of an unknown method", patched(patched(plain, local, 8, "<H", 99), central, 10, "<H", 99)
    yield "bzip2", packed(members, zipfile.ZIP_BZIP2)
    yield "with a member of 4 GB", patched(plain, central, 24, "<I", 2**32 - 2)
    yield "overlapping", patched(plain, central, 42, "<I", 0)
    yield "pointing behind its end", patched(plain, central, 42, "<I", 2**31)
    yield "of wrong sums", patched(plain, central, 16, "<I", 7)
    for what, name in (
        ("above", "../{}"),
        ("absolute", "/etc/{}"),
        ("of Windows", "C:\\{}"),
        ("ending", "{}\0"),
    ):
        yield f"with names {what}", packed([(name.format(n), c) for n, c in members])
    yield "with a name that is no UTF-8", plain.replace(members[0][0].encode()[:2], b"\xff\xfe")
    yield "with a member twice", _silently(lambda: packed([*members, *members]))
    yield "of 20,000 members", packed([(f"{k}.npy", b"") for k in range(20_000)])
    for shape in (b"9999999999,", b"-1,", b"99999, 99999", b"0,", b"True,", b"'a',", b"1.5,"):
        yield f"of shape {shape.decode()}", packed([(n, shaped(c, shape)) for n, c in members])
    for kind in (b"|O", b"<U9", b"<c8", b"|V8", b"<M8"):
        rows = [(n, c.replace(b"'<f8'", b"'" + kind + b"'")) for n, c in members]
        yield f"of {kind.decode()}", packed(rows)
    yield "of empty members", packed([(n, b"") for n, _ in members])


def _silently(make: Callable[[], bytes]) -> bytes:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return make()


# --- cases --------------------------------------------------------------------------------------
Case = tuple[str, str, Callable[[Path], Path]]
"""Kind, in words, and what lays it into a folder and names the file to read."""


def cases(sound: dict[str, Files]) -> list[Case]:
    """All of them, in one order."""
    found: list[Case] = []
    for kind, files in sound.items():
        main = READERS[kind][0]
        stem, _, _ = main.rpartition(".")
        own = [name for name in files if name != main]
        folder = main.rpartition("/")[0]
        beside = [stem + end for end in SIDES] + [main + end for end in BEHIND]
        beside += [f"{folder}/{name}" if folder else name for name in IN_FOLDER]
        for place in dict.fromkeys([main, *own, *beside]):
            for nature, put in NATURES.items():
                found.append((kind, f"{place} is {nature}", _replacing(files, main, place, put)))
        for name, data in files.items():
            if name.endswith(".npz"):
                for how, made in archives(data):
                    changed = {**files, name: made}
                    found.append((kind, f"{name} {how}", _replacing(changed, main, "", None)))
        if "/" not in main and kind not in _NAMED:
            found.append((kind, "a name that is no UTF-8", _named(files, main, b"\xff\xe9 ")))
            found.append((kind, "a name of two lines", _named(files, main, b"a\nb ")))
    return found


_NAMED = {"journal.sqlite", "meta.json", "scene.npz", "images.txt", "drawn.svg"}
"""Kinds that are found by their name."""


def _replacing(
    files: Files, main: str, place: str, put: Callable[[Path], None] | None
) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        lay({name: data for name, data in files.items() if name != place}, folder)
        if put is not None:
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            put(folder / place)
        return folder / main

    return make


def _named(files: Files, main: str, before: bytes) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        lay(files, folder)
        named = folder / os.fsdecode(before + os.fsencode(main))
        (folder / main).rename(named)
        return named

    return make


def campaign(count: int, seed: int, only: str = "") -> tuple[Counter[str], list[str]]:
    """count : how many of all cases, 0 for all."""
    chosen = cases({kind: files for kind, files in seeds().items() if only in kind})
    random.Random(f"hostile {seed}").shuffle(chosen)
    counts, wrong = Counter[str](), list[str]()
    reader = Reader()
    try:
        with tempfile.TemporaryDirectory() as made:
            for number, (kind, words, make) in enumerate(chosen[: count or None]):
                folder = Path(made) / f"f{number}.vom"
                folder.mkdir()
                around = _tree(Path(made))
                main = make(folder)
                found, _ = reader.outcome(kind, folder, main=main)
                if _tree(Path(made)) != around:
                    found = f"WROTE BESIDE {_tree(Path(made)) ^ around}"
                shutil.rmtree(folder)
                counts[found if found.islower() else "wrong"] += 1
                if not found.islower():
                    wrong.append(f"{kind}: {words}: {found}")
    finally:
        reader.close()
    return counts, wrong


def _tree(folder: Path) -> set[str]:
    return set(os.listdir(folder))


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="part of a kind's name")
    asked = parser.parse_args()
    begun = time.monotonic()
    counts, wrong = campaign(asked.cases, asked.seed, asked.only)
    print(f"{counts.total()} cases in {time.monotonic() - begun:.0f} s: {dict(counts)}")
    for line in wrong:
        print("  ", line)
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
