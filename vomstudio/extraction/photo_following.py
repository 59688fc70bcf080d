"""A line that follows a contact in a photo at its full resolution, thrown on the model.

Between way-points it is the path of least cost over the photo's pixels, found in a smaller picture
first where they are many. Lines of sight through the lens bring it to the surface (after Seers &
Hodgetts 2016, Journal of Structural Geology 82, 1). Other photos that see the place have a say in
what a pixel costs, and are asked afterwards whether they show the same there.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, IntArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding, finding_of
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.path_costs import OF_COLOURS, compared, node_costs
from vomstudio.extraction.photo_votes import Voter, agreement
from vomstudio.extraction.pixel_graph import along, around, pixel_graph
from vomstudio.extraction.shortest_paths import straightest
from vomstudio.extraction.surface_graph import Graph

_STRETCH = 1.4
_MARGIN = 16.0
# Pixels: so many are searched at once, and so far beside the line of the smaller picture.
_MOST_NODES = 120_000
_BESIDE = 12.0
_VOTERS = 5
# Of the model's resolution: so far may a line of sight's end be off, and what another photo shows
# there with it.
_OFF = 0.25
_MOST_PIXELS_OFF = 4


@dataclass(frozen=True, eq=False)
class PhotoPath:
    """pixels (n, 2) of the photo, points (n, 3) of the model under them, World; at (w,) the rows of
    the way-points; costs (n,) of a metre at each, in medians of the photo around
    missed : pixels of the line beside the model
    seen, agreeing (n,) : how many other photos could judge a point, and how many show the same
    voters : their names
    """

    pixels: FloatArray
    points: FloatArray
    at: IntArray
    costs: FloatArray
    missed: int
    seen: IntArray
    agreeing: IntArray
    voters: tuple[str, ...]
    warnings: tuple[Finding, ...] = ()

    @property
    def judged(self) -> int:
        """How many points others could judge."""
        return int((self.seen > 0).sum())

    @property
    def confirmed(self) -> int:
        """Of these, how many at least half of the others confirm."""
        return int(((self.seen > 0) & (2 * self.agreeing >= self.seen)).sum())


def _require_cost(cost: str) -> None:
    if cost not in OF_COLOURS:
        raise UsageError(
            Finding("option.not-a-choice", value=cost, choices=OF_COLOURS),
            field="--cost",
        )


class PhotoFollower:
    """Follows contacts in one photo of a model, with one cost.

    cost : "colour", "dark", "light" or "gradient", as in `Follower`
    Raises UsageError for a cost that photos do not have, InputError for a photo that can't be read.
    """

    def __init__(self, photos: CalibratedPhotos, cost: str = "colour", *, voting: bool = True):
        _require_cost(cost)
        self.photos, self.cost, self._voting = photos, cost, voting
        self.view = photos.views.views[photos.chosen]
        self._pyramid = [photos.pixels(photos.chosen)]
        # Photos of the last line, which the next one will probably use too.
        self._kept: dict[int, Voter] = {}

    def by(self, cost: str) -> PhotoFollower:
        """The same photo followed with another cost; its pixels are shared. Raises UsageError."""
        _require_cost(cost)
        other = copy(self)
        other.cost = cost
        return other

    def follow(self, way_points: FloatArray, *, alone: bool = False) -> PhotoPath:
        """Follow a path through way-points in the photo.

        Parameters
        ----------
        way_points : (w, 2) array
            Pixels, w >= 2.
        alone : bool
            Do not compare the path with other photos, which takes longer.

        Raises
        ------
        GeometryError
            If all way-points are in one pixel, or one is outside the photo or the model.
        """
        marks = np.asarray(way_points, np.float64).reshape(-1, 2)
        self._require(marks)
        voters, warnings = ([], list[Finding]()) if alone else self._voters(marks)
        stretches = [self._leg(a, b, marks, voters) for a, b in pairwise(marks)]
        legs = [leg for leg, _ in stretches]
        pixels = np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])
        costs = np.concatenate([stretches[0][1], *(each[1:] for _, each in stretches[1:])])
        at = np.concatenate([[0], np.cumsum([len(leg) - 1 for leg in legs])])
        if len(pixels) < 2:
            raise GeometryError(Finding("points.coincident"))
        points = self.thrown(pixels)
        there = np.isfinite(points[:, 0])
        if there.sum() < 2:
            raise GeometryError(Finding("path.beside-model"))
        # Where the way-points are once what misses the model is left out.
        at = np.maximum(np.cumsum(there)[at] - 1, 0)
        seen, agreeing = agreement(self._pyramid[0], pixels[there], self.thrown, voters)
        return PhotoPath(
            pixels[there],
            points[there],
            at,
            costs[there],
            int((~there).sum()),
            seen,
            agreeing,
            tuple(voter.name for voter in voters),
            tuple(warnings),
        )

    def thrown(self, pixels: FloatArray) -> FloatArray:
        """(n, 3) where the lines of sight through pixels (n, 2) end, World; NaN where nowhere."""
        return self.photos.views.places_under(self.photos.chosen, pixels)

    def _require(self, given: FloatArray) -> None:
        if len(given) < 2:
            raise GeometryError(Finding("feature.too-few-points", count=2 - len(given), minimum=2))
        inside = self.view.contains(given) & np.isfinite(given).all(axis=1)
        for row in np.flatnonzero(~inside).tolist():
            raise GeometryError(Finding("path.outside-photo", number=row + 1, photo=self.view.name))
        for row in np.flatnonzero(~np.isfinite(self.thrown(given)[:, 0])).tolist():
            raise GeometryError(
                Finding("path.point-beside-model", number=row + 1, photo=self.view.name)
            )

    def _voters(self, way_points: FloatArray) -> tuple[list[Voter], list[Finding]]:
        """Return the other photos that show the way-points best, and warnings."""
        if not self._voting:
            return [], []
        photos, warnings = self.photos, list[Finding]()
        line = np.concatenate(
            [a + (b - a) * np.linspace(0, 1, 20)[:, None] for a, b in pairwise(way_points)]
        )
        places = self.thrown(line)
        places = places[np.isfinite(places[:, 0])]
        voters: list[Voter] = []
        used = dict[int, Voter]()
        for seen in photos.views.sightings(places):
            if seen.view == photos.chosen or seen.view not in photos.files:
                continue
            try:
                voter = self._kept.get(seen.view) or Voter(
                    photos.views, seen.view, photos.pixels(seen.view)
                )
                used[seen.view] = voter
                voters.append(voter)
            except InputError as error:
                warnings.append(finding_of(error))
            if len(voters) == _VOTERS:
                break
        self._kept.clear()
        self._kept.update(used)
        if not voters:
            warnings.append(Finding("path.no-other-photo"))
        return voters, warnings

    # --- a leg -------------------------------------------------------------------------------
    def _leg(
        self, one: FloatArray, other: FloatArray, given: FloatArray, voters: Sequence[Voter]
    ) -> tuple[FloatArray, FloatArray]:
        """(k, 2) middles of the pixels from one to the other, and (k,) their costs."""
        apart = float(np.hypot(*(other - one)))
        reach = _STRETCH * apart + _MARGIN
        area = 0.25 * np.pi * reach * np.sqrt(max(reach**2 - apart**2, 1.0))
        level = max(0, int(np.ceil(np.log2(max(area / _MOST_NODES, 1.0)) / 2.0)))
        line = np.zeros((0, 2))
        for down in range(level, -1, -1):
            picture, size = self._smaller(down), 2.0**down
            ends = one / size, other / size
            if down == level:
                box, mask = around(*ends, reach / size + _MARGIN, picture.shape)
            else:
                box, mask = along(np.vstack([ends[0], 2.0 * line, ends[1]]), _BESIDE, picture.shape)
            graph = pixel_graph(picture, box, mask)
            costs = node_costs(graph, self.cost, self._tints(picture, given / size))
            if down == level:
                # Later graphs are narrow, around the line alone.
                usual = float(np.median(costs))
            if down == 0 and voters:
                costs = self._voted(graph, costs, voters, given)
            first, last = (_nearest(graph, end) for end in ends)
            path = straightest(graph, first, last, costs)
            if path is None:
                raise GeometryError(Finding("path.not-connected"))
            line = graph.places[path, :2]
        return line, costs[path] / usual

    def _smaller(self, level: int) -> ByteArray:
        """The photo with a pixel for 2^level x 2^level of its own."""
        import cv2

        while len(self._pyramid) <= level:
            last = self._pyramid[-1]
            height, width = (max(size // 2, 1) for size in last.shape[:2])
            half = last[: 2 * height, : 2 * width]
            self._pyramid.append(
                np.asarray(cv2.resize(half, (width, height), interpolation=cv2.INTER_AREA))
            )
        return self._pyramid[level]

    def _tints(self, picture: ByteArray, pixels: FloatArray) -> FloatArray:
        """(w, 3) colours at pixels, each the mean of nine, as they are compared."""
        found = []
        for x, y in np.floor(pixels).astype(int).tolist():
            rows = slice(max(y - 1, 0), y + 2)
            around_it = picture[rows, max(x - 1, 0) : x + 2].reshape(-1, 3)
            if not len(around_it):
                around_it = picture[-1:, -1]
            found.append(around_it.mean(axis=0))
        return compared(np.array(found))

    def _voted(
        self, graph: Graph, costs: FloatArray, voters: Sequence[Voter], given: FloatArray
    ) -> FloatArray:
        """(n,) half of what the photo says a pixel costs, and half of what the others do; of these
        the least within as many pixels as the surface may be off."""
        pixels = graph.places[:, :2]
        places = self.thrown(pixels)
        marks = self.thrown(given)
        total, number = np.zeros(len(costs)), np.zeros(len(costs))
        assert graph.colours is not None
        reach = self._pixels_off(places)
        for voter in voters:
            colours, seen = voter.colours(places)
            tints, known = voter.colours(marks)
            if not seen.any() or not known.any():
                continue
            shown = np.where(seen[:, None], colours, graph.colours)
            own = node_costs(
                Graph(graph.places, graph.starts, graph.near, shown, {}, graph.rough, graph.row),
                self.cost,
                compared(tints[known]),
            )
            own[~seen] = np.inf
            for _ in range(reach):
                own = np.minimum(own, np.minimum.reduceat(own[graph.near], graph.starts[:-1]))
            has = np.isfinite(own)
            total[has] += own[has]
            number[has] += 1
        asked = number > 0
        costs = costs.copy()
        costs[asked] = 0.5 * (costs[asked] + total[asked] / number[asked])
        return costs

    def _pixels_off(self, places: FloatArray) -> int:
        """By how many pixels what another photo shows may be beside its place."""
        views = self.photos.views
        there = places[np.isfinite(places[:, 0])]
        if not len(there):
            return 0
        depth = float(np.median(self.view.depths(views.local(there))))
        pixel = depth / float(np.sqrt(np.prod(self.view.intrinsics.focal)))
        return int(np.clip(round(_OFF * views.resolution / pixel), 0, _MOST_PIXELS_OFF))


def _nearest(graph: Graph, pixel: FloatArray) -> int:
    return int(np.argmin(((graph.places[:, :2] - pixel) ** 2).sum(axis=1)))
