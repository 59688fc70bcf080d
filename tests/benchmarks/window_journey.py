"""Pictures of the real window on a journey, to be compared to the pixel with those of another
version of the program.

    python -m tests.benchmarks.window_journey OUT [--program FOLDER] [--act NAME]
    python -m tests.benchmarks.window_journey --compare A B

The first starts the program in FOLDER (by default the checkout of this file) on a screen of its own
(Xvfb), with the settings of a new user, drives it with mouse and keys, and writes pictures of the
whole screen to OUT. The second says for each picture in how many pixels A and B differ, and exits
with 1 where any does. Two runs of one program on one machine differ in none; pixels that are at
most ROUNDING levels apart are counted apart, since Qt draws the outlined letters of the compass in
one of a few ways that differ by 4 levels at most in the brims of the letters, by chance.

The journey knows little of the program, so that it can be told of one whose modules have moved:
`vomstudio.app.main`, the names of actions, docks and fields (objectName), titles, and places on the
screen. Each act is a process of its own: the sample outcrop with every tool; the specimen project
with table, net, view along the fold axis; the specimen photos with the window of a photo.

All is done in one folder with a fixed name, since paths are seen in the window: one journey at a
time.
"""

from __future__ import annotations

import argparse
import itertools
import os
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.kernel_cache import share_kernel_cache

ROOT = Path(__file__).resolve().parents[2]
SPECIMENS = ROOT / "tests" / "specimens"
STAGE = Path(tempfile.gettempdir()) / "vomstudio-window-journey"
MIDDLE = (500, 250, 300, 200)
"""Of the view: x, y, width, height on the screen."""
ACTS = ("sample", "project", "photos")
SCREEN = (1600, 1000)
SIZE = (1400, 900)
ROUNDING = 4
"""Levels of 255 by which a pixel may be apart and still count as the same."""
QUIET_S = 1.5
"""A picture that has not changed for so long is taken."""
MESSAGE_S = 7.0
"""Messages in the status line go by themselves after six seconds."""
PATIENCE_S = 240.0
COVERED = {"messages": 100, "make_memory": 2000, "make_threads": 2000, "jobs": 2000}
"""How many pixels of these widgets, from the left, tell of the hour or of the machine."""


# --- outside --------------------------------------------------------------------------------------
def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("out", type=Path, nargs="?", help="folder for the pictures")
    parser.add_argument("--program", type=Path, default=ROOT, help="a checkout of the program")
    parser.add_argument("--act", choices=ACTS, help="one act only")
    parser.add_argument("--compare", type=Path, nargs=2, metavar=("A", "B"))
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.compare:
        return compare(*args.compare)
    if args.out is None:
        parser.error("name a folder for the pictures")
    if args.inside:
        return Journey(args.out, args.act).play()
    out = args.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    for act in (args.act,) if args.act else ACTS:
        for old in out.glob(f"{act}-*.png"):
            old.unlink()
        code = run_act(act, out, args.program.resolve())
        if code:
            print(f"the act {act} ended with {code}", file=sys.stderr)
            return code
    return 0


def run_act(act: str, out: Path, program: Path) -> int:
    """Play an act in a fresh process on a fresh screen, with folders of a new user."""
    try:
        STAGE.mkdir()
    except FileExistsError:
        print(f"{STAGE} is there: another journey is under way, or was killed; remove it")
        return 2
    try:
        for name in ("photos", "schema1.vom"):
            shutil.copytree(SPECIMENS / name, STAGE / name)
        shutil.copy(SPECIMENS / "boulder.ply", STAGE)
        inside = [str(Path(__file__).resolve()), str(out), "--inside", "--act", act]
        return on_a_screen(inside, STAGE, program)
    finally:
        shutil.rmtree(STAGE, ignore_errors=True)


def on_a_screen(script: list[str], stage: Path, program: Path) -> int:
    """The exit code of a Python script with its words, run in the folder `stage` on a screen of its
    own, with the settings of a new user, who sees the same everywhere."""
    share_kernel_cache()
    user = stage / "user"
    home = {
        name: str(user / name.lower())
        for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")
    }
    kept = {k: v for k, v in os.environ.items() if k not in ("WAYLAND_DISPLAY", "DISPLAY")}
    environment = {
        **kept,
        **home,
        "VOMSTUDIO_SETTINGS": str(user / "settings.toml"),
        "PYTHONPATH": str(program),
        "PYTHONHASHSEED": "0",
        "QT_API": "pyside6",
        "QT_QPA_PLATFORM": "xcb",
        "QT_QPA_PLATFORMTHEME": "",
        "QT_STYLE_OVERRIDE": "Fusion",
        "QT_FONT_DPI": "96",
        "QT_SCALE_FACTOR": "1",
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "LC_ALL": "C.UTF-8",
        "TZ": "UTC",
    }
    screen = f"-screen 0 {'x'.join(map(str, SCREEN))}x24 +extension GLX"
    words = ["xvfb-run", "-a", "-s", screen, sys.executable, "-P", *script]
    return subprocess.run(words, env=environment, cwd=stage).returncode


