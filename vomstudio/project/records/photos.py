"""What a model made of photos rests on: the photos, their masks, marked points, reconstructions."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class Asset:
    """A file of the project that is too large for a row of the journal.

    path: relative to the project folder. It is named by its content and never written again, so
    that undoing finds what was there; size: bytes.
    """

    path: str
    size: int


@dataclass(frozen=True)
class PhotoSet:
    """A folder of photos. `path` is written down like that of a Model. crs: "EPSG:n" or WKT of
    the coordinates of its points, "" if not known. The control points, marks and masks that lay
    beside the photos are records; those files are exports."""

    id: str
    name: str
    path: str
    crs: str = ""


@dataclass(frozen=True)
class Mask:
    """Where a photo is not used. photo: its name in the set; file: a picture of the photo's size
    as it is stored, white where it is used."""

    id: str
    photo_set_id: str
    photo: str
    file: Asset

    @property
    def name(self) -> str:
        return self.photo


@dataclass(frozen=True)
class MarkedPoint:
    """A place that is marked in photos of a set.

    position: east, north, up in the CRS of the set, metres; None for a tie point. sigma_m: of each
    coordinate, None where not stated. check: it judges the model and does not place it.
    """

    id: str
    photo_set_id: str
    label: str
    position: Point | None = None
    sigma_m: float | None = None
    check: bool = False

    @property
    def name(self) -> str:
        return self.label


@dataclass(frozen=True)
class ImageMark:
    """Where a marked point is seen. photo: its name in the set; x, y: pixels of the photo as it is
    stored, from the outer corner of its top left pixel."""

    id: str
    point_id: str
    photo: str
    x: float
    y: float

    @property
    def name(self) -> str:
        return self.photo


@dataclass(frozen=True)
class Reconstruction:
    """A model that was made of a set of photos.

    folder: below the project's folder of reconstructions; result_sha256: of its
    reconstruction.json, which holds all figures. settings: names and values of what was asked
    for. registered, photos: how many photos were aligned, of how many. finished: when, ISO 8601 in
    UTC.
    """

    id: str
    photo_set_id: str
    name: str
    folder: str
    quality: str
    result_sha256: str
    settings: tuple[tuple[str, str], ...] = ()
    photos: int = 0
    registered: int = 0
    reprojection_error_px: float | None = None
    software: str = ""
    finished: str = ""
