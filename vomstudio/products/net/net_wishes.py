"""What is done to the net of a table before it is drawn, in the order in which it is done."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.products.net.contents import NetCircle, NetContents, NetMark
from vomstudio.products.net.found_in_sets import with_findings
from vomstudio.products.net.net_options import Turning, net_after, with_intersections
from vomstudio.products.net.table_net import error_ellipses

FINDINGS = ("girdles", "maxima", "averages")


@dataclass(frozen=True)
class NetWishes:
    """turning : of everything; circles, marks : that were typed; found : of
    `FINDINGS`; intersections, errors : lines in which planes meet, ellipses of their errors"""

    turning: Turning = field(default_factory=Turning)
    circles: tuple[NetCircle, ...] = ()
    marks: tuple[NetMark, ...] = ()
    found: frozenset[str] = frozenset()
    intersections: bool = False
    errors: bool = False

    def net(self, net: NetContents, rows: OrientationRows) -> NetContents:
        """All is turned with the planes, what was typed too; findings are those of what was
        turned. Raises UsageError."""
        if self.intersections:
            net = with_intersections(net)
        if self.errors:
            net = replace(net, errors=error_ellipses(rows))
        net = replace(net, circles_typed=self.circles, marks=self.marks)
        if self.turning.turns:
            net = net_after(net, self.turning)
        return with_findings(net, self.found)
