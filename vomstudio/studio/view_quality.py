"""Viewing directions onto an outcrop with their errors, and the depth of the scene.

A view along the intersection of two planes shows both planes edge-on. A view along the line
in a fault plane that is perpendicular to the slip shows the whole displacement (textbook
4.2).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.geology.intersections import intersection_line
from vomstudio.geology.orientation import Line
from vomstudio.geometry import transform
from vomstudio.project.measurement import Measurement, plane_with_error
from vomstudio.project.records import Model, Record
from vomstudio.studio.model_loading import OpenModel


@dataclass(frozen=True)
class AxialDirection:
    """Viewing direction as an axial line, which defines two opposite views.

    `error95_deg` is the larger half-angle of its joint 95 % region, or None if unknown.
    """

    line: Line
    error95_deg: float | None


def direction_across_slip(fault_measurement: Measurement) -> AxialDirection | Finding:
    """Return the line in a fault perpendicular to its slip, or why it is undefined.

    The error of the direction is that of the slip line, or of the plane if the slip line has no
    error estimate.
    """
    if fault_measurement.on_plane is None or fault_measurement.line is None:
        return Finding("selection.no-slip")
    normal = fault_measurement.on_plane.normal()
    cross_axis = np.cross(normal, fault_measurement.line.vector())
    size = float(np.linalg.norm(cross_axis))
    if size < np.sin(np.radians(1.0)):
        return Finding("slip.across-plane")
    return AxialDirection(Line.from_vector(cross_axis / size), fault_measurement.total95_deg)


def intersection_direction(planes: Iterable[Measurement]) -> AxialDirection | Finding:
    """Return the intersection of two planes, or why it is undefined."""
    uncertain_planes = [
        uncertain_plane
        for plane in planes
        if (uncertain_plane := plane_with_error(plane)) is not None
    ]
    if len(uncertain_planes) != 2:
        return Finding("selection.not-two-planes")
    try:
        axis_line = intersection_line(*uncertain_planes)
    except GeometryError as error:
        return to_finding(error)
    return AxialDirection(axis_line.line, axis_line.max_confidence95_deg)


def scene_depth(
    direction: npt.ArrayLike, models: Mapping[str, OpenModel], records: Mapping[str, Record]
) -> tuple[float, bool]:
    """Compute the depth of the bounding boxes of all open models along a direction.

    Parameters
    ----------
    direction : (3,) float64
        Unit vector in the World frame.
    models : mapping
    records : mapping

    Returns
    -------
    float
        Depth along the direction, or 0 if no model is open.
    bool
        Whether the depth is in metres.
    """
    depth_steps, is_metric = [], True
    for model_id, open_model in models.items():
        model = records.get(model_id)
        if not isinstance(model, Model):
            continue
        low, high = np.asarray(open_model.data.bounds, np.float64)
        grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        corners = transform.apply(model.to_world, np.where(grid == 1, high, low))
        depth_steps.append(corners @ np.asarray(direction, np.float64))
        is_metric = is_metric and model.frame.has_metres
    return (float(np.ptp(np.concatenate(depth_steps))) if depth_steps else 0.0), is_metric
