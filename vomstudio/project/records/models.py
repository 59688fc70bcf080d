"""Models of the outcrop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.geometry.frames import UNDECLARED, Frame
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.registrations import Registration


@dataclass(frozen=True)
class Model:
    """A model of the outcrop. `path` is relative to the project folder where it lies inside it or
    beside it on the same drive, else absolute; `content_hash` is the SHA-256 of the file.

    placement: where it is in World, declared by the user or found by a registration. That is the
    registration's record itself: an edit that changes one changes its models with it
    (`edits.set_registration`), so that undoing moves all of them back. On the disk it is an id.
    """

    id: str
    name: str
    path: str
    kind: Literal["mesh", "cloud"]
    content_hash: str
    placement: Frame | Registration = UNDECLARED

    @property
    def registration(self) -> Registration | None:
        return self.placement if isinstance(self.placement, Registration) else None

    @property
    def frame(self) -> Frame:
        """What is known of the axes, unit and place that `to_world` leads to."""
        return self.placement if isinstance(self.placement, Frame) else self.placement.frame

    @property
    def to_world(self) -> Matrix:
        """4x4 similarity from the file to World."""
        return self.placement.to_world()
