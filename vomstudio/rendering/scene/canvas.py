"""The off-screen window that VTK draws in, and what can be read from it.

Three layers: layer 0 is the surface of the models, layer 1 the features drawn over them, layer 2
what is selected among these or being painted. When a layer stands, colour and depth are kept aside;
a later change of those above it puts them back instead of drawing it again.
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
from vomstudio.rendering.scene.dirty_region import Spot
from vomstudio.rendering.scene.offscreen_buffers import Buffers
from vomstudio.rendering.view.camera import Eye

# One flat neutral: a gradient costs a software renderer 12 ms in every frame.
BACKGROUND = (0.36, 0.375, 0.39)

SOFTWARE_TEXTURE_SIDE = 4096
SOFTWARE_WHOLE_SIDE = 2048
"""A larger one goes to a software renderer in quarters."""
SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "basic render", "swr")


class Canvas:
    """size : (width, height) in pixels of the device
    origin : (3,) World, from where VTK counts in its 32 bits; None while there is nothing
    software : the processor draws, there is no graphics card
    texture_limit : largest side of a texture in pixels; whole_texture_side : the largest that is
        taken to the card in one piece, None for any
    frames : how many pictures have been drawn; kept : the surface of the models is kept aside;
    features_kept : and so is the same with the features
    """

    def __init__(self) -> None:
        self.size = (1, 1)
        self.origin: FloatArray | None = None
        self.software = True
        self.texture_limit = SOFTWARE_TEXTURE_SIDE
        self.whole_texture_side: int | None = SOFTWARE_WHOLE_SIDE
        self.frames = 0
        self.kept = self.features_kept = False
        self.surface, self.layer, self.chosen = vtkRenderer(), vtkRenderer(), vtkRenderer()
        self._window: vtkOpenGLRenderWindow | None = None
        self._buffers: Buffers | None = None
        self._before_layer: Callable[[], None] | None = None
        self._before_chosen: Callable[[], None] | None = None
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
        """Pictures kept aside where they are drawn."""
        assert self._buffers is not None, "the canvas is not open"
        return self._buffers

    def open(self, width: int, height: int) -> None:
        window = vtkRenderWindow()
        # What VTK makes of it on every platform; only it has buffers of its own.
        assert isinstance(window, vtkOpenGLRenderWindow)
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetSize(width, height)
        window.SetNumberOfLayers(3)
        self.size = (width, height)
        surface = self.surface
        surface.SetBackground(*BACKGROUND)
        for number, renderer in enumerate((self.layer, self.chosen), start=1):
            renderer.SetLayer(number)
            renderer.PreserveDepthBufferOn()
            renderer.PreserveColorBufferOn()
        self.layer.AddObserver(vtkCommand.StartEvent, self._layer_starts)
        self.chosen.AddObserver(vtkCommand.StartEvent, self._chosen_starts)
        for renderer in (surface, self.layer, self.chosen):
            renderer.SetAutomaticLightCreation(0)
            # Plain blending: the weighted kind needs three more full-screen passes.
            renderer.SetUseOIT(False)
            window.AddRenderer(renderer)
        # A head light: what is seen is lit.
        light = vtkLight()
        light.SetLightTypeToHeadlight()
        surface.AddLight(light)
        surface.GetActiveCamera()
        for renderer in (self.layer, self.chosen):
            renderer.SetActiveCamera(surface.GetActiveCamera())
        self._window = window
        self._buffers = Buffers(window)

    def learn_driver(self) -> None:
        """Draw once, and learn what the graphics driver is."""
        window = self.window
        window.Render()
        report = window.ReportCapabilities().lower()
        names = [line for line in report.splitlines() if "opengl renderer" in line]
        self.software = not names or any(word in names[0] for word in SOFTWARE_RENDERERS)
        largest = int(vtkTextureObject.GetMaximumTextureSize(window))
        self.texture_limit = min(largest, SOFTWARE_TEXTURE_SIDE) if self.software else largest
        self.whole_texture_side = SOFTWARE_WHOLE_SIDE if self.software else None

    def make_current(self) -> None:
        """What the graphics card is told from now on is of this canvas."""
        self.window.MakeCurrent()

    def close(self) -> None:
        """Release every graphics resource; the canvas cannot be opened again."""
        window = self.window
        self.buffers.release()
        for renderer in (self.surface, self.layer, self.chosen):
            renderer.RemoveAllObservers()
            renderer.RemoveAllViewProps()
            window.RemoveRenderer(renderer)
        window.Finalize()
        self._window = None

    def resize(self, width: int, height: int) -> None:
        self.size = (width, height)
        if self._window is not None:
            self._window.SetSize(width, height)
            self.kept = self.features_kept = False

    # -- what is drawn

    @property
    def start(self) -> FloatArray:
        """(3,) World, the origin, or zeros while there is none."""
        return np.zeros(3) if self.origin is None else self.origin

    def placement(self, to_world: FloatArray, origin: FloatArray) -> vtkMatrix4x4:
        """Where VTK has to put what is given in a file's frame, less an origin of its own."""
        values = to_world.copy()
        values[:3, 3] = to_world[:3, :3] @ origin + to_world[:3, 3] - self.start
        return vtk_data.matrix(values)

    def add(self, actor: vtkActor) -> None:
        """To the surface."""
        if self._window is not None:
            self.surface.AddActor(actor)

    def remove(self, actor: vtkActor) -> None:
        if self._window is not None:
            self.surface.RemoveActor(actor)
            actor.ReleaseGraphicsResources(self._window)

    def look(self, eye: Eye, distance: float, view_angle_deg: float) -> None:
        """Draw from here on as the eye sees. distance : m, at which an orthographic view has its
        scale"""
        position = eye.position - self.start
        drawn = self.surface.GetActiveCamera()
        drawn.SetPosition(*position)
        drawn.SetFocalPoint(*(position + eye.direction * max(distance, 1e-3)))
        drawn.SetViewUp(*eye.up)
        drawn.SetParallelProjection(eye.orthographic)
        drawn.SetViewAngle(view_angle_deg)
        if eye.orthographic:
            drawn.SetParallelScale(eye.half_height)
        drawn.SetClippingRange(eye.near, eye.far)

    def render(
        self,
        *,
        erase: bool,
        surface: bool,
        layer: bool,
        chosen: bool,
        before_layer: Callable[[], None] | None = None,
        before_chosen: Callable[[], None] | None = None,
    ) -> None:
        """Draw these layers. before_layer, before_chosen : called before layers 1 and 2, which say
        what to `confine` them to"""
        self.surface.SetDraw(surface)
        self.surface.SetErase(erase)
        self.layer.SetDraw(layer)
        self.chosen.SetDraw(chosen)
        self._before_layer, self._before_chosen = before_layer, before_chosen
        if layer:
            self._depth = None
        self.window.Render()
        self._before_layer = self._before_chosen = None
        self.confine(None)
        self.frames += 1

    def confine(self, spot: Spot | None) -> None:
        """Draw from here on only in a spot of the picture; None for all of it."""
        camera = self.surface.GetActiveCamera()
        camera.SetUseScissor(spot is not None)
        if spot is not None:
            camera.SetScissorRect(vtkRecti(spot.left, spot.bottom, *spot.size))

    def wait(self) -> None:
        """Until everything has been drawn."""
        self.window.WaitForCompletion()

    def _layer_starts(self, *_: object) -> None:
        if self._before_layer is not None:
            self._before_layer()

    def _chosen_starts(self, *_: object) -> None:
        if self._before_chosen is not None:
            self._before_chosen()

    # -- keeping the models' picture aside

    def keep_surface(self) -> None:
        self.buffers.save("surface")
        self.kept = True

    def restore_surface(self, spot: Spot | None = None) -> None:
        self.buffers.restore("surface", spot)

    def keep_features(self, spot: Spot | None = None) -> None:
        """spot : where they have been drawn anew, if not everywhere"""
        self.buffers.save("features", spot)
        self.features_kept = True

    def restore_features(self) -> None:
        self.buffers.restore("features")

    # -- what was drawn

    def pixels(self) -> ByteArray:
        """(height, width, 4) of the last picture, first row at the bottom; valid until the next."""
        width, height = self.size
        self.window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, self._pixels, 0)
        return np.asarray(vtk_data.array_of(self._pixels), np.uint8).reshape(height, width, 4)

    def depth(self) -> Float32Array:
        """(height, width) of the last picture with features, 0 at the near plane to 1 at the far
        one; read once for each."""
        if self._depth is None:
            width, height = self.size
            self.window.GetZbufferData(0, 0, width - 1, height - 1, self._depths)
            depths = np.asarray(vtk_data.array_of(self._depths), np.float32)
            self._depth = depths.reshape(height, width)
        return self._depth

    def surface_depth(self) -> Float32Array:
        """As `depth`, of the models alone where they have been kept aside: what is drawn over them
        hides nothing of them."""
        shown = self.depth()
        if not self.kept:
            return shown
        self.restore_surface()
        width, height = self.size
        values = vtkFloatArray()
        self.window.GetZbufferData(0, 0, width - 1, height - 1, values)
        if self.features_kept:
            self.restore_features()
        return np.asarray(vtk_data.array_of(values), np.float32).reshape(height, width)
