"""Extensions of output files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding


def check_extension(
    path: str | Path, extensions: Iterable[str], field: str | None = "--output"
) -> str:
    """Return the extension of an output file in lower case.

    Raises
    ------
    UsageError
        If the extension is not one of `extensions`.
    """
    suffix = Path(path).suffix.lower()
    formats = tuple(extensions)
    if suffix not in formats:
        cause = Finding("output.unknown-format", suffix=suffix, formats=formats)
        raise UsageError(cause, file=path, field=field)
    return suffix
