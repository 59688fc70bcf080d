"""Which language the program speaks: the catalogues in `resources/locale`, and the user's wish."""

from __future__ import annotations

import gettext
import os
import struct
from pathlib import Path

from vomstudio.core.words import use_catalogue

DOMAIN = "vomstudio"
_WISHES = ("VOMSTUDIO_LANGUAGE", "LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")


def use_users_language(folder: Path | None = None) -> None:
    """Take the catalogue of the user's language, where there is one; else English stays.

    The language is what VOMSTUDIO_LANGUAGE says, else the usual variables of gettext. folder : of
    catalogues, `LANGUAGE/LC_MESSAGES/vomstudio.mo`; by default that of the program. A damaged
    catalogue is as good as none.
    """
    folder = _own_folder() if folder is None else folder
    wish = next((value for name in _WISHES if (value := os.environ.get(name))), "")
    if folder is None or not wish or wish.partition(".")[0] in ("C", "POSIX"):
        use_catalogue(None)
        return
    try:
        use_catalogue(gettext.translation(DOMAIN, folder, languages=wish.split(":")))
    except (OSError, ValueError, struct.error):
        use_catalogue(None)


def _own_folder() -> Path | None:
    from vomstudio.core.errors import InputError
    from vomstudio.core.paths import resource

    try:
        return resource("locale")
    except InputError:
        # Only English is shipped.
        return None
