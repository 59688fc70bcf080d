"""Detection of system libraries that a dependency needs but that are not installed."""

from __future__ import annotations

import re

from vomstudio.core.findings import Finding

_PACKAGES = {
    "libEGL": "libegl1",
    "libGL": "libgl1",
    "libOpenGL": "libopengl0",
    "libGLX": "libglx0",
    "libX11": "libx11-6",
    "libX11-xcb": "libx11-xcb1",
    "libxcb-cursor": "libxcb-cursor0",
    "libxcb-icccm": "libxcb-icccm4",
    "libxcb-image": "libxcb-image0",
    "libxcb-keysyms": "libxcb-keysyms1",
    "libxcb-randr": "libxcb-randr0",
    "libxcb-render-util": "libxcb-render-util0",
    "libxcb-render": "libxcb-render0",
    "libxcb-shape": "libxcb-shape0",
    "libxcb-shm": "libxcb-shm0",
    "libxcb-sync": "libxcb-sync1",
    "libxcb-util": "libxcb-util1",
    "libxcb-xfixes": "libxcb-xfixes0",
    "libxcb-xkb": "libxcb-xkb1",
    "libxcb": "libxcb1",
    "libxkbcommon-x11": "libxkbcommon-x11-0",
    "libxkbcommon": "libxkbcommon0",
    "libusb-1.0": "libusb-1.0-0",
    "libgomp": "libgomp1",
    "libfontconfig": "libfontconfig1",
    "libdbus-1": "libdbus-1-3",
}
"""Debian and Ubuntu packages by library name without the version."""
_LIBRARY_PATTERN = re.compile(r"\b(lib[\w.+-]+?)\.so[.\d]*")


def missing_library(error: BaseException | str) -> Finding | None:
    """Return a finding with the missing library and its package, or None for other failures."""
    match = _LIBRARY_PATTERN.search(str(error))
    if match is None:
        return None
    package = _PACKAGES.get(match[1])
    if package is None:
        return Finding("program.library-missing", library=match[0])
    return Finding("program.package-missing", library=match[0], package=package)
