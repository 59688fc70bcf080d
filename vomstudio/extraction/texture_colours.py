"""Colours at positions on a textured mesh."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from vomstudio.core.arrays import ByteArray, FloatArray, IntArray
from vomstudio.geometry.mesh import Mesh

_MISSING_GREY = 128.0


class TextureColours:
    """Sampler of the colours of a textured mesh.

    Pictures are read when first required. If a picture cannot be read, the diffuse colour of its
    material is used, or else grey.

    Parameters
    ----------
    mesh : Mesh

    Attributes
    ----------
    has_textures : bool
        Whether the mesh has a texture.
    uv : (n, 2) array
        Texture coordinates of the vertices.
    """

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self.has_textures = mesh.uv is not None and any(
            m.texture is not None for m in mesh.materials
        )
        self.uv: FloatArray = (
            np.zeros((len(mesh.vertices), 2))
            if mesh.uv is None
            else np.asarray(mesh.uv, np.float64)
        )
        self._texture_images: dict[tuple[int, int], ByteArray | None] = {}

    def face_materials(self, faces: IntArray) -> IntArray:
        """Return the material (k,) of faces; -1 if a face has none."""
        offsets = np.asarray(self._mesh.material_offsets, np.int64)
        materials = np.searchsorted(offsets, faces, side="right") - 1
        return np.where(materials < len(self._mesh.materials), materials, -1)

    def median_edge_px(self, uv: FloatArray, triangles: IntArray, material: IntArray) -> float:
        """Return the median edge length in texture pixels; 1 if it is unknown."""
        sizes = np.zeros((len(self._mesh.materials) + 1, 2))
        for m in _distinct_materials(material):
            sizes[m] = self._picture_size(m)
        scale = sizes[material]
        a, b = uv[triangles[:, 0]] * scale, uv[triangles[:, 1]] * scale
        length = np.linalg.norm(a - b, axis=1)
        length = length[np.isfinite(length)]
        return float(np.median(length)) if len(length) else 1.0

    def at(self, uv: FloatArray, triangles: IntArray, material: IntArray, level: int) -> FloatArray:
        """Sample colours (n, 3) at vertices, averaged over about half an edge.

        Parameters
        ----------
        uv : (n, 2) array
            Texture coordinates of the vertices.
        triangles : (k, 3) int array
        material : (k,) int array
            Material of each triangle.
        level : int
            Number of times that the faces of the mesh were subdivided.
        """
        colours = np.full((len(uv), 3), _MISSING_GREY)
        pixels = self.median_edge_px(uv, triangles, material)
        halvings = int(np.clip(np.floor(np.log2(max(pixels / 2.0, 1.0))), 0, 8))
        for m in _distinct_materials(material):
            picture = self._texture_image(m, halvings)
            is_used = np.zeros(len(uv), np.bool_)
            is_used[triangles[material == m].ravel()] = True
            rows = np.flatnonzero(is_used)
            if picture is not None:
                colours[rows] = _interpolate(picture, uv[rows])
            elif m >= 0 and (diffuse := self._mesh.materials[m].diffuse) is not None:
                colours[rows] = 255.0 * np.asarray(diffuse)
        return colours

    @cached_property
    def vertex_colours(self) -> FloatArray:
        """Colours (n, 3) of the vertices of the mesh, averaged over about half an edge."""
        faces = np.arange(len(self._mesh.faces))
        return self.at(
            self.uv, np.asarray(self._mesh.faces, np.int64), self.face_materials(faces), 0
        )

    def _picture_size(self, material: int) -> tuple[int, int]:
        picture = self._texture_image(material, 0)
        return (1, 1) if picture is None else (picture.shape[1], picture.shape[0])

    def _texture_image(self, material: int, halvings: int) -> ByteArray | None:
        key = (material, halvings)
        if key not in self._texture_images:
            self._texture_images[key] = self._read_picture(material, halvings)
        return self._texture_images[key]

    def _read_picture(self, material: int, halvings: int) -> ByteArray | None:
        if material < 0 or self._mesh.materials[material].texture is None:
            return None
        if halvings:
            full_picture = self._texture_image(material, 0)
            if full_picture is None:
                return None
            from PIL import Image

            return np.asarray(Image.fromarray(full_picture).reduce(2**halvings))
        from vomstudio.core.errors import InputError
        from vomstudio.io.photos.pixels import open_photo

        try:
            with open_photo(self._mesh.materials[material].texture or "") as image:
                return np.asarray(image.convert("RGB"))
        except InputError:
            # The reader of the model has already reported the missing picture.
            return None


def _distinct_materials(material: IntArray) -> list[int]:
    """Return the distinct materials in ascending order; -1 stands for no material."""
    return [int(m) for m in np.flatnonzero(np.bincount(material + 1)) - 1]


def _interpolate(picture: ByteArray, uv: FloatArray) -> FloatArray:
    """Interpolate colours at texture coordinates, whose origin is at the lower left.

    The picture is repeated outside the range 0 to 1.
    """
    height, width = picture.shape[:2]
    is_known = np.asarray(np.isfinite(uv).all(axis=1))
    finite_uv = np.where(is_known[:, None], uv, 0.0)
    values = np.where(
        (finite_uv >= 0.0) & (finite_uv <= 1.0), finite_uv, finite_uv - np.floor(finite_uv)
    )
    x = np.clip(values[:, 0] * width - 0.5, 0.0, width - 1.0)
    y = np.clip((1.0 - values[:, 1]) * height - 0.5, 0.0, height - 1.0)
    i, j = x.astype(np.int64), y.astype(np.int64)
    i1, j1 = np.minimum(i + 1, width - 1), np.minimum(j + 1, height - 1)
    fx, fy = (x - i)[:, None], (y - j)[:, None]
    colours = (
        picture[j, i] * (1 - fx) * (1 - fy)
        + picture[j, i1] * fx * (1 - fy)
        + picture[j1, i] * (1 - fx) * fy
        + picture[j1, i1] * fx * fy
    )
    return np.asarray(np.where(is_known[:, None], colours, _MISSING_GREY))
