"""The search finds commands by name, synonym and description, in this order."""

from __future__ import annotations

import pytest

from vomstudio.ui.base.search import SYNONYMS, SearchEntry, rank, synonyms_of

UNDO = SearchEntry("undo", "Undo")
UNDO_CLICK = SearchEntry("undo_click", "Undo last click")
COMPACT = SearchEntry("take_back", "Undo compaction")
EXPORT = SearchEntry("gpkg", "Export GIS layers", ("geopackage", "gis layers"), "All features.")
SAVE = SearchEntry("save", "Save", (), "Writes the GIS layers of the project.")
BOX = SearchEntry("box", "Clipping box", ("crop",), "Show only what is inside a box.")
VIEW = SearchEntry("view", "Boxes", ("wrap",), "")
ENTRIES = [UNDO_CLICK, COMPACT, UNDO, SAVE, EXPORT, VIEW, BOX]


@pytest.mark.parametrize(
    ("query", "first"),
    [
        ("undo", UNDO),
        ("UNDO last", UNDO_CLICK),
        ("gis layers", EXPORT),
        ("export gis", EXPORT),
        ("geopackage", EXPORT),
        ("box", BOX),
        ("crop", BOX),
        ("ropp", None),
        ("compac", COMPACT),
        ("inside", BOX),
    ],
)
def test_the_best_match_is_first(query, first):
    ranked = rank(query, ENTRIES)
    assert (ranked[0] if ranked else None) is first


def test_every_word_must_be_found():
    assert rank("clipping undo", ENTRIES) == []


def test_titles_come_before_synonyms_and_descriptions():
    one = SearchEntry("1", "Red fox")
    two = SearchEntry("2", "Blue", ("fox den",))
    three = SearchEntry("3", "Green", (), "A fox")
    assert rank("fox", [three, two, one]) == [one, two, three]


def test_whole_words_come_before_prefixes_and_parts():
    part, prefix, whole = (SearchEntry(t, t) for t in ("Scarfold", "Folding axis", "Fold axis"))
    assert rank("fold", [part, prefix, whole]) == [whole, prefix, part]


def test_recent_entries_are_first_on_a_tie_only():
    one, two = SearchEntry("1", "Alpha map"), SearchEntry("2", "Beta map")
    assert rank("map", [one, two]) == [one, two]
    assert rank("map", [one, two], ["2"]) == [two, one]
    assert rank("alpha", [one, two], ["2"]) == [one]
    better = SearchEntry("3", "Map")
    assert rank("map", [one, two, better], ["2"]) == [better, two, one]


def test_without_words_all_are_listed():
    assert rank("  ", ENTRIES) == ENTRIES


def test_synonyms_belong_to_commands(window):
    assert set(SYNONYMS) <= set(window.actions_table.all)
    assert "gpkg" in synonyms_of("export_gpkg")
    assert synonyms_of("no such command") == ()
