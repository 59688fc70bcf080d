"""Calibrated photos of which the edges that a network finds are seen in place of their pixels."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path

from vomstudio.core.arrays import ByteArray
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.proposals.edge_pictures import Find


@dataclass(frozen=True, eq=False)
class EdgePhotos(CalibratedPhotos):
    """find : by which edges are found, once a photo is asked for; folder : for pictures"""

    find: Find = lambda pictures, folder: ()
    folder: Path = Path()

    def pixels(self, view: int) -> ByteArray:
        (made,) = self.find([self.files[view]], self.folder / str(view))
        shown = replace(self, files={**self.files, view: made})
        return CalibratedPhotos.pixels(shown, view)


def showing_edges(photos: CalibratedPhotos, find: Find, folder: Path) -> EdgePhotos:
    """The same photos, looked at by a network."""
    own = {each.name: getattr(photos, each.name) for each in fields(photos)}
    return EdgePhotos(**own, find=find, folder=folder)
