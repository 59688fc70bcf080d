"""Lithologies in the vocabulary of StraboSpot (sedimentary form "Lithologies")."""

from __future__ import annotations

PRIMARY_LITHOLOGIES = (
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
SILICICLASTIC_TYPES = (
    "claystone",
    "mudstone",
    "shale",
    "siltstone",
    "sandstone",
    "conglomerate",
    "breccia",
)
DUNHAM_CLASSES = (
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
"""Dunham's classes; his mudstone is "lime mudstone", because "mudstone" alone is siliciclastic."""
VOLCANICLASTIC_TYPES = (
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
ORGANIC_TYPES = (
    "amber",
    "peat",
    "lignite",
    "subbituminous",
    "bituminous",
    "coal ball",
    "tar",
    "coal",
)
EVAPORITE_TYPES = ("gypsum", "anhydrite", "halite")
COVERED_INTERVAL_WORDS = ("covered", "unexposed")
LITHOLOGIES = (
    *SILICICLASTIC_TYPES,
    *(word.replace("_", " ") for word in PRIMARY_LITHOLOGIES),
    "lime mudstone",
    *DUNHAM_CLASSES,
    *VOLCANICLASTIC_TYPES,
    *ORGANIC_TYPES,
    *EVAPORITE_TYPES,
    "covered",
)
"""All accepted lithologies without duplicates."""
STRABOSPOT_FIELDS = (
    "primary_lithology",
    "siliciclastic_type",
    "dunham_classification",
    "other_type",
)


def lithology_choices() -> tuple[str, ...]:
    """Return all lithologies accepted by `strabospot_fields`, the common ones first."""
    primary_names = tuple(name.replace("_", " ") for name in PRIMARY_LITHOLOGIES)
    return (
        *SILICICLASTIC_TYPES,
        "limestone",
        "lime mudstone",
        *DUNHAM_CLASSES,
        "dolostone",
        *(name for name in primary_names if name not in ("limestone", "dolostone")),
        *EVAPORITE_TYPES,
        *ORGANIC_TYPES,
        *VOLCANICLASTIC_TYPES,
        *COVERED_INTERVAL_WORDS,
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


def lithology_color(word: str) -> str:
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
    fields = dict.fromkeys(STRABOSPOT_FIELDS, "")
    if not normalized_text or normalized_text in COVERED_INTERVAL_WORDS:
        return fields
    for primary in PRIMARY_LITHOLOGIES:
        if normalized_text == primary.replace("_", " "):
            return {**fields, "primary_lithology": primary}
    if normalized_text in SILICICLASTIC_TYPES:
        return {
            **fields,
            "primary_lithology": "siliciclastic",
            "siliciclastic_type": normalized_text,
        }
    if normalized_text in ("lime mudstone", *DUNHAM_CLASSES):
        name = normalized_text.removeprefix("lime ")
        return {**fields, "primary_lithology": "limestone", "dunham_classification": name}
    for primary, names in (
        ("volcaniclastic", VOLCANICLASTIC_TYPES),
        ("organic_coal", ORGANIC_TYPES),
        ("evaporite", EVAPORITE_TYPES),
    ):
        if normalized_text in names:
            return {**fields, "primary_lithology": primary, "other_type": normalized_text}
    return None
