"""Photos onto a mesh: pages of texture, and colours of the vertices."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, UsageError
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.photogrammetry.surface.atlas import Atlas, AtlasOptions, make_atlas, uv_mesh
from vomstudio.photogrammetry.surface.blending import Blend, blend
from vomstudio.photogrammetry.surface.topology import Array, Faces, compact, cross_products
from vomstudio.photogrammetry.surface.visibility import (
    Look,
    LookTask,
    Photo,
    decode,
    look,
    project,
    pyramid,
)
from vomstudio.photogrammetry.surface.visibility import memory_needed as look_memory
from vomstudio.progress import Executor, Inline, Progress, Silent

# A photo is decoded once for each tile that it has a part in.
_TILE = 2048
# Where two photos meet they fade into each other: the higher, the narrower.
_SEAM = 4.0
_MAX_LEVEL = 6
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
                raise UsageError("must be a positive number.", field=name)


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
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Textured:
    """mesh : with uv and vertex colours; its materials have no files yet, see `write`.
    pages : RGB, (h, w, 3) uint8, one for each material
    drawn_from : (m,) number of the photo that each face of `mesh` is drawn from, -1 where none sees
    it"""

    mesh: Mesh
    pages: tuple[npt.NDArray[np.uint8], ...]
    report: TextureReport
    drawn_from: npt.NDArray[np.int32]

    def write(
        self,
        path: str | Path | Iterable[str | Path],
        *,
        origin: Sequence[float] = (0, 0, 0),
        crs: str | None = None,
        quality: int = JPEG_QUALITY,
        force: bool = False,
        progress: Progress | None = None,
    ) -> list[str]:
        """Write the model by the ending of each path (.obj with MTL and JPEG, .glb, .ply ...).

        origin : added to the coordinates, which are World then. quality : of the JPEG pages

        Returns one sentence for each thing that a format cannot hold. Raises TargetError,
        UsageError for an unknown ending, Cancelled.
        """
        from vomstudio.io.models.writing import write_model

        paths = [path] if isinstance(path, str | Path) else list(path)
        said: list[str] = []
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


def jpeg(page: npt.NDArray[np.uint8], quality: int = JPEG_QUALITY) -> bytes:
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
        raise GeometryError(f"a page of {page.shape[1]} x {page.shape[0]} is too large for JPEG.")
    return bytes(content)


def make_texture(
    mesh: Mesh,
    photos: Sequence[Photo],
    options: TextureOptions | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Textured:
    """Colour a mesh from photos whose views are in its frame, undistorted or not.

    Raises GeometryError for a mesh without faces, or that no photo sees; InputError for a photo
    that is no picture of its camera's shape; Cancelled.
    """
    options, executor, progress = (
        options or TextureOptions(),
        executor or Inline(),
        progress or Silent(),
    )
    if not len(mesh.faces):
        raise GeometryError("the mesh has no faces to be textured.")
    if not photos:
        raise GeometryError("a texture needs at least one photo.")
    shift = mesh.vertices.mean(axis=0)
    vertices = np.ascontiguousarray(mesh.vertices - shift)
    faces = np.ascontiguousarray(mesh.faces, np.int32)
    moved = [_Moved(photo, shift) for photo in photos]
    looks = _looks(moved, vertices, faces, executor, progress)
    if not any(len(one.faces) for one in looks):
        raise GeometryError(
            "no photo sees this mesh; do the cameras belong to it, and do its faces look outwards?"
        )
    resolved = options.texel_m or _resolved(looks, len(faces)) / options.texels_per_pixel
    atlas = make_atlas(vertices, faces, resolved, options.atlas, progress)
    made = blend(vertices, faces, looks, atlas.texel, progress)
    colors = _all_colors(made, mesh)
    pages = _pages(moved, vertices, faces, atlas, made, colors, options, executor, progress)
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
    report = _report(vertices, faces, looks, atlas, made)
    return Textured(finished, tuple(pages), report, made.views[order])


class _Moved:
    """A photo about the middle of the mesh. Its bytes are asked for when they are needed: those of
    hundreds of photos would fill the memory."""

    def __init__(self, photo: Photo, shift: Array) -> None:
        self._photo = photo
        self.view = photo.view.moved(1.0, np.eye(3), -shift)

    @property
    def photo(self) -> bytes:
        return self._photo.photo

    @property
    def mask(self) -> bytes | None:
        return self._photo.mask


def _looks(
    photos: Sequence[_Moved], vertices: Array, faces: Faces, executor: Executor, progress: Progress
) -> list[Look]:
    progress.stage("Looking at the surface from each photo", len(photos))
    tasks = (LookTask(p.photo, p.mask, p.view, vertices, faces) for p in photos)
    found: dict[int, Look] = {}
    lenses = [p.view.intrinsics for p in photos]
    needed = max(look_memory(lens.width, lens.height, len(faces)) for lens in lenses)
    for number, one in executor.map(look, tasks, progress, needed):
        found[number] = one
    return [found[number] for number in range(len(photos))]


def _resolved(looks: Sequence[Look], m: int) -> float:
    """Size of a pixel on the rock, in the photo that sees each face best: the median."""
    best = np.zeros(m, np.float32)
    for one in looks:
        np.maximum.at(best, one.faces, one.quality)
    return float(1 / np.median(best[best > 0]))


def _all_colors(made: Blend, mesh: Mesh) -> npt.NDArray[np.float32]:
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
    vertices: Array, faces: Faces, looks: Sequence[Look], atlas: Atlas, made: Blend
) -> TextureReport:
    area = np.linalg.norm(cross_products(vertices, faces), axis=1) / 2
    whole = max(float(area.sum()), 1e-300)
    names = [one.name for one in looks]
    drawn = np.bincount(made.views[made.views >= 0], area[made.views >= 0], minlength=len(names))
    seen = np.bincount(made.seen_by, area)
    out = [odd / max(len(one.vertices), 1) for odd, one in zip(made.odd, looks, strict=True)]
    unseen = float(area[made.views < 0].sum() / whole)
    warnings = [f"{one.name} sees nothing of the surface." for one in looks if not len(one.faces)]
    if atlas.texel > 1.001 * atlas.facts["wanted_texel_m"]:
        warnings.append(
            f"Texels are {1000 * atlas.texel:.3g} mm instead of"
            f" {1000 * atlas.facts['wanted_texel_m']:.3g} mm, for {len(atlas.sizes)} pages to"
            " suffice."
        )
    if unseen > 0.05:
        warnings.append(f"{unseen:.0%} of the surface is in no photo, and has made-up colours.")
    for name, share in zip(names, out, strict=True):
        if share > 0.3:
            warnings.append(
                f"{name} was left out over {share:.0%} of what it sees: the other photos show"
                " something else there."
            )
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


# --- pages -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TilePhoto:
    """One photo's part in a tile. face (e,) rows of the tile's faces; pixels (e, 3, 2), depths and
    weights (e, 3), offsets (e, 3, 3) at their corners; gain RGB"""

    photo: bytes
    view: Any
    gain: tuple[float, float, float]
    face: npt.NDArray[np.int32]
    pixels: npt.NDArray[np.float32]
    depths: npt.NDArray[np.float32]
    weights: npt.NDArray[np.float32]
    offsets: npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class TileTask:
    """A rectangle of a page. left, top, width, height : texels of the page. corners (m, 3, 2) of
    the faces on the page; fallback (m, 3, 3) colours at them"""

    left: int
    top: int
    width: int
    height: int
    gutter: int
    corners: Array
    fallback: npt.NDArray[np.float32]
    photos: tuple[TilePhoto, ...]


@dataclass(frozen=True, eq=False)
class Tile:
    """rgb (h, w, 3); filled (h, w) where charts and their gutters are"""

    rgb: npt.NDArray[np.uint8]
    filled: npt.NDArray[np.bool_]


def draw_tile(task: TileTask) -> Tile:
    """Colours of one tile; one photo is decoded at a time."""
    from vomstudio.photogrammetry.surface._texture_kernels import (
        add_view,
        draw_faces,
        finish,
        grow_faces,
    )

    # Gutters of charts beyond the tile reach into it.
    rim = task.gutter + 1
    left, top = float(task.left - rim), float(task.top - rim)
    shape = (task.height + 2 * rim, task.width + 2 * rim)
    owner = np.full(shape, -1, np.int32)
    draw_faces(task.corners, left, top, owner)
    grow_faces(owner, np.empty_like(owner), task.gutter)
    owner = np.ascontiguousarray(owner[rim:-rim, rim:-rim])
    total = np.zeros((*owner.shape, 4), np.float32)
    at = (float(task.left), float(task.top))
    for part in task.photos:
        layers = pyramid(decode(part.photo, part.view), _MAX_LEVEL)
        entry = np.full(len(task.corners), -1, np.int32)
        entry[part.face] = np.arange(len(part.face), dtype=np.int32)
        level = np.minimum(_levels(task.corners[part.face], part.pixels), len(layers) - 1)
        level = level.astype(np.int32)
        for wanted in np.unique(level):
            add_view(
                owner, task.corners, *at, entry, part.pixels, part.depths, part.weights,
                part.offsets, level, int(wanted), np.ascontiguousarray(layers[wanted]),
                np.array(part.gain), _SEAM, total,
            )  # fmt: skip
    rgb = np.zeros((*owner.shape, 3), np.uint8)
    finish(owner, task.corners, *at, task.fallback, total, rgb)
    return Tile(rgb, owner >= 0)


def _levels(corners: Array, pixels: npt.NDArray[np.float32]) -> npt.NDArray[np.int64]:
    """Level of the pyramid at which a pixel is about a texel."""

    def area(p: Any) -> Any:
        a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])

    ratio = area(pixels.astype(np.float64)) / np.maximum(area(corners), 1e-12)
    return np.clip(np.floor(0.5 * np.log2(np.maximum(ratio, 1e-12)) + 0.4), 0, _MAX_LEVEL).astype(
        np.int64
    )


def _pages(
    photos: Sequence[_Moved],
    vertices: Array,
    faces: Faces,
    atlas: Atlas,
    made: Blend,
    colors: npt.NDArray[np.float32],
    options: TextureOptions,
    executor: Executor,
    progress: Progress,
) -> list[npt.NDArray[np.uint8]]:
    places = [
        (page, left, top)
        for page, (width, height) in enumerate(atlas.sizes.tolist())
        for top in range(0, height, _TILE)
        for left in range(0, width, _TILE)
    ]
    pages = [np.zeros((h, w, 3), np.uint8) for w, h in atlas.sizes.tolist()]
    filled = [np.zeros((h, w), bool) for w, h in atlas.sizes.tolist()]
    progress.stage("Drawing the texture", len(places))
    tasks = _Tasks(photos, vertices, faces, atlas, made, colors, options.atlas.gutter)
    tiles = (tasks.tile(*place) for place in places)
    for number, tile in executor.map(draw_tile, tiles, progress, _tile_memory(photos)):
        page, left, top = places[number]
        h, w = tile.filled.shape
        pages[page][top : top + h, left : left + w] = tile.rgb
        filled[page][top : top + h, left : left + w] = tile.filled
    progress.stage("Filling between the charts", len(pages))
    for number, (page_rgb, there) in enumerate(zip(pages, filled, strict=True)):
        progress.step(number)
        fill_between(page_rgb, there)
    return pages


def _tile_memory(photos: Sequence[_Moved]) -> int:
    """Bytes that `draw_tile` takes at most: the sums of a tile, and one photo with its halves."""
    largest = max(p.view.intrinsics.width * p.view.intrinsics.height for p in photos)
    return 35 * _TILE**2 + 6 * largest + 20_000_000


class _Tasks:
    def __init__(
        self,
        photos: Sequence[_Moved],
        vertices: Array,
        faces: Faces,
        atlas: Atlas,
        made: Blend,
        colors: npt.NDArray[np.float32],
        gutter: int,
    ) -> None:
        self._photos, self._vertices, self._faces = photos, vertices, faces
        self._atlas, self._made, self._colors, self._gutter = atlas, made, colors, gutter
        self._low = atlas.corners.min(axis=1)
        self._high = atlas.corners.max(axis=1)
        starts = np.zeros(len(faces) + 1, np.int64)
        np.cumsum(np.bincount(made.draw_face, minlength=len(faces)), out=starts[1:])
        self._starts = starts

    def tile(self, page: int, left: int, top: int) -> TileTask:
        width, height = self._atlas.sizes[page].tolist()
        width, height = min(_TILE, width - left), min(_TILE, height - top)
        rim = self._gutter + 1
        low, high = self._low, self._high
        here = np.flatnonzero(
            (self._atlas.page == page)
            & (high[:, 0] > left - rim)
            & (low[:, 0] < left + width + rim)
            & (high[:, 1] > top - rim)
            & (low[:, 1] < top + height + rim)
        )
        made = self._made
        many = self._starts[here + 1] - self._starts[here]
        draws = np.repeat(self._starts[here], many) + (
            np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
        )
        local = np.repeat(np.arange(len(here)), many).astype(np.int32)
        view = made.draw_view[draws]
        parts = []
        for k in np.unique(view).tolist():
            mine = view == k
            rows, face = draws[mine], local[mine]
            _, corners, used = compact(self._vertices, self._faces[here[face]])
            pixels, depths = project(self._photos[k].view, self._vertices[used])
            parts.append(
                TilePhoto(
                    self._photos[k].photo,
                    self._photos[k].view,
                    tuple(made.gains[k].tolist()),
                    face,
                    pixels[corners].astype(np.float32),
                    depths[corners].astype(np.float32),
                    made.draw_weights[rows],
                    made.draw_offsets[rows],
                )
            )
        return TileTask(
            left,
            top,
            width,
            height,
            self._gutter,
            np.ascontiguousarray(self._atlas.corners[here]),
            self._colors[self._faces[here]],
            tuple(parts),
        )


def fill_between(page: npt.NDArray[np.uint8], filled: npt.NDArray[np.bool_]) -> None:
    """Give the free texels smooth colours of the charts about them, so that neither JPEG nor the
    smaller copies of a renderer bring black lines into the charts (pull-push)."""
    if filled.all() or not filled.any():
        return
    # The page itself stays in bytes, four times smaller than as float.
    page[~filled] = 0
    levels = [_halved(page, filled.astype(np.uint8) * np.uint8(255), 255.0)]
    while min(levels[-1][1].shape) > 1:
        levels.append(_halved(*levels[-1], 1.0))
    color, weight = levels[-1]
    below = color / np.maximum(weight, 1e-12)[..., None]
    for color, weight in reversed(levels[:-1]):
        below = color + (1 - weight)[..., None] * _enlarged(below, color.shape)
    grown = _enlarged(np.clip(np.rint(below), 0, 255).astype(np.uint8), page.shape)
    np.copyto(page, grown, where=~filled[..., None])


def _halved(color: Any, weight: Any, full: float) -> tuple[Any, Any]:
    """Means of what counts, times how much of it there is; `full` is the weight of a texel that
    counts wholly. Colours come multiplied by their weights."""
    import cv2

    size = (max(1, (weight.shape[1] + 1) // 2), max(1, (weight.shape[0] + 1) // 2))
    share = cv2.resize(weight, size, interpolation=cv2.INTER_AREA).astype(np.float32) / full
    mean = cv2.resize(color, size, interpolation=cv2.INTER_AREA).astype(np.float32)
    enough = np.minimum(share * 4, 1)
    ratio = np.where(share > 0, enough / np.maximum(share, 1e-12), 0)
    return mean * ratio[..., None], enough


def _enlarged(picture: Any, shape: tuple[int, ...]) -> Any:
    import cv2

    large = cv2.resize(
        np.ascontiguousarray(picture), (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR
    )
    return large.reshape(shape)
