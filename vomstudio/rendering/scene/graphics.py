"""OpenGL vendor, renderer and version as reported by the driver."""

from __future__ import annotations

import json
import sys


def versions() -> dict[str, str]:
    """Return the "vendor", "renderer" and "version" of OpenGL in an off-screen window.

    A broken driver may crash the process.
    """
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  makes the window one of OpenGL
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetSize(16, 16)
    window.AddRenderer(vtkRenderer())
    window.Render()
    texts = {}
    for line in window.ReportCapabilities().splitlines():
        for name in ("vendor", "renderer", "version"):
            if line.startswith(f"OpenGL {name} string:"):
                texts[name] = line.partition(":")[2].strip()
    return texts


def main() -> int:
    """Print the OpenGL versions as one line of JSON."""
    sys.stdout.write(json.dumps(versions()) + "\n")
    return 0
