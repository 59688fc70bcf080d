"""Kills at any moment of random editing with the tools of the real window, mouse and keys: traces
clicked and followed, unfinished ones, deleted ones, masks, marks and points in photos, undoing,
redoing, saving.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.fuzz.kills_in_window --kills 30 [--seed N]

Each window is a process that says, after each event, what is on the screen; it is killed while it
goes on. What it has said must be there when the project is opened again. Prints as `kills` does.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.fuzz.kills import judge, shown
from tests.kernel_cache import share_kernel_cache

ROOT = Path(__file__).resolve().parents[2]
_LONGEST_S = 6.0
"""Of the editing before a kill."""
_START_S = 120.0


# --- the window -------------------------------------------------------------------------------
class Editor:
    """Somebody who uses the window's tools at random."""

    def __init__(self, window: Any, chance: random.Random) -> None:
        self.window, self.studio, self.chance = window, window.studio, chance

    def work(self) -> None:
        """Until it is killed."""
        self.tell("begin")
        steps = [*self.steps(), ("undo", self.undo), ("redo", self.redo), ("save", self.save)]
        while True:
            kind, step = self.chance.choice(steps)
            step()
            self.tell(kind)

    def steps(self) -> list[tuple[str, Callable[[], object]]]:
        raise NotImplementedError

    def tell(self, kind: str) -> None:
        project, session = self.studio.project, self.studio.session
        state = shown(session.records, session.draft, session.dirty)
        print(f"{kind}\t{project.folder}\t{project.journal.last_number}\t{state}", flush=True)

    def key(self, code: Any, modifier: Any = None) -> None:
        from tests import driver

        driver.key(self.window, code, modifier or driver.NONE)

    def undo(self) -> None:
        self.studio.undo()

    def redo(self) -> None:
        self.studio.redo()

    def save(self) -> None:
        self.studio.save()


