"""Error report: a text file that the user can read before sending it.

The report is read by developers, so it is not translated.
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable, Iterable, Sequence

from vomstudio.core.failures import crashes, log
from vomstudio.core.failures.redaction import redact
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
"""Title of a section and a function that returns its lines, which are not redacted."""


def compose(extra_sections: Iterable[Section] = (), private_words: Iterable[str] = ()) -> str:
    """Return the text of a report; a section that fails does not affect the others.

    Parameters
    ----------
    extra_sections : iterable of Section
    private_words : iterable of str
        Names given by the user, which are removed from the log and the crash traces.
    """
    words = list(private_words)
    parts = [
        "# VOM Studio error report",
        "",
        f"Written {time.strftime('%Y-%m-%d %H:%M:%S')}. Nothing has been sent: read it, then "
        "pass it on. Coordinates, file names and the home folder are left out.",
    ]
    sections: list[Section] = [
        ("Versions", versions),
        ("Crashes", lambda: _crash_lines(words)),
        *extra_sections,
        ("Log", lambda: redact(log.tail(_LOG_LINES), words).splitlines()),
    ]
    for title, lines in sections:
        parts += ["", f"## {title}", "", *_section_lines(lines)]
    return "\n".join(parts) + "\n"


def file_name() -> str:
    """Return a file name with the current time for a report."""
    return f"vomstudio-report-{time.strftime('%Y%m%d-%H%M%S')}.txt"


def versions() -> list[str]:
    """Return the versions of the program, Python, the system and the installed libraries.

    The libraries are not imported.
    """
    lines = [
        f"VOM Studio {__version__}",
        f"Python {platform.python_version()} ({platform.python_implementation()})",
        f"System {platform.platform()}, {platform.machine()}",
        f"Installed as {'one program' if getattr(sys, 'frozen', False) else 'a package'}",
    ]
    return lines + [f"{name} {version}" for name, version in packages().items()]


def packages() -> dict[str, str]:
    """Return the versions of the installed libraries by their names in the package index."""
    # Imported late, because the empty window would wait for it.
    from importlib import metadata

    versions_by_name = {}
    for name in _LIBRARIES:
        try:
            versions_by_name[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return versions_by_name


def _crash_lines(private_words: list[str]) -> list[str]:
    lines: list[str] = []
    for role, text in crashes.texts():
        lines += [f"A {role} process:", *redact(text, private_words).splitlines(), ""]
    return lines


def _section_lines(lines: Callable[[], Sequence[str]]) -> Sequence[str]:
    try:
        return lines() or ["none"]
    except Exception as error:  # noqa: BLE001 - the other sections must still be written
        return [f"This section failed ({type(error).__name__})."]
