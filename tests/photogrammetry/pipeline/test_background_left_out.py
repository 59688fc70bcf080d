"""A model from photos of a rock face with a building behind it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.photogrammetry.align.surveys import Survey
from tests.photogrammetry.building_scene import DISTANCE, FOCAL, building_scene, views
from vomstudio.cli import main
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.cameras_file import read_cameras
from vomstudio.registration.similarity import fit_similarity

pytestmark = pytest.mark.slow


def shares(out: Path, survey: Survey) -> tuple[float, float]:
    """Shares of the faces that are on the rock, and of the vertices far from all true surfaces.

    The latter are fragments that wrong depths leave in the air.
    """
    cameras = read_cameras(out / "cameras.json")
    truth = {view.name: view.centre for view in survey.views}
    made = np.array([view.centre for view in cameras.views]) + cameras.origin
    fit = fit_similarity(made, np.array([truth[view.name] for view in cameras.views]))
    mesh = read_model(out / "model.ply").data
    vertices = fit(mesh.vertices)
    far = survey.face.distance(vertices) > 20 * DISTANCE / survey.views[0].intrinsics.focal[0]
    return float(np.mean(vertices[mesh.faces].mean(axis=1)[:, 1] < 2.5)), float(np.mean(far))


def test_model_contains_only_the_rock_unless_the_background_is_kept(tmp_path: Path, capsys) -> None:
    photos = views(4, 720)
    face = building_scene(6.0, ground=False)
    survey = Survey("background", face, tuple(photos), (36 * FOCAL / 1296,) * len(photos))
    folder, out = survey.write(tmp_path / "photos"), tmp_path / "model"

    def reconstruct(*words: str) -> tuple[dict, set[str]]:
        command = ["reconstruct", str(folder), "-o", str(out), "--quality", "preview", "--json"]
        code = main([*command, *words])
        answer = json.loads(capsys.readouterr().out)
        assert code == 0, answer
        return answer, {finding["code"] for finding in answer["warnings"]}

    answer, codes = reconstruct()
    assert "background.left-out" in codes
    assert 0.1 < answer["background_share"] < 0.9
    on_rock, in_air = shares(out, survey)
    assert on_rock > 0.999
    assert in_air < 0.01
    kept, codes = reconstruct("--keep-background")
    assert "background.kept" in codes
    assert kept["background_share"] == answer["background_share"]
    assert shares(out, survey)[0] < 0.95
    box = ",".join(f"{value:.12g}" for value in answer["proposed_region"])
    region, codes = reconstruct("--region", box)
    assert region["background_share"] is None
    assert not codes & {"background.left-out", "background.kept"}
    assert shares(out, survey)[0] > 0.999
