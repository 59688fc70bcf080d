"""The program's icon as Qt draws it, whose SVG has no clipping; those of the actions."""

from __future__ import annotations

import numpy as np
import pytest
import qtawesome
from PySide6.QtCore import QSize
from PySide6.QtGui import QIcon, QImage, QPalette
from PySide6.QtWidgets import QApplication

from tests.tiers import first_in_default_tier
from vomstudio.core.paths import resource
from vomstudio.ui.base import theme


@pytest.mark.parametrize("side", first_in_default_tier([24, 48, 128], 1))
def test_icon_is_a_net_on_a_transparent_background(qtbot, side: int) -> None:
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


NAMES = ("eye-outline", "undo", "camera", "vector-polyline", "magnify-plus-outline")


@pytest.mark.parametrize("side", [16, 24, 37, 64])
def test_action_icons_match_qtawesome(qtbot, side: int) -> None:
    color = QApplication.palette().color(QPalette.ColorRole.ButtonText)
    size = QSize(side, side)
    for name in NAMES:
        ours = theme.icon(name).pixmap(size, 1.0).toImage()
        theirs = qtawesome.icon(f"mdi6.{name}", color=color).pixmap(size).toImage()
        assert ours.size() == size
        assert ours == theirs.convertToFormat(ours.format()), name
        assert any(ours.pixelColor(x, y).alpha() for x in range(side) for y in range(side)), name
