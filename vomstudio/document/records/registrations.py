"""How models come to their place in World by measurement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.document.records.basics import IDENTITY, Matrix
from vomstudio.document.records.frames import UNDECLARED, Frame


@dataclass(frozen=True)
class Registration:
    """A similarity from a model's file to World, found by measurement and not declared.

    method: "gps", "control" or "local" for a reconstruction placed by its cameras, by control
    points, or by nothing outside of the photos. frame: what is known of World afterwards. matrix:
    4x4 from the file to World. reconstruction_id: the one that it came with, "" for none.
    rotation_error_deg: about up, east and north, one sigma, None where not known; scale_error: one
    sigma, as a share. rms_control_m, rms_check_m: of what is left over at the points.
    """

    id: str
    name: str
    method: Literal["gps", "control", "local"]
    frame: Frame = UNDECLARED
    matrix: Matrix = IDENTITY
    reconstruction_id: str = ""
    rotation_error_deg: tuple[float, float, float] | None = None
    scale_error: float | None = None
    rms_control_m: float | None = None
    rms_check_m: float | None = None

    def to_world(self) -> Matrix:
        """4x4 similarity from the file to World."""
        return self.matrix
