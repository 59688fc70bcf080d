"""Ground control: points with surveyed coordinates, and where they are seen in the photos.

Labels that are marked and have no coordinates are tie points: places that the photos share.
"""

from __future__ import annotations

from dataclasses import dataclass

CONTROL, MARKS = "control.csv", "marks.csv"
"""Names of our own tables beside the photos, where they are found without being named."""


@dataclass(frozen=True)
class ControlPoint:
    """position : east, north, up in the CRS of the project, metres
    sigma_m : of each coordinate; None where the table does not say
    check : it judges the model and does not place it
    """

    label: str
    position: tuple[float, float, float]
    sigma_m: float | None = None
    check: bool = False


@dataclass(frozen=True)
class Mark:
    """photo : its name, as in the folder, or the last part of it
    x, y : pixels; (0.5, 0.5) is the centre of the top left pixel
    """

    label: str
    photo: str
    x: float
    y: float
