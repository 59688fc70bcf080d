"""Archives of arrays that somebody else may have made: claims are held against the bytes."""

from __future__ import annotations

import contextlib
import io
import os
import resource
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from vomstudio.core.files.arrays import open_arrays

pytestmark = pytest.mark.filterwarnings("ignore:Duplicate name")


def npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array)
    return stream.getvalue()


def claiming(shape: str, kind: str = "<f8") -> bytes:
    """A header without values."""
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    head += b" " * (63 - (10 + len(head)) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head


def archive(path: Path, *members: tuple[str, bytes], how: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", how) as made:
        for name, data in members:
            made.writestr(name, data)
    return path


def patched(path: Path, *places: tuple[bytes, int, str, int]) -> Path:
    """With numbers of the headers changed: signature, offset in it, form, value."""
    data = bytearray(path.read_bytes())
    for sign, offset, form, value in places:
        at = data.find(sign)
        while at >= 0:
            struct.pack_into(form, data, at + offset, value)
            at = data.find(sign, at + 4)
    path.write_bytes(data)
    return path


def read_all(path: Path) -> dict[str, np.ndarray]:
    with open_arrays(path) as arrays:
        return dict(arrays)


def test_arrays_written_by_numpy_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    chance = np.random.default_rng(1)
    for save in (np.savez, np.savez_compressed):
        save(
            path,
            points=chance.random((50, 3)),
            flat=np.zeros((400, 400)),
            text=np.array("dip"),
            words=np.array(["a", "bc"]),
            turned=np.asfortranarray(np.eye(3)),
            none=np.zeros((0, 3)),
        )
        with np.load(path) as said, open_arrays(path) as arrays:
            assert arrays.files == said.files
            for name in said.files:
                np.testing.assert_array_equal(arrays[name], said[name])
                assert arrays[name].dtype == said[name].dtype
            assert arrays.get("other") is None
            with pytest.raises(KeyError):
                arrays["other"]


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        ("(10000000000,)", "<f8"),
        ("(-5,)", "<f8"),
        ("(4294967296, 4294967296)", "|u1"),
        ("(3,)", "|O"),
        ("(1,)", "<U999999999"),
        ("(True,)", "<f8"),
        ("'x'", "<f8"),
        ("(3,)", "<q9"),
    ],
)
def test_false_array_header_is_rejected_without_allocation(
    tmp_path: Path, shape: str, kind: str
) -> None:
    path = archive(tmp_path / "a.npz", ("a.npy", claiming(shape, kind)))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ValueError, match="a: "):
        read_all(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000


def test_corrupt_archive_members_raise(tmp_path: Path) -> None:
    good = npy(np.arange(9.0))
    twice = archive(tmp_path / "twice.npz", ("a.npy", good), ("a.npy", good))
    locked = patched(
        archive(tmp_path / "locked.npz", ("a.npy", good)),
        (b"PK\x03\x04", 6, "<H", 1),
        (b"PK\x01\x02", 8, "<H", 1),
    )
    foreign = archive(tmp_path / "foreign.npz", ("a.npy", good), how=zipfile.ZIP_LZMA)
    # 4 GB claimed of a member of a few bytes, and members that lie over each other.
    larger = patched(
        archive(tmp_path / "larger.npz", ("a.npy", good), how=zipfile.ZIP_DEFLATED),
        (b"PK\x01\x02", 24, "<I", 4_000_000_000),
    )
    over = patched(
        archive(tmp_path / "over.npz", ("a.npy", good), ("b.npy", good), ("c.npy", good)),
        (b"PK\x01\x02", 20, "<I", 400),
        (b"PK\x01\x02", 24, "<I", 400),
    )
    for path in (twice, locked, foreign, larger, over):
        with pytest.raises(ValueError, match=r"\w+ \w+"):
            read_all(path)


def test_member_names_cannot_write_outside_archive(tmp_path: Path) -> None:
    """Members are read, and never written."""
    names = ["../a.npy", "/etc/passwd.npy", "b\\..\\c.npy", "d\x00.npy", ".npy"]
    (tmp_path / "in").mkdir()
    path = archive(tmp_path / "in" / "a.npz", *((name, npy(np.eye(2))) for name in names))
    read_all(path)
    assert [p.name for p in tmp_path.rglob("*")] == ["in", "a.npz"]


@pytest.mark.parametrize("damage", range(40))
def test_a_damaged_archive_is_a_value_error(tmp_path: Path, damage: int) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, a=np.arange(500.0), b=np.zeros((20, 20), np.uint8))
    chance = np.random.default_rng(damage)
    data = bytearray(path.read_bytes())
    for at in chance.integers(0, len(data), 8):
        data[at] ^= 1 << chance.integers(8)
    path.write_bytes(data[: len(data) - (damage % 3) * 20])
    with contextlib.suppress(ValueError):
        read_all(path)


def test_pipe_is_rejected_as_archive_without_blocking(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.npz")
    with pytest.raises(ValueError, match="pipe"):
        read_all(tmp_path / "a.npz")
    with pytest.raises(FileNotFoundError):
        read_all(tmp_path / "none.npz")
