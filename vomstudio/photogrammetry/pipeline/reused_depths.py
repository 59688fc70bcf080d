"""Reuse of depth maps of earlier runs whose cameras moved by less than a fifth of a pixel.

A photo that is added, removed or masked changes the adjustment of all cameras a little. A depth map
remains valid if the positions that it compares, in its own photo and in its sources, have moved by
less than `MAX_MOVE_PX`. Frames of different runs differ by a similarity, whose scale follows from
the distances between the cameras.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, VomError
from vomstudio.core.files.regular import MAX_JSON_BYTES, read_small_file
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.cameras_file import view_from_dict, view_to_dict
from vomstudio.photogrammetry.base.checkpoints import write_atomically
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.dense.pairs import DepthMapPlan

MAX_MOVE_PX = 0.2
"""Maximum shift of a reused depth map against its own photo and its sources, in its pixels."""
_N_SAMPLES = 400


@dataclass(frozen=True, eq=False)
class DepthInputs:
    """Photos and cameras from which a depth map was computed.

    Attributes
    ----------
    photo : str
        Hash of the photo and its mask.
    view : View
        Camera of the photo, with its lens.
    pinhole : View
        Camera of the undistorted photo.
    sources : tuple of (str, View)
        Hash and camera of each source photo.
    scale : float
        Depths in the file relative to the computed depths; 1 for a map that was not reused.
    """

    photo: str
    view: View
    pinhole: View
    sources: tuple[tuple[str, View], ...]
    scale: float = 1.0

    @classmethod
    def from_plan(
        cls, plan: DepthMapPlan, views: Sequence[View], hashes: Mapping[str, str], pinhole: View
    ) -> DepthInputs:
        """Return the inputs of a planned depth map."""
        view = views[plan.view]
        sources = (views[source.view] for source in plan.sources)
        return cls(
            hashes[view.name], view, pinhole, tuple((hashes[each.name], each) for each in sources)
        )

    def save(self, path: Path, rules: str) -> None:
        """Write the inputs beside the depth map; `rules` identify method and size."""
        content = {
            "rules": rules,
            "photo": self.photo,
            "view": view_to_dict(self.view),
            "pinhole": view_to_dict(self.pinhole),
            "sources": [[name, view_to_dict(view)] for name, view in self.sources],
            "scale": self.scale,
        }
        write_atomically(path, lambda p: p.write_text(json.dumps(content), encoding="utf-8"))

    @classmethod
    def load(cls, path: Path, rules: str) -> DepthInputs | None:
        """Load the inputs. Returns None if they are damaged or belong to other rules."""
        try:
            content: dict[str, Any] = json.loads(read_small_file(path, MAX_JSON_BYTES))
            if content["rules"] != rules:
                return None
            return cls(
                str(content["photo"]),
                view_from_dict(content["view"]),
                view_from_dict(content["pinhole"]),
                tuple((str(name), view_from_dict(view)) for name, view in content["sources"]),
                float(content["scale"]),
            )
        except (VomError, OSError, ValueError, KeyError, TypeError):
            return None


class EarlierDepthMaps:
    """Depth maps in the folders of earlier runs.

    Parameters
    ----------
    folders : iterable of Path
        Folders with depth maps NAME.npz and their inputs NAME.json, preferred ones first.
    rules : str
        See `DepthInputs.save`.
    """

    def __init__(self, folders: Iterable[Path], rules: str) -> None:
        self._maps: dict[str, list[tuple[Path, DepthInputs]]] = defaultdict(list)
        for folder in folders:
            for path in sorted(folder.glob("*.json")):
                inputs = DepthInputs.load(path, rules)
                if inputs is not None and path.with_suffix(".npz").exists():
                    self._maps[inputs.photo].append((path.with_suffix(".npz"), inputs))

    def find(
        self, photo: str, pinhole: View, views: Mapping[str, View]
    ) -> tuple[DepthMap, DepthInputs] | None:
        """Return the depth map of a photo for its present camera, with its inputs, or None.

        Parameters
        ----------
        photo : str
            Hash of the photo and its mask.
        pinhole : View
            Present camera of the undistorted photo.
        views : mapping of str to View
            Present cameras, with their lenses, by the hashes of their photos.
        """
        for path, inputs in self._maps.get(photo, ()):
            cameras = [views.get(name) for name, _ in inputs.sources]
            present = [camera for camera in cameras if camera is not None]
            if len(present) < len(cameras) or not cameras:
                continue
            try:
                depth_map = DepthMap.load(path)
            except InputError:
                continue
            lens = pinhole.intrinsics
            if depth_map.depth.shape != (lens.height, lens.width):
                continue
            scale = relative_scale(inputs, views[photo], present)
            samples = _sample_pixels(depth_map, inputs.scale)
            if scale is None or samples is None:
                continue
            if shift_px(inputs, samples, scale, views[photo], lens, present) < MAX_MOVE_PX:
                depth = (depth_map.depth * np.float32(scale / inputs.scale)).astype(np.float32)
                reused = replace(depth_map, name=pinhole.name, view=pinhole, depth=depth)
                return reused, replace(inputs, scale=scale)
        return None


def relative_scale(inputs: DepthInputs, view: View, sources: Sequence[View]) -> float | None:
    """Return the unit of the earlier scene in units of the present one.

    Parameters
    ----------
    inputs : DepthInputs
    view : View
        Present camera of the photo.
    sources : sequence of View
        Present cameras of the sources, in the order of the inputs.

    Returns
    -------
    float or None
        Median ratio of the distances of the sources from the photo; None if a source coincides
        with it.
    """
    old = [np.linalg.norm(each.centre - inputs.view.centre) for _, each in inputs.sources]
    new = [np.linalg.norm(each.centre - view.centre) for each in sources]
    if min(old) <= 0 or min(new) <= 0:
        return None
    return float(np.median(np.array(new) / np.array(old)))


def shift_px(
    inputs: DepthInputs,
    samples: FloatArray,
    scale: float,
    view: View,
    lens: Intrinsics,
    sources: Sequence[View],
) -> float:
    """Return how far the compared positions have moved, as 95th percentile in map pixels.

    Parameters
    ----------
    inputs : DepthInputs
    samples : (n, 3) ndarray
        Pixels x and y of the depth map, and their depths in the unit of the earlier scene.
    scale : float
        See `relative_scale`.
    view : View
        Present camera of the photo, with its lens.
    lens : Intrinsics
        Present pinhole camera of the map.
    sources : sequence of View
        Present cameras of the sources, in the order of the inputs.

    Returns
    -------
    float
        The largest value over the photo and its sources; infinite if positions are lost.
    """
    old_rays = inputs.pinhole.intrinsics.rays(samples[:, :2])
    new_rays = lens.rays(samples[:, :2])
    depths = samples[:, 2:]
    old_points = old_rays / old_rays[:, 2:] * depths
    new_points = new_rays / new_rays[:, 2:] * depths * scale
    pairs = [
        (inputs.view.intrinsics, old_points, view.intrinsics, new_points),
        *(
            (
                old_source.intrinsics,
                _transform_to_camera(old_points, inputs.view, old_source),
                new_source.intrinsics,
                _transform_to_camera(new_points, view, new_source),
            )
            for (_, old_source), new_source in zip(inputs.sources, sources, strict=True)
        ),
    ]
    largest_shift = 0.0
    for old_lens, old, new_lens, new in pairs:
        shifts = np.linalg.norm(old_lens.project(old) - new_lens.project(new), axis=1)
        is_known = np.isfinite(shifts)
        if is_known.mean() < 0.9:
            return float("inf")
        reduction = max(lens.width, lens.height) / max(old_lens.width, old_lens.height)
        largest_shift = max(largest_shift, float(np.percentile(shifts[is_known], 95)) * reduction)
    return largest_shift


def _transform_to_camera(points: FloatArray, view: View, other_view: View) -> FloatArray:
    """Transform points (n, 3) from the frame of one camera to that of another."""
    scene_points = (points - view.translation) @ view.rotation
    return np.asarray(scene_points @ other_view.rotation.T + other_view.translation)


def _sample_pixels(depth_map: DepthMap, scale: float) -> FloatArray | None:
    """Return pixels (n, 3: x, y and computed depth) at even intervals, or None without depths."""
    rows, columns = np.nonzero(depth_map.depth > 0)
    if not len(rows):
        return None
    indices = np.linspace(0, len(rows) - 1, min(_N_SAMPLES, len(rows))).astype(np.intp)
    rows, columns = rows[indices], columns[indices]
    depths = depth_map.depth[rows, columns].astype(np.float64) / scale
    return np.column_stack([columns + 0.5, rows + 0.5, depths])
