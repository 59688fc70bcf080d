"""Accuracy of a scene that camera positions or control points have placed in World."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import Bowing, LensBend
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.ground_adjustment import KnownCentre, KnownPoint
from vomstudio.photogrammetry.place.ground_calibration import LensVerdict
from vomstudio.photogrammetry.place.lens_errors import lens_effect, same
from vomstudio.registration.remarks import bowing_findings, lens_findings
from vomstudio.registration.scatter import Scatter, scale_findings
from vomstudio.registration.similarity import Similarity, fit_similarity

Array = npt.NDArray[np.float64]

MAX_ROTATION_ERROR_DEG = 40.0
"""One sigma of a rotation above which points determine no direction."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Placement:
    """What the reports on a registration by camera positions and by control points share.

    sigma_m, sigma_height_m : error of a horizontal coordinate and of a height, from the residuals
        of a similarity or as stated, whichever is more
    scale : units of the scene to metres; scale_error : relative, one sigma
    rotation_error_deg : (about east, about north, about up), one sigma; tilt_error_deg : of the
        vertical, by which dips may be wrong
    adjusted : whether the bundle was adjusted together with the positions or control points
    decisions : why or why not, and what became of the lenses; lenses : the latter in numbers
    covariance : (7, 7) as in `Scatter`, about `centre` (World), with what the lenses may do to the
        model
    bowing : by the residuals; lens_bend : by the errors of the lenses, None if these are not known
    """

    sigma_m: float
    sigma_height_m: float
    scale: float
    scale_error: float
    rotation_error_deg: tuple[float, float, float]
    tilt_error_deg: float
    crs: str | None
    adjusted: bool
    decisions: tuple[Finding, ...]
    lenses: tuple[LensVerdict, ...]
    covariance: Array
    centre: tuple[float, float, float]
    bowing: Bowing | None
    lens_bend: LensBend | None
    warnings: tuple[Finding, ...] = ()

    @property
    def bowing_findings(self) -> list[Finding]:
        """Return the findings about bowing by the residuals and by the lenses."""
        return [*bowing_findings(self.bowing), *lens_findings(self.lens_bend, self.bowing)]

    def findings(self, limit_deg: float, by: str) -> Iterator[Finding]:
        """Report a weak rotation or scale, and bowing. limit_deg : error of a rotation, one sigma;
        by : "gps" or "control" """
        azimuth_deg = self.rotation_error_deg[2]
        if max(self.tilt_error_deg, azimuth_deg) > limit_deg:
            yield Finding(
                "registration.weak-rotation",
                sigma_m=self.sigma_m,
                azimuth_deg=azimuth_deg,
                tilt_deg=self.tilt_error_deg,
                by=by,
            )
        yield from scale_findings(self.scale_error)
        yield from self.bowing_findings


def placement_errors(
    scene: SparseScene,
    cameras: Sequence[Calibration],
    scatter: Scatter,
    locate: Callable[[SparseScene], Array],
    targets: Array,
    *,
    lenses: Sequence[LensVerdict] | None,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
) -> dict[str, Any]:
    """Return the fields of `Placement` that state errors.

    Parameters
    ----------
    scene : SparseScene
        In World.
    cameras : sequence of Calibration
        As they were calibrated.
    scatter : Scatter
        Of the placement.
    locate : callable
        Returns the places (n, 3) in a scene of what it was placed by.
    targets : (n, 3) array
        Where these are, less the origin of the scene.
    lenses : sequence of LensVerdict or None
        What became of the lenses in the adjustment to `points` and `centres`; None if the scene was
        not adjusted.
    """

    def place_again(other: SparseScene) -> Similarity:
        return fit_similarity(locate(other), targets)

    about = targets.mean(axis=0)
    if lenses is None:
        effect = lens_effect(scene, cameras, about, place_again)
    else:
        effect = lens_effect(scene, cameras, about, same, points, centres, lenses)
    covariance = scatter.covariance + (0.0 if effect is None else effect.covariance)
    east, north, up = (float(turn) for turn in np.degrees(np.sqrt(np.diag(covariance)[:3])))
    x, y, z = (float(value) for value in about + np.array(scene.origin))
    return {
        "sigma_m": scatter.horizontal_sigma,
        "sigma_height_m": float(scatter.sigma[2]),
        "scale_error": float(np.sqrt(covariance[3, 3])),
        "rotation_error_deg": (east, north, up),
        "tilt_error_deg": math.hypot(east, north),
        "covariance": covariance,
        "centre": (x, y, z),
        "lens_bend": None if effect is None else effect.bend,
    }
