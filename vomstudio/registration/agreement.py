"""Whether control points and positions of cameras place a model alike.

Each places it alone; turn and scale of the two are compared beside their errors. They differ where
one is in another system, and where the lens is wrong: a focal length that is 5 % off moves the
cameras by as much of their distance, and leaves a scene that fits its points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.observations import Observed, Points
from vomstudio.registration.similarity import nearly_on_a_line
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_FEWEST = 4
# Of right registrations one in a thousand is called contradictory.
_BY_CHANCE = 0.001


def said_of_disagreement(kinds: Sequence[Observed], centre: Array, size: float) -> list[str]:
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
