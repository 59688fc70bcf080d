"""The window answers every odd frame, as commands do (`tests/cli/test_parity_of_frames.py`).

The table of answers is printed: ``pytest -s -m "" tests/journeys/test_odd_frames_in_window.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

from tests import driver
from tests.cli.test_parity_of_frames import (
    FRAMES,
    ZONE,
    bed,
    write_control,
    write_model,
    write_oriented,
    write_points,
)
from tests.messages import shown_codes
from vomstudio.studio.notices import Notice
from vomstudio.ui.commands.net import import_readings
from vomstudio.ui.dialogs.readings_dialog import ReadingsDialog
from vomstudio.ui.panels.three_points_panel import ThreePointsPanel
from vomstudio.ui.panels.tools.control import ControlPanel

pytestmark = pytest.mark.full

ASKED = "asked"
"""The window asks for the frame."""
TABLE: dict[tuple[str, str], set[str]] = {}


@pytest.fixture(scope="module", autouse=True)
def table() -> Iterator[None]:
    yield
    for (door, frame), answer in TABLE.items():
        print(f"\n{door:24} {frame:20} {', '.join(sorted(answer))}", end="")
    print()


def expect(door: str, frame: str, answer: set[str], *also: str) -> None:
    TABLE[door, frame] = answer
    *_, expected = FRAMES[frame]
    assert answer & (expected | set(also)), f"{door}, {frame}: {answer}"


@pytest.fixture
def notices(window) -> Iterator[list[Notice]]:
    """What the window shows in its message bar, as it comes."""
    told: list[Notice] = []
    window.studio.notice.connect(told.append)
    yield told
    window.studio.notice.disconnect(told.append)


@pytest.fixture
def on_good_model(window, notices, tmp_path: Path) -> None:
    """Open a model with a plain frame, which is asked nothing."""
    window.open_path(write_model(tmp_path / "model", bed(), ZONE))
    driver.settled(window)


def shown(notices: list[Notice]) -> set[str]:
    return shown_codes("\n".join(notice.text for notice in notices))


@pytest.mark.parametrize("frame", FRAMES)
def test_opening_model_in_unusual_frame_shows_expected_messages(
    window, notices, tmp_path: Path, frame: str
) -> None:
    change, crs, _ = FRAMES[frame]
    path = write_model(tmp_path / "given", change(bed()), crs)
    studio = window.studio
    window.open_path(path)
    driver.wait(lambda: studio.models or notices, "an answer")
    driver.pause(300)
    answer = shown(notices)
    if studio.models and crs is None:
        driver.wait(lambda: driver.dialog_of(window), "the frame dialog")
        answer.add(ASKED)
        driver.dialog_of(window).reject()
    expect("open model", frame, answer, ASKED)


@pytest.mark.parametrize("frame", FRAMES)
def test_three_point_table_in_unusual_frame_shows_expected_messages(
    window, notices, tmp_path: Path, monkeypatch, frame: str
) -> None:
    change, crs, _ = FRAMES[frame]
    path = write_points(tmp_path / "given", change(bed()), crs)
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(path), ""))
    window.actions_table.run("three_points")
    panel = window.findChild(ThreePointsPanel)
    panel._open_table_file()
    driver.wait(lambda: shown(notices), "an answer")
    expect("three points", frame, shown(notices))


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.usefixtures("on_good_model")
def test_control_points_in_unusual_frame_show_expected_messages(
    window, notices, tmp_path: Path, frame: str
) -> None:
    change, crs, _ = FRAMES[frame]
    path = write_control(tmp_path / "given", change(bed()), crs)
    window.actions_table.run("register_model")
    panel = driver.tool_panel(window, ControlPanel)
    panel.import_points(panel.model, path)
    driver.wait(lambda: shown(notices) | shown_codes(panel.summary.text()), "an answer")
    answer = shown(notices) | shown_codes(panel.summary.text())
    expect("register by points", frame, answer)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.usefixtures("on_good_model")
def test_field_readings_in_unusual_frame_show_expected_messages(
    window, notices, tmp_path: Path, frame: str
) -> None:
    change, crs, _ = FRAMES[frame]
    path = write_oriented(tmp_path / "given", change(bed()), crs)
    import_readings(window, window.studio, path)
    driver.pause(300)
    dialog = window.findChildren(ReadingsDialog)[-1]
    answer = shown(notices) | shown_codes(dialog._summary.text())
    is_far = bool(dialog._distance_findings())
    positions = [row.position for row in dialog._field_readings.rows]
    dialog.reject()
    if crs is None:
        # They are in the CRS of the project, as those of `section --features`.
        assert is_far == (frame != "not stated")
    elif frame != "exchanged":
        assert np.array(positions) == pytest.approx(bed()[:12], abs=0.01)
        assert not is_far
        expect("import readings", frame, answer, "frame.reprojected")
    else:
        expect("import readings", frame, answer)
