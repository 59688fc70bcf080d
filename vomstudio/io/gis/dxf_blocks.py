"""How much a DXF drawing becomes once its blocks are put in their places.

A block may hold others many times, and these others again: some lines of a file are so more
entities than anybody can wait for. They are counted here before a library unfolds them.
"""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from pathlib import Path

from vomstudio.errors import InputError
from vomstudio.files.regular import open_regular
from vomstudio.words import tr

MOST_UNFOLDED = 1_000_000
# What begins an entity, a block or a section: group code 0 (AutoCAD DXF Reference, Group codes) and
# a word; a value of 0 is followed by a code, which has digits alone.
_RECORD = re.compile(
    rb"(?:^|\n)[ \t]*0[ \t]*\r?\n[ \t]*(?=[0-9]*[A-Za-z_])([A-Za-z0-9_]+)[ \t]*\r?(?=\n)"
)
_NO_ENTITIES = {b"SECTION", b"ENDSEC", b"BLOCK", b"ENDBLK", b"TABLE", b"ENDTAB", b"EOF"}


def refuse_endless_blocks(path: Path) -> None:
    """Raises InputError where a block holds itself, or where all that is put in places of blocks is
    more than a million entities; OSError."""
    with open_regular(path) as file:
        data = file.read()
    if b"INSERT" not in data.upper():
        return
    total = _Drawing(data).unfolded()
    if total > MOST_UNFOLDED:
        raise InputError(
            tr(
                "The blocks of this drawing hold each other so often that it becomes {count} "
                "entities. Save it without nested blocks (exploded).",
                count=f"{total:.0e}" if math.isfinite(total) else "∞",
            ),
            file=path,
        )


class _Drawing:
    """Entities by the block that holds them; those of none are in the block without a name."""

    def __init__(self, data: bytes) -> None:
        self._own: Counter[bytes] = Counter()
        self._placed: dict[bytes, list[tuple[bytes, float]]] = defaultdict(list)
        self._known: dict[bytes, float] = {}
        block, records = b"", list(_RECORD.finditer(data))
        ends = [record.start() for record in records[1:]] + [len(data)]
        for record, end in zip(records, ends, strict=True):
            kind = record[1].upper()
            if kind == b"BLOCK":
                block = self._groups(data, record.end(), end)[0]
            elif kind == b"ENDBLK":
                block = b""
            elif kind == b"INSERT":
                name, across, down = self._groups(data, record.end(), end)
                self._placed[block].append((name, max(across, 1.0) * max(down, 1.0)))
            elif kind not in _NO_ENTITIES:
                self._own[block] += 1

    @staticmethod
    def _groups(data: bytes, begin: int, end: int) -> tuple[bytes, float, float]:
        """Name, and columns and rows of a grid."""
        lines = [line.strip() for line in data[begin:end].split(b"\n")[1:]]
        said = dict(zip(lines[0::2], lines[1::2], strict=False))
        across, down = (
            float(said[code]) if said.get(code, b"").isdigit() else 1.0 for code in (b"70", b"71")
        )
        return said.get(b"2", b"").upper(), across, down

    def unfolded(self) -> float:
        """How many entities are put in places of blocks; infinite where a block holds itself."""
        return sum(times * self._size(name, ()) for name, times in self._placed[b""])

    def _size(self, block: bytes, above: tuple[bytes, ...]) -> float:
        if block in above or len(above) > _DEEPEST:
            return math.inf
        if block not in self._known:
            inside = (
                times * self._size(name, (*above, block)) for name, times in self._placed[block]
            )
            self._known[block] = self._own[block] + sum(inside)
        return self._known[block]


_DEEPEST = 100
