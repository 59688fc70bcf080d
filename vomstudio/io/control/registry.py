"""Registry of ground control formats.

A new format is either a module in `vomstudio/io/control/formats` that defines `CONTROL_FORMAT`, or
a third-party package that declares a `ControlFormat` in the entry point group
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
    """Return the formats of ground control, including plugins."""
    from vomstudio.io.control import formats

    return find_plugins(formats, "CONTROL_FORMAT", ControlFormat, GROUP)


def extensions() -> tuple[str, ...]:
    """Return all extensions of ground control files, for file dialogs."""
    return tuple(
        dict.fromkeys(
            extension
            for control_format in find_formats().all
            for extension in control_format.extensions
        )
    )


def choose_format(path: Path) -> ControlFormat:
    """Detect the format of a file from its content, trying specific formats first.

    Raises InputError if the file is damaged.
    """
    available_formats = find_formats()
    for format_ in sorted(
        available_formats.all, key=lambda control_format: not control_format.is_certain
    ):
        if format_.matches(path):
            return format_
    names = [
        *(tr(control_format.name) for control_format in available_formats.all),
        *map(str, available_formats.problems),
    ]
    raise InputError(Finding("control.unknown-format", formats=names), file=path)
