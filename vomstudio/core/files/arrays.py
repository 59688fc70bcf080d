"""Arrays of an untrusted .npz file, whose headers and sizes are checked before reading.

Files in the folders of projects and reconstructions may come from unknown sources. A ZIP archive
may expand to thousands of times its size or contain members that overlap, are encrypted or share a
name, and an NPY header may declare any size. All sizes are compared with the size of the file
before memory is allocated.
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
from vomstudio.core.files.regular import open_regular_file

_MAX_MEMBERS = 10_000
_MAX_DEFLATE_RATIO = 1100
"""Maximum expansion ratio of a deflated member: 1032, plus a margin."""
_ENCRYPTED_FLAG = 1
"""Encryption bit in the flags of a member (APPNOTE.TXT, 4.4.4)."""
_SUFFIX = ".npy"


class Arrays(Mapping[str, AnyArray]):
    """Arrays of a file by name; each is read when it is accessed.

    Access raises KeyError for an unknown name and ValueError for a damaged array.
    """

    def __init__(self, archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo]) -> None:
        self._archive, self._members = archive, members

    def __getitem__(self, name: str) -> AnyArray:
        member = self._members[name]
        try:
            with self._archive.open(member) as stream:
                return _read(stream, member.file_size)
        except Exception as error:
            # For a damaged member, zlib, zipfile and numpy raise many types of exceptions.
            raise ValueError(f"{name}: {error}") from error

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    @property
    def files(self) -> list[str]:
        """Names of the arrays, as in `numpy.lib.npyio.NpzFile`."""
        return list(self._members)


@contextlib.contextmanager
def open_arrays(path: str | Path) -> Iterator[Arrays]:
    """Open an .npz file.

    Raises
    ------
    ValueError
        If the file is not a valid .npz file or not a regular file.
    OSError
        If the file cannot be read.
    """
    try:
        opened_file = open_regular_file(path)
    except InputError as error:
        raise ValueError(error.message) from error
    with opened_file as file:
        try:
            archive = zipfile.ZipFile(file)
        except Exception as error:
            raise ValueError(f"not an archive of arrays: {error}") from error
        with archive:
            yield Arrays(archive, _members(archive, os.fstat(file.fileno()).st_size))


def _members(archive: zipfile.ZipFile, size: int) -> dict[str, zipfile.ZipInfo]:
    """Return the members of an archive by name, without the suffix ``.npy``.

    Raises ValueError if a member has an unsupported form, or if the sizes of the members are not
    plausible for a file of `size` bytes.
    """
    infos = archive.infolist()
    if len(infos) > _MAX_MEMBERS:
        raise ValueError("it has more members than any program writes")
    members: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        if info.flag_bits & _ENCRYPTED_FLAG:
            raise ValueError("a member is encrypted")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError("a member has an unsupported compression")
        max_size = info.compress_size
        if info.compress_type == zipfile.ZIP_DEFLATED:
            max_size = _MAX_DEFLATE_RATIO * info.compress_size
        if info.file_size > max_size:
            raise ValueError("a member declares more than its bytes can hold")
        name = info.filename.removesuffix(_SUFFIX)
        if name in members:
            raise ValueError("two members have the same name")
        members[name] = info
    if sum(info.compress_size for info in infos) > size:
        raise ValueError("its members overlap")
    return members


def _read(stream: BinaryIO | Any, size: int) -> AnyArray:
    """Read the array of a member of `size` bytes. Raises ValueError."""
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        shape, _, kind = np.lib.format.read_array_header_1_0(stream)
    elif version == (2, 0):
        shape, _, kind = np.lib.format.read_array_header_2_0(stream)
    else:
        raise ValueError("its header has an unsupported version")
    if kind.hasobject or any(count < 0 for count in shape):
        raise ValueError("it does not contain numbers or text")
    if math.prod(shape) * max(kind.itemsize, 1) > size - stream.tell():
        raise ValueError("its header declares more values than it contains")
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False)
