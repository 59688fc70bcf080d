"""Projection of lines onto a bent section, each part onto the piece that it faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.products.ortho.interpretation import Item, ProjectedItem, project_item
from vomstudio.products.section.section_lines import Panel

STEP_COUNT = 256
"""Number of steps into which a line is divided to find where it changes pieces."""
_MAX_STRETCH = 2.0
"""Ratio of the length of a step on the section to that in space above which a line is broken."""


def project_along_bends(
    item: Item, panels: Sequence[Panel], direction: FloatArray | None
) -> tuple[ProjectedItem, ...]:
    """Project a line or outline onto the pieces of a bent section.

    Parts that face two pieces are projected onto the nearer one, so that the line is broken on the
    inner side of a bend. Parts in the outer wedge of a bend face no piece and are omitted. A part
    of an outline becomes a line.

    Parameters
    ----------
    item : Item
        Line or outline with more than one point.
    panels : sequence of Panel
    direction : (3,) array or None
        Direction of projection; None projects perpendicular to the section.

    Returns
    -------
    tuple of ProjectedItem
    """
    points, is_vertex = _subdivide(item.points)
    best_distances = np.full(len(points), np.inf)
    panel_rows = np.full(len(points), -1)
    unfolded_points = np.zeros((len(points), 2))
    distances = np.zeros(len(points))
    for k, panel in enumerate(panels):
        projected_feature = project_item(
            replace(item, points=points), panel.origin, panel.right, panel.up, direction
        )
        if projected_feature is None:
            continue
        x = projected_feature.points[:, 0]
        is_nearer = (
            (x >= panel.low)
            & (x <= panel.high)
            & (np.abs(projected_feature.distance) < best_distances)
        )
        best_distances[is_nearer], panel_rows[is_nearer] = (
            np.abs(projected_feature.distance[is_nearer]),
            k,
        )
        distances[is_nearer] = projected_feature.distance[is_nearer]
        unfolded_points[is_nearer] = projected_feature.points[is_nearer] + [
            panel.start,
            panel.level,
        ]
    inner_rows = np.flatnonzero(panel_rows >= 0)
    if len(inner_rows) == len(points) and (panel_rows == panel_rows[0]).all():
        return (ProjectedItem(item, unfolded_points[is_vertex], distances[is_vertex], None),)
    steps = np.linalg.norm(np.diff(points[inner_rows], axis=0), axis=1)
    step_lengths = np.linalg.norm(np.diff(unfolded_points[inner_rows], axis=0), axis=1)
    break_rows = np.flatnonzero(step_lengths > _MAX_STRETCH * steps + 1e-12) + 1
    piece = replace(item, form="line", is_filled=False) if item.form == "ring" else item
    parts = []
    for run in np.split(inner_rows, break_rows):
        if len(run) < 2:
            continue
        # Keep vertices, both ends, and the points at which the line changes pieces.
        is_retained = is_vertex[run]
        is_retained[[0, -1]] = True
        panel_changes = np.flatnonzero(np.diff(panel_rows[run]))
        is_retained[panel_changes] = is_retained[panel_changes + 1] = True
        rows = run[is_retained]
        parts.append(ProjectedItem(piece, unfolded_points[rows], distances[rows], None))
    return tuple(parts)


def _subdivide(points: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Insert points between vertices; also return which points are vertices."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step = max(float(lengths.sum()) / STEP_COUNT, 1e-12)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(int)
    parts, is_vertex = [], []
    for start, end, count in zip(points[:-1], points[1:], counts.tolist(), strict=True):
        parts.append(start + (end - start) * np.arange(count)[:, None] / count)
        is_vertex.append(np.arange(count) == 0)
    return np.concatenate([*parts, points[-1:]]), np.concatenate([*is_vertex, [True]])
