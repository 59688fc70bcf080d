"""Digital elevation models in GeoTIFF files, read as surfaces."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.names import utf8_name
from vomstudio.core.files.regular import require_regular_siblings
from vomstudio.core.files.untrusted.pictures import RASTER_CACHE_BYTES, check_raster
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.gis.geo_keys import COMPOUND_CRS_OPTIONS, decode_keys, read_tiff_keys
from vomstudio.io.gis.raster import silence_libtiff
from vomstudio.io.models.formats._common import drop_invalid_vertices
from vomstudio.io.models.reader import LoadedModel, Reader

MAX_VERTICES = 4_000_000
"""Maximum per surface (eight million triangles); larger grids are thinned and reported."""
PIXELS_PER_STEP = 4_000_000
MAX_HEIGHT_M = 1e5
# Values that programs write for "no data" without declaring them.
UNDECLARED_NO_DATA = (-9999.0, -32768.0, -32767.0, -99999.0)
_UNITS = {
    "m": ("m", "metre", "meter", "metres", "meters"),
    "cm": ("cm", "centimetre", "centimeter", "centimetres", "centimeters"),
    "mm": ("mm", "millimetre", "millimeter", "millimetres", "millimeters"),
    "km": ("km", "kilometre", "kilometer", "kilometres", "kilometers"),
    "ft": (
        "ft",
        "foot",
        "feet",
        "internationalfoot",
        "internationalfeet",
        "ftint",
        "footinternational",
        "footintl",
    ),
    "us-ft": (
        "ussurveyfoot",
        "ussurveyfeet",
        "surveyfoot",
        "surveyfeet",
        "usft",
        "ftus",
        "usfoot",
        "usfeet",
        "footus",
        "feetus",
        "ussft",
        "sft",
    ),
}
UNITS = {spelling: name for name, spellings in _UNITS.items() for spelling in spellings}
"""Units by their spelling in files."""


def parse_unit(text: str) -> str | None:
    """Return the key of `METRES_PER_UNIT` for a unit, or None if the unit is unknown."""
    return UNITS.get("".join(filter(str.isalpha, text.lower())))


def matches(path: Path, head: bytes) -> bool:
    """Return whether a file begins like a TIFF file."""
    return head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read the grid as triangles between the centres of its pixels, in float64.

    Pixels without a value become holes, and a grid of more than `MAX_VERTICES` pixels is thinned.
    The position follows from the transform of the file, which may be rotated; the CRS is that of
    the file, and the heights are in the unit stated for them. Raises InputError for an ordinary
    image, a raster without a position, and a damaged file.
    """
    import rasterio
    from rasterio._err import CPLE_BaseError
    from rasterio.errors import RasterioError

    require_regular_siblings(path)
    check_raster(path)
    progress.stage(tr("Reading the heights"))
    findings: list[Finding] = []
    try:
        with (
            silence_libtiff(),
            rasterio.Env(GDAL_CACHEMAX=RASTER_CACHE_BYTES, **COMPOUND_CRS_OPTIONS),
            utf8_name(path) as safe_path,
            _open(safe_path) as dataset,
        ):
            _check_is_dem(dataset, path, findings)
            crs, height_unit = _read_crs(dataset, path, findings)
            step = _choose_step(dataset, findings)
            heights, unit = _heights(dataset, step, path, progress, findings)
            transform = dataset.transform
    except MemoryError as error:
        raise InputError(Finding("file.exceeds-memory"), file=path) from error
    except (RasterioError, CPLE_BaseError, OSError, ValueError) as error:
        raise InputError(
            Finding("file.damaged", format="GeoTIFF", reason=tr("its data cannot be decoded")),
            file=path,
        ) from error
    if not np.isfinite(heights).any():
        raise InputError(Finding("model.no-points"), file=path)
    mesh = _surface(heights, transform, step)
    del heights
    model = drop_invalid_vertices(mesh, findings, path)
    kind: Literal["mesh", "cloud"] = "mesh" if isinstance(model, Mesh) else "cloud"
    return LoadedModel(model, kind, crs, tuple(findings), path, height_unit=unit or height_unit)


