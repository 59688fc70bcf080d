"""Rules that select which intrinsics of a camera are estimated.

Photos with parallel views cannot distinguish a longer lens from rock farther away: the adjustment
then returns a focal length with an error of 10 or 20 % but a formal error of half a per cent,
because it fits the deviation of the lens from its model. The formal error alone is therefore not
sufficient.

A focal length known from EXIF is freed only under three conditions: the photos of the camera view
the same rock from sufficiently different directions (`MIN_CONVERGENCE_DEG`, root mean square about
their mean), there are enough photos, and the error of the freed value is small even if neighbouring
tie points are counted as one. Otherwise the focal length is fixed, unless the photos clearly
contradict it. They do so if the freed value differs by `MIN_EXIF_DIFFERENCE` or more and by several
times its error, and if the cross-validation error of the tie points falls below
`MAX_VALIDATION_RATIO` times the previous one. (If EXIF is right, the error decreases by a few
hundredths at best, because the freed value absorbs the misfit of the lens model.) An unknown focal
length is freed; if it cannot be determined, a typical focal length is assumed, and this is
reported. Radial distortion is determined by the overlap of any two photos, so it is free for a
camera with enough photos.

If there are enough photos, other lens parameters are tested: k2, without which a block of parallel
views bends like a dome, and the principal point. The latter is tested only for convergent photos
with a free focal length, since it is otherwise equivalent to a rotation of the camera. Each
parameter is estimated if its effect in the corner of the photo, beyond the effects of k1, focal
length and rotation, is at least `MIN_EFFECT_PX`, and if it is well determined with neighbouring tie
points counted as one: k2 must be at least `MIN_SIGMAS` times its error, and the error of the
principal point at most `MAX_CENTRE_SIGMA`, well below the differences between cameras. Both are
used only if they do not increase the cross-validation error. Decentring (p1, p2) has nearly the
same effect as a shift of the principal point and is represented by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

MIN_CONVERGENCE_DEG = 8.0
MIN_PHOTOS = 6
# If a camera has fewer photos, its distortion is fixed.
MIN_PHOTOS_DISTORTION = 2
MAX_RELATIVE_SIGMA = 0.01
MIN_EFFECT_PX = 0.1
MIN_SIGMAS = 3.0
# Relative error assumed for an unknown focal length: the typical difference between lenses.
UNKNOWN_FOCAL_SIGMA = 0.2
# Share of the long side: a 35 mm equivalent of 30 mm, between phones and drones (24 to 28 mm) and
# normal lenses (35 mm).
DEFAULT_FOCAL_RATIO = 0.83
MIN_EXIF_DIFFERENCE = 0.04
MAX_VALIDATION_RATIO = 0.93
# Share of the diagonal. Principal points are typically 0.5 % off the centre, so an estimate with
# less than half of that error is better than none.
MAX_CENTRE_SIGMA = 0.0025
MAX_CENTRE_SHIFT = 0.02
# Number of independent regions per photo: neighbouring points share the misfit of the lens model.
_INDEPENDENT_POINTS_PER_PHOTO = 50


@dataclass(frozen=True, eq=False)
class Calibration:
    """Camera after the adjustment.

    Attributes
    ----------
    names, values : tuple
        Names and values of the parameters, in COLMAP's order.
    sigma : (p,) tuple
        Standard deviations, with neighbouring points counted as one; 0 for fixed parameters.
    correlation : (p, p) tuple
        Correlations of the parameters; NaN for fixed ones.
    photos : tuple of str
    focal : {"held", "freed"}
    reasons : tuple of Finding
    exif_px : float or None
        Focal length from EXIF, in pixels.
    convergence_deg : float
        Root mean square angle between the optical axes and their mean.
    """

    model: str
    names: tuple[str, ...]
    values: tuple[float, ...]
    sigma: tuple[float, ...]
    correlation: tuple[tuple[float, ...], ...]
    photos: tuple[str, ...]
    focal: str
    reasons: tuple[Finding, ...]
    exif_px: float | None
    convergence_deg: float

    @property
    def strongest_correlation(self) -> tuple[str, str, float] | None:
        """Names of the two most correlated parameters, and their correlation; None if unknown."""
        table = np.abs(np.array(self.correlation, np.float64))
        table[~np.isfinite(table)] = 0
        np.fill_diagonal(table, 0)
        if not table.any():
            return None
        i, j = np.unravel_index(int(table.argmax()), table.shape)
        return self.names[i], self.names[j], self.correlation[i][j]


def convergence_deg(axes: FloatArray) -> float:
    """Return the RMS angle between unit vectors (n, 3) and their mean, in degrees.

    Returns 0 for fewer than two vectors, and 180 if their mean is zero.
    """
    if len(axes) < 2:
        return 0.0
    mean = axes.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 1e-9:
        return 180.0
    angles = np.degrees(np.arccos(np.clip(axes @ (mean / length), -1, 1)))
    return float(np.sqrt((angles**2).mean()))


@dataclass(frozen=True)
class Freedom:
    """Free parameters of a camera in the adjustment: focal length, k1, k2, principal point."""

    focal: bool
    distortion: bool
    second_radial: bool = False
    centre: bool = False


ALL_FIXED = Freedom(False, False)


def select_free_parameters(
    is_known: bool, photos: int, convergence: float, is_exif_trusted: bool = True
) -> tuple[Freedom, Finding]:
    """Return the free parameters of a camera in the first adjustment, and the reason.

    Parameters
    ----------
    is_known : bool
        Whether EXIF contains the focal length.
    photos : int
        Number of placed photos of the camera.
    convergence : float
        Convergence of all photos of the part, in degrees.
    is_exif_trusted : bool
        Whether the photos could be placed with the EXIF focal length.
    """
    distortion = photos >= MIN_PHOTOS_DISTORTION
    is_weak = convergence < MIN_CONVERGENCE_DEG
    if not is_known:
        if is_weak:
            return Freedom(True, distortion), Finding("lens.focal-weak", spread_deg=convergence)
        return Freedom(True, distortion), Finding(
            "lens.focal-estimated-without-exif", spread_deg=convergence
        )
    if not is_exif_trusted:
        return Freedom(True, distortion), Finding("lens.exif-unusable")
    if is_weak:
        return Freedom(False, distortion), Finding(
            "lens.focal-held-one-direction", spread_deg=convergence, least_deg=MIN_CONVERGENCE_DEG
        )
    if photos < MIN_PHOTOS:
        return Freedom(False, distortion), Finding(
            "lens.focal-held-few-photos", count=photos, least=MIN_PHOTOS
        )
    return Freedom(True, distortion), Finding("lens.focal-estimated", spread_deg=convergence)


def fixed_focal(
    exif_px: float | None, long_side: int, sigma: float, is_exif_trusted: bool
) -> tuple[float, Finding] | None:
    """Return the fixed focal length that replaces an uncertain one, and the reason.

    The focal length is in pixels. Returns None if the relative error `sigma` is small enough, or if
    the focal length from EXIF is not trusted.
    """
    if exif_px is None:
        if sigma <= UNKNOWN_FOCAL_SIGMA:
            return None
        if np.isfinite(sigma):
            return DEFAULT_FOCAL_RATIO * long_side, Finding(
                "lens.focal-assumed", focal_mm=36 * DEFAULT_FOCAL_RATIO, error_percent=100 * sigma
            )
        return DEFAULT_FOCAL_RATIO * long_side, Finding(
            "lens.focal-assumed", focal_mm=36 * DEFAULT_FOCAL_RATIO, error_percent=None
        )
    if not is_exif_trusted or sigma <= MAX_RELATIVE_SIGMA:
        return None
    return exif_px, Finding("lens.focal-held-uncertain", error_percent=100 * sigma)


def is_far_from_exif(ratio: float, sigma: float) -> bool:
    """Return whether the ratio of a freed focal length to EXIF differs significantly from 1."""
    return abs(ratio - 1) > max(MIN_EXIF_DIFFERENCE, MIN_SIGMAS * sigma)


def free_lens_parameters(freedom: Freedom, photos: int, convergence: float) -> Freedom:
    """Free k2 and the principal point if testing them is useful.

    Call this after `select_free_parameters`.
    """
    has_enough_photos = freedom.distortion and photos >= MIN_PHOTOS
    return replace(
        freedom,
        second_radial=has_enough_photos,
        centre=has_enough_photos and freedom.focal and convergence >= MIN_CONVERGENCE_DEG,
    )


def judge_k2(focal: float, corner_px: float, k2: float, sigma: float) -> tuple[bool, Finding]:
    """Return whether to estimate k2, and the reason.

    corner_px : distance of the corner of the picture from its centre
    """
    radius = np.linspace(0.02, 1.0, 50) * corner_px / focal
    bend = focal * k2 * radius**5
    basis = np.column_stack([radius, radius**3])
    bend_residuals = bend - basis @ np.linalg.lstsq(basis, bend, rcond=None)[0]
    bend_effect, sigmas = float(np.abs(bend_residuals).max()), abs(k2) / sigma if sigma > 0 else 0.0
    if bend_effect >= MIN_EFFECT_PX and sigmas >= MIN_SIGMAS:
        return True, Finding("lens.distortion-estimated", effect_px=bend_effect, times=sigmas)
    return False, Finding(
        "lens.distortion-held",
        effect_px=bend_effect,
        times=sigmas,
        least_px=MIN_EFFECT_PX,
        least_times=MIN_SIGMAS,
    )


def judge_centre(
    focal: float,
    corner_px: float,
    shift: FloatArray,
    covariance: FloatArray,
) -> tuple[bool, Finding]:
    """Return whether to estimate the principal point, and the reason.

    corner_px : distance of the corner of the picture from its centre
    shift : (2,) shift of the principal point from the centre of the picture, in pixels
    covariance : (2, 2) covariance of the shift, with neighbouring points counted as one
    """
    # The effect of the shift that a rotation of the camera does not compensate for.
    distance = float(np.linalg.norm(shift))
    centre_effect = distance * (corner_px / focal) ** 2
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    is_estimated = (
        centre_effect >= MIN_EFFECT_PX
        and sigma <= MAX_CENTRE_SIGMA * 2 * corner_px
        and distance <= MAX_CENTRE_SHIFT * 2 * corner_px
    )
    values = {"x_px": float(shift[0]), "y_px": float(shift[1]), "sigma_px": sigma}
    if is_estimated:
        reason = Finding("lens.centre-estimated", effect_px=centre_effect, **values)
    elif centre_effect < MIN_EFFECT_PX:
        reason = Finding(
            "lens.centre-held-small", effect_px=centre_effect, least_px=MIN_EFFECT_PX, **values
        )
    elif distance > MAX_CENTRE_SHIFT * 2 * corner_px:
        reason = Finding("lens.centre-held-far", **values)
    else:
        reason = Finding(
            "lens.centre-held-uncertain", least_px=MAX_CENTRE_SIGMA * 2 * corner_px, **values
        )
    return is_estimated, reason


def correlation_factor(observations: int, photos: int) -> float:
    """Return the factor by which correlated neighbouring points increase formal errors."""
    return float(np.sqrt(max(1.0, observations / max(1, photos * _INDEPENDENT_POINTS_PER_PHOTO))))


def parameter_names(model: str) -> tuple[str, ...]:
    """Return the parameter names of a COLMAP camera model, in COLMAP's order."""
    from vomstudio.geometry.cameras import CAMERA_MODELS

    return CAMERA_MODELS[model]


def part_axes(reconstruction: Any) -> FloatArray:
    """Return the optical axes (n, 3) of the placed photos."""
    return np.array(
        [
            reconstruction.image(i).viewing_direction()
            for i in sorted(reconstruction.reg_image_ids())
        ]
    ).reshape(-1, 3)


def set_focal(reconstruction: Any, camera_id: int, focal: float) -> None:
    """Set the focal length of a camera, in pixels."""
    camera = reconstruction.camera(camera_id)
    params = np.array(camera.params)
    params[list(camera.focal_length_idxs())] = focal
    camera.params = params
