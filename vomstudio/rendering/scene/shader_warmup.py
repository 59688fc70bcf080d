"""Compilation of the driver's shader programs before they are needed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from vtkmodules.vtkRenderingCore import vtkTexture

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene import gpu_textures
from vomstudio.rendering.scene.actor_creation import ActorCreator
from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.model_scene import ModelScene
from vomstudio.rendering.view.camera import Camera


def warm_up(
    canvas: Canvas,
    scene_contents: Contents,
    visibility: SceneVisibility,
    actor_creator: ActorCreator,
) -> Iterator[None]:
    """Compile one shader program per step.

    Compiling all of them would delay the first frame of the first model by 0.1 s. The drawings
    made for this purpose are removed, and the warm-up ends when a model arrives.
    """
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1]], np.float32)
    corners = points.astype(np.float64)
    faces = np.array([[0, 1, 2]], np.int32)
    grey = np.full((3, 3), 128, np.uint8)
    samples = (
        (Mesh(corners, faces), vtk_data.triangles(points, faces, colors=grey), 0),
        (Mesh(corners, faces), vtk_data.triangles(points, faces, uv=points[:, ::2]), 1),
        (Mesh(corners, faces), vtk_data.triangles(points, faces, uv=points[:, ::2]), 4),
        (PointCloud(corners), vtk_data.point_set(points, grey), 0),
    )
    for holder, data, pictures in samples:
        if scene_contents.models or not canvas.is_open:
            return
        zero = np.zeros(3)
        origin, canvas.origin = canvas.origin, None
        model = ModelScene("", holder, zero, zero, zero + 1.0, np.eye(4), np.eye(4))
        part = actor_creator.part(model, data)
        scene_contents.look.style_part(model, part)
        if pictures:
            texture_image = vtk_data.image(np.full((4, 4, 3), 128, np.uint8))
            textures = [vtkTexture() for _ in range(pictures)]
            for texture in textures:
                texture.SetInputData(texture_image)
                texture.InterpolateOn()
            gpu_textures.apply_to(part.actor, textures)
            part.actor.GetProperty().LightingOff()
        visibility.apply(Camera())
        part.actor.VisibilityOn()
        canvas.render(
            clears_canvas=True, draws_surface=True, draws_layer=False, draws_emphasis=False
        )
        canvas.wait()
        actor_creator.drop(part)
        canvas.origin = origin
        canvas.frames -= 1
        yield
