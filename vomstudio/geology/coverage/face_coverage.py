"""How much of a face was looked at, and what was counted there.

A figure per area is worth as much as the area that it is counted over: cells where somebody looked
and found nothing belong to it, cells where nobody looked, or where nothing can be measured, do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import to_translate
from vomstudio.geology.coverage.cells import CellGrid

OPEN, DONE, EMPTY, UNMEASURABLE = "-", "d", "e", "u"
"""What a cell may be: nobody has looked, features were picked, there are none, or none can be
measured there (vegetation, debris, shadow, a hole in the model)."""
TITLES = {
    OPEN: to_translate("not looked at"),
    DONE: to_translate("done"),
    EMPTY: to_translate("empty"),
    UNMEASURABLE: to_translate("unmeasurable"),
}
_THIN = 1e-6


@dataclass(frozen=True)
class Share:
    """cells : of this kind that hold any of the surface; covered_m2 : of them, as they are seen;
    surface_m2 : of the rock in them; share : of the covered area of all cells, None without any"""

    cells: int
    covered_m2: float
    surface_m2: float
    share: float | None


@dataclass(frozen=True, repr=False)
class LookedAt(PrintableResult):
    """Coverage of a face: how much of it was inspected.

    Areas are in the square of the grid's unit, metres in a project.

    not_looked_at, done, empty, unmeasurable : shares; looked_at_share : of the last three together
    contradictions : cells marked as empty in which a feature begins or passes
    features : that reach into cells done or empty; density_1_per_m2 : their middles there over the
        covered area of these cells; P21_1_per_m : length of lines in them, as they are seen, over
        the same. None where no cell is done or empty
    """

    cells: int
    cell_m: float
    not_looked_at: Share
    done: Share
    empty: Share
    unmeasurable: Share
    looked_at_share: float | None
    contradictions: tuple[str, ...]
    features: int
    counted_m2: float
    density_1_per_m2: float | None
    P21_1_per_m: float | None
    reasons: tuple[Finding, ...]


def cell_name(grid: CellGrid, number: int) -> str:
    """A1 is the upper left cell, as on a map; columns go on after Z with AA."""
    row, column = divmod(int(number), grid.columns)
    letters = ""
    column += 1
    while column:
        column, rest = divmod(column - 1, 26)
        letters = chr(65 + rest) + letters
    return f"{letters}{grid.rows - row}"


def looked_at(
    grid: CellGrid,
    marks: str,
    surface: FloatArray,
    covered: FloatArray,
    lines: Sequence[FloatArray] = (),
) -> LookedAt:
    """marks : one of the letters above for each cell; surface, covered : (cells,) as of
    `cells.Exposed`; lines : (k, 3) vertices of each feature, or the one place of it, in the grid's
    frame."""
    kind = np.array(list(marks.ljust(grid.count, OPEN)[: grid.count]))
    there = covered > _THIN * grid.cell**2
    total = float(covered[there].sum())

    def share(mark: str) -> Share:
        own = there & (kind == mark)
        area = float(covered[own].sum())
        return Share(
            int(own.sum()), area, float(surface[own].sum()), area / total if total > 0 else None
        )

    shares = {mark: share(mark) for mark in TITLES}
    counted = there & ((kind == DONE) | (kind == EMPTY))
    area = float(covered[counted].sum())
    lengths = np.zeros(grid.count)
    inside = middles = 0
    denied: set[int] = set()
    for line in lines:
        own = lengths_in_cells(grid, line)
        middle = int(grid.at(_middle(line)[None])[0])
        reaches = {c for c, length in own.items() if counted[c] and length > 0.0}
        if middle >= 0 and counted[middle]:
            middles += 1
            reaches.add(middle)
        inside += bool(reaches)
        denied |= {
            c for c in reaches if kind[c] == EMPTY and (c == middle or own[c] > 0.05 * grid.cell)
        }
        for c, length in own.items():
            lengths[c] += length
    names = tuple(cell_name(grid, c) for c in sorted(denied))
    looked = total - shares[OPEN].covered_m2
    return LookedAt(
        int(there.sum()),
        grid.cell,
        shares[OPEN],
        shares[DONE],
        shares[EMPTY],
        shares[UNMEASURABLE],
        looked / total if total > 0 else None,
        names,
        inside,
        area,
        middles / area if area > 0 else None,
        float(lengths[counted].sum()) / area if area > 0 else None,
        tuple(_share_warnings(shares, names, area)),
    )


def lengths_in_cells(grid: CellGrid, line: FloatArray) -> dict[int, float]:
    """What of a line (k, 3) lies in each cell, as it is seen, in the grid's unit."""
    flat = grid.local(line)[:, :2]
    found: dict[int, float] = {}
    for start, end in pairwise(flat):
        step = end - start
        length = float(np.hypot(*step))
        if not length > 0.0 or not np.isfinite(length):
            continue
        cuts = [np.zeros(1), np.ones(1)]
        for axis, count in ((0, grid.columns), (1, grid.rows)):
            low, high = sorted((start[axis], end[axis]))
            # Only lines of the grid: a line may begin far away from it.
            crossed = np.arange(max(np.ceil(low), 0.0), min(np.floor(high), count) + 1.0)
            if step[axis] != 0.0:
                cuts.append((crossed - start[axis]) / step[axis])
        t = np.unique(np.clip(np.concatenate(cuts), 0.0, 1.0))
        middles = start + ((t[:-1] + t[1:]) / 2.0)[:, None] * step
        cells = grid.numbers(np.floor(middles))
        for cell, part in zip(cells.tolist(), np.diff(t).tolist(), strict=True):
            if cell >= 0:
                found[cell] = found.get(cell, 0.0) + part * length * grid.cell
    return found


def _middle(line: FloatArray) -> FloatArray:
    """(3,) half way along a line."""
    if len(line) == 1:
        return np.asarray(line[0])
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([np.interp(along[-1] / 2.0, along, line[:, i]) for i in range(3)])


def _share_warnings(
    shares: dict[str, Share], denied: tuple[str, ...], counted: float
) -> list[Finding]:
    warnings = []
    if (out := shares[UNMEASURABLE]).cells:
        warnings.append(
            Finding(
                "grid.unmeasurable-cells",
                count=out.cells,
                share_percent=100.0 * (out.share or 0.0),
            )
        )
    if (left := shares[OPEN]).cells and counted > 0.0:
        warnings.append(
            Finding("grid.open-cells", count=left.cells, share_percent=100.0 * (left.share or 0.0))
        )
    if denied:
        warnings.append(Finding("grid.empty-cells-with-features", cells=denied))
    return warnings
