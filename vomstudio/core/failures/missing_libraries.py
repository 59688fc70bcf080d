"""Libraries of the system that a package of ours needs and that are not there."""

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
"""Of Debian and Ubuntu, by the name of the library without its number."""
_LIBRARY = re.compile(r"\b(lib[\w.+-]+?)\.so[.\d]*")


def missing_library(error: BaseException | str) -> Finding | None:
    """Return which library is missing and the package to install; None for another failure."""
    found = _LIBRARY.search(str(error))
    if found is None:
        return None
    package = _PACKAGES.get(found[1])
    if package is None:
        return Finding("program.library-missing", library=found[0])
    return Finding("program.package-missing", library=found[0], package=package)
