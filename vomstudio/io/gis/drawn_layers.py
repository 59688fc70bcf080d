"""Lines and polygons that were drawn in a GIS or CAD program, in metres.

GeoPackage, GeoJSON, shapefiles, DXF and whatever else GDAL reads as vectors. A layer in degrees is
refused: it has no true lengths; GeoJSON that names no reference system is in degrees (RFC 7946).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.errors import InputError, UsageError
from vomstudio.files.regular import is_folder, is_there
from vomstudio.geometry.outlines.self_crossing import taken_apart
from vomstudio.geometry.units import METRES
from vomstudio.io.gis.axis_units import MOST_DEGREES, StatedAxes, in_words, refusal, stated_axes
from vomstudio.io.gis.dxf_facts import OF_ENTITIES, dxf_facts, features_of, why_unreadable
from vomstudio.io.gis.layer_reading import names_no_crs, symbol_layers
from vomstudio.io.gis.vector_layers import VectorLayer, list_layers, read_layers
from vomstudio.progress import Progress
from vomstudio.words import tr, tr_n

Shapes = npt.NDArray[np.object_]

_LINES, _AREAS = ("LineString", "LinearRing"), ("Polygon",)


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """shapes : (n,) shapely lines or polygons in metres, single parts; feature : (n,) number of the
    feature that each is of, from 1; columns : (n,) attributes of each that were asked for, by their
    names; crs : "EPSG:n" or WKT, None where the file names none; fields : names of all there
    are"""

    path: Path
    shapes: Shapes
    feature: npt.NDArray[np.int64]
    columns: Mapping[str, npt.NDArray[Any]]
    crs: str | None
    warnings: tuple[Message, ...]
    fields: tuple[str, ...] = ()

    def column(self, name: str, field: str) -> list[str]:
        """(n,) the words of an attribute, "" where it is empty. Raises UsageError."""
        found = next((c for c in self.columns if c.casefold() == name.casefold()), None)
        if found is None:
            raise UsageError(
                tr(
                    "There is no attribute '{name}'. The layer has: {columns}.",
                    name=name, columns=", ".join(self.fields or self.columns) or "-",
                ),
                file=self.path, field=field,
            )  # fmt: skip
        return ["" if _is_empty(v) else str(v).strip() for v in self.columns[found]]


def read_lines(
    path: str | Path,
    layer: str | None = None,
    columns: Iterable[str] = (),
    progress: Progress | None = None,
) -> DrawnLayer:
    """The lines of a file, with those of their attributes that are called so, in any letters.
    Raises InputError for files that are no drawing, hold no line or are in degrees, UsageError
    where the layer must be named, and Cancelled."""
    return _read(
        Path(path), layer, _LINES,
        tr("The file holds no line. Save the traces as lines, each from end to end."),
        columns, progress,
    )  # fmt: skip


def drawn_lines(lines: Shapes | None) -> DrawnLayer:
    """Lines (n,) of the interface, in metres, as if they had been read. Raises InputError."""
    given = np.empty(0, np.object_) if lines is None else lines
    parts, feature, said = _parts(given, _LINES)
    if not len(parts):
        raise InputError(tr("There are no lines with a length."), field="traces")
    return DrawnLayer(Path("traces"), parts, feature + 1, {}, None, tuple(said))


def read_area(
    path: str | Path, layer: str | None = None, progress: Progress | None = None
) -> tuple[Any, DrawnLayer]:
    """All polygons of a file as one shapely area, with what was read. Raises as `read_lines`."""
    found = _read(
        Path(path), layer, _AREAS,
        tr("The file holds no polygon. Draw one around the area in which traces were mapped."),
        (), progress,
    )  # fmt: skip
    area, said = taken_apart(found.shapes)
    return area, replace(found, warnings=(*found.warnings, *said))


def same_frame(one: DrawnLayer, other: DrawnLayer) -> None:
    """Raises InputError where two drawings name different reference systems."""
    if one.crs is None or other.crs is None:
        return
    from pyproj import CRS

    if not CRS.from_user_input(one.crs).equals(CRS.from_user_input(other.crs), True):
        raise InputError(
            tr(
                "This is in {crs}, the traces are in {other}. Reproject one of them.",
                crs=CRS.from_user_input(other.crs).name, other=CRS.from_user_input(one.crs).name,
            ),
            file=other.path,
        )  # fmt: skip


def _read(
    path: Path,
    layer: str | None,
    wanted: tuple[str, ...],
    none: str,
    attributes: Iterable[str],
    progress: Progress | None,
) -> DrawnLayer:
    import shapely

    if not is_there(path) or is_folder(path):
        raise InputError(tr("There is no such file. Check its name."), file=path)
    layer = layer or _layer_of(path, wanted, progress)
    names = {name.casefold() for name in (*attributes, *OF_ENTITIES, "layer")}
    read = next(
        iter(read_layers(path, [layer], names, lambda: _unreadable(path), progress)),
        VectorLayer("", None),
    )
    # A table without geometry has none at all.
    shapes = shapely.from_wkb([] if read.shapes is None else read.shapes, on_invalid="ignore")
    columns = dict(read.columns or {})
    left_out: list[str] = []
    if path.suffix.lower() == ".dxf" and len(shapes):
        keep, left_out = features_of(path, columns, len(shapes))
        shapes = shapes[keep]
        columns = {name: values[keep] for name, values in columns.items()}
    axes = _axes(path, read.crs, shapes)
    factor, said = _factor(path, axes)
    if wanted is _AREAS:
        shapes, outlines = _outlines(shapes)
        said += outlines
    parts, feature, left = _parts(shapes, wanted)
    said += left
    if not len(parts):
        raise InputError(none, file=path)
    if factor != 1.0:
        parts = shapely.transform(parts, lambda xy: xy * factor)
    return DrawnLayer(
        path, parts, feature + 1, {name: values[feature] for name, values in columns.items()},
        axes.crs, (*said, *left_out), read.fields,
    )  # fmt: skip


def _unreadable(path: Path) -> InputError:
    return InputError(
        why_unreadable(path)
        or tr(
            "This cannot be read as a drawing. Save it as GeoPackage, GeoJSON, shapefile or DXF."
        ),
        file=path,
    )


def _layer_of(path: Path, wanted: tuple[str, ...], progress: Progress | None) -> str | None:
    """The only layer that can hold such shapes."""
    layers = list_layers(path, lambda: _unreadable(path), progress)
    symbols = symbol_layers(layer.name for layer in layers)
    # None is no geometry at all, Unknown is any.
    kinds = ("Unknown", *wanted, "Curve", "GeometryCollection")
    fit = [
        layer.name
        for layer in layers
        if layer.kind is not None
        and layer.name.casefold() not in symbols
        and any(part in layer.kind for part in kinds)
    ]
    if len(fit) > 1:
        raise UsageError(
            tr("The file has several layers: {names}. Name one of them.", names=", ".join(fit)),
            file=path, field="--layer",
        )  # fmt: skip
    return fit[0] if fit else None


def _axes(path: Path, crs: str | None, shapes: Shapes) -> StatedAxes:
    import shapely

    axes = stated_axes(crs)
    if not len(shapes):
        return axes
    bounds = np.asarray(shapely.total_bounds(shapes), np.float64).reshape(2, 2)
    if axes.kind == "geographic" and names_no_crs(path):
        if np.nanmax(np.abs(bounds)) > MOST_DEGREES:
            said = tr(
                "GeoJSON that names no coordinate reference system is in degrees, and these "
                "numbers cannot be. Write its 'crs' member, or save it as GeoPackage."
            )
        else:
            said = tr(
                "GeoJSON that names no coordinate reference system is in degrees, which have no "
                "true scale. If these numbers are metres, write its 'crs' member, or save it as "
                "GeoPackage; if they are degrees, reproject it first into a projected system, such "
                "as a UTM zone (EPSG:326xx)."
            )
        raise InputError(said, file=path)
    refused = refusal(axes, np.nan_to_num(bounds))
    if refused is not None:
        raise InputError.of_finding(refused, file=path, field="CRS")
    return axes


def _factor(path: Path, axes: StatedAxes) -> tuple[float, list[str]]:
    """Metres in a unit of the file, and what is said of it."""
    if axes.unit_m is not None:
        if abs(axes.unit_m - 1.0) < 1e-9:
            return 1.0, []
        return axes.unit_m, [
            tr("The coordinates are in {unit} and were converted to metres.",
               unit=in_words(axes.units[0]))
        ]  # fmt: skip
    if path.suffix.lower() == ".dxf" and (factor := dxf_facts(path).unit_m) is not None:
        if factor == 1.0:
            return 1.0, []
        return factor, [
            tr("The drawing is in units of {unit:g} m and was converted to metres.", unit=factor)
        ]
    return METRES["m"], [
        tr("{file} names no coordinate reference system; its coordinates are taken as metres.",
           file=path.name)
    ]  # fmt: skip


def _outlines(shapes: Shapes) -> tuple[Shapes, list[str]]:
    """Closed lines as polygons where there is none, since drawings for CAD have no polygons; and
    what is said of them."""
    import shapely

    kinds = shapely.get_type_id(shapes)
    if np.isin(kinds, (3, 6)).any():
        return shapes, []
    lines = _finite(shapes) & np.isin(kinds, (1, 2)) & (shapely.get_num_coordinates(shapes) >= 4)
    rows = np.flatnonzero(lines)
    closed = rows[shapely.is_closed(shapes[rows])]
    if not len(closed):
        return shapes, []
    made = shapes.copy()
    made[closed] = [shapely.Polygon(shapely.get_coordinates(shapes[i])) for i in closed]
    return made, [
        tr_n(
            "{count} closed line was taken as the outline of the area.",
            "{count} closed lines were taken as outlines of the area.",
            len(closed),
        )
    ]


def _parts(
    shapes: Shapes, wanted: tuple[str, ...]
) -> tuple[Shapes, npt.NDArray[np.int64], list[str]]:
    """Single shapes of the wanted kind, the row of each, and what was left out in words."""
    import shapely

    there = np.flatnonzero(~(shapely.is_missing(shapes) | shapely.is_empty(shapes)))
    whole = np.flatnonzero(np.isfinite(shapely.bounds(shapes)).all(axis=1))
    finite = np.intersect1d(np.intersect1d(there, whole), np.flatnonzero(_finite(shapes)))
    merged = shapes[finite]
    multi = np.flatnonzero(shapely.get_type_id(merged) == 5)
    merged[multi] = shapely.line_merge(merged[multi])
    parts, at = shapely.get_parts(merged, return_index=True)
    kind = np.isin(shapely.get_type_id(parts), (3,) if "Polygon" in wanted else (1, 2))
    size = shapely.length(parts)
    if "Polygon" in wanted:
        # The parts of an outline that crosses itself may cancel.
        size = shapely.area(shapely.make_valid(parts))
    long = kind & (size > 0)
    feature = finite.astype(np.int64)[at]
    said = []
    if lost := len(shapes) - len(finite):
        said.append(
            tr_n(
                "{count} feature without finite coordinates is left out.",
                "{count} features without finite coordinates are left out.",
                lost,
            )
        )
    if other := int(np.sum(~kind)):
        said.append(
            tr_n(
                "{count} shape of another kind is left out.",
                "{count} shapes of another kind are left out.",
                other,
            )
        )
    if short := int(np.sum(kind & ~long)):
        said.append(
            tr_n(
                "{count} shape without length or area is left out: feature {first}.",
                "{count} shapes without length or area are left out, the first is feature {first}.",
                short,
                first=int(feature[kind & ~long][0]) + 1,
            )
        )
    parts, feature = parts[long], feature[long]
    again = len(feature) - len(np.unique(feature))
    if again and "Polygon" not in wanted:
        said.append(
            tr_n(
                "Parts of a feature that do not join are traces of their own: {count} more than "
                "there are features.",
                "Parts of features that do not join are traces of their own: {count} more than "
                "there are features.",
                again,
            )
        )
    kept = _first_of_each(parts)
    if twice := len(parts) - len(kept):
        said.append(
            tr_n(
                "{count} shape that is drawn twice is counted once.",
                "{count} shapes that are drawn twice are counted once.",
                twice,
            )
        )
    return parts[kept], feature[kept], said


def _finite(shapes: Shapes) -> npt.NDArray[np.bool_]:
    """(n,) which of them have no coordinate that is no number."""
    import shapely

    points, row = shapely.get_coordinates(shapes, return_index=True)
    found = np.ones(len(shapes), np.bool_)
    found[row[~np.isfinite(points).all(axis=1)]] = False
    return found


def _first_of_each(shapes: Shapes) -> npt.NDArray[np.int64]:
    import shapely

    _, first = np.unique(shapely.to_wkb(shapely.normalize(shapes)), return_index=True)
    return np.sort(first)


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, float) and np.isnan(value)) or str(value) == "NaT"
