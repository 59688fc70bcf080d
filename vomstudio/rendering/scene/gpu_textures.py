"""Textures on the graphics card, uploaded in pieces at the level required for the view.

A software renderer allocates textures in main memory, and spends most of the upload time on new
memory pages. A level in quarters (see `textures.Level`) is therefore uploaded one quarter at a
time, and drawn by a shader that selects the quarter. The previous level remains in use until all
four quarters are present.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer, vtkRenderWindow, vtkTexture

from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.prepare.textures import Texture

QUARTER_NAMES = ("actortexture", "quarter1", "quarter2", "quarter3")
"""Names of the quarters in the shader; the first is VTK's name for the texture of an actor."""

# Each quarter has a border of one texel from its neighbour or, because the picture repeats, from
# its opposite side. The result is identical to that of the undivided picture.
QUARTERS_SHADER = """
  vec2 lower = vec2(textureSize(actortexture, 0) - 2);
  vec2 upper = vec2(textureSize(quarter3, 0) - 2);
  vec2 place = fract(tcoordVCVSOutput) * (lower + upper);
  bvec2 beyond = greaterThanEqual(place, lower);
  place = (place + 1.0 - mix(vec2(0.0), lower, beyond)) / (mix(lower, upper, beyond) + 2.0);
  vec4 texel;
  if (beyond.y) {
    if (beyond.x) texel = textureLod(quarter3, place, 0.0);
    else texel = textureLod(quarter2, place, 0.0);
  } else {
    if (beyond.x) texel = textureLod(quarter1, place, 0.0);
    else texel = textureLod(actortexture, place, 0.0);
  }
  gl_FragData[0] = gl_FragData[0] * texel;
"""


class GpuTexture:
    """Texture of a material; `level` is the uploaded level (None before the first upload)."""

    def __init__(self, texture: Texture) -> None:
        self.texture = texture
        self.level: int | None = None
        self.target_level = 0
        self._uploaded_pieces: list[vtkTexture] = []
        self._next_pieces: list[vtkTexture] = []
        self._next_level = -1

    @property
    def is_too_coarse(self) -> bool:
        return self.level is None or self.level > self.target_level

    def request_level(self, texels_per_pixel: float | None) -> None:
        """Choose the coarsest level with about one texel per pixel.

        Parameters
        ----------
        texels_per_pixel : float or None
            Texels of the finest level per pixel, or None if the material is not in view.
        """
        coarsest_level = len(self.texture.levels) - 1
        if texels_per_pixel is not None:
            level = int(np.floor(np.log2(max(texels_per_pixel, 1.0)) + 0.25))
            self.target_level = min(level, coarsest_level)
        else:
            self.target_level = coarsest_level if self.level is None else self.level

    def upload_piece(self, renderer: vtkRenderer, *, has_mipmap: bool) -> bool:
        """Upload a piece of the target level. Return True once the level is complete.

        The texture must then be applied to the actors with `apply_to`.
        """
        window = renderer.GetRenderWindow()
        window.MakeCurrent()
        if self._next_level != self.target_level:
            self.forget_pieces(window)
            self._next_level = self.target_level
        tiles = self.texture.levels[self.target_level].tiles
        piece = vtkTexture()
        piece.SetInputData(vtk_data.image(tiles[len(self._next_pieces)]))
        piece.InterpolateOn()
        piece.SetMipmap(has_mipmap)
        piece.Render(renderer)
        self._next_pieces.append(piece)
        if len(self._next_pieces) < len(tiles):
            return False
        self._release(self._uploaded_pieces, window)
        self._uploaded_pieces, self._next_pieces = self._next_pieces, []
        self.level, self._next_level = self._next_level, -1
        return True

    def apply_to(self, actor: vtkActor) -> bool:
        """Apply the uploaded texture to an actor. Return False if nothing is uploaded yet."""
        if not self._uploaded_pieces:
            return False
        apply_to(actor, self._uploaded_pieces)
        return True

    def forget_pieces(self, window: vtkRenderWindow | None) -> None:
        """Release the pieces of an obsolete target level."""
        self._release(self._next_pieces, window)
        self._next_level = -1

    def release(self, window: vtkRenderWindow | None) -> None:
        self._release(self._uploaded_pieces, window)
        self.forget_pieces(window)
        self.level = None

    @staticmethod
    def _release(pieces: list[vtkTexture], window: vtkRenderWindow | None) -> None:
        if window is not None:
            for piece in pieces:
                piece.ReleaseGraphicsResources(window)
        pieces.clear()


def apply_to(actor: vtkActor, pieces: list[vtkTexture]) -> None:
    """Apply a texture, undivided or in quarters, to an actor."""
    remove_textures(actor)
    actor.SetTexture(pieces[0])
    if len(pieces) > 1:
        for name, piece in zip(QUARTER_NAMES[1:], pieces[1:], strict=True):
            actor.GetProperty().SetTexture(name, piece)
        actor.GetShaderProperty().AddFragmentShaderReplacement(
            "//VTK::TCoord::Impl", True, QUARTERS_SHADER, False
        )


def remove_textures(actor: vtkActor) -> None:
    """Remove the textures of an actor and their shader code."""
    # VTK accepts None as no texture, although its type stubs do not.
    actor.SetTexture(cast(vtkTexture, None))
    actor.GetProperty().RemoveAllTextures()
    actor.GetShaderProperty().ClearAllFragmentShaderReplacements()
