"""Lines of features, as they are handed to VTK."""

from __future__ import annotations

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkRenderer

from vomstudio.rendering.scene import feature_layer
from vomstudio.rendering.scene.feature_layer import FeatureLayer
from vomstudio.rendering.view.drawing import FeatureDrawing


def _line(name: str, x: float) -> FeatureDrawing:
    line = np.array([[x, 0.0, 0.0], [x, 1.0, 0.0]])
    return FeatureDrawing(name, line, None, (1.0, 0.0, 0.0), name, line[0])


@pytest.mark.full
def test_selected_lines_keep_the_drawing_order_of_features() -> None:
    """Pictures of one selection are the same on every day: ids are random."""
    layer = FeatureLayer()
    layer.attach(vtkRenderer(), vtkRenderer())
    layer.change({f"f{i:03d}": _line(f"f{i:03d}", float(i)) for i in range(50)})
    layer.select(frozenset(f"f{i:03d}" for i in range(0, 50, 2)))
    layer.refresh()
    for name, step in (("line", 1), ("line+", 2)):
        data = layer._actors[name].GetMapper().GetInput()
        x = vtk_to_numpy(data.GetPoints().GetData())[:, 0]
        assert x.tolist() == np.repeat(np.arange(0.0, 50.0, step), 2).tolist()


def test_halos_of_many_selected_lines_are_omitted_while_the_camera_moves(monkeypatch) -> None:
    monkeypatch.setattr(feature_layer, "MIN_THIN_POINTS", 10)
    layer = FeatureLayer()
    layer.attach(vtkRenderer(), vtkRenderer())
    names = [f"f{i:03d}" for i in range(10)]
    layer.change({name: _line(name, float(i)) for i, name in enumerate(names)})
    for is_moving, count, has_halo in ((True, 2, True), (True, 8, False), (False, 8, True)):
        layer.is_thin = is_moving
        layer.select(frozenset(names[:count]))
        layer.refresh()
        assert bool(layer._actors["halo+"].GetVisibility()) == has_halo
        assert layer._actors["line+"].GetVisibility()


def test_lines_are_simplified_while_the_camera_moves_and_complete_at_rest(monkeypatch) -> None:
    monkeypatch.setattr(feature_layer, "MIN_THIN_POINTS", 10)
    layer = FeatureLayer()
    layer.attach(vtkRenderer(), vtkRenderer())
    line = np.stack([np.linspace(0.0, 10.0, 101), np.zeros(101), np.zeros(101)], axis=1)
    layer.change({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "f", line[0])})
    layer.select(frozenset(["f"]))

    def vertices(name: str) -> np.ndarray:
        return vtk_to_numpy(layer._actors[name].GetMapper().GetInput().GetPoints().GetData())

    for pixel, is_moving in ((0.1, True), (0.01, True), (0.1, False)):
        layer.begin_moving(lambda points, pixel=pixel: np.full(len(points), pixel))
        layer.is_thin = is_moving
        layer.refresh()
        gap = feature_layer.MOVING_VERTEX_PIXELS * pixel if is_moving else 0.0
        for name in ("line", "line+"):
            x = vertices(name)[:, 0]
            assert (x[0], x[-1]) == (0.0, 10.0)
            assert np.diff(x).max() < gap + 0.11
            assert len(x) <= (10.0 / gap + 3 if is_moving else 101)
    assert len(vertices("line")) == 101
