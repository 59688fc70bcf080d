"""Parts of the models in the view, with their distance and level of detail."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vomstudio.rendering.scene.appearance import Appearance
from vomstudio.rendering.scene.model_scene import ModelScene, Part
from vomstudio.rendering.view.camera import Camera, Eye
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.frame_timing import point_weight


def parts_in_view(
    models: Iterable[ModelScene],
    eye: Eye,
    size: tuple[int, int],
    clip: ClipBox | None,
    *,
    include_all_nodes: bool = False,
) -> list[tuple[ModelScene, Part]]:
    """Return the parts whose boxes may be in view, nearest first.

    For clouds, these are the nodes required for the view, or all loaded nodes if
    `include_all_nodes` is True.
    """
    parts = []
    aspect = size[0] / max(size[1], 1)
    for model in models:
        if not model.visible or not model.parts:
            continue
        low, high = model.chunk_boxes()
        half_size = (high - low) / 2.0
        centre = (low + high) / 2.0 + model.origin
        linear_part = model.to_world[:3, :3]
        centre = centre @ linear_part.T + model.to_world[:3, 3]
        radius = np.linalg.norm(half_size, axis=1) * np.cbrt(abs(np.linalg.det(linear_part)))
        q = (centre - eye.position) @ np.stack([eye.right, eye.up, eye.direction]).T
        height = eye.half_height * (1.0 if eye.orthographic else np.maximum(q[:, 2], 0))
        slant = 1.0 if eye.orthographic else np.hypot(1.0, eye.half_height * aspect)
        is_inside = (
            (np.abs(q[:, 1]) <= height + radius * slant)
            & (np.abs(q[:, 0]) <= height * aspect + radius * slant)
            & (q[:, 2] + radius > eye.near)
        )
        if clip is not None:
            is_inside &= clip.intersects_balls(centre, radius)
        if model.streamer is not None and not include_all_nodes:
            is_inside &= np.array([part.row in model.shown_rows for part in model.parts])
        for i in np.flatnonzero(is_inside):
            parts.append((float(q[i, 2] - radius[i]), model, model.parts[i]))
    parts.sort(key=lambda entry: entry[0])
    return [(model, part) for _, model, part in parts]


def depth_range(model: ModelScene, part: Part, eye: Eye) -> tuple[float, float]:
    """Return the scale of a model, and the nearest depth of a part's bounding sphere."""
    scale = float(np.cbrt(abs(np.linalg.det(model.to_world[:3, :3])))) or 1.0
    centre = (part.low + part.high) / 2.0 + model.origin
    centre = model.to_world[:3, :3] @ centre + model.to_world[:3, 3]
    radius = float(np.linalg.norm(part.high - part.low)) / 2.0 * scale
    return scale, max(float(eye.depth(centre[None])[0]) - radius, eye.near)


def set_point_sizes(
    model: ModelScene, part: Part, eye: Eye, camera: Camera, height: int, style: Appearance
) -> None:
    """Set the point size of a part for the view.

    It is the size in `style`, or else the smallest size that closes the gaps between points, within
    limits.
    """
    scale, depth = depth_range(model, part, eye)
    spacing = model.shown_rows.get(part.row, part.spacing)
    pixels = 1.3 * spacing * scale / camera.metres_per_pixel(height, depth)
    low, high = 2.0 * style.point_scale, 9.0 * style.point_scale
    size = round(min(max(pixels, low), high))
    if style.point_size is not None:
        size = max(1, round(style.point_size * style.point_scale))
    part.actor.GetProperty().SetPointSize(size)
    part.weight = point_weight(size)


def texels_per_pixel(
    parts: Iterable[tuple[ModelScene, Part]], eye: Eye, camera: Camera, height: int
) -> dict[int, float]:
    """Return the texels of the finest level per pixel of each texture in view, by `id`.

    The value refers to the nearest point of the textured surface.
    """
    best_density: dict[int, float] = {}
    for model, part in parts:
        if not part.has_uv or part.material not in model.gpu_textures:
            continue
        gpu_texture = model.gpu_textures[part.material]
        scale, depth = depth_range(model, part, eye)
        metres_per_pixel = camera.metres_per_pixel(height, depth)
        finest = gpu_texture.texture.levels[0]
        texels = part.density / scale * max(finest.width, finest.height) * metres_per_pixel
        best_density[id(gpu_texture)] = min(best_density.get(id(gpu_texture), np.inf), texels)
    return best_density
