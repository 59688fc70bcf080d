"""What was looked at, in the real window: a grid over the face, marked by clicks and keys."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.driver import LEFT, NONE, wait
from tests.messages import figures, shown_codes
from vomstudio.cli.common.entry import main
from vomstudio.geology.coverage.cells import measure_faces
from vomstudio.project import grid_edits
from vomstudio.project.grid_edits import grid_marks
from vomstudio.project.records import FaceGrid, Model
from vomstudio.studio.surfaces.face_grids import world_grid
from vomstudio.studio.tools.cells import CellsTool
from vomstudio.ui.panels.coverage.coverage_panel import CoveragePanel
from vomstudio.ui.panels.tools.cells import CellsPanel


def press(button) -> None:
    QTest.mouseClick(button, LEFT, NONE, button.rect().center())


def settle(panel) -> None:
    driver.pause(200)
    wait(lambda: not panel._requests.is_waiting and not panel._timer.isActive(), "the figures")


def grid_of(window) -> FaceGrid:
    (grid,) = window.studio.session.of(FaceGrid)
    return grid


def middles(window) -> dict[int, np.ndarray]:
    """A World point on the surface in each cell that holds some of it, near its middle."""
    grid = grid_of(window)
    exposure = window.studio.workspace.grids.exposure(grid.id)
    cells = world_grid(grid, window.studio.records[grid.model_id])
    found = {}
    for cell in np.unique(exposure.cell).tolist():
        own = exposure.pieces[exposure.cell == cell].mean(axis=1)
        row, column = divmod(cell, grid.columns)
        near = own[np.abs(own[:, :2] - [column + 0.5, row + 0.5]).max(axis=1).argmin()]
        axes = np.stack([cells.right, cells.up, cells.normal])
        found[cell] = cells.origin + cells.cell * near @ axes
    return found


@pytest.fixture
def laid(window, outcrop):
    """A grid over the whole face, as it is looked at."""
    driver.open_outcrop(window, outcrop)
    window.actions_table.run("looked_at")
    panel = window.findChild(CoveragePanel)
    assert not panel.visibleRegion().isEmpty()
    settle(panel)
    assert shown_codes(panel.figures.placeholder) == {"grid.not-begun"}
    assert not panel.figures.toPlainText()
    press(panel.create_button)
    wait(lambda: window.studio.session.of(FaceGrid), "the grid")
    wait(lambda: window.studio.workspace.grids.exposure(grid_of(window).id), "its cells")
    settle(panel)
    return panel


@pytest.mark.full
def test_cells_are_marked_by_clicks_and_keys_and_counted(window, laid) -> None:
    panel, studio = laid, window.studio
    assert studio.tool_name == CellsTool.name
    grid = grid_of(window)
    exposure = studio.workspace.grids.exposure(grid.id)
    # The whole model faces the viewer or away from him: all of it lies in some cell.
    model = studio.session.of(Model)[0]
    data = studio.models[model.id].data
    alone = measure_faces(world_grid(grid, model), data.vertices, data.faces)
    assert exposure.covered.sum() == pytest.approx(alone.covered.sum())
    assert panel.result.cells == (exposure.covered > 0).sum()
    places = middles(window)
    # Those in the middle of the face, which nothing hides.
    one, two, three, four = sorted(
        (c for c in places if exposure.covered[c] > 0.99 * grid.cell**2),
        key=lambda c: np.linalg.norm(places[c] - np.mean(list(places.values()), axis=0)),
    )[:4]
    viewport = window.viewport
    driver.focus(window)
    driver.click(viewport, driver.pixel(window, places[one]))
    assert grid_marks(grid_of(window))[one] == "d"
    driver.move(viewport, driver.pixel(window, places[two]))
    driver.key(window, Qt.Key.Key_W)
    driver.move(viewport, driver.pixel(window, places[three]))
    driver.key(window, Qt.Key.Key_X)
    driver.click(viewport, driver.pixel(window, places[four]))
    marks = grid_marks(grid_of(window))
    assert [marks[c] for c in (one, two, three, four)] == ["d", "e", "u", "u"]
    # A second click takes the mark away, and undo brings it back.
    QTest.qWait(600)
    driver.click(viewport, driver.pixel(window, places[four]))
    assert grid_marks(grid_of(window))[four] == "-"
    studio.undo()
    assert grid_marks(grid_of(window))[four] == "u"
    settle(panel)
    found = panel.result
    assert (found.done.cells, found.empty.cells, found.unmeasurable.cells) == (1, 1, 2)
    assert found.looked_at_share == pytest.approx(
        exposure.covered[[one, two, three, four]].sum() / exposure.covered.sum()
    )
    assert found.counted_m2 == pytest.approx(exposure.covered[[one, two]].sum())
    left_out = [2, round(100.0 * found.unmeasurable.share)]
    assert left_out in [figures(line)[:2] for line in panel.figures.toPlainText().splitlines()]
    told = driver.tool_panel(window, CellsPanel).count.text()
    assert figures(told) == [4, grid.columns * grid.rows]
    wait(lambda: viewport.is_still, "the picture")
    driver.keep_picture(window, "looked_at")
    press(panel.remove)
    assert not studio.session.of(FaceGrid)
    assert not any(key.startswith(grid.id) for key in viewport.features.drawings)
    studio.undo()
    assert grid_marks(grid_of(window)) == marks
    wait(lambda: any(key.startswith(grid.id) for key in viewport.features.drawings), "the cells")


@pytest.mark.full
def test_command_matches_the_panel_figures(window, laid, tmp_path, capfd) -> None:
    panel, studio = laid, window.studio
    grid = grid_of(window)
    assert studio.attempt(grid_edits.mark_cells, grid.id, range(grid.columns), "e")
    settle(panel)
    folder = tmp_path / "looked.vom"
    studio.save_as(folder)
    wait(lambda: studio.project.folder == folder, "the saved project")
    settle(panel)
    mine = panel.result.to_dict()
    studio.new_project()
    capfd.readouterr()
    assert main(["project", str(folder), "coverage", "--json"]) == 0
    (told,) = json.loads(capfd.readouterr().out)["grids"]
    assert told["name"] == "Grid 1"
    for key in ("cells", "cell_m", "looked_at_share", "counted_m2", "P21_1_per_m"):
        assert told[key] == pytest.approx(mine[key]), key
    assert told["empty"] == pytest.approx(mine["empty"])
