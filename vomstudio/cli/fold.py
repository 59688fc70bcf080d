"""`vomstudio fold`: pi-plane and fold axis, or the axis common to several sets."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from vomstudio.cli import text_tables
from vomstudio.cli.arguments import Subparsers, add_azimuth, add_command
from vomstudio.cli.output import Output
from vomstudio.errors import GeometryError, UsageError, VomError
from vomstudio.words import tr

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from vomstudio.geology.folds import FoldAxis
    from vomstudio.io.text.orientation_reading import OrientationTable

DEFAULT_KIND = "bedding"


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "fold", run, help_=tr("Pi-plane, fold axis beta and its verdict")
    )
    parser.add_argument("table", metavar="TABLE", help=tr("table of planes"))
    parser.add_argument(
        "--kind",
        help=tr(
            "use planes of this kind only (default {DEFAULT_KIND}, if the table has kinds)",
            DEFAULT_KIND=DEFAULT_KIND,
        ),
    )
    parser.add_argument(
        "--sets",
        metavar="A,B[,C]",
        help=tr("the axis common to these sets (hanging wall, footwall, fault), by their means"),
    )
    add_azimuth(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    axis, choice = axis_of(args.table, args.azimuth, args.kind, args.sets)
    table = choice.table
    used = int(choice.use.sum())
    result = {
        "n": len(table),
        "used": used,
        "left_out": choice.left_out,
        **axis.as_dict(),
        "convention": table.convention,
        "dropped_lines": list(table.dropped),
        "warnings": list(table.warnings),
    }
    out.result(result)
    out.note(f"read as {table.convention}")
    out.warn(table.warnings)
    out.text(_in_words(result))


def axis_of(
    path: str,
    azimuth: Literal["strike", "dipdir"] | None = None,
    kind: str | None = None,
    sets: str | None = None,
) -> tuple[FoldAxis, Choice]:
    """The axis of a table's planes, and which of them were used; for every command that takes a
    table for a fold."""
    from vomstudio.io.text.orientation_reading import read_orientations

    table = read_orientations(path, azimuth)
    choice = Choice(table)
    choice.planes_only()
    # A column of kinds that says nothing, as `fit` writes it, is no table with kinds.
    has_kinds = table.kinds is not None and any(table.kinds)
    if kind is not None or (sets is None and has_kinds):
        choice.one_kind(kind)
    try:
        axis = choice.axis() if sets is None else choice.common_axis(_names(sets))
    except GeometryError as error:
        raise GeometryError(error.message, file=path, field=error.field) from error
    return axis, choice


class Choice:
    """Which planes of a table are used, and what was left out and why."""

    def __init__(self, table: OrientationTable) -> None:
        import numpy as np

        self.table = table
        self.use: NDArray[np.bool_] = np.ones(len(table), dtype=bool)
        self.left_out: list[dict[str, Any]] = []

    def planes_only(self) -> None:
        lines = int((~self.table.is_plane).sum())
        if lines:
            self.left_out.append({"what": "lines", "n": lines, "reason": "not planes"})
            self.use &= self.table.is_plane
        if not self.use.any():
            raise self._error("there are only lines in it; a fold axis needs planes.", "geometry")

    def one_kind(self, wanted: str | None) -> None:
        """Keep one kind: cross joints among beds would turn beta by up to 90 degrees."""
        kinds = self.table.kinds
        if kinds is None:
            raise self._error("there is no column of kinds to choose from.", "--kind")
        name = wanted or DEFAULT_KIND
        present = Counter(kind for kind, use in zip(kinds, self.use, strict=True) if use)
        if not any(_same(kind, name) for kind in present):
            listed = ", ".join(kind or "(empty)" for kind in present)
            raise self._error(
                f"no plane is of the kind '{name}'; choose one with --kind: {listed}.", "kind"
            )
        for i, kind in enumerate(kinds):
            self.use[i] &= _same(kind, name)
        for kind, n in present.items():
            if not _same(kind, name):
                what = kind or "no kind"
                self.left_out.append({"what": what, "n": n, "reason": f"kind is not {name}"})

    def axis(self) -> FoldAxis:
        from vomstudio.geology.folds import fold_axis

        return fold_axis(self.table.dip_direction_deg[self.use], self.table.dip_deg[self.use])

    def common_axis(self, names: Sequence[str]) -> FoldAxis:
        """Each set by its mean, once."""
        import numpy as np

        from vomstudio.geology.folds import common_axis

        given = self.table.sets or self.table.kinds
        if given is None:
            raise self._error("there is no column 'set' or 'kind' to choose from.", "--sets")
        present = Counter(name for name, use in zip(given, self.use, strict=True) if use)
        chosen: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        used = np.zeros(len(self.table), dtype=bool)
        for name in names:
            members = self.use & np.array([_same(s, name) for s in given], dtype=bool)
            if not members.any():
                listed = ", ".join(s or "(empty)" for s in present)
                raise self._error(
                    f"no plane is in the set '{name}'; the sets are {listed}.", "--sets"
                )
            chosen[name] = (
                self.table.dip_direction_deg[members],
                self.table.dip_deg[members],
            )
            used |= members
        for name, n in present.items():
            if not any(_same(name, wanted) for wanted in names):
                what = name or "no set"
                self.left_out.append({"what": what, "n": n, "reason": "set was not named"})
        self.use = used
        return common_axis(chosen)

    def _error(self, message: str, field: str) -> VomError:
        return UsageError(message, file=self.table.table.path, field=field)


def _names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if len(names) < 2 or not all(names) or len({n.casefold() for n in names}) < len(names):
        raise UsageError(tr("name two or three different sets, as in --sets A,B."), field="--sets")
    return names


def _same(a: str, b: str) -> bool:
    return a.strip().casefold() == b.strip().casefold()


def _in_words(result: dict[str, Any]) -> str:
    beta, plane = result["beta"], result["pi_plane"]
    confidence = "undefined"
    if beta["max_confidence95_deg"] is not None:
        confidence = (
            f"{beta['max_confidence95_deg']:.1f} x {beta['min_confidence95_deg']:.1f} deg "
            "(semi-axes, joint 95 %)"
        )
    lines = [
        f"planes used   {result['used']} of {result['n']}",
        *(f"  left out    {o['n']} {o['what']} ({o['reason']})" for o in result["left_out"]),
        f"beta          {text_tables.line(beta)}  trend/plunge, deg",
        f"  confidence  {confidence}",
        f"pi-plane      {text_tables.azimuth(plane['dip_direction_deg'])}/"
        f"{text_tables.inclination(plane['dip_deg'])} dip direction/dip = "
        f"{text_tables.azimuth(plane['strike_rhr_deg'])}/"
        f"{text_tables.inclination(plane['dip_deg'])} "
        "strike (RHR)/dip, deg",
        f"verdict       {result['verdict']}; view along beta valid: {result['valid']}",
        *(f"  - {reason}" for reason in result["reasons"]),
    ]
    return "\n".join(lines)
