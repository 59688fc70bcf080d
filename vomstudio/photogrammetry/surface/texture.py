"""Texturing of a mesh from photos: pages and vertex colours."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array, FloatArray, Int32Array
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Executor, InlineExecutor, Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.photogrammetry.surface.atlas import Atlas, AtlasOptions, make_atlas, uv_mesh
from vomstudio.photogrammetry.surface.blending import Blend, blend
from vomstudio.photogrammetry.surface.orientation import orient_to_photos
from vomstudio.photogrammetry.surface.texture_pages import draw_pages
from vomstudio.photogrammetry.surface.topology import cross_products, neighbours
from vomstudio.photogrammetry.surface.visibility import (
    MaskedPhoto,
    PhotoVisibility,
    VisibilityTask,
    compute_visibility,
)
from vomstudio.photogrammetry.surface.visibility import peak_memory_bytes as visibility_memory_bytes

JPEG_QUALITY = 95
# Maximum size of a texel relative to a pixel of the best photo, over this share of the area.
_MAX_TEXEL_RATIO, _FINE_SHARE = 1.3, 0.9
# If pixels vary by this factor, parts of the surface have texels of different sizes, in steps of
# the square root of 2 and up to 2 to the power of the maximum level.
_MIN_PIXEL_SPREAD, _MAX_LEVEL = 2.0, 4
_SMOOTHING_ROUNDS = 12
# Texels are larger on faces that are inclined to the projection of their chart.
_CHART_STRETCH = 1.15


@dataclass(frozen=True)
class TextureOptions:
    """Options of textures.

    texel_m : edge of a texel in the unit of the mesh; if None, the resolution of the photos is used
    texels_per_pixel : texels along the side of a photo's pixel on the rock, if `texel_m` is None
    """

    texel_m: float | None = None
    texels_per_pixel: float = 1.0
    atlas: AtlasOptions = field(default_factory=AtlasOptions)

    def __post_init__(self) -> None:
        for name, value in (("texel_m", self.texel_m), ("texels_per_pixel", self.texels_per_pixel)):
            if value is not None and not (value > 0 and math.isfinite(value)):
                raise UsageError(Finding("number.not-positive", value=value), field=name)


@dataclass(frozen=True)
class TextureReport:
    """Report on a texture.

    Attributes
    ----------
    texel_m, pages, charts
        Properties of the atlas; pages are (width, height).
    texel_ratio : float
        Edge of a texel on the surface relative to a pixel of the best photo; 90 % quantile of the
        visible area.
    gains : dict
        RGB gain of each photo.
    sharpness : dict
        Sharpness of each photo relative to the median photo.
    drawn_share : dict
        Share of the textured area that is drawn from each photo.
    left_out_share : dict
        Share of the visible vertices of each photo that was excluded because of occluders.
    seen_by_share : dict
        Share of the area by number of photos with a good view.
    unseen_share : float
        Share of the area that no photo shows, which is coloured like its surroundings.
    """

    texel_m: float
    pages: tuple[tuple[int, int], ...]
    charts: int
    texel_ratio: float
    gains: dict[str, tuple[float, float, float]]
    sharpness: dict[str, float]
    drawn_share: dict[str, float]
    left_out_share: dict[str, float]
    seen_by_share: dict[int, float]
    unseen_share: float
    warnings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """Textured mesh.

    Attributes
    ----------
    mesh : Mesh
        Mesh with texture coordinates and vertex colours. Its materials do not have files; `write`
        creates them.
    pages : tuple of (h, w, 3) uint8 array
        RGB, one for each material.
    source_photos : (m,) array
        Photo from which each face of `mesh` is drawn; -1 if it is not drawn from a photo.
    """

    mesh: Mesh
    pages: tuple[ByteArray, ...]
    report: TextureReport
    source_photos: Int32Array

    def write(
        self,
        path: str | Path | Iterable[str | Path],
        *,
        origin: Sequence[float] = (0, 0, 0),
        crs: str | None = None,
        quality: int = JPEG_QUALITY,
        force: bool = False,
        progress: Progress | None = None,
    ) -> list[Finding]:
        """Write the model in the format of each path's extension.

        The formats are OBJ with MTL and JPEG, GLB, PLY and others.

        Parameters
        ----------
        path : path or iterable of paths
        origin : sequence of float
            Offset that converts the coordinates to the World frame.
        crs : str, optional
        quality : int
            Quality of the JPEG pages.
        force : bool
            Whether to replace existing files.
        progress : Progress, optional

        Returns
        -------
        list of Finding
            Findings about data that a format cannot store.

        Raises
        ------
        TargetError
            If a file cannot be written, or exists and `force` is not set.
        UsageError
            If the extension is unknown.
        Cancelled
        """
        from vomstudio.io.models.writing import write_model

        paths = [path] if isinstance(path, str | Path) else list(path)
        findings: list[Finding] = []
        with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
            stem = Path(paths[0]).stem if paths else "model"
            mesh = replace(
                self.mesh,
                vertices=self.mesh.vertices + np.asarray(origin, np.float64),
                materials=tuple(self._write_pages(Path(folder), stem, quality)),
            )
            for target in paths:
                findings += write_model(mesh, crs, target, force=force, progress=progress)
        return findings

    def _write_pages(self, folder: Path, stem: str, quality: int) -> Iterator[Material]:
        for number, (material, page) in enumerate(
            zip(self.mesh.materials, self.pages, strict=True), start=1
        ):
            path = folder / f"{stem}_{number}.jpg"
            path.write_bytes(encode_jpeg(page, quality))
            yield replace(material, texture=path)


def encode_jpeg(page: ByteArray, quality: int = JPEG_QUALITY) -> bytes:
    """Encode an RGB page as JPEG, with colours at full resolution.

    Raises GeometryError if the page is too large for the format.
    """
    import cv2

    settings = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    is_encoded, content = cv2.imencode(".jpg", np.ascontiguousarray(page[..., ::-1]), settings)
    if not is_encoded:
        raise GeometryError(
            Finding("texture.page-too-large", width=page.shape[1], height=page.shape[0])
        )
    return bytes(content)


def make_texture(
    mesh: Mesh,
    photos: Sequence[MaskedPhoto],
    options: TextureOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> TexturedMesh:
    """Colour a mesh from photos whose views are in its frame, undistorted or not.

    Pieces of the mesh that the photos show from behind are flipped.

    Raises
    ------
    GeometryError
        If there are no faces or photos, or if more than half of the mesh is not visible in any
        photo.
    InputError
        If a photo cannot be read, or its shape differs from that of its camera.
    Cancelled
    """
    options, executor, progress = (
        options or TextureOptions(),
        executor or InlineExecutor(),
        progress or SilentProgress(),
    )
    if not len(mesh.faces):
        raise GeometryError(Finding("texture.no-triangles"))
    if not photos:
        raise GeometryError(Finding("texture.no-photos"))
    shift = mesh.vertices.mean(axis=0)
    vertices = np.ascontiguousarray(mesh.vertices - shift)
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    shifted_photos = [_ShiftedPhoto(photo, shift) for photo in photos]
    faces, visibilities, flipped_count = orient_to_photos(
        vertices,
        faces,
        lambda f: _compute_visibilities(shifted_photos, vertices, f, executor, progress),
    )
    pixel_sizes = _best_pixel_sizes(visibilities, len(faces))
    areas = np.linalg.norm(cross_products(vertices, faces), axis=1) / 2
    if options.texel_m is None:
        texel, factors = _choose_texel(pixel_sizes, areas, faces)
        texel /= options.texels_per_pixel
    else:
        texel, factors = options.texel_m, None
    atlas = make_atlas(vertices, faces, texel, options.atlas, progress, factors)
    blend_result = blend(vertices, faces, visibilities, atlas.texel, progress)
    colors = _fill_unknown_colors(blend_result, mesh)
    pages = draw_pages(
        shifted_photos,
        vertices,
        faces,
        atlas,
        blend_result,
        colors,
        options.atlas.gutter,
        executor,
        progress,
    )
    old_vertices, new_faces, uv, order = uv_mesh(atlas, faces)
    counts = np.bincount(atlas.page, minlength=len(pages))
    textured_mesh = Mesh(
        mesh.vertices[old_vertices],
        new_faces,
        tuple(Material(f"texture_{k + 1}") for k in range(len(pages))),
        np.r_[0, np.cumsum(counts)].astype(np.int64),
        uv,
        np.clip(np.rint(colors), 0, 255).astype(np.uint8)[old_vertices],
    )
    report = _report(vertices, faces, visibilities, atlas, blend_result, flipped_count, pixel_sizes)
    return TexturedMesh(textured_mesh, tuple(pages), report, blend_result.views[order])


class _ShiftedPhoto:
    """Photo relative to the mesh centre, whose bytes are read on access to save memory."""

    def __init__(self, photo: MaskedPhoto, shift: FloatArray) -> None:
        self._photo = photo
        self.view = photo.view.moved(1.0, np.eye(3), -shift)

    @property
    def photo(self) -> bytes:
        return self._photo.photo

    @property
    def mask(self) -> bytes | None:
        return self._photo.mask


def _compute_visibilities(
    photos: Sequence[_ShiftedPhoto],
    vertices: FloatArray,
    faces: Int32Array,
    executor: Executor,
    progress: Progress,
) -> list[PhotoVisibility]:
    progress.stage(tr("Computing visibility"), len(photos))
    tasks = (VisibilityTask(p.photo, p.mask, p.view, vertices, faces) for p in photos)
    results: dict[int, PhotoVisibility] = {}
    lenses = [p.view.intrinsics for p in photos]
    max_memory_bytes = max(
        visibility_memory_bytes(lens.width, lens.height, len(faces)) for lens in lenses
    )
    for number, visibility in executor.map(compute_visibility, tasks, progress, max_memory_bytes):
        results[number] = visibility
    return [results[number] for number in range(len(photos))]


def _best_pixel_sizes(visibilities: Sequence[PhotoVisibility], face_count: int) -> FloatArray:
    """Return the size (m,) of a pixel of the best photo on each face; infinity if not visible.

    Oblique views and borders of photos, which the blending avoids, do not enlarge it.
    """
    best_resolution = np.zeros(face_count)
    for visibility in visibilities:
        np.maximum.at(best_resolution, visibility.faces, visibility.resolution)
    with np.errstate(divide="ignore"):
        return np.asarray(1 / best_resolution)


def _choose_texel(
    pixel_sizes: FloatArray, areas: FloatArray, faces: Int32Array
) -> tuple[float, FloatArray | None]:
    """Return the texel size for the best pixel sizes (m,), and factors (m,) that enlarge it.

    The texel size is the median pixel size, or less if pixel sizes vary. The factors are None
    unless close-up photos show a part in much more detail; they then enlarge the other texels.
    """
    fine_size, median_size, coarse_size = _quantiles(
        pixel_sizes, areas, [1 - _FINE_SHARE, 0.5, 0.95]
    )
    texel = min(median_size, _MAX_TEXEL_RATIO / _CHART_STRETCH * fine_size)
    if coarse_size < _MIN_PIXEL_SPREAD * fine_size:
        return texel, None
    # Smooth the levels, so that charts do not break up where the best photo changes.
    levels = np.log2(np.where(np.isfinite(pixel_sizes), pixel_sizes, median_size) / fine_size)
    neighbour_faces = neighbours(faces)
    has_neighbour = neighbour_faces >= 0
    for _ in range(_SMOOTHING_ROUNDS):
        sums = np.where(has_neighbour, levels[neighbour_faces], 0.0).sum(axis=1)
        levels = (levels + sums) / (1 + has_neighbour.sum(axis=1))
    steps = np.clip(np.floor(2 * levels), 0, 2 * _MAX_LEVEL)
    return texel, np.asarray(2.0 ** (steps / 2))


def _texel_ratio(
    vertices: FloatArray, faces: Int32Array, atlas: Atlas, pixel_sizes: FloatArray
) -> float:
    """Return the 90 % quantile of the edges of texels, in pixels of the best photo."""
    sizes, areas = _texel_sizes(vertices, faces, atlas)
    ratios = sizes / pixel_sizes
    is_visible = np.isfinite(pixel_sizes) & np.isfinite(sizes) & (areas > 0)
    if not is_visible.any():
        return 0.0
    return _quantiles(ratios[is_visible], areas[is_visible], [_FINE_SHARE])[0]


def _texel_sizes(
    vertices: FloatArray, faces: Int32Array, atlas: Atlas
) -> tuple[FloatArray, FloatArray]:
    """Return the edge (m,) of the texels on each face, and the areas (m,) of the faces."""
    areas = np.linalg.norm(cross_products(vertices, faces), axis=1) / 2
    first_edges, second_edges = (atlas.corners[:, k] - atlas.corners[:, 0] for k in (1, 2))
    texel_counts = (
        np.abs(first_edges[:, 0] * second_edges[:, 1] - first_edges[:, 1] * second_edges[:, 0]) / 2
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.sqrt(areas / texel_counts), areas


def _median_texel_size(vertices: FloatArray, faces: Int32Array, atlas: Atlas) -> float:
    """Return the area-weighted median edge of the texels, in the unit of the vertices."""
    if not atlas.facts["has_factors"]:
        return atlas.texel
    sizes, areas = _texel_sizes(vertices, faces, atlas)
    return _quantiles(sizes, areas, [0.5])[0]


def _quantiles(values: FloatArray, areas: FloatArray, shares: Sequence[float]) -> list[float]:
    """Return area-weighted quantiles of the finite values."""
    is_finite = np.isfinite(values)
    values, areas = values[is_finite], areas[is_finite]
    order = np.argsort(values)
    cumulative_areas = np.cumsum(areas[order])
    rows = np.minimum(
        np.searchsorted(cumulative_areas, np.multiply(shares, cumulative_areas[-1])),
        len(cumulative_areas) - 1,
    )
    return [float(value) for value in values[order][rows]]


def _fill_unknown_colors(blend_result: Blend, mesh: Mesh) -> Float32Array:
    """Fill unknown vertex colours with those of the original mesh, or with the mean colour."""
    colors = blend_result.colors.copy()
    is_unknown = ~blend_result.is_known
    if is_unknown.any():
        if mesh.colors is not None:
            colors[is_unknown] = mesh.colors[is_unknown]
        else:
            colors[is_unknown] = colors[blend_result.is_known].mean(axis=0)
    return colors


def _report(
    vertices: FloatArray,
    faces: Int32Array,
    visibilities: Sequence[PhotoVisibility],
    atlas: Atlas,
    blend_result: Blend,
    flipped_count: int,
    pixel_sizes: FloatArray,
) -> TextureReport:
    areas = np.linalg.norm(cross_products(vertices, faces), axis=1) / 2
    total_area = max(float(areas.sum()), 1e-300)
    names = [item.name for item in visibilities]
    drawn_areas = np.bincount(
        blend_result.views[blend_result.views >= 0],
        areas[blend_result.views >= 0],
        minlength=len(names),
    )
    area_by_count = np.bincount(blend_result.view_counts, areas)
    occluded_shares = [
        count / max(len(item.vertices), 1)
        for count, item in zip(blend_result.occluded_counts, visibilities, strict=True)
    ]
    unseen_share = float(areas[blend_result.views < 0].sum() / total_area)
    warnings = [
        Finding("texture.photo-sees-nothing", photo=item.name)
        for item in visibilities
        if not len(item.faces)
    ]
    texel_ratio = _texel_ratio(vertices, faces, atlas, pixel_sizes)
    if texel_ratio > _MAX_TEXEL_RATIO:
        # Do not state a length, since the model may have no scale.
        is_full = atlas.texel > 1.001 * atlas.facts["wanted_texel_m"]
        code = "texture.pages-full" if is_full else "texture.coarse"
        warnings.append(
            Finding(
                code,
                count=len(atlas.sizes),
                factor=texel_ratio,
                limit=_MAX_TEXEL_RATIO,
            )
        )
    if unseen_share > 0.05:
        warnings.append(Finding("texture.unseen", share_percent=100 * unseen_share))
    if flipped_count:
        warnings.append(Finding("texture.turned-over", count=flipped_count))
    for name, share in zip(names, occluded_shares, strict=True):
        if share > 0.3:
            warnings.append(Finding("texture.occluded", photo=name, share_percent=100 * share))
    return TextureReport(
        _median_texel_size(vertices, faces, atlas),
        tuple((int(w), int(h)) for w, h in atlas.sizes),
        int(atlas.facts["charts"]),
        texel_ratio,
        {n: tuple(g) for n, g in zip(names, blend_result.gains.tolist(), strict=True)},
        dict(zip(names, blend_result.sharpness.tolist(), strict=True)),
        dict(zip(names, (drawn_areas / total_area).tolist(), strict=True)),
        dict(zip(names, (float(share) for share in occluded_shares), strict=True)),
        {k: float(share / total_area) for k, share in enumerate(area_by_count) if share > 0},
        unseen_share,
        tuple(warnings),
    )
