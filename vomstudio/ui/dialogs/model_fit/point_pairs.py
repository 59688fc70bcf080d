"""Pairs of points clicked on two models, with undo and redo."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.studio.jobs.registration_tasks import HomologousPoint

Point = tuple[float, float, float]


@dataclass(frozen=True)
class _State:
    """Complete pairs, at most one pending point of each model, and the next label."""

    pairs: tuple[HomologousPoint, ...] = ()
    model_point: Point | None = None
    reference_point: Point | None = None
    next_number: int = 1


class PointPairs:
    """Collection of point pairs from clicks on a model and its reference.

    A second click on the same side replaces the pending point. Points on the model are in its
    file frame, and points on the reference are in the World frame.
    """

    def __init__(self) -> None:
        self._state = _State()
        self._undo_states: list[_State] = []
        self._redo_states: list[_State] = []

    @property
    def pairs(self) -> tuple[HomologousPoint, ...]:
        return self._state.pairs

    @property
    def model_point(self) -> Point | None:
        return self._state.model_point

    @property
    def reference_point(self) -> Point | None:
        return self._state.reference_point

    def click(self, coordinates: FloatArray, *, is_model: bool) -> None:
        """Add a point on the model or on the reference."""
        x, y, z = (float(v) for v in coordinates)
        point = (x, y, z)
        state = (
            replace(self._state, model_point=point)
            if is_model
            else replace(self._state, reference_point=point)
        )
        if state.model_point is not None and state.reference_point is not None:
            pair = HomologousPoint(str(state.next_number), state.model_point, state.reference_point)
            state = _State((*state.pairs, pair), None, None, state.next_number + 1)
        self._push(state)

    def remove(self, label: str) -> None:
        """Remove a pair."""
        remaining_pairs = tuple(pair for pair in self.pairs if pair.label != label)
        if remaining_pairs != self.pairs:
            self._push(replace(self._state, pairs=remaining_pairs))

    def clear(self) -> None:
        """Remove all points and the history."""
        self._state = _State()
        self._undo_states, self._redo_states = [], []

    @property
    def can_undo(self) -> bool:
        return bool(self._undo_states)

    @property
    def can_redo(self) -> bool:
        return bool(self._redo_states)

    def undo(self) -> None:
        if self._undo_states:
            self._redo_states.append(self._state)
            self._state = self._undo_states.pop()

    def redo(self) -> None:
        if self._redo_states:
            self._undo_states.append(self._state)
            self._state = self._redo_states.pop()

    def _push(self, state: _State) -> None:
        self._undo_states.append(self._state)
        self._redo_states = []
        self._state = state

    def to_pairs(self) -> Pairs:
        """Convert to point pairs for a registration, with unknown errors."""
        n = len(self.pairs)
        return Pairs(
            tuple(pair.label for pair in self.pairs),
            np.array([pair.model for pair in self.pairs], np.float64).reshape(-1, 3),
            np.array([pair.reference_point for pair in self.pairs], np.float64).reshape(-1, 3),
            np.full((n, 3), np.nan),
            np.zeros(n, bool),
        )
