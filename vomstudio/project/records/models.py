"""Models of the outcrop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.registrations import Registration


@dataclass(frozen=True)
class Model:
    """Model of the outcrop.

    Attributes
    ----------
    path : str
        Path, relative to the project folder if the file is inside it or next to it on the same
        drive, otherwise absolute.
    content_hash : str
        SHA-256 of the file.
    placement : Frame or Registration
        Position in the World frame, declared by the user or determined by a registration. It is the
        record of the registration itself: an edit that changes a registration also changes its
        models (`edits.set_registration`), so undo restores all of them. On disk it is an ID.
    """

    id: str
    name: str
    path: str
    kind: Literal["mesh", "cloud"]
    content_hash: str
    placement: Frame | Registration = UNDECLARED_FRAME

    @property
    def registration(self) -> Registration | None:
        return self.placement if isinstance(self.placement, Registration) else None

    @property
    def frame(self) -> Frame:
        """Known properties of the axes, the unit and the position of the World frame."""
        return self.placement if isinstance(self.placement, Frame) else self.placement.frame

    @property
    def to_world(self) -> Matrix:
        """Similarity transformation (4, 4) from the file frame to the World frame."""
        return self.placement.to_world()
