"""Opens every dialog and prints, one JSON object a line, how it stands on the screen.

Run as a process of its own: the scale of the screen is fixed when Qt starts.
"""

from __future__ import annotations

import faulthandler
import json
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QPoint, QRect, QTimer
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QDialog,
    QLineEdit,
    QScrollArea,
    QWidget,
)

from tests import appearance, driver
from tests.journeys.conftest import bare_outcrop, read_picks
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model

_BOOK = """station,kind,dip direction,dip,x,y,z
F1,Bedding,270,45,500010,5100010,1
F2,bedding,268,,500010,5100010,1
""" + "".join(f"G{i},Kind {i},{i},x,,,\n" for i in range(30))


def fields_of(dialog: QWidget) -> Iterator[QWidget]:
    """What can be clicked or typed in, in sight or not yet."""
    for kind in (QAbstractButton, QLineEdit, QComboBox):
        for widget in dialog.findChildren(kind):
            # The arrow and the field of a box belong to it; tables scroll by themselves.
            owner = widget.parentWidget()
            inside = isinstance(owner, QComboBox) or owner.objectName() == "qt_scrollarea_viewport"
            if widget.isVisibleTo(dialog) and widget.isEnabled() and not inside:
                yield widget


def reached(dialog: QWidget, widget: QWidget) -> bool:
    """Whether its middle is in sight after scrolling to it."""
    above = widget.parentWidget()
    while above is not None and above is not dialog:
        if isinstance(above, QScrollArea):
            above.ensureWidgetVisible(widget, 0, 0)
        above = above.parentWidget()
    QApplication.processEvents()
    middle = widget.mapTo(dialog, widget.rect().center())
    hit = dialog.childAt(middle)
    return dialog.rect().contains(middle) and (
        hit is widget or (hit is not None and widget.isAncestorOf(hit))
    )


def out_of_reach(dialog: QWidget) -> list[QWidget]:
    """Fields that cannot be reached once nothing arrives any more that moves them while they are
    scrolled to."""
    for _ in range(5):
        found = [w for w in fields_of(dialog) if not reached(dialog, w)]
        if not found:
            break
        driver.pause(1000)
    return found


def describe(dialog: QWidget, name: str) -> dict[str, Any]:
    """How it stands once all that comes later is in it."""
    driver.pause(400)
    driver.keep_picture(dialog, f"dialog-{name}-{dialog.screen().availableGeometry().width()}")
    area = dialog.screen().availableGeometry()
    place = QRect(dialog.mapToGlobal(QPoint(0, 0)), dialog.size())
    fields = list(fields_of(dialog))
    squeezed = [
        f"{type(w).__name__} {w.objectName()}: {w.height()} of {w.minimumSizeHint().height()}"
        for w in fields
        if w.height() < w.minimumSizeHint().height() and w.objectName() != "qt_spinbox_lineedit"
    ]
    return {
        "dialog": name,
        "kind": type(dialog).__name__,
        "fits": area.contains(place),
        "place": [*place.getRect(), area.width(), area.height()],
        "fields": len(fields),
        "squeezed": squeezed,
        "violations": appearance.violations(dialog),
        "hidden": [
            getattr(w, "text", lambda: "")() or w.objectName() or type(w).__name__
            for w in out_of_reach(dialog)
        ],
    }


