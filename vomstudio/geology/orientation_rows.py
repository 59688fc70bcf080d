"""Planes and lines of a table, regardless of its source."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.common_rotation_errors import RotationErrors


class OrientationRows(Protocol):
    """Table of n planes and lines; angles of the other geometry are NaN.

    Attributes
    ----------
    path : Path
        Path of the source, for error messages.
    ids, kinds, sets : (n,) tuple of str
        Identifiers, kinds and sets; None for kinds or sets if the table has no such column.
    overturned : (n,) tuple of bool or None
        Whether a bed is overturned (younger side below); None if unknown.
    convention : str
        Convention by which the columns were read, for display.
    dropped : tuple of int
        Line numbers of the table that contain no angles.
    warnings : tuple of Finding
    rotation_errors : RotationErrors or None
        Uncertain rotations of the rows due to the registrations of their models.
    repeats : int
        Number of rows excluded because they repeat other rows.
    bowed_deg : float or None
        Difference in dip between the edges of a bowed model, degrees.
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
    def rotation_errors(self) -> RotationErrors | None: ...
    @property
    def repeats(self) -> int: ...
    @property
    def bowed_deg(self) -> float | None: ...

    def __len__(self) -> int: ...

    def column(self, key: str) -> list[str]:
        """Return the cells (n,) of a column as text, or raise UsageError if it does not exist."""

    def vectors(self) -> FloatArray:
        """Return unit vectors (n, 3) in the World frame.

        Planes are represented by their downward poles, lines by their directed vectors.
        """