def compare(first: Path, second: Path) -> int:
    """Print how many pixels of each picture differ; 1 where any does."""
    import numpy as np
    from PIL import Image

    names = sorted({p.name for folder in (first, second) for p in folder.glob("*.png")})
    total = 0
    for name in names:
        if not all((folder / name).is_file() for folder in (first, second)):
            print(f"{name}: in one folder only")
            total += 1
            continue
        with Image.open(first / name) as a, Image.open(second / name) as b:
            one, other = (np.asarray(image.convert("RGB")) for image in (a, b))
        if one.shape != other.shape:
            print(f"{name}: {one.shape} and {other.shape}")
            total += 1
            continue
        levels = np.abs(one.astype(int) - other.astype(int)).max(axis=2)
        apart = levels > ROUNDING
        faint = int((levels > 0).sum() - apart.sum())
        where = f" ({faint} by rounding)" if faint else ""
        if count := int(apart.sum()):
            rows, columns = apart.any(axis=1).nonzero()[0], apart.any(axis=0).nonzero()[0]
            where += f" within x {columns[0]}-{columns[-1]}, y {rows[0]}-{rows[-1]}"
        print(f"{name}: {count} pixels differ{where}")
        total += count
    print(f"{len(names)} pictures, {total} differences")
    return 1 if total or not names else 0


