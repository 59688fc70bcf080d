"""The embedded sample outcrop."""

from __future__ import annotations

from pathlib import Path


def sample(*parts: str) -> Path:
    """The folder of the embedded sample outcrop, a generated cliff whose geology is known exactly,
    or a file in it.

    Its files: ``sample.obj`` (a textured mesh, EPSG:32633), ``picks.csv`` (points along beds, a
    fault and joints, by ``pick``), ``truth.csv`` (what is true there), ``photos`` (a folder),
    ``control.csv`` and ``marks.csv``.

    parts : of the path below that folder. Raises vs.errors.InputError for a file that is not there.

    >>> import vomstudio as vs
    >>> vs.sample("sample.obj").name
    'sample.obj'
    """
    from vomstudio.paths import resource

    return resource("sample", *parts)
