"""Files of every kind, swollen to hundreds of megabytes: what each costs to read or refuse.

    python -m tests.fuzz.swollen [--megabytes 300] [--only WORD] [--way WORD] [--dir FOLDER]

Each file is read in a process of its own. Printed are what became of it, seconds, the most memory
over what the process held before, the same as a share of what is allowed (twice the file, and
500 MB), and how long a second reading went on after SIGINT, which is sent halfway. WRONG stands
where one of them is more than is promised; the exit code is then 1.

Ways: `sound`, one large model or raster (of which what is allowed may be that of the file decoded);
`more`, sound content again and again; `line`, one line or word without an end; `cells`, one
line of many; `blank`, zeros where content is expected; `spaces`, likewise, which texts may have
anywhere; `tail`, bytes by chance after the sound end.
"""

from __future__ import annotations

import argparse
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import psutil

from tests.fuzz.kinds import READERS, Files, seeds
from tests.fuzz.readers import FREE_BYTES, lay
from tests.fuzz.sound_models import MADE

LONGEST_END_S = 5.0
LONGEST_S = 300.0
_PIECE = 1 << 20
_POLL_S = 0.02

_UNITS = {
    "a.gltf": (rb'\{"mesh": 0, "scale": \[1, 2, 3\]\}', b", "),
    "s.stl": (rb"facet normal.*?endfacet\n", b""),
    "d.xml": (rb"<marker .*?</marker>", b""),
    "app.xml": (rb"<OneAppuisDAF>.*?</OneAppuisDAF>", b""),
    "markers.xml": (rb"<OneMesureAF1I>.*?</OneMesureAF1I>", b""),
    "k.kml": (rb"<Placemark>.*?</Placemark>", b""),
    "area.geojson": (rb'\{"type": "Feature", .*\}(?=\])', b", "),
    "contacts.geojson": (rb'\{"type": "Feature", .*\}(?=\])', b", "),
    "l.geojson": (rb'\{ "type": "Feature", .*? \] \} \}', b",\n"),
    "shots.geojson": (rb'\{"type": "Feature", .*?\}\}', b", "),
    "cameras.json": (rb'\{"name": "p.jpg".*?\}', b", "),
    "cameras.xml": (rb"<camera .*?</camera>", b""),
    "drawn.svg": (rb"<path .*?/>", b""),
    "l.dxf": (rb"  0\r?\nLWPOLYLINE.*?(?=  0\r?\n(?:LWPOLYLINE|ENDSEC))", b""),
    "x.xmp": (rb"<rdf:Description.*?/>", b""),
    "meta.json": (rb'"', b' ", "'),
    "r.registration.json": (rb'"P1"', b", "),
    "run/reconstruction.json": (rb'"residuals": \[', b"1.5, "),
}
"""Of texts that are no lists of lines: a piece that may come again, and what stands between."""
_LINES = (".csv", ".txt", ".obj", ".xyz", ".toml")


@dataclass(frozen=True)
class Swollen:
    """write puts the main file, of so many bytes or a few more; how many it has once decoded, where
    these are known"""

    kind: str
    way: str
    write: Callable[[Path, int], int]


