"""Plane on which three-dimensional traces are analysed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.view_frame import ViewFrame

MIN_DIP_DEG = 20.0
"""Dip of the best-fit plane below which lines form a map, which shortens them by up to 6 %."""
MIN_RELIEF_RATIO = 0.2
"""Minimum height difference along three-dimensional lines, as a fraction of their length."""
MIN_STEP_RATIO = 2.0
MIN_FLATNESS = 3.0
MAX_MAP_DIP_DEG = 80.0
"""Maximum dip for projecting map positions vertically onto a plane; steeper planes are edge-on."""

MAX_STRIKE_DIP_DEG = 45.0
"""Dip below which trace angles are strikes; on steeper planes, they start at up dip."""

MIN_RELATIVE_WIDTH = 1e-6
LINE_TYPES = (1, 2, 5)


def map_azimuths_deg(directions: FloatArray) -> FloatArray:
    """Return the azimuths of lines on a map.

    Parameters
    ----------
    directions : (n, 2) ndarray

    Returns
    -------
    (n,) ndarray
        Degrees in [0, 180), clockwise from y.
    """
    x, y = directions.T
    return np.asarray(np.degrees(np.arctan2(x, y)) % 180.0)


def trace_azimuths_deg(directions: FloatArray, plane: TracePlane | None) -> FloatArray:
    """Return the angles of traces on a plane or on the map.

    Parameters
    ----------
    directions : (n, 2) ndarray
    plane : TracePlane or None
        Plane of the traces. If None, they are on a map.

    Returns
    -------
    (n,) ndarray
        Degrees in [0, 180).
    """
    return map_azimuths_deg(directions) if plane is None else plane.azimuths_deg(directions)


@dataclass(frozen=True)
class TracePlane:
    """Plane on which three-dimensional traces were analysed.

    The coordinates on the plane are x to the right and y up, viewed against the upward normal:
    `right` is horizontal and points toward the dip direction - 90, and `up` points up dip. On a
    horizontal plane, they are the x and y of the map.

    Parameters
    ----------
    dip_direction_deg, dip_deg : float
        Attitude of the plane, degrees.
    origin, right, up : tuple of float
        Origin x = y = 0, and unit vectors along x and y, in the World frame.
    scatter_m, max_distance_m : float
        RMS and maximum distance of the vertices from the plane, m.
    shortening_percent : float
        Shortening of the lines by the projection; traces on a rough face are not straight.
    azimuths_from : {"up", "north"}
        Direction from which trace angles (`strike_deg`, strike ranges, rose diagram) are
        measured clockwise. On planes that dip less than `MAX_STRIKE_DIP_DEG`, the angles are
        the strikes of the traces from north. On steeper planes, they are angles in the plane
        from up dip (the rake is this angle - 90).
    """

    dip_direction_deg: float
    dip_deg: float
    origin: tuple[float, float, float]
    right: tuple[float, float, float]
    up: tuple[float, float, float]
    scatter_m: float
    max_distance_m: float
    shortening_percent: float
    azimuths_from: Literal["up", "north"]

    @classmethod
    def from_attitude(cls, plane: Plane, lines: Sequence[FloatArray]) -> TracePlane:
        """Return the plane of a given attitude through the centroid of World lines (k, 3)."""
        points = np.concatenate(lines)
        normal = plane.normal()
        frame = ViewFrame.from_direction(0.0 - normal)
        up = 0.0 - frame.down
        centre = points.mean(axis=0)
        distance = (points - centre) @ normal
        origin = centre
        if plane.undefined:
            origin = np.array([0.0, 0.0, centre[2]])
        elif plane.vertical:
            # On a vertical plane, y is the height.
            origin = np.array([centre[0], centre[1], 0.0])
        true_length = sum(float(_lengths(line).sum()) for line in lines)
        plane_axes = np.stack([frame.right, up])
        projected_length = sum(float(_lengths(line @ plane_axes.T).sum()) for line in lines)
        return cls(
            dip_direction_deg=plane.dip_direction_deg,
            dip_deg=plane.dip_deg,
            origin=_to_triple(origin),
            right=_to_triple(frame.right),
            up=_to_triple(up),
            scatter_m=float(np.sqrt(np.mean(distance**2))),
            max_distance_m=float(np.abs(distance).max()),
            # Rounding must not make the value negative.
            shortening_percent=max(100.0 * (1.0 - projected_length / true_length), 0.0)
            if true_length > 0
            else 0.0,
            azimuths_from="north" if plane.dip_deg < MAX_STRIKE_DIP_DEG else "up",
        )

    @property
    def is_horizontal(self) -> bool:
        return Plane(self.dip_direction_deg, self.dip_deg).undefined

    def azimuths_deg(self, directions: FloatArray) -> FloatArray:
        """Return the angles (n,) of lines in [0, 180), clockwise from `azimuths_from`.

        `directions` (n, 2) are components along x and y on the plane.
        """
        if self.azimuths_from == "north" and not self.is_horizontal:
            directions = directions @ np.stack([self.right, self.up])[:, :2]
        return map_azimuths_deg(directions)

    @property
    def name(self) -> str:
        """Attitude of the plane as text, dip direction/dip."""
        return format_plane(Plane(self.dip_direction_deg, self.dip_deg))

    @property
    def normal(self) -> FloatArray:
        """Upward unit normal (3,)."""
        return Plane(self.dip_direction_deg, self.dip_deg).normal()

    def finding(self, lines: int) -> Finding:
        """Return the finding that reports the plane and the number of its lines."""
        return Finding(
            "lines.not-planar",
            plane=self.name,
            dip_direction_deg=self.dip_direction_deg,
            dip_deg=self.dip_deg,
            lines=lines,
            scatter_m=self.scatter_m,
            max_distance_m=self.max_distance_m,
            shortening_percent=self.shortening_percent,
        )

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Return x and y (n, 2) on the plane for points (n, 3) in the World frame."""
        # Do not use matrix products: equal points must have bitwise equal coordinates, so that
        # joined and duplicate lines are recognised.
        x, y, z = (points - np.array(self.origin)).T
        return np.column_stack([x * a + y * b + z * c for a, b, c in (self.right, self.up)])

    def project(self, shapes: ObjectArray) -> ObjectArray:
        """Project shapes (n,) with heights from the World frame to x and y on the plane."""
        import shapely

        if self.is_horizontal:
            return _drop_heights(shapes)

        def project_onto(points: FloatArray) -> FloatArray:
            return np.column_stack([self.coordinates(points), np.zeros(len(points))])

        return _drop_heights(shapely.transform(shapes, project_onto, include_z=True))

    def project_window(
        self, shapes: ObjectArray, option: Literal["area", "scanline"], heights: tuple[float, float]
    ) -> ObjectArray:
        """Project areas or scanlines (n,) from the World frame onto the plane.

        Shapes with heights are projected perpendicular to the plane. Shapes without heights, level
        areas, and level lines outside the height range of the traces (GIS programs write 0) are
        treated as positions on the map and projected vertically, if the plane dips at most 80
        degrees.

        Parameters
        ----------
        shapes : (n,) ndarray of object
            Shapely geometries.
        option : {"area", "scanline"}
            Option that provided the shapes.
        heights : tuple of float
            Minimum and maximum Z of the traces, m.

        Returns
        -------
        (n,) ndarray of object
            Shapely geometries in coordinates on the plane.

        Raises
        ------
        GeometryError
            ``lines.edge-on`` if a shape is nearly perpendicular to the plane, or if the plane is
            too steep for a position on the map.
        """
        import shapely

        if self.is_horizontal:
            return _drop_heights(shapes)
        moved_shapes = shapes.copy()
        for i, shape in enumerate(shapes):
            if shape is None or shape.is_empty:
                continue
            z = shapely.get_coordinates(shape, include_z=True)[:, 2]
            is_level = bool(np.ptp(z) == 0) if np.isfinite(z).all() else None
            is_within_heights = is_level is not None and heights[0] <= z[0] <= heights[1]
            if is_level is None or (is_level and (option == "area" or not is_within_heights)):
                moved_shapes[i] = self._move_onto_plane(shape, option)
            else:
                projected_shape = shapely.force_3d(self.project(shapes[i : i + 1])[0])
                min_extent = math.cos(math.radians(MAX_MAP_DIP_DEG)) * _extent(shape, option)
                if _extent(projected_shape, option) < min_extent:
                    raise self._edge_on_error(option)
        return self.project(moved_shapes)

    def project_circle(self, circle: Sequence[float]) -> tuple[float, float, float]:
        """Project a circle from the World frame onto the plane.

        Parameters
        ----------
        circle : sequence of float
            (X, Y, R), in which case the centre is projected vertically, or (X, Y, Z, R).

        Returns
        -------
        tuple of float
            (x, y, radius) on the plane.

        Raises
        ------
        GeometryError
            See `project_window`.
        """
        *centre, radius = circle
        if self.is_horizontal:
            return centre[0], centre[1], radius
        if len(centre) == 2:
            centre.append(float(self._heights(np.array([centre]), "circle")[0]))
        x, y = self.coordinates(np.array([centre]))[0].tolist()
        return x, y, radius

    def _move_onto_plane(self, shape: Any, option: str) -> Any:
        """Move a shape of the map vertically onto the plane."""
        import shapely

        horizontal_shape = shapely.force_3d(shapely.force_2d(shape))
        return shapely.transform(
            horizontal_shape,
            lambda p: np.column_stack([p[:, :2], self._heights(p[:, :2], option)]),
            include_z=True,
        )

    def _heights(self, xy: FloatArray, option: str) -> FloatArray:
        if self.dip_deg > MAX_MAP_DIP_DEG:
            raise self._edge_on_error(option)
        (a, b, c), (x, y, z) = self.normal, self.origin
        return np.asarray(z - (a * (xy[:, 0] - x) + b * (xy[:, 1] - y)) / c)

    def _edge_on_error(self, option: str) -> GeometryError:
        finding = Finding("lines.edge-on", option=option, plane=self.name)
        return GeometryError(finding, field=f"--{option}")


