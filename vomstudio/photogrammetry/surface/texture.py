"""Photos onto a mesh: pages of texture, and colours of the vertices."""

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
from vomstudio.core.progress import Executor, InlineExecutor, Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.photogrammetry.surface.atlas import Atlas, AtlasOptions, make_atlas, uv_mesh
from vomstudio.photogrammetry.surface.blending import Blend, blend
from vomstudio.photogrammetry.surface.orientation import facing_photos
from vomstudio.photogrammetry.surface.texture_pages import draw_pages
from vomstudio.photogrammetry.surface.topology import cross_products
from vomstudio.photogrammetry.surface.visibility import (
    Photo,
    PhotoVisibility,
    VisibilityTask,
    compute_visibility,
)
from vomstudio.photogrammetry.surface.visibility import memory_needed as visibility_memory

JPEG_QUALITY = 95


@dataclass(frozen=True)
class TextureOptions:
    """How a texture is made.

    texel_m : edge of a texel in the unit of the mesh; None: what the photos resolve
    texels_per_pixel : with None above, texels along the side of a photo's pixel on the rock
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
    """texel_m, pages (width, height), charts : of the atlas
    gains : photo -> RGB factors; sharpness : photo -> relative to the median photo
    drawn_share : photo -> share of the textured area that is drawn from it
    left_out_share : photo -> share of what it sees that was left out, since it shows something else
    seen_by_share : number of photos -> share of the area that so many see well
    unseen_share : of the area that no photo sees; coloured like what is beside it
    warnings : sentences
    """

    texel_m: float
    pages: tuple[tuple[int, int], ...]
    charts: int
    gains: dict[str, tuple[float, float, float]]
    sharpness: dict[str, float]
    drawn_share: dict[str, float]
    left_out_share: dict[str, float]
    seen_by_share: dict[int, float]
    unseen_share: float
    warnings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class Textured:
    """mesh : with uv and vertex colours; its materials have no files yet, see `write`.
    pages : RGB, (h, w, 3) uint8, one for each material
    drawn_from : (m,) number of the photo that each face of `mesh` is drawn from, -1 where none sees
    it"""

    mesh: Mesh
    pages: tuple[ByteArray, ...]
    report: TextureReport
    drawn_from: Int32Array

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
        """Write the model by the ending of each path (.obj with MTL and JPEG, .glb, .ply ...).

        origin : added to the coordinates, which are World then. quality : of the JPEG pages

        Returns one sentence for each thing that a format cannot hold. Raises TargetError,
        UsageError for an unknown ending, Cancelled.
        """
        from vomstudio.io.models.writing import write_model

        paths = [path] if isinstance(path, str | Path) else list(path)
        said: list[Finding] = []
        with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
            stem = Path(paths[0]).stem if paths else "model"
            mesh = replace(
                self.mesh,
                vertices=self.mesh.vertices + np.asarray(origin, np.float64),
                materials=tuple(self._files(Path(folder), stem, quality)),
            )
            for one in paths:
                said += write_model(mesh, crs, one, force=force, progress=progress)
        return said

    def _files(self, folder: Path, stem: str, quality: int) -> Iterator[Material]:
        for number, (material, page) in enumerate(
            zip(self.mesh.materials, self.pages, strict=True), start=1
        ):
            path = folder / f"{stem}_{number}.jpg"
            path.write_bytes(jpeg(page, quality))
            yield replace(material, texture=path)


def jpeg(page: ByteArray, quality: int = JPEG_QUALITY) -> bytes:
    """An RGB page, its colours at full resolution."""
    import cv2

    settings = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    done, content = cv2.imencode(".jpg", np.ascontiguousarray(page[..., ::-1]), settings)
    if not done:
        raise GeometryError(
            Finding("texture.page-too-large", width=page.shape[1], height=page.shape[0])
        )
    return bytes(content)


def make_texture(
    mesh: Mesh,
    photos: Sequence[Photo],
    options: TextureOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Textured:
    """Colour a mesh from photos whose views are in its frame, undistorted or not.

    Pieces of the mesh that the photos see from behind are turned over. Raises GeometryError for a
    mesh without faces, or of which more than half is in no photo; InputError for a photo that is no
    picture of its camera's shape; Cancelled.
    """
    options, executor, progress = (
        options or TextureOptions(),
        executor or InlineExecutor(),
        progress or Silent(),
    )
    if not len(mesh.faces):
        raise GeometryError(Finding("texture.no-triangles"))
    if not photos:
        raise GeometryError(Finding("texture.no-photos"))
    shift = mesh.vertices.mean(axis=0)
    vertices = np.ascontiguousarray(mesh.vertices - shift)
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    moved = [_Moved(photo, shift) for photo in photos]
    faces, visible, turned = facing_photos(
        vertices, faces, lambda f: _visibility(moved, vertices, f, executor, progress)
    )
    resolved = options.texel_m or _resolved(visible, len(faces)) / options.texels_per_pixel
    atlas = make_atlas(vertices, faces, resolved, options.atlas, progress)
    made = blend(vertices, faces, visible, atlas.texel, progress)
    colors = _all_colors(made, mesh)
    pages = draw_pages(
        moved, vertices, faces, atlas, made, colors, options.atlas.gutter, executor, progress
    )
    old, fresh, uv, order = uv_mesh(atlas, faces)
    counts = np.bincount(atlas.page, minlength=len(pages))
    finished = Mesh(
        mesh.vertices[old],
        fresh,
        tuple(Material(f"texture_{k + 1}") for k in range(len(pages))),
        np.r_[0, np.cumsum(counts)].astype(np.int64),
        uv,
        np.clip(np.rint(colors), 0, 255).astype(np.uint8)[old],
    )
    report = _report(vertices, faces, visible, atlas, made, turned)
    return Textured(finished, tuple(pages), report, made.views[order])


class _Moved:
    """A photo about the middle of the mesh. Its bytes are asked for when they are needed: those of
    hundreds of photos would fill the memory."""

    def __init__(self, photo: Photo, shift: FloatArray) -> None:
        self._photo = photo
        self.view = photo.view.moved(1.0, np.eye(3), -shift)

    @property
    def photo(self) -> bytes:
        return self._photo.photo

    @property
    def mask(self) -> bytes | None:
        return self._photo.mask


def _visibility(
    photos: Sequence[_Moved],
    vertices: FloatArray,
    faces: Int32Array,
    executor: Executor,
    progress: Progress,
) -> list[PhotoVisibility]:
    progress.stage(tr("Computing visibility"), len(photos))
    tasks = (VisibilityTask(p.photo, p.mask, p.view, vertices, faces) for p in photos)
    found: dict[int, PhotoVisibility] = {}
    lenses = [p.view.intrinsics for p in photos]
    needed = max(visibility_memory(lens.width, lens.height, len(faces)) for lens in lenses)
    for number, one in executor.map(compute_visibility, tasks, progress, needed):
        found[number] = one
    return [found[number] for number in range(len(photos))]


def _resolved(visible: Sequence[PhotoVisibility], m: int) -> float:
    """Size of a pixel on the rock, in the photo that sees each face best: the median."""
    best = np.zeros(m, np.float32)
    for one in visible:
        np.maximum.at(best, one.faces, one.quality)
    return float(1 / np.median(best[best > 0]))


def _all_colors(made: Blend, mesh: Mesh) -> Float32Array:
    """Vertices that nothing reaches keep the colour of the cloud, or the mean."""
    colors = made.colors.copy()
    rest = ~made.known
    if rest.any():
        if mesh.colors is not None:
            colors[rest] = mesh.colors[rest]
        else:
            colors[rest] = colors[made.known].mean(axis=0)
    return colors


def _report(
    vertices: FloatArray,
    faces: Int32Array,
    visible: Sequence[PhotoVisibility],
    atlas: Atlas,
    made: Blend,
    turned: int,
) -> TextureReport:
    area = np.linalg.norm(cross_products(vertices, faces), axis=1) / 2
    whole = max(float(area.sum()), 1e-300)
    names = [one.name for one in visible]
    drawn = np.bincount(made.views[made.views >= 0], area[made.views >= 0], minlength=len(names))
    seen = np.bincount(made.seen_by, area)
    out = [
        occluded / max(len(one.vertices), 1)
        for occluded, one in zip(made.occluded, visible, strict=True)
    ]
    unseen = float(area[made.views < 0].sum() / whole)
    warnings = [
        Finding("texture.photo-sees-nothing", photo=one.name)
        for one in visible
        if not len(one.faces)
    ]
    larger = atlas.texel / atlas.facts["wanted_texel_m"]
    if larger > 1.001:
        # Without a length: the model may have no scale.
        warnings.append(Finding("texture.larger-pixels", count=len(atlas.sizes), factor=larger))
    if unseen > 0.05:
        warnings.append(Finding("texture.unseen", share_percent=100 * unseen))
    if turned:
        warnings.append(Finding("texture.turned-over", count=turned))
    for name, share in zip(names, out, strict=True):
        if share > 0.3:
            warnings.append(Finding("texture.occluded", photo=name, share_percent=100 * share))
    return TextureReport(
        atlas.texel,
        tuple((int(w), int(h)) for w, h in atlas.sizes),
        int(atlas.facts["charts"]),
        {n: tuple(g) for n, g in zip(names, made.gains.tolist(), strict=True)},
        dict(zip(names, made.sharpness.tolist(), strict=True)),
        dict(zip(names, (drawn / whole).tolist(), strict=True)),
        dict(zip(names, (float(share) for share in out), strict=True)),
        {k: float(share / whole) for k, share in enumerate(seen) if share > 0},
        unseen,
        tuple(warnings),
    )
