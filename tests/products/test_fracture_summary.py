"""Fracture summaries name every parameter of a length distribution."""

import numpy as np
import pytest

from tests.messages import figures
from tests.ui.test_fracture_answer import WALL, answered
from vomstudio.geology.fractures.length_laws import candidate_laws
from vomstudio.products.fractures.summary import PARAMETER_TEXTS, figure_rows
from vomstudio.ui.panels.fractures.analysis import SCANLINE


def test_every_parameter_of_a_law_has_a_text():
    laws = candidate_laws(np.linspace(1.0, 5.0, 20), np.zeros(20, int))
    names = {name for law in laws for name in (*law.parameters, *law.constants)}
    assert names == set(PARAMETER_TEXTS)


def test_intensity_and_spacing_along_a_scanline_have_confidence_intervals():
    low = np.concatenate(answered(WALL).lines).min(axis=0)
    ends = [*(low + [3.0, 0.5]), *(low + [3.5, 3.6])]
    network = answered(WALL, SCANLINE, tuple(map(float, ends))).network
    assert network is not None
    statistics = network.statistics.to_dict()
    line, texts = statistics["scanline"], dict(figure_rows(network.statistics))
    for row, values in (
        ("P10", [statistics["P10_1_per_m"], *statistics["P10_95_1_per_m"]]),
        (
            "  spacing",
            [line["mean_m"], *line["mean_95_m"], line["true_mean_m"], *line["true_mean_95_m"]],
        ),
    ):
        shown = figures(texts[row])
        for value in values:
            assert any(figure == pytest.approx(value, rel=0.005) for figure in shown), (row, value)
