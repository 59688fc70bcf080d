"""North stays readable where slip reaches the rim."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vomstudio.geology.stereonet import unproject
from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.figure import draw_stereonet
from vomstudio.products.net.net_axes import add_net
from vomstudio.products.net.slip_arrows import draw_slip_arrows
from vomstudio.products.net.style import NetStyle


def plain(figure: Figure):
    return add_net(figure, (0.1, 0.1, 0.8, 0.8), NetStyle())


def of_the_dock(figure: Figure):
    return draw_stereonet(figure, NetContents(()), NetStyle()).axes


@pytest.mark.parametrize("drawn", [plain, of_the_dock])
def test_rim_arrow_does_not_cover_the_north_letter(drawn) -> None:
    figure = Figure(figsize=(3.0, 3.2), dpi=200)
    canvas = FigureCanvasAgg(figure)
    axes = drawn(figure)
    canvas.draw()
    (north,) = [text for text in axes.texts if text.get_text() == "N"]
    box = north.get_window_extent()
    height = figure.bbox.height

    def ink() -> np.ndarray:
        canvas.draw()
        pixels = np.asarray(canvas.buffer_rgba())[..., :3].max(axis=-1)
        rows = slice(int(height - box.y1), int(height - box.y0))
        return pixels[rows, int(box.x0) : int(box.x1)] < 60

    before = ink()
    assert before.sum() > 30
    # Hanging walls that move north at striations of the north, nearly level.
    east = np.linspace(-0.06, 0.06, 7)
    at = unproject(np.stack([east, np.full(7, 0.99)], axis=1))
    slip = np.tile([0.0, 1.0, -0.02], (7, 1))
    draw_slip_arrows(axes, at, slip, color="#ffee88", width_pt=1.2, zorder=5)
    assert ink()[before].all()
