"""What the user wants to see on the net beside the sets themselves."""

from __future__ import annotations

import math

from PySide6.QtCore import QObject, Signal

from vomstudio.geology.roses import HISTOGRAM_OF, ROSE_OF
from vomstudio.products.net.contents import NetCircle, NetMark
from vomstudio.products.net.figure_options import MAX_LEVELS
from vomstudio.products.net.net_options import Turning
from vomstudio.ui.base.studio import Studio

ASKED = ("girdles", "maxima", "errors", "averages", "intersections", "slip planes")
"""What can be switched on; kept in the settings."""
BINS = (5.0, 10.0, 15.0, 30.0)
"""Offered for roses and histograms, in degrees."""


class NetWishes(QObject):
    """circles, marks : as they were typed, turning : what is done to all orientations, hidden : the
    names of sets that are not shown; these last until another project is opened.
    texts : what was typed, by the names of the fields"""

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._forget()
        studio.project_opened.connect(self._forget)

    def _forget(self) -> None:
        self.texts: dict[str, str] = {}
        self.circles: tuple[NetCircle, ...] = ()
        self.marks: tuple[NetMark, ...] = ()
        self.turning = Turning()
        self.hidden: frozenset[str] = frozenset()

    def typed(self) -> tuple[tuple[NetCircle, ...], tuple[NetMark, ...]]:
        """The circles and marks as they are drawn: turned with all else."""
        turning = self.turning
        if not turning.turns:
            return self.circles, self.marks
        notation = self._studio.settings.notation
        circles = tuple(turning.rotate_circle(circle, notation) for circle in self.circles)
        return circles, tuple(map(turning.rotate_mark, self.marks))

    # --- what is typed -----------------------------------------------------------------------
    def draw(
        self,
        texts: dict[str, str],
        circles: tuple[NetCircle, ...],
        marks: tuple[NetMark, ...],
        turning: Turning,
    ) -> None:
        """This is typed from now on."""
        self.texts, self.circles, self.marks, self.turning = texts, circles, marks, turning
        self.changed.emit()

    def show_set(self, name: str, shown: bool) -> None:
        self.hidden = self.hidden - {name} if shown else self.hidden | {name}
        self.changed.emit()

    def show_all(self) -> None:
        self.hidden = frozenset()
        self.changed.emit()

    # --- what is kept ------------------------------------------------------------------------
    @property
    def asked(self) -> frozenset[str]:
        return frozenset(self._studio.settings.net_asked) & frozenset(ASKED)

    def ask(self, name: str, on: bool) -> None:
        wanted = self.asked | {name} if on else self.asked - {name}
        self._studio.settings.net_asked = [each for each in ASKED if each in wanted]
        self._studio.keep_settings()

    @property
    def view(self) -> str:
        """ "net", or one of `roses.ROSE_OF` and `roses.HISTOGRAM_OF`."""
        view = self._studio.settings.net_view
        return view if view in (*ROSE_OF, *HISTOGRAM_OF) else "net"

    def show_view(self, view: str, projection: str) -> None:
        """projection : of the net, empty for the one that is chosen"""
        self._studio.settings.net_view = view
        if projection:
            self._studio.settings.projection = projection
        self._studio.keep_settings()

    @property
    def bin_deg(self) -> float:
        wanted = self._studio.settings.rose_bin
        return wanted if wanted in BINS else 10.0

    def count_by(
        self, bin_deg: float, *, by_length: bool | None = None, by_area: bool | None = None
    ) -> None:
        settings = self._studio.settings
        settings.rose_bin = bin_deg
        settings.rose_by_length = settings.rose_by_length if by_length is None else by_length
        settings.rose_by_area = settings.rose_by_area if by_area is None else by_area
        self._studio.keep_settings()

    @property
    def by_length(self) -> bool:
        return self._studio.settings.rose_by_length

    @property
    def by_area(self) -> bool:
        return self._studio.settings.rose_by_area

    @property
    def levels(self) -> tuple[float, ...]:
        """Of contours, ascending; empty for round ones."""
        found = [v for v in self._studio.settings.contour_levels if isinstance(v, int | float)]
        return tuple(sorted({float(v) for v in found if math.isfinite(v) and v > 0}))[:MAX_LEVELS]

    def contour_at(self, levels: tuple[float, ...]) -> None:
        self._studio.settings.contour_levels = list(levels)
        self._studio.keep_settings()
