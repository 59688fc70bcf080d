"""Features of a project as vector data over an orthophoto: GeoPackage, SVG and DXF.

The coordinates are those of the GeoTIFF.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.words import tr
from vomstudio.products.ortho.interpretation import Item, project_item
from vomstudio.products.ortho.planning import OrthophotoPlan
from vomstudio.products.ortho.vector_drawing import (
    Drawing,
    create_shape,
    svg_text,
    write_dxf,
    write_gpkg,
)
from vomstudio.products.ortho.view_description import axis_labels, direction_text, end_labels

FORMATS = ("gpkg", "svg", "dxf")


def drawing_targets(image: str | Path) -> dict[str, Path]:
    """Return the paths of the drawings of NAME.tif: NAME_drawing.gpkg, .svg and .dxf."""
    path = Path(image)
    return {format_: path.with_name(f"{path.stem}_drawing.{format_}") for format_ in FORMATS}


def picture_id(metadata: Mapping[str, Any]) -> str:
    """Return the id of a picture: 16 characters of the SHA-256 of its size and geometry."""
    content = json.dumps([metadata["width"], metadata["height"], metadata["pixel_to_world"]])
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def picture_comment(picture: str) -> str:
    """Return the comment that identifies the picture in layers and drawings."""
    return f"VOM Studio picture {picture}"


def draw_features(
    items: tuple[Item, ...], plan: OrthophotoPlan, picture: ByteArray | None
) -> tuple[Drawing, int]:
    """Draw the features within a picture, and return the number of features outside it.

    In a vertical downward view, the coordinates are World x and y. Otherwise they are metres to the
    right of and above the reference point.
    """
    frame, grid = plan.frame, plan.grid
    up = 0.0 - frame.down
    low = np.array([grid.left, -grid.top - grid.height * grid.gsd])
    high = np.array([grid.left + grid.width * grid.gsd, -grid.top])
    shapes, outside_count = [], 0
    for item in items:
        projected_item = project_item(item, plan.reference, frame.right, up)
        assert projected_item is not None
        is_inside = (projected_item.points >= low) & (projected_item.points <= high)
        if is_inside.all(axis=1).any():
            shapes.append(create_shape(projected_item))
        else:
            outside_count += 1
    unit = "m" if plan.view.is_metric else tr("units")
    left_label, right_label, _ = end_labels(plan.view)
    axes = axis_labels(plan.view, unit)
    shift = np.zeros(2)
    if is_straight_down(plan):
        shift = np.asarray(plan.reference[:2])
        axes = (tr("x, East ({unit})", unit=unit), tr("y, North ({unit})", unit=unit))
    placed_shapes = tuple(replace(shape, points=shape.points + shift) for shape in shapes)
    drawing = Drawing(
        placed_shapes,
        np.stack([low, high]) + shift,
        (left_label, right_label),
        axes,
        (direction_text(plan.view),),
        picture,
        plan.view.is_metric,
    )
    return drawing, outside_count


def is_straight_down(plan: OrthophotoPlan) -> bool:
    """Return whether the view is vertically down, so that right is East and up is North."""
    return plan.frame.is_vertical and bool(plan.frame.direction[2] < 0)


def write_drawings(
    paths: Mapping[str, Path],
    drawing: Drawing,
    crs: str | None,
    picture: str,
    rotation: FloatArray | None = None,
) -> None:
    """Write the drawings of a picture.

    Parameters
    ----------
    paths : mapping of str to Path
        Files by format.
    drawing : Drawing
    crs : str or None
        CRS of the GeoTIFF.
    picture : str
        Id of the picture.
    rotation : (3, 3) array, optional
        Matrix from `raster_rotation`, for files that overlay the GeoTIFF.

    Raises
    ------
    TargetError
    """
    mark = picture_comment(picture)
    placed_drawing = drawing if rotation is None else _transform_drawing(drawing, rotation)
    write_gpkg(paths["gpkg"], placed_drawing, crs, mark)
    text = svg_text(drawing).replace("<g", f"<desc>{mark}</desc>\n<g", 1)
    paths["svg"].write_text(text, "utf-8")
    write_dxf(paths["dxf"], placed_drawing, mark)


def raster_rotation(plan: OrthophotoPlan) -> FloatArray | None:
    """Return the matrix (3, 3) from drawing to GeoTIFF coordinates; None for the identity.

    A picture that looks vertically upwards is mirrored on the map.
    """
    frame = plan.frame
    if not frame.is_vertical or is_straight_down(plan):
        return None
    rotation = np.eye(3)
    rotation[:2] = np.column_stack([frame.right[:2], -frame.down[:2], plan.reference[:2]])
    return rotation


def _transform_drawing(drawing: Drawing, rotation: FloatArray) -> Drawing:
    def transform(points: FloatArray) -> FloatArray:
        return np.asarray(points @ rotation[:2, :2].T + rotation[:2, 2])

    corners = transform(drawing.bounds)
    shapes = tuple(
        replace(
            shape,
            points=transform(shape.points),
            symbol=tuple(line @ rotation[:2, :2].T for line in shape.symbol),
        )
        for shape in drawing.shapes
    )
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    return replace(drawing, shapes=shapes, bounds=bounds)
