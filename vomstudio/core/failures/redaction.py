"""Removal of coordinates, paths and file names from a report."""

from __future__ import annotations

import re
import sysconfig
from collections.abc import Iterable
from functools import cache
from pathlib import Path, PurePosixPath

_PATH_PATTERN = re.compile(
    r"""(?<![\w.~/\\<>])(?:[A-Za-z]:[\\/]|\\\\|~?/(?=[^\s/]))[^\n"'<>|:;,)\]]*"""
)
_FILE_NAME_PATTERN = re.compile(
    r"""[^\s"'/\\(\[=]+\.(?P<suffix>obj|mtl|ply|glb|gltf|stl|las|laz|e57|ptx|xyz|pts|txt|csv|prj|jpe?g"""
    r"""|png|tiff?|dng|heic|mp4|mov|avi|gpkg|shp|dbf|dxf|tfw|xml|json|toml|vom|zip)\b""",
    re.IGNORECASE,
)
# A version number has at least two dots; a number with one dot or many digits may be a coordinate.
_NUMBER_PATTERN = re.compile(
    r"(?<![\w.])(?P<version>\d+(?:\.\d+){2,})|(?<![\w.])-?(?:\d+\.\d*|\.\d+|\d+(?=[eE][-+]?\d)|\d{5,})"
    r"(?:[eE][-+]?\d+)?"
)


def redact(text: str, private_words: Iterable[str] = ()) -> str:
    """Remove the user's paths and file names, private words and coordinates from a text.

    The function removes too much rather than too little: it treats every decimal or long number as
    a coordinate, and keeps only the extension of a path outside the program.

    Parameters
    ----------
    text : str
    private_words : iterable of str
        Words to remove, such as project names.
    """
    longest_words = sorted({word for word in private_words if len(word) > 2}, key=len, reverse=True)
    text = _PATH_PATTERN.sub(lambda match: _redact_path(match[0]), text)
    for word in longest_words:
        text = re.sub(rf"(?<!\w){re.escape(word)}(?!\w)", "…", text)
    text = _FILE_NAME_PATTERN.sub(lambda match: f"….{match['suffix']}", text)
    return _NUMBER_PATTERN.sub(lambda match: match["version"] or "#", text)


def _redact_path(path: str) -> str:
    trimmed_path = path.rstrip()
    trailing_space = path[len(trimmed_path) :]
    for root, name in _program_folders():
        if trimmed_path.startswith(root):
            return name + trimmed_path[len(root) :].replace("\\", "/") + trailing_space
    home = str(Path.home())
    is_in_home = trimmed_path.startswith((home, home.replace("\\", "\\\\"), "~"))
    return (
        ("~" if is_in_home else "")
        + "/…"
        + PurePosixPath(trimmed_path.replace("\\", "/")).suffix
        + trailing_space
    )


@cache
def _program_folders() -> list[tuple[str, str]]:
    """Return the folders of the program and of Python, whose paths are not private."""
    package = Path(__file__).resolve().parents[2]
    positions = {str(package): "<program>"}
    for key, name in (("purelib", "<packages>"), ("platlib", "<packages>"), ("stdlib", "<python>")):
        positions.setdefault(sysconfig.get_path(key), name)
    return sorted(positions.items(), key=lambda place: len(place[0]), reverse=True)
