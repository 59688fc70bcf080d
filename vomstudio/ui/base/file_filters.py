"""Filters for file dialogs, derived from the extensions that the readers support."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.core.words import tr


def _patterns(endings: Iterable[str]) -> str:
    """Return patterns in lower and upper case, because some dialogs are case-sensitive."""
    variants = dict.fromkeys(item for e in endings for item in (e.lower(), e.upper()))
    return " ".join(f"*{suffix}" for suffix in variants)


def _add_all_files(name_filter: str) -> str:
    return ";;".join((name_filter, tr("All files (*)")))


def models() -> str:
    """Return the filter for meshes, point clouds and height models."""
    from vomstudio.io.models.registry import extensions

    return _add_all_files(tr("Models ({patterns})", patterns=_patterns(extensions())))


def photos() -> str:
    from vomstudio.io.photos.reading import PHOTO_ENDINGS

    return _add_all_files(tr("Photos ({patterns})", patterns=_patterns(PHOTO_ENDINGS)))


def videos() -> str:
    from vomstudio.photogrammetry.survey.video import VIDEO_EXTENSIONS

    return _add_all_files(tr("Videos ({patterns})", patterns=_patterns(VIDEO_EXTENSIONS)))


def tables() -> str:
    """Return the filter for tables of compass readings, as text, layers or workbooks."""
    from vomstudio.io.gate.orientation_files import LAYER_EXTENSIONS
    from vomstudio.io.text.tables import TABLE_EXTENSIONS

    endings = (*TABLE_EXTENSIONS, *LAYER_EXTENSIONS)
    return _add_all_files(tr("Tables ({patterns})", patterns=_patterns(endings)))


def layers_and_tables() -> str:
    """Return the filter for features in layers and tables."""
    from vomstudio.io.text.tables import TABLE_EXTENSIONS

    endings = (".gpkg", ".geojson", ".json", ".shp", ".kml", ".dxf", ".xml", *TABLE_EXTENSIONS)
    return _add_all_files(tr("Layers and tables ({patterns})", patterns=_patterns(endings)))


def drawings() -> str:
    """Return the filter for lines that were drawn on an orthophoto."""
    endings = (".gpkg", ".geojson", ".json", ".shp", ".dxf", ".svg", ".svgz")
    return _add_all_files(tr("Drawings ({patterns})", patterns=_patterns(endings)))


def sidecars() -> str:
    """Return the filter for sidecar files of orthophotos."""
    return _add_all_files(tr("Orthophoto sidecars ({patterns})", patterns=_patterns([".json"])))


def cameras() -> str:
    """Return the filter for files with the cameras of photos."""
    from vomstudio.io.photos.own_cameras.reading import EXTENSIONS

    return _add_all_files(tr("Cameras ({patterns})", patterns=_patterns(EXTENSIONS)))


def ground_control() -> str:
    """Return the filter for ground control points and image marks."""
    from vomstudio.io.control.registry import extensions

    return _add_all_files(tr("Ground control ({patterns})", patterns=_patterns(extensions())))
