"""Mask that shows one domain of a picture and fades the others (textbook, fig. 31c).

If each domain has its own axis, a picture along one direction is valid for only one domain. The
extent of a domain is derived from its features. A fault separates two domains if all features of
one domain are on one side of it, and all features of the other domain on the other side. If no
fault separates them, the nearest feature determines the domain.
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
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor
from vomstudio.products.ortho.domain_axes import (
    FAULT_TYPE,
    domain_names,
    no_domains_error,
    off_axis_findings,
)
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.ortho.planning import OrthophotoPlan
from vomstudio.products.ortho.tiles import Tile, TilePicture, TileSource

_MIN_SIDE_SHARE = 0.98
"""Minimum share of the points of a domain that must lie on its side of a fault.

Traces of beds dragged along the fault extend slightly beyond its mean plane."""
_CELL_PX = 8
"""Side of the cells for which the nearest feature is determined, in pixels."""
_MAX_POINTS = 20_000
_LUMA_WEIGHTS = np.array([0.299, 0.587, 0.114], np.float32)
_FADED_LEVEL, _FADED_CONTRAST = 205.0, 0.25
"""Grey level of the faded part, and the share of its contrast that remains."""


@dataclass(frozen=True, eq=False)
class DomainBoundary:
    """Plane x . normal = offset; the domain is on the side where x . normal is larger."""

    name: str
    normal: FloatArray
    offset: float


@dataclass(frozen=True, eq=False)
class DomainExtent:
    """Extent of one domain.

    Parameters
    ----------
    name : str
    boundaries : tuple of DomainBoundary
        Faults that separate the domain from others.
    points : (n, 3) array
        Points of the features of this domain and of the domains that no boundary separates from
        it; empty if boundaries separate it from all others.
    is_member : (n,) bool array
        Whether each of these points belongs to the domain.
    notes : tuple of Finding
    """

    name: str
    boundaries: tuple[DomainBoundary, ...]
    points: FloatArray
    is_member: BoolArray
    notes: tuple[Finding, ...]

    def features(self, items: Sequence[Item]) -> tuple[Item, ...]:
        """Return the features of this domain and those without a domain.

        Angles of features of other domains would be distorted.
        """
        return tuple(item for item in items if item.domain in ("", self.name))

    def add_view_findings(self, items: Sequence[Item], plan: OrthophotoPlan) -> DomainExtent:
        """Return a copy with findings if the view is not along the axis of the domain."""
        return replace(self, notes=(*self.notes, *off_axis_findings(items, self.name, plan)))

    @property
    def metadata(self) -> dict[str, Any]:
        """Metadata of the domain for the sidecar of the picture."""
        return {"name": self.name, "ends_at": [boundary.name for boundary in self.boundaries]}

    @cached_property
    def tree(self) -> Any:
        """Search tree of the points."""
        from scipy.spatial import KDTree

        return KDTree(self.points)


def domain_extent(items: Sequence[Item], name: str, field: str = "--domain") -> DomainExtent:
    """Find the extent of a domain.

    Raises
    ------
    UsageError
        If no feature belongs to the domain.
    """
    known_domains = domain_names(items)
    if not known_domains:
        raise no_domains_error(field)
    if name not in known_domains:
        raise UsageError(Finding("domain.unknown", domain=name, domains=known_domains), field=field)
    other_domains = [item for item in known_domains if item != name]
    points_by_domain = {item: _points(items, item) for item in known_domains}
    boundaries: list[DomainBoundary] = []
    remaining_domains = list(other_domains)
    for boundary in _fault_boundaries(items):
        is_positive = points_by_domain[name] @ boundary.normal > boundary.offset
        sign = 1.0 if is_positive.mean() >= 0.5 else -1.0
        oriented_boundary = DomainBoundary(
            boundary.name, sign * boundary.normal, sign * boundary.offset
        )
        if _share_inside_boundary(points_by_domain[name], oriented_boundary) < _MIN_SIDE_SHARE:
            continue
        separated_domains = [
            item
            for item in other_domains
            if 1.0 - _share_inside_boundary(points_by_domain[item], oriented_boundary)
            >= _MIN_SIDE_SHARE
        ]
        if separated_domains:
            boundaries.append(oriented_boundary)
            remaining_domains = [
                item for item in remaining_domains if item not in separated_domains
            ]
    notes = []
    if boundaries:
        faults = tuple(dict.fromkeys(boundary.name for boundary in boundaries))
        notes.append(Finding("domain.ends-at-faults", domain=name, faults=faults))
    if not remaining_domains:
        return DomainExtent(
            name, tuple(boundaries), np.empty((0, 3)), np.empty(0, np.bool_), tuple(notes)
        )
    if other_domains:
        notes.append(Finding("domain.no-fault-between", domain=name, others=remaining_domains))
    points = [points_by_domain[name], *(points_by_domain[item] for item in remaining_domains)]
    is_positive = np.repeat(
        [True, *[False] * len(remaining_domains)], [len(part) for part in points]
    )
    return DomainExtent(name, tuple(boundaries), np.concatenate(points), is_positive, tuple(notes))


def _points(items: Sequence[Item], name: str) -> FloatArray:
    all_points = np.concatenate([item.points for item in items if item.domain == name])
    all_points = all_points[np.isfinite(all_points).all(axis=1)]
    return np.asarray(all_points[:: max(1, len(all_points) // _MAX_POINTS)])


def _share_inside_boundary(points: FloatArray, boundary: DomainBoundary) -> float:
    """Return the share of points on the domain's side of a boundary."""
    return float((points @ boundary.normal > boundary.offset).mean())


