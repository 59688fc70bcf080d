"""Coplanarity by collinearity, against point clouds of known eigenvalues."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.tiers import first_in_default_tier
from vomstudio.products.net.shape_figure import draw_shapes, write_shapes
from vomstudio.project.tables.fitted_planes import fitted_planes


def cloud(l1: float, l2: float, l3: float) -> np.ndarray:
    """(8, 3) corners of a box, whose covariance has these eigenvalues."""
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], float)
    return signs * np.sqrt([l1, l2, l3])


def rows_of(*clouds: np.ndarray) -> list:
    points = np.concatenate(clouds)
    offsets = np.concatenate([[0], np.cumsum([len(c) for c in clouds])])
    return fitted_planes([f"p{i}" for i in range(len(clouds))], points, offsets).rows


def test_symbols_are_at_the_textbook_indices() -> None:
    """l1 = 0.6, l2 = 0.39, l3 = 0.01: coplanarity 1 / 0.01, collinearity 0.6 / 0.39."""
    axes = Figure().add_subplot()
    assert draw_shapes(axes, rows_of(cloud(0.6, 0.39, 0.01), cloud(0.9, 0.08, 0.02))) == 2
    result = sorted(
        (float(x), float(y))
        for line in axes.lines
        if line.get_linestyle() == "None"
        for x, y in zip(*line.get_data(), strict=True)
    )
    assert result == [pytest.approx((0.6 / 0.39, 100.0)), pytest.approx((0.9 / 0.08, 50.0))]


def test_collinearity_never_exceeds_coplanarity_minus_two() -> None:
    rng = np.random.default_rng(1)
    rows = rows_of(*(rng.normal(size=(12, 3)) * rng.uniform(0.01, 1, 3) for _ in range(200)))
    assert all(row["collinearity"] <= row["coplanarity"] - 2.0 + 1e-9 for row in rows)


@pytest.mark.parametrize("format_", first_in_default_tier(["svg", "pdf", "png"]))
def test_the_figure_is_written(tmp_path: Path, format_: str) -> None:
    path = tmp_path / f"shapes.{format_}"
    assert write_shapes(path, rows_of(cloud(0.6, 0.39, 0.01)), format=format_) == 1
    assert path.stat().st_size > 1000
    assert write_shapes(path, [], format=format_) == 0


def test_names_overlap_neither_each_other_nor_symbols() -> None:
    """Forty planes of nearly one shape, with long names; one far from them keeps its own."""
    rng = np.random.default_rng(5)
    clouds = [cloud(0.9, 0.08 * s, 0.02) for s in rng.uniform(0.8, 1.2, 40)]
    rows = rows_of(*clouds, cloud(0.6, 0.25, 0.15))
    rows = [dict(row, quality="poor", name=f"a long name of a bed {row['id']}") for row in rows]
    figure = Figure(figsize=(120 / 25.4, 100 / 25.4))
    axes = figure.add_axes((0.13, 0.13, 0.83, 0.80))
    draw_shapes(axes, rows[-25:])
    renderer = FigureCanvasAgg(figure).get_renderer()
    named = [text for text in axes.texts if text.get_text().startswith("a long name")]
    boxes = [text.get_window_extent(renderer) for text in named]
    assert any(text.get_text().endswith("p40") for text in named)
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    places = axes.transData.transform([(r["collinearity"], r["coplanarity"]) for r in rows[-25:]])
    assert not any(box.contains(x, y) for box in boxes for x, y in places)
