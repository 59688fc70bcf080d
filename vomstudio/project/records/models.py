"""Models of the outcrop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.geometry.frames import UNDECLARED, Frame
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.registrations import Registration


@dataclass(frozen=True)
class Model:
    """A model of the outcrop.

    Attributes
    ----------
    path : str
        Relative to the project folder if inside it or beside it on the same drive, else absolute.
    content_hash : str
        SHA-256 of the file.
    placement : Frame or Registration
        Position in World, declared by the user or determined by a registration. It is the record
        of the registration itself: an edit that changes one changes its models with it
        (`edits.set_registration`), so undo restores all of them. On disk it is an id.
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
        """Known properties of the axes, unit and place of World."""
        return self.placement if isinstance(self.placement, Frame) else self.placement.frame

    @property
    def to_world(self) -> Matrix:
        """4x4 similarity from the file frame to World."""
        return self.placement.to_world()
