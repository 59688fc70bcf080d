"""Every string that a user sees passes through here, so that it can stand in their language.

English is written in the code and is what is shown where there is no catalogue, or none of its
entries fits. Codes, columns, keys of JSON and the words of verdicts are data and never pass here.
This module knows no folder: whoever starts the program hands it a catalogue.
"""

from __future__ import annotations

import gettext
from functools import lru_cache
from string import Formatter

__all__ = ["to_translate", "to_translate_n", "tr", "tr_n", "use_catalogue"]

_catalogue, _english = gettext.NullTranslations(), True


def use_catalogue(catalogue: gettext.NullTranslations | None) -> None:
    """From now on strings come from this catalogue; None stands for English."""
    global _catalogue, _english
    _catalogue, _english = catalogue or gettext.NullTranslations(), catalogue is None


def tr(message: str, /, **values: object) -> str:
    """The message in the user's language, its named placeholders filled.

    `tr("{name} has {count} points.", name=name, count=count)`. Placeholders are those of
    `str.format`, with its formats (`{length:.2f}`). Without values nothing is filled and braces are
    themselves. A translation with other placeholders than the English is not used.
    """
    if _english:
        # Tables of thousands of rows ask for hundreds of thousands of sentences.
        return message.format(**values) if values else message
    return _filled(_catalogue.gettext(message), message, values)


def tr_n(one: str, many: str, count: int, /, **values: object) -> str:
    """As `tr`, in the form that goes with a number, which is the placeholder `{count}`.

    `tr_n("{count} photo", "{count} photos", 3)`. Languages have up to six forms of the plural, so
    an s must never be glued on.
    """
    english = one if count == 1 else many
    return _filled(
        _catalogue.ngettext(one, many, count), english, {"count": count, **values}, also=one
    )


def to_translate(message: str) -> str:
    """The message as it is, noted for translators: for constants, which `tr` is given where they
    are shown. A constant is made before there is a catalogue."""
    return message


def to_translate_n(one: str, many: str) -> tuple[str, str]:
    """Mark the texts for one and for several of a constant that `tr_n` receives."""
    return one, many


def _filled(
    translated: str, english: str, values: dict[str, object], also: str | None = None
) -> str:
    if not values:
        return translated or english
    if translated != english and _placeholders(translated) in (
        _placeholders(english),
        _placeholders(also or english),
    ):
        try:
            return translated.format(**values)
        except (ValueError, TypeError):
            # A format that this kind of value does not have.
            pass
    return english.format(**values)


@lru_cache(maxsize=4096)
def _placeholders(message: str) -> frozenset[str] | None:
    """The names in a message, or None where its braces are wrong or reach into a value."""
    try:
        names = frozenset(name for _, name, _, _ in Formatter().parse(message) if name is not None)
    except ValueError:
        return None
    return names if all(name.isidentifier() for name in names) else None
