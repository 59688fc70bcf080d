"""The fold axis of a table's planes: what `vomstudio fold` prints, and which planes it rests on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vomstudio.core.findings import Message
from vomstudio.errors import GeometryError, UsageError, VomError
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.common_turns import Turns
from vomstudio.geology.domains import DomainFigures, OneAxisFigures, domain_axes
from vomstudio.geology.folding.figures import AxisFigures
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.reprs import Shown
from vomstudio.words import tr

DEFAULT_KIND = "bedding"
UNNAMED = "unassigned"


@dataclass(frozen=True)
class LeftOut:
    """So many rows that were not used, what they are, and why."""

    what: str
    n: int
    reason: str


@dataclass(frozen=True)
class _Counts:
    n: int
    used: int
    left_out: tuple[LeftOut, ...]


@dataclass(frozen=True)
class _Domains:
    domains: Mapping[str, DomainFigures] | None
    one_axis: OneAxisFigures | None


@dataclass(frozen=True)
class _Reading:
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Message, ...]


# The last of the bases has the first of the fields.
@dataclass(frozen=True, repr=False)
class TableFold(Shown, _Reading, _Domains, AxisFigures, _Counts):
    """n : rows; used : of them; left_out : the others, and why. The figures of the axis are those
    of `FoldAxis`. domains : each with its own axis, one_axis : whether one serves all; None where
    no domains were named. convention, dropped_lines : of the table as it was read; warnings : those
    of the table, and findings on the axis."""

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return asdict(self)


def table_fold(
    table: OrientationRows,
    kind: str | None = None,
    sets: Sequence[str] | None = None,
    domain: str | None = None,
    waviness_deg: float | None = None,
) -> TableFold:
    """The axis of a table's planes.

    kind : use planes of this kind only; of a table with kinds bedding is taken without it
    sets : the axis common to these sets, by their means
    domain : name or number of the column that names the domains, each of which gets its own axis
    waviness_deg : how far a pole strays by nature and by error; None for the usual limits
    Raises GeometryError where the planes have no axis, UsageError for a kind, set or column that is
    not there.
    """
    if sets is not None and domain is not None:
        raise UsageError(
            tr("Sets share an axis, domains have one each: name --sets or --domain, not both."),
            field="--domain",
        )
    if waviness_deg is not None and not 0.0 < waviness_deg < 45.0:
        raise UsageError(tr("The waviness lies between 0 and 45 degrees."), field="--waviness")
    axis, choice = _axis_of(table, kind, sets, waviness_deg)
    figures = {f.name: getattr(axis.figures, f.name) for f in fields(AxisFigures)}
    rows = np.flatnonzero(choice.use)
    worst = axis.leave_one_out
    if worst is not None:
        figures["leave_one_out"] = replace(worst, id=str(table.ids[rows[worst.index]]))
    found, one_axis = None, None
    if domain is not None:
        found, one_axis = _domains(table, choice, axis, domain, waviness_deg)
        if not one_axis.serves_all:
            figures.update(
                verdict="two axes", valid="no", reasons=(*one_axis.reasons, *figures["reasons"])
            )
        else:
            figures["reasons"] = (*figures["reasons"], *one_axis.reasons)
    return TableFold(
        n=len(table),
        used=int(choice.use.sum()),
        left_out=tuple(choice.left_out),
        **figures,
        domains=found,
        one_axis=one_axis,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(*table.warnings, *axis.findings),
    )


def _domains(
    table: OrientationRows,
    choice: _Choice,
    axis: FoldAxis,
    column: str,
    waviness_deg: float | None,
) -> tuple[dict[str, DomainFigures], OneAxisFigures]:
    names = table.column(column)
    members: dict[str, list[int]] = {}
    for i in np.flatnonzero(choice.use):
        members.setdefault(names[i].strip() or UNNAMED, []).append(int(i))
    if len(members) < 2:
        raise UsageError(
            tr("The column '{column}' names one domain only; two are needed.", column=column),
            file=table.path,
            field="--domain",
        )
    beds = {
        name: (table.dip_direction_deg[rows], table.dip_deg[rows]) for name, rows in members.items()
    }
    return domain_axes(beds, axis, waviness_deg)


def set_names(text: str) -> list[str]:
    """Names of sets in one word, such as A,B. Raises UsageError."""
    return checked_names(text.split(","))


def checked_names(given: Sequence[str]) -> list[str]:
    """Names of two or more different sets. Raises UsageError."""
    names = [name.strip() for name in given]
    if len(names) < 2 or not all(names) or len({n.casefold() for n in names}) < len(names):
        raise UsageError(tr("Name two or three different sets, as in --sets A,B."), field="--sets")
    return names


def _axis_of(
    table: OrientationRows,
    kind: str | None,
    sets: Sequence[str] | None,
    waviness_deg: float | None,
) -> tuple[FoldAxis, _Choice]:
    choice = _Choice(table)
    choice.planes_only()
    # A column of kinds that says nothing, as `fit` writes it, is no table with kinds.
    has_kinds = table.kinds is not None and any(table.kinds)
    if kind is not None or (sets is None and has_kinds):
        choice.one_kind(kind)
    try:
        if sets is None:
            axis = choice.axis(waviness_deg)
        else:
            axis = choice.common_axis(checked_names(sets))
    except GeometryError as error:
        raise GeometryError(error.message, file=table.path, field=error.field) from error
    return axis, choice


class _Choice:
    """Which planes of a table are used, and what was left out and why."""

    def __init__(self, table: OrientationRows) -> None:
        self.table = table
        self.use: NDArray[np.bool_] = np.ones(len(table), dtype=bool)
        self.left_out: list[LeftOut] = []

    def planes_only(self) -> None:
        lines = int((~self.table.is_plane).sum())
        if lines:
            self.left_out.append(LeftOut("lines", lines, tr("not planes")))
            self.use &= self.table.is_plane
        if not self.use.any():
            raise self._error(tr("The table has only lines. A fold axis needs planes."), "geometry")

    def one_kind(self, wanted: str | None) -> None:
        """Keep one kind: cross joints among beds would turn beta by up to 90 degrees."""
        kinds = self.table.kinds
        if kinds is None:
            raise self._error(tr("The table has no column 'kind' to choose from."), "--kind")
        name = wanted or DEFAULT_KIND
        present = Counter(kind for kind, use in zip(kinds, self.use, strict=True) if use)
        if not any(_same(kind, name) for kind in present):
            listed = ", ".join(kind or "(empty)" for kind in present)
            raise self._error(
                tr(
                    "No plane is of the kind '{kind}'. Choose one with --kind: {kinds}.",
                    kind=name,
                    kinds=listed,
                ),
                "kind",
            )
        for i, kind in enumerate(kinds):
            self.use[i] &= _same(kind, name)
        for kind, n in present.items():
            if not _same(kind, name):
                what = kind or "no kind"
                self.left_out.append(LeftOut(what, n, tr("kind is not {kind}", kind=name)))

    def axis(self, waviness_deg: float | None) -> FoldAxis:
        turns = None if self.table.turns is None else self.table.turns.of(self.use)
        return fold_axis(
            self.table.dip_direction_deg[self.use],
            self.table.dip_deg[self.use],
            turns,
            self.table.bowed_deg,
            waviness_deg,
            [str(id_) for id_ in np.asarray(self.table.ids)[self.use]],
            self._overturned(),
        )

    def _overturned(self) -> NDArray[np.bool_] | None:
        """Of the planes used; None where the table says nothing of it."""
        flags = self.table.overturned
        if flags is None:
            return None
        return np.array([flag is True for flag in flags])[self.use]

    def common_axis(self, names: Sequence[str]) -> FoldAxis:
        """Each set by its mean, once."""
        given = self.table.sets or self.table.kinds
        if given is None:
            raise self._error(
                tr("The table has no column 'set' or 'kind' to choose from."), "--sets"
            )
        present = Counter(name for name, use in zip(given, self.use, strict=True) if use)
        chosen: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        turns: dict[str, Turns] = {}
        used = np.zeros(len(self.table), dtype=bool)
        for name in names:
            members = self.use & np.array([_same(s, name) for s in given], dtype=bool)
            if not members.any():
                listed = ", ".join(s or "(empty)" for s in present)
                raise self._error(
                    tr(
                        "No plane is in the set '{set}'. The sets are {sets}.",
                        set=name,
                        sets=listed,
                    ),
                    "--sets",
                )
            chosen[name] = (
                self.table.dip_direction_deg[members],
                self.table.dip_deg[members],
            )
            if self.table.turns is not None:
                turns[name] = self.table.turns.of(members)
            used |= members
        for name, n in present.items():
            if not any(_same(name, wanted) for wanted in names):
                what = name or "no set"
                self.left_out.append(LeftOut(what, n, tr("set was not named")))
        self.use = used
        return common_axis(chosen, turns or None)

    def _error(self, message: str, field: str) -> VomError:
        return UsageError(message, file=self.table.path, field=field)


def _same(a: str, b: str) -> bool:
    return a.strip().casefold() == b.strip().casefold()
