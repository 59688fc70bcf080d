"""Lithologies in the vocabulary of StraboSpot (sedimentary form "Lithologies")."""

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
"""Dunham's mudstone is called "lime mudstone", because "mudstone" alone is siliciclastic."""
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
COVERED_ROCK_WORDS = ("covered", "unexposed")
LITHOLOGIES = (
    *SILICICLASTIC,
    *(word.replace("_", " ") for word in PRIMARY),
    "lime mudstone",
    *DUNHAM,
    *VOLCANICLASTIC,
    *ORGANIC,
    *EVAPORITE,
    "covered",
)
"""All accepted lithologies without duplicates."""
FIELDS = ("primary_lithology", "siliciclastic_type", "dunham_classification", "other_type")


def lithology_choices() -> tuple[str, ...]:
    """Return all lithologies accepted by `strabospot_fields`, the common ones first."""
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
        *COVERED_ROCK_WORDS,
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
"""Colours of lithologies on the state geologic maps of the U.S. Geological Survey."""


def color_of_rock(word: str) -> str:
    """Return the map colour of a lithology.

    If the lithology has no colour of its own, the colour of its class is used.

    Parameters
    ----------
    word : str
        Name of a lithology.

    Returns
    -------
    str
        Colour as "#rrggbb"; "" for covered intervals and unknown lithologies.
    """
    fields = strabospot_fields(word) or {}
    values = [value for value in fields.values() if value]
    return next((_COLORS[value] for value in reversed(values) if value in _COLORS), "")


def strabospot_fields(word: str) -> dict[str, str] | None:
    """Return the StraboSpot fields of a lithology; case and separators are ignored.

    Returns
    -------
    dict or None
        `primary_lithology` and the subtype. All values are empty for "" and for covered intervals;
        None for a name that is not in the vocabulary of StraboSpot.
    """
    normalized_text = " ".join(word.casefold().replace("_", " ").replace("/", " ").split())
    fields = dict.fromkeys(FIELDS, "")
    if not normalized_text or normalized_text in COVERED_ROCK_WORDS:
        return fields
    for primary in PRIMARY:
        if normalized_text == primary.replace("_", " "):
            return {**fields, "primary_lithology": primary}
    if normalized_text in SILICICLASTIC:
        return {
            **fields,
            "primary_lithology": "siliciclastic",
            "siliciclastic_type": normalized_text,
        }
    if normalized_text in ("lime mudstone", *DUNHAM):
        name = normalized_text.removeprefix("lime ")
        return {**fields, "primary_lithology": "limestone", "dunham_classification": name}
    for primary, names in (
        ("volcaniclastic", VOLCANICLASTIC),
        ("organic_coal", ORGANIC),
        ("evaporite", EVAPORITE),
    ):
        if normalized_text in names:
            return {**fields, "primary_lithology": primary, "other_type": normalized_text}
    return None