class Interpreter(Editor):
    """Works on the model."""

    def __init__(self, window: Any, chance: random.Random) -> None:
        import numpy as np

        from tests import driver
        from tests.journeys.conftest import read_picks

        super().__init__(window, chance)
        self.picks = read_picks()
        driver.look_at(window, np.concatenate(list(self.picks.values())), 0.0, 10.0)

    def steps(self) -> list[tuple[str, Callable[[], object]]]:
        return [
            ("click", self.click),
            ("click", self.click),
            ("click", self.click),
            ("take back", self.take_back),
            ("finish", self.finish),
            ("finish", self.finish),
            ("follow", self.follow),
            ("delete", self.delete),
            ("set", self.put_in_set),
        ]

    def click(self) -> None:
        from PySide6.QtCore import Qt

        from tests import driver
        from vomstudio.studio.tools.trace import TraceTool

        if not isinstance(self.studio.open_tool, TraceTool):
            self.key(Qt.Key.Key_T)
        points = self.picks[self.chance.choice(sorted(self.picks))]
        driver.pick(self.window, points[self.chance.randrange(len(points))][None])

    def take_back(self) -> None:
        from PySide6.QtCore import Qt

        self.key(Qt.Key.Key_Backspace)

    def finish(self) -> None:
        from PySide6.QtCore import Qt

        for _ in range(self.chance.choice([0, 3])):
            self.click()
            self.tell("click")
        self.key(Qt.Key.Key_Return)

    def follow(self) -> None:
        """A contact between two clicks."""
        from PySide6.QtCore import Qt

        from tests import driver
        from vomstudio.studio.tools.trace import TraceTool
        from vomstudio.ui.panels.tools.trace import TracePanel

        self.studio.cancel_tool()
        self.key(Qt.Key.Key_T)
        tool = self.studio.get_tool(TraceTool)
        box = driver.tool_panel(self.window, TracePanel).follow_box
        box.setCurrentIndex(box.findData("dark"))
        points = self.picks[self.chance.choice(sorted(self.picks))]
        for at in (0, len(points) // 2, -1):
            driver.click(self.window.viewport, driver.pixel(self.window, points[at]))
            self.tell("way-point")
        driver.wait(lambda: not tool.is_searching, "the way", 60.0)
        self.key(Qt.Key.Key_Return)
        box.setCurrentIndex(box.findData(None))

    def _selected(self) -> bool:
        from tests import driver

        traces = driver.traces(self.window)
        if traces:
            self.studio.selection.set([self.chance.choice(traces).id])
        return bool(traces)

    def delete(self) -> None:
        from PySide6.QtCore import Qt

        if self._selected():
            self.key(Qt.Key.Key_Delete)

    def put_in_set(self) -> None:
        from vomstudio.project import edits

        if self._selected():
            (id_,) = self.studio.selection.ids
            name = self.chance.choice("ABC")
            if self.studio.records[id_].set_name != name:
                self.studio.attempt(edits.assign_sets, {id_: name})


class Photographer(Editor):
    """Works in the photos."""

    def __init__(self, window: Any, chance: random.Random, photos: Path) -> None:
        from tests import driver
        from tests.journeys.test_photo_window import NAMES, ready

        super().__init__(window, chance)
        window.open_path(photos)
        driver.wait(lambda: window.survey.document.is_imported, "the photos", 120.0)
        driver.wait(lambda: window.photos_panel.table.rowCount() == 4, "their table", 60.0)
        driver.wait(lambda: not window.survey.is_reading, "their check", 120.0)
        window.photo_opening.open(chance.choice(NAMES))
        driver.wait(lambda: window.photo_opening.page is not None, "the photo")
        self.page = window.photo_opening.page
        ready(self.page)

    def steps(self) -> list[tuple[str, Callable[[], object]]]:
        return [
            ("mask", self.stroke),
            ("mask", self.stroke),
            ("invert", self.invert),
            ("repeat", self.repeat),
            ("mark", self.mark),
            ("mark", self.mark),
            ("nudge", self.nudge),
            ("photo", self.another),
        ]

    def _at(self) -> Any:
        from tests.journeys.test_photo_window import on

        return on(self.page, self.chance.uniform(300, 900), self.chance.uniform(200, 700))

    def _press(self, name: str) -> None:
        from PySide6.QtCore import Qt

        from tests.journeys.test_photo_window import press

        press(self.page, getattr(Qt.Key, f"Key_{name}"))

    def stroke(self) -> None:
        from tests import driver

        self._press("B")
        if self.chance.random() < 0.3:
            self._press("X")
        driver.drag(self.page.canvas, self._at(), self._at())

    def invert(self) -> None:
        self.page.actions_table.run("invert_mask")

    def repeat(self) -> None:
        from tests import driver

        self.page.actions_table.run("repeat_mask")
        driver.wait(lambda: not self.page.masks.busy_reason, "the masks", 60.0)

    def mark(self) -> None:
        from tests import driver

        self._press("N")
        driver.click(self.page.canvas, self._at())

    def nudge(self) -> None:
        self._press(self.chance.choice(["Left", "Right", "Up", "Down"]))

    def another(self) -> None:
        from tests.journeys.test_photo_window import NAMES, ready

        self.page.show_photo(self.chance.choice(NAMES))
        ready(self.page)


def edit(folder: Path, models: Path, photos: Path, seed: str) -> None:
    from PySide6.QtWidgets import QApplication

    from tests import driver

    application = QApplication([])
    assert application is not None
    chance = random.Random(seed)
    new = not folder.exists()
    window = driver.make_window([] if new else [folder])
    window.resize(1400, 900)
    if new:
        driver.open_outcrop(window, models / "outcrop.obj")
        window.studio.save_as(folder)
    else:
        driver.wait(lambda: window.studio.project.folder == folder, "the project", 60.0)
        driver.wait(lambda: window.studio.models, "the model", 60.0)
    if chance.random() < 0.6:
        Interpreter(window, chance).work()
    else:
        Photographer(window, chance, photos).work()


# --- kills ------------------------------------------------------------------------------------
def one_kill(words: list[str], delay_s: float, user: Path) -> tuple[list[list[str]], str]:
    """What was said, whole lines, and what stood on stderr if the window ended by itself."""
    share_kernel_cache()
    folders = ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")
    environment = {**os.environ, **{name: str(user / name.lower()) for name in folders}}
    environment["VOMSTUDIO_SETTINGS"] = str(user / "settings.toml")
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz.kills_in_window", "--edit", *words],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=errors,
        )
        assert process.stdout is not None
        out = process.stdout.fileno()
        said, end = b"", time.monotonic() + _START_S
        while (left := end - time.monotonic()) > 0:
            ready, _, _ = select.select([out], [], [], left)
            if ready:
                if not (chunk := os.read(out, 1 << 16)):
                    break
                if not said:
                    end = time.monotonic() + delay_s
                said += chunk
        ended = process.poll() is not None
        process.send_signal(signal.SIGKILL)
        process.wait()
        while chunk := os.read(out, 1 << 16):
            said += chunk
        process.stdout.close()
        errors.seek(0)
        fell = errors.read()[-1500:].decode(errors="replace") if ended or not said else ""
    return [line.split("\t") for line in said.decode().split("\n")[:-1] if "\t" in line], fell


def campaign(kills: int, seed: int) -> tuple[Counter[str], Counter[str], list[str]]:
    """How kills ended, which steps were told, and what was lost."""
    from tests.journeys.conftest import bare_outcrop
    from vomstudio.core.paths import resource

    chance = random.Random(f"kills in a window {seed}")
    ends, steps = Counter[str](), Counter[str]()
    wrong: list[str] = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as made:
        place = Path(made).resolve()
        bare_outcrop(place / "models")
        (place / "the face").mkdir()
        for number in range(4):
            name = f"HL_204{number + 1}.jpg"
            (place / "the face" / name).write_bytes(resource("sample", "photos", name).read_bytes())
        (place / "user").mkdir()
        for number in range(kills):
            # Some windows go on with what the one before has left.
            if number % 5 == 0:
                folder = place / f"{number}.vom"
            words = [*map(str, (folder, place / "models", place / "the face")), f"{seed} {number}"]
            told, fell = one_kill(words, chance.random() * _LONGEST_S, place / "user")
            steps.update(line[0] for line in told)
            if fell or not told:
                ends["wrong"] += 1
                wrong.append(f"kill {number}: the window fell: {fell}")
                folder = place / f"{number}-new.vom"
                continue
            found = judge(told)
            ends[found if found.islower() else "wrong"] += 1
            if not found.islower():
                wrong.append(f"kill {number}: {found}")
    return ends, steps, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--edit", nargs=4, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.edit:
        folder, models, photos, seed = asked.edit
        edit(Path(folder), Path(models), Path(photos), seed)
        return 0
    ends, steps, wrong = campaign(asked.kills, asked.seed)
    print(f"{asked.kills} kills: {dict(ends)}")
    print(f"{steps.total()} steps shown: {dict(sorted(steps.items()))}")
    for line in wrong:
        print("  ", line)
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
