"""A material's picture on the graphics card, at the level its view needs, brought there in pieces.

A software renderer makes its textures in main memory, and most of the time that takes goes into
being given fresh pages. A level that comes in quarters (see `textures.Level`) is therefore brought
one quarter at a time, and drawn by a few lines of shader that choose the quarter; until all four
are there, the level before stays.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer, vtkRenderWindow, vtkTexture

from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.prepare.textures import Texture

QUARTER_NAMES = ("actortexture", "quarter1", "quarter2", "quarter3")
"""The first is what VTK calls an actor's own texture."""

# Each quarter has a rim of one texel from its neighbour, or from the far side of the picture,
# which repeats: what is drawn is to the bit what the picture in one would give.
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


class Skin:
    """A material's texture; `level` is the one on the graphics card, None before the first."""

    def __init__(self, texture: Texture) -> None:
        self.texture = texture
        self.level: int | None = None
        self.wanted = 0
        self._drawn: list[vtkTexture] = []
        self._coming: list[vtkTexture] = []
        self._coming_level = -1

    @property
    def too_coarse(self) -> bool:
        return self.level is None or self.level > self.wanted

    def want(self, texels_per_pixel: float | None) -> None:
        """Choose the coarsest level with about a texel per pixel, given how many texels of the
        finest fall on one; None where the material is not in view."""
        last = len(self.texture.levels) - 1
        if texels_per_pixel is not None:
            wanted = int(np.floor(np.log2(max(texels_per_pixel, 1.0)) + 0.25))
            self.wanted = min(wanted, last)
        else:
            self.wanted = last if self.level is None else self.level

    def upload_piece(self, renderer: vtkRenderer, *, mipmap: bool) -> bool:
        """Bring one piece of the wanted level to the graphics card; True once the level stands
        there, and the actors have to put it on by `wear`."""
        window = renderer.GetRenderWindow()
        window.MakeCurrent()
        if self._coming_level != self.wanted:
            self.forget_pieces(window)
            self._coming_level = self.wanted
        tiles = self.texture.levels[self.wanted].tiles
        piece = vtkTexture()
        piece.SetInputData(vtk_data.image(tiles[len(self._coming)]))
        piece.InterpolateOn()
        piece.SetMipmap(mipmap)
        piece.Render(renderer)
        self._coming.append(piece)
        if len(self._coming) < len(tiles):
            return False
        self._release(self._drawn, window)
        self._drawn, self._coming = self._coming, []
        self.level, self._coming_level = self._coming_level, -1
        return True

    def wear(self, actor: vtkActor) -> bool:
        """Dress an actor in what is on the graphics card; False where nothing is yet."""
        if not self._drawn:
            return False
        wear(actor, self._drawn)
        return True

    def forget_pieces(self, window: vtkRenderWindow | None) -> None:
        """Give back the pieces of a level that is no longer wanted."""
        self._release(self._coming, window)
        self._coming_level = -1

    def release(self, window: vtkRenderWindow | None) -> None:
        self._release(self._drawn, window)
        self.forget_pieces(window)
        self.level = None

    @staticmethod
    def _release(pieces: list[vtkTexture], window: vtkRenderWindow | None) -> None:
        if window is not None:
            for piece in pieces:
                piece.ReleaseGraphicsResources(window)
        pieces.clear()


def wear(actor: vtkActor, pieces: list[vtkTexture]) -> None:
    """Dress an actor in a texture whole or in quarters."""
    take_off(actor)
    actor.SetTexture(pieces[0])
    if len(pieces) > 1:
        for name, piece in zip(QUARTER_NAMES[1:], pieces[1:], strict=True):
            actor.GetProperty().SetTexture(name, piece)
        actor.GetShaderProperty().AddFragmentShaderReplacement(
            "//VTK::TCoord::Impl", True, QUARTERS_SHADER, False
        )


def take_off(actor: vtkActor) -> None:
    # VTK takes None for no texture; its stubs do not say so.
    actor.SetTexture(cast(vtkTexture, None))
    actor.GetProperty().RemoveAllTextures()
    actor.GetShaderProperty().ClearAllFragmentShaderReplacements()