class Walk:
    """The real window, with everything in it that a dialog may ask for."""

    def __init__(self, folder: Path, reconstruction: Path) -> None:
        self.folder, self.reconstruction = folder, reconstruction
        self.window = driver.make_window()

    @contextmanager
    def seen(self, name: str) -> Iterator[None]:
        """Describes what was opened inside, and closes it."""
        before = set(self.shown())
        yield
        driver.wait(lambda: set(self.shown()) - before, name, 60.0)
        (made,) = set(self.shown()) - before
        print(json.dumps(describe(made, name)), flush=True)
        made.close()
        driver.pause(50)

    def shown(self) -> list[QWidget]:
        """Windows beside the main one."""
        tops = QApplication.topLevelWidgets()
        return [
            w
            for w in tops
            if w.isVisible()
            and w is not self.window
            and w.isWindow()
            and type(w).__module__.startswith("vomstudio.ui")
            and isinstance(w, QDialog)
        ]

    def modal(self, name: str, run: Callable[[], object]) -> None:
        """The same of one that waits for its end."""
        said: list[dict[str, Any]] = []

        def look() -> None:
            made = QApplication.activeModalWidget()
            if made is None:
                QTimer.singleShot(50, look)
                return
            said.append(describe(made, name))
            made.close()

        QTimer.singleShot(100, look)
        run()
        print(json.dumps(said[0]), flush=True)

    def all(self) -> None:
        """One after the other."""
        window = self.window
        run = window.actions_table.run
        with self.seen("frame"):
            window.open_path(bare_outcrop(self.folder / "models"))
        window.files.declare_frame()
        driver.declare(window)
        model = driver.model(window)
        driver.settled(window)
        for number, (name, points) in enumerate(read_picks().items()):
            kind = "fault" if number == 0 else "bedding"
            vertices = tuple(map(tuple, points.tolist()))
            trace = Trace(name, name, kind, model.id, model.content_hash, vertices)
            assert window.studio.attempt(edits.add_trace, trace)
        for action in (
            "verdict_profile",
            "orthophoto",
            "intersection_of_sets",
            "feature_types",
            "type_on_net",
            "figure_style",
            "plan_survey",
            "video_frames",
            "fit_model",
            "documentation",
        ):
            with self.seen(action):
                run(action)
        with self.seen("extend_plane"):
            window.studio.selection.set([next(iter(read_picks()))])
            run("extend_plane")
        self._compass(model)
        self._surface(model)
        self._book()
        self._page()
        self.modal("find_command", lambda: run("find_command"))
        self.modal("shortcuts", lambda: run("shortcuts"))
        self._photos()
        self._alignment()

    def _compass(self, model: Model) -> None:
        from vomstudio.registration.north import NorthInputs
        from vomstudio.ui.panels.tools.compass_dialog import CompassDialog

        dialog = CompassDialog(self.window, model, None, lambda made: NorthInputs())
        dialog.north.setCurrentIndex(dialog.north.findData("magnetic"))
        self.modal("compass_north", dialog.exec)

    def _surface(self, model: Model) -> None:
        from dataclasses import replace

        from vomstudio.project.kinds.patch import Patch
        from vomstudio.studio.tools.brush_stroke import patch_fields

        opened, zero = self.window.studio.models[model.id], (0.0, 0.0, 0.0)
        ids = np.arange(len(opened.data.faces) // 2)
        patch = Patch(
            "p1",
            "P1",
            "fault",
            model.id,
            model.content_hash,
            "face",
            (),
            0,
            zero,
            (zero, zero, zero),
            0.0,
        )
        driver.wait(lambda: opened.surface._faces_by_vertex is not None, "the search structures")
        patch = replace(patch, **patch_fields(opened.surface, ids))
        assert self.window.studio.attempt(edits.add_features, [patch])
        self.window.studio.selection.set(["p1"])
        with self.seen("patch_surface"):
            self.window.actions_table.run("patch_surface")

    def _book(self) -> None:
        from vomstudio.ui.commands.net import import_readings

        path = self.folder / "book.csv"
        path.write_text(_BOOK)
        with self.seen("readings"):
            import_readings(self.window, self.window.studio, path)

    def _page(self) -> None:
        from vomstudio.ui.widgets.html_page import open_page

        path = self.folder / "page.html"
        path.write_text("<h1>Page</h1>" + "<p>Text.</p>" * 200)
        # No browser is found without a path to it.
        os.environ["PATH"] = ""
        with self.seen("page"):
            open_page(self.window, path)

    def _photos(self) -> None:
        window = self.window
        specimens = Path(__file__).parents[1] / "specimens" / "photos"
        window.open_path(Path(shutil.copytree(specimens, self.folder / "photos")))
        driver.wait(lambda: window.survey.document.is_imported, "the photos", 120.0)
        driver.wait(lambda: not window.survey.is_reading, "the check", 120.0)
        driver.wait(lambda: not window.survey.is_forecasting, "the forecast", 60.0)
        with self.seen("make_settings"):
            window.actions_table.run("make_settings")

    def _alignment(self) -> None:
        from vomstudio.ui.base.window_fitting import fit_to_screen
        from vomstudio.ui.dialogs.alignment.alignment_dialog import AlignmentDialog

        with self.seen("alignment"):
            dialog = AlignmentDialog(self.window, self.window.studio, self.reconstruction)
            fit_to_screen(dialog)
            dialog.show()
            driver.wait(lambda: dialog.is_ready, "the alignment", 60.0)


def main(folder: Path, reconstruction: Path, theme: str) -> None:
    """folder : for files; reconstruction : a folder that can be looked into"""
    faulthandler.enable()
    application = QApplication([])
    walk = Walk(folder, reconstruction)
    walk.window.actions_table.run(f"theme_{theme}")
    begun = time.monotonic()
    walk.all()
    print(f"{time.monotonic() - begun:.1f} s", file=sys.stderr)
    driver.dismiss(walk.window)
    del application


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
    sys.stdout.flush()
    os._exit(0)
