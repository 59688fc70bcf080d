"""Paths that follow a contact in a photo at full resolution, projected onto the model.

Between way-points, the line is the path of least cost over the pixels of the photo; large areas are
first searched in a reduced picture. The line is projected onto the surface along lines of sight
through the lens (after Seers & Hodgetts 2016, Journal of Structural Geology 82, 1). Other photos of
the same location contribute to the cost of a pixel, and are used afterwards to confirm the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.path_costs import COLOUR_COSTS, node_costs, opponent_colours
from vomstudio.extraction.photo_votes import Voter, count_agreeing_photos
from vomstudio.extraction.pixel_graph import (
    pixel_graph,
    select_pixels_along_line,
    select_pixels_in_ellipse,
)
from vomstudio.extraction.shortest_paths import straightest_path
from vomstudio.extraction.surface_graph import Graph

_CORRIDOR_STRETCH_FACTOR = 1.4
_MARGIN_PX = 16.0
# Maximum number of pixels searched at once, and half-width of the corridor around the line that was
# found in the coarser picture, pixels.
_MAX_NODES = 120_000
_CORRIDOR_HALF_WIDTH_PX = 12.0
_MAX_VOTERS = 5
# Maximum error of the end point of a line of sight, in model resolutions.
_SIGHT_ERROR_RESOLUTIONS = 0.25
_MAX_SIGHT_ERROR_PX = 4


@dataclass(frozen=True, eq=False)
class PhotoPath:
    """Path that was followed in a photo.

    Parameters
    ----------
    pixels : (n, 2) array
        Columns and rows of the path in the photo.
    points : (n, 3) array
        Points of the model under these pixels, in the World frame, m.
    way_point_rows : (w,) int array
        Rows of the way-points in the path.
    costs : (n,) array
        Cost at each pixel, relative to the median over the searched part of the photo.
    missed_count : int
        Number of pixels of the path that miss the model.
    seen, agreeing : (n,) int arrays
        Number of other photos that show each point, and number of those that confirm it.
    voters : tuple of str
        Names of the other photos.
    warnings : tuple of Finding
    """

    pixels: FloatArray
    points: FloatArray
    way_point_rows: IntArray
    costs: FloatArray
    missed_count: int
    seen: IntArray
    agreeing: IntArray
    voters: tuple[str, ...]
    warnings: tuple[Finding, ...] = ()

    @property
    def judged_count(self) -> int:
        """Number of points that are visible in other photos."""
        return int((self.seen > 0).sum())

    @property
    def confirmed_count(self) -> int:
        """Number of points confirmed by at least half of the other photos that show them."""
        return int(((self.seen > 0) & (2 * self.agreeing >= self.seen)).sum())


def _require_cost(cost: str) -> None:
    if cost not in COLOUR_COSTS:
        raise UsageError(
            Finding("option.not-a-choice", value=cost, choices=COLOUR_COSTS),
            field="--cost",
        )


class PhotoFollower:
    """Follower of contacts in one photo of a model with one cost.

    Parameters
    ----------
    photos : CalibratedPhotos
    cost : {"colour", "dark", "light", "gradient"}
        See `Follower`.
    uses_votes : bool
        Whether to compare with other photos.

    Raises
    ------
    UsageError
        If the cost is not available for photos.
    InputError
        If the photo cannot be read.
    """

    def __init__(self, photos: CalibratedPhotos, cost: str = "colour", *, uses_votes: bool = True):
        _require_cost(cost)
        self.photos, self.cost, self._uses_votes = photos, cost, uses_votes
        self.view = photos.views.views[photos.view_row]
        self._pyramid = [photos.pixels(photos.view_row)]
        # Cache the photos of the last line, which the next line probably uses as well.
        self._cached_voters: dict[int, Voter] = {}

    def with_cost(self, cost: str) -> PhotoFollower:
        """Return a follower of the same photo with another cost; both share the pixels.

        Raises
        ------
        UsageError
            If the cost is not available for photos.
        """
        _require_cost(cost)
        follower = copy(self)
        follower.cost = cost
        return follower

    def follow(self, way_points: FloatArray, *, is_alone: bool = False) -> PhotoPath:
        """Follow a path through way-points in the photo.

        Parameters
        ----------
        way_points : (w, 2) array
            Way-points in pixels, w >= 2.
        is_alone : bool
            If True, do not compare the path with other photos, which saves time.

        Returns
        -------
        PhotoPath

        Raises
        ------
        GeometryError
            If there are fewer than two way-points, if all are in the same pixel, if one is outside
            the photo or the model, or if no path on the model connects them.
        """
        marks = np.asarray(way_points, np.float64).reshape(-1, 2)
        self._require_way_points(marks)
        voters, warnings = ([], list[Finding]()) if is_alone else self._find_voters(marks)
        paths = [self._find_leg(a, b, marks, voters) for a, b in pairwise(marks)]
        legs = [leg for leg, _ in paths]
        pixels = np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])
        costs = np.concatenate([paths[0][1], *(item[1:] for _, item in paths[1:])])
        position = np.concatenate([[0], np.cumsum([len(leg) - 1 for leg in legs])])
        if len(pixels) < 2:
            raise GeometryError(Finding("points.coincident"))
        points = self.project(pixels)
        is_on_model = np.isfinite(points[:, 0])
        if is_on_model.sum() < 2:
            raise GeometryError(Finding("path.beside-model"))
        # Rows of the way-points after removing the pixels that miss the model.
        position = np.maximum(np.cumsum(is_on_model)[position] - 1, 0)
        visible_count, agreeing_photos = count_agreeing_photos(
            self._pyramid[0], pixels[is_on_model], self.project, voters
        )
        return PhotoPath(
            pixels[is_on_model],
            points[is_on_model],
            position,
            costs[is_on_model],
            int((~is_on_model).sum()),
            visible_count,
            agreeing_photos,
            tuple(voter.name for voter in voters),
            tuple(warnings),
        )

    def project(self, pixels: FloatArray) -> FloatArray:
        """Project pixels (n, 2) onto the model along their lines of sight.

        Returns
        -------
        (n, 3) array
            In the World frame, m; NaN if a line of sight misses the model.
        """
        return self.photos.views.intersect_model(self.photos.view_row, pixels)

    def _require_way_points(self, marks: FloatArray) -> None:
        if len(marks) < 2:
            raise GeometryError(Finding("feature.too-few-points", count=2 - len(marks), minimum=2))
        is_inside = self.view.contains(marks) & np.isfinite(marks).all(axis=1)
        for row in np.flatnonzero(~is_inside).tolist():
            raise GeometryError(Finding("path.outside-photo", number=row + 1, photo=self.view.name))
        for row in np.flatnonzero(~np.isfinite(self.project(marks)[:, 0])).tolist():
            raise GeometryError(
                Finding("path.point-beside-model", number=row + 1, photo=self.view.name)
            )

    def _find_voters(self, way_points: FloatArray) -> tuple[list[Voter], list[Finding]]:
        """Return the other photos that show the line between way-points best, and warnings."""
        if not self._uses_votes:
            return [], []
        photos, warnings = self.photos, list[Finding]()
        line = np.concatenate(
            [a + (b - a) * np.linspace(0, 1, 20)[:, None] for a, b in pairwise(way_points)]
        )
        positions = self.project(line)
        positions = positions[np.isfinite(positions[:, 0])]
        voters: list[Voter] = []
        voters_by_photo = dict[int, Voter]()
        for sighting in photos.views.sightings(positions):
            if sighting.view == photos.view_row or sighting.view not in photos.files:
                continue
            try:
                voter = self._cached_voters.get(sighting.view) or Voter(
                    photos.views, sighting.view, photos.pixels(sighting.view)
                )
                voters_by_photo[sighting.view] = voter
                voters.append(voter)
            except InputError as error:
                warnings.append(to_finding(error))
            if len(voters) == _MAX_VOTERS:
                break
        self._cached_voters.clear()
        self._cached_voters.update(voters_by_photo)
        if not voters:
            warnings.append(Finding("path.no-other-photo"))
        return voters, warnings

    # --- a leg -------------------------------------------------------------------------------
    def _find_leg(
        self, start: FloatArray, goal: FloatArray, marks: FloatArray, voters: Sequence[Voter]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the pixels (k, 2) from one way-point to the next, and their costs (k,)."""
        distance = float(np.hypot(*(goal - start)))
        span = _CORRIDOR_STRETCH_FACTOR * distance + _MARGIN_PX
        area = 0.25 * np.pi * span * np.sqrt(max(span**2 - distance**2, 1.0))
        level = max(0, int(np.ceil(np.log2(max(area / _MAX_NODES, 1.0)) / 2.0)))
        line = np.zeros((0, 2))
        for current in range(level, -1, -1):
            picture, size = self._reduced_picture(current), 2.0**current
            ends = start / size, goal / size
            if current == level:
                box, mask = select_pixels_in_ellipse(*ends, span / size + _MARGIN_PX, picture.shape)
            else:
                box, mask = select_pixels_along_line(
                    np.vstack([ends[0], 2.0 * line, ends[1]]),
                    _CORRIDOR_HALF_WIDTH_PX,
                    picture.shape,
                )
            graph = pixel_graph(picture, box, mask)
            costs = node_costs(graph, self.cost, self._way_point_colours(picture, marks / size))
            if current == level:
                # At later levels, the graph only contains a narrow corridor around the line.
                typical_cost = float(np.median(costs))
            if current == 0 and voters:
                costs = self._add_votes(graph, costs, voters, marks)
            first, last = (_nearest_node(graph, end) for end in ends)
            path = straightest_path(graph, first, last, costs)
            if path is None:
                raise GeometryError(Finding("path.not-connected"))
            line = graph.places[path, :2]
        return line, costs[path] / typical_cost

    def _reduced_picture(self, level: int) -> ByteArray:
        """Return the photo reduced by a factor of 2^level."""
        import cv2

        while len(self._pyramid) <= level:
            previous = self._pyramid[-1]
            height, width = (max(size // 2, 1) for size in previous.shape[:2])
            cropped_picture = previous[: 2 * height, : 2 * width]
            self._pyramid.append(
                np.asarray(
                    cv2.resize(cropped_picture, (width, height), interpolation=cv2.INTER_AREA)
                )
            )
        return self._pyramid[level]

    def _way_point_colours(self, picture: ByteArray, pixels: FloatArray) -> FloatArray:
        """Return the opponent colours (w, 3) at pixels, averaged over nine pixels each."""
        colours = []
        for x, y in np.floor(pixels).astype(int).tolist():
            rows = slice(max(y - 1, 0), y + 2)
            window = picture[rows, max(x - 1, 0) : x + 2].reshape(-1, 3)
            if not len(window):
                window = picture[-1:, -1]
            colours.append(window.mean(axis=0))
        return opponent_colours(np.array(colours))

    def _add_votes(
        self, graph: Graph, costs: FloatArray, voters: Sequence[Voter], way_points: FloatArray
    ) -> FloatArray:
        """Average the costs (n,) in the photo with the mean costs in the other photos.

        In each other photo, the lowest cost within the error of the projection is used.
        """
        pixels = graph.places[:, :2]
        positions = self.project(pixels)
        marks = self.project(way_points)
        total, count = np.zeros(len(costs)), np.zeros(len(costs))
        assert graph.colours is not None
        error_px = self._sight_error_px(positions)
        for voter in voters:
            colours, is_visible = voter.colours(positions)
            tints, is_known = voter.colours(marks)
            if not is_visible.any() or not is_known.any():
                continue
            blended_colours = np.where(is_visible[:, None], colours, graph.colours)
            voter_costs = node_costs(
                Graph(
                    graph.places,
                    graph.starts,
                    graph.neighbours,
                    blended_colours,
                    {},
                    graph.compute_roughness,
                    graph.row,
                ),
                self.cost,
                opponent_colours(tints[is_known]),
            )
            voter_costs[~is_visible] = np.inf
            for _ in range(error_px):
                voter_costs = np.minimum(
                    voter_costs,
                    np.minimum.reduceat(voter_costs[graph.neighbours], graph.starts[:-1]),
                )
            is_finite = np.isfinite(voter_costs)
            total[is_finite] += voter_costs[is_finite]
            count[is_finite] += 1
        is_judged = count > 0
        costs = costs.copy()
        costs[is_judged] = 0.5 * (costs[is_judged] + total[is_judged] / count[is_judged])
        return costs

    def _sight_error_px(self, positions: FloatArray) -> int:
        """Estimate the error in pixels of a point that is projected into another photo."""
        views = self.photos.views
        visible_positions = positions[np.isfinite(positions[:, 0])]
        if not len(visible_positions):
            return 0
        depth = float(np.median(self.view.depths(views.to_local(visible_positions))))
        pixel = depth / float(np.sqrt(np.prod(self.view.intrinsics.focal)))
        return int(
            np.clip(
                round(_SIGHT_ERROR_RESOLUTIONS * views.resolution / pixel), 0, _MAX_SIGHT_ERROR_PX
            )
        )


def _nearest_node(graph: Graph, pixel: FloatArray) -> int:
    return int(np.argmin(((graph.places[:, :2] - pixel) ** 2).sum(axis=1)))
