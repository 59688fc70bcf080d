"""Session of an open project: records, history and notifications.

Records are changed only by the methods of `Session`, and changes are reported only by its signal
`changed`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from vomstudio.core.findings import Finding
from vomstudio.core.signals import Signal, group_notifications
from vomstudio.project.codec import encode_edit
from vomstudio.project.edit import Edit, change
from vomstudio.project.journal.replay import Draft, Journal, RowKind, replay
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import DEFAULT_TYPES, Feature, FeatureType, Record

T = TypeVar("T")
RESTORE_TYPES_LABEL = "Restore the feature types"
DISCARD_LABEL = "Discard unsaved changes"


class Session:
    """Records of an open project, with their history and journal.

    A row is committed to the journal before its effect is announced. `settings` returns the
    settings that affect results; they are stored with every edit.
    """

    def __init__(self, journal: Journal, settings: Callable[[], Mapping[str, Any]] = dict) -> None:
        self.changed: Signal[Edit] = Signal()
        self.history_changed: Signal[None] = Signal()
        self._journal = journal
        self._settings = settings
        replayed = replay(journal.rows())
        self._records = RecordMap(replayed.records)
        self._done_steps = replayed.done
        self._undone_steps = replayed.undone
        self._saved_records = replayed.saved_records
        self._saved_top = replayed.saved_top
        self.problems: tuple[Finding, ...] = tuple(replayed.problems)
        self.draft: Draft | None = replayed.draft
        self.is_recovered = self.dirty and bool(self._done_steps)
        if not replayed.done and not replayed.undone and not replayed.records:
            self._begin()
        elif not self.of(FeatureType):
            # The first row of the journal is damaged. Without feature types nothing can be picked.
            types: dict[str, Record | None] = {
                feature_type.id: feature_type for feature_type in DEFAULT_TYPES
            }
            self._write(change(self._records, RESTORE_TYPES_LABEL, types), "do")

    def _begin(self) -> None:
        first_edit = change(
            {}, "New project", {feature_type.id: feature_type for feature_type in DEFAULT_TYPES}
        )
        self._write(first_edit, "do")
        self._journal.append("save")
        self._saved_records, self._saved_top = dict(self._records), self.top

    @property
    def records(self) -> RecordMap:
        """Live mapping of the records; copy it to preserve a state."""
        return self._records

    def features(self) -> list[Feature]:
        """Return all features in the order in which they were added."""
        return self._records.of(Feature)

    def of(self, cls: type[T]) -> list[T]:
        """Return the records of a class in the order in which they were added."""
        return self._records.of(cls)

    def has_ever_contained(self, *classes: type[Any]) -> bool:
        """Return whether the history has ever contained a record of one of these classes."""
        return any(
            isinstance(record, classes)
            for _, edit in (*self._done_steps, *self._undone_steps)
            for record in (*edit.before.values(), *edit.after.values())
        )

    # --- edits -------------------------------------------------------------------------------
    def apply(self, edit: Edit, *, finishes_draft: bool = False, joins: int | None = None) -> int:
        """Apply an edit and return its number.

        Parameters
        ----------
        edit : Edit
        finishes_draft : bool, optional
            Whether the edit finishes a line that is being drawn.
        joins : int, optional
            Number of the newest edit, as returned by this method, with which this edit forms a
            single step of the history. If another edit is newer, this edit becomes a separate step.

        Raises
        ------
        DocumentError
            If the edit does not match the records or cannot be written. In this case nothing has
            changed.
        """
        # Amending a saved edit would undo the save as well.
        amends = joins is not None and joins == self.top and self.dirty
        self._write(edit, "amend" if amends else "do", finishes_draft=finishes_draft)
        self._notify(edit)
        return self.top

    def _write(self, edit: Edit, kind: RowKind, *, finishes_draft: bool = False) -> None:
        edit.check(self._records)
        old_values, new_values = encode_edit(edit)
        of_seq = self.draft.seq if finishes_draft and self.draft else None
        seq = self._journal.append(
            kind,
            of_seq=self.top if kind == "amend" else of_seq,
            label=edit.label,
            before=old_values,
            after=new_values,
            settings=self._settings(),
        )
        if finishes_draft:
            self.draft = None
        self._records.apply(edit.after)
        if kind == "amend":
            edit = self._done_steps.pop()[1].merge_with(edit)
        self._done_steps.append((seq, edit))
        self._undone_steps.clear()

    def _notify(self, edit: Edit) -> None:
        with group_notifications():
            self.changed.emit(edit)
            self.history_changed.emit(None)

    # --- history -----------------------------------------------------------------------------
    @property
    def top(self) -> int:
        return self._done_steps[-1][0] if self._done_steps else 0

    @property
    def saved_top(self) -> int:
        """Number of the newest edit at the time of the last save."""
        return self._saved_top

    @property
    def saved_records(self) -> Mapping[str, Record]:
        """Records at the time of the last save."""
        return MappingProxyType(self._saved_records)

    @property
    def undo_label(self) -> str | None:
        """Label of the step to undo, or None. The creation of the project cannot be undone."""
        return self._done_steps[-1][1].label if len(self._done_steps) > 1 else None

    @property
    def redo_label(self) -> str | None:
        return self._undone_steps[-1][1].label if self._undone_steps else None

    def undo(self) -> None:
        if self.undo_label is None:
            return
        seq, edit = self._done_steps[-1]
        self._journal.append("undo", of_seq=seq, label=edit.label)
        self._done_steps.pop()
        self._undone_steps.append((seq, edit))
        inverse = edit.inverse()
        inverse.check(self._records)
        self._records.apply(inverse.after)
        self._notify(inverse)

    def redo(self) -> None:
        if self.redo_label is None:
            return
        seq, edit = self._undone_steps[-1]
        self._journal.append("redo", of_seq=seq, label=edit.label)
        self._undone_steps.pop()
        self._done_steps.append((seq, edit))
        edit.check(self._records)
        self._records.apply(edit.after)
        self._notify(edit)

    # --- saving ------------------------------------------------------------------------------
    @property
    def dirty(self) -> bool:
        return self.top != self._saved_top

    def save(self) -> None:
        self._journal.append("save")
        self.mark_saved()

    def mark_saved(self) -> None:
        """Treat the current state as saved. The last row of the journal must be a save."""
        self._saved_records, self._saved_top = dict(self._records), self.top
        self.is_recovered = False
        self.history_changed.emit(None)

    def discard_unsaved(self) -> None:
        """Restore the state of the last save with an edit that can itself be undone."""
        ids = {
            id_
            for id_ in {*self._records, *self._saved_records}
            if self._records.get(id_) != self._saved_records.get(id_)
        }
        if not any(isinstance(record, FeatureType) for record in self._saved_records.values()):
            # Types that were restored after damage are not work that could be discarded.
            ids = {id_ for id_ in ids if not isinstance(self._records.get(id_), FeatureType)}
        edit = change(
            self._records, DISCARD_LABEL, {id_: self._saved_records.get(id_) for id_ in ids}
        )
        self._write(edit, "discard")
        self._journal.append("save")
        self._saved_records, self._saved_top = dict(self._records), self.top
        self.is_recovered = False
        self._notify(edit)

    # --- drafts ------------------------------------------------------------------------------
    def set_draft(self, state: Mapping[str, Any] | None) -> None:
        """Store the clicks of an unfinished tool, or None after the tool was cancelled."""
        if state is None and self.draft is None:
            return
        seq = self._journal.append("draft", after=state)
        self.draft = None if state is None else Draft(seq, dict(state))

    def use_journal(self, journal: Journal, seq_map: Mapping[int, int] | None = None) -> Journal:
        """Continue in another journal with the same steps, and return the previous journal.

        `seq_map` maps row numbers of the previous journal to those of the new one if they differ.
        """
        old_journal, self._journal = self._journal, journal
        if seq_map:
            self._done_steps = [(seq_map[seq], edit) for seq, edit in self._done_steps]
            self._undone_steps = [(seq_map[seq], edit) for seq, edit in self._undone_steps]
            self._saved_top = seq_map.get(self._saved_top, self._saved_top)
            if self.draft is not None:
                self.draft = Draft(seq_map[self.draft.seq], self.draft.state)
        return old_journal

    def done_steps(self) -> list[tuple[int, Edit]]:
        """Return the row number and edit of each step that can be undone, oldest first."""
        return list(self._done_steps)

    def undone_steps(self) -> list[tuple[int, Edit]]:
        """Return the row number and edit of each step that can be redone, the next step last."""
        return list(self._undone_steps)

    def close(self) -> None:
        self._journal.close()
