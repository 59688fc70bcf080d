"""Proxies that are drawn when drawing the complete models would take too long."""

from __future__ import annotations

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.scene.model_scene import ModelScene, Part

MAX_MOVING_SETS = 6
POINTS_PER_SET = 50_000
MAX_MESH_ELEMENTS = 150_000
"""Maximum number of mesh faces that are drawn if a mesh has no proxy."""

Entry = tuple[ModelScene, Part]


def mesh_proxies(visible: list[ModelScene]) -> list[Part]:
    """Return uploaded chunks of meshes that have no proxy, up to a maximum number of faces."""
    shown_parts = []
    budget = MAX_MESH_ELEMENTS
    for model in visible:
        if not isinstance(model.data, Mesh) or model.proxies:
            continue
        for part in model.parts:
            if part.is_uploaded and budget > 0:
                shown_parts.append(part)
                budget -= part.elements
    return shown_parts


def coarse_nodes(entries: list[Entry], sets: int) -> tuple[list[Entry], bool]:
    """Return the coarse cloud nodes that can be drawn in time, and whether more will follow.

    Parameters
    ----------
    entries : list of Entry
        All parts in view.
    sets : int
        Number of sets of POINTS_PER_SET points that can be drawn in a moving picture.
    """
    nodes = [entry for entry in entries if isinstance(entry[0].data, PointCloud)]
    nodes.sort(key=lambda entry: -entry[1].spacing)
    remaining_points = sets * POINTS_PER_SET
    shown_parts: list[Entry] = []
    new_point_count = 0
    for model, part in nodes:
        remaining_points -= part.elements
        if shown_parts and remaining_points < 0:
            break
        if not part.is_uploaded:
            # Only a few at a time, because the first drawing uploads them.
            new_point_count += part.elements
            if shown_parts and new_point_count > POINTS_PER_SET:
                return shown_parts, True
        shown_parts.append((model, part))
    return shown_parts, False
