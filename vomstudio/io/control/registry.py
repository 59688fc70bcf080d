"""Which format takes which file of ground control.

A new format is one module in `vomstudio/io/control/formats` that defines `CONTROL_FORMAT`, or a
package of someone else that names a `ControlFormat` in the entry point group
`vomstudio.control_formats`.
"""

from __future__ import annotations

import functools
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.plugins import LoadedPlugins, find_plugins

GROUP = "vomstudio.control_formats"


@functools.cache
def find_formats() -> LoadedPlugins[ControlFormat]:
    from vomstudio.io.control import formats

    return find_plugins(formats, "CONTROL_FORMAT", ControlFormat, GROUP)


def extensions() -> tuple[str, ...]:
    """Every extension that files of ground control have, for file dialogs."""
    return tuple(dict.fromkeys(e for one in find_formats().all for e in one.extensions))


def choose_format(path: Path) -> ControlFormat:
    """By the file's content, a certain format before those that take what nobody else knows.
    Raises InputError for a damaged file."""
    found = find_formats()
    for format_ in sorted(found.all, key=lambda one: not one.certain):
        if format_.matches(path):
            return format_
    known = [*(tr(one.name) for one in found.all), *map(str, found.broken)]
    raise InputError(Finding("control.unknown-format", formats=known), file=path)
