"""The fold axis of the bedding, kept until something that it rests on changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.document.kinds import is_picked_plane
from vomstudio.document.records import Model, Record, Typed, get_feature
from vomstudio.document.registration_errors import bowed_deg, model_of, turns_of
from vomstudio.document.repeats import firsts
from vomstudio.errors import VomError
from vomstudio.geology.orientation import normals_to_planes
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.geology.folds import FoldAxis


class BeddingAxis:
    """only_selected : tells whether the selected planes alone count"""

    def __init__(self, studio: Studio, only_selected: Callable[[], bool]) -> None:
        self._studio = studio
        self._only_selected = only_selected
        self._kept: FoldAxis | str | None = None
        self._searched = False
        self._poor = 0
        self.beds: tuple[str, ...] = ()

    def planes(self) -> list[str]:
        """Ids of the bedding planes for the fold axis: feature types are never pooled silently."""
        session = self._studio.session
        beds = [t.id for t in firsts(filter(_is_bed, session.of(Typed)), session.records)]
        if not self._only_selected():
            return beds
        chosen = set(self._studio.selection.ids)
        return [id_ for id_ in beds if id_ in chosen]

    def found(self) -> FoldAxis | str:
        """The fold axis of the bedding, or why there is none."""
        if self._kept is None:
            self._kept = self.search()()
        return self._kept

    def keep(self, axis: FoldAxis | str) -> None:
        """What the last `search` has found, unless something has changed since."""
        if self._searched:
            self._kept = axis

    @property
    def known(self) -> bool:
        """Whether the axis, or why there is none, has been found."""
        return self._kept is not None

    def why_not(self) -> str | None:
        """Why there is none, without looking for it where two planes will do."""
        if self._kept is None:
            measured = (self._studio.measured([id_])[id_] for id_ in self.planes())
            if sum(1 for _ in islice((m for m in measured if m.fit is not None), 2)) == 2:
                return None
        axis = self.found()
        return axis if isinstance(axis, str) else None

    def forget(self, *_: object) -> None:
        """Every refresh of the commands asks for the axis: it is kept until something changes."""
        self._kept, self._searched = None, False

    def renew(self) -> None:
        """Its bedding is known at once, the axis when it is asked for."""
        self.forget()
        self.beds = tuple(self.planes())

    def edited(self, touched: Iterable[str]) -> None:
        # Thousands of planes are asked for it: most edits are of other features.
        ids = set(touched)
        if not ids.isdisjoint(self.beds) or any(
            _is_bed(self._studio.records.get(id_)) for id_ in ids
        ):
            # How many there are decides whether the axis is looked for beside the window.
            self.renew()

    def search(self) -> Callable[[], FoldAxis | str]:
        """What finds the axis, or why there is none, of the bedding as it is now; to be called in
        any thread, since it takes long for thousands of planes."""
        self._searched = True
        self.beds = tuple(self.planes())
        measured = self._studio.measured(self.beds)
        self._poor = sum(
            m.verdict is not None and m.verdict.quality == "poor" for m in measured.values()
        )
        fitted = {id_: m.fit for id_, m in measured.items() if m.fit is not None}
        if len(fitted) < 2:
            few = self._too_few(len(fitted))
            return lambda: few
        records = self._studio.records
        models = [model_of(records, get_feature(records, id_)) for id_ in fitted]
        normals = np.array([fit.normal for fit in fitted.values()])
        features = [get_feature(records, id_) for id_ in fitted]
        names = [
            getattr(each, "name", "") or id_ for each, id_ in zip(features, fitted, strict=True)
        ]
        overturned = [getattr(each, "overturned", False) for each in features]
        return partial(_axis_of, normals, models, names, overturned)

    def _too_few(self, count: int) -> str:
        if self._only_selected():
            return tr(
                "A fold axis needs at least 2 selected bedding planes; there are {count}.",
                count=count,
            )
        return tr("A fold axis needs at least 2 bedding planes; there are {count}.", count=count)

    def doubts(self) -> tuple[str, ...]:
        """A warning where planes are poor: the scatter of planes ignores the error of each."""
        if not self._poor:
            return ()
        return (
            tr_n(
                "{count} of these planes is poor: the error of the fold axis is computed from "
                "scatter alone and is too small.",
                "{count} of these planes are poor: the error of the fold axis is computed from "
                "scatter alone and is too small.",
                self._poor,
            ),
        )


def _axis_of(
    normals: npt.NDArray[np.float64],
    models: list[Model | None],
    names: list[str],
    overturned: list[bool],
) -> FoldAxis | str:
    from vomstudio.geology.folds import fold_axis

    azimuths, dips, _ = normals_to_planes(normals)
    try:
        return fold_axis(
            azimuths, dips, turns_of(models), bowed_deg(models), names=names, overturned=overturned
        )
    except VomError as error:
        return str(error)


def _is_bed(record: Record | None) -> bool:
    """A picked plane of the type bedding."""
    return isinstance(record, Typed) and record.type_id == "bedding" and is_picked_plane(record)
