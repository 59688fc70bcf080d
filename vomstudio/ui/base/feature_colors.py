"""Colours of features by type, set, quality or dip direction, the same in all views."""

from __future__ import annotations

import colorsys

from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr
from vomstudio.project.kind import get_color
from vomstudio.project.measurement import Measurement
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import Feature, FeatureType, TypedFeature
from vomstudio.rendering.qt.legend_painting import ColorEntry
from vomstudio.rendering.qt.painting import VERDICT_COLORS
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.studio import Studio

COLOR_MODES: dict[str, str] = {
    "type": _("Type"),
    "set": _("Set"),
    "quality": _("Quality"),
    "dip_direction": _("Dip direction"),
}
"""Properties by which features are coloured, with their titles."""
UNKNOWN_COLOR = "#9a9a9a"
"""Colour of features without the property."""
OCTANT_NAMES = (_("N"), _("NE"), _("E"), _("SE"), _("S"), _("SW"), _("W"), _("NW"))
"""Classes of dip directions, each 45 degrees wide."""
MAX_LEGEND_ROWS = 10
_LIGHTNESS, _SATURATION = 0.52, 0.8


def set_colors(records: RecordMap) -> dict[tuple[str, str], str]:
    """Return the colour of each set, keyed by type ID and set name.

    Sets are ordered by feature type, then by name. Colours are repeated if there are more sets than
    colours.

    Parameters
    ----------
    records : RecordMap

    Returns
    -------
    dict of (str, str) to str
    """
    from vomstudio.products.net.contents import OKABE_ITO

    order = {feature_type.id: i for i, feature_type in enumerate(records.of(FeatureType))}
    sets = {(f.type_id, f.set_name) for f in records.of(TypedFeature) if f.set_name}
    names = sorted(
        sets, key=lambda set_key: (order.get(set_key[0], 0), natural_sort_key(set_key[1]))
    )
    # Black is invisible on the dark legend and on shaded rock.
    palette = [color for color in OKABE_ITO if color != "#000000"]
    return {name: palette[i % len(palette)] for i, name in enumerate(names)}


def _octant_color(octant: int) -> str:
    """Return the colour of a compass octant on the colour wheel, with red at north."""
    channels = colorsys.hls_to_rgb(octant / 8.0, _LIGHTNESS, _SATURATION)
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels)


def _find_octant(measurement: Measurement) -> int | None:
    """Return the octant (0 to 7) nearest to the dip direction or trend, or None if undefined."""
    if measurement.plane is not None:
        return round(measurement.plane.dip_direction_deg / 45.0) % 8
    return None if measurement.line is None else round(measurement.line.trend_deg / 45.0) % 8


def feature_class(studio: Studio, feature: Feature, measurement: Measurement) -> ColorEntry:
    """Return the class of a feature with its colour, according to the settings.

    Features to which the property cannot apply, such as stations, keep their own colour.

    Parameters
    ----------
    studio : Studio
    feature : Feature
    measurement : Measurement

    Returns
    -------
    ColorEntry
    """
    mode = studio.settings.color_by
    if mode == "type" or not isinstance(feature, TypedFeature):
        return ColorEntry(get_color(feature, studio.records), "")
    if mode == "set":
        colors = studio.session.records.cached(set_colors)
        color = colors.get((feature.type_id, feature.set_name), UNKNOWN_COLOR)
        return ColorEntry(color, feature.set_name)
    if mode == "quality":
        quality = measurement.verdict.quality if measurement.verdict else ""
        text = tr(quality) if quality else tr("no verdict")
        return ColorEntry(VERDICT_COLORS.get(quality, UNKNOWN_COLOR), text, quality)
    octant = _find_octant(measurement)
    if octant is None:
        return ColorEntry(UNKNOWN_COLOR, tr("no direction"))
    return ColorEntry(_octant_color(octant), tr(OCTANT_NAMES[octant]))


def feature_color(studio: Studio, feature: Feature, measurement: Measurement) -> str:
    """Return the colour (#rrggbb) of a feature according to the settings.

    Parameters
    ----------
    studio : Studio
    feature : Feature
    measurement : Measurement

    Returns
    -------
    str
    """
    return feature_class(studio, feature, measurement).color


def legend(studio: Studio) -> tuple[str, list[ColorEntry]]:
    """Return the title and rows of the legend.

    The list of rows is empty if features are coloured by type, because the types and their colours
    are listed in the tree and beside the net.

    Parameters
    ----------
    studio : Studio

    Returns
    -------
    title : str
    rows : list of ColorEntry
    """
    mode = studio.settings.color_by
    title = tr(COLOR_MODES[mode])
    if mode == "type":
        return title, []
    if mode == "quality":
        rows = [ColorEntry(color, tr(name), name) for name, color in VERDICT_COLORS.items()]
    elif mode == "dip_direction":
        rows = [
            ColorEntry(_octant_color(i), tr(octant_name))
            for i, octant_name in enumerate(OCTANT_NAMES)
        ]
    else:
        rows = _set_rows(studio.session.records)
    return title, rows


def _set_rows(records: RecordMap) -> list[ColorEntry]:
    types = {feature_type.id: feature_type.name for feature_type in records.of(FeatureType)}
    rows = [
        ColorEntry(color, f"{types.get(type_id, '')} {name}".strip())
        for (type_id, name), color in records.cached(set_colors).items()
    ]
    if len(rows) > MAX_LEGEND_ROWS:
        count = len(rows) - MAX_LEGEND_ROWS + 1
        rows = [
            *rows[: MAX_LEGEND_ROWS - 1],
            ColorEntry(UNKNOWN_COLOR, tr("and {count} more", count=count)),
        ]
    if any(not feature.set_name for feature in records.of(TypedFeature)):
        rows.append(ColorEntry(UNKNOWN_COLOR, tr("no set")))
    return rows
