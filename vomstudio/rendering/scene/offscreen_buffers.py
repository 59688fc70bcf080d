"""Pictures with depth that are saved in graphics memory."""

from __future__ import annotations

from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLFramebufferObject, vtkOpenGLRenderWindow

from vomstudio.rendering.scene.dirty_region import PixelRegion

GL_READ_FRAMEBUFFER = 0x8CA8
GL_DRAW_FRAMEBUFFER = 0x8CA9
GL_COLOR_AND_DEPTH = 0x4000 | 0x0100
GL_NEAREST = 0x2600


class Buffers:
    """Saved pictures of a window by name, each with the window size at the time of saving."""

    def __init__(self, window: vtkOpenGLRenderWindow) -> None:
        self._window = window
        self._buffers: dict[str, vtkOpenGLFramebufferObject] = {}
        # In Python, VTK returns the size of a buffer as a raw pointer.
        self._sizes: dict[str, tuple[int, int]] = {}

    def __getitem__(self, name: str) -> vtkOpenGLFramebufferObject:
        return self._buffers[name]

    def save(self, name: str, region: PixelRegion | None = None) -> None:
        """Save the picture of the window, or only a part of it."""
        buffer = self._buffers[name] = self._prepare_buffer(name)
        self._copy_region(self._window.GetRenderFramebuffer(), buffer, region)

    def restore(self, name: str, region: PixelRegion | None = None) -> None:
        """Restore a saved picture, or only a part of it."""
        self._copy_region(self._buffers[name], self._window.GetRenderFramebuffer(), region)

    def release(self) -> None:
        for buffer in self._buffers.values():
            buffer.ReleaseGraphicsResources(self._window)
        self._buffers.clear()
        self._sizes.clear()

    def _prepare_buffer(self, name: str) -> vtkOpenGLFramebufferObject:
        width, height = self._window.GetSize()
        buffer = self._buffers.get(name)
        if buffer is not None:
            if self._sizes[name] == (width, height):
                return buffer
            buffer.ReleaseGraphicsResources(self._window)
        buffer = vtkOpenGLFramebufferObject()
        buffer.SetContext(self._window)
        state = self._window.GetState()
        state.PushFramebufferBindings()
        unsigned_char, depth_bits = 3, 32
        buffer.PopulateFramebuffer(
            width, height, True, 1, unsigned_char, True, depth_bits, 0, False
        )
        state.PopFramebufferBindings()
        self._sizes[name] = (width, height)
        return buffer

    def _copy_region(
        self,
        source: vtkOpenGLFramebufferObject,
        target: vtkOpenGLFramebufferObject,
        region: PixelRegion | None,
    ) -> None:
        self._window.MakeCurrent()
        width, height = self._window.GetSize()
        region = region or PixelRegion(0, 0, width - 1, height - 1)
        # First and end columns, then first and end rows.
        extent = [region.left, region.right + 1, region.bottom, region.top + 1]
        state = self._window.GetState()
        state.PushFramebufferBindings()
        source.Bind(GL_READ_FRAMEBUFFER)
        target.Bind(GL_DRAW_FRAMEBUFFER)
        vtkOpenGLFramebufferObject.Blit(extent, extent, GL_COLOR_AND_DEPTH, GL_NEAREST)
        state.PopFramebufferBindings()
