"""Files of every kind that is read (`kinds`), bent and swollen; what reaches new lines of the
program is kept and bent further.

    python -m tests.fuzz.readers --files 10000 [--seed N] [--only WORD] [--guided] [--reached DIR]

First pipes, devices and folders take the place of every file (`no_files`). Then each file is read
in a process with little memory and little time. What ends in an error that is
none of ours, takes too long or too much, or is refused without naming the file, is printed, and is
kept in a folder that is named at the end; the exit code is then 1. `corpus` holds those that once
did; they are read before all others.

With `--guided` each file is read a second time while it is noted which lines of `vomstudio` run
(sys.settrace): a file that reaches a line which none before it has reached is kept, in memory and
in the folder `--reached`, and chosen again and again to be bent. `corpus/reached` holds such files
of earlier runs, with which every run begins.
"""

from __future__ import annotations

import argparse
import multiprocessing
import random
import resource
import shutil
import stat
import struct
import sys
import tempfile
import threading
import time
import traceback
import types
import zlib
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import psutil

from tests.fuzz.kinds import READERS, SEALED, Files, seeds
from tests.fuzz.stopping import until_stopped

CORPUS = Path(__file__).with_name("corpus")
REACHED = CORPUS / "reached"
PACKAGE = str(Path(__file__).resolve().parents[2] / "vomstudio")
LONGEST_S = 5.0
_SLICE_S = 0.5
FREE_BYTES = 500 << 20
_TRACED_S = 0.3
"""What took longer is not read again to see which lines it reaches."""
_TOKENS = [
    b"\0",
    b"\xff",
    b"\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff",
    b"\0\0\0\x80",
    b"-1",
    b"1e999",
    b"nan",
    b"null",
    b"Infinity",
    b"true",
    b"\\u0000",
    b"&a;",
    b"=",
    b"\t",
    b";",
    b"99999999999999999999",
    b"\n",
    b" ",
    b",",
    b"'",
    b'"',
    b"[",
    b"{",
    b"<",
    b">",
    b"/",
    b"../",
    b"%",
    b"4294967295",
    b"0",
    b"\xed\xa0\x80",
    b"\xef\xbb\xbf",
]
Lines = frozenset[tuple[str, int]]


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
def _outcome(kind: str, folder: Path, given: Path | None = None) -> str:
    from vomstudio.core.errors import VomError

    main, read = READERS[kind]
    names = {path.name for path in folder.rglob("*")} | {folder.name}
    begun = time.process_time()
    try:
        read(given or folder / main)
        found = "read"
    except VomError as error:
        named = any(name in str(error) for name in names)
        found = "refused" if named else f"REFUSED WITHOUT ITS NAME: {error}"
    except MemoryError:
        found = "TOO MUCH MEMORY"
    except Exception as error:  # noqa: BLE001 - that is what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        found = (
            f"ERROR {type(error).__name__}: {str(error)[:100]} ({place.filename}:{place.lineno})"
        )
    spent = time.process_time() - begun
    return found if spent < LONGEST_S else f"TOOK {spent:.0f} s"


def _lines_of(kind: str, folder: Path) -> Lines:
    """Lines of the program that run while the file is read."""
    found: set[tuple[str, int]] = set()

    def trace(frame: types.FrameType, event: str, argument: object) -> Any:
        name = frame.f_code.co_filename
        if not name.startswith(PACKAGE):
            return None
        short = name[len(PACKAGE) + 1 :]

        def line(frame: types.FrameType, event: str, argument: object) -> Any:
            if event == "line":
                found.add((short, frame.f_lineno))
            return line

        return line

    threading.settrace(trace)
    sys.settrace(trace)
    try:
        _outcome(kind, folder)
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
    return frozenset(found)


