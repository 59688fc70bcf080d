"""What is known of the frame of a model's file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from vomstudio.core.words import tr
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.units import Axes

FrameKind = Literal["crs", "local", "oriented", "scaled", "undeclared"]
UpAxis = Literal["z", "y"]


@dataclass(frozen=True)
class Frame:
    """What is known of a model's frame.

    kind: "crs" (World is the projected CRS `crs`), "local" (metres, up and north are known, the
    place is not), "oriented" (up and north are known, metres are not), "scaled" (metres are known,
    north is not) or "undeclared" (no north, no metre: angles are shown as local frame, lengths in
    units). level: up is known, though north is not.
    unit_m: metres per unit of the file. up_axis: the file's axis that points up; with "y" the file
    is taken as x East, y Up, z South (glTF).
    """

    kind: FrameKind = "undeclared"
    crs: str | None = None
    unit_m: float = 1.0
    up_axis: UpAxis = "z"
    level: bool = False

    @property
    def has_north(self) -> bool:
        """And up with it."""
        return self.kind in ("crs", "local", "oriented")

    @property
    def has_up(self) -> bool:
        return self.level or self.has_north

    @property
    def has_metres(self) -> bool:
        return self.kind in ("crs", "local", "scaled")

    @property
    def axes(self) -> Axes:
        """What files and labels say of World's axes."""
        return Axes(self.has_metres, self.has_north)

    def to_world(self) -> Matrix:
        """4x4 similarity from the file frame to World (x East, y North, z Up, metres)."""
        s = float(self.unit_m)
        if self.up_axis == "y":
            return (
                (s, 0.0, 0.0, 0.0),
                (0.0, 0.0, -s, 0.0),
                (0.0, s, 0.0, 0.0),
                (0.0, 0.0, 0.0, 1.0),
            )
        return (
            (s, 0.0, 0.0, 0.0),
            (0.0, s, 0.0, 0.0),
            (0.0, 0.0, s, 0.0),
            (0.0, 0.0, 0.0, 1.0),
        )

    def name(self) -> str:
        """In a few words, for badges and table headers."""
        if self.kind == "crs":
            return tr("{crs}, grid north", crs=crs_label(self.crs or ""))
        if self.kind == "local":
            return tr("local, north known")
        if self.kind == "oriented":
            return tr("local, north known, scale not known")
        if self.kind == "scaled":
            if self.level:
                return tr("local frame in metres, level: north not known")
            return tr("local frame in metres: not registered")
        if self.level:
            return tr("local frame, level: north and scale not known")
        return tr("local frame: not registered")

    def known_text(self) -> str:
        """Which of north, vertical, scale and position are known, as sentences."""
        each = (
            (tr("north"), self.has_north),
            (tr("vertical"), self.has_up),
            (tr("scale"), self.has_metres),
            (tr("position"), self.kind == "crs"),
        )
        known = ", ".join(name for name, there in each if there)
        lacking = ", ".join(name for name, there in each if not there)
        if not lacking:
            return tr("Known: {what}.", what=known)
        if not known:
            return tr("Not known: {what}.", what=lacking)
        return tr("Known: {known}. Not known: {lacking}.", known=known, lacking=lacking)


@lru_cache(maxsize=64)
def crs_label(crs: str) -> str:
    """A CRS in few words: its code, or the name within its WKT."""
    found = re.match(r'\w+\["([^"]+)"', crs)
    return found[1] if found else crs


UNDECLARED = Frame()
