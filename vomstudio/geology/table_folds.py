"""Compute the fold axis of a table's planes, as `vomstudio fold` prints it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.common_rotation_errors import Turns
from vomstudio.geology.domains import (
    DomainFigures,
    OneAxisFigures,
    apply_domain_verdict,
    domain_axes,
)
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.fold_planes import FoldFilter, LeftOut, choose_planes, verdict_in
from vomstudio.geology.folding.figures import AxisFigures
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import normals_to_planes, planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows

DEFAULT_KIND = "bedding"
UNNAMED = "unassigned"


@dataclass(frozen=True)
class _Counts:
    n: int
    used: int
    not_good: int | None
    left_out: tuple[LeftOut, ...]


@dataclass(frozen=True)
class _Domains:
    domains: Mapping[str, DomainFigures] | None
    one_axis: OneAxisFigures | None


@dataclass(frozen=True)
class _Reading:
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


# The last of the bases has the first of the fields.
@dataclass(frozen=True, repr=False)
class TableFold(PrintableResult, _Reading, _Domains, AxisFigures, _Counts):
    """Fold axis of a table's planes. The figures of the axis are those of `FoldAxis`.

    Parameters
    ----------
    n, used : int
        Number of rows, and of rows that were used.
    not_good : int or None
        Number of used planes whose verdict is not good; None if no plane has a verdict.
    left_out : tuple of LeftOut
        Rows that were not used, with the reasons.
    domains : mapping or None
        Axis of each domain; None if no column of domains was given.
    one_axis : OneAxisFigures or None
        Whether one axis serves all domains.
    convention : str
        Convention by which the table was read.
    dropped_lines : tuple of int
        Lines of the table without angles.
    warnings : tuple of Finding
        Warnings about the table and findings about the axis.
    """


def table_fold(table: OrientationRows, options: FoldOptions | None = None) -> TableFold:
    """Compute the fold axis of a table's planes.

    Raises
    ------
    GeometryError
        If the planes have no axis.
    UsageError
        For a kind, set or column that is missing.
    """
    options = FoldOptions() if options is None else options
    sets = None if options.sets is None else set_names(options.sets)
    domain, waviness_deg = options.by, options.waviness_deg
    which = FoldFilter(options.quality, options.only_set)
    choice = _Choice(table)
    axis = choice.find_axis(options.kind, sets, waviness_deg, which)
    domains, one_axis = None, None
    if domain is not None:
        domains, one_axis = _domains(table, choice, axis, domain, waviness_deg)
        axis = apply_domain_verdict(axis, one_axis)
    figures = {f.name: getattr(axis.figures, f.name) for f in fields(AxisFigures)}
    worst = axis.leave_one_out
    if worst is not None:
        rows = np.flatnonzero(choice.use)
        figures["leave_one_out"] = replace(worst, id=str(table.ids[rows[worst.index]]))
    return TableFold(
        n=len(table),
        used=int(choice.use.sum()),
        not_good=choice.not_good,
        left_out=tuple(choice.left_out),
        **figures,
        domains=domains,
        one_axis=one_axis,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(
            *table.warnings,
            *not_good_warning(choice.not_good, int(choice.use.sum())),
        ),
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
            Finding("fold.one-domain", column=column),
            file=table.path,
            field="--by",
        )
    beds = {
        name: (table.dip_direction_deg[rows], table.dip_deg[rows]) for name, rows in members.items()
    }
    return domain_axes(beds, axis, waviness_deg)


def set_names(text: str) -> list[str]:
    """Return the names of two or more different sets, such as A,B. Raises UsageError."""
    names = [name.strip() for name in text.split(",")]
    if len(names) < 2 or not all(names) or len({n.casefold() for n in names}) < len(names):
        raise UsageError(Finding("fold.too-few-sets"), field="--sets")
    return names


def fold_of_table(
    table: OrientationRows,
    which: FoldFilter,
    turn: Callable[[FloatArray], FloatArray] | None = None,
) -> tuple[FoldAxis, int | None]:
    """Return the fold axis that `table_fold` describes, and how many of its planes are not good.

    Parameters
    ----------
    table : OrientationRows
    which : FoldFilter
    turn : callable or None
        Turns normals (n, 3), as a net is turned; registrations then count no more.

    Raises
    ------
    GeometryError, UsageError
        As `table_fold`.
    """
    choice = _Choice(table)
    axis = choice.find_axis(None, None, None, which, turn)
    return axis, choice.not_good


def not_good_warning(not_good: int | None, used: int) -> list[Finding]:
    """Report planes that are not good among those of a fold axis."""
    return [Finding("fold.planes-not-good", not_good=not_good, used=used)] if not_good else []


class _Choice:
    """Which planes of a table are used, and what was left out and why."""

    def __init__(self, table: OrientationRows) -> None:
        self.table = table
        self.use: BoolArray = np.ones(len(table), dtype=bool)
        self.left_out: list[LeftOut] = []
        self.not_good: int | None = None

    def find_axis(
        self,
        kind: str | None,
        sets: Sequence[str] | None,
        waviness_deg: float | None,
        which: FoldFilter,
        turn: Callable[[FloatArray], FloatArray] | None = None,
    ) -> FoldAxis:
        """Return the axis of the planes, or of the named sets."""
        self.planes_only()
        # A column of kinds that says nothing, as `fit` writes it, is no table with kinds.
        has_kinds = self.table.kinds is not None and any(self.table.kinds)
        if kind is not None or (sets is None and has_kinds):
            self.one_kind(kind)
        self.filtered(which)
        try:
            axis = self.axis(waviness_deg, turn) if sets is None else self.common_axis(sets)
        except GeometryError as error:
            raise GeometryError(cause_of(error), file=self.table.path, field=error.field) from error
        self.not_good = choose_planes(*self._judged(self.use), FoldFilter()).not_good
        return axis

    def filtered(self, which: FoldFilter) -> None:
        """Keep one set and verdicts that are good enough, and picks where there are any."""
        table = self.table
        qualities, sets = self._judged(self.use)
        if which.min_quality is not None and not any(qualities):
            raise self._error(Finding("fold.no-verdicts", option="--quality"), "--quality")
        if which.set_name is not None and not any(_same(s, which.set_name) for s in sets):
            present = sorted(set(sets) - {""})
            finding = Finding("sets.unknown", set=which.set_name, sets=present or None)
            raise self._error(finding, "--only-set")
        chosen = choose_planes(qualities, sets, which)
        self.left_out += chosen.left_out
        rows = np.flatnonzero(self.use)
        self.use = np.zeros(len(table), bool)
        self.use[rows[chosen.use]] = True
        if not self.use.any():
            finding = Finding("fold.none-good-enough", quality=which.min_quality)
            raise self._error(finding, "--quality")

    def _judged(self, use: BoolArray) -> tuple[list[str], list[str]]:
        """Verdicts and sets of these rows, "" for none."""
        table, rows = self.table, np.flatnonzero(use)
        try:
            words = table.column("quality")
        except UsageError:
            words = [""] * len(table)
        sets = table.sets or ("",) * len(table)
        return [verdict_in(words[i]) for i in rows], [sets[i] for i in rows]

    def planes_only(self) -> None:
        lines = int((~self.table.is_plane).sum())
        if lines:
            self.left_out.append(LeftOut("lines", lines, Finding("fold.only-planes")))
            self.use &= self.table.is_plane
        if not self.use.any():
            raise self._error(Finding("orientation.no-planes"), "element")

    def one_kind(self, wanted: str | None) -> None:
        """Keep one kind: cross joints among beds would turn beta by up to 90 degrees."""
        kinds = self.table.kinds
        if kinds is None:
            raise self._error(Finding("fold.no-column", columns="kind", option="--kind"), "--kind")
        name = wanted or DEFAULT_KIND
        present = Counter(kind for kind, use in zip(kinds, self.use, strict=True) if use)
        if not any(_same(kind, name) for kind in present):
            listed = [kind or "(empty)" for kind in present]
            raise self._error(Finding("fold.unknown-kind", kind=name, kinds=listed), "kind")
        for i, kind in enumerate(kinds):
            self.use[i] &= _same(kind, name)
        for kind, n in present.items():
            if not _same(kind, name):
                what = kind or "no kind"
                self.left_out.append(LeftOut(what, n, Finding("fold.only-kind", kind=name)))

    def axis(
        self, waviness_deg: float | None, turn: Callable[[FloatArray], FloatArray] | None = None
    ) -> FoldAxis:
        turns = None if self.table.turns is None else self.table.turns.of(self.use)
        azimuth, dip = self.table.dip_direction_deg[self.use], self.table.dip_deg[self.use]
        if turn is not None:
            azimuth, dip, _ = normals_to_planes(turn(planes_to_normals(azimuth, dip)))
            turns = None
        return fold_axis(
            azimuth,
            dip,
            turns,
            self.table.bowed_deg,
            waviness_deg,
            [str(id_) for id_ in np.asarray(self.table.ids)[self.use]],
            self._overturned(),
        )

    def _overturned(self) -> BoolArray | None:
        """Of the planes used; None where the table says nothing of it."""
        flags = self.table.overturned
        if flags is None:
            return None
        return np.array([flag is True for flag in flags])[self.use]

    def common_axis(self, names: Sequence[str]) -> FoldAxis:
        """Each set by its mean, once."""
        given = self.table.sets or self.table.kinds
        if given is None:
            finding = Finding("fold.no-column", columns=("set", "kind"), option="--sets")
            raise self._error(finding, "--sets")
        present = Counter(name for name, use in zip(given, self.use, strict=True) if use)
        chosen: dict[str, tuple[FloatArray, FloatArray]] = {}
        turns: dict[str, Turns] = {}
        used = np.zeros(len(self.table), dtype=bool)
        for name in names:
            members = self.use & np.array([_same(s, name) for s in given], dtype=bool)
            if not members.any():
                listed = [s or "(empty)" for s in present]
                raise self._error(Finding("sets.unknown", set=name, sets=listed), "--sets")
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
                self.left_out.append(LeftOut(what, n, Finding("fold.only-named-sets")))
        self.use = used
        return common_axis(chosen, turns or None)

    def _error(self, finding: Finding, field: str) -> UsageError:
        return UsageError(finding, file=self.table.path, field=field)


def _same(a: str, b: str) -> bool:
    return a.strip().casefold() == b.strip().casefold()