def _serve(link: Any) -> None:
    """Reads what it is told to, until it is told nothing."""
    known: set[tuple[str, int]] = set()
    while (asked := link.recv()) is not None:
        kind, folder, traced, main = asked
        size = sum(map(_bytes_on_disk, folder.rglob("*")))
        limit = _held() + FREE_BYTES + 20 * size
        resource.setrlimit(resource.RLIMIT_DATA, (limit, resource.RLIM_INFINITY))
        begun = time.process_time()
        outcome = _outcome(kind, folder, main)
        quick = time.process_time() - begun < _TRACED_S
        new = _lines_of(kind, folder) - known if traced and quick else frozenset()
        known |= new
        resource.setrlimit(resource.RLIMIT_DATA, (resource.RLIM_INFINITY,) * 2)
        link.send((outcome, new))


def _bytes_on_disk(path: Path) -> int:
    """Of a file; holes count for nothing, and neither does what a link leads to."""
    facts = path.lstat()
    return min(facts.st_size, facts.st_blocks * 512) if stat.S_ISREG(facts.st_mode) else 0


def _held() -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData"):
            return int(line.split()[1]) * 1024
    return 1 << 32


def _sleeps(pid: int) -> bool:
    """Whether none of a process's threads works or waits for its turn, or for the disk."""
    tasks = Path(f"/proc/{pid}/task").glob("*/stat")
    return all(path.read_text().rpartition(")")[2].split()[0] == "S" for path in tasks)


class Reader:
    """A process that reads files; another one takes its place when it dies or hangs."""

    def __init__(self) -> None:
        self._compiled: set[str] = set()
        self._start()

    def _start(self) -> None:
        self._link, theirs = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("spawn").Process(
            target=_serve, args=(theirs,), daemon=True
        )
        self._process.start()
        theirs.close()
        self._fresh = True

    def _answers(self, most_s: float) -> bool:
        """False once it has worked, or slept, for longer: other programs on the machine may keep it
        from working."""
        process = psutil.Process(self._process.pid)
        begun, slept_s = sum(process.cpu_times()[:2]), 0.0
        while not self._link.poll(_SLICE_S):
            slept_s += _SLICE_S * _sleeps(process.pid)
            if max(slept_s, sum(process.cpu_times()[:2]) - begun) > most_s:
                return False
        return True

    def outcome(
        self, kind: str, folder: Path, *, traced: bool = False, main: Path | None = None
    ) -> tuple[str, Lines]:
        """What became of the file, or of `main` in its place, and lines that this process has not
        run before."""
        if kind not in self._compiled:
            # Kernels are compiled for the first file of a kind, and kept on the disk.
            self._compiled.add(kind)
            self._asked((kind, folder, False, main), LONGEST_S * 60)
        # The first file of a process waits for imports.
        return self._asked((kind, folder, traced, main), LONGEST_S * (12 if self._fresh else 4))

    def _asked(self, what: tuple[str, Path, bool, Path | None], most_s: float) -> tuple[str, Lines]:
        self._link.send(what)
        try:
            if self._answers(most_s):
                self._fresh = False
                outcome, lines = self._link.recv()
                return str(outcome), lines
            said = "HANGS"
        except (EOFError, OSError, psutil.NoSuchProcess):
            self._process.join()
            said = f"CRASHED ({self._process.exitcode})"
        self._process.kill()
        self._process.join()
        self._start()
        return said, frozenset()

    def close(self) -> None:
        self._process.kill()
        self._process.join()


class Pool:
    """Files by kind, those that reached new lines among them."""

    def __init__(self, sound: dict[str, Files], chance: random.Random) -> None:
        self._all = {kind: [files] for kind, files in sound.items()}
        self._chance = chance
        self._pieces = [data for files in sound.values() for data in files.values()]
        self.lines: set[tuple[str, int]] = set()
        self.kept = 0

    def bent(self) -> tuple[str, str, Files]:
        """Kind, the name of the file that was bent, and all files."""
        chance = self._chance
        kind = chance.choice(list(self._all))
        known = self._all[kind]
        # The latest have reached what is hardest to reach.
        files = known[-1 - min(int(chance.expovariate(0.2)), len(known) - 1)]
        name = chance.choice([READERS[kind][0], *files])
        made = mutated(files[name], self._pieces, chance)
        sealed = SEALED.get(Path(name).suffix)
        if sealed is not None and chance.random() < 0.8:
            made = sealed(made)
        return kind, name, {**files, name: made}

    def learn(self, kind: str, files: Files, lines: Lines) -> bool:
        """Whether lines are new; then the files are bent further."""
        if not lines - self.lines:
            return False
        self.lines |= lines
        if sum(map(len, files.values())) < 1 << 20:
            self._all[kind].append(files)
            self.kept += 1
        return True


