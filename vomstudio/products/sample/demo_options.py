"""Options of the demonstration, shared by all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class DemoOptions(Options):
    """Parts of the demonstration to run."""

    without_photos: bool = option(
        False,
        help=to_translate("measure the built-in model only, which takes seconds"),
    )
