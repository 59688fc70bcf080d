"""Where marked points are seen: marks of a table joined to the photos of a scene by their names."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.io.control import Mark
from vomstudio.photogrammetry.scene import SparseScene
from vomstudio.photogrammetry.tied import triangulate

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sighting:
    """views : (k,) rows of the views in which a point is marked; pixels : (k, 2)"""

    views: npt.NDArray[np.int64]
    pixels: Array

    def place(self, scene: SparseScene) -> Array:
        """(3,) in the frame of the scene; NaN where the rays do not say."""
        return triangulate([scene.views[row] for row in self.views], self.pixels)


NOWHERE = Sighting(np.zeros(0, np.int64), np.zeros((0, 2)))


def sightings(scene: SparseScene, marks: Sequence[Mark]) -> tuple[dict[str, Sighting], set[str]]:
    """(by label, in the order of the marks; names of photos that are marked and not placed).

    A photo may be named without its folder where no other has the same name.
    """
    rows: dict[str, int] = {}
    shorter: dict[str, list[int]] = {}
    for row, view in enumerate(scene.views):
        rows[view.name] = row
        shorter.setdefault(_last(view.name), []).append(row)
    found: dict[str, tuple[list[int], list[tuple[float, float]]]] = {}
    missing = set()
    for mark in marks:
        same = shorter.get(_last(mark.photo), [])
        row = rows.get(mark.photo, same[0] if len(same) == 1 else -1)
        if row < 0:
            missing.add(mark.photo)
            continue
        views, pixels = found.setdefault(mark.label, ([], []))
        views.append(row)
        pixels.append((mark.x, mark.y))
    return {
        label: Sighting(np.array(views, np.int64), np.array(pixels, np.float64).reshape(-1, 2))
        for label, (views, pixels) in found.items()
    }, missing


def some(names: Collection[str]) -> str:
    """The first few of them, for a sentence."""
    shown = sorted(names)[:4]
    return ", ".join(shown) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def _last(name: str) -> str:
    return name.rsplit("/", 1)[-1].casefold()
