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

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.combined import Combined
from vomstudio.registration.observations import (
    COMPASS,
    YAW,
    Attitudes,
    Azimuths,
    Directions,
    KeptScale,
    Observed,
    Points,
)
from vomstudio.registration.similarity import nearly_on_a_line

_FEWEST = 4
# Of right registrations one in a thousand is called contradictory.
_BY_CHANCE = 0.001
# Of an angle that is as good as not known beforehand, and that is not worth a word.
_ANY_NORTH_RAD = np.radians(60.0)
_NOT_SEEN_DEG = 20.0
_LITTLE_DEG = 0.5
# So near a quarter turn a yaw is taken for that of another side of the camera.
_NEAR_QUARTER_DEG = 10.0
_STEP_DEG = 10.0
_SEE_NORTH = Points | Attitudes | Combined | Directions | Azimuths
_STEPS = 6
# Logarithm of a ratio of scales up to which steps of the adjustment converge.
_CLOSE_SCALES = 0.4


@dataclass(frozen=True)
class ScaleContradiction:
    """A kept scale that all else contradicts by more than chance.

    times : the other scale, as a multiple of the one that is kept; error : relative, one sigma
    """

    times: float
    error: float

    @property
    def finding(self) -> Finding:
        """The contradiction as a finding."""
        return Finding(
            "registration.scale-contradicted", times=self.times, error95_percent=196.0 * self.error
        )


def contradicted_scale(
    kinds: Sequence[Observed], centre: FloatArray, size: float
) -> tuple[ScaleContradiction | None, list[Observed]]:
    """Compare a kept scale with that by all else.

    Parameters
    ----------
    kinds : sequence of Observed
    centre, size : as of `adjust`

    Returns
    -------
    ScaleContradiction or None
    list of Observed
        With points moved towards their mean until they have the kept scale, where that is
        contradicted: the best rotation does not depend on the scale, whereas misfits of a wrong one
        would turn the model to where they cost least.
    """
    from scipy.stats import norm

    rest = [kind for kind in kinds if not isinstance(kind, KeptScale)]
    kept = next((kind for kind in kinds if isinstance(kind, KeptScale)), None)
    if kept is None or not rest:
        return None, list(kinds)
    free = adjust(rest, centre, size)
    if np.abs(free.free[3]).sum() > 0:
        return None, list(kinds)
    metres = float(kept.length[0] / np.linalg.norm(kept.second - kept.first))
    times, error = free.fit.scale / metres, float(np.sqrt(free.covariance[3, 3]))
    found = None
    if abs(np.log(times)) >= float(norm.isf(_BY_CHANCE / 2.0)) * error:
        found = ScaleContradiction(times, error)
    elif abs(np.log(times)) < _CLOSE_SCALES:
        return None, list(kinds)
    places = [kind.world for kind in kinds if isinstance(kind, Points)]
    middle = np.concatenate(places).mean(axis=0) if places else np.zeros(3)
    return found, [
        replace(kind, world=middle + (kind.world - middle) / times, sigma=kind.sigma / times)
        if isinstance(kind, Points)
        else kind
        for kind in kinds
    ]


def disagreement_findings(
    kinds: Sequence[Observed], centre: FloatArray, size: float
) -> list[Finding]:
    """Where points and cameras contradict each other.

    centre : (1, 3) model, size : of it, as for `adjust`
    """
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
        Finding(
            "registration.points-and-cameras",
            turn_deg=float(np.degrees(np.linalg.norm(turn))),
            scale_percent=100.0 * float(np.expm1(grow)),
        )
    ]


def _of_turn_and_scale(found: Adjusted) -> FloatArray:
    return found.covariance[:4, :4]


