"""The matrix of a registration is an array that can be used as it is."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

import vomstudio as vs

MODEL = np.array([[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7], [5, 6, 0.5]])
WORLD = 2.0 * MODEL[:, [1, 0, 2]] * [-1, 1, 1] + [398_000.0, 4_980_000.0, 20.0]


@pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
def test_matrix_is_float64_array_from_model_to_world() -> None:
    found = vs.register(MODEL, WORLD)
    assert isinstance(found.matrix, np.ndarray)
    assert found.matrix.dtype == np.float64
    assert found.matrix.shape == (4, 4)
    there = (found.matrix @ np.column_stack([MODEL, np.ones(5)]).T).T[:, :3]
    assert there == pytest.approx(WORLD, abs=1e-6)
    assert found.matrix[:3, :3] @ found.matrix[:3, :3].T == pytest.approx(4.0 * np.eye(3))
    told = json.loads(json.dumps(found.to_dict()))
    assert np.array(told["matrix"]) == pytest.approx(found.matrix)
    again = pickle.loads(pickle.dumps(found))
    assert again.matrix == pytest.approx(found.matrix)
    assert "matrix" in repr(found)
