"""What is drawn for the models while drawing them takes too long."""

from __future__ import annotations

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.scene.model_scene import ModelScene, Part

MOVING_SETS = 6
POINTS_PER_SET = 50_000
MESH_ELEMENTS = 150_000
"""Of meshes that nothing else stands for."""

Entry = tuple[ModelScene, Part]


def of_meshes(visible: list[ModelScene]) -> list[Part]:
    """The faces of meshes without a proxy, as far as they are on the graphics card."""
    show = []
    budget = MESH_ELEMENTS
    for model in visible:
        if not isinstance(model.data, Mesh) or model.proxies:
            continue
        for part in model.parts:
            if part.uploaded and budget > 0:
                show.append(part)
                budget -= part.elements
    return show


def coarse_nodes(seen: list[Entry], sets: int) -> tuple[list[Entry], bool]:
    """The coarse nodes of clouds, as many as there is time for, and whether the next picture will
    show more of them.

    seen : every part in view; sets : of POINTS_PER_SET points that a moving picture can afford
    """
    nodes = [entry for entry in seen if isinstance(entry[0].data, PointCloud)]
    nodes.sort(key=lambda entry: -entry[1].spacing)
    left = sets * POINTS_PER_SET
    show: list[Entry] = []
    fresh = 0
    for model, part in nodes:
        left -= part.elements
        if show and left < 0:
            break
        if not part.uploaded:
            # A few at a time: the first drawing takes it to the graphics card.
            fresh += part.elements
            if show and fresh > POINTS_PER_SET:
                return show, True
        show.append((model, part))
    return show, False
