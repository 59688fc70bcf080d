"""Rocks in the words of StraboSpot's sedimentary forms (the lists of its form "Lithologies")."""

from __future__ import annotations

PRIMARY = (
    "siliciclastic",
    "limestone",
    "dolostone",
    "organic_coal",
    "evaporite",
    "chert",
    "ironstone",
    "phosphatic",
    "volcaniclastic",
)
SILICICLASTIC = (
    "claystone",
    "mudstone",
    "shale",
    "siltstone",
    "sandstone",
    "conglomerate",
    "breccia",
)
DUNHAM = (
    "wackestone",
    "packstone",
    "grainstone",
    "boundstone",
    "cementstone",
    "recrystallized",
    "floatstone",
    "rudstone",
    "framestone",
    "bafflestone",
    "bindstone",
)
"""Dunham's mudstone is written "lime mudstone", for mudstone alone is siliciclastic."""
VOLCANICLASTIC = (
    "volcanic mudstone",
    "volcanic sandstone",
    "lapillistone",
    "agglomerate",
    "volcanic breccia",
    "bentonite",
    "tuff",
    "welded tuff",
    "ignimbrite",
)
ORGANIC = ("amber", "peat", "lignite", "subbituminous", "bituminous", "coal ball", "tar", "coal")
EVAPORITE = ("gypsum", "anhydrite", "halite")
COVERED = ("covered", "unexposed")
WORDS = (
    *SILICICLASTIC,
    *(word.replace("_", " ") for word in PRIMARY),
    "lime mudstone",
    *DUNHAM,
    *VOLCANICLASTIC,
    *ORGANIC,
    *EVAPORITE,
    "covered",
)
"""What a rock may be called, each once."""
FIELDS = ("primary_lithology", "siliciclastic_type", "dunham_classification", "other_type")


def words() -> tuple[str, ...]:
    """All that `in_strabospot` knows, to choose from: first the common rocks of the field."""
    primary = tuple(name.replace("_", " ") for name in PRIMARY)
    return (
        *SILICICLASTIC,
        "limestone",
        "lime mudstone",
        *DUNHAM,
        "dolostone",
        *(name for name in primary if name not in ("limestone", "dolostone")),
        *EVAPORITE,
        *ORGANIC,
        *VOLCANICLASTIC,
        *COVERED,
    )


_COLORS = {
    "siliciclastic": "#d9fdd3",
    "claystone": "#d5e6cc",
    "mudstone": "#cfefdf",
    "shale": "#ace4c8",
    "siltstone": "#d6fe9a",
    "sandstone": "#cdffd9",
    "conglomerate": "#b7d9cc",
    "breccia": "#a7ba86",
    "limestone": "#43aff9",
    "dolostone": "#6bc3ff",
    "organic_coal": "#820041",
    "peat": "#ffcf81",
    "evaporite": "#019ccd",
    "chert": "#9abfc0",
    "ironstone": "#b99598",
    "phosphatic": "#bfe3dc",
    "volcaniclastic": "#ffe0de",
    "bentonite": "#c0d0c0",
    "tuff": "#f9d3d3",
    "welded tuff": "#fff3c9",
    "ignimbrite": "#ffe5c3",
}
"""The colours of lithologies on the state geologic maps of the U.S. Geological Survey."""


def color_of_rock(word: str) -> str:
    """The colour of a rock on a map, "#rrggbb": its own, else that of its class; "" for what is
    covered, and for words that StraboSpot's forms do not have."""
    fields = in_strabospot(word) or {}
    told = [value for value in fields.values() if value]
    return next((_COLORS[value] for value in reversed(told) if value in _COLORS), "")


def in_strabospot(word: str) -> dict[str, str] | None:
    """The fields of StraboSpot for a rock, case and separators forgiven: `primary_lithology` and
    what it is called more closely; all empty for nothing and what is covered; None for a word that
    its forms do not have."""
    plain = " ".join(word.casefold().replace("_", " ").replace("/", " ").split())
    found = dict.fromkeys(FIELDS, "")
    if not plain or plain in COVERED:
        return found
    for primary in PRIMARY:
        if plain == primary.replace("_", " "):
            return {**found, "primary_lithology": primary}
    if plain in SILICICLASTIC:
        return {**found, "primary_lithology": "siliciclastic", "siliciclastic_type": plain}
    if plain in ("lime mudstone", *DUNHAM):
        name = plain.removeprefix("lime ")
        return {**found, "primary_lithology": "limestone", "dunham_classification": name}
    for primary, names in (
        ("volcaniclastic", VOLCANICLASTIC),
        ("organic_coal", ORGANIC),
        ("evaporite", EVAPORITE),
    ):
        if plain in names:
            return {**found, "primary_lithology": primary, "other_type": plain}
    return None
