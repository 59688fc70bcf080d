"""Coverage of the face of an outcrop."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class FaceGrid:
    """A grid of square cells over a face, each marked with the result of its inspection.

    Attributes
    ----------
    origin : Point
        Lower left corner, model file frame.
    right, up : Point
        Unit vectors in its plane, model file frame.
    cell : float
        Side of a cell, file units.
    marks : str
        A letter of `geology.coverage.face_coverage` for each cell, row by row from the origin.
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
