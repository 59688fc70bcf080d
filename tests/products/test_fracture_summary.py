"""Fracture summaries name every parameter of a length distribution."""

import numpy as np

from vomstudio.geology.fractures.length_laws import candidate_laws
from vomstudio.products.fractures.summary import PARAMETER_TEXTS


def test_every_parameter_of_a_law_has_a_text():
    laws = candidate_laws(np.linspace(1.0, 5.0, 20), np.zeros(20, int))
    names = {name for law in laws for name in (*law.parameters, *law.constants)}
    assert names == set(PARAMETER_TEXTS)
