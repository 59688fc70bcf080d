"""A photo as the lists show it."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class PhotoRow:
    """place: (x, y) metres in plan; looks: unit (dx, dy) or None. found_mask: the mask that lies
    beside the photo; mask: the one that is used."""

    name: str
    path: str
    width: int
    height: int
    camera: str
    focal: str
    taken: str
    has_gps: bool
    mask: str | None
    thumbnail: str | None = None
    place: tuple[float, float] | None = None
    looks: tuple[float, float] | None = None
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    findings: list[str] = field(default_factory=list)
    found_mask: str | None = None
    found_sha256: str = ""
