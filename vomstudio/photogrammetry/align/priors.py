"""Select the intrinsics of a camera that are estimated, by a stated rule.

Photos with parallel views cannot distinguish a longer lens from rock farther away: the adjustment
then gives a focal length with an error of 10 or 20 % and a formal error of half a per cent, since
it fits the deviation of the lens from its model. So the formal error alone is not sufficient.

Focal length: one known from EXIF is freed only if the photos of the camera view the same rock from
sufficiently different directions (`CONVERGENT_DEG`, root mean square about their mean), there are
enough of them, and the error of the freed value is small even if neighbouring tie points are
counted as one. Otherwise it is fixed, unless the photos clearly contradict it: freed, it differs by
`FAR_FROM_EXIF` or more, several times its error, and the error of tie points in cross-validation
decreases below `CONTRADICTED` times the previous one. (If EXIF is right it decreases by some
hundredths at best, since the freed value absorbs the misfit of the lens model.) An unknown one is
freed; if it is undetermined, that of a usual lens is assumed and reported. Radial distortion is
determined by the overlap of any two photos and is free for a camera with some photos.

Other lens parameters are tested if there are enough photos: k2, without which a block of parallel
views bends like a dome, and for convergent photos with a free focal length the principal point,
which is otherwise equivalent to a rotation of the camera. Each is estimated if its effect in the
corner of the photo, beyond that of k1, focal length and rotation, is `MIN_EFFECT_PX` or more, and
if it is determined with neighbouring tie points counted as one: k2 with `MIN_SIGMAS` of its errors,
the principal point to `MAX_CENTRE_SIGMA`, well within differences between cameras. Both are used
only if they do not increase the cross-validation error. Decentring (p1, p2) has nearly the effect
of a shift of the principal point, which represents it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

CONVERGENT_DEG = 8.0
MIN_PHOTOS = 6
# The distortion of a camera with fewer photos is fixed.
MIN_PHOTOS_DISTORTION = 2
MAX_SIGMA = 0.01
MIN_EFFECT_PX = 0.1
MIN_SIGMAS = 3.0
# Relative error of an unknown focal length: usual differences between lenses.
UNKNOWN_FOCAL_SIGMA = 0.2
# Share of the long side: 30 mm on film, between phones and drones (24 to 28) and normal lenses
# (35).
DEFAULT_FOCAL = 0.83
FAR_FROM_EXIF = 0.04
CONTRADICTED = 0.93
# Share of the diagonal: principal points are typically 0.5 % from the middle, so an estimate with
# an error of less than half of that is better.
MAX_CENTRE_SIGMA = 0.0025
MAX_CENTRE_SHIFT = 0.02
# Neighbouring points share the misfit of the lens model: number of independent regions per photo.
_INDEPENDENT_PER_PHOTO = 50


@dataclass(frozen=True, eq=False)
class Calibration:
    """Camera after the adjustment.

    Attributes
    ----------
    names, values : tuple
        Parameters in COLMAP's order.
    sigma : (p,) tuple
        One standard deviation, 0 if fixed; neighbouring points are counted as one.
    correlation : (p, p) tuple
        NaN if fixed.
    photos : tuple of str
    focal : {"held", "freed"}
    reasons : tuple of Finding
    exif_px : float or None
        Focal length from EXIF.
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
    def strongest(self) -> tuple[str, str, float] | None:
        """Return the two most correlated parameters."""
        table = np.abs(np.array(self.correlation, np.float64))
        table[~np.isfinite(table)] = 0
        np.fill_diagonal(table, 0)
        if not table.any():
            return None
        i, j = np.unravel_index(int(table.argmax()), table.shape)
        return self.names[i], self.names[j], self.correlation[i][j]


def convergence_deg(axes: FloatArray) -> float:
    """Return the root mean square angle between unit vectors (n, 3) and their mean; 0 for one."""
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
    """Free parameters of a camera in the adjustment: focal length, k1, k2 and principal point."""

    focal: bool
    distortion: bool
    second: bool = False
    centre: bool = False


ALL_FIXED = Freedom(False, False)


def select_free_parameters(
    known: bool, photos: int, convergence: float, trusted: bool = True
) -> tuple[Freedom, Finding]:
    """Select the free parameters of a camera before its error is known, with the reason.

    Parameters
    ----------
    known : bool
        Whether EXIF contains the focal length.
    photos : int
        Placed photos of the camera.
    convergence : float
        Of all photos of the part, degrees.
    trusted : bool
        Whether the photos could be placed with that focal length.
    """
    distortion = photos >= MIN_PHOTOS_DISTORTION
    weak = convergence < CONVERGENT_DEG
    if not known:
        if weak:
            return Freedom(True, distortion), Finding("lens.focal-weak", spread_deg=convergence)
        return Freedom(True, distortion), Finding(
            "lens.focal-estimated-without-exif", spread_deg=convergence
        )
    if not trusted:
        return Freedom(True, distortion), Finding("lens.exif-unusable")
    if weak:
        return Freedom(False, distortion), Finding(
            "lens.focal-held-one-direction", spread_deg=convergence, least_deg=CONVERGENT_DEG
        )
    if photos < MIN_PHOTOS:
        return Freedom(False, distortion), Finding(
            "lens.focal-held-few-photos", count=photos, least=MIN_PHOTOS
        )
    return Freedom(True, distortion), Finding("lens.focal-estimated", spread_deg=convergence)