@dataclass(frozen=True, eq=False)
class NorthTurn:
    """What all azimuths of one north are too large by, and its 95 % error, degrees; name : of that
    north; planes : whether planes and lines were read by it, and not azimuths alone"""

    name: str
    turn_deg: float
    error95_deg: float
    planes: bool

    @property
    def finding(self) -> Finding:
        """The turn as a finding."""
        near = min((90.0, 180.0, -90.0, -180.0), key=lambda quarter: abs(self.turn_deg - quarter))
        values: dict[str, object] = {
            "kind": self.name,
            "readings": tr("compass readings") if self.name == COMPASS else tr("yaws"),
            "turn_deg": self.turn_deg,
            "error95_deg": self.error95_deg,
        }
        if abs(self.turn_deg - near) < _NEAR_QUARTER_DEG:
            return Finding("registration.north-quarter-turn", correction_deg=-near, **values)
        return Finding("registration.north-turned", **values)


def turned_norths(
    kinds: Sequence[Observed], centre: FloatArray, size: float
) -> tuple[list[NorthTurn], list[Observed]]:
    """Of compass and yaws by how much they are off for all readings alike, where something else
    determines north and it is more than chance; and the kinds with these norths corrected and not
    known beforehand, as the model is best placed by and single readings are judged."""
    found, left = [], list(kinds)
    for name in (COMPASS, YAW):
        turned = _turned(left, centre, size, name)
        if turned is not None:
            turn, left = turned
            found.append(turn)
    return found, left


def _turned(
    kinds: Sequence[Observed], centre: FloatArray, size: float, name: str
) -> tuple[NorthTurn, list[Observed]] | None:
    from scipy.stats import norm

    read = Attitudes if name == YAW else Directions | Azimuths
    others = [kind for kind in kinds if not isinstance(kind, read)]
    if len(others) == len(kinds) or not any(isinstance(kind, _SEE_NORTH) for kind in others):
        return None
    try:
        turned = _first_turn(kinds, others, centre, size, name)
    except GeometryError:
        return None
    freed = [_freed(kind, turned, name) for kind in kinds]
    for _ in range(_STEPS):
        try:
            found = adjust(freed, centre, size)
        except GeometryError:
            return None
        at = found.rows.shared_names.index(name)
        # The rows turn what is placed, against the clock; readings run with it.
        step = -float(np.degrees(found.common[at]))
        turned += step
        error = float(np.degrees(np.sqrt(found.common_covariance[at, at])))
        if error > _NOT_SEEN_DEG:
            return None
        freed = [_freed(kind, turned, name) for kind in kinds]
        if abs(step) < 0.01:
            break
    turned = float((turned + 180.0) % 360.0 - 180.0)
    if abs(turned) < max(_LITTLE_DEG, float(norm.isf(_BY_CHANCE / 2.0)) * error):
        return None
    planes = any(isinstance(kind, Directions) for kind in kinds)
    return NorthTurn(name, turned, 1.959963984540054 * error, planes), freed


def _first_turn(
    kinds: Sequence[Observed],
    others: Sequence[Observed],
    centre: FloatArray,
    size: float,
    name: str,
) -> float:
    """About by how much the readings are turned, degrees, by what the others place the model by:
    from far off, small steps would end at a wrong place."""
    found = adjust(others, centre, size)
    if np.abs(found.free[:3]).sum() > 0:
        return 0.0
    read = [kind for kind in kinds if not any(kind is other for other in others)]
    turns = np.arange(0.0, 360.0, _STEP_DEG)
    misses = [
        np.median(
            np.abs(
                np.concatenate(
                    [_freed(kind, turn, name).rows(found.fit, found.centre).misses for kind in read]
                )
            )
        )
        for turn in turns
    ]
    return float(turns[int(np.argmin(misses))])


def _freed(kind: Observed, turned_deg: float, name: str) -> Observed:
    """A kind of readings with this taken off its azimuths, and with a north that is not known
    beforehand; other kinds as they are."""
    by = np.radians(turned_deg)
    c, s = np.cos(by), np.sin(by)
    back = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    if name == YAW:
        if isinstance(kind, Attitudes):
            return replace(
                kind, world=back @ kind.world, axes=back @ kind.axes, north_sigma=_ANY_NORTH_RAD
            )
        return kind
    if isinstance(kind, Azimuths):
        return replace(kind, azimuth=kind.azimuth - by, north_sigma=_ANY_NORTH_RAD)
    if isinstance(kind, Directions):
        return replace(kind, world=kind.world @ back.T, north_sigma=_ANY_NORTH_RAD)
    return kind