def _repeated(file: BinaryIO, piece: bytes, size: int) -> None:
    block = piece * max(1, _PIECE // max(len(piece), 1))
    for _ in range(size // len(block) + 1):
        file.write(block)


def _between(head: bytes, piece: bytes, end: bytes) -> Callable[[Path, int], int]:
    def write(path: Path, size: int) -> int:
        with open(path, "wb") as file:
            file.write(head)
            _repeated(file, piece, size)
            file.write(end)
        return 0

    return write


def _by_chance(head: bytes) -> Callable[[Path, int], int]:
    def write(path: Path, size: int) -> int:
        chance = np.random.default_rng(0)
        with open(path, "wb") as file:
            file.write(head)
            for _ in range(size // _PIECE):
                file.write(chance.bytes(_PIECE))
        return 0

    return write


def swollen(kind: str, files: Files) -> Iterator[Swollen]:
    """All ways in which a file of this kind is swollen."""
    name = READERS[kind][0]
    data = files[name]
    half = len(data) // 2
    for make in MADE.get(kind, ()):
        yield Swollen(kind, "sound", make)
    if kind in _UNITS:
        pattern, between = _UNITS[kind]
        found = re.search(pattern, data, re.DOTALL)
        assert found is not None, kind
        unit = found[0]
        head, rest = data[: found.end()], data[found.end() :]
        yield Swollen(kind, "more", _between(head, between + unit, rest))
        yield Swollen(
            kind, "line", _between(head[: head.rindex(unit) + len(unit) // 2], b"1", rest)
        )
        yield Swollen(kind, "spaces", _between(head, b" ", rest))
    elif name.endswith(_LINES):
        lines = data.splitlines(keepends=True)
        yield Swollen(kind, "more", _between(data, lines[-1], b""))
        yield Swollen(kind, "line", _between(data[:-1], b"1", b"\n"))
        yield Swollen(kind, "cells", _between(data[:-1], b",1", b"\n"))
        yield Swollen(kind, "spaces", _between(data, b" \n", b""))
    yield Swollen(kind, "blank", _between(data[:half], b"\0", data[half:]))
    yield Swollen(kind, "tail", _by_chance(data))


# --- reading ----------------------------------------------------------------------------------
def child(kind: str, folder: Path) -> None:
    """Reads when it is told to; says what came of it."""
    from vomstudio.core.errors import VomError

    main, read = READERS[kind]
    # What is imported, and compiled, is not the file's.
    small = Path(sys.stdin.readline().strip())
    try:
        read(small / main)
    except VomError as error:
        print("of the sound file:", error, file=sys.stderr)
    print("ready", flush=True)
    sys.stdin.readline()
    try:
        read(folder / main)
        print("read")
    except VomError as error:
        print("refused:", str(error)[:150].replace("\n", " "))
    except KeyboardInterrupt:
        print("ended")
    except MemoryError:
        print("WRONG: out of memory")


@dataclass(frozen=True)
class Cost:
    said: str
    seconds: float
    memory: int
    end_s: float = 0.0


def _held(process: psutil.Process) -> int:
    total = 0
    for each in (process, *process.children(recursive=True)):
        try:
            total += each.memory_info().rss
        except psutil.NoSuchProcess:
            continue
    return total


def cost(kind: str, folder: Path, small: Path, end_after: float | None = None) -> Cost:
    command = [sys.executable, "-m", "tests.fuzz.swollen", "--child", kind, "--dir", str(folder)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as reading:
        return _watched(reading, small, end_after)


def _watched(reading: subprocess.Popen[str], small: Path, end_after: float | None) -> Cost:
    assert reading.stdin is not None
    assert reading.stdout is not None
    reading.stdin.write(f"{small}\n")
    reading.stdin.flush()
    reading.stdout.readline()
    process = psutil.Process(reading.pid)
    before, most, asked = _held(process), 0, 0.0
    begun = time.monotonic()
    reading.stdin.write("go\n")
    reading.stdin.flush()
    while reading.poll() is None:
        try:
            most = max(most, _held(process))
        except psutil.NoSuchProcess:
            break
        now = time.monotonic() - begun
        if end_after is not None and not asked and now > end_after:
            asked = now
            reading.send_signal(signal.SIGINT)
        if now > LONGEST_S:
            reading.kill()
        time.sleep(_POLL_S)
    spent = time.monotonic() - begun
    said = reading.stdout.read().strip() or f"WRONG: ended by {reading.wait()}"
    return Cost(said, spent, max(most - before, 0), spent - asked if asked else 0.0)


def campaign(
    megabytes: int,
    folder: Path | None,
    *,
    only: str = "",
    way: str = "",
    free_bytes: int = FREE_BYTES,
    tell: Callable[[str], object] = str,
) -> list[str]:
    """A line for each file, which begins with WRONG where a promise is not kept."""
    said = []
    for kind, files in seeds().items():
        for each in swollen(kind, files) if only in kind else ():
            if way in ("", each.way):
                with tempfile.TemporaryDirectory(dir=folder) as made:
                    said.append(_line(each, files, megabytes << 20, free_bytes, Path(made)))
                tell(said[-1])
    return said


def _line(each: Swollen, files: Files, size: int, free_bytes: int, made: Path) -> str:
    small, large = made / "small.vom", made / "large.vom"
    lay(files, small)
    lay(files, large)
    main_file = large / READERS[each.kind][0]
    decoded = each.write(main_file, size)
    whole = cost(each.kind, large, small)
    allowed = 2 * max(main_file.stat().st_size, decoded) + free_bytes
    end_s = 0.0
    if whole.seconds > 1.0:
        end_s = cost(each.kind, large, small, whole.seconds / 2).end_s
    bad = "WRONG" in whole.said or whole.memory > allowed or end_s > LONGEST_END_S
    return (
        f"{'WRONG ' * bad}{each.kind:24s}{each.way:8s}{whole.seconds:7.1f} s"
        f"{whole.memory / 1e6:8.0f} MB {whole.memory / allowed:5.2f}"
        f"  end {end_s:5.1f} s  {whole.said}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--megabytes", type=int, default=300)
    parser.add_argument("--only", default="", help="part of a kind's name")
    parser.add_argument("--way", default="")
    parser.add_argument("--dir", type=Path)
    parser.add_argument("--child", default="", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.child:
        child(asked.child, asked.dir)
        return 0
    said = campaign(asked.megabytes, asked.dir, only=asked.only, way=asked.way, tell=print)
    return int(any(line.startswith("WRONG") for line in said))


if __name__ == "__main__":
    sys.exit(main())
