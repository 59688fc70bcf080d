"""Settings of the net panel: overlays, typed drawings, rotation and bins."""

from __future__ import annotations

import math

from PySide6.QtCore import QObject, Signal

from vomstudio.geology.roses import HISTOGRAM_ANGLES, ROSE_ANGLES
from vomstudio.products.net.contents import NetCircle, NetMark
from vomstudio.products.net.figure_options import MAX_LEVELS
from vomstudio.products.net.net_options import NetRotation
from vomstudio.ui.base.studio import Studio

OVERLAYS = ("girdles", "maxima", "errors", "averages", "intersections", "slip planes")
"""Names of the overlays as stored in the settings."""
BINS = (5.0, 10.0, 15.0, 30.0)
"""Bin widths of roses and histograms in degrees."""


class NetViewSettings(QObject):
    """View settings of the net panel.

    All attributes are reset when another project is opened.

    Attributes
    ----------
    texts : dict
        Typed text by field name.
    circles : tuple of NetCircle
        Typed circles before the rotation.
    marks : tuple of NetMark
        Typed marks before the rotation.
    rotation : NetRotation
        Rotation applied to all orientations.
    hidden_sets : frozenset of str
        Names of hidden sets.
    contoured_type : str or None
        Name of the feature type that is contoured; an empty name stands for the most frequent type,
        None for all types together.
    """

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._reset()
        studio.project_opened.connect(self._reset)

    def _reset(self) -> None:
        self.texts: dict[str, str] = {}
        self.circles: tuple[NetCircle, ...] = ()
        self.marks: tuple[NetMark, ...] = ()
        self.rotation = NetRotation()
        self.hidden_sets: frozenset[str] = frozenset()
        self.contoured_type: str | None = ""

    def select_contoured_type(self, name: str | None) -> None:
        """Select the feature type that is contoured."""
        self.contoured_type = name
        self.changed.emit()

    def rotated_drawings(self) -> tuple[tuple[NetCircle, ...], tuple[NetMark, ...]]:
        """Return the typed circles and marks after the rotation of all orientations."""
        rotation = self.rotation
        if not rotation.has_rotation:
            return self.circles, self.marks
        notation = self._studio.settings.notation
        circles = tuple(rotation.rotate_circle(circle, notation) for circle in self.circles)
        return circles, tuple(map(rotation.rotate_mark, self.marks))

    # --- typed drawings ----------------------------------------------------------------------
    def set_drawings(
        self,
        texts: dict[str, str],
        circles: tuple[NetCircle, ...],
        marks: tuple[NetMark, ...],
        rotation: NetRotation,
    ) -> None:
        """Store the typed circles, marks and rotation."""
        self.texts, self.circles, self.marks, self.rotation = texts, circles, marks, rotation
        self.changed.emit()

    def show_set(self, name: str, is_visible: bool) -> None:
        self.hidden_sets = self.hidden_sets - {name} if is_visible else self.hidden_sets | {name}
        self.changed.emit()

    def show_all(self) -> None:
        self.hidden_sets = frozenset()
        self.changed.emit()

    # --- stored settings ---------------------------------------------------------------------
    @property
    def overlays(self) -> frozenset[str]:
        return frozenset(self._studio.settings.net_asked) & frozenset(OVERLAYS)

    def show_overlay(self, overlay: str, is_visible: bool) -> None:
        overlays = self.overlays | {overlay} if is_visible else self.overlays - {overlay}
        self._studio.settings.net_asked = [name for name in OVERLAYS if name in overlays]
        self._studio.keep_settings()

    @property
    def view(self) -> str:
        """Selected view: "net", or one of `roses.ROSE_ANGLES` and `roses.HISTOGRAM_ANGLES`."""
        view = self._studio.settings.net_view
        return view if view in (*ROSE_ANGLES, *HISTOGRAM_ANGLES) else "net"

    def show_view(self, view: str, projection: str) -> None:
        """Show a net, rose or histogram; an empty projection leaves the projection unchanged."""
        self._studio.settings.net_view = view
        if projection:
            self._studio.settings.projection = projection
        self._studio.keep_settings()

    @property
    def bin_deg(self) -> float:
        bin_deg = self._studio.settings.rose_bin
        return bin_deg if bin_deg in BINS else 10.0

    def set_bins(
        self,
        bin_deg: float,
        *,
        is_length_weighted: bool | None = None,
        is_area_scaled: bool | None = None,
    ) -> None:
        settings = self._studio.settings
        settings.rose_bin = bin_deg
        settings.rose_by_length = (
            settings.rose_by_length if is_length_weighted is None else is_length_weighted
        )
        settings.rose_by_area = settings.rose_by_area if is_area_scaled is None else is_area_scaled
        self._studio.keep_settings()

    @property
    def is_length_weighted(self) -> bool:
        return self._studio.settings.rose_by_length

    @property
    def is_area_scaled(self) -> bool:
        return self._studio.settings.rose_by_area

    @property
    def levels(self) -> tuple[float, ...]:
        """Typed contour levels in ascending order; if empty, round levels are chosen."""
        levels = [v for v in self._studio.settings.contour_levels if isinstance(v, int | float)]
        return tuple(sorted({float(v) for v in levels if math.isfinite(v) and v > 0}))[:MAX_LEVELS]

    def set_levels(self, levels: tuple[float, ...]) -> None:
        self._studio.settings.contour_levels = list(levels)
        self._studio.keep_settings()
