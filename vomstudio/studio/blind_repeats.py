"""Repeated picks of randomly selected features while the original picks are hidden."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vomstudio.core.signals import Signal
from vomstudio.geology.coverage.repeat_selection import DEFAULT_SHARE, select_repeats
from vomstudio.project import repeated_features
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import RepeatableFeature, TypedFeature, get
from vomstudio.project.selection import Selection
from vomstudio.studio.projects import Projects
from vomstudio.studio.tool_host import NAVIGATE, ToolHost
from vomstudio.studio.visibility import Visibility


class BlindRepeats:
    """Round of blind repeat picks.

    All features are hidden during a round, because a nearby bed would reveal the expected
    attitude.

    Attributes
    ----------
    selected_ids : tuple of str
        Ids of the features of the round, in order.
    interpreter : str
        Name of the interpreter.
    changed : Signal
        Emitted when the next feature is offered and when the round ends.
    """

    def __init__(
        self,
        projects: Projects,
        tools: ToolHost,
        visibility: Visibility,
        selection: Selection,
        run_in_owner: Callable[[Callable[[], object]], object],
    ) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._tools = projects, tools
        self._visibility, self._selection = visibility, selection
        self._run_in_owner = run_in_owner
        self.selected_ids: tuple[str, ...] = ()
        self.interpreter = ""
        self._skipped_ids: set[str] = set()
        self._previous_hidden_ids: set[str] | None = None
        self._offered_id: str | None = None

    # --- a round -----------------------------------------------------------------------------
    def available(self) -> list[str]:
        """Return the ids of the planes and lines that were picked with a tool."""
        records = self._projects.records
        return [
            f.id
            for f in repeated_features.repeatable_features(records)
            if get_kind(f).orientations and get_kind(f).tool
        ]

    def begin(self, share: float = DEFAULT_SHARE, interpreter: str = "", seed: str = "") -> None:
        """Start a round with a random share of the picks.

        Raises UsageError if the share is not valid.
        """
        self.selected_ids = select_repeats(self.available(), share, seed)
        self.interpreter = interpreter
        self._skipped_ids.clear()
        if not self.selected_ids:
            return
        self._previous_hidden_ids = set(self._visibility.hidden)
        self._hide()
        self._offer_next_repeat()

    def stop(self) -> None:
        """End the round and restore the previous visibility."""
        if self._previous_hidden_ids is not None:
            hidden_ids, previous_hidden_ids = self._visibility.hidden, self._previous_hidden_ids
            self._previous_hidden_ids = None
            self._visibility.set_visible(hidden_ids - previous_hidden_ids, True)
        self.selected_ids = ()
        self._offered_id = None
        self.changed.emit()

    def clear_state(self) -> None:
        """End the round because the project is about to be closed."""
        if self.selected_ids:
            self.stop()

    @property
    def waiting_ids(self) -> list[str]:
        """Ids of the features that remain to be repeated in this round."""
        records = self._projects.records
        repeated_ids = {r.repeat_of for r in self._projects.of(RepeatableFeature) if r.repeat_of}
        return [
            i
            for i in self.selected_ids
            if i in records and i not in repeated_ids | self._skipped_ids
        ]

    @property
    def current(self) -> str | None:
        """Id of the feature to be repeated next, or None if none remains or no round is active."""
        return next(iter(self.waiting_ids), None) if self.selected_ids else None

    def skip(self) -> None:
        """Skip the current feature, for example if it cannot be located any more."""
        if (id_ := self.current) is not None:
            self._skipped_ids.add(id_)
            self._offer_next_repeat()

    def _offer_next_repeat(self) -> None:
        """Activate the tool of the next feature with its type and set, or else end the round."""
        original = get(self._projects.records, self.current, RepeatableFeature)
        self._offered_id = None if original is None else original.id
        if original is None:
            self._tools.activate(NAVIGATE)
            self.stop()
            return
        self._tools.activate(get_kind(original).tool or NAVIGATE)
        if isinstance(original, TypedFeature):
            self._tools.copy_next_type(original.type_id, original.set_name)
        self.changed.emit()

    def _hide(self) -> None:
        # Selected features would be drawn even if hidden.
        self._selection.set(())
        features = {feature.id for feature in self._projects.session.features()}
        self._visibility.set_visible(features, False)

    # --- repeated picks -----------------------------------------------------------------------
    def follow_edit(self, edit: Edit) -> None:
        """Link a new feature of the requested kind to the original.

        If an edit undid a repeat or deleted its original, the next feature is offered again.
        """
        if not self.selected_ids:
            return
        original = get(self._projects.records, self._offered_id, RepeatableFeature)
        for id_, record in edit.after.items():
            is_added = record is not None and edit.before[id_] is None
            if (
                is_added
                and original is not None
                and type(record) is type(original)
                and id_ != original.id
            ):
                assert isinstance(record, RepeatableFeature)
                if record.repeat_of is None:
                    # The next edit must wait until all listeners have received this one.
                    self._run_in_owner(partial(self._link, id_, original.id))
                    return
        if self.current != self._offered_id:
            # A repeat was undone, or its original was deleted.
            self._run_in_owner(self._offer_next_repeat)

    def _link(self, id_: str, first_id: str) -> None:
        session = self._projects.session
        if id_ not in session.records or first_id not in session.records:
            return
        edit = repeated_features.link_repeat(session.records, id_, first_id, self.interpreter)
        session.apply(edit, joins=session.top)
        self._hide()
        self._offer_next_repeat()
