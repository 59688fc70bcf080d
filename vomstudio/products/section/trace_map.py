"""Map of the traces of an outcrop on its face."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.geology.fractures.network import SamplingRegion
from vomstudio.geology.fractures.trace_plane import TracePlane, best_fit_plane
from vomstudio.geology.orientation import Plane
from vomstudio.io.gis.layer_writing import write_layer
from vomstudio.products.section.section_lines import Curtain, curtain_from_plane


def curtain_from_traces(lines: Sequence[FloatArray], plane: Plane | None = None) -> Curtain:
    """Build the plane on which traces are mapped, through their centre.

    It is viewed against its upward normal. Distances are measured to the right and up-dip, or along
    Z if the plane is vertical.

    Parameters
    ----------
    lines : sequence of (n, 3) arrays
        Traces in the World frame, m.
    plane : Plane, optional
        Plane of the face. By default, the best fit to all points.

    Raises
    ------
    GeometryError
        If the points do not determine a plane.
    """
    if not lines:
        raise GeometryError(Finding("traces.none"))
    points = np.concatenate(lines)
    if plane is None:
        plane = best_fit_plane(points)
    # Use the same origin as the command for x and y.
    return curtain_from_plane(plane, TracePlane.from_attitude(plane, lines).origin)


def map_to_face(lines: Sequence[FloatArray], face: Curtain) -> list[FloatArray]:
    """Project traces onto the face as coordinates (n, 2) to the right and up, m."""
    return [np.ascontiguousarray(face.panels[0].coordinates(line)[:, :2]) for line in lines]


def map_to_outcrop(points: FloatArray, face: Curtain) -> FloatArray:
    """Convert points (n, 2) on the face to World coordinates (n, 3)."""
    return face.panels[0].world(points[:, 0], points[:, 1])


def map_outputs(traces: Path, sampling_region: SamplingRegion) -> dict[str, Path]:
    """Return the files that `write_map` writes: traces, and the area or scanlines, if any.

    A circle is not written to a file.
    """
    files = {"traces": traces}
    if sampling_region.scanlines is not None:
        files["scanline"] = traces.with_name(f"{traces.stem}_scanline.gpkg")
    elif sampling_region.area is not None and sampling_region.circle is None:
        files["area"] = traces.with_name(f"{traces.stem}_area.gpkg")
    return files


def write_map(
    traces: Path,
    lines: Sequence[FloatArray],
    names: Sequence[str],
    sets: Sequence[str],
    sampling_region: SamplingRegion,
    face: Curtain,
    *,
    crs: str,
    force: bool = False,
) -> dict[str, Path]:
    """Write GeoPackages for `vomstudio fractures`, which also needs the plane of the face.

    Parameters
    ----------
    traces : Path
    lines : sequence of (k, 3) ndarray
        Lines in the World frame.
    names, sets : sequence of str
        Name and set of each line.
    sampling_region : SamplingRegion
        Area or scanlines on the face; a circle is not written to a file.
    face : Curtain
    crs : str
        CRS of the World frame.
    force : bool
        Whether to replace existing files.

    Returns
    -------
    dict of str to Path
        As in `map_outputs`.

    Raises
    ------
    TargetError
    """
    import shapely

    def to_world(shapes: Any) -> Any:
        return shapely.transform(
            shapely.force_3d(shapes), lambda xy: map_to_outcrop(xy[:, :2], face), include_z=True
        )

    files = map_outputs(traces, sampling_region)
    with atomic_group(list(files.values()), force) as temporary_paths:
        path_by_target = dict(zip(files, temporary_paths, strict=True))
        columns = {"name": _text_array(names), "set": _text_array(sets)}
        shapes = _geometry_array([shapely.linestrings(line) for line in lines])
        _write(path_by_target["traces"], "traces", "LineString Z", shapes, columns, crs)
        if "area" in path_by_target:
            area = to_world(_geometry_array(list(shapely.get_parts(sampling_region.area))))
            _write(path_by_target["area"], "area", "Polygon Z", area, {}, crs)
        if "scanline" in path_by_target:
            scanlines = to_world(sampling_region.scanlines)
            _write(path_by_target["scanline"], "scanline", "LineString Z", scanlines, {}, crs)
    return files


def _write(
    path: Path, layer: str, kind: str, shapes: Any, columns: dict[str, Any], crs: str
) -> None:
    path.unlink(missing_ok=True)
    write_layer(path, layer, kind, shapes, columns, crs)


def _geometry_array(shapes: Sequence[Any]) -> Any:
    array = np.empty(len(shapes), object)
    array[:] = shapes
    return array


def _text_array(texts: Sequence[str]) -> Any:
    return np.array(list(texts), dtype=object)
