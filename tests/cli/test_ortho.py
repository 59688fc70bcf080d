"""`vomstudio ortho`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import rasterio

from tests.marked import UTM, found_dots, marked_mesh
from tests.messages import codes, error_of, messages, shown_codes

PROMISED = (
    "image",
    "sidecar",
    "depth",
    "width",
    "height",
    "gsd_m",
    "trend_deg",
    "plunge_deg",
    "right",
    "down",
    "sense",
    "coverage",
)


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """An OBJ of the marked surface, with millimetres and a CRS beside it."""
    mesh, _ = marked_mesh(tmp_path)
    assert mesh.uv is not None
    lines = ["mtllib m.mtl", "usemtl dots"]
    lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in mesh.uv]
    lines += ["f " + " ".join(f"{k}/{k}" for k in face) for face in (mesh.faces + 1).tolist()]
    (tmp_path / "m.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "m.mtl").write_text("newmtl dots\nmap_Kd dots.png\n")
    (tmp_path / "m.prj").write_text("EPSG:32615\n")
    return tmp_path / "m.obj"


def files(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir()}


def test_ortho_reports_and_writes_documented_outputs(run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.tif"
    before = files(tmp_path)
    ran = run("ortho", model, "--trend", 40, "--plunge", 35, "-o", out, "--gsd", 0.005, "--json")
    assert ran.code == 0
    found = ran.json
    assert list(found)[:3] == ["image", "sidecar", "depth"]
    assert not set(PROMISED) - set(found)
    assert files(tmp_path) - before == {"o.tif", "o_depth.tif", "o.json", "o.tfw"}
    assert (found["trend_deg"], found["plunge_deg"], found["gsd_m"]) == (40, 35, 0.005)
    assert found["sense"] == "as given"
    facts = json.loads(Path(found["sidecar"]).read_text("utf-8"))
    for key in ("width", "height", "right", "down", "pixel_to_world", "coverage"):
        assert facts[key] == found[key]
    with rasterio.open(found["image"]) as file:
        assert (file.width, file.height, file.count) == (found["width"], found["height"], 4)
        rgba = np.moveaxis(file.read(), 0, 2)
    assert found["coverage"] == pytest.approx((rgba[..., 3] > 0).mean())
    places = marked_mesh(tmp_path)[1]
    expected, measured = found_dots(rgba, np.array(facts["pixel_to_world"]), places, 12)
    assert np.hypot(*(measured - expected).T).mean() < 0.1


def test_map_has_model_crs_and_automatic_pixel_size_is_reported(run, model, tmp_path) -> None:  # type: ignore[no-untyped-def]
    ran = run("ortho", model, "--plane", "0/0", "-o", tmp_path / "map.tif", "--json")
    found = ran.json
    assert found["world_file"] == str(tmp_path / "map.tfw")
    assert found["crs"] == "EPSG:32615"
    assert any("texture" in warning for warning in messages(found))
    assert "gsd.texture" in shown_codes(ran.err)
    with rasterio.open(tmp_path / "map.tif") as file:
        assert file.crs.to_epsg() == 32615
        assert file.bounds.left == pytest.approx(UTM[0] - 2, abs=0.01)


def test_flip_reverses_any_direction(run, model: Path, tmp_path: Path) -> None:
    one = run("ortho", model, "--plane", "120/90", "-o", tmp_path / "a.tif", "--json").json
    assert one["trend_deg"] == pytest.approx(300)
    other = run(
        "ortho", model, "--plane", "120/90", "-o", tmp_path / "b.tif", "--flip", "--json"
    ).json
    assert other["trend_deg"] == pytest.approx(120)
    assert other["right"] == pytest.approx([-v for v in one["right"]])
    assert other["sense"] != one["sense"]


def test_view_follows_fold_axis_and_reports_its_error(run, write, model, tmp_path) -> None:  # type: ignore[no-untyped-def]
    beds = [(90, 20), (90, 40), (270, 30), (270, 50), (88, 30), (272, 45)]
    path = write(
        "kind,dipdir,dip\n" + "".join(f"bedding,{a},{d}\n" for a, d in beds) + "joint,0,85\n"
    )
    fold = run("fold", path, "--json").json
    out = tmp_path / "o.tif"
    found = run("ortho", model, "--fold", path, "-o", out, "--gsd", 0.05, "--json").json
    assert found["fold"]["beta"] == fold["beta"]
    assert found["fold"]["left_out"] == fold["left_out"]
    assert found["fold"]["cost"]["code"] == "view.axis-error"
    assert found["sense"] in ("down-plunge", "up-plunge")
    sign = 1 if found["sense"] == "down-plunge" else -1
    assert found["plunge_deg"] == pytest.approx(sign * fold["beta"]["plunge_deg"], abs=1e-9)
    with rasterio.open(out) as file:
        assert found["sense"] in file.tags()["VOMSTUDIO_SENSE"]


@pytest.mark.parametrize(
    ("words", "code", "field"),
    [
        ([], "option.none-given", "--trend"),
        (["--trend", 1], "option.requires", "--trend"),
        (["--plunge", 1], "option.requires", "--plunge"),
        (["--trend", 1, "--plunge", 91], "option.out-of-range", "--plunge"),
        (["--trend", 1, "--plunge", 2, "--plane", "3/4"], "option.conflict", "--plane"),
        (["--plane", "3/4", "--domain", "A"], "option.requires", "--domain"),
        (["--plane", "steep"], "notation.unknown-word", "--plane"),
        (["--plane", "3/4", "--gsd", "0"], "option.not-a-length", "--gsd"),
        (["--plane", "3/4", "--gsd", "nan"], "option.not-a-length", "--gsd"),
        (["--plane", "3/4", "--gsd", "1e-6"], "gsd.too-many-pixels", "--gsd"),
        (["--plane", "3/4", "--unit", "0"], "option.not-a-choice", "--unit"),
        (["--plane", "3/4", "--unit", "0.3048"], "option.not-a-choice", "--unit"),
        (["--plane", "3/4", "--sheet", "s.doc"], "output.unknown-format", "--sheet"),
        (["--fold", "missing.csv"], "file.missing", None),
    ],
)
def test_invalid_options_are_refused_and_nothing_is_written(
    run, model: Path, tmp_path: Path, words: list[str | int], code: str, field: str | None
) -> None:
    before = files(tmp_path)
    ran = run("ortho", model, "-o", tmp_path / "o.tif", *words, "--json")
    assert ran.code == 2
    error_of(ran.json, code, field=field)
    assert files(tmp_path) == before


def test_missing_model_wrong_extension_and_existing_file_are_refused(
    run, model: Path, tmp_path: Path
) -> None:
    view = ("--plane", "3/4")
    assert "gone.obj" in run("ortho", "gone.obj", *view, "-o", tmp_path / "o.tif").said
    assert ".tif" in run("ortho", model, *view, "-o", tmp_path / "o.png").said
    (tmp_path / "o_depth.tif").write_text("mine")
    ran = run("ortho", model, *view, "-o", tmp_path / "o.tif", "--json")
    assert ran.json["error"]["code"] == "output.exists"
    assert (tmp_path / "o_depth.tif").read_text() == "mine"
    assert not (tmp_path / "o.tif").exists()
    forced = run("ortho", model, *view, "-o", tmp_path / "o.tif", "--gsd", 0.1, "--force")
    assert forced.code == 0


def test_progress_counts_tiles(run, model: Path, tmp_path: Path) -> None:
    ran = run(
        "ortho",
        model,
        "--plane",
        "0/0",
        "-o",
        tmp_path / "o.tif",
        "--gsd",
        0.003,
        "--progress",
        "json",
        "--json",
    )
    events = [json.loads(line) for line in ran.err.splitlines() if line.startswith("{")]
    (stage,) = [e for e in events if e.get("stage") == "Casting rays" and e["event"] == "stage"]
    steps = [e["done"] for e in events if e["event"] == "step" and e["stage"] == "Casting rays"]
    assert steps == list(range(1, stage["total"] + 1))


def test_full_disk_is_reported_and_leaves_no_files(run, model: Path, tmp_path: Path) -> None:
    resource = pytest.importorskip("resource", reason="limits of a process are POSIX's")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = files(tmp_path)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, limits[1]))
        ran = run("ortho", model, "--plane", "20/30", "-o", tmp_path / "o.tif", "--json")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert ran.code == 2
    assert ran.json["error"]["code"] == "disk.full"
    assert files(tmp_path) == before


@pytest.mark.parametrize("scaled", [False, True])
def test_unscaled_model_from_photos_claims_no_north(
    run, model: Path, tmp_path: Path, scaled: bool
) -> None:
    from vomstudio.io.photos.cameras_file import Cameras, write_cameras

    (tmp_path / "m.prj").unlink()
    write_cameras(tmp_path / "cameras.json", Cameras((), Path("photos"), is_scaled=scaled))
    out = tmp_path / "o.tif"
    ran = run("ortho", model, "--trend", 40, "--plunge", 35, "-o", out, "--gsd", 0.05, "--json")
    assert ran.code == 0
    facts = json.loads(Path(ran.json["sidecar"]).read_text("utf-8"))
    assert facts["north"].startswith("not known") != scaled
    assert ("metre" in facts["unit"]) == scaled
    assert ("view.not-placed" in codes(ran.json)) != scaled
