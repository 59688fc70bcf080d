"""Counting of the entities of a DXF drawing after its blocks have been inserted.

A block may contain other blocks many times, and these may again contain blocks, so a short file can
expand to more entities than a library can process. The entities are counted before a library
expands them.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.dxf_groups import DxfPiece, dxf_pieces, value_text

MAX_EXPANDED_ENTITIES = 1_000_000
_NON_ENTITIES = {b"SECTION", b"ENDSEC", b"BLOCK", b"ENDBLK", b"TABLE", b"ENDTAB", b"EOF"}


def count_block_entities(path: Path) -> float:
    """Count the entities to which inserted blocks expand.

    Raises
    ------
    InputError
        If a block contains itself, or if there are more than `MAX_EXPANDED_ENTITIES` entities.
    OSError
        If the file cannot be read.
    """
    entity_count = _Drawing(dxf_pieces(path)).count_expanded()
    if entity_count > MAX_EXPANDED_ENTITIES:
        raise InputError(
            Finding(
                "drawing.nested-blocks",
                count=f"{entity_count:.0e}" if math.isfinite(entity_count) else "∞",
            ),
            file=path,
        )
    return entity_count


class _Drawing:
    """Entities by the block that contains them; the block name is "" outside blocks."""

    def __init__(self, pieces: Iterator[DxfPiece]) -> None:
        self._entities: Counter[bytes] = Counter()
        self._inserts: dict[bytes, list[tuple[bytes, float]]] = defaultdict(list)
        self._sizes: dict[bytes, float] = {}
        block = b""
        for piece in pieces:
            if piece.kind == b"BLOCK":
                block = self._parse_insert(piece)[0]
            elif piece.kind == b"ENDBLK":
                block = b""
            elif piece.kind == b"INSERT":
                name, width, height = self._parse_insert(piece)
                self._inserts[block].append((name, max(width, 1.0) * max(height, 1.0)))
            elif piece.kind not in _NON_ENTITIES:
                self._entities[block] += 1

    @staticmethod
    def _parse_insert(piece: DxfPiece) -> tuple[bytes, float, float]:
        """Return the name of an inserted block and the number of columns and rows of its grid."""
        values = dict(piece.groups())
        width, height = (
            float(text) if (text := value_text(values.get(code, 1))).isdigit() else 1.0
            for code in (70, 71)
        )
        return value_text(values.get(2, b"")).upper(), width, height

    def count_expanded(self) -> float:
        """Return the number of expanded entities.

        It is infinite if a block contains itself or is nested more than `_MAX_DEPTH` levels deep.
        """
        return sum(times * self._size(name, ()) for name, times in self._inserts[b""])

    def _size(self, block: bytes, parents: tuple[bytes, ...]) -> float:
        if block in parents or len(parents) > _MAX_DEPTH:
            return math.inf
        if block not in self._sizes:
            contents = (
                times * self._size(name, (*parents, block)) for name, times in self._inserts[block]
            )
            self._sizes[block] = self._entities[block] + sum(contents)
        return self._sizes[block]


_MAX_DEPTH = 100
