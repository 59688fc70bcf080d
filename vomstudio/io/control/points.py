"""Ground control: points with surveyed coordinates, and their marks in photos.

Marked labels without coordinates are tie points: positions that photos share.
"""

from __future__ import annotations

from dataclasses import dataclass

CONTROL, MARKS = "control.csv", "marks.csv"
"""Default names of the tables beside the photos."""


@dataclass(frozen=True)
class ControlPoint:
    """A ground control point.

    `position` is east, north, up in the CRS of the project, metres; `sigma_m` is that of each
    coordinate, None if not stated; `check` marks a check point, which is not used for the model.
    """

    label: str
    position: tuple[float, float, float]
    sigma_m: float | None = None
    check: bool = False


@dataclass(frozen=True)
class Mark:
    """A mark in a photo.

    `photo` is its name in the folder, or the last part of it; x and y are pixels, (0.5, 0.5) is
    the centre of the top left pixel.
    """

    label: str
    photo: str
    x: float
    y: float
