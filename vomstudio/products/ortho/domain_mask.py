"""One domain of an outcrop in a picture, the rest of it grey (textbook 4.2, fig. 31c).

A picture looks along one direction, which is right for one domain only where each has an axis of
its own. What of the surface is of the domain is told by the features that were put into domains: a
fault whose plane has all features of the domain on one side and all of another one on the other
parts them, and where none does, the nearest feature decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.statistics import flip_to, orientation_tensor
from vomstudio.products.ortho.domain_axes import FAULTS, domains_of, no_domains, off_axis
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.ortho.planning import Plan
from vomstudio.products.ortho.tiles import Source, Tile, TilePicture

_SIDE_SHARE = 0.98
"""Of the points of a domain those that lie on its side of a fault which parts it: the traces of
beds that are dragged along the fault reach a little beyond its mean plane."""
_CELL = 8
"""Pixels of the cells for whose middles the nearest feature is looked for."""
_MOST_POINTS = 20_000
_LUMA = np.array([0.299, 0.587, 0.114], np.float32)
_GREY, _KEPT = 205.0, 0.25
"""To what the rest is faded, and how much of its lightness is left."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A plane x . normal = offset; the domain lies where x . normal is larger."""

    name: str
    normal: FloatArray
    offset: float


@dataclass(frozen=True, eq=False)
class Territory:
    """Where one domain is. walls : faults that part it from others; points, own : (n, 3) of the
    features that decide where no wall does, and which are of the domain; empty where walls do"""

    name: str
    walls: tuple[Wall, ...]
    points: FloatArray
    own: BoolArray
    notes: tuple[Finding, ...]

    def features(self, items: Sequence[Item]) -> tuple[Item, ...]:
        """Those of the domain, and of no domain: of others the picture shows no true angles."""
        return tuple(item for item in items if item.domain in ("", self.name))

    def seen_in(self, items: Sequence[Item], plan: Plan) -> Territory:
        """Return the territory with findings if the view is not along the domain's axis."""
        return replace(self, notes=(*self.notes, *off_axis(items, self.name, plan)))

    @property
    def facts(self) -> dict[str, Any]:
        """For the sidecar of its picture."""
        return {"name": self.name, "ends_at": [wall.name for wall in self.walls]}

    @cached_property
    def tree(self) -> Any:
        from scipy.spatial import KDTree

        return KDTree(self.points)


def territory(items: Sequence[Item], name: str, field: str = "--domain") -> Territory:
    """Of the domain `name`. Raises UsageError where no feature is in it."""
    known = domains_of(items)
    if not known:
        raise no_domains(field)
    if name not in known:
        raise UsageError(Finding("domain.unknown", domain=name, domains=known), field=field)
    others = [each for each in known if each != name]
    by_domain = {each: _points(items, each) for each in known}
    walls: list[Wall] = []
    left = list(others)
    for wall in _faults(items):
        own = by_domain[name] @ wall.normal > wall.offset
        sign = 1.0 if own.mean() >= 0.5 else -1.0
        turned = Wall(wall.name, sign * wall.normal, sign * wall.offset)
        if _share(by_domain[name], turned) < _SIDE_SHARE:
            continue
        parted = [each for each in others if 1.0 - _share(by_domain[each], turned) >= _SIDE_SHARE]
        if parted:
            walls.append(turned)
            left = [each for each in left if each not in parted]
    notes = []
    if walls:
        faults = tuple(dict.fromkeys(wall.name for wall in walls))
        notes.append(Finding("domain.ends-at-faults", domain=name, faults=faults))
    if not left:
        return Territory(name, tuple(walls), np.empty((0, 3)), np.empty(0, np.bool_), tuple(notes))
    if others:
        notes.append(Finding("domain.no-fault-between", domain=name, others=left))
    points = [by_domain[name], *(by_domain[each] for each in left)]
    own = np.repeat([True, *[False] * len(left)], [len(part) for part in points])
    return Territory(name, tuple(walls), np.concatenate(points), own, tuple(notes))


