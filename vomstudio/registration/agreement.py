"""Whether what is known of a model's place agrees: control points with positions of cameras, and
the north of a compass with that of everything else.

Points and cameras place it alone; turn and scale of the two are compared beside their errors. They
differ where one is in another system, and where the lens is wrong: a focal length that is 5 % off
moves the cameras by as much of their distance, and leaves a scene that fits its points. What all
azimuths of a compass are off is estimated together with the placement, as if nothing were known of
it beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.combined import Combined
from vomstudio.registration.observations import (
    COMPASS,
    Attitudes,
    Azimuths,
    Directions,
    KeptScale,
    Observed,
    Points,
)
from vomstudio.registration.similarity import nearly_on_a_line
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_FEWEST = 4
# Of right registrations one in a thousand is called contradictory.
_BY_CHANCE = 0.001
# Of an angle that is as good as not known beforehand, and that is not worth a word.
_ANY_NORTH_RAD = np.radians(60.0)
_NOT_SEEN_DEG = 20.0
_LITTLE_DEG = 0.5
_STEPS = 6


def said_of_disagreement(kinds: Sequence[Observed], centre: Array, size: float) -> list[str]:
    """Where points and cameras contradict each other, or a scale that is kept.

    centre : (1, 3) model, size : of it, as for `adjust`
    """
    return [*_of_kept_scale(kinds, centre, size), *_of_cameras(kinds, centre, size)]


def _of_kept_scale(kinds: Sequence[Observed], centre: Array, size: float) -> list[str]:
    """Where all else knows the scale, and knows it otherwise."""
    from scipy.stats import norm

    rest = [kind for kind in kinds if not isinstance(kind, KeptScale)]
    kept = next((kind for kind in kinds if isinstance(kind, KeptScale)), None)
    if kept is None or not rest:
        return []
    free = adjust(rest, centre, size)
    if np.abs(free.free[3]).sum() > 0:
        return []
    metres = float(kept.length[0] / np.linalg.norm(kept.second - kept.first))
    times, error = free.fit.scale / metres, float(np.sqrt(free.covariance[3, 3]))
    if abs(np.log(times)) < float(norm.isf(_BY_CHANCE / 2.0)) * error:
        return []
    return [
        tr(
            "The scale that is kept is contradicted: what else is known makes the model "
            "{times:.4g} times as large (± {error:.2g} %, 95 %). One of them is wrong, or in "
            "another unit.",
            times=times,
            error=196.0 * error,
        )
    ]


def _of_cameras(kinds: Sequence[Observed], centre: Array, size: float) -> list[str]:
    from scipy.spatial.transform import Rotation
    from scipy.stats import chi2

    alone = [
        adjust([kind], centre, size)
        for kind in kinds
        if isinstance(kind, Points)
        and len(kind.labels) >= _FEWEST
        and not nearly_on_a_line(kind.model)
        and not nearly_on_a_line(kind.world)
    ]
    if len(alone) != 2 or any(one.free.shape[1] for one in alone):
        return []
    first, second = (one.fit for one in alone)
    turn = Rotation.from_matrix(first.rotation @ second.rotation.T).as_rotvec()
    grow = float(np.log(first.scale / second.scale))
    off = np.array([*turn, grow])
    errors = _of_turn_and_scale(alone[0]) + _of_turn_and_scale(alone[1])
    if float(chi2.sf(off @ np.linalg.solve(errors, off), 4)) > _BY_CHANCE:
        return []
    return [
        tr(
            "Control points and cameras contradict each other: by the points alone the model is "
            "turned by {turn:.2g}° and its scale {share:+.2g} % against that by the cameras alone, "
            "more than their errors explain. The lens may be wrong, or one of them is in another "
            "system; the stated errors do not hold that. Place it by the better one, and take the "
            "other one as a check.",
            turn=float(np.degrees(np.linalg.norm(turn))),
            share=100.0 * float(np.expm1(grow)),
        )
    ]


def _of_turn_and_scale(found: Adjusted) -> Array:
    return found.covariance[:4, :4]


@dataclass(frozen=True, eq=False)
class CompassTurn:
    """What all azimuths of a compass are too large by, and its 95 % error, degrees. freed : the
    kinds with a north that is not known beforehand, against which single readings are judged"""

    turn_deg: float
    error95_deg: float
    freed: list[Observed]

    def in_words(self) -> str:
        return tr(
            "All compass readings are turned by {turn:+.1f}° ± {error:.1f}° (95 %) against what "
            "else places the model: the declination may have been applied twice or not at all, or "
            "iron is near. Correct it (--declination), or state how far north may be off "
            "(--north-sigma).",
            turn=self.turn_deg,
            error=self.error95_deg,
        )


def compass_turn(kinds: Sequence[Observed], centre: Array, size: float) -> CompassTurn | None:
    """By how much a compass is off for all readings alike, where something else determines north
    and it is more than chance; None where not."""
    from scipy.stats import norm

    if not any(isinstance(kind, Points | Attitudes | Combined) for kind in kinds):
        return None
    turned = 0.0
    freed = [_freed(kind, 0.0) for kind in kinds]
    if not any(isinstance(kind, Directions | Azimuths) for kind in kinds):
        return None
    for _ in range(_STEPS):
        try:
            found = adjust(freed, centre, size)
        except GeometryError:
            return None
        at = found.rows.shared_names.index(COMPASS)
        # The rows turn what is placed, against the clock; readings run with it.
        step = -float(np.degrees(found.common[at]))
        turned += step
        error = float(np.degrees(np.sqrt(found.common_covariance[at, at])))
        if error > _NOT_SEEN_DEG:
            return None
        freed = [_freed(kind, turned) for kind in kinds]
        if abs(step) < 0.01:
            break
    if abs(turned) < max(_LITTLE_DEG, float(norm.isf(_BY_CHANCE / 2.0)) * error):
        return None
    return CompassTurn(turned, 1.959963984540054 * error, freed)


def _freed(kind: Observed, turned_deg: float) -> Observed:
    """A kind of compass readings with this taken off its azimuths, and with a north that is not
    known beforehand."""
    by = np.radians(turned_deg)
    if isinstance(kind, Azimuths):
        return replace(kind, azimuth=kind.azimuth - by, north_sigma=_ANY_NORTH_RAD)
    if isinstance(kind, Directions):
        c, s = np.cos(by), np.sin(by)
        back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return replace(kind, world=kind.world @ back, north_sigma=_ANY_NORTH_RAD)
    return kind
