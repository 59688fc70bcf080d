"""Start of the window: an empty frame, then the viewport, then slow parts."""

from __future__ import annotations

import gc
import locale
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.failures.missing_libraries import missing_library
from vomstudio.core.failures.stop_requests import reset_handler_after_first
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.ui.shell.drawing_check import opengl_problem

if TYPE_CHECKING:
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QMainWindow

# Name of the desktop menu entry (vomstudio/core/files/desktop.py).
DESKTOP_NAME = "vomstudio"
_MESSAGE_DURATION_MS = 10_000


def run_window(paths: Sequence[str]) -> int:
    """Open the window with models, projects or photo folders, and return the exit code."""
    from vomstudio.ui.shell.drawing_check import screen_problem

    if (refusal := screen_problem()) is not None:
        # Otherwise Qt would abort the process with its own long message.
        print(refusal, file=sys.stderr)
        return 2
    # Objects imported now remain; scanning them repeatedly would take a tenth of the start time.
    gc.disable()
    os.environ.setdefault("QT_API", "pyside6")
    try:
        from PySide6.QtGui import QIcon
        from PySide6.QtWidgets import QApplication, QMessageBox
    except ImportError as error:
        return _report_missing(error)

    _disable_source_reading()
    _request_opengl()
    # The name becomes the window class on X11, by which desktops find the menu entry
    # (StartupWMClass). argv[0] is __main__.py in a bundle.
    application = QApplication([DESKTOP_NAME])
    # QApplication sets the user's locale; with decimal commas, native readers misread numbers.
    locale.setlocale(locale.LC_NUMERIC, "C")
    application.setApplicationName("VOM Studio")
    application.setDesktopFileName(DESKTOP_NAME)
    application.setWindowIcon(QIcon(str(resource("icon", "vomstudio.svg"))))

    try:
        from vomstudio.core.errors import VomError
        from vomstudio.io.settings import read_settings
        from vomstudio.ui.base import qt_log as qt_messages
        from vomstudio.ui.base import theme
        from vomstudio.ui.base.controls import escape_markup
        from vomstudio.ui.shell.first_paint import FirstPaint
        from vomstudio.ui.shell.main_window import MainWindow
        from vomstudio.ui.widgets.failure_notices import FailureNotices
    except ImportError as error:
        return _report_missing(error)

    theme.enlarge_small_font(application)
    settings, problems = read_settings()
    theme.use(settings.theme)
    qt_messages.install()
    window = MainWindow(settings)
    notices = FailureNotices(window, window)
    window.show()

    def begin() -> None:
        # The window is visible by now; only its viewport uses OpenGL.
        if (opengl_finding := opengl_problem()) is not None:
            _print_failure(opengl_finding)
            application.exit(2)
            return
        try:
            window.begin([Path(p) for p in paths])
            gc.enable()
        except VomError as error:
            # Without a folder for the project's journal, no work could be stored.
            QMessageBox.critical(window, "VOM Studio", escape_markup(str(error)))
            application.exit(error.exit_code)
            return
        except Exception as error:  # noqa: BLE001 - an incomplete window is of no use
            notices.show_fatal(error)
            application.exit(1)
            return
        for problem in problems:
            window.studio.warn(problem)
        notices.begin()

    FirstPaint(window, begin)
    listener = _connect_signals(window)
    code = application.exec()
    listener.stop()
    notices.close()
    qt_messages.uninstall()
    return code


def _connect_signals(window: QMainWindow) -> QTimer:
    """Close the window on SIGINT (Ctrl+C), SIGTERM and SIGHUP, as its close button does.

    The returned timer lets Python handle the signal, until it is stopped.
    """
    from PySide6.QtCore import QTimer

    # A signal may arrive between any two lines of Python, so closing is deferred to the event
    # loop.
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            number = getattr(signal, name)
            signal.signal(number, lambda *_: QTimer.singleShot(0, window.close))
            reset_handler_after_first(number)
    listener = QTimer()
    listener.start(500)
    listener.timeout.connect(lambda: None)
    return listener


def _report_missing(error: ImportError) -> int:
    """Report a missing or damaged system library and return the exit code.

    Any other error is raised again.
    """
    finding = missing_library(error)
    if finding is None:
        raise error
    print(finding.message, file=sys.stderr)
    return 2


def _print_failure(finding: Finding) -> None:
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QMessageBox

    print(finding, file=sys.stderr)
    # A user who started the program from a menu has no terminal; a dialog without a user must
    # close itself.
    box = QMessageBox(QMessageBox.Icon.Critical, "VOM Studio", finding.message)
    QTimer.singleShot(_MESSAGE_DURATION_MS, box.close)
    box.exec()


def _disable_source_reading() -> None:
    """Prevent PySide from reading the source of every imported module.

    The search for its snake_case feature takes a tenth of the start time. No module of this program
    uses that feature.
    """
    feature = sys.modules.get("shibokensupport.feature")
    if hasattr(feature, "_mod_uses_pyside"):
        setattr(feature, "_mod_uses_pyside", lambda _: False)  # noqa: B010 - not for type checkers


def _request_opengl() -> None:
    """Request OpenGL for all widgets. Must be called before the application is created."""
    from PySide6.QtGui import QSurfaceFormat

    surface = QSurfaceFormat()
    surface.setRenderableType(QSurfaceFormat.RenderableType.OpenGL)
    surface.setVersion(3, 2)
    surface.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    surface.setDepthBufferSize(24)
    QSurfaceFormat.setDefaultFormat(surface)
