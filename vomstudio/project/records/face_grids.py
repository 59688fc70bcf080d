"""Coverage of an outcrop face."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class FaceGrid:
    """Grid of square cells on a face, each marked with the result of its inspection.

    Attributes
    ----------
    origin : Point
        Lower-left corner in the file frame of the model.
    right, up : Point
        Unit vectors in the plane of the grid, in the file frame of the model.
    cell : float
        Side length of a cell in file units.
    marks : str
        One letter of `geology.coverage.face_coverage` per cell, row by row from the origin.
    """

    id: str
    name: str
    model_id: str
    model_hash: str
    origin: Point
    right: Point
    up: Point
    cell: float
    columns: int
    rows: int
    marks: str = ""
    notes: str = ""
