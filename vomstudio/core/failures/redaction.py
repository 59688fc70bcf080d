"""Removes coordinates, paths and file names from a report."""

from __future__ import annotations

import re
import sysconfig
from collections.abc import Iterable
from functools import cache
from pathlib import Path, PurePosixPath

_PATH = re.compile(r"""(?<![\w.~/\\<>])(?:[A-Za-z]:[\\/]|\\\\|~?/(?=[^\s/]))[^\n"'<>|:;,)\]]*""")
_FILE = re.compile(
    r"""[^\s"'/\\(\[=]+\.(?P<suffix>obj|mtl|ply|glb|gltf|stl|las|laz|e57|xyz|pts|txt|csv|prj|jpe?g"""
    r"""|png|tiff?|dng|heic|mp4|mov|avi|gpkg|shp|dbf|dxf|tfw|xml|json|toml|vom|zip)\b""",
    re.IGNORECASE,
)
# A version has two dots or more; what has one may be a coordinate, and so may a long number.
_NUMBER = re.compile(
    r"(?<![\w.])(?P<version>\d+(?:\.\d+){2,})|(?<![\w.])-?(?:\d+\.\d*|\.\d+|\d+(?=[eE][-+]?\d)|\d{5,})"
    r"(?:[eE][-+]?\d+)?"
)


def scrub(text: str, private: Iterable[str] = ()) -> str:
    """`text` without the user's paths, file names, `private` words and coordinates.

    Rather too much goes than too little: what looks like a decimal or a long number is taken for a
    coordinate, and all of a path that is not the program's own but its ending.
    """
    words = sorted({word for word in private if len(word) > 2}, key=len, reverse=True)
    text = _PATH.sub(lambda found: _shown(found[0]), text)
    for word in words:
        text = re.sub(rf"(?<!\w){re.escape(word)}(?!\w)", "…", text)
    text = _FILE.sub(lambda found: f"….{found['suffix']}", text)
    return _NUMBER.sub(lambda found: found["version"] or "#", text)


def _shown(path: str) -> str:
    rest = path.rstrip()
    tail = path[len(rest) :]
    for root, name in _roots():
        if rest.startswith(root):
            return name + rest[len(root) :].replace("\\", "/") + tail
    home = str(Path.home())
    at_home = rest.startswith((home, home.replace("\\", "\\\\"), "~"))
    return ("~" if at_home else "") + "/…" + PurePosixPath(rest.replace("\\", "/")).suffix + tail


@cache
def _roots() -> list[tuple[str, str]]:
    """Folders of the program and of Python, whose files are everybody's."""
    package = Path(__file__).resolve().parents[2]
    places = {str(package): "<program>"}
    for key, name in (("purelib", "<packages>"), ("platlib", "<packages>"), ("stdlib", "<python>")):
        places.setdefault(sysconfig.get_path(key), name)
    return sorted(places.items(), key=lambda place: len(place[0]), reverse=True)
