"""Selection of the planes for the fold axis, shared by all views of the window."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING

from vomstudio.core.signals import Signal
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.project.kinds import group_and_set, is_picked_plane
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Record, TypedFeature
from vomstudio.project.selection import Selection
from vomstudio.studio.derived_quantities import DerivedQuantities
from vomstudio.studio.projects import Projects

if TYPE_CHECKING:
    from vomstudio.project.fold_planes import FoldPlanes

MAX_TESTED_PLANES = 50
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

    def features(self) -> list[TypedFeature]:
        """Return the bedding planes of any quality and set, or only the selected ones."""
        beds = self._projects.records.cached(_beds)
        if self.is_selected:
            ids = set(self._selection.ids)
            return [f for f in beds if f.id in ids]
        return list(beds)

    def planes(self) -> FoldPlanes:
        """Return the planes from which the fold axis is computed, cached until they may change."""
        records, measurements = self._projects.records, self._derived.measurements
        inputs = self._key()
        if self._planes is None or self._inputs[2:] != inputs:
            from vomstudio.project.fold_planes import fold_planes

            features = self.features()
            measured_planes = self._derived.measured(f.id for f in features)
            self._planes = fold_planes(records, features, measured_planes, self.fold_filter)
            # The owners are stored, so that no other object can have their identity.
            self._inputs = (records, measurements, *inputs)
        return self._planes

    def _key(self) -> tuple[object, ...]:
        """Return the inputs on which the planes depend."""
        records, measurements = self._projects.records, self._derived.measurements
        selected_ids = self._selection.ids if self.is_selected else None
        # Compared by identity, because equal records would be compared one by one.
        return id(records), id(measurements), records.revision, self.fold_filter, selected_ids

    def has_planes(self, count: int) -> bool:
        """Return whether at least `count` planes are available, usually by testing only some."""
        is_known = self._planes is not None and self._inputs[2:] == self._key()
        if not is_known and not self.is_selected:
            from vomstudio.project.fold_planes import fold_planes

            records = self._projects.records
            first_beds = list(islice(filter(is_bed, records.of(TypedFeature)), MAX_TESTED_PLANES))
            measurements = self._derived.measured(f.id for f in first_beds)
            if len(fold_planes(records, first_beds, measurements, self.fold_filter)) >= count:
                return True
        return len(self.planes()) >= count

    def sets(self) -> list[str]:
        """Return the names of the sets to which the bedding planes belong."""
        counts = self._projects.records.count_by(group_and_set)
        return sorted(
            {name for group, name, is_picked in counts if is_picked and group == FOLD_TYPE} - {""}
        )


def _beds(records: RecordMap) -> tuple[TypedFeature, ...]:
    return tuple(f for f in records.of(TypedFeature) if is_bed(f))


def is_bed(record: Record | None) -> bool:
    """Return whether a record is a picked plane with the feature type bedding."""
    return (
        isinstance(record, TypedFeature) and record.type_id == FOLD_TYPE and is_picked_plane(record)
    )