# --- inside ---------------------------------------------------------------------------------------
class Journey:
    """One act: the program is started as by its user, and played in place of its event loop."""

    def __init__(self, out: Path, act: str) -> None:
        self.out, self.act = out, act
        self.number = 0
        self.window: Any = None

    def play(self) -> int:
        from PySide6.QtWidgets import QApplication

        def loop(*_: object) -> int:
            try:
                self._begin()
                getattr(self, self.act)()
            except Exception as error:  # noqa: BLE001 - a picture tells more than a traceback
                self.grab().save(str(self.out / f"{self.act}-failed.png"))
                print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
                os._exit(1)
            return 0

        # Names of records are random; some orders of drawing hang on them.
        numbers = itertools.count(1)
        secrets.token_hex = lambda n=16: f"{next(numbers):0{2 * n}x}"
        QApplication.exec = loop  # type: ignore[method-assign, assignment]
        from vomstudio.app import main as start

        start(self.words())
        # Not by closing, which would ask what to do with the work.
        sys.stdout.flush()
        os._exit(0)

    def words(self) -> list[str]:
        """After the program's name."""
        return {
            "sample": [],
            "project": [str(STAGE / "schema1.vom")],
            "photos": [str(STAGE / "photos")],
        }[self.act]

    def _begin(self) -> None:
        from PySide6.QtCore import Qt
        from PySide6.QtWidgets import QApplication, QMainWindow

        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.setCursorFlashTime(0)
        for effect in (
            Qt.UIEffect.UI_AnimateMenu,
            Qt.UIEffect.UI_AnimateCombo,
            Qt.UIEffect.UI_AnimateTooltip,
            Qt.UIEffect.UI_FadeMenu,
            Qt.UIEffect.UI_FadeTooltip,
            Qt.UIEffect.UI_AnimateToolBox,
        ):
            application.setEffectEnabled(effect, False)
        self.window = next(w for w in application.topLevelWidgets() if isinstance(w, QMainWindow))
        self.window.move(0, 0)
        self.window.resize(*SIZE)
        self.wait(lambda: self.dock("stereonet") is not None, "the docks")
        # The net comes last of all: its library is heavy.
        self.window.prepare_for_models()
        self.wait(lambda: hasattr(self.window, "net"), "the net")
        self.window.activateWindow()
        self.wait(lambda: application.activeWindow() is not None, "an active window")

    # --- waiting ---------------------------------------------------------------------------------
    def wait(self, until: Callable[[], object], what: str, seconds: float = PATIENCE_S) -> None:
        from PySide6.QtTest import QTest

        end = time.monotonic() + seconds
        while not until():
            if time.monotonic() > end:
                raise RuntimeError(f"did not come about in {seconds:g} s: {what}")
            QTest.qWait(20)

    def pause(self, seconds: float) -> None:
        from PySide6.QtTest import QTest

        QTest.qWait(round(1000 * seconds))

    def grab(self) -> Any:
        """The whole screen, as an image."""
        from PySide6.QtGui import QGuiApplication, QImage

        screen = QGuiApplication.primaryScreen()
        return screen.grabWindow(0).toImage().convertToFormat(QImage.Format.Format_RGB888)

    def stable(self, quiet: float = QUIET_S) -> Any:
        """The picture, once it has not changed for some time."""
        end = time.monotonic() + PATIENCE_S
        last, since = self.grab(), time.monotonic()
        while time.monotonic() - since < quiet:
            if time.monotonic() > end:
                raise RuntimeError("the picture does not come to rest")
            self.pause(0.15)
            if (now := self.grab()) != last:
                last, since = now, time.monotonic()
        return last

    def until_drawn(self, place: tuple[int, int, int, int]) -> None:
        """Wait until a part of the screen (x, y, width, height) shows an outcrop: many colours."""

        def colours() -> int:
            piece = self.grab().copy(*place)
            points = [(x, y) for x in range(0, place[2], 10) for y in range(0, place[3], 10)]
            return len({piece.pixel(x, y) for x, y in points})

        self.wait(lambda: colours() > 50, "a picture there")

    def shot(self, name: str, quiet: float = QUIET_S) -> Any:
        """Take the next picture of the journey."""
        image = self.stable(quiet)
        self.number += 1
        path = self.out / f"{self.act}-{self.number:02d}-{name.replace(' ', '-')}.png"
        self._cover(image)
        image.save(str(path))
        print(path.name, flush=True)
        return image

    def _cover(self, image: Any) -> None:
        """Black over what tells of the hour and of the machine."""
        from PySide6.QtCore import QRect, Qt
        from PySide6.QtGui import QPainter
        from PySide6.QtWidgets import QApplication

        painter = QPainter(image)
        for widget in QApplication.allWidgets():
            if (wide := COVERED.get(widget.objectName())) is None or not widget.isVisible():
                continue
            whole = QRect(widget.mapToGlobal(widget.rect().topLeft()), widget.size())
            whole.setWidth(min(whole.width(), wide))
            painter.fillRect(whole, Qt.GlobalColor.black)
        painter.end()

    # --- the window's parts ----------------------------------------------------------------------
    def dock(self, name: str) -> Any:
        from PySide6.QtWidgets import QDockWidget

        return self.window.findChild(QDockWidget, name)

    def show_dock(self, name: str) -> None:
        self.window.docks.bring_forward(name)

    def action(self, name: str, owner: Any = None) -> Any:
        from PySide6.QtGui import QAction

        found = (owner or self.window).findChild(QAction, name)
        assert found is not None, name
        return found

    def run(self, name: str, owner: Any = None) -> None:
        """As a click in the menu would, and without waiting for a dialog's end."""
        from PySide6.QtCore import QTimer

        QTimer.singleShot(0, self.action(name, owner).trigger)
        self.pause(0.1)

    def named(self, name: str, owner: Any = None) -> Any:
        from PySide6.QtWidgets import QWidget

        found = (owner or self.window).findChild(QWidget, name)
        assert found is not None, name
        return found

    def dialog(self) -> Any:
        """The window in front that is not the main one."""
        from PySide6.QtWidgets import QApplication

        def shown() -> list[Any]:
            return [
                w
                for w in QApplication.topLevelWidgets()
                if w is not self.window and w.isVisible() and w.isWindow() and w.windowTitle()
            ]

        self.wait(shown, "a dialog")
        dialog = shown()[-1]
        dialog.move(80, 40)
        dialog.activateWindow()
        return dialog

    # --- the hand --------------------------------------------------------------------------------
    def at(self, x: int, y: int) -> tuple[Any, Any]:
        """The widget at a place of the screen, and the place in it."""
        from PySide6.QtCore import QPoint
        from PySide6.QtWidgets import QApplication

        place = QPoint(x, y)
        widget = QApplication.widgetAt(place)
        assert widget is not None, f"nothing at {x}, {y}"
        return widget, widget.mapFromGlobal(place)

    def move(self, x: int, y: int) -> None:
        from PySide6.QtTest import QTest

        widget, place = self.at(x, y)
        QTest.mouseMove(widget, place)
        self.pause(0.05)

    def click(self, x: int, y: int, modifier: Any = None, *, double: bool = False) -> None:
        from PySide6.QtCore import Qt
        from PySide6.QtTest import QTest

        self.move(x, y)
        widget, place = self.at(x, y)
        held = Qt.KeyboardModifier.NoModifier if modifier is None else modifier
        QTest.mouseClick(widget, Qt.MouseButton.LeftButton, held, place)
        if double:
            QTest.mouseDClick(widget, Qt.MouseButton.LeftButton, held, place)
        # Or the next click would be a double one.
        self.pause(0.05 if double else 0.6)

    def drag(self, *places: tuple[int, int], button: str = "left") -> None:
        """Press at the first place, move over the others, release at the last."""
        from PySide6.QtCore import QEvent, QPointF, Qt
        from PySide6.QtGui import QMouseEvent
        from PySide6.QtWidgets import QApplication

        which = Qt.MouseButton.LeftButton if button == "left" else Qt.MouseButton.RightButton
        none = Qt.MouseButton.NoButton
        self.move(*places[0])
        widget, _ = self.at(*places[0])

        def send(kind: Any, place: QPointF, changed: Any, held: Any) -> None:
            local = QPointF(widget.mapFromGlobal(place.toPoint()))
            event = QMouseEvent(kind, local, place, changed, held, Qt.KeyboardModifier.NoModifier)
            QApplication.sendEvent(widget, event)
            self.pause(0.02)

        points = [QPointF(*place) for place in places]
        send(QEvent.Type.MouseButtonPress, points[0], which, which)
        for start, end in itertools.pairwise(points):
            for step in range(1, 9):
                send(QEvent.Type.MouseMove, start + (end - start) * step / 8, none, which)
        send(QEvent.Type.MouseButtonRelease, points[-1], which, none)

    def wheel(self, x: int, y: int, notches: int) -> None:
        from PySide6.QtCore import QPoint, QPointF, Qt
        from PySide6.QtGui import QWheelEvent
        from PySide6.QtWidgets import QApplication

        self.move(x, y)
        widget, place = self.at(x, y)
        for _ in range(abs(notches)):
            event = QWheelEvent(
                QPointF(place),
                QPointF(x, y),
                QPoint(),
                QPoint(0, 120 if notches > 0 else -120),
                Qt.MouseButton.NoButton,
                Qt.KeyboardModifier.NoModifier,
                Qt.ScrollPhase.NoScrollPhase,
                False,
            )
            QApplication.sendEvent(widget, event)
            self.pause(0.05)

    def key(self, name: str, *, ctrl: bool = False) -> None:
        from PySide6.QtCore import Qt
        from PySide6.QtTest import QTest
        from PySide6.QtWidgets import QApplication

        target = QApplication.focusWidget() or self.window
        held = Qt.KeyboardModifier.ControlModifier if ctrl else Qt.KeyboardModifier.NoModifier
        QTest.keyClick(target, getattr(Qt.Key, f"Key_{name}"), held)
        self.pause(0.1)

    def write(self, field: Any, text: str) -> None:
        """Type into a field, in place of what it holds."""
        from PySide6.QtTest import QTest

        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, text)
        self.pause(0.1)

    def press(self, name: str) -> None:
        """Click the button of an action in one of the bars."""
        from PySide6.QtWidgets import QToolBar, QToolButton

        action = self.action(name)
        bars = self.window.findChildren(QToolBar)
        buttons = [bar.widgetForAction(action) for bar in bars]
        buttons += [each for each in action.associatedObjects() if isinstance(each, QToolButton)]
        for button in buttons:
            if button is not None and button.isVisible():
                place = button.mapToGlobal(button.rect().center())
                self.click(place.x(), place.y())
                return
        raise RuntimeError(f"no button {name}")

    def row(self, table: Any, number: int, *, double: bool = False) -> None:
        """Click the first cell of a table's row."""
        index = table.model().index(number, 0)
        table.scrollTo(index)
        place = table.viewport().mapToGlobal(table.visualRect(index).center())
        self.click(place.x(), place.y(), double=double)

    # --- the acts --------------------------------------------------------------------------------
    def sample(self) -> None:
        """The sample outcrop and every tool."""
        self.shot("empty")
        self.run("open_sample")
        self.until_drawn(MIDDLE)
        self.shot("opened", MESSAGE_S)
        self.drag((700, 600), (740, 620))
        self.shot("orbited")
        self.wheel(560, 330, 4)
        self.shot("zoomed")

        self.press("trace")
        self.trace("a trace open", (420, 330), (500, 310), (600, 300), (680, 320), (760, 350))
        self.key("Return")
        self.shot("a trace finished")
        self.key("Z", ctrl=True)
        self.shot("undone")
        self.key("Y", ctrl=True)
        self.shot("done again")
        self.trace("", (400, 430), (480, 410), (560, 400), (640, 410), (720, 440), (790, 450))
        self.key("Return")
        self.write(self.set_field(), "upper")
        self.key("Return")
        self.trace("", (830, 380), (880, 360), (930, 350), (990, 340))
        self.key("Return")
        self.shot("three traces of two sets")

        self.press("plane")
        self.drag((520, 350), (560, 345), (600, 350), (560, 360))
        self.drag((600, 360), (630, 355))
        self.shot("a patch")
        self.key("Return")
        self.press("line")
        self.click(700, 420)
        self.click(720, 460)
        self.click(735, 500)
        self.shot("a line open")
        self.key("Return")
        self.press("measure")
        self.click(450, 300)
        self.click(470, 480)
        self.shot("a distance")

        self.press("navigate")
        self.key("A", ctrl=True)
        self.shot("all selected")
        self.run("view_north")
        self.shot("looking north")
        self.key("O")
        self.key("7")
        self.shot("orthographic from above")
        self.run("orthographic")
        self.run("view_north")
        self.show_dock("view")
        self.shot("view direction")
        self.show_dock("display")
        self.run("clipping_box")
        self.shot("clipped")
        self.run("clipping_box")
        self.run("feature_types")
        self.dialog()
        self.shot("feature types")
        self.key("Escape")
        self.run("only_outcrop")
        self.shot("only the outcrop")

    def project(self) -> None:
        """The specimen project in tree, table and net."""
        self.until_drawn(MIDDLE)
        self.shot("opened", MESSAGE_S)
        self.run("along_beta")
        self.shot("along the fold axis")
        self.run("orthographic")
        self.run("view_north")
        table = self.named("orientation_table")
        self.row(table, 4)
        self.shot("a row chosen")
        self.key("A", ctrl=True)
        self.shot("all chosen")
        self.row(table, 5)
        self.run("frame_selection")
        self.shot("framed")
        self.run("face_plane")
        self.shot("faced")
        self.run("show_only")
        self.shot("shown alone")
        self.run("show_all")
        self.run("planes_symbols")
        self.shot("planes as symbols")
        self.run("intersection_of_sets")
        self.dialog()
        self.shot("intersection of sets")
        self.key("Escape")
        self.show_dock("messages")
        self.shot("messages")
        self.run("show_in_photos")
        self.until_drawn((750, 580, 180, 150))
        self.shot("in the photos", MESSAGE_S)

    def photos(self) -> None:
        """The specimen photos, planner and settings, and the window of a photo."""
        self.wait(lambda: "warning" in self.named("survey_verdict").text(), "the survey check")
        self.shot("opened", MESSAGE_S)
        self.run("plan_survey")
        planner = self.dialog()
        self.write(self.named("plan_camera", planner).lineEdit(), "36x24,30,6000x4000")
        self.shot("planner", 3.0)
        planner.close()
        self.run("make_settings")
        settings = self.dialog()
        self.wait(lambda: "can be used" in self.named("control_verdict", settings).text(), "marks")
        self.shot("settings of the model", MESSAGE_S)
        settings.close()
        self.row(self.named("photo_table"), 1, double=True)
        photo = self.dialog()
        photo.resize(1200, 800)
        self.until_drawn(MIDDLE)
        self.shot("a photo", MESSAGE_S)
        canvas = self.named("mark_canvas", photo)
        middle = canvas.mapToGlobal(canvas.rect().center())
        self.run("brush", photo)
        self.drag((middle.x() - 60, middle.y() + 80), (middle.x() + 60, middle.y() + 90))
        self.shot("a mask painted", 3.0)
        self.run("mark", photo)
        self.shot("ready to mark")
        self.click(middle.x() + 40, middle.y() - 30)
        self.shot("a point marked", 3.0)
        photo.close()
        self.shot("back in the window", MESSAGE_S)

    def trace(self, name: str, *places: tuple[int, int]) -> None:
        """Click along a line on the outcrop."""
        for x, y in places:
            self.click(x, y)
        if name:
            self.shot(name)

    def set_field(self) -> Any:
        """Where the trace's panel takes the name of a set."""
        from PySide6.QtWidgets import QLineEdit

        dock = self.dock("tool") or self.dock("trace")
        fields = dock.findChildren(QLineEdit)
        return next(f for f in fields if f.placeholderText() == "none" and f.isVisible())


if __name__ == "__main__":
    sys.exit(main())