def best_fit_plane(points: FloatArray) -> Plane:
    """Fit a plane to points (n, 3) in the World frame by least squares of the distances.

    Raises
    ------
    GeometryError
        ``lines.no-plane`` if the points lie on one line.
    """
    sizes, axes = _axes(points)
    if _is_straight(sizes):
        raise _no_plane_error()
    return Plane.from_normal(axes[2])


def find_trace_plane(lines: Sequence[FloatArray]) -> TracePlane | None:
    """Find the plane of three-dimensional traces.

    Traces are three-dimensional if either of two criteria is met:

    - They climb: the largest height difference from the first vertex of a line, summed over all
      lines, is at least 0.2 times the largest distance from it. This ratio is 0.22 for isotropic
      traces on a plane that dips 20 degrees, and 0.64 on a vertical plane; it is smaller on a rough
      pavement, however dense or noisy its vertices are.
    - They lie above each other, like bedding on a cliff: there are three or more lines whose mean
      heights scatter at least twice as much as the heights along each line, on a well-defined plane
      (its width is at least 3 times its scatter) that dips at least 20 degrees.

    For traces that climb on a plane that dips less than 20 degrees (several walls, or a very rough
    surface), no plane is better than the map, so a horizontal plane is used.

    Parameters
    ----------
    lines : sequence of (k, 3) arrays
        Vertices of the lines in the World frame, m.

    Returns
    -------
    TracePlane or None
        Best-fit plane of all vertices; None if the lines form a map.

    Raises
    ------
    GeometryError
        ``lines.no-plane`` if the traces are three-dimensional but lie on one line.
    """
    if not lines:
        return None
    points = np.concatenate(lines)
    counts = np.array([len(line) for line in lines])
    first_rows = np.cumsum(counts) - counts
    offsets = points - np.repeat(points[first_rows], counts, axis=0)
    height_ranges = np.maximum.reduceat(np.abs(offsets[:, 2]), first_rows)
    lengths = np.maximum.reduceat(np.linalg.norm(offsets, axis=1), first_rows)
    has_relief = bool(height_ranges.sum() >= MIN_RELIEF_RATIO * lengths.sum() > 0)
    if not has_relief and (len(lines) < 3 or not _are_stacked(points[:, 2], counts, first_rows)):
        return None
    sizes, axes = _axes(points)
    if has_relief and _is_straight(sizes):
        raise _no_plane_error()
    plane = Plane.from_normal(axes[2])
    if plane.dip_deg < MIN_DIP_DEG:
        return TracePlane.from_attitude(Plane(0.0, 0.0), lines) if has_relief else None
    if not has_relief and (_is_straight(sizes) or sizes[1] < MIN_FLATNESS * sizes[2]):
        return None
    return TracePlane.from_attitude(plane, lines)


