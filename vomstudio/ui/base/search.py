"""Ranking of commands, pages and documents by the words of a search."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from vomstudio.core.words import to_translate, tr

_WORD = re.compile(r"\w+(?:[-/]\w+)*")
_WHOLE_WORD, _WORD_PREFIX, _WORD_PART, _NO_MATCH = range(4)
_MATCH_KIND_COUNT = 3

SYNONYMS: dict[str, str] = {
    "open": to_translate("load, mesh, point cloud, obj, ply, las, laz, e57, gltf"),
    "choose_photos": to_translate("photogrammetry, images, pictures, structure from motion"),
    "export_gpkg": to_translate("export gis, gis layers, gpkg, geopackage, qgis"),
    "export_shp": to_translate("shp, arcgis"),
    "export_dxf": to_translate("cad, autocad"),
    "export_csv": to_translate("csv, spreadsheet, excel"),
    "export_program": to_translate("stereonet, faultkin, orient, gempy"),
    "project_report": to_translate("html, print, summary of the project"),
    "import_readings": to_translate(
        "field data, compass readings, strike and dip, clino, import csv"
    ),
    "import_drawing": to_translate("import lines, digitised lines, inkscape"),
    "find_command": to_translate("search, palette"),
    "home": to_translate("reset view, zoom all, fit all, zoom extents"),
    "frame_selection": to_translate("zoom to feature, frame"),
    "orthographic": to_translate("parallel projection, perspective"),
    "only_outcrop": to_translate("full screen, hide panels, presentation"),
    "view_top": to_translate("top view, plan view, map view"),
    "notation_dipdir": to_translate("dip direction, notation"),
    "notation_strike": to_translate("strike, right-hand rule, notation"),
    "theme_dark": to_translate("dark, dark mode, dark theme, night"),
    "theme_light": to_translate("light, light mode, light theme"),
    "reset_panels": to_translate("reset, reset panels, default layout, restore panels"),
    "second_view": to_translate(
        "second window, split view, side by side, two views, compare epochs, linked cameras, "
        "second screen, dual view"
    ),
    "page_in_center": to_translate("enlarge, maximise, full page"),
    "declare_frame": to_translate(
        "frame of the model, crs, coordinate system, reference system, epsg, up axis, unit"
    ),
    "register_model": to_translate(
        "georeference, register, ground control, gcp, control points, align"
    ),
    "fit_model": to_translate("icp, cloud to cloud, align two models"),
    "compare_models": to_translate("m3c2, difference, change detection, benchmark"),
    "convert_model": to_translate("reproject, feet, degrees"),
    "export_model": to_translate("save model, obj, ply, glb, laz"),
    "trace": to_translate("polyline, digitise, pick bedding, pick fault"),
    "plane": to_translate(
        "grow plane, patch, brush, paint, surface plane, region growing, grow, magic wand"
    ),
    "plane_lasso": to_translate("lasso, freehand selection"),
    "plane_polygon": to_translate("polygon selection"),
    "contact": to_translate("contact, boundary line"),
    "lithology": to_translate("rock area, facies, lithology polygon"),
    "line": to_translate("lineation, striation, slickenline, hinge, rake"),
    "station": to_translate("sample, locality, waypoint"),
    "labels": to_translate("hide labels, show labels, names of features"),
    "rose_diagram": to_translate("rose, rose of strikes, histogram"),
    "net_contours": to_translate("contours, kamb, density, schmidt contours"),
    "measure_thickness": to_translate("thickness, true thickness, stratigraphic thickness"),
    "measure": to_translate("distance, length, area, height, ruler"),
    "control": to_translate("ground control points, gcp, targets, compass and north, north"),
    "known_line": to_translate(
        "scale bar, known length, known azimuth, horizon, plumb line, level line"
    ),
    "cells": to_translate("mark cells, inspected cells"),
    "edit_feature": to_translate("continue, change vertices, edit vertices"),
    "hide_elements": to_translate("hide vegetation, hide faces"),
    "cut_out": to_translate("crop model, extract part"),
    "follow": to_translate("snap, trace following, autotrace, livewire"),
    "along_beta": to_translate("fold axis, look along fold axis, profile view, beta, plunge"),
    "face_plane": to_translate("look at plane, perpendicular view"),
    "make_model": to_translate("reconstruction, dense cloud, texture"),
    "make_settings": to_translate("quality, memory, threads"),
    "plan_survey": to_translate("flight plan, drone, overlap, planner"),
    "video_frames": to_translate("video, movie"),
    "show_alignment": to_translate("camera calibration, residuals, matches, depth maps"),
    "open_report": to_translate("report, reconstruction report, summary"),
    "orthophoto": to_translate("orthoimage, orthomosaic, geotiff, photo map"),
    "elevation_model": to_translate("dem, dtm, dsm, heights, relief, raster"),
    "section": to_translate("cross section, profile, cut"),
    "propose_sets": to_translate("sets, clusters, cluster analysis, joint sets"),
    "propose_facets": to_translate("facets, find facets, planes automatically, ransac"),
    "propose_traces": to_translate("find traces, edges, lineaments"),
    "surface_fields": to_translate("curvature, roughness, dip map, hsv, colour by orientation"),
    "count_fractures": to_translate(
        "p21, p10, scanline, spacing, fracture intensity, circle, window sampling"
    ),
    "looked_at": to_translate("inspected cells, grid, sampling grid"),
    "repeats": to_translate("repeatability, pick again, operator error"),
    "fault_displacement": to_translate("slip, throw, heave, offset, cutoff"),
    "bed_log": to_translate("sedimentary log, stratigraphic column, thickness log"),
    "verdict_profile": to_translate("quality limits, thresholds, verdict"),
    "type_on_net": to_translate("small circle, great circle, rotate net"),
    "figure_style": to_translate("figure size, fonts, symbols, colours"),
    "export_net": to_translate("save net, stereoplot, svg, pdf"),
    "show_stereonet": to_translate("stereonet, stereoplot, schmidt net, wulff net"),
    "feature_types": to_translate("types, bedding, fault, joint, colours"),
    "planes_discs": to_translate("discs, disks"),
    "clipping_box": to_translate("clip, crop, cut away, section box"),
    "display_field": to_translate("scalar field, colour by, colormap, classification"),
    "display_cameras": to_translate("camera positions, frustums"),
    "documentation": to_translate("help, manual, user guide"),
    "shortcuts": to_translate("keyboard shortcuts, keys, hotkeys"),
    "save_report": to_translate("bug, error report, log file"),
    "three_points": to_translate("three point problem, outcrop pattern"),
    "undo": to_translate("revert, step back"),
}
"""Synonyms of each command, keyed by its name: phrases separated by commas."""


@dataclass(frozen=True)
class SearchEntry:
    """Entry of the search: a command, page or document.

    Attributes
    ----------
    key : str
        Name of the command, page or document.
    synonyms : tuple of str
        Phrases with the same meaning as the title.
    """

    key: str
    title: str
    synonyms: tuple[str, ...] = ()
    description: str = ""


def command_synonyms(name: str) -> tuple[str, ...]:
    """Return the phrases that mean a command, in the user's language."""
    phrases = tr(SYNONYMS[name]).split(",") if name in SYNONYMS else ()
    return tuple(phrase.strip() for phrase in phrases)


