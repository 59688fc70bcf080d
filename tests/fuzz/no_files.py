"""Pipes, sockets, devices and folders in the place of every file that is read, and of those beside
it: none may be waited for, and none read without end.

    python -m tests.fuzz.no_files [--only WORD]

prints each that did what none may do; the exit code is then 1. `readers` does the same before it
bends files.
"""

from __future__ import annotations

import argparse
import os
import shutil
import socket
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Collection
from pathlib import Path

from tests.fuzz.kinds import GO_ON, READERS, seeds
from tests.fuzz.readers import Reader, lay


def _socket(place: Path) -> None:
    # The name of a socket is short: it is bound from its own folder.
    here = Path.cwd()
    os.chdir(place.parent)
    try:
        with socket.socket(socket.AF_UNIX) as bound:
            bound.bind(place.name)
    finally:
        os.chdir(here)


ODD: dict[str, Callable[[Path], object]] = {
    "pipe": os.mkfifo,
    "socket": _socket,
    "endless device": lambda place: place.symlink_to("/dev/zero"),
    "empty device": lambda place: place.symlink_to("/dev/null"),
    "folder": Path.mkdir,
    "link to nothing": lambda place: place.symlink_to("nothing"),
    "link to itself": lambda place: place.symlink_to(place.name),
}


def campaign(only: str = "", odd: Collection[str] = tuple(ODD)) -> tuple[Counter[str], list[str]]:
    """How many were read without it and refused, and a line for each that did what none may do.

    only : part of a kind's name; odd : what takes the place of a file, of ODD
    """
    counts, wrong = Counter[str](), list[str]()
    reader = Reader()
    try:
        with tempfile.TemporaryDirectory() as made:
            for kind, files in seeds().items():
                for name in files if only in kind else ():
                    for what in odd:
                        place = Path(made) / "f.vom"
                        lay(files, place)
                        (place / name).unlink()
                        ODD[what](place / name)
                        found, _ = reader.outcome(kind, place)
                        shutil.rmtree(place)
                        # Without what lies beside it a file may still be read.
                        needed = name == READERS[kind][0] and kind not in GO_ON
                        fine = ("refused",) if needed else ("refused", "read")
                        counts[found if found in fine else "wrong"] += 1
                        if found not in fine:
                            wrong.append(f"{kind}: {what} as {name}: {found}")
    finally:
        reader.close()
    return counts, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--only", default="", help="part of a kind's name")
    counts, wrong = campaign(parser.parse_args().only)
    print(f"{sum(counts.values())} files that are none: {dict(counts)}")
    for line in wrong:
        print("  ", line)
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
