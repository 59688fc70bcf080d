"""Opens every workspace, page and tool and prints, one JSON object a line, what is wrong with it.

Run as a process of its own: the scale of the screen is fixed when Qt starts.
"""

from __future__ import annotations

import faulthandler
import json
import os
import shutil
import sys
from pathlib import Path

from PySide6.QtWidgets import QApplication, QWidget

from tests import appearance, driver
from tests.journeys.conftest import read_picks
from vomstudio.core.paths import resource
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base import theme
from vomstudio.ui.shell.layout import REGIONS, WORKSPACES


def main(folder: Path, width: int, height: int, name: str) -> None:
    """folder : for files; name : of the theme"""
    faulthandler.enable()
    application = QApplication([])
    theme.enlarge_small_font(application)
    window = driver.make_window()
    window.actions_table.run(f"theme_{name}")
    window.move(0, 0)
    window.resize(width, height)

    def describe(place: str, widget: QWidget) -> None:
        driver.pause(100)
        driver.keep_picture(window, f"{place}-{name}-{width}")
        found = appearance.violations(widget)
        print(json.dumps({"place": place, "violations": found}), flush=True)

    describe("start", window)
    shutil.copytree(resource("outcrop"), folder / "models")
    window.open_path(folder / "models" / "outcrop.obj")
    driver.settled(window)
    model = driver.model(window)
    for trace, points in read_picks().items():
        vertices = tuple(map(tuple, points.tolist()))
        record = Trace(trace, trace, "bedding", model.id, model.content_hash, vertices)
        assert window.studio.attempt(edits.add_trace, record)
    for workspace in WORKSPACES:
        window.workspaces.switch(workspace.name)
        describe(f"workspace {workspace.name}", window)
    # The net is a figure, which has tests of its own.
    for page in REGIONS.keys() - {"stereonet"}:
        window.docks.bring_forward(page)
        driver.pause(300)
        describe(f"page {page}", driver.page(window, page))
    for tool in TOOLS:
        window.actions_table.run(tool.name)
        describe(f"tool {tool.name}", window.tool_panel)
    window.studio.cancel_tool()
    driver.dismiss(window)
    del application


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
    sys.stdout.flush()
    os._exit(0)
