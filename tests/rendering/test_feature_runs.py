"""The arrays that are kept in blocks are those of all features in their order."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vomstudio.rendering.scene.feature_runs import FeatureRuns
from vomstudio.rendering.view.drawing import FeatureDrawing

KEYS = st.integers(0, 299).map(str)
CHANGES = st.lists(
    st.dictionaries(KEYS, st.tuples(st.sampled_from("drhn"), st.integers(0, 9)), max_size=150),
    min_size=1,
    max_size=4,
)


def drawing(key: str, what: str, seed: int) -> FeatureDrawing | None:
    """d: line and disc, r: a point and a disc, h: hidden, n: gone."""
    if what == "n":
        return None
    rng = np.random.default_rng(seed + 1000 * int(key))
    line = rng.normal(5e6, 10.0, (1 if what == "r" else 2 + seed, 3))
    ring = rng.normal(5e6, 10.0, (5, 3))
    return FeatureDrawing(key, line, ring, (seed / 9.0, 0.5, 0.1), "", line[0], what != "h")


@pytest.mark.full
@settings(max_examples=25)
@given(CHANGES)
def test_block_arrays_equal_the_concatenated_features(changes):
    origin = np.array([5e6, 5e6, 5e6])
    runs, kept = FeatureRuns(), {}
    first = {str(i): drawing(str(i), "d", i % 10) for i in range(290)}
    runs.set_origin(np.zeros(3))
    for change in ({}, *changes):
        made = {key: drawing(key, *how) for key, how in change.items()} if change else first
        runs.change(made)
        runs.set_origin(origin)
        for key, each in made.items():
            kept.pop(key, None) if each is None else kept.update({key: each})
        shown = [d for d in kept.values() if d.visible]
        for found, parts in (
            (runs.lines(), [(d.line, d.color) for d in shown if len(d.line) > 1]),
            (runs.discs(), [(d.disc, d.color) for d in shown]),
        ):
            points = np.concatenate([np.zeros((0, 3)), *(p for p, _ in parts)]) - origin
            np.testing.assert_array_equal(found.points, points.astype(np.float32))
            assert found.sizes.tolist() == [len(p) for p, _ in parts]
            reds = np.repeat([round(255 * c[0]) for _, c in parts], [len(p) for p, _ in parts])
            np.testing.assert_array_equal(found.colors[:, 0], reds.astype(np.uint8))
        spots = np.concatenate([np.zeros((0, 3)), *(np.vstack([d.line, d.disc]) for d in shown)])
        box = runs.box()
        assert len(box) == (2 if shown else 0)
        if shown:
            np.testing.assert_array_equal(box, [spots.min(axis=0), spots.max(axis=0)])
