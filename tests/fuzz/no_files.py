"""Pipes, sockets, devices and folders in the place of every file that is read, and of those beside
it: none may be waited for, and none read without end."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.fuzz.kinds import READERS, seeds
from tests.fuzz.readers import Reader, lay


def _socket(place: Path) -> None:
    # The name of a socket is short: it is bound from its own folder.
    here = Path.cwd()
    os.chdir(place.parent)
    try:
        socket.socket(socket.AF_UNIX).bind(place.name)
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


def wrong(made: Path, only: str = "") -> Iterator[str]:
    """A line for each that did what none may do. made : a folder to work in"""
    reader = Reader()
    try:
        for kind, files in seeds().items():
            if only not in kind:
                continue
            main = READERS[kind][0]
            for name in files:
                for odd, make in ODD.items():
                    place = made / "f.vom"
                    lay(files, place)
                    (place / name).unlink()
                    make(place / name)
                    found, _ = reader.outcome(kind, place)
                    shutil.rmtree(place)
                    # Without what lies beside it a file may still be read.
                    if found != "refused" and not (found == "read" and name != main):
                        yield f"{kind}: {odd} as {name}: {found}"
    finally:
        reader.close()
