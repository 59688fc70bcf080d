"""An azimuth of 359.97 must not be written 360.0, which is no azimuth."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import vomstudio
import vomstudio as vs
from vomstudio.geology.notation import format_plain_azimuth

BY_ITSELF = re.compile(r"""\{[^{}]*(dip_direction|trend|strike)[a-z_0-9"'\]]*:[0-9,]*\.[0-9]f\}""")


def test_azimuths_are_formatted_by_azimuth_functions_only() -> None:
    folder = Path(vomstudio.__file__).parent
    found = [
        f"{path.relative_to(folder)}: {match[0]}"
        for path in folder.rglob("*.py")
        for match in BY_ITSELF.finditer(path.read_text(encoding="utf-8"))
    ]
    assert found == [], "use format_azimuth or plain_azimuth of vomstudio/geology/notation.py"


def test_azimuth_rounding_to_360_is_written_as_0() -> None:
    assert format_plain_azimuth(359.99996) == "0.0000"
    assert format_plain_azimuth(359.99994) == "359.9999"
    assert format_plain_azimuth(7.004, 2) == "7.00"


def test_plane_dipping_north_is_not_shown_as_360() -> None:
    x, y = (v.ravel() for v in np.meshgrid(np.arange(5.0), np.arange(5.0)))
    fit = vs.fit_plane(np.column_stack([x, y, -0.5 * y + 1e-4 * x]))
    assert 359.95 < fit.dip_direction_deg < 360.0
    assert "(36" not in repr(fit)
