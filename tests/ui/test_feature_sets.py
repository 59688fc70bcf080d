"""Symbols of the sets on the net of a project."""

from __future__ import annotations

from dataclasses import replace

import pytest

from vomstudio.products.net.contents import MARKERS, USER_LINE_MARKER, make_sets
from vomstudio.ui.panels.net.feature_sets import distinct_symbols

PLANES = ("plane", [10.0, 20.0], [30.0, 40.0])


@pytest.mark.parametrize("count", [1, 3, 8, 10])
def test_every_set_has_a_symbol_of_its_own(count: int) -> None:
    """Whatever the symbols of their types; none is that of the fold axis or of a typed line."""
    for marker in ("o", "P", "p"):
        sets = [
            replace(s, marker=marker if i % 3 else "D", variant=i)
            for i, s in enumerate(make_sets({str(i): PLANES for i in range(count)}))
        ]
        result = distinct_symbols(sets)
        symbols = [s.marker for s in result]
        assert len(set(symbols)) == count
        assert not {"*", USER_LINE_MARKER, "x", "+"} & set(symbols)
        assert all(s.variant == 0 for s in result)
        # The first set of a type keeps the symbol of the type.
        assert symbols[:2] == ["D", marker][:count]
        assert [s.name for s in result] == [s.name for s in sets]


def test_sets_beyond_the_symbols_differ_by_their_fill() -> None:
    sets = [
        replace(s, marker="o", variant=i)
        for i, s in enumerate(make_sets({str(i): PLANES for i in range(20)}))
    ]
    result = distinct_symbols(sets)
    assert len({s.marker for s in result}) > len(MARKERS)
    assert [s.variant for s in result][-2:] == [18, 19]
