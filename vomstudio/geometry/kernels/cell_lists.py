"""Compiled loops over cubic cells that hold points: the points of cell c, which stand sorted, are
points[begins[c]:begins[c + 1]]."""

from __future__ import annotations

from vomstudio.geometry.kernels.jit import kernel


@kernel("i8(i8[::1], i8, i8, i8[::1], i8[::1], i4[::1])")
def near_cells(keys, row, layer, at, starts, near):  # type: ignore[no-untyped-def]
    """The up to 26 cells around each, and how many they are in all: those of cell c become
    near[starts[c]:starts[c + 1]].

    keys : sorted numbers of cells, i + row j + layer k, no cell at an end of a row or layer;
    at : (9,) zeros
    """
    total = 0
    for c in range(len(keys)):
        starts[c] = total
        for turn in range(9):
            first = keys[c] + (turn // 3 - 1) * layer + (turn % 3 - 1) * row - 1
            p = at[turn]
            while p < len(keys) and keys[p] < first:
                p += 1
            at[turn] = p
            while p < len(keys) and keys[p] <= first + 2:
                if p != c:
                    near[total] = p
                    total += 1
                p += 1
    starts[len(keys)] = total
    return total


@kernel("b1(f8[:,::1], i8[::1])")
def has_twins(points, begins):  # type: ignore[no-untyped-def]
    """Whether two points of a cell are at one place."""
    for c in range(len(begins) - 1):
        for a in range(begins[c], begins[c + 1]):
            for b in range(a + 1, begins[c + 1]):
                if (
                    points[a, 0] == points[b, 0]
                    and points[a, 1] == points[b, 1]
                    and points[a, 2] == points[b, 2]
                ):
                    return True
    return False
