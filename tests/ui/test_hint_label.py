"""The hint of the status line ends with a clause, whatever its width."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from vomstudio.ui.base.controls import HintLabel

HINT = "Plane: click it, or paint 1.5 m of it. The right button orbits."


def test_clauses_that_do_not_fit_are_left_out(qapp: QApplication) -> None:
    label = HintLabel()
    wide = label.fontMetrics().horizontalAdvance
    parts = {
        label.shorten(HINT, width) for width in range(wide("Plane: click it."), wide(HINT) + 1)
    }
    assert parts == {"Plane: click it.", "Plane: click it, or paint 1.5 m of it.", HINT}
    for width in range(wide("Plane: click it."), wide(HINT)):
        assert wide(label.shorten(HINT, width)) <= width


def test_a_word_without_a_clause_is_elided(qapp: QApplication) -> None:
    label = HintLabel()
    assert label.shorten(HINT, 40).endswith("…")
