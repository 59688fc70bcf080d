"""Picks that are offered for a second time, without sight of the first."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vomstudio.core.signals import Signal
from vomstudio.geology.coverage.repeat_selection import SHARE, chosen_for_repeating
from vomstudio.project import repeated_features
from vomstudio.project.edit import Edit
from vomstudio.project.kinds import kind_of
from vomstudio.project.records import Repeatable, Typed, get
from vomstudio.project.selection import Selection
from vomstudio.studio.projects import Projects
from vomstudio.studio.tool_host import NAVIGATE, ToolHost
from vomstudio.studio.visibility import Visibility


class BlindRepeats:
    """While a round lasts, all features are hidden: a bed beside it says how one dips as well.

    chosen : the ids of the round, in their order; interpreter : who picks. changed : another one is
    offered, or none any more
    """

    def __init__(
        self,
        projects: Projects,
        tools: ToolHost,
        visibility: Visibility,
        selection: Selection,
        hand_over: Callable[[Callable[[], object]], object],
    ) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._tools = projects, tools
        self._visibility, self._selection = visibility, selection
        self._hand_over = hand_over
        self.chosen: tuple[str, ...] = ()
        self.interpreter = ""
        self._skipped: set[str] = set()
        self._hidden_before: set[str] | None = None
        self._offered: str | None = None

    # --- a round -----------------------------------------------------------------------------
    def available(self) -> list[str]:
        """Ids of what could be offered: planes and lines picked with a tool, and not repeated."""
        records = self._projects.records
        return [
            f.id
            for f in repeated_features.repeatable_features(records)
            if kind_of(f).orientations and kind_of(f).tool
        ]

    def begin(self, share: float = SHARE, interpreter: str = "", seed: str = "") -> None:
        """Offer a random share of the picks. Raises UsageError for a share that is none."""
        self.chosen = chosen_for_repeating(self.available(), share, seed)
        self.interpreter = interpreter
        self._skipped.clear()
        if not self.chosen:
            return
        self._hidden_before = set(self._visibility.hidden)
        self._hide()
        self._offer()

    def stop(self) -> None:
        """What was shown before is shown again."""
        if self._hidden_before is not None:
            hidden, before = self._visibility.hidden, self._hidden_before
            self._hidden_before = None
            self._visibility.set_visible(hidden - before, True)
        self.chosen = ()
        self._offered = None
        self.changed.emit()

    def forget(self) -> None:
        """The project is being left."""
        if self.chosen:
            self.stop()

    @property
    def waiting(self) -> list[str]:
        """Those of the round that are still to be picked."""
        records = self._projects.records
        done = {r.repeat_of for r in self._projects.of(Repeatable) if r.repeat_of}
        return [i for i in self.chosen if i in records and i not in done | self._skipped]

    @property
    def current(self) -> str | None:
        """What is to be picked now."""
        return next(iter(self.waiting), None) if self.chosen else None

    def skip(self) -> None:
        """Leave one out: its place cannot be made out any more."""
        if (id_ := self.current) is not None:
            self._skipped.add(id_)
            self._offer()

    def _offer(self) -> None:
        """The tool of the next one, with its type and set."""
        first = get(self._projects.records, self.current, Repeatable)
        self._offered = None if first is None else first.id
        if first is None:
            self._tools.activate(NAVIGATE)
            self.stop()
            return
        self._tools.activate(kind_of(first).tool or NAVIGATE)
        if isinstance(first, Typed):
            self._tools.set_next(first.type_id, first.set_name)
        self.changed.emit()

    def _hide(self) -> None:
        # What is selected is drawn all the same.
        self._selection.set(())
        features = {feature.id for feature in self._projects.session.features()}
        self._visibility.set_visible(features, False)

    # --- what is picked ----------------------------------------------------------------------
    def edited(self, edit: Edit) -> None:
        """A new feature of the kind that is asked for is the repeat."""
        if not self.chosen:
            return
        first = get(self._projects.records, self._offered, Repeatable)
        for id_, record in edit.after.items():
            new = record is not None and edit.before[id_] is None
            if new and first is not None and type(record) is type(first) and id_ != first.id:
                assert isinstance(record, Repeatable)
                if record.repeat_of is None:
                    # Who hears of an edit makes no other one before all have heard of it.
                    self._hand_over(partial(self._link, id_, first.id))
                    return
        if self.current != self._offered:
            # A repeat was taken back, or the first one deleted.
            self._hand_over(self._offer)

    def _link(self, id_: str, first_id: str) -> None:
        session = self._projects.session
        if id_ not in session.records or first_id not in session.records:
            return
        edit = repeated_features.link_repeat(session.records, id_, first_id, self.interpreter)
        session.apply(edit, joins=session.top)
        self._hide()
        self._offer()
