"""Whether the attitudes of cameras agree among each other, and what they look like that do not.

Every photo tells the turn of the model by itself: its attitude in World against that in the model.
Where conventions differ, or a photo was turned, these turns scatter, and one change of the angles
makes them agree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.view_attitudes import camera_rotations
from vomstudio.registration.selection import selected

# Turns that scatter by less are those of good instruments, in whatever convention.
_AGREE_DEG = 5.0
_CLOSE_DEG = 10.0
_BETTER = 0.3
_FEWEST = 4
# A photo further from the others than this, and than so many times their scatter, is left out.
_FAR_DEG = 15.0
_TIMES = 5.0
# More photos than this are judged by some of them.
_MOST = 600
# A turn of which so much is about the vertical leaves that as it is.
_LEVEL = 0.95


def left_out(
    labels: Sequence[str], angles: FloatArray, model: FloatArray, messages: list[Finding]
) -> tuple[BoolArray, BoolArray]:
    """(n,) which photos do not agree with most others, and of which not even the vertical does.

    angles : (n, 3) yaw, pitch, roll in World; model : (n, 3, 3) from the cameras to the model
    messages : messages about suspicious angles are appended
    """
    none = np.zeros(len(labels), bool)
    if len(labels) < _FEWEST:
        return none, none
    turns = camera_rotations(angles) @ np.swapaxes(model, 1, 2)
    usual, scatter = _agreed(turns)
    if scatter > _AGREE_DEG:
        better = [
            (_agreed(camera_rotations(change(angles)) @ np.swapaxes(model, 1, 2))[1], sentence)
            for change, sentence in _conventions()
        ]
        least, sentence = min(better)
        if least < min(_BETTER * scatter, _CLOSE_DEG):
            messages.append(
                Finding(
                    "attitude.other-convention",
                    scatter_deg=scatter,
                    least_deg=least,
                    change=sentence,
                )
            )
            return none, none
    off = _apart(turns, usual)
    limit = _limit(off)
    out = np.asarray(off > limit)
    tilted = none.copy()
    if out.any():
        tilted[out] = _described(labels, angles, model, usual, out, limit, messages)
    return out, tilted


def verticals_left_out(
    labels: Sequence[str],
    down: FloatArray,
    model: FloatArray,
    considered: BoolArray,
    messages: list[Finding],
) -> BoolArray:
    """(n,) which photos' verticals do not agree with most others.

    down : (n, 3) the direction in which things fall, in the frame of each camera; model : as above
    considered : (n,) which photos to check
    """
    if len(labels) < _FEWEST or not considered.any():
        return np.zeros(len(labels), bool)
    turned = [down]
    for _ in range(3):
        # By a quarter turn of the photo, clockwise.
        right, below, ahead = turned[-1].T
        turned.append(np.column_stack([-below, right, ahead]))
    each = [np.einsum("nij,nj->ni", model, one) for one in turned]
    usual, scatter = _agreed_down(each[0])
    if scatter > _AGREE_DEG:
        least, quarter = min((_agreed_down(one)[1], k) for k, one in enumerate(each))
        if quarter and least < min(_BETTER * scatter, _CLOSE_DEG):
            messages.append(
                Finding(
                    "attitude.turned-photos",
                    scatter_deg=scatter,
                    least_deg=least,
                    turn_deg=90 * quarter,
                )
            )
            return np.zeros(len(labels), bool)
    off = _from(each[0], usual)
    out = np.asarray(considered & (off > _limit(off)))
    if out.any():
        away = np.array([_from(one, usual) for one in each])[:, out]
        close = away.min(axis=0) < _CLOSE_DEG
        quarters = np.unique(90 * away.argmin(axis=0)[close]).tolist()
        messages.append(Finding("attitude.verticals-left-out", photos=selected(labels, out)))
        if quarters:
            messages.append(Finding("attitude.verticals-turned", turns_deg=quarters))
    return out


# --- what angles may mean ---------------------------------------------------------------------
def _plus(column: int, degrees: float) -> Callable[[FloatArray], FloatArray]:
    return lambda angles: angles + degrees * np.eye(3)[column]


def _times(*factors: float) -> Callable[[FloatArray], FloatArray]:
    return lambda angles: angles * factors


def _quarters() -> list[tuple[Callable[[FloatArray], FloatArray], str]]:
    return [
        (_plus(2, 90.0), tr("90° is added to roll (photos in portrait)")),
        (_plus(2, -90.0), tr("90° is taken from roll (photos in portrait)")),
        (_plus(2, 180.0), tr("180° is added to roll (photos upside down)")),
    ]


def _conventions() -> list[tuple[Callable[[FloatArray], FloatArray], str]]:
    return [
        *_quarters(),
        (_plus(1, -90.0), tr("90° is taken from pitch (it is counted from straight down)")),
        (_plus(1, 90.0), tr("90° is added to pitch (it is counted from the horizon, downwards)")),
        (_times(1.0, -1.0, 1.0), tr("pitch has its sign changed (it is positive downwards)")),
        (_times(-1.0, 1.0, 1.0), tr("yaw has its sign changed (it runs counterclockwise)")),
        (_times(1.0, 1.0, -1.0), tr("roll has its sign changed")),
        (_from_radians, tr("all angles are multiplied by 57.2958 (they are radians)")),
    ]


def _from_radians(angles: FloatArray) -> FloatArray:
    """What is no radian stays as it is."""
    radians = np.nanmax(np.abs(angles), initial=0.0) <= 2.0 * np.pi + 1e-6
    return np.degrees(angles) if radians else angles


def _described(
    labels: Sequence[str],
    angles: FloatArray,
    model: FloatArray,
    usual: FloatArray,
    out: BoolArray,
    limit: float,
    messages: list[Finding],
) -> list[bool]:
    """Return whether the vertical of each excluded photo is excluded too.

    Appends one message for photos with the same error.
    """
    from scipy.spatial.transform import Rotation

    back = np.swapaxes(model, 1, 2)
    named: dict[tuple[str, Any], list[str]] = {}
    tilted = []
    for row in map(int, np.flatnonzero(out)):
        one = angles[row : row + 1]
        fits = [
            (float(_apart(camera_rotations(change(one)) @ back[row], usual)[0]), sentence)
            for change, sentence in _quarters()
        ]
        least, sentence = min(fits)
        between = camera_rotations(one)[0] @ back[row] @ usual.T
        turn = np.degrees(Rotation.from_matrix(between).as_rotvec())
        # Where a camera looks down, a photo that was turned seems to have another yaw.
        quarter = least < limit / 2
        flat = not quarter and abs(turn[2]) > _LEVEL * np.linalg.norm(turn)
        tilted.append(not flat)
        if quarter:
            named.setdefault(("quarter", sentence), []).append(labels[row])
        elif flat:
            named.setdefault(("yaw", round(-float(turn[2]) / 5) * 5), []).append(labels[row])
        else:
            named.setdefault(("far", limit), []).append(labels[row])
    messages += [_exclusion_finding(why, what, names) for (why, what), names in named.items()]
    return tilted


def _exclusion_finding(why: str, what: Any, photos: list[str]) -> Finding:
    if why == "yaw":
        return Finding("attitude.yaw-left-out", off_deg=what, photos=photos)
    if why == "quarter":
        return Finding("attitude.convention-left-out", change=what, photos=photos)
    return Finding("attitude.left-out", limit_deg=what, photos=photos)


def _limit(off: FloatArray) -> float:
    return max(_FAR_DEG, _TIMES * 1.4826 * float(np.median(off)))


def _agreed_down(there: FloatArray) -> tuple[FloatArray, float]:
    """The direction that most of (n, 3) are near to, and their median angle from it, degrees."""
    some = there[:: max(1, -(-len(there) // _MOST))]
    angles = np.degrees(np.arccos(np.clip(some @ some.T, -1.0, 1.0)))
    middle = some[int(np.argmin(np.median(angles, axis=1)))]
    near = _from(some, middle)
    mean = some[near <= np.median(near)].sum(axis=0)
    better = mean / np.linalg.norm(mean)
    return better, float(np.median(_from(there, better)))


def _from(there: FloatArray, usual: FloatArray) -> FloatArray:
    """(n,) degrees."""
    return np.asarray(np.degrees(np.arccos(np.clip(there @ usual, -1.0, 1.0))), np.float64)


def _agreed(turns: FloatArray) -> tuple[FloatArray, float]:
    """The turn that most of (n, 3, 3) are near to, and their median angle from it, degrees."""
    some = turns[:: max(1, -(-len(turns) // _MOST))]
    flat = some.reshape(-1, 9)
    angles = np.degrees(np.arccos(np.clip((flat @ flat.T - 1.0) / 2.0, -1.0, 1.0)))
    middle = some[int(np.argmin(np.median(angles, axis=1)))]
    near = _apart(some, middle)
    u, _, vt = np.linalg.svd(some[near <= np.median(near)].sum(axis=0))
    better = np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt, np.float64)
    return better, float(np.median(_apart(turns, better)))


def _apart(turns: FloatArray, usual: FloatArray) -> FloatArray:
    """(n,) degrees between turns (n, 3, 3) and one."""
    trace = np.einsum("nij,ij->n", turns.reshape(-1, 3, 3), usual)
    return np.asarray(np.degrees(np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0))), np.float64)