def kept_files(sound: dict[str, Files], folder: Path) -> list[tuple[str, str, Files]]:
    """Kind, name and files of those in a corpus; a name tells the file that was bent."""
    found = []
    for path in sorted(folder.glob("*-*")):
        name = path.name.partition("-")[2].replace("~", "/")
        for kind, files in sound.items():
            if name in files:
                found.append((kind, name, {**files, name: path.read_bytes()}))
    return found


def campaign(
    count: int,
    seed: int,
    *,
    only: str = "",
    guided: bool = False,
    keep: Callable[[str, bytes], None] | None = None,
    reached: Callable[[str, bytes], None] | None = None,
) -> tuple[Counter[str], list[str], Pool]:
    """How many files were read and refused, and a line for each that did what none may do."""
    everything = seeds()
    sound = {kind: files for kind, files in everything.items() if only in kind}
    counts, wrong = Counter[str](), list[str]()
    pool = Pool(sound, random.Random(f"readers {seed}"))
    given = [(kind, READERS[kind][0], files) for kind, files in sound.items()]
    given += kept_files(sound, CORPUS) + (kept_files(sound, REACHED) if guided else [])
    reader = Reader()
    try:
        with tempfile.TemporaryDirectory() as made:
            for number in until_stopped(range(len(given) + count)):
                bent = number >= len(given)
                kind, name, files = pool.bent() if bent else given[number]
                place = Path(made) / f"f{number}.vom"
                lay(files, place)
                found, lines = reader.outcome(kind, place, traced=guided)
                shutil.rmtree(place)
                counts[found if found.islower() else "wrong"] += 1
                unique = f"{zlib.crc32(files[name]):08x}-{name.replace('/', '~')}"
                if pool.learn(kind, files, lines) and bent and reached is not None:
                    reached(unique, files[name])
                if not found.islower():
                    wrong.append(f"{number} {kind}: {name} ({len(files[name])} bytes): {found}")
                    if keep is not None:
                        keep(unique, files[name])
    finally:
        reader.close()
    return counts, wrong, pool


def lay(files: Files, place: Path) -> None:
    for name, data in files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(data)


def _put_into(folder: Path) -> Callable[[str, bytes], None]:
    def put(name: str, data: bytes) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)

    return put


def _told(counts: Counter[str], wrong: Collection[str], pool: Pool, spent_s: float) -> None:
    print(f"{sum(counts.values())} files in {spent_s:.0f} s: {dict(counts)}")
    if pool.lines:
        print(f"{len(pool.lines)} lines reached; {pool.kept} files reached a new one")
    for line in wrong:
        print("  ", line)


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="part of a kind's name")
    parser.add_argument("--guided", action="store_true", help="bend what reaches new lines further")
    parser.add_argument("--reached", type=Path, help="folder for files that reach new lines")
    asked = parser.parse_args()
    # It reads as this does, so it is known here only once this runs.
    from tests.fuzz import no_files

    none, odd = no_files.campaign(asked.only)
    print(f"{sum(none.values())} files that are none: {dict(none)}")
    for line in odd:
        print("  ", line)
    kept = Path(tempfile.mkdtemp(prefix="vom-fuzz-"))
    begun = time.monotonic()
    counts, wrong, pool = campaign(
        asked.files,
        asked.seed,
        only=asked.only,
        guided=asked.guided,
        keep=_put_into(kept),
        reached=_put_into(asked.reached) if asked.reached else None,
    )
    _told(counts, wrong, pool, time.monotonic() - begun)
    if wrong:
        print("kept in", kept)
    else:
        shutil.rmtree(kept)
    return min(len(wrong) + len(odd), 1)


if __name__ == "__main__":
    sys.exit(main())
