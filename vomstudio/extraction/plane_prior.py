"""Preference for paths that lie in one plane through two way-points.

The contact between two way-points is in most cases nearly planar. The planes through both
way-points are a family with one parameter. The contact is visible along the intersection of its
plane with the surface, whereas parallel contacts cross the planes of the family only here and
there. The plane with the lowest costs is therefore found before the path (a Hough transform), and
leaving it costs more. This cost is limited, so that the path still follows a contact that bends.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.extraction.surface_graph import Graph

N_PLANES = 90
MIN_FACE_ANGLE_DEG = 25.0
"""Minimum angle between a plane and the face: any other plane contains too much of the surface."""
MAX_SECTIONS = 32
SECTION_ARCS = 3.0
"""Minimum length of a section between the way-points, in typical arcs."""
MIN_SECTIONS = 8
WIDTH_ARCS, WIDTH_SHARE = 1.5, 0.002
"""Half-width of the band on the surface, in typical arcs plus a share of the distance."""
FREE_WIDTHS, FULL_WIDTHS = 2.0, 4.0
"""Distances in half-widths up to which a departure costs nothing, and from which it costs most."""
MAX_PENALTY = 0.3
"""Maximum cost of a departure from the plane, in typical costs."""
MAX_COST_RATIO = 0.9
"""Maximum ratio of the cost in the best plane to the median of all planes."""


def add_plane_prior(
    graph: Graph, costs: FloatArray, start: FloatArray, goal: FloatArray, typical_cost: float
) -> FloatArray:
    """Add the cost of a departure from the best plane through two way-points.

    Parameters
    ----------
    graph : Graph
    costs : (n,) array
        Cost per metre at each node.
    start, goal : (3,) arrays
        Way-points relative to the origin of the surface.
    typical_cost : float
        Median of the costs.

    Returns
    -------
    (n,) array
        The costs with the additional cost, or the costs themselves if no plane is distinct.
    """
    from vomstudio.extraction.path_kernels import add_departure_costs, find_lowest_costs_in_planes

    distance = float(np.linalg.norm(goal - start))
    arc = graph.typical_arc
    if not arc > 0.0 or distance < MIN_SECTIONS * SECTION_ARCS * arc:
        return costs
    along = (goal - start) / distance
    across = np.cross(along, graph.axes[:, 0])
    size = float(np.linalg.norm(across))
    if size < np.sin(np.radians(MIN_FACE_ANGLE_DEG)):
        return costs
    across /= size
    outward = np.cross(along, across)
    half_width = WIDTH_ARCS * arc + WIDTH_SHARE * distance
    sections = min(MAX_SECTIONS, int(distance / (SECTION_ARCS * arc)))
    angles = np.pi * np.arange(N_PLANES) / N_PLANES
    sines, cosines = np.sin(angles), np.cos(angles)
    lowest = np.full((sections, N_PLANES), typical_cost)
    find_lowest_costs_in_planes(
        graph.places,
        costs,
        start,
        along,
        across,
        outward,
        sines,
        cosines,
        distance,
        half_width,
        typical_cost,
        lowest,
    )
    is_steep = sines >= np.sin(np.radians(MIN_FACE_ANGLE_DEG))
    means = lowest.mean(axis=0)
    best = int(np.argmin(np.where(is_steep, means, np.inf)))
    if means[best] > MAX_COST_RATIO * float(np.median(means[is_steep])):
        return costs
    normal = cosines[best] * outward - sines[best] * across
    penalised = np.empty(len(costs))
    add_departure_costs(
        graph.places,
        costs,
        start,
        normal / sines[best],
        FREE_WIDTHS * half_width,
        FULL_WIDTHS * half_width,
        MAX_PENALTY * typical_cost,
        penalised,
    )
    return penalised