def _fault_boundaries(items: Sequence[Item]) -> list[DomainBoundary]:
    """Return the mean plane of each set of faults, and the plane of each other fault."""
    sets: dict[str, list[Item]] = {}
    for item in items:
        if item.normal is not None and item.kind.casefold() == FAULT_TYPE:
            sets.setdefault(item.set or item.id, []).append(item)
    boundaries = []
    for fault_set in sets.values():
        normals = np.array([item.normal for item in fault_set], np.float64)
        mean = flip_to_hemisphere(normals, orientation_tensor(normals)[1][0]).mean(axis=0)
        mean /= np.linalg.norm(mean)
        centre = np.mean([item.points.mean(axis=0) for item in fault_set], axis=0)
        name = fault_set[0].set if len(fault_set) > 1 else fault_set[0].name
        boundaries.append(DomainBoundary(name, mean, float(centre @ mean)))
    return boundaries


@dataclass(frozen=True, eq=False)
class DomainTileSource:
    """Source of tiles in which all domains but one are greyed out."""

    source: TileSource
    plan: OrthophotoPlan
    domain_extent: DomainExtent

    @property
    def hole_m(self) -> float | None:
        return getattr(self.source, "hole_m", None)

    def warnings(self) -> list[Finding]:
        return [*self.source.warnings(), *self.domain_extent.notes]

    def draw(self, tile: Tile) -> TilePicture:
        picture = self.source.draw(tile)
        is_visible = np.isfinite(picture.depth)
        if not is_visible.any():
            return picture
        is_faded = is_visible & ~self._domain_pixels(tile, picture.depth)
        rgba = picture.rgba.copy()
        shade = rgba[is_faded, :3] @ _LUMA_WEIGHTS
        rgba[is_faded, :3] = np.rint(_FADED_LEVEL + _FADED_CONTRAST * (shade - 128.0)).clip(0, 255)[
            :, None
        ]
        return replace(picture, rgba=rgba)

    def _domain_pixels(self, tile: Tile, depth: Float32Array) -> BoolArray:
        """Return a mask (h, w) of pixels that show the domain; empty pixels are arbitrary."""
        is_domain = np.ones(depth.shape, np.bool_)
        right = np.arange(tile.width) + tile.column + 0.5
        down = np.arange(tile.height)[:, None] + tile.row + 0.5
        matrix = self.plan.pixel_to_world
        for boundary in self.domain_extent.boundaries:
            a, b, c, d = (boundary.normal @ matrix[:3]).tolist()
            is_domain &= a * right + b * down + c * depth + d > boundary.offset
        if len(self.domain_extent.points):
            is_domain &= self._nearest(tile, depth, matrix)
        return is_domain

    def _nearest(self, tile: Tile, depth: Float32Array, matrix: FloatArray) -> BoolArray:
        """Return, for cells of several pixels, whether the nearest feature is in the domain."""
        rows, columns = (np.arange(0, size, _CELL_PX) for size in depth.shape)
        height, width = -(-depth.shape[0] // _CELL_PX), -(-depth.shape[1] // _CELL_PX)
        padded_cells = np.full((height * _CELL_PX, width * _CELL_PX), np.nan, np.float32)
        padded_cells[: depth.shape[0], : depth.shape[1]] = depth
        cells = padded_cells.reshape(height, _CELL_PX, width, _CELL_PX)
        count = np.isfinite(cells).sum(axis=(1, 3))
        middle = np.nansum(cells, axis=(1, 3)) / np.maximum(count, 1)
        is_domain = np.ones((height, width), np.bool_)
        j, i = np.nonzero(count)
        positions = (
            np.column_stack(
                [
                    columns[i] + tile.column + _CELL_PX / 2,
                    rows[j] + tile.row + _CELL_PX / 2,
                    middle[j, i],
                    np.ones(len(i)),
                ]
            )
            @ matrix[:3].T
        )
        is_domain[j, i] = self.domain_extent.is_member[self.domain_extent.tree.query(positions)[1]]
        enlarged_mask = is_domain.repeat(_CELL_PX, axis=0).repeat(_CELL_PX, axis=1)
        return enlarged_mask[: depth.shape[0], : depth.shape[1]]
