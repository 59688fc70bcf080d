"""Frame of a model's file."""

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
    """Frame of a model as far as it is known.

    Attributes
    ----------
    kind : {"crs", "local", "oriented", "scaled", "undeclared"}
        "crs": the World frame is the projected CRS `crs`. "local": scale, up and north are known,
        but the position is not. "oriented": up and north are known, but the scale is not. "scaled":
        the scale is known, but north is not. "undeclared": angles are in the local frame, and
        lengths in units of the file.
    unit_m : float
        Metres per unit of the file.
    up_axis : {"z", "y"}
        Up axis of the file; "y" means x East, y Up, z South (glTF).
    level : bool
        Whether up is known but north is not.
    """

    kind: FrameKind = "undeclared"
    crs: str | None = None
    unit_m: float = 1.0
    up_axis: UpAxis = "z"
    level: bool = False

    @property
    def has_north(self) -> bool:
        """Whether north (and therefore up) is known."""
        return self.kind in ("crs", "local", "oriented")

    @property
    def has_up(self) -> bool:
        return self.level or self.has_north

    @property
    def has_metres(self) -> bool:
        return self.kind in ("crs", "local", "scaled")

    @property
    def axes(self) -> Axes:
        """Description of the axes of the World frame for files and labels."""
        return Axes(self.has_metres, self.has_north)

    def to_world(self) -> Matrix:
        """Return the 4x4 similarity from the file frame to the World frame.

        The World frame is x East, y North, z Up, in metres.
        """
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
        """Return a short name for badges and table headers."""
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
        """Describe which of north, vertical, scale and position are known."""
        components = (
            (tr("north"), self.has_north),
            (tr("vertical"), self.has_up),
            (tr("scale"), self.has_metres),
            (tr("position"), self.kind == "crs"),
        )
        known_names = ", ".join(name for name, is_known in components if is_known)
        missing_names = ", ".join(name for name, is_known in components if not is_known)
        if not missing_names:
            return tr("Known: {what}.", what=known_names)
        if not known_names:
            return tr("Not known: {what}.", what=missing_names)
        return tr("Known: {known}. Not known: {lacking}.", known=known_names, lacking=missing_names)


@lru_cache(maxsize=64)
def crs_label(crs: str) -> str:
    """Return the code of a CRS, or the name in its WKT.

    Parameters
    ----------
    crs : str
        "EPSG:n" or WKT.

    Returns
    -------
    str
    """
    match = re.match(r'\w+\["([^"]+)"', crs)
    return match[1] if match else crs


UNDECLARED_FRAME = Frame()

WORLD_NORTHS = {
    "crs": "grid north of the CRS",
    "world": "y of World",
    "unknown": "not known: angles are of the model's own frame",
}
"""North direction of the World frame for the sidecar files of rasters, in English."""


def world_north(crs: str | None, *, is_known: bool) -> str:
    """Return the north direction of a World frame for the sidecar files of rasters.

    Parameters
    ----------
    crs : str or None
        CRS of the World frame.
    is_known : bool
        Whether north is known.

    Returns
    -------
    str
    """
    return WORLD_NORTHS["unknown" if not is_known else "world" if crs is None else "crs"]
