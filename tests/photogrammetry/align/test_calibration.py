"""What is believed of lenses that EXIF does not tell, or tells wrongly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.messages import with_code
from tests.photogrammetry.made_photos import LENS, Finder, Made, abreast, around, face, make
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.align.alignment import Alignment, AlignmentOptions, align
from vomstudio.photogrammetry.align.scene_check import check_scene
from vomstudio.registration.similarity import fit_similarity


def aligned(made: Made, work: Path) -> Alignment:
    return align(made.photos, work, AlignmentOptions(threads=1), Finder([made]), SilentProgress())


def worst_centre(alignment: Alignment, made: Made) -> float:
    truth = {view.name: view.centre for view in made.views}
    scene = alignment.parts[0]
    wanted = np.array([truth[view.name] for view in scene.views])
    fit = fit_similarity(scene.centres, wanted)
    return float(np.linalg.norm(fit(scene.centres) - wanted, axis=1).max())


def bow(alignment: Alignment, made: Made) -> float:
    """Metres by which the middle of the face stands off a plane through its ends."""
    truth = {view.name: view.centre for view in made.views}
    scene = alignment.parts[0]
    wanted = np.array([truth[view.name] for view in scene.views])
    fit = fit_similarity(scene.centres, wanted)
    points = fit(scene.points)
    columns = np.column_stack([np.ones(len(points)), points[:, 0], points[:, 2], points[:, 0] ** 2])
    bent = np.linalg.lstsq(columns, points[:, 1], rcond=None)[0][3]
    return float(abs(bent) * np.ptp(points[:, 0]) ** 2 / 4)


@pytest.mark.full
@pytest.mark.parametrize("focal", first_in_default_tier([1200.0, 1875.0], 1))
def test_five_photos_contradict_a_focal_length_with_25_percent_error(
    tmp_path: Path, focal: float
) -> None:
    made = make(tmp_path / "photos", around(5), face(), focal_px=focal)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    assert alignment.registered_photo_count == 5
    assert camera.focal == "freed"
    assert abs(camera.values[0] - 1500) < 3 * camera.sigma[0] < 30
    assert with_code(camera.reasons, "lens.exif-contradicted")
    assert worst_centre(alignment, made) < 0.05
    told = finding(alignment, "focal-wrong")
    assert told is not None
    assert told.values["value"] == pytest.approx(focal / 1500 - 1, abs=0.02)
    assert len(told.values["photos"]) == 5


def test_correct_focal_length_is_not_contradicted(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(5), face(), focal_px=1485.0)
    camera = aligned(made, tmp_path / "work").cameras[0]
    assert camera.focal == "held"
    assert camera.values[0] == 1485.0


@pytest.mark.full
def test_lens_with_more_than_k1_does_not_bow_a_parallel_block(tmp_path: Path) -> None:
    lens = Intrinsics("RADIAL", 1600, 1200, (1500, 800, 600, 0.03, -0.12))
    made = make(tmp_path / "photos", abreast(10, lens), face(1800, relief=0.3), noise_px=0.2)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    assert camera.focal == "held"
    assert camera.model == "RADIAL"
    assert camera.values[4] == pytest.approx(-0.12, abs=0.04)
    # Without k2 it is 25 cm.
    assert bow(alignment, made) < 0.03


@pytest.mark.full
def test_undetermined_focal_length_defaults_to_a_typical_lens(
    tmp_path: Path,
) -> None:
    made = make(tmp_path / "photos", abreast(6), face(relief=0.0), focal_px=None)
    alignment = aligned(made, tmp_path / "work")
    camera = alignment.cameras[0]
    assert camera.focal == "held"
    told = finding(alignment, "focal-vague")
    assert told is not None
    assert told.severity == "warning"
    assert camera.values[0] == pytest.approx(30 / 36 * 1600, rel=0.01)
    assert with_code(camera.reasons, "lens.focal-assumed")


def finding(alignment: Alignment, code: str) -> Finding | None:
    report = check_scene(alignment.parts[0], cameras=alignment.cameras)
    return next((f for f in report.findings if f.code == code), None)


@pytest.mark.full
def test_lenses_are_distinguished_without_exif(tmp_path: Path) -> None:
    other = replace(LENS, params=(2300.0, 800.0, 600.0, 0.0))
    views = [replace(v, intrinsics=other) if i % 2 else v for i, v in enumerate(around(10))]
    made = make(tmp_path / "photos", views, face(), focal_px=None)
    alignment = aligned(made, tmp_path / "work")
    found = sorted((round(c.values[0], -1), len(c.photos)) for c in alignment.cameras)
    assert found == [(1500, 5), (2300, 5)]
    assert worst_centre(alignment, made) < 0.05
    (finding,) = with_code(alignment.notes, "lens.several-lenses")
    assert finding.values["lenses"] == 2
    assert not (tmp_path / "work" / "lenses").exists()


@pytest.mark.full
def test_single_lens_is_not_split_into_several(tmp_path: Path) -> None:
    made = make(tmp_path / "photos", around(8), face(), focal_px=None)
    alignment = aligned(made, tmp_path / "work")
    assert len(alignment.cameras) == 1
    assert alignment.cameras[0].values[0] == pytest.approx(1500, rel=0.01)
    assert finding(alignment, "focal-vague") is None
