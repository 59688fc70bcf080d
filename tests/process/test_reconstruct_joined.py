"""Photos that no tie point joins, and the markers that do."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from tests.messages import by_code, shown_codes
from tests.photogrammetry import photo_set, rock_face
from tests.process.reconstruction_runs import reconstruct
from vomstudio.io.photos.cameras_file import read_cameras
from vomstudio.registration.similarity import fit_similarity

PLACES = np.array([[-2.0, -1.2], [2.0, -1.1], [1.8, 1.2], [-1.9, 1.1], [0.1, 0.2]])


@pytest.fixture(scope="module")
def two_parts(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """(folder of photos, marks): every other photo is a negative, in which no feature of the others
    is found again."""
    folder = photo_set.write_photos(tmp_path_factory.mktemp("joined") / "photos", 12)
    views = photo_set.views(12)
    for number in range(1, 13, 2):
        path = folder / f"photo {number}.jpg"
        with Image.open(path) as image:
            ImageOps.invert(image).save(path, quality=95, exif=image.info["exif"])
    vertices = rock_face.rough_face(9.0, 6.0, 0.03).vertices
    rng = np.random.default_rng(0)
    lines = ["label,photo,x,y"]
    for label, place in zip("ABCDE", PLACES, strict=True):
        point = vertices[np.linalg.norm(vertices[:, [0, 2]] - place, axis=1).argmin()]
        for number, view in enumerate(views, start=1):
            x, y = view.project(point)[0] + rng.normal(0, 0.3, 2)
            if 0 < x < photo_set.SIZE[0] and 0 < y < photo_set.SIZE[1]:
                lines.append(f"{label},photo {number}.jpg,{x:.3f},{y:.3f}")
    marks = folder.parent / "marks.csv"
    marks.write_text("\n".join(lines) + "\n")
    return folder, marks


@pytest.mark.slow
def test_marks_join_the_components_and_another_run_gives_identical_results(
    two_parts: tuple[Path, Path], tmp_path: Path
) -> None:
    photos, marks = two_parts
    out = tmp_path / "out"
    alone = reconstruct(photos, out, "--threads", 1, "--seed", 0)
    assert alone.code == 0, alone.err
    assert alone.json["registered"] == 6
    assert (out / "part2" / "cameras.json").exists()
    end = reconstruct(photos, out, "--threads", 1, "--seed", 0, "--marks", marks)
    assert end.code == 0, end.err
    assert end.json["registered"] == 12
    joined = by_code(end.json["warnings"])["join.by-markers"]
    assert (joined["one"], joined["other"], joined["markers"]) == (6, 6, 5)
    assert not (out / "part2").exists()
    truth = {f"photo {n}.jpg": view.centre for n, view in enumerate(photo_set.views(12), start=1)}
    views = read_cameras(out / "cameras.json").views
    wanted = np.array([truth[view.name] for view in views])
    centres = np.array([view.centre for view in views])
    miss = np.linalg.norm(fit_similarity(centres, wanted)(centres) - wanted, axis=1)
    # The same as photos of this size without a gap between them.
    assert np.median(miss) < 3 * photo_set.GSD
    stage = next((out / "work").glob("joined-*"))
    with np.load(stage / "part0" / "scene.npz") as arrays:
        before = {name: arrays[name] for name in arrays.files}
    assert json.loads((stage / "stage.json").read_text())["parts"] == 1
    shutil.rmtree(stage)
    again = reconstruct(photos, out, "--threads", 1, "--seed", 0, "--marks", marks)
    assert again.code == 0, again.err
    with np.load(stage / "part0" / "scene.npz") as arrays:
        assert all(np.array_equal(arrays[name], before[name]) for name in arrays.files)


@pytest.mark.full
def test_insufficient_control_still_gives_a_local_model(tmp_path: Path) -> None:
    """Marks whose rays do not meet are found after the alignment: the frame is local then."""
    photos = photo_set.write_photos(tmp_path / "photos", 5)
    rng = np.random.default_rng(2)
    wide, tall = photo_set.SIZE
    lines = ["label,photo,x,y"]
    for label in "ABC":
        for number in range(1, 6):
            x, y = rng.uniform(0.1, 0.9, 2) * (wide, tall)
            lines.append(f"{label},photo {number}.jpg,{x:.1f},{y:.1f}")
    # Two labels at one place are told before the work, beside what follows from it.
    lines.append(f"D,photo 1.jpg,{0.5 * wide:.1f},{0.5 * tall:.1f}")
    lines.append(f"E,photo 1.jpg,{0.5 * wide + 1:.1f},{0.5 * tall:.1f}")
    (tmp_path / "marks.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "control.csv").write_text("label,x,y,z\nA,0,0,0\nB,5,0,0\nC,0,1,4\n")
    out = tmp_path / "out"
    end = reconstruct(
        photos, out, "--gcp", tmp_path / "control.csv", "--marks", tmp_path / "marks.csv"
    )
    assert end.code == 0, end.err
    assert end.json["frame"] == "local"
    assert end.json["scaled"] is False
    assert [f["code"] for f in end.json["survey"]["findings"]].count("control-unused") == 1
    assert "Traceback" not in end.err
    log = (out / "log.txt").read_text("utf-8")
    before = log[: log.index("Registering the model")]
    assert "control.same-spot" in shown_codes(before)
    assert len(read_cameras(out / "cameras.json").views) >= 3
    assert (out / "sparse.ply").stat().st_size > 1000
