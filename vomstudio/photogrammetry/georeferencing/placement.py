"""Accuracy of a scene registered in the World frame by cameras or control points."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import Bowing, LensDeformation
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownCentre, KnownPoint
from vomstudio.photogrammetry.georeferencing.ground_calibration import LensVerdict
from vomstudio.photogrammetry.georeferencing.lens_errors import identity_placement, lens_effect
from vomstudio.registration.scatter import Scatter, scale_findings
from vomstudio.registration.similarity import Similarity, fit_similarity
from vomstudio.registration.warnings import bowing_findings, lens_findings

MAX_ROTATION_ERROR_DEG = 40.0
"""If one sigma of a rotation is larger, the points do not determine directions."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Placement:
    """Accuracy of a registration by camera positions or by control points.

    Parameters
    ----------
    sigma_m, sigma_height_m : float
        Standard deviations of a horizontal coordinate and of a height, from the residuals of a
        similarity or as stated, whichever is larger.
    scale, scale_error : float
        Metres per unit of the scene, and its relative standard deviation.
    rotation_error_deg : (float, float, float)
        Standard deviations about east, north and up.
    tilt_error_deg : float
        Standard deviation of the vertical, which affects dips.
    crs : str or None
    adjusted : bool
        Whether the bundle was adjusted together with the camera positions or control points.
    decisions : tuple of Finding
        Reasons why the bundle was or was not adjusted, and how the lenses were treated.
    lenses : tuple of LensVerdict
        Treatment of the lenses, with numbers.
    covariance : (7, 7) array
        Covariance of the registration with respect to `centre`, as in `Scatter`; includes the
        effect of lens errors.
    centre : (float, float, float)
        Reference point of the covariance, in the World frame.
    bowing : Bowing or None
        Bowing estimated from the residuals.
    lens_bend : LensDeformation or None
        Bend estimated from the errors of the lenses; None if these are not known.
    warnings : tuple of Finding
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
    covariance: FloatArray
    centre: tuple[float, float, float]
    bowing: Bowing | None
    lens_bend: LensDeformation | None
    warnings: tuple[Finding, ...] = ()

    @property
    def bowing_findings(self) -> list[Finding]:
        """Findings about bowing estimated from the residuals and from the lenses."""
        return [*bowing_findings(self.bowing), *lens_findings(self.lens_bend, self.bowing)]

    def findings(self, limit_deg: float, by: str) -> Iterator[Finding]:
        """Report a poorly determined rotation or scale, and bowing.

        Parameters
        ----------
        limit_deg : float
            Maximum standard deviation of a rotation.
        by : {"gps", "control"}
        """
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
    locate: Callable[[SparseScene], FloatArray],
    targets: FloatArray,
    *,
    lenses: Sequence[LensVerdict] | None,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
) -> dict[str, Any]:
    """Compute the fields of `Placement` that contain errors.

    Parameters
    ----------
    scene : SparseScene
        Registered scene, in the World frame.
    cameras : sequence of Calibration
        Calibration before the adjustment.
    scatter : Scatter
        Scatter of the residuals.
    locate : callable
        Function that returns the positions (n, 3) of the cameras or control points in a scene.
    targets : (n, 3) array
        Known positions of these points, minus the origin of the scene.
    lenses : sequence of LensVerdict or None
        Treatment of the lenses in the adjustment to `points` and `centres`; None if the scene was
        not adjusted.
    points : sequence of KnownPoint, optional
    centres : sequence of KnownCentre, optional
        Control points and camera positions of the adjustment.
    """

    def fit_placement(other_scene: SparseScene) -> Similarity:
        return fit_similarity(locate(other_scene), targets)

    centre = targets.mean(axis=0)
    if lenses is None:
        effect = lens_effect(scene, cameras, centre, fit_placement)
    else:
        effect = lens_effect(scene, cameras, centre, identity_placement, points, centres, lenses)
    covariance = scatter.covariance + (0.0 if effect is None else effect.covariance)
    east, north, up = (float(angle) for angle in np.degrees(np.sqrt(np.diag(covariance)[:3])))
    x, y, z = (float(value) for value in centre + np.array(scene.origin))
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
