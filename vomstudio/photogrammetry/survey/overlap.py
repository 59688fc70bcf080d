"""Which photos show the same rock, from a quick look at small versions of them.

SIFT on photos reduced to about 800 pixels, matched by ratio and mutually, verified by a fundamental
matrix. Where one homography explains a pair (a rock face is nearly plane), it gives the overlap of
the two pictures, the ratio of their pixel sizes, and how far apart the cameras stood: with both
calibrations known, K2^-1 H K1 scaled to a middle singular value of 1 is R + t n'/d, whose first and
last singular values differ by at least 0 (one position) and by about the baseline over the distance
otherwise (Faugeras & Lustman 1988; Malis & Vargas 2007, INRIA RR-6303).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


LONG_SIDE = 800
MOST_FEATURES = 1500
FEWEST_MATCHES = 16
_RATIO = 0.8
# Of the pairs of a large set only neighbours are looked at.
_ALL_PAIRS_UP_TO = 40
_NEIGHBOURS = 6
# Where a large set has several components, pairs between them are tried too, up to this many.
_MOST_EXTRA_PAIRS = 1200
# Share of a pair's matches that a homography must explain to speak for the pair.
_PLANE_SHARE = 0.6
_GRID = 8


@dataclass(frozen=True, eq=False)
class Features:
    """Of one photo, in pixels of the full photo divided by its long side.

    points : (n, 2); descriptors : (n, 128) float32 of unit length
    width, height : 1 along the long side
    focal : in the same unit, None where unknown
    """

    points: FloatArray
    descriptors: Float32Array
    width: float
    height: float
    focal: float | None

    @property
    def matrix(self) -> FloatArray | None:
        """(3, 3) calibration matrix in these units; None without a focal length."""
        if self.focal is None:
            return None
        return np.array(
            [[self.focal, 0, self.width / 2], [0, self.focal, self.height / 2], [0, 0, 1.0]]
        )


@dataclass(frozen=True, eq=False)
class PairOverlap:
    """Two photos that show the same.

    matches : verified; plane_share : of them that one homography explains
    overlap : share of the smaller seen part: of the first photo in the second, or the other way
    pixel_ratio : metres per pixel of the first photo over those of the second
    rotation : (3, 3) from the first camera to the second, None where focal lengths are unknown
    baseline_ratio : distance of the cameras over that to the rock, at least; None if it is unknown
    inside : (GRID * GRID,) which places of the first photo lie on the second, and `inside_back`
    """

    first: int
    second: int
    matches: int
    plane_share: float
    overlap: float
    pixel_ratio: float | None
    rotation: FloatArray | None
    baseline_ratio: float | None
    inside: BoolArray
    inside_back: BoolArray

    @property
    def turn_deg(self) -> float | None:
        """Angle between the optical axes."""
        if self.rotation is None:
            return None
        return math.degrees(math.acos(float(np.clip(self.rotation[2, 2], -1.0, 1.0))))


@dataclass(frozen=True, eq=False)
class SetOverlap:
    """pairs : that match; views : per photo, the median number of photos (itself among them) that
    see a place of it; views_low : share of places that fewer than three photos see;
    compared : number of pairs that were tried"""

    pairs: tuple[PairOverlap, ...]
    views: FloatArray
    views_low: FloatArray
    compared: int

    def components(self, count: int) -> list[list[int]]:
        """Connected components of `count` photos, the largest first."""
        label = list(range(count))

        def root(i: int) -> int:
            while label[i] != i:
                label[i] = label[label[i]]
                i = label[i]
            return i

        for pair in self.pairs:
            label[root(pair.first)] = root(pair.second)
        groups: dict[int, list[int]] = {}
        for i in range(count):
            groups.setdefault(root(i), []).append(i)
        return sorted(groups.values(), key=lambda g: (-len(g), g))


def features_of(photo: Photo) -> Features | None:
    """None for a photo that cannot be decoded. A function of one photo, for any process."""
    import cv2

    from vomstudio.core.errors import InputError
    from vomstudio.io.photos.pixels import grey, read_mask

    try:
        pixels = grey(photo, LONG_SIDE)
        mask = read_mask(photo)
    except InputError:
        return None
    small = None
    if mask is not None:
        size = (pixels.shape[1], pixels.shape[0])
        small = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    sift = cv2.SIFT.create(MOST_FEATURES, contrastThreshold=0.02)
    keys, descriptors = sift.detectAndCompute(np.ascontiguousarray(pixels), small)
    long_side = float(max(pixels.shape))
    points = np.array([key.pt for key in keys], np.float64).reshape(-1, 2) / long_side
    if descriptors is None:
        descriptors = np.empty((0, 128), np.float32)
    # RootSIFT (Arandjelovic & Zisserman 2012).
    total = np.maximum(descriptors.sum(1, keepdims=True), 1e-9)
    rooted = np.sqrt(descriptors / total).astype(np.float32)
    focal = None if photo.focal_px is None else photo.focal_px / photo.long_side
    return Features(
        points,
        rooted,
        pixels.shape[1] / long_side,
        pixels.shape[0] / long_side,
        focal,
    )


def choose_pairs(count: int, positions: FloatArray | None = None) -> list[tuple[int, int]]:
    """All pairs of a small set; else those that are near in order, or in place where known.

    positions : (count, 2 or 3), NaN where unknown
    """
    if count <= _ALL_PAIRS_UP_TO:
        return list(itertools.combinations(range(count), 2))
    chosen = {(i, j) for i in range(count) for j in range(i + 1, min(i + _NEIGHBOURS + 1, count))}
    if positions is not None:
        known = np.flatnonzero(np.isfinite(positions).all(axis=1))
        for i in known:
            away = np.linalg.norm(positions[known] - positions[i], axis=1)
            for j in known[np.argsort(away, kind="stable")[1 : _NEIGHBOURS + 3]]:
                chosen.add((min(i, j), max(i, j)))
    return sorted(chosen)


def match_pair(a: Features, b: Features) -> tuple[FloatArray, FloatArray]:
    """Matched points (n, 2) of each, before verification."""
    if len(a.points) < FEWEST_MATCHES or len(b.points) < FEWEST_MATCHES:
        return np.empty((0, 2)), np.empty((0, 2))
    likeness = a.descriptors @ b.descriptors.T
    forth, back = np.argmax(likeness, 1), np.argmax(likeness, 0)
    rows = np.arange(len(likeness))
    best = likeness[rows, forth]
    second = likeness.copy()
    second[rows, forth] = -1.0
    near, next_ = (np.sqrt(np.maximum(2 - 2 * v, 0)) for v in (best, second.max(1)))
    good = (back[forth] == rows) & (near < _RATIO * next_)
    return a.points[good], b.points[forth[good]]


def compare_pair(i: int, j: int, a: Features, b: Features) -> PairOverlap | None:
    """None where the two do not show the same rock."""
    import cv2

    p, q = match_pair(a, b)
    if len(p) < FEWEST_MATCHES:
        return None
    cv2.setRNGSeed(1)
    threshold = 1.5 / LONG_SIDE
    _, sound = cv2.findFundamentalMat(p, q, cv2.FM_RANSAC, threshold, 0.999, 2000)
    if sound is None:
        return None
    keep = sound.ravel().astype(bool)
    if keep.sum() < FEWEST_MATCHES or keep.sum() < 0.2 * len(p):
        return None
    p, q = p[keep], q[keep]
    # Looser than the epipolar one: relief is no reason to doubt that a face is one plane.
    plane, on_plane = cv2.findHomography(p, q, cv2.RANSAC, 4.0 / LONG_SIDE, None, 2000, 0.999)
    share = 0.0 if on_plane is None else float(on_plane.mean())
    if plane is None or share < _PLANE_SHARE or abs(np.linalg.det(plane)) < 1e-9:
        inside, back = _inside_hull(p, a), _inside_hull(q, b)
        rotation, ratio = _rotation_by_essential_matrix(p, q, a, b), None
    else:
        inside = _inside(plane, a, b)
        back = _inside(np.linalg.inv(plane), b, a)
        ratio = _pixel_ratio(plane, a)
        rotation = None
    base = None
    if plane is not None and share >= 0.8:
        rotation, base = _plane_motion(plane, a, b)
    if rotation is None:
        rotation = _rotation_by_essential_matrix(p, q, a, b)
    return PairOverlap(
        i,
        j,
        len(p),
        share,
        float(min(inside.mean(), back.mean())),
        ratio,
        rotation,
        base,
        inside,
        back,
    )


def compare_photos(
    features: Sequence[Features | None],
    positions: FloatArray | None = None,
    progress: Progress | None = None,
) -> SetOverlap:
    """All pairs worth looking at; a photo without features matches nothing."""
    progress = progress or Silent()
    count = len(features)
    tried = choose_pairs(count, positions)
    progress.stage(tr("Matching photos"), len(tried))
    pairs: list[PairOverlap] = []
    _compare_pairs(features, tried, pairs, progress)
    more = _pairs_between_components(count, tried, pairs)
    if more:
        progress.stage(tr("Matching disconnected components"), len(more))
        _compare_pairs(features, more, pairs, progress)
        tried = tried + more
    seen = np.ones((count, _GRID * _GRID))
    for pair in pairs:
        seen[pair.first] += pair.inside
        seen[pair.second] += pair.inside_back
    return SetOverlap(tuple(pairs), np.median(seen, axis=1), (seen < 3).mean(axis=1), len(tried))


def _compare_pairs(
    features: Sequence[Features | None],
    tried: Sequence[tuple[int, int]],
    pairs: list[PairOverlap],
    progress: Progress,
) -> None:
    for done, (i, j) in enumerate(tried):
        progress.step(done)
        a, b = features[i], features[j]
        if a is not None and b is not None:
            found = compare_pair(i, j, a, b)
            if found is not None:
                pairs.append(found)
    progress.step(len(tried))


def _pairs_between_components(
    count: int, tried: Sequence[tuple[int, int]], pairs: Sequence[PairOverlap]
) -> list[tuple[int, int]]:
    """Pairs that were left out and could join what seems to fall apart: the neighbours in order
    need not be neighbours on the rock."""
    if count <= _ALL_PAIRS_UP_TO:
        return []
    parts = SetOverlap(tuple(pairs), np.empty(0), np.empty(0), 0).components(count)
    done = set(tried)
    found = [
        (min(i, j), max(i, j))
        for p, part in enumerate(parts[1:], 1)
        for i in part
        for other in parts[:p]
        for j in other
        if (min(i, j), max(i, j)) not in done
    ]
    step = max(1, -(-len(found) // _MOST_EXTRA_PAIRS))
    return found[::step]


def optical_axes(look: SetOverlap, count: int) -> tuple[FloatArray, BoolArray]:
    """Directions of view (count, 3) in the frame of one camera, and which photos they are known
    for: relative rotations chained along the best matched pairs of the largest component."""
    best = sorted((p for p in look.pairs if p.rotation is not None), key=lambda p: -p.matches)
    part = set(look.components(count)[0]) if count else set()
    rotation: dict[int, FloatArray] = {}
    if best:
        rotation[best[0].first] = np.eye(3)
    grown = True
    while grown:
        grown = False
        for pair in best:
            i, j = pair.first, pair.second
            assert pair.rotation is not None
            if i in rotation and j not in rotation:
                rotation[j] = pair.rotation @ rotation[i]
            elif j in rotation and i not in rotation:
                rotation[i] = pair.rotation.T @ rotation[j]
            else:
                continue
            grown = True
            break
    axes = np.full((count, 3), np.nan)
    for i, r in rotation.items():
        if i in part:
            axes[i] = r[2]
    return axes, np.isfinite(axes[:, 0])


# ------------------------------------------------------------------------------------------------
def _places(f: Features) -> FloatArray:
    steps = (np.arange(_GRID) + 0.5) / _GRID
    x, y = np.meshgrid(steps * f.width, steps * f.height)
    return np.column_stack([x.ravel(), y.ravel()])


def _inside(plane: FloatArray, a: Features, b: Features) -> BoolArray:
    """Which places of a the homography carries onto b."""
    at = np.column_stack([_places(a), np.ones(_GRID * _GRID)]) @ plane.T
    centre = plane[2] @ [a.width / 2, a.height / 2, 1.0]
    front = at[:, 2] * np.sign(centre) > 1e-9
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = at[:, 0] / at[:, 2], at[:, 1] / at[:, 2]
        on = (x >= 0) & (x <= b.width) & (y >= 0) & (y <= b.height)
    return np.asarray(front & on)


def _inside_hull(points: FloatArray, f: Features) -> BoolArray:
    """Which places lie among the matches; for scenes that are no plane."""
    import cv2

    hull = cv2.convexHull(points.astype(np.float32))
    return np.array(
        [cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0 for x, y in _places(f)]
    )


def _pixel_ratio(plane: FloatArray, a: Features) -> float | None:
    """Magnification of the homography at the centre of the first photo."""
    x, y = a.width / 2, a.height / 2
    w = plane[2] @ [x, y, 1.0]
    u, v = (plane[:2] @ [x, y, 1.0]) / w
    jacobian = (plane[:2, :2] - np.outer([u, v], plane[2, :2])) / w
    area = abs(np.linalg.det(jacobian))
    return float(math.sqrt(area)) if 1e-6 < area < 1e6 else None


def _plane_motion(
    plane: FloatArray, a: Features, b: Features
) -> tuple[FloatArray | None, float | None]:
    """Rotation from the first camera to the second, and their distance over that to the rock."""
    k1, k2 = a.matrix, b.matrix
    if k1 is None or k2 is None:
        return None, None
    h = np.linalg.inv(k2) @ plane @ k1
    u, s, vt = np.linalg.svd(h)
    if s[1] < 1e-9:
        return None, None
    base = float((s[0] - s[2]) / s[1])
    if base > _ONE_PLACE:
        return _facing_rotation(h), base
    sign = np.sign(np.linalg.det(u @ vt))
    return np.asarray(sign * u @ vt), base


def _facing_rotation(h: FloatArray) -> FloatArray | None:
    """Of the motions that explain a plane (two remain once it lies before the cameras) the one for
    which it faces the first camera most: in the other, camera path and normal trade places."""
    import cv2

    count, rotations, _, normals = cv2.decomposeHomographyMat(h, np.eye(3))
    if not count:
        return None
    # Each comes with both signs of the normal and the same rotation.
    facing = [abs(float(np.ravel(n)[2])) for n in normals]
    return np.asarray(rotations[int(np.argmax(facing))], np.float64)


_ONE_PLACE = 0.02
"""Baseline over distance under which two photos count as taken from one position: what lens
distortion and the rounding of an EXIF focal length leave of a pure rotation."""


def _rotation_by_essential_matrix(
    p: FloatArray, q: FloatArray, a: Features, b: Features
) -> FloatArray | None:
    """Rotation by the essential matrix."""
    import cv2

    k1, k2 = a.matrix, b.matrix
    if k1 is None or k2 is None or len(p) < FEWEST_MATCHES:
        return None
    n1 = (p - [k1[0, 2], k1[1, 2]]) / k1[0, 0]
    n2 = (q - [k2[0, 2], k2[1, 2]]) / k2[0, 0]
    mean_focal = (k1[0, 0] + k2[0, 0]) / 2
    essential, _ = cv2.findEssentialMat(
        n1, n2, np.eye(3), cv2.RANSAC, 0.999, 1.0 / LONG_SIDE / mean_focal
    )
    if essential is None or essential.shape != (3, 3):
        return None
    _, rotation, _, _ = cv2.recoverPose(essential, n1, n2, np.eye(3))
    return np.asarray(rotation, np.float64)
