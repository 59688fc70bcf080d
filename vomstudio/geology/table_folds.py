"""Fold axis of the planes of a table, for `vomstudio fold`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.common_axes import common_axis
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.domains import (
    DomainFigures,
    OneAxisTest,
    apply_domain_verdict,
    domain_axes,
)
from vomstudio.geology.fold_options import FoldOptions
from vomstudio.geology.fold_planes import ExcludedRows, FoldFilter, parse_verdict, select_planes
from vomstudio.geology.folding.figures import AxisFigures
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.orientation import normals_to_planes, planes_to_normals
from vomstudio.geology.orientation_rows import OrientationRows

DEFAULT_KIND = "bedding"
UNASSIGNED_NAME = "unassigned"


@dataclass(frozen=True)
class _Counts:
    n: int
    used: int
    not_good: int | None
    left_out: tuple[ExcludedRows, ...]


@dataclass(frozen=True)
class _Domains:
    domains: Mapping[str, DomainFigures] | None
    one_axis: OneAxisTest | None


@dataclass(frozen=True)
class _TableProperties:
    convention: str
    dropped_lines: tuple[int, ...]
    warnings: tuple[Finding, ...]


# The fields of the last base class precede those of the other base classes.
@dataclass(frozen=True, repr=False)
class TableFold(PrintableResult, _TableProperties, _Domains, AxisFigures, _Counts):
    """Fold axis of the planes of a table. See `FoldAxis` for the figures of the axis.

    Parameters
    ----------
    n, used : int
        Total number of rows, and number of rows used.
    not_good : int or None
        Number of planes used whose verdict is not good; None if no plane has a verdict.
    left_out : tuple of ExcludedRows
        Rows that were not used, and the reasons.
    domains : mapping or None
        Axis of each domain; None if no domain column was given.
    one_axis : OneAxisTest or None
        Result of the test whether a single axis fits all domains.
    convention : str
        Convention by which the table was interpreted.
    dropped_lines : tuple of int
        Line numbers of the table that contain no angles.
    warnings : tuple of Finding
        Warnings about the table and findings about the axis.
    """


def table_fold(table: OrientationRows, options: FoldOptions | None = None) -> TableFold:
    """Compute the fold axis of the planes of a table.

    Raises
    ------
    GeometryError
        If the planes have no axis.
    UsageError
        If a kind, set or column is missing, if no planes are selected, or if there are fewer than
        two domains.
    """
    options = FoldOptions() if options is None else options
    sets = None if options.sets is None else set_names(options.sets)
    domain_column, waviness_deg = options.by, options.waviness_deg
    fold_filter = FoldFilter(options.quality, options.only_set)
    selection = _Selection(table)
    axis = selection.find_axis(options.kind, sets, waviness_deg, fold_filter)
    domains, one_axis = None, None
    if domain_column is not None:
        domains, one_axis = _domains(table, selection, axis, domain_column, waviness_deg)
        axis = apply_domain_verdict(axis, one_axis)
    figures = {field.name: getattr(axis.figures, field.name) for field in fields(AxisFigures)}
    influential_plane = axis.leave_one_out
    if influential_plane is not None:
        rows = np.flatnonzero(selection.is_used)
        figures["leave_one_out"] = replace(
            influential_plane, id=str(table.ids[rows[influential_plane.index]])
        )
    return TableFold(
        n=len(table),
        used=int(selection.is_used.sum()),
        not_good=selection.not_good,
        left_out=tuple(selection.left_out),
        **figures,
        domains=domains,
        one_axis=one_axis,
        convention=table.convention,
        dropped_lines=tuple(table.dropped),
        warnings=(
            *table.warnings,
            *not_good_warning(selection.not_good, int(selection.is_used.sum())),
        ),
    )


def _domains(
    table: OrientationRows,
    selection: _Selection,
    axis: FoldAxis,
    column: str,
    waviness_deg: float | None,
) -> tuple[dict[str, DomainFigures], OneAxisTest]:
    names = table.column(column)
    members: dict[str, list[int]] = {}
    for i in np.flatnonzero(selection.is_used):
        members.setdefault(names[i].strip() or UNASSIGNED_NAME, []).append(int(i))
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
    """Parse the names of two or more distinct sets, such as A,B.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of str

    Raises
    ------
    UsageError
        If there are fewer than two names, or if a name is repeated.
    """
    names = [name.strip() for name in text.split(",")]
    if len(names) < 2 or not all(names) or len({name.casefold() for name in names}) < len(names):
        raise UsageError(Finding("fold.too-few-sets"), field="--sets")
    return names


def fold_axis_of_table(
    table: OrientationRows,
    fold_filter: FoldFilter,
    rotate: Callable[[FloatArray], FloatArray] | None = None,
) -> tuple[FoldAxis, int | None]:
    """Return the fold axis of `table_fold` and the number of its planes that are not good.

    Parameters
    ----------
    table : OrientationRows
    fold_filter : FoldFilter
    rotate : callable or None
        Function that rotates normals (n, 3) like a rotated net; registrations are then ignored.

    Returns
    -------
    axis : FoldAxis
    not_good : int or None
        Number of planes used whose verdict is not good; None if no plane has a verdict.

    Raises
    ------
    GeometryError, UsageError
        See `table_fold`.
    """
    selection = _Selection(table)
    axis = selection.find_axis(None, None, None, fold_filter, rotate)
    return axis, selection.not_good


def not_good_warning(n_not_good: int | None, n_used: int) -> list[Finding]:
    """Report the planes of a fold axis whose verdict is not good.

    Parameters
    ----------
    n_not_good : int or None
        Number of planes whose verdict is not good; None if unknown.
    n_used : int
        Number of planes used.

    Returns
    -------
    list of Finding
    """
    return [Finding("fold.planes-not-good", not_good=n_not_good, used=n_used)] if n_not_good else []


class _Selection:
    """Selection of planes of a table, with the excluded rows and the reasons."""

    def __init__(self, table: OrientationRows) -> None:
        self.table = table
        self.is_used: BoolArray = np.ones(len(table), dtype=bool)
        self.left_out: list[ExcludedRows] = []
        self.not_good: int | None = None

    def find_axis(
        self,
        kind: str | None,
        sets: Sequence[str] | None,
        waviness_deg: float | None,
        fold_filter: FoldFilter,
        rotate: Callable[[FloatArray], FloatArray] | None = None,
    ) -> FoldAxis:
        """Return the axis of the selected planes, or of the named sets.

        Raises GeometryError if they have no axis, and UsageError if no planes are selected.
        """
        self.exclude_lines()
        # Ignore an empty column of kinds, as written by `fit`.
        has_kinds = self.table.kinds is not None and any(self.table.kinds)
        if kind is not None or (sets is None and has_kinds):
            self.select_kind(kind)
        self.apply_filter(fold_filter)
        try:
            axis = self.axis(waviness_deg, rotate) if sets is None else self.common_axis(sets)
        except GeometryError as error:
            raise GeometryError(
                cause_finding(error), file=self.table.path, field=error.field
            ) from error
        self.not_good = select_planes(*self._verdicts_and_sets(self.is_used), FoldFilter()).not_good
        return axis

    def apply_filter(self, fold_filter: FoldFilter) -> None:
        """Select the planes that pass the filter for sets and verdicts."""
        table = self.table
        qualities, sets = self._verdicts_and_sets(self.is_used)
        if fold_filter.min_quality is not None and not any(qualities):
            raise self._error(Finding("fold.no-verdicts", option="--quality"), "--quality")
        if fold_filter.set_name is not None and not any(
            _are_equal_names(set_, fold_filter.set_name) for set_ in sets
        ):
            present_sets = sorted(set(sets) - {""})
            finding = Finding("sets.unknown", set=fold_filter.set_name, sets=present_sets or None)
            raise self._error(finding, "--only-set")
        selected_planes = select_planes(qualities, sets, fold_filter)
        self.left_out += selected_planes.left_out
        rows = np.flatnonzero(self.is_used)
        self.is_used = np.zeros(len(table), bool)
        self.is_used[rows[selected_planes.is_used]] = True
        if not self.is_used.any():
            finding = Finding("fold.none-good-enough", quality=fold_filter.min_quality)
            raise self._error(finding, "--quality")

    def _verdicts_and_sets(self, is_used: BoolArray) -> tuple[list[str], list[str]]:
        """Return the verdicts and sets of the selected rows; "" if missing."""
        table, rows = self.table, np.flatnonzero(is_used)
        try:
            words = table.column("quality")
        except UsageError:
            words = [""] * len(table)
        sets = table.sets or ("",) * len(table)
        return [parse_verdict(words[i]) for i in rows], [sets[i] for i in rows]

    def exclude_lines(self) -> None:
        lines = int((~self.table.is_plane).sum())
        if lines:
            self.left_out.append(ExcludedRows("lines", lines, Finding("fold.only-planes")))
            self.is_used &= self.table.is_plane
        if not self.is_used.any():
            raise self._error(Finding("orientation.no-planes"), "element")

    def select_kind(self, requested_kind: str | None) -> None:
        """Select one kind: cross joints among beds would rotate beta by up to 90 degrees."""
        kinds = self.table.kinds
        if kinds is None:
            raise self._error(Finding("fold.no-column", columns="kind", option="--kind"), "--kind")
        name = requested_kind or DEFAULT_KIND
        present_kinds = Counter(
            kind for kind, is_used in zip(kinds, self.is_used, strict=True) if is_used
        )
        if not any(_are_equal_names(kind, name) for kind in present_kinds):
            listed_kinds = [kind or "(empty)" for kind in present_kinds]
            raise self._error(Finding("fold.unknown-kind", kind=name, kinds=listed_kinds), "kind")
        for i, kind in enumerate(kinds):
            self.is_used[i] &= _are_equal_names(kind, name)
        for kind, n in present_kinds.items():
            if not _are_equal_names(kind, name):
                kind_name = kind or "no kind"
                self.left_out.append(
                    ExcludedRows(kind_name, n, Finding("fold.only-kind", kind=name))
                )

    def axis(
        self, waviness_deg: float | None, rotate: Callable[[FloatArray], FloatArray] | None = None
    ) -> FoldAxis:
        selected_rotation_errors = (
            None
            if self.table.rotation_errors is None
            else self.table.rotation_errors.of(self.is_used)
        )
        azimuth, dip = self.table.dip_direction_deg[self.is_used], self.table.dip_deg[self.is_used]
        if rotate is not None:
            azimuth, dip, _ = normals_to_planes(rotate(planes_to_normals(azimuth, dip)))
            selected_rotation_errors = None
        return fold_axis(
            azimuth,
            dip,
            selected_rotation_errors,
            self.table.bowed_deg,
            waviness_deg,
            [str(id_) for id_ in np.asarray(self.table.ids)[self.is_used]],
            self._overturned(),
        )

    def _overturned(self) -> BoolArray | None:
        """Return the overturned flags of the planes used, or None if the table has no flags."""
        flags = self.table.overturned
        if flags is None:
            return None
        return np.array([flag is True for flag in flags])[self.is_used]

    def common_axis(self, names: Sequence[str]) -> FoldAxis:
        """Return the common axis of sets, each represented by its mean with equal weight."""
        names_by_row = self.table.sets or self.table.kinds
        if names_by_row is None:
            finding = Finding("fold.no-column", columns=("set", "kind"), option="--sets")
            raise self._error(finding, "--sets")
        present_sets = Counter(
            name for name, is_used in zip(names_by_row, self.is_used, strict=True) if is_used
        )
        attitudes: dict[str, tuple[FloatArray, FloatArray]] = {}
        rotation_errors: dict[str, RotationErrors] = {}
        is_used = np.zeros(len(self.table), dtype=bool)
        for name in names:
            members = self.is_used & np.array(
                [_are_equal_names(row_name, name) for row_name in names_by_row], dtype=bool
            )
            if not members.any():
                listed_sets = [present_set or "(empty)" for present_set in present_sets]
                raise self._error(Finding("sets.unknown", set=name, sets=listed_sets), "--sets")
            attitudes[name] = (
                self.table.dip_direction_deg[members],
                self.table.dip_deg[members],
            )
            if self.table.rotation_errors is not None:
                rotation_errors[name] = self.table.rotation_errors.of(members)
            is_used |= members
        for name, n in present_sets.items():
            if not any(_are_equal_names(name, requested_name) for requested_name in names):
                set_name_text = name or "no set"
                self.left_out.append(
                    ExcludedRows(set_name_text, n, Finding("fold.only-named-sets"))
                )
        self.is_used = is_used
        return common_axis(attitudes, rotation_errors or None)

    def _error(self, finding: Finding, field: str) -> UsageError:
        return UsageError(finding, file=self.table.path, field=field)


def _are_equal_names(first_name: str, second_name: str) -> bool:
    return first_name.strip().casefold() == second_name.strip().casefold()
