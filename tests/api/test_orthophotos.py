"""Orthophotos in memory against the files of the command and the model itself."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from PIL import Image

import vomstudio as vs
from tests.messages import refused
from vomstudio.cli.common.output import to_json

MODEL = vs.sample("sample.obj")


def test_image_matches_command_output(command: Any, cliff: vs.Mesh, tmp_path: Path) -> None:
    target = tmp_path / "told.tif"
    told = command("ortho", MODEL, "--plane", "200/85", "--gsd", 0.1, "-o", target)
    made = vs.orthophoto(cliff, plane=(200, 85), gsd_m=0.1)
    figures = json.loads(to_json(made.to_dict()))
    assert figures == {name: told[name] for name in figures}
    with rasterio.open(target) as picture, rasterio.open(told["depth"]) as depth:
        assert (np.moveaxis(picture.read(), 0, -1) == made.image).all()
        np.testing.assert_array_equal(depth.read(1), made.depth)


def test_saving_writes_the_files_of_the_command(
    command: Any, cliff: vs.Mesh, tmp_path: Path
) -> None:
    told = command(
        "ortho", MODEL, "--trend", 0, "--plunge", 90, "--gsd", 0.2, "-o", tmp_path / "told.tif"
    )
    made = vs.orthophoto(cliff, trend_deg=0, plunge_deg=90, gsd_m=0.2)
    (tmp_path / "own").mkdir()
    files = made.save(tmp_path / "own" / "told.tif")
    assert [file.name for file in files] == ["told.tif", "told_depth.tif", "told.json", "told.tfw"]
    for file in files:
        other = tmp_path / file.name
        if file.suffix == ".tif":
            with rasterio.open(file) as ours, rasterio.open(other) as theirs:
                assert str(ours.profile) == str(theirs.profile)
                np.testing.assert_array_equal(ours.read(), theirs.read())
        else:
            assert file.read_text() == other.read_text()
    assert told["coverage"] == made.coverage
    with pytest.raises(vs.errors.TargetError):
        made.save(files[0])
    with pytest.raises(vs.errors.UsageError, match=r"\.tif"):
        made.save(tmp_path / "picture.png")


def test_pixels_map_onto_model_surface(cliff: vs.Mesh) -> None:
    """The World point of a pixel is on a face: no farther from a vertex than an edge is long."""
    made = vs.orthophoto(cliff, trend_deg=20, plunge_deg=-10, gsd_m=0.2)
    rows, columns = np.nonzero(np.isfinite(made.depth))
    chosen = slice(None, None, 97)
    rows, columns = rows[chosen], columns[chosen]
    pixels = np.stack([columns + 0.5, rows + 0.5, made.depth[rows, columns], np.ones(len(rows))])
    places = (made.pixel_to_world @ pixels)[:3].T
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(cliff.points - cliff.bounds[0]).query(places - cliff.bounds[0])
    corners = cliff.points[cliff.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    assert distance.max() < longest
    assert made.coverage == np.isfinite(made.depth).mean()
    assert (made.image[..., 3] > 0).sum() == np.isfinite(made.depth).sum()


def test_a_fold_gives_the_view_along_its_axis(picks: Any) -> None:
    beds = vs.fit_planes(picks[picks["kind"] == "bedding"], by="pick")
    found = vs.fold(beds)
    for fold in (beds, found):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            made = vs.orthophoto(MODEL, fold=fold, gsd_m=0.5)
        assert [str(w.message) for w in said] == list(made.warnings[: len(said)])
        assert made.fold is not None
        assert made.fold.cost not in made.warnings, "it is negligible"
        assert made.plunge_deg == pytest.approx(found.beta.plunge_deg)
        assert made.sense == "down-plunge"
        assert made.fold.beta == found.beta


def test_planes_are_accepted_as_fit_or_text(cliff: vs.Mesh, picks: Any) -> None:
    plane = vs.fit_plane(picks[picks["pick"] == "B01"])
    by_fit = vs.orthophoto(cliff, plane=plane, gsd_m=1.0)
    text = f"{plane.dip_direction_deg}/{plane.dip_deg}"
    assert vs.orthophoto(cliff, plane=text, gsd_m=1.0).to_dict() == by_fit.to_dict()
    # Against the upward normal.
    assert by_fit.direction == pytest.approx(-plane.normal, abs=1e-9)
    flipped = vs.orthophoto(cliff, plane=plane, gsd_m=1.0, flip=True)
    assert flipped.direction == pytest.approx(plane.normal, abs=1e-9)


def test_progress_is_reported_and_can_cancel(cliff: vs.Mesh) -> None:
    told: list[tuple[str, int, int | None]] = []
    vs.orthophoto(cliff, trend_deg=0, plunge_deg=90, gsd_m=1, progress=lambda *a: told.append(a))
    assert ("Casting rays", 1, 1) in told

    def stop(stage: str, done: int, total: int | None) -> None:
        raise vs.errors.Cancelled()

    with pytest.raises(vs.errors.Cancelled):
        vs.orthophoto(cliff, trend_deg=0, plunge_deg=90, gsd_m=1, progress=stop)


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        ({}, "option.none-given", "trend_deg"),
        ({"trend_deg": 5}, "option.requires", "trend_deg"),
        ({"trend_deg": 5, "plunge_deg": 5, "plane": "3/4"}, "option.conflict", "plane"),
        ({"trend_deg": 5, "plunge_deg": 95}, "option.out-of-range", "plunge_deg"),
        ({"trend_deg": 5, "plunge_deg": 5, "gsd_m": 0}, "option.not-a-length", "gsd_m"),
    ],
)
def test_errors_name_python_arguments(cliff: vs.Mesh, words: Any, code: str, field: str) -> None:
    with pytest.raises(vs.errors.UsageError) as error:
        vs.orthophoto(cliff, **words)
    assert (error.value.code, error.value.field) == (code, field)
    assert "--" not in error.value.message


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        ({"trend_deg": "north", "plunge_deg": 5}, "array.not-numbers", "trend_deg"),
        ({"trend_deg": [1, 2], "plunge_deg": 5}, "argument.wrong-type", "trend_deg"),
        ({"plane": (1, 2, 3)}, "argument.wrong-type", "plane"),
        ({"trend_deg": 5, "plunge_deg": 5, "progress": 7}, "argument.wrong-type", "progress"),
    ],
)
def test_arguments_of_wrong_type_are_refused(
    cliff: vs.Mesh, words: Any, code: str, field: str
) -> None:
    with refused(code, field=field):
        vs.orthophoto(cliff, **words)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ({"plane": "steep"}, "notation.unknown-word"),
        ({"trend_deg": 5, "plunge_deg": 5, "gsd_m": 1e-6}, "gsd.too-many-pixels"),
    ],
)
def test_unusable_plane_or_pixel_size_is_refused(cliff: vs.Mesh, words: Any, code: str) -> None:
    with refused(code):
        vs.orthophoto(cliff, **words)


def test_orthophoto_has_repr(cliff: vs.Mesh) -> None:
    made = vs.orthophoto(cliff, trend_deg=0, plunge_deg=90, gsd_m=1)
    assert "of 1 m" in repr(made)
    assert "EPSG:32633" in made._repr_html_()


def test_undrawn_texture_is_a_python_warning(tmp_path: Path) -> None:
    Image.new("RGB", (8, 8), (90, 80, 70)).save(tmp_path / "rock.png")
    (tmp_path / "wall.mtl").write_text("newmtl rock\nmap_Kd rock.png\n")
    (tmp_path / "wall.obj").write_text(
        "mtllib wall.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl rock\nf 1/1 2/2 3/3 4/4\n"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vs.errors.VomWarning)
        model = vs.read(tmp_path / "wall.obj")
    (tmp_path / "rock.png").write_bytes(b"damaged after it was read")
    with pytest.warns(vs.errors.VomWarning) as caught:
        picture = vs.orthophoto(model, trend_deg=0, plunge_deg=90, gsd_m=0.1)
    codes = {w.message.code for w in caught if isinstance(w.message, vs.errors.VomWarning)}
    stated = {finding.code for finding in picture.warnings if finding.severity == "warning"}
    assert "texture.not-drawn" in stated
    assert stated <= codes
