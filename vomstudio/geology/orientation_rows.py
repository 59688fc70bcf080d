"""Planes and lines of one table, wherever they were read."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import Turns


class OrientationRows(Protocol):
    """n planes and lines, row by row; NaN where a row is not of that geometry.

    path : where they come from, for errors
    ids, kinds, sets : (n,) words; kinds and sets are None where there is no such column
    overturned : (n,) whether a bed's younger side is below, None where that is not said
    convention : how the columns were understood, for people
    dropped : lines of the table without angles; warnings : sentences
    turns : how the rows turn with the registrations of their models, None where nothing is said
    repeats : how many rows were left out since they repeat others
    bowed_deg : by how much dips differ from edge to edge of a model of theirs that is bowed
    """

    @property
    def path(self) -> Path: ...
    @property
    def is_plane(self) -> BoolArray: ...
    @property
    def dip_direction_deg(self) -> FloatArray: ...
    @property
    def dip_deg(self) -> FloatArray: ...
    @property
    def trend_deg(self) -> FloatArray: ...
    @property
    def plunge_deg(self) -> FloatArray: ...
    @property
    def ids(self) -> tuple[str, ...]: ...
    @property
    def kinds(self) -> tuple[str, ...] | None: ...
    @property
    def sets(self) -> tuple[str, ...] | None: ...
    @property
    def overturned(self) -> tuple[bool | None, ...] | None: ...
    @property
    def convention(self) -> str: ...
    @property
    def dropped(self) -> tuple[int, ...]: ...
    @property
    def warnings(self) -> tuple[Finding, ...]: ...
    @property
    def turns(self) -> Turns | None: ...
    @property
    def repeats(self) -> int: ...
    @property
    def bowed_deg(self) -> float | None: ...

    def __len__(self) -> int: ...

    def column(self, key: str) -> list[str]:
        """(n,) the words of the column that the user calls `key`. Raises UsageError."""

    def vectors(self) -> FloatArray:
        """(n, 3) unit vectors, World: downward poles of the planes, and the lines as directed."""
