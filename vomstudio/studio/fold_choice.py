"""Planes of the fold axis, chosen once for net, statistics, views and sections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.core.signals import Signal
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.project.kinds import is_picked_plane
from vomstudio.project.records import Record, Typed
from vomstudio.project.selection import Selection
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.projects import Projects

if TYPE_CHECKING:
    from vomstudio.project.fold_planes import FoldPlanes

FOLD_TYPE = "bedding"
"""Feature type of the planes: types are never pooled silently."""


class FoldChoice:
    """Choice of the bedding planes for the fold axis, the same everywhere in the window.

    Attributes
    ----------
    which : FoldFilter
        Quality and set.
    selected : bool
        Whether only selected planes are used.
    changed : Signal
        Emitted when the choice changes.
    """

    def __init__(
        self, projects: Projects, derived: DerivedQuantities, selection: Selection
    ) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._derived, self._selection = projects, derived, selection
        self.which, self.selected = FoldFilter(), False

    def begin(self) -> None:
        """Use all planes of another project."""
        self.choose(FoldFilter(), selected=False)

    def choose(self, which: FoldFilter, *, selected: bool) -> None:
        """Change the choice."""
        if (which, selected) != (self.which, self.selected):
            self.which, self.selected = which, selected
            self.changed.emit()

    def features(self) -> list[Typed]:
        """Return all bedding planes, or the selected ones, of any quality and set."""
        beds = [f for f in self._projects.session.of(Typed) if is_bed(f)]
        if self.selected:
            ids = set(self._selection.ids)
            beds = [f for f in beds if f.id in ids]
        return beds

    def planes(self) -> FoldPlanes:
        """Return the planes of the fold axis."""
        from vomstudio.project.fold_planes import fold_planes

        features = self.features()
        measured = self._derived.measured(f.id for f in features)
        return fold_planes(self._projects.records, features, measured, self.which)

    def sets(self) -> list[str]:
        """Return the names of the sets of the bedding."""
        return sorted({f.set_name for f in self._projects.session.of(Typed) if is_bed(f)} - {""})


def is_bed(record: Record | None) -> bool:
    """Return whether a record is a picked plane of the type bedding."""
    return isinstance(record, Typed) and record.type_id == FOLD_TYPE and is_picked_plane(record)