def _points(items: Sequence[Item], name: str) -> FloatArray:
    every = np.concatenate([item.points for item in items if item.domain == name])
    every = every[np.isfinite(every).all(axis=1)]
    return np.asarray(every[:: max(1, len(every) // _MOST_POINTS)])


def _share(points: FloatArray, wall: Wall) -> float:
    """Of points those on the domain's side."""
    return float((points @ wall.normal > wall.offset).mean())


def _faults(items: Sequence[Item]) -> list[Wall]:
    """A plane for each fault: the mean of those of one set, else each by itself."""
    sets: dict[str, list[Item]] = {}
    for item in items:
        if item.normal is not None and item.kind.casefold() == FAULTS:
            sets.setdefault(item.set or item.id, []).append(item)
    found = []
    for own in sets.values():
        normals = np.array([item.normal for item in own], np.float64)
        mean = flip_to(normals, orientation_tensor(normals)[1][0]).mean(axis=0)
        mean /= np.linalg.norm(mean)
        middle = np.mean([item.points.mean(axis=0) for item in own], axis=0)
        name = own[0].set if len(own) > 1 else own[0].name
        found.append(Wall(name, mean, float(middle @ mean)))
    return found


@dataclass(frozen=True, eq=False)
class OneDomain:
    """Draws the tiles of another source with all but one domain in grey."""

    source: Source
    plan: Plan
    territory: Territory

    @property
    def hole_m(self) -> float | None:
        return getattr(self.source, "hole_m", None)

    def warnings(self) -> list[Finding]:
        return [*self.source.warnings(), *self.territory.notes]

    def draw(self, tile: Tile) -> TilePicture:
        picture = self.source.draw(tile)
        seen = np.isfinite(picture.depth)
        if not seen.any():
            return picture
        rest = seen & ~self._own(tile, picture.depth)
        rgba = picture.rgba.copy()
        shade = rgba[rest, :3] @ _LUMA
        rgba[rest, :3] = np.rint(_GREY + _KEPT * (shade - 128.0)).clip(0, 255)[:, None]
        return replace(picture, rgba=rgba)

    def _own(self, tile: Tile, depth: Float32Array) -> BoolArray:
        """(h, w) which pixels show the domain; of those that show nothing, anything."""
        own = np.ones(depth.shape, np.bool_)
        right = np.arange(tile.width) + tile.column + 0.5
        down = np.arange(tile.height)[:, None] + tile.row + 0.5
        matrix = self.plan.pixel_to_world
        for wall in self.territory.walls:
            a, b, c, d = (wall.normal @ matrix[:3]).tolist()
            own &= a * right + b * down + c * depth + d > wall.offset
        if len(self.territory.points):
            own &= self._nearest(tile, depth, matrix)
        return own

    def _nearest(self, tile: Tile, depth: Float32Array, matrix: FloatArray) -> BoolArray:
        """Whether a feature of the domain is the nearest, for cells of some pixels."""
        rows, columns = (np.arange(0, size, _CELL) for size in depth.shape)
        tall, wide = -(-depth.shape[0] // _CELL), -(-depth.shape[1] // _CELL)
        padded = np.full((tall * _CELL, wide * _CELL), np.nan, np.float32)
        padded[: depth.shape[0], : depth.shape[1]] = depth
        cells = padded.reshape(tall, _CELL, wide, _CELL)
        count = np.isfinite(cells).sum(axis=(1, 3))
        middle = np.nansum(cells, axis=(1, 3)) / np.maximum(count, 1)
        own = np.ones((tall, wide), np.bool_)
        j, i = np.nonzero(count)
        places = (
            np.column_stack(
                [
                    columns[i] + tile.column + _CELL / 2,
                    rows[j] + tile.row + _CELL / 2,
                    middle[j, i],
                    np.ones(len(i)),
                ]
            )
            @ matrix[:3].T
        )
        own[j, i] = self.territory.own[self.territory.tree.query(places)[1]]
        spread = own.repeat(_CELL, axis=0).repeat(_CELL, axis=1)
        return spread[: depth.shape[0], : depth.shape[1]]
