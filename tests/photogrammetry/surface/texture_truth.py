"""A textured face beside what it should look like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.photogrammetry.rock_face import Face
from vomstudio.geometry.mesh import Mesh

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Pictures along +y on one grid: drawn and true (h, w, 3), covered (h, w), face (h, w) of the
    mesh."""

    drawn: Array
    true: Array
    covered: npt.NDArray[np.bool_]
    face: npt.NDArray[np.int64]

    @property
    def gain(self) -> Array:
        """The one factor per channel that a set of photos without a grey card leaves open."""
        return self.true[self.covered].mean(0) / self.drawn[self.covered].mean(0)

    @property
    def residual(self) -> Array:
        return np.where(self.covered[..., None], self.drawn * self.gain - self.true, 0.0)

    def sharpness(self, sigma: float = 0.7) -> float:
        """Contrast between `sigma` and twice that, drawn over true."""
        return float(self._band(self.drawn * self.gain, sigma) / self._band(self.true, sigma))

    def likeness(self, sigma: float = 0.7) -> float:
        """Correlation of the same band."""
        inner = self._inner()
        a, b = self._split(self.drawn, sigma)[inner], self._split(self.true, sigma)[inner]
        return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])

    def low_error(self, sigma: float = 12.0) -> float:
        """Standard deviation of the smoothed residual, 0..255: exposures and stains."""
        import cv2

        weight = cv2.GaussianBlur(self.covered.astype(float), (0, 0), sigma)
        low = cv2.GaussianBlur(self.residual, (0, 0), sigma) / np.maximum(weight, 1e-9)[..., None]
        return float(low[self.covered].std())

    def _inner(self) -> npt.NDArray[np.bool_]:
        import cv2

        return cv2.erode(self.covered.astype(np.uint8), np.ones((9, 9))) > 0

    def _split(self, picture: Array, sigma: float) -> Array:
        import cv2

        grey = np.where(self.covered, picture.mean(-1), picture[self.covered].mean())
        return cv2.GaussianBlur(grey, (0, 0), sigma) - cv2.GaussianBlur(grey, (0, 0), 2 * sigma)

    def _band(self, picture: Array, sigma: float) -> float:
        return float(self._split(picture, sigma)[self._inner()].std())


def sample_pages(
    mesh: Mesh, pages: tuple[npt.NDArray[np.uint8], ...], face: Array, weights: Array
) -> Array:
    """Bilinear colours (n, 3) of the pages at points of faces (n,); weights (n, 2) of the second
    and third corner."""
    assert mesh.uv is not None
    uv = mesh.uv[mesh.faces[face]].astype(float)
    w = np.column_stack([1 - weights.sum(1), weights])
    place = (uv * w[..., None]).sum(1)
    page = np.searchsorted(mesh.material_offsets, face, side="right") - 1
    colors = np.zeros((len(face), 3))
    for k, picture in enumerate(pages):
        rows = np.flatnonzero(page == k)
        h, wide = picture.shape[:2]
        x = np.clip(place[rows, 0] * wide - 0.5, 0, wide - 1.001)
        y = np.clip((1 - place[rows, 1]) * h - 0.5, 0, h - 1.001)
        i, j = x.astype(int), y.astype(int)
        a, b = (x - i)[:, None], (y - j)[:, None]
        p = picture.astype(float)
        colors[rows] = (1 - b) * ((1 - a) * p[j, i] + a * p[j, i + 1]) + b * (
            (1 - a) * p[j + 1, i] + a * p[j + 1, i + 1]
        )
    return colors


def compare(
    mesh: Mesh,
    pages: tuple[npt.NDArray[np.uint8], ...],
    face: Face,
    *,
    step: float,
    box: tuple[float, float, float, float],
    shaded: bool = True,
) -> Comparison:
    """box : x and z of the picture, from and to"""
    import open3d as o3d

    x0, x1, z0, z1 = box
    w, h = int((x1 - x0) / step), int((z1 - z0) / step)

    def cast(scene, per: int):  # type: ignore[no-untyped-def]
        x = x0 + (np.arange(w * per) + 0.5) * step / per
        z = z1 - (np.arange(h * per) + 0.5) * step / per
        xx, zz = np.meshgrid(x, z)
        rays = np.stack([xx, np.full_like(xx, -50.0), zz, 0 * xx, 1 + 0 * xx, 0 * xx], -1)
        hits = scene.cast_rays(o3d.core.Tensor(rays.astype(np.float32)))
        reach = hits["t_hit"].numpy()
        points = np.stack([xx, reach - 50.0, zz], -1)
        return hits, np.isfinite(reach), points

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(mesh.vertices.astype(np.float32)),
        o3d.core.Tensor(mesh.faces.astype(np.uint32)),
    )
    hits, there, _ = cast(scene, 1)
    number = hits["primitive_ids"].numpy().astype(np.int64)
    drawn = np.zeros((h, w, 3))
    drawn[there] = sample_pages(
        mesh, pages, number[there], hits["primitive_uvs"].numpy()[there].astype(float)
    )
    fine, seen, points = cast(face.scene, 2)
    true = np.zeros((2 * h, 2 * w, 3))
    true[seen] = face.paint(points[seen])
    if shaded:
        true[seen] *= face.shade(fine["primitive_normals"].numpy()[seen])[:, None]
    true = true.reshape(h, 2, w, 2, 3).mean((1, 3))
    covered = there & seen.reshape(h, 2, w, 2).all((1, 3))
    return Comparison(drawn, true, covered, np.where(there, number, -1))
