"""The error report: one text file, which the user can read before passing it on.

It is read by developers and stays in English.
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from importlib import metadata

from vomstudio.core.failures import crashes, log
from vomstudio.core.failures.redaction import scrub
from vomstudio.core.version import __version__

_LIBRARIES = (
    "PySide6-Essentials",
    "vtk",
    "pyvista",
    "pyvistaqt",
    "numpy",
    "scipy",
    "numba",
    "pandas",
    "matplotlib",
    "mplstereonet",
    "laspy",
    "pyproj",
    "shapely",
    "pyogrio",
    "rasterio",
    "Pillow",
    "pycolmap",
    "pycolmap-cuda12",
    "open3d",
    "open3d-cpu",
    "opencv-python-headless",
    "psutil",
)
_LOG_LINES = 400

Section = tuple[str, Callable[[], Sequence[str]]]
"""A title, and what gives its lines; they are taken as they are."""


def compose(more: Iterable[Section] = (), private: Iterable[str] = ()) -> str:
    """The text of a report. A section that fails says so, and the others follow.

    private : names that the user has given, which are taken out of log and crashes
    """
    words = list(private)
    parts = [
        "# VOM Studio error report",
        "",
        f"Written {time.strftime('%Y-%m-%d %H:%M:%S')}. Nothing has been sent: read it, then "
        "pass it on. Coordinates, file names and the home folder are left out.",
    ]
    sections: list[Section] = [
        ("Versions", versions),
        ("Crashes", lambda: _crashes(words)),
        *more,
        ("Log", lambda: scrub(log.tail(_LOG_LINES), words).splitlines()),
    ]
    for title, lines in sections:
        parts += ["", f"## {title}", "", *_lines_of(lines)]
    return "\n".join(parts) + "\n"


def file_name() -> str:
    """A name for a report that is written now."""
    return f"vomstudio-report-{time.strftime('%Y%m%d-%H%M%S')}.txt"


def versions() -> list[str]:
    """The program, Python, the system and the libraries, none of which is imported for it."""
    lines = [
        f"VOM Studio {__version__}",
        f"Python {platform.python_version()} ({platform.python_implementation()})",
        f"System {platform.platform()}, {platform.machine()}",
        f"Installed as {'one program' if getattr(sys, 'frozen', False) else 'a package'}",
    ]
    return lines + [f"{name} {version}" for name, version in packages().items()]


def packages() -> dict[str, str]:
    """Versions of the libraries that are installed, by their names in the package index."""
    found = {}
    for name in _LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def _crashes(private: list[str]) -> list[str]:
    lines: list[str] = []
    for whose, text in crashes.texts():
        lines += [f"A {whose} process:", *scrub(text, private).splitlines(), ""]
    return lines


def _lines_of(lines: Callable[[], Sequence[str]]) -> Sequence[str]:
    try:
        return lines() or ["none"]
    except Exception as error:  # noqa: BLE001 - what is broken must not keep the rest away
        return [f"This section failed ({type(error).__name__})."]