def vertices_with_heights(shapes: ObjectArray) -> tuple[list[FloatArray], BoolArray]:
    """Return the vertices of lines with heights, and a mask of lines without heights.

    Parameters
    ----------
    shapes : (n,) array of shapely geometries

    Returns
    -------
    vertices : list of (k, 3) arrays
        One array for each part of an open line; closed lines are included only if all lines are
        closed.
    has_missing_heights : (n,) array of bool
    """
    import shapely

    line_rows = np.flatnonzero(np.isin(shapely.get_type_id(shapes), LINE_TYPES))
    points, row = shapely.get_coordinates(shapes[line_rows], include_z=True, return_index=True)
    is_finite = np.isfinite(points)
    is_usable = is_finite[:, :2].all(axis=1)
    has_missing_heights = np.zeros(len(shapes), np.bool_)
    has_missing_heights[line_rows[row[is_usable & ~is_finite[:, 2]]]] = True
    if not is_finite[:, 2].any():
        return [], has_missing_heights
    parts, part_rows = shapely.get_parts(shapes[line_rows], return_index=True)
    points, part = shapely.get_coordinates(parts, include_z=True, return_index=True)
    is_invalid = _mask_from_rows(part, ~np.isfinite(points).all(axis=1), len(parts))
    lines = np.split(points, np.flatnonzero(np.diff(part)) + 1) if len(points) else []
    line_ids = np.unique(part)
    usable_lines = [
        line
        for line, number in zip(lines, line_ids, strict=True)
        if not is_invalid[number] and not has_missing_heights[line_rows[part_rows[number]]]
    ]
    is_open = [bool((line[0] != line[-1]).any()) for line in usable_lines]
    if any(is_open):
        usable_lines = [
            line for line, is_used in zip(usable_lines, is_open, strict=True) if is_used
        ]
    return usable_lines, has_missing_heights


