"""Which intrinsics of a camera are held and which are estimated, by a stated rule.

Photos that all look the same way cannot tell a longer lens from rock farther away: the adjustment
then finds a focal length that is 10 or 20 % off with a formal error of half a per cent, since what
it really fits is the lens's deviation from its model. So the formal error alone decides nothing.
The rule: a focal length known from EXIF is freed only where the photos of the camera look at the
same rock from directions that differ enough (`CONVERGENT_DEG`, root mean square about their mean),
there are enough of them, and the error of the freed value is small even when neighbouring tie
points are counted as one. Otherwise it is held, unless the photos speak clearly against it: freed,
it is `FAR_FROM_EXIF` or more off, several times its error, and tie points that the adjustment has
not seen miss by less than `CONTRADICTED` times as much. (Freed where EXIF is right, they miss by
some hundredths less at best, since the freed value takes up what the lens's model leaves.) An
unknown one is freed; where nothing determines it, that of a usual lens is assumed, and it is said.
Radial distortion is seen in the overlap of any two photos and is free where a camera has some
photos.

The rest of the lens is tried where there are photos enough: k2, without which a block that looks
one way bends like a dome, and of convergent photos with a free focal length the principal point,
which others cannot tell from a turn of the camera. Each is kept where what it does in the corner of
the photo, beyond what k1, the focal length and a turn of the camera can do in its stead, is
`LEAST_EFFECT_PX` or more, and it is determined, neighbouring tie points counted as one: k2
`LEAST_SIGMAS` of its errors from nothing, the principal point to `LARGEST_CENTRE_SIGMA`, well
within what cameras differ by. Both are kept only where tie points that the adjustment has not seen
fit no worse with them. Decentring (p1, p2) does nearly what a shift of the principal point does,
and is left to it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

CONVERGENT_DEG = 8.0
FEWEST_PHOTOS = 6
# A camera with fewer photos keeps the distortion it has.
FEWEST_FOR_DISTORTION = 2
LARGEST_SIGMA = 0.01
LEAST_EFFECT_PX = 0.1
LEAST_SIGMAS = 3.0
# Relative, of an unknown focal length: lenses of cameras differ by no more, as a rule.
LOOSEST_SIGMA = 0.2
# Of the long side: 30 mm on film, between phones and drones (24 to 28) and normal lenses (35).
USUAL_FOCAL = 0.83
FAR_FROM_EXIF = 0.04
CONTRADICTED = 0.93
# Of the diagonal of the photo: the principal points of sound cameras lie some 0.5 % from the
# middle, so an estimate with less than half of that is the better guess.
LARGEST_CENTRE_SIGMA = 0.0025
FARTHEST_CENTRE = 0.02
# The misfit of the lens's model is shared by neighbouring points: so many regions of a photo speak
# for themselves.
_INDEPENDENT_PER_PHOTO = 50


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera after the adjustment.

    names, values : its parameters, COLMAP's order
    sigma : (p,) one standard deviation, 0 where held; neighbouring points counted as one
    correlation : (p, p), NaN where held
    photos : names
    focal : "held" or "freed"
    reasons : why
    exif_px : focal length that EXIF gives
    convergence_deg : root mean square angle between the optical axes and their mean
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
        """The two parameters that are hardest to tell apart."""
        table = np.abs(np.array(self.correlation, np.float64))
        table[~np.isfinite(table)] = 0
        np.fill_diagonal(table, 0)
        if not table.any():
            return None
        i, j = np.unravel_index(int(table.argmax()), table.shape)
        return self.names[i], self.names[j], self.correlation[i][j]


def convergence_deg(axes: FloatArray) -> float:
    """Root mean square angle between unit vectors (n, 3) and their mean; 0 for one."""
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
    """Which parameters of one camera the adjustment may change: the focal length, k1, k2 and the
    principal point."""

    focal: bool
    distortion: bool
    second: bool = False
    centre: bool = False


HELD = Freedom(False, False)


def decide(
    known: bool, photos: int, convergence: float, trusted: bool = True
) -> tuple[Freedom, Finding]:
    """Which parameters of a camera to estimate, and why, before its error is known.

    known : EXIF gives the focal length; photos : placed photos of the camera; convergence : of all
    photos of the part, degrees; trusted : the photos could be placed with that focal length
    """
    distortion = photos >= FEWEST_FOR_DISTORTION
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
    if photos < FEWEST_PHOTOS:
        return Freedom(False, distortion), Finding(
            "lens.focal-held-few-photos", count=photos, least=FEWEST_PHOTOS
        )
    return Freedom(True, distortion), Finding("lens.focal-estimated", spread_deg=convergence)


def held_instead(
    exif_px: float | None, long_side: int, sigma: float, trusted: bool
) -> tuple[float, Finding] | None:
    """(focal length in pixels at which it is held, why) where a freed one turned out to have a
    relative error of `sigma` that is too large; None where it is small enough."""
    if exif_px is None:
        if sigma <= LOOSEST_SIGMA:
            return None
        if np.isfinite(sigma):
            return USUAL_FOCAL * long_side, Finding(
                "lens.focal-assumed", focal_mm=36 * USUAL_FOCAL, error_percent=100 * sigma
            )
        return USUAL_FOCAL * long_side, Finding(
            "lens.focal-assumed", focal_mm=36 * USUAL_FOCAL, error_percent=None
        )
    if not trusted or sigma <= LARGEST_SIGMA:
        return None
    return exif_px, Finding("lens.focal-held-uncertain", error_percent=100 * sigma)


def far_from_exif(ratio: float, sigma: float) -> bool:
    """Whether a freed focal length, `ratio` times that from EXIF, with a relative error of `sigma`,
    is another one."""
    return abs(ratio - 1) > max(FAR_FROM_EXIF, LEAST_SIGMAS * sigma)


def with_lens_parameters(freedom: Freedom, photos: int, convergence: float) -> Freedom:
    """After `decide`: with k2 and the principal point freed where that is worth a trial."""
    enough = freedom.distortion and photos >= FEWEST_PHOTOS
    return replace(
        freedom,
        second=enough,
        centre=enough and freedom.focal and convergence >= CONVERGENT_DEG,
    )


def judge_second(focal: float, corner_px: float, k2: float, sigma: float) -> tuple[bool, Finding]:
    """Whether k2 is kept, and why; corner_px : distance of the corner from the middle."""
    radius = np.linspace(0.02, 1.0, 50) * corner_px / focal
    bend = focal * k2 * radius**5
    instead = np.column_stack([radius, radius**3])
    left = bend - instead @ np.linalg.lstsq(instead, bend, rcond=None)[0]
    effect, sigmas = float(np.abs(left).max()), abs(k2) / sigma if sigma > 0 else 0.0
    if effect >= LEAST_EFFECT_PX and sigmas >= LEAST_SIGMAS:
        return True, Finding("lens.distortion-estimated", effect_px=effect, times=sigmas)
    return False, Finding(
        "lens.distortion-held",
        effect_px=effect,
        times=sigmas,
        least_px=LEAST_EFFECT_PX,
        least_times=LEAST_SIGMAS,
    )


def judge_centre(
    focal: float,
    corner_px: float,
    shift: FloatArray,
    covariance: FloatArray,
) -> tuple[bool, Finding]:
    """Whether the principal point is kept `shift` (2,) pixels off the middle, and why; covariance
    (2, 2) with neighbouring points counted as one."""
    # What is left of the shift when the camera is turned to make up for it.
    distance = float(np.linalg.norm(shift))
    effect = distance * (corner_px / focal) ** 2
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    kept = (
        effect >= LEAST_EFFECT_PX
        and sigma <= LARGEST_CENTRE_SIGMA * 2 * corner_px
        and distance <= FARTHEST_CENTRE * 2 * corner_px
    )
    values = {"x_px": float(shift[0]), "y_px": float(shift[1]), "sigma_px": sigma}
    if kept:
        reason = Finding("lens.centre-estimated", effect_px=effect, **values)
    elif effect < LEAST_EFFECT_PX:
        reason = Finding(
            "lens.centre-held-small", effect_px=effect, least_px=LEAST_EFFECT_PX, **values
        )
    elif distance > FARTHEST_CENTRE * 2 * corner_px:
        reason = Finding("lens.centre-held-far", **values)
    else:
        reason = Finding(
            "lens.centre-held-uncertain", least_px=LARGEST_CENTRE_SIGMA * 2 * corner_px, **values
        )
    return kept, reason


def correlated_factor(observations: int, photos: int) -> float:
    """By how much formal errors are too small where neighbouring points err together."""
    return float(np.sqrt(max(1.0, observations / max(1, photos * _INDEPENDENT_PER_PHOTO))))


def parameter_names(model: str) -> tuple[str, ...]:
    """Names of the parameters of a COLMAP camera model, in its order."""
    from vomstudio.geometry.cameras import MODELS

    return MODELS[model]


def part_axes(reconstruction: Any) -> FloatArray:
    """(n, 3) optical axes of the placed photos."""
    return np.array(
        [
            reconstruction.image(i).viewing_direction()
            for i in sorted(reconstruction.reg_image_ids())
        ]
    ).reshape(-1, 3)


def set_focal(reconstruction: Any, camera_id: int, focal: float) -> None:
    """Give a camera a focal length, in pixels."""
    camera = reconstruction.camera(camera_id)
    params = np.array(camera.params)
    params[list(camera.focal_length_idxs())] = focal
    camera.params = params
