"""Ground control: points with surveyed coordinates, and their marks in photos.

Marked labels without coordinates are tie points, which are visible in several photos.
"""

from __future__ import annotations

from dataclasses import dataclass

CONTROL, MARKS = "control.csv", "marks.csv"
"""Default names of the tables next to the photos."""


@dataclass(frozen=True)
class ControlPoint:
    """Ground control point.

    `position` contains east, north and up in the CRS of the project, in metres. `sigma_m` is the
    standard deviation of each coordinate in metres, or None if not stated. `check` marks a check
    point, which is not used for the model.
    """

    label: str
    position: tuple[float, float, float]
    sigma_m: float | None = None
    check: bool = False


@dataclass(frozen=True)
class Mark:
    """Mark in a photo.

    `photo` is the path of the photo relative to the photo folder, or only its file name. `x`
    and `y` are pixel coordinates, in which (0.5, 0.5) is the centre of the top-left pixel.
    """

    label: str
    photo: str
    x: float
    y: float