def _open(path: Path) -> Any:
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotGeoreferencedWarning)
        return rasterio.open(path, driver="GTiff")


def _check_is_dem(dataset: Any, path: Path, findings: list[Finding]) -> None:
    kind = np.dtype(dataset.dtypes[0])
    colors = {"red", "green", "blue", "palette", "cyan"}
    first_band = dataset.colorinterp[0].name
    if kind == np.uint8 or first_band in colors or (dataset.count >= 3 and kind == np.uint16):
        raise InputError(Finding("dem.picture", bands=dataset.count, kind=kind.name), file=path)
    if kind.kind not in "iuf":
        raise InputError(Finding("dem.not-heights", kind=kind.name), file=path)
    if dataset.width < 2 or dataset.height < 2:
        raise InputError(Finding("dem.too-small"), file=path)
    coefficients = np.array(dataset.transform[:6])
    if (
        dataset.transform.is_identity
        or not np.isfinite(coefficients).all()
        or dataset.transform.determinant == 0
    ):
        raise InputError(Finding("dem.no-place"), file=path)
    if dataset.count > 1:
        findings.append(Finding("dem.first-band", count=dataset.count))


def _read_crs(dataset: Any, path: Path, findings: list[Finding]) -> tuple[str | None, str | None]:
    """Return the CRS as WKT, and a unit of heights that the file states separately.

    Both are None if not stated. Raises InputError for a depth image of an oblique view.
    """
    if dataset.crs is None:
        return None, None
    text = str(dataset.crs.to_wkt())
    if "VOM Studio view plane" in text:
        raise InputError(Finding("dem.depths"), file=path)
    keys = read_tiff_keys(path)
    if not keys.directory:  # stated by a sidecar file
        return text, None
    reference = decode_keys(keys)
    if stated_axes(text).kind != "local":
        return text, reference.height_unit
    findings += reference.warnings
    return reference.crs, reference.height_unit


