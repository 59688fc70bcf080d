"""Translation of every string that is displayed to the user.

The source code contains the English text, which is displayed unless a catalogue has a valid entry.
Codes, columns, JSON keys and the words of verdicts are data and are not translated. This module
does not depend on any folder: the entry points load the catalogue.
"""

from __future__ import annotations

import gettext
from functools import lru_cache
from string import Formatter

__all__ = ["to_translate", "to_translate_n", "tr", "tr_n", "use_catalogue"]

_catalogue, _is_english = gettext.NullTranslations(), True


def use_catalogue(catalogue: gettext.NullTranslations | None) -> None:
    """Translate strings with a catalogue from now on; None selects English."""
    global _catalogue, _is_english
    _catalogue, _is_english = catalogue or gettext.NullTranslations(), catalogue is None


def tr(message: str, /, **values: object) -> str:
    """Translate a message to the user's language and fill its named placeholders.

    A translation whose placeholders differ from those of the English text is not used.

    Parameters
    ----------
    message : str
        English text with `str.format` placeholders such as ``{length:.2f}``.
    **values
        Values of the placeholders. Without values, braces are literal.

    Examples
    --------
    >>> tr("{name} has {count} points.", name="Trace 1", count=3)
    'Trace 1 has 3 points.'
    """
    if _is_english:
        # Tables of thousands of rows contain hundreds of thousands of sentences.
        return message.format(**values) if values else message
    return _fill(_catalogue.gettext(message), message, values)


def tr_n(singular: str, plural: str, count: int, /, **values: object) -> str:
    """Translate a message in the plural form that matches a number, in the same way as `tr`.

    Languages have up to six plural forms, so never form a plural by appending an s.

    Parameters
    ----------
    singular, plural : str
        English texts for one item and for several items.
    count : int
        The number, which is also the value of the placeholder ``{count}``.
    **values
        Values of the other placeholders.

    Examples
    --------
    >>> tr_n("{count} photo", "{count} photos", 3)
    '3 photos'
    """
    english_text = singular if count == 1 else plural
    return _fill(
        _catalogue.ngettext(singular, plural, count),
        english_text,
        {"count": count, **values},
        singular=singular,
    )


def to_translate(message: str) -> str:
    """Mark a constant for translators and return it unchanged.

    A constant is created before the catalogue is loaded; pass it to `tr` where it is displayed.
    """
    return message


def to_translate_n(singular: str, plural: str) -> tuple[str, str]:
    """Mark the singular and plural texts of a constant for `tr_n`."""
    return singular, plural


def _fill(
    translated_text: str, english_text: str, values: dict[str, object], singular: str | None = None
) -> str:
    if not values:
        return translated_text or english_text
    if translated_text != english_text and _placeholders(translated_text) in (
        _placeholders(english_text),
        _placeholders(singular or english_text),
    ):
        try:
            return translated_text.format(**values)
        except (ValueError, TypeError):
            # The translation has a format that the value does not support.
            pass
    return english_text.format(**values)


@lru_cache(maxsize=4096)
def _placeholders(message: str) -> frozenset[str] | None:
    """Return the placeholder names, or None if braces are unbalanced or access attributes."""
    try:
        names = frozenset(name for _, name, _, _ in Formatter().parse(message) if name is not None)
    except ValueError:
        return None
    return names if all(name.isidentifier() for name in names) else None
