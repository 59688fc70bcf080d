"""Language of the program: message catalogues, selected by the environment."""

from __future__ import annotations

import gettext
import os
import struct
from pathlib import Path

from vomstudio.core.words import use_catalogue

DOMAIN = "vomstudio"
_LANGUAGE_VARIABLES = ("VOMSTUDIO_LANGUAGE", "LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")


def use_user_language(folder: Path | None = None) -> None:
    """Load the catalogue of the user's language, or use English if it is missing or invalid.

    The language is the value of VOMSTUDIO_LANGUAGE or, if that is not set, of the usual gettext
    variables.

    Parameters
    ----------
    folder : Path, optional
        Folder of catalogues, ``LANGUAGE/LC_MESSAGES/vomstudio.mo``. If None, the program's folder
        is used.
    """
    folder = _default_folder() if folder is None else folder
    language = next((value for name in _LANGUAGE_VARIABLES if (value := os.environ.get(name))), "")
    if folder is None or not language or language.partition(".")[0] in ("C", "POSIX"):
        use_catalogue(None)
        return
    try:
        use_catalogue(gettext.translation(DOMAIN, folder, languages=language.split(":")))
    except (OSError, ValueError, struct.error):
        use_catalogue(None)


def _default_folder() -> Path | None:
    from vomstudio.core.errors import InputError
    from vomstudio.core.paths import resource

    try:
        return resource("locale")
    except InputError:
        # Only English is included in the program.
        return None
