"""Eye-dome lighting, which darkens pixels according to their depth behind neighbours.

It shows the shape of a cloud that has no normals. The method follows Christian Boucheny,
Visualisation scientifique interactive de grands volumes de donnees, PhD thesis, Grenoble (2009),
with logarithms of depth as in Markus Schuetz, Potree, master's thesis, TU Wien (2016).

It is a single pass over the finished picture of the models, before the features are drawn over
it. The pass is divided into horizontal bands, so that a software renderer can process them
between the events of a window.
"""

from __future__ import annotations

from vtkmodules.vtkRenderingOpenGL2 import (
    vtkOpenGLFramebufferObject,
    vtkOpenGLQuadHelper,
    vtkOpenGLRenderWindow,
)

STRENGTH = 200.0
SHADING_RADIUS_PIXELS = 1.4
BAND_COUNT = 6

GL_SCISSOR_TEST = 0x0C11
GL_ALWAYS = 0x0207
GL_LEQUAL = 0x0203

VERTEX_SHADER = """//VTK::System::Dec
in vec4 ndCoordIn;
in vec2 texCoordIn;
out vec2 place;
void main() {
  gl_Position = ndCoordIn;
  place = texCoordIn;
}
"""

FRAGMENT_SHADER = """//VTK::System::Dec
//VTK::Output::Dec
in vec2 place;
uniform sampler2D colors;
uniform sampler2D depths;
uniform vec2 pixel;
uniform vec2 range;
uniform int parallel;
uniform float distance;
uniform float strength;
float depthOf(float z) {
  // Of an orthographic view the depth at which its scale is stated takes the place of the viewer.
  float deep = parallel == 1 ? distance + (z - 0.5) * (range.y - range.x)
                             : range.x * range.y / (range.y - z * (range.y - range.x));
  return log2(max(deep, 0.01 * distance));
}
void main() {
  vec4 own = texture(colors, place);
  float z = texture(depths, place).r;
  if (z < 1.0) {
    float here = depthOf(z);
    float behind = 0.0;
    for (int i = 0; i < 8; i++) {
      float turn = 0.785398 * float(i);
      vec2 at = place + pixel * vec2(cos(turn), sin(turn));
      float other = texture(depths, at).r;
      if (other < 1.0) behind += max(0.0, here - depthOf(other));
    }
    own.rgb *= exp(-strength * behind / 8.0);
  }
  gl_FragData[0] = own;
  gl_FragDepth = z;
}
"""


class EyeDome:
    """Eye-dome lighting, bound to the graphics context of one window."""

    def __init__(self) -> None:
        self._quad: vtkOpenGLQuadHelper | None = None

    def shade(
        self,
        window: vtkOpenGLRenderWindow,
        source: vtkOpenGLFramebufferObject,
        size: tuple[int, int],
        rows: tuple[int, int],
        *,
        near: float,
        far: float,
        distance: float,
        is_orthographic: bool,
        scale: float,
    ) -> None:
        """Shade rows[0] to rows[1] - 1 of `source`, and draw them into the window's buffer.

        Parameters
        ----------
        window : vtkOpenGLRenderWindow
        source : vtkOpenGLFramebufferObject
        size : tuple of int
            Width and height of the buffer.
        rows : tuple of int
            First row that is drawn, and first row above it that is not.
        near, far, distance : float
            Depth of the near and far planes, and distance of the pivot, metres.
        is_orthographic : bool
            Whether the projection is parallel.
        scale : float
            Device pixels per logical pixel.
        """
        window.MakeCurrent()
        if self._quad is None:
            self._quad = vtkOpenGLQuadHelper(window, VERTEX_SHADER, FRAGMENT_SHADER, "")
        program = window.GetShaderCache().ReadyShaderProgram(VERTEX_SHADER, FRAGMENT_SHADER, "")
        colors = source.GetColorAttachmentAsTextureObject(0)
        depths = source.GetDepthAttachmentAsTextureObject()
        state = window.GetState()
        state.PushFramebufferBindings()
        window.GetRenderFramebuffer().Bind(0x8D40)
        state.vtkglViewport(0, 0, *size)
        state.vtkglEnable(GL_SCISSOR_TEST)
        state.vtkglScissor(0, rows[0], size[0], rows[1] - rows[0])
        state.vtkglDepthFunc(GL_ALWAYS)
        colors.Activate()
        depths.Activate()
        program.SetUniformi("colors", colors.GetTextureUnit())
        program.SetUniformi("depths", depths.GetTextureUnit())
        max_distance = SHADING_RADIUS_PIXELS * scale
        program.SetUniform2f("pixel", [max_distance / size[0], max_distance / size[1]])
        program.SetUniform2f("range", [near, far])
        program.SetUniformi("parallel", int(is_orthographic))
        program.SetUniformf("distance", distance)
        program.SetUniformf("strength", STRENGTH)
        self._quad.Render()
        colors.Deactivate()
        depths.Deactivate()
        state.vtkglDepthFunc(GL_LEQUAL)
        state.vtkglScissor(0, 0, *size)
        state.PopFramebufferBindings()

    def release(self, window: vtkOpenGLRenderWindow) -> None:
        if self._quad is not None:
            self._quad.ReleaseGraphicsResources(window)
            self._quad = None
