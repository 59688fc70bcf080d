"""What was looked at of the face of an outcrop."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class FaceGrid:
    """A grid of square cells over a face, each marked with what was found there.

    origin : the lower left corner; right, up : unit vectors in its plane; all in the model's file
    frame. cell : side of a cell, file units; marks : for each cell a letter of
    `geology.coverage.face_coverage`, row by row from the origin
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
