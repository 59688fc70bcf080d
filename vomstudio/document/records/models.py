"""Models of the outcrop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.document.records.basics import IDENTITY, Matrix
from vomstudio.document.records.frames import UNDECLARED, Frame


@dataclass(frozen=True)
class Model:
    """A model of the outcrop. `path` is relative to the project folder where it lies inside it or
    beside it on the same drive, else absolute; `content_hash` is the SHA-256 of the file."""

    id: str
    name: str
    path: str
    kind: Literal["mesh", "cloud"]
    content_hash: str
    frame: Frame = UNDECLARED
    to_world: Matrix = IDENTITY
