"""Records of photo models: the photos, their masks, marked points and reconstructions."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class Asset:
    """A file of the project that is too large for a row of the journal.

    `path` is relative to the project folder; the name is the hash of the content and the file is
    never overwritten, so undo finds it. `size` is in bytes.
    """

    path: str
    size: int


@dataclass(frozen=True)
class PhotoSet:
    """A folder of photos.

    `path` is stored like that of a Model. `crs` is "EPSG:n" or WKT of the coordinates of its
    points, "" if unknown. Control points, marks and masks from beside the photos are records;
    those files are exports.
    """

    id: str
    name: str
    path: str
    crs: str = ""


@dataclass(frozen=True)
class Mask:
    """The used part of a photo.

    `photo` is its name in the set; `file` is an image of the size of the stored photo, white where
    it is used.
    """

    id: str
    photo_set_id: str
    photo: str
    file: Asset

    @property
    def name(self) -> str:
        return self.photo


@dataclass(frozen=True)
class MarkedPoint:
    """A point that is marked in photos of a set.

    `position` is east, north, up in the CRS of the set, metres, None for a tie point; `sigma_m` is
    that of each coordinate, None if not stated; `check` marks a check point, which is not used for
    the model.
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
    """Position of a marked point in a photo.

    `photo` is its name in the set; x, y are pixels of the stored photo, from the outer corner of
    its top left pixel.
    """

    id: str
    point_id: str
    photo: str
    x: float
    y: float

    @property
    def name(self) -> str:
        return self.photo


@dataclass(frozen=True)
class ReconstructionRecord:
    """A model that was reconstructed from a photo set.

    Attributes
    ----------
    folder : str
        Below the project's folder of reconstructions.
    result_sha256 : str
        Hash of its reconstruction.json, which contains all figures.
    settings : tuple of tuple of str
        Names and values of the requested settings.
    registered, photos : int
        Number of aligned photos, and of all photos.
    finished : str
        ISO 8601 time in UTC.
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
