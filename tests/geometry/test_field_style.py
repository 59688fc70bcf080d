"""What a project keeps of the colours of a field."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import ELEVATION, PALETTES, FieldStyle, field_names
from vomstudio.geometry.mesh import Mesh

STYLE = FieldStyle("intensity", -1.5, 7.0, (5.0, 90.0), "magma")


@pytest.mark.parametrize("style", [STYLE, FieldStyle("a"), FieldStyle("b", low=0.0)])
def test_style_round_trips_through_json(style: FieldStyle) -> None:
    assert FieldStyle.from_dict(json.loads(json.dumps(style.to_dict()))) == style


def test_style_without_range_uses_2_to_98_percentiles_and_default_palette() -> None:
    plain = FieldStyle("intensity")
    assert (plain.low, plain.high, plain.palette) == (None, None, None)
    assert plain.percentiles == (2.0, 98.0)


@pytest.mark.parametrize("palette", [name for names in PALETTES.values() for name in names])
def test_every_palette_that_is_offered_can_be_kept_and_drawn(palette: str) -> None:
    import matplotlib

    assert FieldStyle.from_dict(STYLE.to_dict() | {"palette": palette}).palette == palette
    assert palette in matplotlib.colormaps


def without(key: str) -> dict[str, Any]:
    return {k: v for k, v in STYLE.to_dict().items() if k != key}


@pytest.mark.parametrize(
    "values",
    [
        None,
        3,
        *(without(key) for key in STYLE.to_dict()),
        STYLE.to_dict() | {"palette": "rainbow of my own"},
        STYLE.to_dict() | {"low": "deep"},
        STYLE.to_dict() | {"high": [1.0]},
        STYLE.to_dict() | {"percentiles": 5.0},
        STYLE.to_dict() | {"percentiles": (1.0,)},
        STYLE.to_dict() | {"percentiles": (1.0, 2.0, 3.0)},
    ],
)
def test_invalid_style_raises_value_error(values: object) -> None:
    """Whoever reads a project catches ValueError alone."""
    with pytest.raises(ValueError, match="style"):
        FieldStyle.from_dict(values)


def test_scalar_fields_can_be_shown() -> None:
    fields = {
        "intensity": np.arange(5, dtype=np.uint16),
        "curvature": np.linspace(0, 1, 5),
        "ground": np.zeros(5, bool),
        "level": np.arange(-2, 3),
        "name": np.array(list("abcde")),
        "directions": np.zeros((5, 3)),
        "short": np.zeros(4),
    }
    points = np.random.default_rng(0).normal(size=(5, 3))
    wanted = (ELEVATION, "intensity", "curvature", "ground", "level")
    assert field_names(PointCloud(points, fields=fields)) == wanted
    # Of a mesh the vertices count, not the faces.
    faces = np.zeros((4, 3), np.int32)
    assert field_names(Mesh(points, faces, fields=fields)) == wanted
    assert field_names(PointCloud(points)) == (ELEVATION,)
