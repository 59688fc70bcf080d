"""Jobs that read a reconstruction for inspection: small things as values, large as arrays in
files. `out` is the reconstruction's folder, `into` the file for the arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.progress import Progress
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane, Nothing


@dataclass(frozen=True)
class AlignmentIn:
    """out : the reconstruction's folder"""

    out: Path


@dataclass(frozen=True)
class AlignedPhoto:
    """part : 0 for the model's own, None where it was not placed, for the `reason`; error_px :
    median of its tie points; gps_m : by how much it misses its GPS position"""

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
    """values : of the parameters `names`; sigma, correlation : None where they are undetermined;
    focal : "held" or how it was found; strongest : the pair that is hardest to tell apart"""

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
    """See `inspection.overview`. pairs : rows of two photos, matches tried and kept."""

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


NOTHING_ALIGNED = AlignmentOverview(None, (), (), 0, (), None, 0, False, None, {})


def _alignment(asked: AlignmentIn, progress: Progress) -> AlignmentOverview:
    from vomstudio.photogrammetry.inspect.inspection import overview

    return serialisation.decode(AlignmentOverview, overview(asked.out))


INSPECT_ALIGNMENT = Job(
    "inspect_alignment", Lane.INSPECTION, AlignmentIn, AlignmentOverview, _alignment
)


@dataclass(frozen=True)
class PairIn:
    """a, b : names of two photos"""

    out: Path
    into: Path
    a: str
    b: str


def _pair(asked: PairIn, progress: Progress) -> Nothing:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import pair

    found = pair(asked.out, asked.a, asked.b)
    np.savez(
        asked.into,
        left=found.left,
        right=found.right,
        matches=found.matches,
        refused=found.refused,
    )
    return Nothing()


INSPECT_PAIR = Job("inspect_pair", Lane.INSPECTION, PairIn, Nothing, _pair)
"""The features and matches of two photos."""


@dataclass(frozen=True)
class PhotoIn:
    """name : of a photo"""

    out: Path
    into: Path
    name: str


def _residuals(asked: PhotoIn, progress: Progress) -> Nothing:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import residual_vectors

    pixels, vectors = residual_vectors(asked.out, asked.name)
    np.savez(asked.into, pixels=pixels, vectors=vectors)
    return Nothing()


INSPECT_RESIDUALS = Job("inspect_residuals", Lane.INSPECTION, PhotoIn, Nothing, _residuals)
"""The residual vectors of a photo."""


@dataclass(frozen=True)
class DepthFacts:
    """low, high : ends of the colours; coverage : share of the pixels that have a depth"""

    low: float
    high: float
    coverage: float


def _depths(asked: PhotoIn, progress: Progress) -> DepthFacts:
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import depth_pictures

    made = depth_pictures(asked.out, asked.name)
    np.savez(
        asked.into,
        photo=made.photo,
        depth=made.depth,
        colors=made.colors,
        confidence=made.confidence,
        normals=made.normals,
    )
    return DepthFacts(made.low, made.high, made.coverage)


INSPECT_DEPTHS = Job("inspect_depths", Lane.INSPECTION, PhotoIn, DepthFacts, _depths)
"""The depth map of a photo as pictures."""

JOBS = (INSPECT_ALIGNMENT, INSPECT_PAIR, INSPECT_RESIDUALS, INSPECT_DEPTHS)
