"""The planes of the fold axis, chosen once for net, statistics, views and sections."""

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
    """Which planes of the bedding make the fold axis; the same everywhere in the window.

    changed : another choice; which : quality and set; selected : only of the selected planes.
    Another project has all.
    """

    def __init__(
        self, projects: Projects, derived: DerivedQuantities, selection: Selection
    ) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._derived, self._selection = projects, derived, selection
        self.which, self.selected = FoldFilter(), False

    def begin(self) -> None:
        """Another project: use all planes."""
        self.choose(FoldFilter(), selected=False)

    def choose(self, which: FoldFilter, *, selected: bool) -> None:
        """Use these planes from now on."""
        if (which, selected) != (self.which, self.selected):
            self.which, self.selected = which, selected
            self.changed.emit()

    def features(self) -> list[Typed]:
        """All bedding planes, or the selected ones, of any quality and set."""
        found = [f for f in self._projects.session.of(Typed) if is_bed(f)]
        if self.selected:
            ids = set(self._selection.ids)
            found = [f for f in found if f.id in ids]
        return found

    def planes(self) -> FoldPlanes:
        """The planes of the fold axis."""
        from vomstudio.project.fold_planes import fold_planes

        features = self.features()
        measured = self._derived.measured(f.id for f in features)
        return fold_planes(self._projects.records, features, measured, self.which)

    def sets(self) -> list[str]:
        """Names of the sets of the bedding."""
        return sorted({f.set_name for f in self._projects.session.of(Typed) if is_bed(f)} - {""})


def is_bed(record: Record | None) -> bool:
    """Return whether a record is a picked plane of the type bedding."""
    return isinstance(record, Typed) and record.type_id == FOLD_TYPE and is_picked_plane(record)
