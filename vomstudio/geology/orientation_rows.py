"""Planes and lines of a table, independent of its source."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import Turns


class OrientationRows(Protocol):
    """Table of n planes and lines; NaN for values of the other geometry.

    Attributes
    ----------
    path : Path
        Source, for errors.
    ids, kinds, sets : (n,) tuple of str
        Kinds and sets are None without such a column.
    overturned : (n,) tuple of bool or None
        Whether the younger side of a bed is below, None if unknown.
    convention : str
        Interpretation of the columns, for users.
    dropped : tuple of int
        Lines of the table without angles.
    warnings : tuple of Finding
    turns : Turns or None
        Rotation of the rows with the registrations of their models.
    repeats : int
        Number of rows excluded as repeats of others.
    bowed_deg : float or None
        Difference of dips between the edges of a bowed model, degrees.
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
        """Return the words (n,) of the column with this name. Raises UsageError."""

    def vectors(self) -> FloatArray:
        """Return unit vectors (n, 3), World frame.

        They are the poles of planes, pointing down, and the directed lines.
        """
