"""Whether this machine can draw, found out before the window that would crash over it."""

from __future__ import annotations

import ctypes
import os
import sys

from vomstudio.failures.missing_libraries import missing_library
from vomstudio.words import tr

_NEEDED = (3, 2)


def why_no_screen() -> str | None:
    """One sentence where Qt would find no screen, and would end the process over it; None where it
    finds one. To be asked before the application is made."""
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if not sys.platform.startswith("linux") or platform not in ("", "xcb"):
        return None
    if platform == "" and os.environ.get("WAYLAND_DISPLAY"):
        return None
    display = os.environ.get("DISPLAY")
    if not display:
        return tr(
            "There is no screen for the window (DISPLAY is not set). The commands work without "
            "one: vomstudio --help lists them."
        )
    try:
        xcb = ctypes.CDLL("libxcb.so.1")
        ctypes.CDLL(_plugin())
    except (ImportError, OSError) as error:
        return str(missing_library(error) or error)
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(None, None))
    failed = xcb.xcb_connection_has_error(connection)
    xcb.xcb_disconnect(connection)
    if not failed:
        return None
    return tr(
        "The screen {display} cannot be reached: check DISPLAY, and whether this user may use it. "
        "The commands work without one: vomstudio --help lists them.",
        display=display,
    )


def _plugin() -> str:
    """What Qt shows windows by on X11. Distributions leave out some of the libraries that it is
    linked with, and Qt aborts where one of them is missing."""
    from PySide6.QtCore import QLibraryInfo

    plugins = QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath)
    return os.path.join(plugins, "platforms", "libqxcb.so")


def why_not_drawn() -> str | None:
    """One sentence with the remedy; None where OpenGL 3.2 is there. To be asked after the
    application and its default surface are made."""
    from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

    if QGuiApplication.platformName() in ("offscreen", "minimal"):
        # Nobody looks at it.
        return None
    context = QOpenGLContext()
    surface = QOffscreenSurface()
    surface.setFormat(QSurfaceFormat.defaultFormat())
    surface.create()
    if not context.create() or not context.makeCurrent(surface):
        return tr(
            "This screen has no OpenGL, which drawing needs. Install the driver of the graphics "
            "card, or on Linux the package libgl1-mesa-dri, which draws without one; the commands "
            "work without it: vomstudio --help lists them."
        )
    found = context.format().version()
    context.doneCurrent()
    if tuple(found) < _NEEDED:
        return tr(
            "This screen has OpenGL {major}.{minor}; drawing needs {needed}. Update the driver of "
            "the graphics card, or on Linux set LIBGL_ALWAYS_SOFTWARE=1, which draws without it; "
            "the commands work without it: vomstudio --help lists them.",
            major=found[0],
            minor=found[1],
            needed="{}.{}".format(*_NEEDED),
        )
    return None
