"""Options of repeated picks, declared once for all interfaces."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class RepeatOptions(Options):
    """Columns that identify repeated picks of a structure and the interpreters."""

    by: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column with the same word for picks of the same structure"),
        automatic=to_translate("repeat_of, the id of the pick that a row repeats"),
    )
    interpreter: str | None = option(
        None,
        metavar="COLUMN",
        help=to_translate("column of the person who picked"),
        automatic=to_translate("interpreter, if there is one"),
    )