def fixed_focal(
    exif_px: float | None, long_side: int, sigma: float, trusted: bool
) -> tuple[float, Finding] | None:
    """Return the fixed focal length for a free one with a large error, and the reason.

    The focal length is in pixels.

    None if the relative error `sigma` is small enough.
    """
    if exif_px is None:
        if sigma <= UNKNOWN_FOCAL_SIGMA:
            return None
        if np.isfinite(sigma):
            return DEFAULT_FOCAL * long_side, Finding(
                "lens.focal-assumed", focal_mm=36 * DEFAULT_FOCAL, error_percent=100 * sigma
            )
        return DEFAULT_FOCAL * long_side, Finding(
            "lens.focal-assumed", focal_mm=36 * DEFAULT_FOCAL, error_percent=None
        )
    if not trusted or sigma <= MAX_SIGMA:
        return None
    return exif_px, Finding("lens.focal-held-uncertain", error_percent=100 * sigma)


def far_from_exif(ratio: float, sigma: float) -> bool:
    """Return whether a freed focal length differs significantly from EXIF by a ratio."""
    return abs(ratio - 1) > max(FAR_FROM_EXIF, MIN_SIGMAS * sigma)


def free_lens_parameters(freedom: Freedom, photos: int, convergence: float) -> Freedom:
    """Free k2 and the principal point, after `select_free_parameters`, if a test is useful."""
    enough = freedom.distortion and photos >= MIN_PHOTOS
    return replace(
        freedom,
        second=enough,
        centre=enough and freedom.focal and convergence >= CONVERGENT_DEG,
    )


def judge_second(focal: float, corner_px: float, k2: float, sigma: float) -> tuple[bool, Finding]:
    """Return whether k2 is estimated, and why; corner_px : radius of the picture's corner."""
    radius = np.linspace(0.02, 1.0, 50) * corner_px / focal
    bend = focal * k2 * radius**5
    alternatives = np.column_stack([radius, radius**3])
    remaining = bend - alternatives @ np.linalg.lstsq(alternatives, bend, rcond=None)[0]
    effect, sigmas = float(np.abs(remaining).max()), abs(k2) / sigma if sigma > 0 else 0.0
    if effect >= MIN_EFFECT_PX and sigmas >= MIN_SIGMAS:
        return True, Finding("lens.distortion-estimated", effect_px=effect, times=sigmas)
    return False, Finding(
        "lens.distortion-held",
        effect_px=effect,
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
    """Return whether a principal point shifted by (2,) pixels is estimated, and why.

    covariance : (2, 2) with neighbouring points counted as one
    """
    # Effect of the shift that a rotation of the camera does not compensate.
    distance = float(np.linalg.norm(shift))
    effect = distance * (corner_px / focal) ** 2
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    is_estimated = (
        effect >= MIN_EFFECT_PX
        and sigma <= MAX_CENTRE_SIGMA * 2 * corner_px
        and distance <= MAX_CENTRE_SHIFT * 2 * corner_px
    )
    values = {"x_px": float(shift[0]), "y_px": float(shift[1]), "sigma_px": sigma}
    if is_estimated:
        reason = Finding("lens.centre-estimated", effect_px=effect, **values)
    elif effect < MIN_EFFECT_PX:
        reason = Finding(
            "lens.centre-held-small", effect_px=effect, least_px=MIN_EFFECT_PX, **values
        )
    elif distance > MAX_CENTRE_SHIFT * 2 * corner_px:
        reason = Finding("lens.centre-held-far", **values)
    else:
        reason = Finding(
            "lens.centre-held-uncertain", least_px=MAX_CENTRE_SIGMA * 2 * corner_px, **values
        )
    return is_estimated, reason


def correlated_factor(observations: int, photos: int) -> float:
    """Return the factor of formal errors for correlated neighbouring points."""
    return float(np.sqrt(max(1.0, observations / max(1, photos * _INDEPENDENT_PER_PHOTO))))


def parameter_names(model: str) -> tuple[str, ...]:
    """Return the parameter names of a COLMAP camera model, in its order."""
    from vomstudio.geometry.cameras import MODELS

    return MODELS[model]


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
