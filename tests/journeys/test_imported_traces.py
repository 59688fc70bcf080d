"""Traces of another program, imported in the window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt

from tests import driver
from tests.driver import key
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.commands.feature_import import FeatureListImport


def test_traces_of_a_table_are_added_in_one_step(window, outcrop, picks, tmp_path: Path) -> None:
    driver.open_outcrop(window, outcrop)
    studio = window.studio
    table = tmp_path / "digitised.csv"
    rows = [
        f"{x},{y},{z},{name},Joint" for name in ("B01", "B02") for x, y, z in picks[name].tolist()
    ]
    table.write_text("\n".join(["x,y,z,trace,type", *rows, "0,0,0,far,Joint", "1,0,0,far,Joint"]))
    assert window.actions_table.all["import_listed"].isEnabled()
    FeatureListImport(window, studio).import_file(table)
    driver.wait(lambda: len(studio.session.of(Trace)) == 2, "the traces")
    traces = studio.session.of(Trace)
    assert [trace.name for trace in traces] == ["B01", "B02"]
    assert {trace.type_id for trace in traces} == {"joint"}
    assert all(trace.resolution is not None for trace in traces)
    assert set(studio.selection.ids) == {trace.id for trace in traces}
    assert window.table.model.rowCount() == 2
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert studio.session.of(Trace) == []
