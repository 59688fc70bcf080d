"""The search finds commands by name, synonym and description, in this order."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt

from vomstudio.ui.base.search import SYNONYMS, SearchEntry, command_synonyms, rank
from vomstudio.ui.dialogs.command_palette import CommandPalette

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


def test_empty_query_lists_all_entries():
    assert rank("  ", ENTRIES) == ENTRIES


QUERIES = {
    "export gis": "export_gpkg",
    "gis layers": "export_gpkg",
    "gpkg": "export_gpkg",
    "clipping box": "clipping_box",
    "field measurements": "import_readings",
    "fold axis": "along_beta",
    "rose": "rose_diagram",
    "contours": "net_contours",
    "kamb": "net_contours",
    "hide labels": "labels",
    "labels": "labels",
    "undo": "undo",
    "trace": "trace",
    "grow plane": "plane",
    "lasso": "plane_lasso",
    "orthophoto": "orthophoto",
    "dem": "elevation_model",
    "section": "section",
    "crs": "declare_frame",
    "coordinate system": "declare_frame",
    "save": "save",
    "dark": "theme_dark",
    "reset": "reset_panels",
    "facets": "propose_facets",
    "sets": "propose_sets",
    "report": "open_report",
    "shortcuts": "shortcuts",
    "north": "control",
    "scale bar": "known_line",
    "thickness": "measure_thickness",
}


def test_intended_command_is_ranked_first(window):
    palette = CommandPalette(window, window.actions_table, window._search_destinations())
    first = {}
    for query in QUERIES:
        palette._search.setText(query)
        first[query] = palette._list.item(0).data(Qt.ItemDataRole.UserRole)
    assert first == QUERIES


def test_pages_and_documents_are_found_and_opened(window):
    palette = CommandPalette(window, window.actions_table, window._search_destinations())
    palette._search.setText("page statistics")
    assert palette.selected_command == "page_statistics"
    palette.run_selected()
    assert window.docks.page("drawer") == "statistics"
    palette._search.setText("help first steps")
    assert palette.selected_command == "document_first_steps"


def test_synonyms_belong_to_commands(window):
    assert set(SYNONYMS) <= set(window.actions_table.all)
    assert "gpkg" in command_synonyms("export_gpkg")
    assert command_synonyms("xyzzy") == ()
