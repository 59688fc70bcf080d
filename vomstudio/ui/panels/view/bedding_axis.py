"""Cached fold axis of the bedding."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.studio.fold_choice import is_bed
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.geology.folds import FoldAxis
    from vomstudio.project.fold_planes import FoldPlanes


class BeddingAxis:
    """Cached fold axis of the planes selected by `Studio.fold`.

    Attributes
    ----------
    planes : FoldPlanes or None
        Planes used by the last search, or None if there were none.
    """

    def __init__(self, studio: Studio) -> None:
        self._studio = studio
        self._axis: FoldAxis | Finding | None = None
        self._has_searched = False
        self._ids: frozenset[str] = frozenset()
        self.planes: FoldPlanes | None = None

    @property
    def count(self) -> int:
        """Number of bedding planes of any quality."""
        return len(self._ids)

    def find_axis(self) -> FoldAxis | Finding:
        """Return the fold axis of the bedding, or the reason why it cannot be computed."""
        if self._axis is None:
            self._axis = self.search()()
        return self._axis

    def store(self, axis: FoldAxis | Finding) -> None:
        """Store the result of the last `search`, unless the bedding has changed since."""
        if self._has_searched:
            self._axis = axis

    @property
    def is_known(self) -> bool:
        """Whether the axis, or the reason why it is undefined, has been computed."""
        return self._axis is not None

    def disabled_reason(self) -> Finding | None:
        """Return why the axis cannot be computed, or None if it can be computed.

        The axis is not computed for this check if there are at least two planes.
        """
        if self._axis is None and self._studio.fold.has_planes(2):
            return None
        axis = self.find_axis()
        return axis if isinstance(axis, Finding) else None

    def invalidate(self, *_: object) -> None:
        """Discard the cached axis."""
        self._axis, self._has_searched = None, False

    def update_bedding(self) -> None:
        """Update the bedding and discard the cached axis."""
        self.invalidate()
        self._ids = frozenset(f.id for f in self._studio.fold.features())

    def follow_edit(self, changed_ids: Iterable[str]) -> None:
        # The search reads thousands of planes, but most edits change other features.
        ids = set(changed_ids)
        if not ids.isdisjoint(self._ids) or any(is_bed(self._studio.records.get(i)) for i in ids):
            # The number of planes decides whether the axis is computed in a worker thread.
            self.update_bedding()

    def search(self) -> Callable[[], FoldAxis | Finding]:
        """Return a function that computes the axis of the current bedding.

        The function may run in a worker thread, since the computation takes seconds for thousands
        of planes.
        """
        self._has_searched = True
        self._ids = frozenset(f.id for f in self._studio.fold.features())
        # The module of the planes is not imported for an empty project.
        planes = self.planes = self._studio.fold.planes() if self._ids else None
        if planes is None or len(planes) < 2:
            reason = self._too_few_planes(0 if planes is None else len(planes))
            return lambda: reason

        def find() -> FoldAxis | Finding:
            try:
                return planes.axis()
            except VomError as error:
                return to_finding(error)

        return find

    def _too_few_planes(self, count: int) -> Finding:
        is_selection = self._studio.fold.is_selected
        code = "fold.needs-selected-planes" if is_selection else "fold.needs-planes"
        return Finding(code, count=count, minimum=2)

    def warnings(self) -> tuple[str, ...]:
        """Return warnings about planes whose verdict is not good, and about excluded planes."""
        from vomstudio.geology.table_folds import not_good_warning

        planes = self.planes
        if planes is None:
            return ()
        exclusions = (f"{item.n} {item.what}: {item.reason}" for item in planes.left_out)
        return (*map(str, not_good_warning(planes.not_good, len(planes))), *exclusions)
