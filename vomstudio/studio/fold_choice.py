"""Selection of the planes for the fold axis, shared by all views of the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vomstudio.core.signals import Signal
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.project.kinds import is_picked_plane
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Record, Typed
from vomstudio.project.selection import Selection
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.projects import Projects

if TYPE_CHECKING:
    from vomstudio.project.fold_planes import FoldPlanes

FOLD_TYPE = "bedding"
"""Feature type of the planes, because different types are never pooled silently."""


class FoldChoice:
    """Selection of the bedding planes from which the fold axis is computed.

    Attributes
    ----------
    fold_filter : FoldFilter
        Required quality and set of the planes.
    is_selected : bool
        Whether only selected planes are used.
    changed : Signal
        Emitted when the filter or `is_selected` changes.
    """

    def __init__(
        self, projects: Projects, derived: DerivedQuantities, selection: Selection
    ) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._derived, self._selection = projects, derived, selection
        self.fold_filter, self.is_selected = FoldFilter(), False
        self._planes: FoldPlanes | None = None
        self._inputs: tuple[object, ...] = ()

    def begin(self) -> None:
        """Reset the filter to all planes, for another project."""
        self.choose(FoldFilter(), is_selected=False)

    def choose(self, fold_filter: FoldFilter, *, is_selected: bool) -> None:
        """Change the filter of the planes, and whether only selected planes are used."""
        if (fold_filter, is_selected) != (self.fold_filter, self.is_selected):
            self.fold_filter, self.is_selected = fold_filter, is_selected
            self.changed.emit()

    def features(self) -> list[Typed]:
        """Return the bedding planes of any quality and set, or only the selected ones."""
        beds = self._projects.records.cached(_beds)
        if self.is_selected:
            ids = set(self._selection.ids)
            return [f for f in beds if f.id in ids]
        return list(beds)

    def planes(self) -> FoldPlanes:
        """Return the planes from which the fold axis is computed, cached until they may change."""
        records, measurements = self._projects.records, self._derived.measurements
        selected_ids = self._selection.ids if self.is_selected else None
        # Compared by identity, because equal records would be compared one by one.
        owners = (records, measurements)
        inputs = (*map(id, owners), records.revision, self.fold_filter, selected_ids)
        if self._planes is None or self._inputs[2:] != inputs:
            from vomstudio.project.fold_planes import fold_planes

            features = self.features()
            measured_planes = self._derived.measured(f.id for f in features)
            self._planes = fold_planes(records, features, measured_planes, self.fold_filter)
            # The owners are stored, so that no other object can have their identity.
            self._inputs = (*owners, *inputs)
        return self._planes

    def sets(self) -> list[str]:
        """Return the names of the sets to which the bedding planes belong."""
        return sorted({f.set_name for f in self._projects.records.cached(_beds)} - {""})


def _beds(records: RecordMap) -> tuple[Typed, ...]:
    return tuple(f for f in records.of(Typed) if is_bed(f))


def is_bed(record: Record | None) -> bool:
    """Return whether a record is a picked plane with the feature type bedding."""
    return isinstance(record, Typed) and record.type_id == FOLD_TYPE and is_picked_plane(record)
