"""Detection of photos of the same rock by a quick comparison of reduced versions.

SIFT features of photos reduced to about 800 pixels are matched mutually with a ratio test, and
verified by a fundamental matrix. If one homography explains a pair (a rock face is nearly planar),
it determines the overlap of the two pictures, the ratio of their pixel sizes, and the distance
between the cameras. If both calibrations are known, K2^-1 H K1, scaled to a middle singular value
of 1, is R + t n'/d. Its first and last singular values are equal for a single position, and
otherwise differ by about the ratio of baseline to distance (Faugeras & Lustman 1988; Malis & Vargas
2007, INRIA RR-6303).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


LONG_SIDE = 800
MAX_FEATURES = 1500
MIN_MATCHES = 16
_MAX_MATCH_RATIO = 0.8
# In larger sets, only neighbours are compared.
_MAX_PHOTOS_ALL_PAIRS = 40
_N_NEIGHBOURS = 6
# Maximum number of pairs between the components of a large set.
_MAX_EXTRA_PAIRS = 1200
# Minimum share of matches that the homography of a plane explains.
_MIN_PLANE_SHARE = 0.6
_GRID_SIZE = 8


@dataclass(frozen=True, eq=False)
class NormalizedFeatures:
    """Features of a photo, in coordinates of the full photo divided by its long side.

    points : (n, 2)
    descriptors : (n, 128) float32 of unit length
    width, height : size, 1 along the long side
    focal : focal length in the same unit, or None if unknown
    """

    points: FloatArray
    descriptors: Float32Array
    width: float
    height: float
    focal: float | None

    @property
    def calibration_matrix(self) -> FloatArray | None:
        """Calibration matrix (3, 3) in these units; None if the focal length is unknown."""
        if self.focal is None:
            return None
        return np.array(
            [[self.focal, 0, self.width / 2], [0, self.focal, self.height / 2], [0, 0, 1.0]]
        )


@dataclass(frozen=True, eq=False)
class PairOverlap:
    """Overlap of two photos.

    Attributes
    ----------
    first, second : int
        Rows of the photos.
    matches : int
        Number of verified matches.
    plane_share : float
        Share of matches that one homography explains.
    overlap : float
        Share of either photo that the other one shows, whichever is smaller.
    pixel_ratio : float or None
        Pixel size on the rock of the first photo divided by that of the second; None if unknown.
    rotation : (3, 3) array or None
        Rotation from the first camera to the second; None if unknown.
    baseline_ratio : float or None
        Lower limit of the ratio of the baseline to the distance from the rock; None if unknown.
    is_inside, is_inside_back : (k,) array of bool
        Which points of a grid on the first photo the second one shows, and vice versa.
    """

    first: int
    second: int
    matches: int
    plane_share: float
    overlap: float
    pixel_ratio: float | None
    rotation: FloatArray | None
    baseline_ratio: float | None
    is_inside: BoolArray
    is_inside_back: BoolArray

    @property
    def turn_deg(self) -> float | None:
        """Angle between the optical axes; None if the rotation is unknown."""
        if self.rotation is None:
            return None
        return math.degrees(math.acos(float(np.clip(self.rotation[2, 2], -1.0, 1.0))))


@dataclass(frozen=True, eq=False)
class SetOverlap:
    """Overlap of a set of photos.

    Attributes
    ----------
    pairs : tuple of PairOverlap
    views : (n,) array
        Median number of photos that show a point of each photo, including the photo itself.
    low_view_shares : (n,) array
        Share of the points of each photo that fewer than three photos show.
    compared : int
        Number of compared pairs.
    """

    pairs: tuple[PairOverlap, ...]
    views: FloatArray
    low_view_shares: FloatArray
    compared: int

    def components(self, count: int) -> list[list[int]]:
        """Return the connected components of `count` photos, the largest first."""
        parents = list(range(count))

        def root(i: int) -> int:
            while parents[i] != i:
                parents[i] = parents[parents[i]]
                i = parents[i]
            return i

        for pair in self.pairs:
            parents[root(pair.first)] = root(pair.second)
        groups: dict[int, list[int]] = {}
        for i in range(count):
            groups.setdefault(root(i), []).append(i)
        return sorted(groups.values(), key=lambda g: (-len(g), g))


def extract_features(photo: Photo) -> NormalizedFeatures | None:
    """Return the features of a photo, or None if it cannot be decoded; runs in any process."""
    import cv2

    from vomstudio.core.errors import InputError
    from vomstudio.io.photos.pixels import grey, read_mask

    try:
        pixels = grey(photo, LONG_SIDE)
        mask = read_mask(photo)
    except InputError:
        return None
    reduced_mask = None
    if mask is not None:
        size = (pixels.shape[1], pixels.shape[0])
        reduced_mask = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    sift = cv2.SIFT.create(MAX_FEATURES, contrastThreshold=0.02)
    keypoints, descriptors = sift.detectAndCompute(np.ascontiguousarray(pixels), reduced_mask)
    long_side = float(max(pixels.shape))
    points = (
        np.array([keypoint.pt for keypoint in keypoints], np.float64).reshape(-1, 2) / long_side
    )
    if descriptors is None:
        descriptors = np.empty((0, 128), np.float32)
    # RootSIFT (Arandjelovic & Zisserman 2012).
    descriptor_sums = np.maximum(descriptors.sum(1, keepdims=True), 1e-9)
    root_descriptors = np.sqrt(descriptors / descriptor_sums).astype(np.float32)
    focal = None if photo.focal_px is None else photo.focal_px / photo.long_side
    return NormalizedFeatures(
        points,
        root_descriptors,
        pixels.shape[1] / long_side,
        pixels.shape[0] / long_side,
        focal,
    )


def choose_check_pairs(count: int, positions: FloatArray | None = None) -> list[tuple[int, int]]:
    """Select all pairs of a small set, or pairs near in order or position of a large set.

    positions : (count, 2 or 3); NaN if unknown
    """
    if count <= _MAX_PHOTOS_ALL_PAIRS:
        return list(itertools.combinations(range(count), 2))
    pairs = {(i, j) for i in range(count) for j in range(i + 1, min(i + _N_NEIGHBOURS + 1, count))}
    if positions is not None:
        known_indices = np.flatnonzero(np.isfinite(positions).all(axis=1))
        for i in known_indices:
            distances = np.linalg.norm(positions[known_indices] - positions[i], axis=1)
            for j in known_indices[np.argsort(distances, kind="stable")[1 : _N_NEIGHBOURS + 3]]:
                pairs.add((min(i, j), max(i, j)))
    return sorted(pairs)


def match_pair(a: NormalizedFeatures, b: NormalizedFeatures) -> tuple[FloatArray, FloatArray]:
    """Return matched points (n, 2) of each photo, before verification."""
    if len(a.points) < MIN_MATCHES or len(b.points) < MIN_MATCHES:
        return np.empty((0, 2)), np.empty((0, 2))
    similarities = a.descriptors @ b.descriptors.T
    forward_matches, backward_matches = np.argmax(similarities, 1), np.argmax(similarities, 0)
    rows = np.arange(len(similarities))
    best_similarities = similarities[rows, forward_matches]
    other_similarities = similarities.copy()
    other_similarities[rows, forward_matches] = -1.0
    best_distances, second_distances = (
        np.sqrt(np.maximum(2 - 2 * v, 0)) for v in (best_similarities, other_similarities.max(1))
    )
    is_match = (backward_matches[forward_matches] == rows) & (
        best_distances < _MAX_MATCH_RATIO * second_distances
    )
    return a.points[is_match], b.points[forward_matches[is_match]]


def compare_pair(
    i: int, j: int, a: NormalizedFeatures, b: NormalizedFeatures
) -> PairOverlap | None:
    """Return the overlap of two photos, or None if they do not show the same rock."""
    import cv2

    p, q = match_pair(a, b)
    if len(p) < MIN_MATCHES:
        return None
    cv2.setRNGSeed(1)
    threshold = 1.5 / LONG_SIDE
    _, inliers = cv2.findFundamentalMat(p, q, cv2.FM_RANSAC, threshold, 0.999, 2000)
    if inliers is None:
        return None
    is_inlier = inliers.ravel().astype(bool)
    if is_inlier.sum() < MIN_MATCHES or is_inlier.sum() < 0.2 * len(p):
        return None
    p, q = p[is_inlier], q[is_inlier]
    # The tolerance is larger than the epipolar one, to allow for relief.
    homography, is_on_plane = cv2.findHomography(
        p, q, cv2.RANSAC, 4.0 / LONG_SIDE, None, 2000, 0.999
    )
    plane_share = 0.0 if is_on_plane is None else float(is_on_plane.mean())
    if (
        homography is None
        or plane_share < _MIN_PLANE_SHARE
        or abs(np.linalg.det(homography)) < 1e-9
    ):
        is_inside, is_inside_back = _is_inside_hull(p, a), _is_inside_hull(q, b)
        rotation, pixel_ratio = _rotation_from_essential_matrix(p, q, a, b), None
    else:
        is_inside = _is_in_other_photo(homography, a, b)
        is_inside_back = _is_in_other_photo(np.linalg.inv(homography), b, a)
        pixel_ratio = _pixel_ratio(homography, a)
        rotation = None
    baseline_ratio = None
    if homography is not None and plane_share >= 0.8:
        rotation, baseline_ratio = _plane_motion(homography, a, b)
    if rotation is None:
        rotation = _rotation_from_essential_matrix(p, q, a, b)
    return PairOverlap(
        i,
        j,
        len(p),
        plane_share,
        float(min(is_inside.mean(), is_inside_back.mean())),
        pixel_ratio,
        rotation,
        baseline_ratio,
        is_inside,
        is_inside_back,
    )


def compare_photos(
    features: Sequence[NormalizedFeatures | None],
    positions: FloatArray | None = None,
    progress: Progress | None = None,
) -> SetOverlap:
    """Compare all useful pairs of photos; photos without features do not match any."""
    progress = progress or SilentProgress()
    count = len(features)
    compared_pairs = choose_check_pairs(count, positions)
    progress.stage(tr("Matching photos"), len(compared_pairs))
    pairs: list[PairOverlap] = []
    _compare_pairs(features, compared_pairs, pairs, progress)
    extra_pairs = _pairs_between_components(count, compared_pairs, pairs)
    if extra_pairs:
        progress.stage(tr("Matching disconnected components"), len(extra_pairs))
        _compare_pairs(features, extra_pairs, pairs, progress)
        compared_pairs = compared_pairs + extra_pairs
    view_counts = np.ones((count, _GRID_SIZE * _GRID_SIZE))
    for pair in pairs:
        view_counts[pair.first] += pair.is_inside
        view_counts[pair.second] += pair.is_inside_back
    return SetOverlap(
        tuple(pairs),
        np.median(view_counts, axis=1),
        (view_counts < 3).mean(axis=1),
        len(compared_pairs),
    )


def _compare_pairs(
    features: Sequence[NormalizedFeatures | None],
    candidates: Sequence[tuple[int, int]],
    pairs: list[PairOverlap],
    progress: Progress,
) -> None:
    for done_count, (i, j) in enumerate(candidates):
        progress.step(done_count)
        a, b = features[i], features[j]
        if a is not None and b is not None:
            overlap = compare_pair(i, j, a, b)
            if overlap is not None:
                pairs.append(overlap)
    progress.step(len(candidates))


def _pairs_between_components(
    count: int, compared_pairs: Sequence[tuple[int, int]], pairs: Sequence[PairOverlap]
) -> list[tuple[int, int]]:
    """Return pairs to compare between components.

    They are needed because neighbours in order are not always neighbours on the rock.
    """
    if count <= _MAX_PHOTOS_ALL_PAIRS:
        return []
    components = SetOverlap(tuple(pairs), np.empty(0), np.empty(0), 0).components(count)
    compared_set = set(compared_pairs)
    candidates = [
        (min(i, j), max(i, j))
        for p, component in enumerate(components[1:], 1)
        for i in component
        for other_component in components[:p]
        for j in other_component
        if (min(i, j), max(i, j)) not in compared_set
    ]
    step = max(1, -(-len(candidates) // _MAX_EXTRA_PAIRS))
    return candidates[::step]


def optical_axes(overlap: SetOverlap, count: int) -> tuple[FloatArray, BoolArray]:
    """Return the view directions (count, 3) in the frame of one camera, and which are known.

    Relative rotations are chained along the best-matched pairs of the largest component.
    """
    best_pairs = sorted(
        (p for p in overlap.pairs if p.rotation is not None), key=lambda p: -p.matches
    )
    largest_component = set(overlap.components(count)[0]) if count else set()
    rotations: dict[int, FloatArray] = {}
    if best_pairs:
        rotations[best_pairs[0].first] = np.eye(3)
    has_grown = True
    while has_grown:
        has_grown = False
        for pair in best_pairs:
            i, j = pair.first, pair.second
            assert pair.rotation is not None
            if i in rotations and j not in rotations:
                rotations[j] = pair.rotation @ rotations[i]
            elif j in rotations and i not in rotations:
                rotations[i] = pair.rotation.T @ rotations[j]
            else:
                continue
            has_grown = True
            break
    axes = np.full((count, 3), np.nan)
    for i, r in rotations.items():
        if i in largest_component:
            axes[i] = r[2]
    return axes, np.isfinite(axes[:, 0])


# ------------------------------------------------------------------------------------------------
def _grid_points(f: NormalizedFeatures) -> FloatArray:
    steps = (np.arange(_GRID_SIZE) + 0.5) / _GRID_SIZE
    x, y = np.meshgrid(steps * f.width, steps * f.height)
    return np.column_stack([x.ravel(), y.ravel()])


def _is_in_other_photo(
    homography: FloatArray, a: NormalizedFeatures, b: NormalizedFeatures
) -> BoolArray:
    """Return which grid points of photo `a` the homography maps into photo `b`."""
    projected_points = (
        np.column_stack([_grid_points(a), np.ones(_GRID_SIZE * _GRID_SIZE)]) @ homography.T
    )
    centre = homography[2] @ [a.width / 2, a.height / 2, 1.0]
    is_in_front = projected_points[:, 2] * np.sign(centre) > 1e-9
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = (
            projected_points[:, 0] / projected_points[:, 2],
            projected_points[:, 1] / projected_points[:, 2],
        )
        is_on_photo = (x >= 0) & (x <= b.width) & (y >= 0) & (y <= b.height)
    return np.asarray(is_in_front & is_on_photo)


def _is_inside_hull(points: FloatArray, f: NormalizedFeatures) -> BoolArray:
    """Return which grid points lie within the hull of the matches, for non-planar scenes."""
    import cv2

    hull = cv2.convexHull(points.astype(np.float32))
    return np.array(
        [cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0 for x, y in _grid_points(f)]
    )


def _pixel_ratio(homography: FloatArray, a: NormalizedFeatures) -> float | None:
    """Return the magnification of the homography at the centre of the first photo.

    Returns None if the homography is degenerate there.
    """
    x, y = a.width / 2, a.height / 2
    w = homography[2] @ [x, y, 1.0]
    u, v = (homography[:2] @ [x, y, 1.0]) / w
    jacobian = (homography[:2, :2] - np.outer([u, v], homography[2, :2])) / w
    area = abs(np.linalg.det(jacobian))
    return float(math.sqrt(area)) if 1e-6 < area < 1e6 else None


def _plane_motion(
    homography: FloatArray, a: NormalizedFeatures, b: NormalizedFeatures
) -> tuple[FloatArray | None, float | None]:
    """Return the rotation between the cameras, and the ratio of baseline to distance.

    Both are None if a focal length is unknown.
    """
    k1, k2 = a.calibration_matrix, b.calibration_matrix
    if k1 is None or k2 is None:
        return None, None
    h = np.linalg.inv(k2) @ homography @ k1
    u, s, vt = np.linalg.svd(h)
    if s[1] < 1e-9:
        return None, None
    baseline_ratio = float((s[0] - s[2]) / s[1])
    if baseline_ratio > _MAX_BASELINE_RATIO:
        return _facing_rotation(h), baseline_ratio
    sign = np.sign(np.linalg.det(u @ vt))
    return np.asarray(sign * u @ vt), baseline_ratio


def _facing_rotation(h: FloatArray) -> FloatArray | None:
    """Return the most probable rotation of a homography, or None if it has no solution.

    Two solutions have the plane in front of the cameras. The one whose plane faces the first camera
    most is used; in the other, camera path and normal are exchanged.
    """
    import cv2

    count, rotations, _, normals = cv2.decomposeHomographyMat(h, np.eye(3))
    if not count:
        return None
    # Each solution occurs with both signs of the normal and the same rotation.
    facing = [abs(float(np.ravel(n)[2])) for n in normals]
    return np.asarray(rotations[int(np.argmax(facing))], np.float64)


_MAX_BASELINE_RATIO = 0.02
"""Maximum ratio of baseline to distance of a single position.

Even for a pure rotation it is not zero, because of lens distortion and rounded EXIF focal
lengths."""


def _rotation_from_essential_matrix(
    p: FloatArray, q: FloatArray, a: NormalizedFeatures, b: NormalizedFeatures
) -> FloatArray | None:
    """Return the rotation from the essential matrix, or None if it cannot be computed."""
    import cv2

    k1, k2 = a.calibration_matrix, b.calibration_matrix
    if k1 is None or k2 is None or len(p) < MIN_MATCHES:
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
