"""Checks whether this machine can draw, because the window would otherwise crash."""

from __future__ import annotations

import ctypes
import os
import sys

from vomstudio.core.failures.missing_libraries import missing_library
from vomstudio.core.findings import Finding

_MIN_OPENGL_VERSION = (3, 2)


def screen_problem() -> Finding | None:
    """Return why Qt would find no screen and abort, or None if it will find one.

    Must be called before the application is created.
    """
    platform = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if not sys.platform.startswith("linux") or platform not in ("", "xcb"):
        return None
    if platform == "" and os.environ.get("WAYLAND_DISPLAY"):
        return None
    display = os.environ.get("DISPLAY")
    if not display:
        return Finding("screen.missing")
    try:
        xcb = ctypes.CDLL("libxcb.so.1")
        ctypes.CDLL(_find_plugin())
    except (ImportError, OSError) as error:
        return missing_library(error) or Finding("screen.library-failed", error=error)
    xcb.xcb_connect.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(xcb.xcb_connect(None, None))
    has_error = xcb.xcb_connection_has_error(connection)
    xcb.xcb_disconnect(connection)
    return Finding("screen.unreachable", display=display) if has_error else None


def _find_plugin() -> str:
    """Return the path of Qt's platform plugin for X11.

    Some distributions lack libraries to which it is linked, and Qt aborts if one is missing.
    """
    from PySide6.QtCore import QLibraryInfo

    plugins = QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath)
    return os.path.join(plugins, "platforms", "libqxcb.so")


def opengl_problem() -> Finding | None:
    """Return why the window cannot draw, or None if OpenGL 3.2 is available.

    Must be called after the application and its default surface format have been created.
    """
    from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

    if QGuiApplication.platformName() in ("offscreen", "minimal"):
        # The surface is never shown.
        return None
    context = QOpenGLContext()
    surface = QOffscreenSurface()
    surface.setFormat(QSurfaceFormat.defaultFormat())
    surface.create()
    if not context.create() or not context.makeCurrent(surface):
        return Finding("screen.no-opengl")
    actual_version = context.format().version()
    context.doneCurrent()
    if tuple(actual_version) < _MIN_OPENGL_VERSION:
        version, min_version = (
            ".".join(map(str, item)) for item in (actual_version, _MIN_OPENGL_VERSION)
        )
        return Finding("screen.old-opengl", version=version, needed=min_version)
    return None
