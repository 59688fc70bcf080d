"""Records of photo models: the photos, their masks, marked points and reconstructions."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.geometry.matrices import Point


@dataclass(frozen=True)
class Asset:
    """File of the project that is too large for a journal row.

    `path` is relative to the project folder. The name is the hash of the content, and the file is
    never overwritten, so undo can find it. `size` is in bytes.
    """

    path: str
    size: int


@dataclass(frozen=True)
class PhotoSet:
    """Folder of photos.

    `path` is stored in the same way as that of a Model. `crs` is "EPSG:n" or the WKT of the CRS of
    the points, or "" if unknown. Control points, marks and masks found next to the photos are
    stored as records; those files are exports.
    """

    id: str
    name: str
    path: str
    crs: str = ""


@dataclass(frozen=True)
class Mask:
    """Used part of a photo.

    `photo` is the name of the photo in the set. `file` is an image of the same size as the stored
    photo, in which the used pixels are white.
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
    """Point that is marked in photos of a set.

    `position` contains east, north and up in the CRS of the set in metres, or None for a tie point.
    `sigma_m` contains the standard deviation of each coordinate, or None if not stated. `check`
    marks a check point, which is not used for the model.
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

    `photo` is the name of the photo in the set; x and y are pixel coordinates in the stored photo,
    measured from the outer corner of its top-left pixel.
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
    """Model reconstructed from a photo set.

    Attributes
    ----------
    folder : str
        Path relative to the project's folder of reconstructions.
    result_sha256 : str
        Hash of the file reconstruction.json, which contains all figures.
    settings : tuple of tuple of str
        Names and values of the settings that were requested.
    registered, photos : int
        Number of aligned photos, and total number of photos.
    finished : str
        Time of completion in UTC as ISO 8601.
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
