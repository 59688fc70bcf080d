"""The embedded sample outcrop."""

from __future__ import annotations

from pathlib import Path

from vomstudio.api.checking import to_path
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding


def sample(*parts: str) -> Path:
    """Return the folder of the embedded sample outcrop, or a file in it.

    It is a generated cliff with exactly known geology: ``sample.obj`` (a textured mesh,
    EPSG:32633), ``picks.csv`` (points along beds, a fault and joints, by ``pick``),
    ``truth.csv`` (the true values), ``photos`` (a folder), ``control.csv`` and ``marks.csv``.

    Parameters
    ----------
    *parts : str
        Parts of the path below that folder.

    Returns
    -------
    Path

    Raises
    ------
    vs.errors.InputError
        If the file does not exist.

    Examples
    --------
    >>> import vomstudio as vs
    >>> vs.sample("sample.obj").name
    'sample.obj'
    """
    from vomstudio.core.paths import resource

    names = [str(to_path(part, "parts")) for part in parts]
    try:
        return resource("sample", *names)
    except InputError as error:
        raise InputError(Finding("file.missing"), file=error.file, field="parts") from error
