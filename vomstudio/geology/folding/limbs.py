"""Two limbs among the poles of a fold, and whether they are two limbs at all."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geology.folding.arcs import one_sided, rms
from vomstudio.geology.populations.distributions import f95
from vomstudio.geology.populations.probabilities import chi2_tail, f_tail, t95
from vomstudio.geology.statistics import flip_to, orientation_tensor

NO_SCATTER_DEG = 1e-3
"""Poles that lie on the curve to this are taken as exact: there is nothing to test."""

FLAT_LIMBS, FLAT_DEG = 2.5, 1.5
"""A limb has one dip where its poles stray along the great circle by no more times what they stray
across it, or by no more degrees: traces on one face are all known least in the same direction, and
so little of an arc tells no curve of natural beds."""

LIMBS_APART = 6.0
"""Two limbs: their poles lie apart by so many times their scatter along the great circle (those of
an evenly bent arc, cut in the middle, by 3.5)."""

UNEVEN_LIMBS = 2.0
"""A group that strays along the great circle by so many times the other, and is not `LIMBS_APART`
by its own scatter, is an arc rather than a limb: its mean is no plane of the fold."""

ACROSS_HINGE_DEG = 25.0
"""Both limbs of a tight fold have poles within this of the plane at right angles to that of the
hinge, and fall together, since poles have no ends."""

ISOCLINAL_DEG, HINGE_SHARE = 10.0, 0.35
"""So near to that plane the poles of both limbs are one group that shows no two; a hinge has no
larger share of the planes."""

HINGE_ARC_DEG, NARROW_P = 20.0, 0.02
"""The planes of a hinge turn by so much at least: a group is a limb where so little scatter along
the great circle as its own would have a smaller chance in a hinge."""

UNLIKE_P = 0.05
"""Scatter of two limbs that differs by chance as seldom as this is not taken as one."""

MIXED = 0.2
"""A limb is overturned, or not, where no larger share of its planes says otherwise."""

BENT_P, BENT_FEW_P, BENT_FEW = 0.01, 0.05, 8
"""A group is bent where its scatter along the great circle has a smaller chance, by that across it;
the second of groups of fewer planes."""


@dataclass(frozen=True, eq=False)
class Limbs:
    """Two limbs by their mean poles (2, 3) and numbers of planes; by how much they lie apart along
    the great circle, and how far (RMS) the poles stray along and across it from their means.
    variances: of the planes of each along the great circle, radians squared.
    doubt: why they may be no limbs of one fold: "hinge" where one group may be both limbs of a
    tight fold and the other its hinge, "arc" where one is rather an arc, "mixed" where some planes
    of one limb are overturned and some are not; "" without."""

    poles: tuple[FloatArray, FloatArray]
    counts: tuple[int, int]
    apart_deg: float
    along_deg: float
    across_deg: float
    variances: tuple[float, float]
    overturned: tuple[bool, bool] = (False, False)
    doubt: str = ""

    @property
    def flat(self) -> bool:
        """Whether each limb has one dip: its poles stray along the great circle hardly more than
        across it, or hardly at all, and so do not tell which way the curve that they lie on goes
        on."""
        return self.along_deg <= max(FLAT_LIMBS * self.across_deg, FLAT_DEG)

    @property
    def up(self) -> tuple[FloatArray, FloatArray]:
        """Unit normals of both toward younger beds, which is upward unless a limb is overturned."""
        first, second = (
            pole if (pole[2] > 0) != turned else -pole
            for pole, turned in zip(self.poles, self.overturned, strict=True)
        )
        return first, second

    def errors95_deg(self, axis: FloatArray) -> tuple[float, float]:
        """Of the angle between both, and the larger half-angle of the joint region of the plane
        that halves it, about the fold axis (3,). Of Student and Fisher, with the degrees of freedom
        by Welch (1947) for the angle: whether both limbs stray alike is not asked first, since few
        planes do not tell (Zimmerman 2004, British Journal of Mathematical and Statistical
        Psychology 57, 173-181); where they may, the scatter of each is at least that of both."""
        counts = np.array(self.counts, np.float64)
        own = np.array(self.variances)
        free = float(counts.sum() - 2.0)
        low, high = (0, 1) if own[0] <= own[1] else (1, 0)
        ratio = own[high] / max(own[low], math.radians(NO_SCATTER_DEG) ** 2)
        alike = f_tail(counts[high] - 1.0, counts[low] - 1.0, ratio) > UNLIKE_P / 2.0
        if alike:
            # Few planes do not show that they stray more: theirs is at least what they show.
            own = np.maximum(own, float(own @ (counts - 1.0)) / free)
        along = own / counts
        welch = float(along.sum() ** 2 / max(np.sum(along**2 / (counts - 1.0)), 1e-300))
        welch = min(max(welch, 1.0), free)
        if not alike:
            free = welch
        n = float(counts.sum())
        across = math.radians(self.across_deg) ** 2 * n / max(n - 2.0, 1.0) / counts
        first, second = self.up
        halving = first - second
        length = float(np.linalg.norm(halving))
        halving /= length
        spread = np.zeros((3, 3))
        for normal, on, off in zip((first, second), along, across, strict=True):
            beside = np.cross(axis, normal)
            spread += on * np.outer(beside, beside) + off * np.outer(axis, axis)
        flat = np.eye(3) - np.outer(halving, halving)
        widest = float(np.linalg.eigvalsh(flat @ spread @ flat)[-1]) / length**2
        # Limbs are told by how little they scatter, which of few planes is often by chance.
        wider = 1.0 + 1.0 / max(n - 2.0, 1.0)
        angle = wider * t95(welch) * math.sqrt(float(along.sum()))
        region = math.atan(wider * math.sqrt(widest * 2.0 * f95(free)))
        return min(math.degrees(angle), 180.0), math.degrees(region)


def limbs_of(
    poles: FloatArray, axes: FloatArray, overturned: BoolArray | None = None
) -> Limbs | None:
    """Two limbs, where the poles are two groups along the great circle; else None. overturned :
    (n,), None where nothing is known."""
    if len(poles) < 4:
        return None
    ends = one_sided(poles, axes)
    middle = ends.sum(axis=0)
    middle -= axes[2] * (middle @ axes[2])
    middle /= np.linalg.norm(middle)
    along = np.arctan2(ends @ np.cross(axes[2], middle), ends @ middle)
    order = np.argsort(along)
    t = along[order]
    # The cut that leaves the least scatter within both groups.
    n = np.arange(1, len(t))
    left = np.cumsum(t)[:-1]
    right, total = t.sum() - left, float(np.sum(t**2))
    within = total - left**2 / n - right**2 / (len(t) - n)
    cut = int(np.argmin(within[1:-1])) + 2 if len(t) > 4 else int(np.argmin(within)) + 1
    groups = order[:cut], order[cut:]
    if min(map(len, groups)) < 2:
        return None
    apart = float(along[groups[1]].mean() - along[groups[0]].mean())
    scatter = math.sqrt(max(float(within[cut - 1]), 0.0) / (len(t) - 2))
    if apart < math.radians(20.0) or apart < LIMBS_APART * scatter:
        return None
    means = [orientation_tensor(poles[group])[1][0] for group in groups]
    off = ends @ axes[2]
    across = rms(np.concatenate([off[group] - off[group].mean() for group in groups]))
    turned, doubt = (False, False), _doubt_of([along[group] for group in groups], apart, across)
    if overturned is not None:
        shares = [float(np.mean(overturned[group])) for group in groups]
        turned = shares[0] > 0.5, shares[1] > 0.5
        if any(MIXED < share < 1.0 - MIXED for share in shares):
            doubt = "mixed"
    first, second = (float(np.var(along[group], ddof=1)) for group in groups)
    return Limbs(
        (means[0], means[1]),
        (len(groups[0]), len(groups[1])),
        math.degrees(apart),
        math.degrees(scatter),
        math.degrees(across),
        (first, second),
        turned,
        doubt,
    )


def lone_limb(poles: FloatArray) -> int | None:
    """The place of the one plane that is a limb by itself: all others have one dip, as a limb of
    `limbs_of` has, and lie far from it. None where there is none."""
    if len(poles) < 4:
        return None
    _, axes = orientation_tensor(poles)
    row = int(np.argmax(np.abs(poles @ axes[1])))
    rest = np.delete(poles, row, axis=0)
    mean = orientation_tensor(rest)[1][0]
    toward = poles[row] * math.copysign(1.0, float(poles[row] @ mean))
    apart = math.acos(min(max(float(toward @ mean), -1.0), 1.0))
    toward = toward - mean * float(toward @ mean)
    length = float(np.linalg.norm(toward))
    if apart < math.radians(20.0) or length == 0.0:
        return None
    along = np.arcsin(np.clip(flip_to(rest, mean) @ toward / length, -1.0, 1.0))
    return row if apart >= LIMBS_APART * rms(along) else None


def _doubt_of(groups: list[FloatArray], apart: float, across: float) -> str:
    """Of two groups of angles along the great circle, so far apart, with their scatter across it
    (radians): as `Limbs.doubt`."""
    free = sum(map(len, groups)) - 2
    # By all that scatter of the planes themselves, rather than a bend, could be.
    variance = max(across**2 * (free + 2) / free, math.radians(NO_SCATTER_DEG) ** 2)
    own = [float(np.var(group, ddof=1)) for group in groups]
    bent = [
        f_tail(len(group) - 1, free, value / variance)
        < (BENT_FEW_P if len(group) < BENT_FEW else BENT_P)
        for group, value in zip(groups, own, strict=True)
    ]
    off = abs(math.degrees(apart) - 90.0)
    less = 0 if len(groups[0]) <= len(groups[1]) else 1
    if off <= ACROSS_HINGE_DEG and any(bent):
        return "hinge"
    if (
        off <= ISOCLINAL_DEG
        and len(groups[less]) <= HINGE_SHARE * (free + 2)
        and not _narrow(own[less], len(groups[less]), variance)
    ):
        return "hinge"
    wide = math.sqrt(max(own))
    if wide > UNEVEN_LIMBS * math.sqrt(min(own)) and apart < LIMBS_APART * wide:
        return "arc"
    return ""


def _narrow(own: float, n: int, variance: float) -> bool:
    """Whether n angles stray less from their mean (by their variance) than the planes of a hinge
    would, which also stray by themselves; radians squared."""
    if n < 3:
        return False
    hinge = math.radians(HINGE_ARC_DEG) ** 2 / 12.0 + variance
    return 1.0 - chi2_tail(n - 1, (n - 1) * own / hinge) < NARROW_P
