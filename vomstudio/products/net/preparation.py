"""Preparation of the net of a table for drawing."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.table_folds import fold_axis_of_table
from vomstudio.products.net.contents import Contouring, NetCircle, NetContents, NetMark
from vomstudio.products.net.figure_options import StereonetOptions, parse_levels
from vomstudio.products.net.net_options import (
    NetRotation,
    add_intersections,
    parse_cone,
    parse_net_plane,
    parse_plane_circle,
    parse_rotation,
    parse_slip,
    rotate_net,
)
from vomstudio.products.net.set_statistics import add_statistics
from vomstudio.products.net.table_net import error_ellipses

STATISTIC_NAMES = ("girdles", "maxima", "averages")


@dataclass(frozen=True)
class NetAdditions:
    """Elements that are requested for a net besides the sets.

    Parameters
    ----------
    rotation : NetRotation
        Rotation that is applied to everything.
    circles, marks : tuples
        Circles and directions entered by the user.
    statistics : frozenset of str
        Requested statistics, items of `STATISTIC_NAMES`.
    intersections, errors : bool
        Whether to add the intersections of planes, and the 95 % error ellipses of planes.
    fold : FoldFilter or None
        Filter that selects the planes of the fold axis; None if no axis is requested.
    """

    rotation: NetRotation = field(default_factory=NetRotation)
    circles: tuple[NetCircle, ...] = ()
    marks: tuple[NetMark, ...] = ()
    statistics: frozenset[str] = frozenset()
    intersections: bool = False
    errors: bool = False
    fold: FoldFilter | None = None

    def net(self, net: NetContents, rows: OrientationRows) -> NetContents:
        """Add the requested elements to a net, and rotate it.

        The statistics are those of the rotated net.

        Raises
        ------
        UsageError
        """
        if self.intersections:
            net = add_intersections(net)
        if self.errors:
            net = replace(net, errors=error_ellipses(rows))
        net = replace(net, user_circles=self.circles, marks=self.marks)
        if self.rotation.has_rotation:
            net = rotate_net(net, self.rotation)
        if self.fold is not None:
            rotate_vectors = self.rotation.vectors if self.rotation.has_rotation else None
            fold, not_good_count = fold_axis_of_table(rows, self.fold, rotate_vectors)
            net = replace(net, fold=fold, fold_not_good_count=not_good_count)
        return add_statistics(net, self.statistics)


def contouring_from_options(options: StereonetOptions) -> Contouring:
    """Return the contour settings given by options."""
    return Contouring(
        levels=parse_levels(options.levels),
        filled=options.filled,
        each_set=options.each_set,
        sigma=options.kamb_sigma,
        set_name=options.contour_set,
    )


def additions_from_options(options: StereonetOptions) -> NetAdditions:
    """Return the elements that options request besides the sets.

    Raises
    ------
    UsageError
        If an angle is invalid.
    """
    plane = None if options.untilt is None else parse_net_plane(options.untilt, "--untilt")
    slips = [parse_slip(text) for text in options.slip_lines]
    rotate = options.rotate
    return NetAdditions(
        rotation=NetRotation(plane)
        if rotate is None
        else NetRotation(plane, *parse_rotation(rotate)),
        circles=(
            *map(parse_plane_circle, options.planes),
            *map(parse_cone, options.cones),
            *(circle for circle, _ in slips),
        ),
        marks=tuple(mark for _, mark in slips),
        statistics=frozenset(name for name in STATISTIC_NAMES if getattr(options, name)),
        intersections=options.intersections,
        errors=options.errors,
        fold=FoldFilter(options.quality, options.only_set) if options.fold else None,
    )
