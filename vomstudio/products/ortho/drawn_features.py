"""A project's features as vector data over an orthophoto: GeoPackage, SVG and DXF, in the
coordinates in which the GeoTIFF lies in a GIS."""

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
from vomstudio.products.ortho.interpretation import Item, flattened
from vomstudio.products.ortho.planning import Plan
from vomstudio.products.ortho.vector_drawing import (
    Drawing,
    shape_of,
    svg_text,
    write_dxf,
    write_gpkg,
)
from vomstudio.products.ortho.view_description import direction_text, end_labels

FORMATS = ("gpkg", "svg", "dxf")
SURFACE = "outcrop"


def drawing_targets(image: str | Path) -> dict[str, Path]:
    """NAME_drawing.gpkg, .svg and .dxf beside NAME.tif."""
    path = Path(image)
    return {form: path.with_name(f"{path.stem}_drawing.{form}") for form in FORMATS}


def picture_id(facts: Mapping[str, Any]) -> str:
    """By which a drawing is known to belong to a picture: 16 letters of the sha256 of its size and
    of what its pixels mean."""
    said = json.dumps([facts["width"], facts["height"], facts["pixel_to_world"]])
    return hashlib.sha256(said.encode()).hexdigest()[:16]


def mark_of(picture: str) -> str:
    """What layers and drawings say of their picture."""
    return f"VOM Studio picture {picture}"


def draw_features(
    items: tuple[Item, ...], plan: Plan, picture: ByteArray | None
) -> tuple[Drawing, int]:
    """The features that lie within the picture, and how many lie beside it. Coordinates are World's
    x and y on a picture straight down, else metres right and up of the reference point."""
    frame, grid = plan.frame, plan.grid
    up = 0.0 - frame.down
    low = np.array([grid.left, -grid.top - grid.height * grid.gsd])
    high = np.array([grid.left + grid.width * grid.gsd, -grid.top])
    shapes, beside = [], 0
    for item in items:
        flat = flattened(item, plan.reference, frame.right, up)
        assert flat is not None
        inside = (flat.points >= low) & (flat.points <= high)
        if inside.all(axis=1).any():
            shapes.append(shape_of(flat))
        else:
            beside += 1
    unit = "m" if plan.view.metric else tr("units")
    axes = (tr("right ({unit})", unit=unit), tr("up ({unit})", unit=unit))
    shift = np.zeros(2)
    if is_straight_down(plan):
        shift = np.asarray(plan.reference[:2])
        axes = (tr("x, East ({unit})", unit=unit), tr("y, North ({unit})", unit=unit))
    moved = tuple(replace(shape, points=shape.points + shift) for shape in shapes)
    left, right, _ = end_labels(plan.view)
    drawing = Drawing(
        moved,
        np.stack([low, high]) + shift,
        (left, right),
        axes,
        (direction_text(plan.view),),
        picture,
        plan.view.metric,
    )
    return drawing, beside


def is_straight_down(plan: Plan) -> bool:
    """Only there are the picture's right and up East and North."""
    return plan.frame.is_vertical and bool(plan.frame.direction[2] < 0)


def write_drawings(
    parts: Mapping[str, Path],
    drawing: Drawing,
    crs: str | None,
    picture: str,
    turn: FloatArray | None = None,
) -> None:
    """parts : where each format is written; crs : of the GeoTIFF; turn : as of `raster_turn`, for
    files that lie over it. Raises TargetError."""
    mark = mark_of(picture)
    placed = drawing if turn is None else _in_raster(drawing, turn)
    write_gpkg(parts["gpkg"], placed, crs, mark)
    text = svg_text(drawing).replace("<g", f"<desc>{mark}</desc>\n<g", 1)
    parts["svg"].write_text(text, "utf-8")
    write_dxf(parts["dxf"], placed, mark)


def raster_turn(plan: Plan) -> FloatArray | None:
    """(3, 3) from the coordinates of `draw_features` to those of the GeoTIFF, None where they are
    the same: a picture straight up lies on the map turned over."""
    frame = plan.frame
    if not frame.is_vertical or is_straight_down(plan):
        return None
    turn = np.eye(3)
    turn[:2] = np.column_stack([frame.right[:2], -frame.down[:2], plan.reference[:2]])
    return turn


def _in_raster(drawing: Drawing, turn: FloatArray) -> Drawing:
    def moved(points: FloatArray) -> FloatArray:
        return np.asarray(points @ turn[:2, :2].T + turn[:2, 2])

    corners = moved(drawing.bounds)
    shapes = tuple(
        replace(
            shape,
            points=moved(shape.points),
            symbol=tuple(line @ turn[:2, :2].T for line in shape.symbol),
        )
        for shape in drawing.shapes
    )
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    return replace(drawing, shapes=shapes, bounds=bounds)
