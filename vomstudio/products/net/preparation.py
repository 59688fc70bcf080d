"""What is done to the net of a table before it is drawn, in the order in which it is done."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geology.table_folds import fold_of_table
from vomstudio.products.net.contents import Contouring, NetCircle, NetContents, NetMark
from vomstudio.products.net.figure_options import StereonetOptions, parse_levels
from vomstudio.products.net.net_options import (
    Turning,
    net_after,
    plane_of,
    turn_of,
    typed_cone,
    typed_plane,
    typed_slip,
    with_intersections,
)
from vomstudio.products.net.set_statistics import with_findings
from vomstudio.products.net.table_net import error_ellipses

FINDINGS = ("girdles", "maxima", "averages")


@dataclass(frozen=True)
class NetWishes:
    """turning : of everything; circles, marks : that were typed; found : of
    `FINDINGS`; intersections, errors : lines in which planes meet, ellipses of their errors;
    fold : planes of the fold axis, None for no axis"""

    turning: Turning = field(default_factory=Turning)
    circles: tuple[NetCircle, ...] = ()
    marks: tuple[NetMark, ...] = ()
    found: frozenset[str] = frozenset()
    intersections: bool = False
    errors: bool = False
    fold: FoldFilter | None = None

    def net(self, net: NetContents, rows: OrientationRows) -> NetContents:
        """Add the requested items to a net, and rotate all of it with its planes.

        The findings are those of the rotated net. Raises UsageError.
        """
        if self.intersections:
            net = with_intersections(net)
        if self.errors:
            net = replace(net, errors=error_ellipses(rows))
        net = replace(net, circles_typed=self.circles, marks=self.marks)
        if self.turning.turns:
            net = net_after(net, self.turning)
        if self.fold is not None:
            turn = self.turning.vectors if self.turning.turns else None
            fold, not_good = fold_of_table(rows, self.fold, turn)
            net = replace(net, fold=fold, fold_not_good=not_good)
        return with_findings(net, self.found)


def contouring_of(options: StereonetOptions) -> Contouring:
    """Return the settings of the contours of a net."""
    return Contouring(
        parse_levels(options.levels), options.filled, options.each_set, options.kamb_sigma
    )


def wishes_of(options: StereonetOptions) -> NetWishes:
    """Return the items drawn besides the sets. Raises UsageError for angles that are not valid."""
    plane = None if options.untilt is None else plane_of(options.untilt, "--untilt")
    slips = [typed_slip(text) for text in options.slip_lines]
    rotate = options.rotate
    return NetWishes(
        turning=Turning(plane) if rotate is None else Turning(plane, *turn_of(rotate)),
        circles=(
            *map(typed_plane, options.planes),
            *map(typed_cone, options.cones),
            *(circle for circle, _ in slips),
        ),
        marks=tuple(mark for _, mark in slips),
        found=frozenset(name for name in FINDINGS if getattr(options, name)),
        intersections=options.intersections,
        errors=options.errors,
        fold=FoldFilter(options.quality, options.only_set) if options.fold else None,
    )
