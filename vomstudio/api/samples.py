"""The embedded sample outcrop."""

from __future__ import annotations

from pathlib import Path

from vomstudio.api.checking import path_of
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding


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
    from vomstudio.core.paths import resource

    names = [str(path_of(part, "parts")) for part in parts]
    try:
        return resource("sample", *names)
    except InputError as error:
        raise InputError(Finding("file.missing"), file=error.file, field="parts") from error