def _mask_from_rows(row: IntArray, flags: BoolArray, count: int) -> BoolArray:
    has_flag = np.zeros(count, np.bool_)
    has_flag[row[flags]] = True
    return has_flag


def _are_stacked(heights: FloatArray, counts: IntArray, first_rows: IntArray) -> bool:
    """Return whether heights (n,) vary at least twice as much between lines as along them.

    `counts` (m,) are the numbers of vertices of the lines, `first_rows` (m,) the rows of their
    first vertices.
    """
    means = np.add.reduceat(heights, first_rows) / counts
    residuals = heights - np.repeat(means, counts)
    spread_within = float(np.sqrt(np.mean(np.add.reduceat(residuals**2, first_rows) / counts)))
    spread_between = float(np.std(means))
    return spread_between > 0 and spread_between >= MIN_STEP_RATIO * spread_within


def _axes(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the singular values and axes (as rows) of centred points (n, 3), largest first."""
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return sizes, axes


def _is_straight(sizes: FloatArray) -> bool:
    return len(sizes) < 3 or not sizes[1] > MIN_RELATIVE_WIDTH * sizes[0]


def _no_plane_error() -> GeometryError:
    return GeometryError(Finding("lines.no-plane"), field="--plane")


def _extent(shape: Any, option: str) -> float:
    """Return the area within the rings of a shape with heights, or the length of its lines."""
    import shapely

    extent = 0.0
    for part in shapely.get_parts(shape):
        ring = part.exterior if part.geom_type == "Polygon" else part
        points = shapely.get_coordinates(ring, include_z=True)
        if option == "area":
            centred_points = points - points.mean(axis=0)
            extent += (
                float(np.linalg.norm(np.cross(centred_points[:-1], centred_points[1:]).sum(axis=0)))
                / 2
            )
        else:
            extent += float(_lengths(points).sum())
    return extent


def _drop_heights(shapes: Any) -> ObjectArray:
    import shapely

    return np.asarray(shapely.force_2d(shapes), np.object_)


def _lengths(points: FloatArray) -> FloatArray:
    """Return the lengths (n - 1,) of the segments between points (n, 2 or 3)."""
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))


def _to_triple(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(v) + 0.0 for v in vector)
    return x, y, z
