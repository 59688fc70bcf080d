"""Jobs that read a reconstruction for inspection.

In the requests, `out` is the folder of the reconstruction, and `folder` is the output file for the
arrays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.progress import Progress
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane, NoArguments


@dataclass(frozen=True)
class AlignmentRequest:
    """Request for the overview of an alignment."""

    out: Path


@dataclass(frozen=True)
class AlignedPhoto:
    """Photo of an alignment.

    Parameters
    ----------
    part : int or None
        Number of the connected component, 0 for the component of the model; None if the photo
        was not aligned.
    reason : str or None
        Reason why the photo was not aligned, or None.
    error_px, largest_px : float or None
        Median and maximum reprojection error of the tie points, pixels.
    gps_m : float or None
        Distance between the computed position and the GPS position, metres.
    """

    name: str
    width: int
    height: int
    features: int
    part: int | None
    reason: str | None
    tie_points: int
    error_px: float | None
    largest_px: float | None
    gps_m: float | None
    has_depths: bool


@dataclass(frozen=True)
class AlignedCamera:
    """Calibration of a camera.

    Parameters
    ----------
    names, values : tuple
        Parameters of the camera model.
    sigma, correlation : tuple
        Standard deviations and correlations; None for undetermined parameters.
    focal : {"held", "freed"}
        Whether the focal length was fixed or estimated.
    strongest : (str, str, float) or None
        The most strongly correlated pair of parameters.
    """

    model: str
    names: tuple[str, ...]
    values: tuple[float, ...]
    sigma: tuple[float | None, ...]
    correlation: tuple[tuple[float | None, ...], ...]
    photos: tuple[str, ...]
    focal: str
    reason: str
    exif_px: float | None
    convergence_deg: float | None
    strongest: tuple[str, str, float] | None


@dataclass(frozen=True)
class AlignmentOverview:
    """Overview of an alignment; see `inspection.overview`.

    Each row of `pairs` contains the indices of two photos, and their numbers of tentative and
    verified matches.
    """

    folder: str | None
    photos: tuple[AlignedPhoto, ...]
    pairs: tuple[tuple[int, int, int, int], ...]
    weak_below: int
    cameras: tuple[AlignedCamera, ...]
    reprojection_error_px: float | None
    tie_points: int
    scaled: bool
    crs: str | None
    registration: Mapping[str, Any]


EMPTY_OVERVIEW = AlignmentOverview(None, (), (), 0, (), None, 0, False, None, {})


def _alignment(request: AlignmentRequest, progress: Progress) -> AlignmentOverview:
    from vomstudio.photogrammetry.inspect.inspection import overview

    return serialisation.decode(AlignmentOverview, overview(request.out))


INSPECT_ALIGNMENT = Job(
    "inspect_alignment", Lane.INSPECTION, AlignmentRequest, AlignmentOverview, _alignment
)


@dataclass(frozen=True)
class PairRequest:
    """Request for the matches of the photos `a` and `b`."""

    out: Path
    folder: Path
    a: str
    b: str


def _pair(request: PairRequest, progress: Progress) -> NoArguments:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import pair

    matches = pair(request.out, request.a, request.b)
    np.savez(
        request.folder,
        left=matches.left,
        right=matches.right,
        matches=matches.matches,
        refused=matches.refused,
    )
    return NoArguments()


INSPECT_PAIR = Job("inspect_pair", Lane.INSPECTION, PairRequest, NoArguments, _pair)
"""Read the features and matches of two photos."""


@dataclass(frozen=True)
class PhotoRequest:
    """Request for data of a photo."""

    out: Path
    folder: Path
    name: str


def _residuals(request: PhotoRequest, progress: Progress) -> NoArguments:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import residual_vectors

    pixels, vectors = residual_vectors(request.out, request.name)
    np.savez(request.folder, pixels=pixels, vectors=vectors)
    return NoArguments()


INSPECT_RESIDUALS = Job("inspect_residuals", Lane.INSPECTION, PhotoRequest, NoArguments, _residuals)
"""Read the residual vectors of a photo."""


@dataclass(frozen=True)
class DepthSummary:
    """Colour range of a depth picture, and the share of pixels with a depth."""

    low: float
    high: float
    coverage: float


def _depths(request: PhotoRequest, progress: Progress) -> DepthSummary:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import depth_pictures

    depths = depth_pictures(request.out, request.name)
    np.savez(
        request.folder,
        photo=depths.photo,
        depth=depths.depth,
        colors=depths.colors,
        confidence=depths.confidence,
        normals=depths.normals,
    )
    return DepthSummary(depths.low, depths.high, depths.coverage)


INSPECT_DEPTHS = Job("inspect_depths", Lane.INSPECTION, PhotoRequest, DepthSummary, _depths)
"""Write the depth map of a photo as pictures."""

JOBS = (INSPECT_ALIGNMENT, INSPECT_PAIR, INSPECT_RESIDUALS, INSPECT_DEPTHS)