def _choose_step(dataset: Any, findings: list[Finding]) -> int:
    width, height, step = dataset.width, dataset.height, 1
    while -(-width // step) * -(-height // step) > MAX_VERTICES:
        step += 1
    if step > 1:
        findings.append(
            Finding(
                "dem.reduced",
                width=width,
                height=height,
                columns=-(-width // step),
                rows=-(-height // step),
                step=step,
            )
        )
    return step


def _heights(
    dataset: Any, step: int, path: Path, progress: Progress, findings: list[Finding]
) -> tuple[FloatArray, str | None]:
    """Return every step-th height (NaN for no data) and the unit of the band, or None."""
    from rasterio.windows import Window

    width, height = dataset.width, dataset.height
    scale, offset = dataset.scales[0], dataset.offsets[0]
    if scale == 0:
        scale = 1.0
        findings.append(Finding("dem.scale-unused"))
    if not np.isfinite([scale, offset]).all():
        raise InputError(
            Finding(
                "file.damaged",
                format="GeoTIFF",
                reason=tr("the scale or offset of the heights is not a number"),
            ),
            file=path,
        )
    rows_per_step = max(1, PIXELS_PER_STEP // width // step) * step
    heights = np.empty((-(-height // step), -(-width // step)))
    progress.stage(tr("Reading the heights"), height)
    for start in range(0, height, rows_per_step):
        rows = min(rows_per_step, height - start)
        window = Window(0, start, width, rows)  # type: ignore[call-arg, unused-ignore]
        values = dataset.read(1, window=window)[::step, ::step].astype(np.float64)
        # Nodata value, mask or opacity band, whichever the file contains.
        mask = dataset.read_masks(1, window=window)[::step, ::step]
        values[mask == 0] = np.nan
        first_row = start // step
        heights[first_row : first_row + len(values)] = values
        progress.step(start + rows)
    if dataset.nodata is None:
        for value in UNDECLARED_NO_DATA:
            is_empty = heights == value
            n = int(np.count_nonzero(is_empty))
            if n:
                heights[is_empty] = np.nan
                findings.append(Finding("dem.no-data-value", count=n, value=value))
    unit_text = (dataset.units[0] or "").strip()
    unit = parse_unit(unit_text)
    if unit_text and unit is None:
        findings.append(Finding("dem.unit-unknown", unit=unit_text))
    heights *= scale
    heights += offset
    is_implausible = np.abs(heights) > MAX_HEIGHT_M / METRES_PER_UNIT[unit or "m"]
    n = int(np.count_nonzero(is_implausible))
    if n:
        heights[is_implausible] = np.nan
        findings.append(Finding("dem.pixels-left-out", count=n))
    return heights, unit


def _surface(heights: AnyArray, transform: Any, step: int) -> Mesh:
    has_height = np.isfinite(heights)
    rows, columns = np.nonzero(has_height)
    z = heights[has_height]
    column, row = columns * float(step) + 0.5, rows * float(step) + 0.5
    a, b, c, d, e, f = transform[:6]
    vertices = np.column_stack([a * column + b * row + c, d * column + e * row + f, z])
    vertex_ids = np.full(heights.shape, -1, np.int32)
    vertex_ids[has_height] = np.arange(len(z), dtype=np.int32)
    faces = _triangles(vertex_ids, heights)
    if transform.determinant > 0:
        faces = faces[:, ::-1]
    return Mesh(vertices, np.ascontiguousarray(faces))


def _triangles(vertex_ids: AnyArray, heights: AnyArray) -> AnyArray:
    """Return two triangles between four pixels, split along the smaller height difference.

    Between three pixels there is one triangle. Triangles are counterclockwise as seen from above if
    rows run south.
    """
    corners = [vertex_ids[:-1, :-1], vertex_ids[:-1, 1:], vertex_ids[1:, :-1], vertex_ids[1:, 1:]]
    nw, ne, sw, se = (corner.ravel() for corner in corners)
    has_all_corners = (nw >= 0) & (ne >= 0) & (sw >= 0) & (se >= 0)
    falling_differences = np.abs(heights[:-1, :-1] - heights[1:, 1:])
    rising_differences = np.abs(heights[:-1, 1:] - heights[1:, :-1])
    with np.errstate(invalid="ignore"):
        is_falling = (falling_differences <= rising_differences).ravel()
    triangles = np.full((len(nw), 2, 3), -1, np.int32)
    halves = [
        (has_all_corners & is_falling, 0, (nw, sw, se)),
        (has_all_corners & is_falling, 1, (nw, se, ne)),
        (has_all_corners & ~is_falling, 0, (nw, sw, ne)),
        (has_all_corners & ~is_falling, 1, (ne, sw, se)),
        ((nw < 0) & (ne >= 0) & (sw >= 0) & (se >= 0), 0, (ne, sw, se)),
        ((ne < 0) & (nw >= 0) & (sw >= 0) & (se >= 0), 0, (nw, sw, se)),
        ((sw < 0) & (nw >= 0) & (ne >= 0) & (se >= 0), 0, (nw, se, ne)),
        ((se < 0) & (nw >= 0) & (ne >= 0) & (sw >= 0), 0, (nw, sw, ne)),
    ]
    for half_mask, triangle_half, triangle_corners in halves:
        for k, corner in enumerate(triangle_corners):
            np.copyto(triangles[:, triangle_half, k], corner, where=half_mask)
    faces = triangles.reshape(-1, 3)
    return faces[faces[:, 0] >= 0]


READER = Reader(to_translate("GeoTIFF height model"), (".tif", ".tiff"), matches, read)
