"""Points that were clicked on two models, in pairs, with steps that can be taken back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.studio.jobs.registration_tasks import HomologousPoint

Point = tuple[float, float, float]


@dataclass(frozen=True)
class _State:
    """pairs : whole ones; here, there : the clicked point whose counterpart is not, on the model or
    on the reference; next_number : of the label of the next pair"""

    pairs: tuple[HomologousPoint, ...] = ()
    here: Point | None = None
    there: Point | None = None
    next_number: int = 1


class PointPairs:
    """A click on one side waits for one on the other; a second one on the same side corrects it.
    All in the model's own frame and in World of the reference."""

    def __init__(self) -> None:
        self._state = _State()
        self._before: list[_State] = []
        self._after: list[_State] = []

    @property
    def pairs(self) -> tuple[HomologousPoint, ...]:
        return self._state.pairs

    @property
    def here(self) -> Point | None:
        return self._state.here

    @property
    def there(self) -> Point | None:
        return self._state.there

    def click(self, place: FloatArray, *, on_model: bool) -> None:
        """A point of the model, or of the reference."""
        x, y, z = (float(v) for v in place)
        point = (x, y, z)
        now = replace(self._state, here=point) if on_model else replace(self._state, there=point)
        if now.here is not None and now.there is not None:
            pair = HomologousPoint(str(now.next_number), now.here, now.there)
            now = _State((*now.pairs, pair), None, None, now.next_number + 1)
        self._take(now)

    def remove(self, label: str) -> None:
        """Take a pair out."""
        left = tuple(pair for pair in self.pairs if pair.label != label)
        if left != self.pairs:
            self._take(replace(self._state, pairs=left))

    def clear(self) -> None:
        """Forget all, also what could be taken back."""
        self._state = _State()
        self._before, self._after = [], []

    @property
    def can_undo(self) -> bool:
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        return bool(self._after)

    def undo(self) -> None:
        if self._before:
            self._after.append(self._state)
            self._state = self._before.pop()

    def redo(self) -> None:
        if self._after:
            self._before.append(self._state)
            self._state = self._after.pop()

    def _take(self, state: _State) -> None:
        self._before.append(self._state)
        self._after = []
        self._state = state

    def as_pairs(self) -> Pairs:
        """For a registration."""
        n = len(self.pairs)
        return Pairs(
            tuple(pair.label for pair in self.pairs),
            np.array([pair.model for pair in self.pairs], np.float64).reshape(-1, 3),
            np.array([pair.there for pair in self.pairs], np.float64).reshape(-1, 3),
            np.full((n, 3), np.nan),
            np.zeros(n, bool),
        )
