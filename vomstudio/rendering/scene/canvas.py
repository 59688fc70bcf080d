"""Window for drawing with VTK, off screen or of a widget, and its pixels.

There are three layers: layer 0 contains the surface of the models, layer 1 the features over
them, and layer 2 the selected or live features. The colour and depth of a completed layer are
saved. When a layer above changes later, they are restored instead of drawing the layer again.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from vtkmodules.vtkCommonCore import vtkCommand, vtkFloatArray, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkRecti
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkLight, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderWindow, vtkTextureObject

from vomstudio.core.arrays import ByteArray, Float32Array, FloatArray
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.dirty_region import PixelRegion
from vomstudio.rendering.scene.offscreen_buffers import Buffers
from vomstudio.rendering.view.camera import Eye

# Uniform neutral colour, because a gradient takes a software renderer 12 ms per frame.
BACKGROUND = (0.36, 0.375, 0.39)

SOFTWARE_TEXTURE_SIDE = 4096
SOFTWARE_WHOLE_SIDE = 2048
"""Maximum side length, in pixels, of textures that a software renderer uploads undivided."""
SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "basic render", "swr")


class Canvas:
    """VTK window with three layers, off screen unless it is the window of a widget.

    Attributes
    ----------
    size : (int, int)
        Width and height in device pixels.
    origin : (3,) float64 or None
        World position of the origin of VTK's 32-bit coordinates; None if there are no contents.
    is_software : bool
        Whether a software renderer is used.
    texture_limit : int
        Maximum side length of a texture, pixels.
    whole_texture_side : int or None
        Maximum side length of a texture that is uploaded in one piece, pixels; None for any.
    frames : int
        Number of pictures that have been drawn.
    is_surface_saved, are_features_saved : bool
        Whether the picture of the models, and the picture with features, is saved.
    """

    def __init__(
        self, window: vtkOpenGLRenderWindow | None = None, surface: vtkRenderer | None = None
    ) -> None:
        """Create a canvas.

        Parameters
        ----------
        window : vtkOpenGLRenderWindow, optional
            Window of a widget, which sets its size and finalizes it. By default, a window is
            created off screen.
        surface : vtkRenderer, optional
            Renderer of layer 0 that the window already contains.
        """
        self.size = (1, 1)
        self.origin: FloatArray | None = None
        self.is_software = True
        self.texture_limit = SOFTWARE_TEXTURE_SIDE
        self.whole_texture_side: int | None = SOFTWARE_WHOLE_SIDE
        self.frames = 0
        self.is_surface_saved = self.are_features_saved = False
        self.surface = vtkRenderer() if surface is None else surface
        self.layer, self.emphasis = vtkRenderer(), vtkRenderer()
        self._widget_window = window
        self._window: vtkOpenGLRenderWindow | None = None
        self._buffers: Buffers | None = None
        self._layer_callback: Callable[[], None] | None = None
        self._emphasis_callback: Callable[[], None] | None = None
        self._pixels = vtkUnsignedCharArray()
        self._depths = vtkFloatArray()
        self._depth: Float32Array | None = None

    # -- life

    @property
    def is_open(self) -> bool:
        return self._window is not None

    @property
    def window(self) -> vtkOpenGLRenderWindow:
        assert self._window is not None, "the canvas is not open"
        return self._window

    @property
    def buffers(self) -> Buffers:
        """Pictures that are saved in graphics memory."""
        assert self._buffers is not None, "the canvas is not open"
        return self._buffers

    def open(self, width: int, height: int) -> None:
        window = self._widget_window or self._off_screen_window(width, height)
        window.SetMultiSamples(0)
        window.SetNumberOfLayers(3)
        self.size = (width, height)
        surface = self.surface
        surface.SetBackground(*BACKGROUND)
        for number, renderer in enumerate((self.layer, self.emphasis), start=1):
            renderer.SetLayer(number)
            renderer.PreserveDepthBufferOn()
            renderer.PreserveColorBufferOn()
        self.layer.AddObserver(vtkCommand.StartEvent, self._begin_layer)
        self.emphasis.AddObserver(vtkCommand.StartEvent, self._begin_emphasis)
        for renderer in (surface, self.layer, self.emphasis):
            renderer.SetAutomaticLightCreation(0)
            # Uses plain blending, because weighted blending needs three more full-screen passes.
            renderer.SetUseOIT(False)
            if not window.HasRenderer(renderer):
                window.AddRenderer(renderer)
        # A headlight illuminates everything that is visible.
        surface.RemoveAllLights()
        light = vtkLight()
        light.SetLightTypeToHeadlight()
        surface.AddLight(light)
        surface.GetActiveCamera()
        for renderer in (self.layer, self.emphasis):
            renderer.SetActiveCamera(surface.GetActiveCamera())
        self._window = window
        self._buffers = Buffers(window)

    @staticmethod
    def _off_screen_window(width: int, height: int) -> vtkOpenGLRenderWindow:
        window = vtkRenderWindow()
        # VTK creates this class on every platform, and only this class has its own buffers.
        assert isinstance(window, vtkOpenGLRenderWindow)
        window.SetOffScreenRendering(1)
        window.SetSize(width, height)
        return window

    def detect_driver(self) -> None:
        """Draw once to detect the graphics driver."""
        window = self.window
        window.Render()
        report = window.ReportCapabilities().lower()
        names = [line for line in report.splitlines() if "opengl renderer" in line]
        self.is_software = not names or any(word in names[0] for word in SOFTWARE_RENDERERS)
        max_texture_size = int(vtkTextureObject.GetMaximumTextureSize(window))
        self.texture_limit = (
            min(max_texture_size, SOFTWARE_TEXTURE_SIDE) if self.is_software else max_texture_size
        )
        self.whole_texture_side = SOFTWARE_WHOLE_SIDE if self.is_software else None

    def make_current(self) -> None:
        """Make the graphics context of this canvas current."""
        self.window.MakeCurrent()

    def close(self) -> None:
        """Stop using the canvas and release all graphics resources."""
        window = self.window
        self.buffers.release()
        for renderer in (self.surface, self.layer, self.emphasis):
            renderer.RemoveAllObservers()
            renderer.RemoveAllViewProps()
            window.RemoveRenderer(renderer)
        if self._widget_window is None:
            window.Finalize()
        self._window = None

    def resize(self, width: int, height: int) -> None:
        self.size = (width, height)
        if self._window is not None:
            if self._widget_window is None:
                self._window.SetSize(width, height)
            self.is_surface_saved = self.are_features_saved = False

    # -- contents

    @property
    def start(self) -> FloatArray:
        """Origin (3,) in the World frame, or zeros if there are no contents."""
        return np.zeros(3) if self.origin is None else self.origin

    def placement(self, to_world: FloatArray, origin: FloatArray) -> vtkMatrix4x4:
        """Return the placement of data from which a local origin was subtracted."""
        values = to_world.copy()
        values[:3, 3] = to_world[:3, :3] @ origin + to_world[:3, 3] - self.start
        return vtk_data.matrix(values)

    def add(self, actor: vtkActor) -> None:
        """Add an actor to the layer of the models."""
        if self._window is not None:
            self.surface.AddActor(actor)

    def remove(self, actor: vtkActor) -> None:
        if self._window is not None:
            self.surface.RemoveActor(actor)
            actor.ReleaseGraphicsResources(self._window)

    def look(self, eye: Eye, distance: float, view_angle_deg: float) -> None:
        """Set the view for subsequent drawings.

        Parameters
        ----------
        eye : Eye
        distance : float
            Distance at which the scale of an orthographic view is defined, metres.
        view_angle_deg : float
            Vertical angle of view.
        """
        position = eye.position - self.start
        vtk_camera = self.surface.GetActiveCamera()
        vtk_camera.SetPosition(*position)
        vtk_camera.SetFocalPoint(*(position + eye.direction * max(distance, 1e-3)))
        vtk_camera.SetViewUp(*eye.up)
        vtk_camera.SetParallelProjection(eye.orthographic)
        vtk_camera.SetViewAngle(view_angle_deg)
        if eye.orthographic:
            vtk_camera.SetParallelScale(eye.half_height)
        vtk_camera.SetClippingRange(eye.near, eye.far)

    def render(
        self,
        *,
        clears_canvas: bool,
        draws_surface: bool,
        draws_layer: bool,
        draws_emphasis: bool,
        layer_callback: Callable[[], None] | None = None,
        emphasis_callback: Callable[[], None] | None = None,
    ) -> None:
        """Draw the requested layers.

        `layer_callback` and `emphasis_callback` are called before layers 1 and 2, and may call
        `confine`.
        """
        self.surface.SetDraw(draws_surface)
        self.surface.SetErase(clears_canvas)
        self.layer.SetDraw(draws_layer)
        self.emphasis.SetDraw(draws_emphasis)
        self._layer_callback, self._emphasis_callback = layer_callback, emphasis_callback
        if draws_layer:
            self._depth = None
        self.window.Render()
        self._layer_callback = self._emphasis_callback = None
        self.confine(None)
        self.frames += 1

    def confine(self, region: PixelRegion | None) -> None:
        """Restrict drawing to a part of the picture; None removes the restriction."""
        camera = self.surface.GetActiveCamera()
        camera.SetUseScissor(region is not None)
        if region is not None:
            camera.SetScissorRect(vtkRecti(region.left, region.bottom, *region.size))

    def wait(self) -> None:
        """Wait until the graphics card has drawn everything."""
        self.window.WaitForCompletion()

    def _begin_layer(self, *_: object) -> None:
        if self._layer_callback is not None:
            self._layer_callback()

    def _begin_emphasis(self, *_: object) -> None:
        if self._emphasis_callback is not None:
            self._emphasis_callback()

    # -- saved layers

    def save_surface(self) -> None:
        self.buffers.save("surface")
        self.is_surface_saved = True

    def restore_surface(self, region: PixelRegion | None = None) -> None:
        self.buffers.restore("surface", region)

    def save_features(self, region: PixelRegion | None = None) -> None:
        """Save the picture with features, or only the part that was redrawn."""
        self.buffers.save("features", region)
        self.are_features_saved = True

    def restore_features(self, region: PixelRegion | None = None) -> None:
        self.buffers.restore("features", region)

    # -- results

    def pixels(self) -> ByteArray:
        """Return the last picture (height, width, 4), bottom row first."""
        width, height = self.size
        self.window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, self._pixels, 0)
        return np.asarray(vtk_data.to_array(self._pixels), np.uint8).reshape(height, width, 4)

    def depth(self) -> Float32Array:
        """Return the depth buffer (height, width) of the last picture with features.

        Values are 0 at the near plane and 1 at the far plane; they are read once per picture.
        """
        if self._depth is None:
            width, height = self.size
            self.window.GetZbufferData(0, 0, width - 1, height - 1, self._depths)
            depths = np.asarray(vtk_data.to_array(self._depths), np.float32)
            self._depth = depths.reshape(height, width)
        return self._depth

    def surface_depth(self) -> Float32Array:
        """Return the depth buffer (height, width) of the models.

        It includes the features if the picture of the models is not saved.
        """
        depth = self.depth()
        if not self.is_surface_saved:
            return depth
        self.restore_surface()
        width, height = self.size
        values = vtkFloatArray()
        self.window.GetZbufferData(0, 0, width - 1, height - 1, values)
        if self.are_features_saved:
            self.restore_features()
        return np.asarray(vtk_data.to_array(values), np.float32).reshape(height, width)
