"""Arrays in an .npz file (a ZIP of NPY members), of which each may be a lie.

Results that the program keeps lie in the folders of projects and reconstructions, which travel. A
ZIP may stand for thousands of times its size, claim members that overlap, that are locked, or that
are there twice, and an NPY header may ask for any room before a single number follows it. All of it
is held against the bytes that are there, before room is made.
"""

from __future__ import annotations

import contextlib
import math
import os
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular

_MOST_MEMBERS = 10_000
_DEFLATED = 1100
"""Bytes that one byte of a deflated member can stand for: 1032, and a little."""
_LOCKED = 1
"""The bit of a member's flags that says so (APPNOTE.TXT, 4.4.4)."""
_ENDING = ".npy"


class Arrays(Mapping[str, AnyArray]):
    """The arrays of a file by name, each read when it is asked for. Raises KeyError for a name that
    is not there, and ValueError for an array that is damaged."""

    def __init__(self, archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo]) -> None:
        self._archive, self._members = archive, members

    def __getitem__(self, name: str) -> AnyArray:
        member = self._members[name]
        try:
            with self._archive.open(member) as stream:
                return _read(stream, member.file_size)
        except Exception as error:
            # A damaged member makes zlib, zipfile, numpy and its parser of headers raise whatever
            # they like.
            raise ValueError(f"{name}: {error}") from error

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    @property
    def files(self) -> list[str]:
        return list(self._members)


@contextlib.contextmanager
def open_arrays(path: str | Path) -> Iterator[Arrays]:
    """Raises ValueError where the file is no sound .npz, or no regular file, and OSError where it
    cannot be read."""
    try:
        opened = open_regular(path)
    except InputError as error:
        raise ValueError(error.message) from error
    with opened as file:
        try:
            archive = zipfile.ZipFile(file)
        except Exception as error:
            raise ValueError(f"no archive of arrays: {error}") from error
        with archive:
            yield Arrays(archive, _members(archive, os.fstat(file.fileno()).st_size))


def _members(archive: zipfile.ZipFile, size: int) -> dict[str, zipfile.ZipInfo]:
    """Those that are arrays, by name. size : bytes of the whole file. Raises ValueError."""
    infos = archive.infolist()
    if len(infos) > _MOST_MEMBERS:
        raise ValueError("it has more members than any program writes")
    found: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        if info.flag_bits & _LOCKED:
            raise ValueError("a member is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError("a member is compressed in a way that is not read")
        most = info.compress_size
        if info.compress_type == zipfile.ZIP_DEFLATED:
            most = _DEFLATED * info.compress_size
        if info.file_size > most:
            raise ValueError("a member claims more than its bytes can hold")
        name = info.filename.removesuffix(_ENDING)
        if name in found:
            raise ValueError("two members have one name")
        found[name] = info
    if sum(info.compress_size for info in infos) > size:
        raise ValueError("its members overlap")
    return found


def _read(stream: BinaryIO | Any, size: int) -> AnyArray:
    """The array of a member of so many bytes. Raises ValueError."""
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        shape, _, kind = np.lib.format.read_array_header_1_0(stream)
    elif version == (2, 0):
        shape, _, kind = np.lib.format.read_array_header_2_0(stream)
    else:
        raise ValueError("it has a header of a kind that is not read")
    if kind.hasobject or any(count < 0 for count in shape):
        raise ValueError("it holds no numbers or text")
    if math.prod(shape) * max(kind.itemsize, 1) > size - stream.tell():
        raise ValueError("its header claims more values than there are")
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False)
