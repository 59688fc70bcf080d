"""How much a DXF drawing becomes once its blocks are put in their places.

A block may hold others many times, and these others again: some lines of a file are so more
entities than anybody can wait for. They are counted here before a library unfolds them.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.dxf_groups import DxfPiece, dxf_pieces, text_of

MOST_UNFOLDED = 1_000_000
_NO_ENTITIES = {b"SECTION", b"ENDSEC", b"BLOCK", b"ENDBLK", b"TABLE", b"ENDTAB", b"EOF"}


def refuse_endless_blocks(path: Path) -> float:
    """How many entities are put in places of blocks. Raises InputError where a block holds itself,
    or where they are more than a million; OSError."""
    total = _Drawing(dxf_pieces(path)).unfolded()
    if total > MOST_UNFOLDED:
        raise InputError(
            Finding("drawing.nested-blocks", count=f"{total:.0e}" if math.isfinite(total) else "∞"),
            file=path,
        )
    return total


class _Drawing:
    """Entities by the block that holds them; those of none are in the block without a name."""

    def __init__(self, pieces: Iterator[DxfPiece]) -> None:
        self._own: Counter[bytes] = Counter()
        self._placed: dict[bytes, list[tuple[bytes, float]]] = defaultdict(list)
        self._known: dict[bytes, float] = {}
        block = b""
        for piece in pieces:
            if piece.kind == b"BLOCK":
                block = self._told(piece)[0]
            elif piece.kind == b"ENDBLK":
                block = b""
            elif piece.kind == b"INSERT":
                name, across, down = self._told(piece)
                self._placed[block].append((name, max(across, 1.0) * max(down, 1.0)))
            elif piece.kind not in _NO_ENTITIES:
                self._own[block] += 1

    @staticmethod
    def _told(piece: DxfPiece) -> tuple[bytes, float, float]:
        """Name, and columns and rows of a grid."""
        said = dict(piece.groups())
        across, down = (
            float(text) if (text := text_of(said.get(code, 1))).isdigit() else 1.0
            for code in (70, 71)
        )
        return text_of(said.get(2, b"")).upper(), across, down

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
