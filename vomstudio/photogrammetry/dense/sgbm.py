"""Depth from a pair of photos by semi-global matching (Hirschmueller, 2008; OpenCV).

The pair is rectified along its baseline, and the second picture is sheared along its rows by the
disparity of the plane through the tie points. Only the difference from this plane is then searched.
This reduces the number of disparities, and an oblique face is matched as if seen at right angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from vomstudio.geometry.cameras import View
from vomstudio.geometry.kernels.jit import to_kernel_array

# Window size in pixels. Larger windows extend the depth of a face beyond its edges: with a size of
# 5, synthetic faces are measured less accurately (tests/benchmarks/bench_dense), and joint steps
# are filled.
_WINDOW_SIZE = 3
# Maximum number of disparities; a deeper scene is matched at a lower resolution.
_MAX_DISPARITIES = 256
_MIN_REDUCTION = 0.4
_MAX_GROWTH = 4.0
_MAX_SLOPE = 0.6


@dataclass(frozen=True, eq=False)
class Rectification:
    """Rectification of a pair, with pixel centres at half-integer coordinates.

    Attributes
    ----------
    first, second : (3, 3) array
        Homographies from the pixels of each photo to the rectified planes; the second includes the
        shear.
    rotation : (3, 3) array
        Rotation from the scene to the rectified frame.
    focal : float
        Focal length of both planes, pixels.
    baseline : float
        Distance between the projection centres.
    plane : (float, float, float)
        Coefficients alpha, beta, gamma of the reference disparity alpha u + beta v + gamma.
    min_disparity, count : int
        Range of disparities to search.
    left, top, width, height : int
        Part of the plane to fill.
    """

    first: FloatArray
    second: FloatArray
    rotation: FloatArray
    focal: float
    baseline: float
    plane: tuple[float, float, float]
    min_disparity: int
    count: int
    left: int
    top: int
    width: int
    height: int

    @property
    def step(self) -> float:
        """Change of inverse depth, in the rectified frame, per pixel of disparity."""
        return (1.0 - self.plane[0]) / (self.focal * self.baseline)


def rectify(
    first: View, second: View, points: FloatArray, min_depth: float, max_depth: float
) -> Rectification | None:
    """Rectify two pinhole photos, or return None if rectification is not useful.

    Parameters
    ----------
    first, second : View
    points : (n, 3) array
        Tie points of the first photo.
    min_depth, max_depth : float
        Range of depths in the first photo.
    """
    baseline = second.centre - first.centre
    baseline_length = float(np.linalg.norm(baseline))
    x = baseline / baseline_length
    z = first.direction + second.direction
    z = z - x * (z @ x)
    if not np.linalg.norm(z) > 0.5:
        return None
    z /= np.linalg.norm(z)
    rotation = np.stack([x, np.cross(z, x), z])
    lens = first.intrinsics
    focal = float(np.mean(lens.focal))

    for _ in range(2):
        bounds = _rectified_box(first, rotation, focal)
        if bounds is None:
            return None
        left, top, right, bottom = bounds
        plane, min_difference, max_difference = _disparity_range(
            (points - first.centre) @ rotation.T, focal, baseline_length, min_depth, max_depth
        )
        count = int(np.ceil((max_difference - min_difference + 1) / 16)) * 16
        if count <= _MAX_DISPARITIES:
            break
        focal *= 0.98 * (_MAX_DISPARITIES - 16) / count
        if focal < _MIN_REDUCTION * float(np.mean(lens.focal)):
            return None
    else:
        return None
    min_disparity = int(np.floor(min_difference))
    # SGBM excludes columns whose matching column may lie beyond the edge.
    left_margin, right_margin = max(min_disparity + count, 0) + 2, max(-min_disparity, 0) + 2
    width, height = right - left + left_margin + right_margin, bottom - top
    if width * height > _MAX_GROWTH * lens.width * lens.height:
        return None
    camera_matrix = np.diag([focal, focal, 1.0])
    alpha, beta, gamma = plane
    shear = np.array([[1.0 - alpha, -beta, -gamma], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

    def project_onto(view: View) -> FloatArray:
        return np.asarray(
            camera_matrix @ rotation @ view.rotation.T @ np.linalg.inv(view.intrinsics.matrix),
            np.float64,
        )

    return Rectification(
        project_onto(first),
        np.linalg.inv(shear) @ project_onto(second),
        rotation,
        focal,
        baseline_length,
        plane,
        min_disparity,
        count,
        left - left_margin,
        top,
        width,
        height,
    )


def pair_inverse_depth(
    first: tuple[View, ByteArray, BoolArray],
    second: tuple[View, ByteArray, BoolArray],
    points: FloatArray,
    min_depth: float,
    max_depth: float,
) -> tuple[Float32Array, float] | None:
    """Return inverse depths (h, w) in the first photo, and their change per disparity pixel.

    Pixels without a depth are 0. Returns None if the pair cannot be rectified.

    Parameters
    ----------
    first, second : (View, array, array)
        Pinhole view, greyscale picture and mask of each photo.
    points : (n, 3) array
        Tie points of the first photo.
    min_depth, max_depth : float
        Range of depths in the first photo.
    """
    import cv2

    from vomstudio.photogrammetry.dense._depth_kernels import convert_disparities

    rectification = rectify(first[0], second[0], points, min_depth, max_depth)
    if rectification is None:
        return None
    size = (rectification.width, rectification.height)
    # Convert between pixels counted from the corner of the first pixel and OpenCV's, counted from
    # its centre.
    shift = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    crop_offset = np.array(
        [[1.0, 0.0, -rectification.left], [0.0, 1.0, -rectification.top], [0.0, 0.0, 1.0]]
    )
    # OpenCV's cubic weights would shift the pictures by up to 0.05 pixel.
    pictures = [
        cv2.warpPerspective(gray, crop_offset @ homography @ shift, size, flags=cv2.INTER_LANCZOS4)
        for homography, gray in ((rectification.first, first[1]), (rectification.second, second[1]))
    ]
    is_visible = cv2.warpPerspective(
        second[2].astype(np.uint8),
        crop_offset @ rectification.second @ shift,
        size,
        flags=cv2.INTER_NEAREST,
    )
    matcher = cv2.StereoSGBM.create(
        minDisparity=rectification.min_disparity,
        numDisparities=rectification.count,
        blockSize=_WINDOW_SIZE,
        P1=8 * _WINDOW_SIZE * _WINDOW_SIZE,
        P2=32 * _WINDOW_SIZE * _WINDOW_SIZE,
        disp12MaxDiff=1,
        preFilterCap=63,
        uniquenessRatio=5,
        speckleWindowSize=100,
        speckleRange=2,
        mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    )
    disparities = matcher.compute(*pictures)
    inverse_depths = np.empty(first[1].shape, np.float32)
    coefficients = np.array(
        [
            *rectification.plane,
            1.0 / (rectification.focal * rectification.baseline),
            rectification.focal,
            *(first[0].rotation @ rectification.rotation.T)[2],
        ]
    )
    convert_disparities(
        to_kernel_array(disparities, np.int16),
        to_kernel_array(is_visible, np.uint8),
        rectification.min_disparity,
        rectification.count,
        rectification.left,
        rectification.top,
        24,
        to_kernel_array(rectification.first, np.float64),
        coefficients,
        to_kernel_array(first[2], np.uint8),
        inverse_depths,
    )
    return inverse_depths, rectification.step


def _rectified_box(
    view: View, rotation: FloatArray, focal: float
) -> tuple[int, int, int, int] | None:
    """Return the bounds of the photo on the rectified plane: left, top, right, bottom.

    Returns None if the photo is too oblique to the plane.
    """
    w, h = view.intrinsics.width, view.intrinsics.height
    corners = view.intrinsics.rays([[0, 0], [w, 0], [w, h], [0, h]]) @ view.rotation @ rotation.T
    if not (corners[:, 2] > 0.2 * np.linalg.norm(corners, axis=1)).all():
        return None
    image_corners = focal * corners[:, :2] / corners[:, 2:]
    (left, top), (right, bottom) = (
        np.floor(image_corners.min(axis=0)),
        np.ceil(image_corners.max(axis=0)),
    )
    return int(left), int(top), int(right), int(bottom)


def _disparity_range(
    xyz: FloatArray,
    focal: float,
    baseline: float,
    min_depth: float,
    max_depth: float,
) -> tuple[tuple[float, float, float], float, float]:
    """Return the disparity plane through tie points, and the range of differences from it."""
    xyz = xyz[(xyz[:, 2] > 0.7 * min_depth) & (xyz[:, 2] < 1.4 * max_depth)]
    u, v = (focal * xyz[:, :2] / xyz[:, 2:]).T
    disparity = focal * baseline / xyz[:, 2]
    if len(xyz) < 5:
        gamma = focal * baseline / min_depth
        return (0.0, 0.0, gamma), focal * baseline / max_depth - gamma, 0.0
    plane = _fit_disparity_plane(u, v, disparity)
    differences = (disparity - (plane[0] * u + plane[1] * v + plane[2])) / (1.0 - plane[0])
    low, high = np.percentile(differences, [0.5, 99.5])
    margin = 6.0 + 0.15 * (high - low) + 0.02 * float(np.median(disparity))
    return plane, float(low - margin), float(high + margin)


def _fit_disparity_plane(
    u: FloatArray, v: FloatArray, disparity: FloatArray
) -> tuple[float, float, float]:
    """Fit a plane by iteratively reweighted least squares.

    The weights approximate least absolute differences. If the plane is too steep, the plane of
    constant median disparity is returned.
    """
    design = np.column_stack([u, v, np.ones_like(u)])
    weights = np.ones_like(u)
    solution = np.zeros(3)
    for _ in range(8):
        root_weights = np.sqrt(weights)[:, None]
        solution = np.linalg.lstsq(
            design * root_weights, disparity * root_weights[:, 0], rcond=None
        )[0]
        weights = 1.0 / np.maximum(np.abs(disparity - design @ solution), 0.25)
    if abs(solution[0]) > _MAX_SLOPE or abs(solution[1]) > 2 * _MAX_SLOPE:
        return 0.0, 0.0, float(np.median(disparity))
    return float(solution[0]), float(solution[1]), float(solution[2])
