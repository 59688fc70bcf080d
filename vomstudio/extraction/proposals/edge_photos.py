"""Calibrated photos whose pixels are replaced by the edges that a network detects."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path

from vomstudio.core.arrays import ByteArray
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.proposals.edge_pictures import EdgeDetector


@dataclass(frozen=True, eq=False)
class EdgePhotos(CalibratedPhotos):
    """Calibrated photos that show detected edges.

    Parameters
    ----------
    find : callable
        Function that detects edges when a photo is first requested.
    folder : Path
        Folder for the edge pictures.
    """

    find: EdgeDetector = lambda pictures, folder: ()
    folder: Path = Path()

    def pixels(self, view: int) -> ByteArray:
        (edges,) = self.find([self.files[view]], self.folder / str(view))
        edge_photos = replace(self, files={**self.files, view: edges})
        return CalibratedPhotos.pixels(edge_photos, view)


def replace_by_edges(
    photos: CalibratedPhotos, find_edges: EdgeDetector, folder: Path
) -> EdgePhotos:
    """Replace the pixels of photos with detected edges.

    Parameters
    ----------
    photos : CalibratedPhotos
    find_edges : EdgeDetector
        Function that detects the edges in a photo.
    folder : Path
        Folder for the edge pictures.

    Returns
    -------
    EdgePhotos
    """
    values = {item.name: getattr(photos, item.name) for item in fields(photos)}
    return EdgePhotos(**values, find=find_edges, folder=folder)