def rank(
    query: str, entries: Iterable[SearchEntry], recent_names: Sequence[str] = ()
) -> list[SearchEntry]:
    """Return the entries that contain all words of a query, best match first.

    A title or synonym that equals the query ranks highest. Otherwise titles rank above synonyms and
    descriptions, and whole words above prefixes above parts of words. Equal matches are
    sorted by the number of words in the title, recent use and the order of the entries. A query
    without words returns all entries.
    """
    words = _words(query)
    scored_entries = []
    for position, entry in enumerate(entries):
        score = _score(words, entry)
        if score is not None:
            recency_rank = (
                recent_names.index(entry.key) if entry.key in recent_names else len(recent_names)
            )
            scored_entries.append(((*score, recency_rank, position), entry))
    return [entry for _, entry in sorted(scored_entries, key=lambda scored_entry: scored_entry[0])]


def _words(text: str) -> list[str]:
    return _WORD.findall(text.casefold())


def _score(words: list[str], entry: SearchEntry) -> tuple[int, int, int] | None:
    """Return the sort key of a match, or None if a word is missing.

    The key contains the class of the match, the summed scores of the words and the number of words
    in the title. Lower values rank higher.
    """
    title, phrases = _words(entry.title), [_words(phrase) for phrase in entry.synonyms]
    if not words:
        return (0, 0, 0)
    if words == title:
        return (0, 0, 0)
    if words in phrases:
        return (1, phrases.index(words), 0)
    fields = (title, [word for phrase in phrases for word in phrase], _words(entry.description))
    total_score = 0
    for word in words:
        scores = [
            _MATCH_KIND_COUNT * field + match_kind
            for field, texts in enumerate(fields)
            if (match_kind := min((_match_kind(word, text) for text in texts), default=_NO_MATCH))
            != _NO_MATCH
        ]
        if not scores:
            return None
        total_score += min(scores)
    return (2, total_score, len(title))


def _match_kind(word: str, text: str) -> int:
    if word == text:
        return _WHOLE_WORD
    if text.startswith(word):
        return _WORD_PREFIX
    return _WORD_PART if len(word) > 1 and word in text else _NO_MATCH
