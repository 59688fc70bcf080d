"""The program's icon as Qt draws it, whose SVG has no clipping."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QIcon, QImage

from vomstudio.paths import resource


@pytest.mark.parametrize("side", [24, 48, 128])
def test_the_icon_is_a_net_with_nothing_outside(qtbot, side: int) -> None:
    image = QIcon(str(resource("icon", "vomstudio.svg"))).pixmap(side, side).toImage()
    image = image.convertToFormat(QImage.Format.Format_RGBA8888)
    wide = image.width()
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(wide, -1)[:, : 4 * wide]
    alpha = pixels.reshape(wide, wide, 4)[..., 3]
    y, x = (np.indices((wide, wide)) + 0.5) * 128 / wide
    away = np.hypot(x - 64, y - 64)
    # A pixel on an edge is a part of both.
    edge = 1.5 * 128 / wide
    north = (np.abs(x - 64) < 3 + edge) & (y < 12)
    assert not alpha[(away > 57 + edge) & ~north].any()
    assert (alpha[away < 57 - edge] == 255).all()
