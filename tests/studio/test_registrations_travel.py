"""A registration travels with a model: whatever the door, planes have the same errors."""

from __future__ import annotations

import contextlib
import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import vomstudio as vs
from tests.messages import codes, warned
from tests.registrations import TURN
from tests.tiers import first_in_default_tier
from vomstudio.cli import main
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import Registration
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.models.model_copy import copy_model
from vomstudio.io.models.registration_file import registration_path
from vomstudio.io.photos.cameras_file import FILE_NAME, Cameras, write_cameras
from vomstudio.project import catalogue
from vomstudio.project.figures import Subject
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.measurement import Measurement
from vomstudio.project.measurement_cache import measure_feature
from vomstudio.project.records import Model
from vomstudio.registration.register_options import Observations
from vomstudio.studio.headless_project import AddedModel, HeadlessProject, Picks
from vomstudio.studio.jobs.model_tasks import ModelCut, ModelExport, _cut_model, _export_model

pytestmark = pytest.mark.usefixtures("own_folders")

Array = npt.NDArray[np.float64]
CRS = "EPSG:32633"
SCALE, SHIFT = 2.5, np.array([500_000.0, 4_980_000.0, 320.0])
CORNERS = np.array([[0, 0, 0], [9, 0, 0], [0, 4, 1], [3, 2, 5], [5, 1, 0.5], [7, 3, 4]], float)
BED = np.array([[1, 1, 0.5], [3, 2, 1.1], [6, 1, 0.4], [7, 3, 1.4], [2, 3, 1.6], [5, 2.5, 1.2]])


def to_world(places: Array) -> Array:
    return SCALE * places @ TURN.T + SHIFT


@dataclass(frozen=True)
class Case:
    """model : in a frame of its own; pairs : that place it; out : the registered model"""

    folder: Path
    model: Path
    pairs: Path
    out: Path


def command(*words: object) -> dict[str, Any]:
    """Run a command and return its JSON."""
    import io

    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main([str(word) for word in (*words, "--json")]) == 0
    found: dict[str, Any] = json.loads(out.getvalue())
    return found


@pytest.fixture
def case(tmp_path: Path) -> Case:
    rng = np.random.default_rng(3)
    model = tmp_path / "cliff.xyz"
    places = np.column_stack([rng.uniform(0, 9, 400), rng.uniform(0, 4, 400), np.zeros(400)])
    places[:, 2] = 0.2 * places[:, 0] + 0.3 * places[:, 1]
    np.savetxt(model, places, fmt="%.6f")
    pairs = tmp_path / "pairs.csv"
    world = to_world(CORNERS) + rng.normal(0.0, 0.02, CORNERS.shape)
    rows = [
        ",".join([f"P{i}", *(f"{v:.6f}" for v in (*a, *b))])
        for i, (a, b) in enumerate(zip(CORNERS, world, strict=True))
    ]
    pairs.write_text("label,model_x,model_y,model_z,x,y,z\n" + "\n".join(rows) + "\n")
    out = tmp_path / "placed" / "cliff.ply"
    out.parent.mkdir()
    command("register", model, "--pairs", pairs, "--crs", CRS, "-o", out)
    return Case(tmp_path, model, pairs, out)


@contextlib.contextmanager
def desk(folder: Path) -> Iterator[HeadlessProject]:
    ProjectFolder.create(folder).close()
    with HeadlessProject.open(folder) as opened:
        yield opened


def bed_on(project: HeadlessProject, model: Model, points: Array) -> Measurement:
    """The measurement of a trace through points in World."""
    kind = project.find_type("bedding")
    added = project.add_picks([Picks("", points)], model, kind)
    return measure_feature(added.features[0], model)


def bed_in_new_project(
    folder: Path, file: Path, points: Array, options: FrameOptions = DEFAULT_FRAME
) -> tuple[Measurement, AddedModel]:
    with desk(folder) as project:
        added = project.add_model(file, options)
        return bed_on(project, added.model, points), added


def assert_same_errors(found: Measurement, wanted: Measurement, rel: float = 1e-5) -> None:
    assert wanted.registration_error_deg is not None
    assert wanted.registration_error_deg > 0.05
    assert found.registration_error_deg == pytest.approx(wanted.registration_error_deg, rel=rel)
    totals = [catalogue.TOTAL_ERROR.value(Subject(None, each)) for each in (found, wanted)]
    assert totals[0] > found.registration_error_deg
    assert totals[0] == pytest.approx(totals[1], rel=1e-3)


def as_reconstructed(case: Case, folder: Path) -> Path:
    """The registered model as a reconstruction of the same place and errors would leave it."""
    stored = json.loads(registration_path(case.out).read_text("utf-8"))
    up, east, north = stored["rotation_error_deg"]
    result = {
        "frame": CRS,
        "scaled": True,
        "registration": {
            "method": "ground control points",
            "rotation_error_deg": {"about_up": up, "about_east": east, "about_north": north},
            "scale_error": stored["scale_error"],
            "covariance": stored["covariance"]["matrix"],
            "centre": stored["covariance"]["centre"],
        },
    }
    folder.mkdir()
    (folder / "reconstruction.json").write_text(json.dumps(result))
    write_cameras(folder / FILE_NAME, Cameras((), folder, crs=CRS, is_scaled=True))
    (folder / "model.ply").write_bytes(case.out.read_bytes())
    return folder / "model.ply"


# --- the doors ------------------------------------------------------------------------------------
def test_command_window_and_reconstruction_give_the_same_total_errors(case: Case) -> None:
    points = to_world(BED)
    by_command, added = bed_in_new_project(case.folder / "command.vom", case.out, points)
    assert added.model.frame.crs == CRS
    assert added.warnings == ()
    # As in the window: the model of the project is placed by an edit.
    with desk(case.folder / "window.vom") as project:
        model = project.add_model(case.model).model
        project.register(model, Observations(pairs=str(case.pairs), crs=CRS))
        placed = project.find_model(None)
        by_window = bed_on(project, placed, points)
    made = as_reconstructed(case, case.folder / "photos")
    by_result, _ = bed_in_new_project(case.folder / "result.vom", made, points)
    for found in (by_command, by_result):
        assert_same_errors(found, by_window)


def test_model_read_in_python_has_the_registration_errors(case: Case, tmp_path: Path) -> None:
    made = vs.read(case.out)
    with warned("control.no-check-points"):
        placed = vs.register(case.model, pairs=case.pairs, crs=CRS)
    for axis in ("about_up", "about_east", "about_north"):
        expected = getattr(placed.rotation_error_95_deg, axis)
        assert 1.96 * getattr(made.rotation_error_deg, axis) == pytest.approx(expected, rel=1e-3)
    assert made.scale_error_95 == pytest.approx(placed.scale_error_95)
    saved = made.save(tmp_path / "copy.xyz")
    again = vs.read(saved)
    assert again.rotation_error_deg == made.rotation_error_deg
    with vs.Project.create(tmp_path / "python.vom") as project:
        id_ = project.add_model(case.out)
        project.add_trace(to_world(BED), model=id_, type="bedding")
        by_python = float(project.planes()["registration_error_deg"][0])
    by_command, _ = bed_in_new_project(tmp_path / "command.vom", case.out, to_world(BED))
    assert by_python == pytest.approx(by_command.registration_error_deg)


def test_models_of_one_registration_share_its_record(case: Case) -> None:
    """Their planes turn together."""
    command("convert", case.out, case.folder / "again.xyz")
    with desk(case.folder / "both.vom") as project:
        for file in (case.out, case.folder / "again.xyz"):
            project.add_model(file)
        first, second = project.session.of(Model)
        assert first.registration is second.registration
        assert len(project.session.of(Registration)) == 1


def test_second_registration_keeps_the_error_of_undetermined_parameters(case: Case) -> None:
    """An azimuth alone determines the turn about the vertical, not the tilt."""
    ends = to_world(BED)[[0, 3]]
    along = ends[1] - ends[0]
    azimuth = float(np.degrees(np.arctan2(along[0], along[1]))) % 360.0
    line = ",".join(map(repr, [*ends[0].tolist(), *ends[1].tolist(), azimuth, 0.001]))
    turned = case.folder / "turned.ply"
    command("register", case.out, "--bearing", line, "-o", turned)
    before, after = (
        json.loads(registration_path(each).read_text("utf-8")) for each in (case.out, turned)
    )
    sigma = [np.sqrt(np.diag(each["covariance"]["matrix"])) for each in (before, after)]
    assert sigma[1][:2] == pytest.approx(sigma[0][:2], rel=0.05)
    assert sigma[1][2] < 0.1 * sigma[0][2]
    assert after["scale_error"] == pytest.approx(before["scale_error"], rel=0.01)
    assert (after["frame"], after["crs"]) == ("crs", CRS)


# --- copies ---------------------------------------------------------------------------------------
def copied(case: Case) -> Path:
    return copy_model(case.out, case.folder / "copies")


def copied_from_project(case: Case) -> Path:
    model, _ = registered_in_project(case, case.folder / "p.vom")
    return copy_model(case.model, case.folder / "copies", registration=model.registration)


def converted(case: Case) -> Path:
    command("convert", case.out, case.folder / "converted.xyz")
    return case.folder / "converted.xyz"


def labelled(case: Case) -> Path:
    command("compare", case.out, case.out, "-o", case.folder / "labelled.ply")
    return case.folder / "labelled.ply"


def registered_in_project(case: Case, folder: Path) -> tuple[Model, Path]:
    with desk(folder) as project:
        model = project.add_model(case.model).model
        project.register(model, Observations(pairs=str(case.pairs), crs=CRS))
        return project.find_model(None), project.project.cache


def exported(case: Case) -> Path:
    model, cache = registered_in_project(case, case.folder / "e.vom")
    out = case.folder / "exported.ply"
    _export_model(
        ModelExport(
            case.model, cache, model.to_world, CRS, out, model.frame.axes, model.registration
        ),
        SilentProgress(),
    )
    return out


def cut(case: Case) -> Path:
    model, cache = registered_in_project(case, case.folder / "c.vom")
    bits = case.folder / "bits.npy"
    np.save(bits, np.packbits(np.arange(400) < 300))
    order = ModelCut(
        case.model,
        cache,
        model.content_hash,
        bits,
        None,
        case.folder / "pieces",
        "piece",
        model.registration,
    )
    return _cut_model(order, SilentProgress()).path


@pytest.mark.parametrize(
    "make",
    first_in_default_tier([copied, copied_from_project, converted, labelled, exported, cut], 2),
)
def test_a_copy_has_the_errors_of_the_original(case: Case, make: Callable[[Case], Path]) -> None:
    wanted, _ = bed_in_new_project(case.folder / "original.vom", case.out, to_world(BED))
    found, added = bed_in_new_project(case.folder / "copy.vom", make(case), to_world(BED))
    assert added.warnings == ()
    assert added.model.frame.crs == CRS
    assert_same_errors(found, wanted)
    assert found.points == pytest.approx(to_world(BED), abs=1e-5)


def test_cut_piece_keeps_file_coordinates_and_the_matrix_to_world(case: Case) -> None:
    piece = cut(case)
    stored = json.loads(registration_path(piece).read_text("utf-8"))
    assert not np.allclose(stored["matrix"], np.eye(4))
    corners = vs.read(piece).points
    own = np.loadtxt(case.model)[:300]
    assert corners == pytest.approx(transform.apply(stored["matrix"], own), abs=1e-5)
    assert json.loads(registration_path(case.out).read_text("utf-8"))["matrix"] == (
        np.eye(4).tolist()
    )


def test_crs_conversion_rotates_the_covariance_by_the_convergence(case: Case) -> None:
    """A plane tilts by the same angle, about whatever north it is counted from."""
    wanted, _ = bed_in_new_project(case.folder / "original.vom", case.out, to_world(BED))
    to_crs = FrameOptions(to_crs="EPSG:32632")
    with desk(case.folder / "converted.vom") as project:
        model = project.add_model(case.out, to_crs).model
        assert model.frame.crs == "EPSG:32632"
        assert model.registration is not None
        from vomstudio.io.gate.reprojection import Reprojection

        points = Reprojection.create(CRS, "EPSG:32632").apply(to_world(BED))
        found = bed_on(project, model, points)
    assert wanted.plane is not None
    assert found.plane is not None
    turned = (found.plane.dip_direction_deg - wanted.plane.dip_direction_deg + 180) % 360 - 180
    assert abs(turned) > 3.0
    assert found.registration_error_deg == pytest.approx(wanted.registration_error_deg, rel=2e-3)


# --- losses ---------------------------------------------------------------------------------------
def lose_by_another_file(case: Case) -> Sequence[str]:
    # The last digits of a coordinate.
    content = bytearray(case.out.read_bytes())
    content[-8] ^= 1
    case.out.write_bytes(content)
    return ["registration.other-model"]


def lose_by_damage(case: Case) -> Sequence[str]:
    registration_path(case.out).write_text("{")
    return ["registration.damaged"]


def lose_by_version(case: Case) -> Sequence[str]:
    path = registration_path(case.out)
    plain = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps(plain | {"version": 99}))
    return ["registration.unknown-version"]


def lose_by_result(case: Case) -> Sequence[str]:
    registration_path(case.out).unlink()
    folder = case.out.parent
    write_cameras(folder / FILE_NAME, Cameras((), folder, crs=CRS, is_scaled=True))
    (folder / "reconstruction.json").write_text("[]")
    case.out.rename(folder / "model.ply")
    return ["registration.damaged"]


@pytest.mark.parametrize(
    "lose", [lose_by_another_file, lose_by_damage, lose_by_version, lose_by_result]
)
def test_lost_registration_is_reported_by_every_interface(
    case: Case, lose: Callable[[Case], Sequence[str]], tmp_path: Path
) -> None:
    wanted = list(lose(case))
    (file,) = case.out.parent.glob("*.ply")
    _, added = bed_in_new_project(case.folder / "a.vom", file, to_world(BED))
    assert added.model.registration is None
    assert codes({"warnings": added.warnings}) == wanted
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        vs.read(file)
    assert [each.message.code for each in caught] == wanted  # type: ignore[union-attr]
    assert codes(command("info", file)["files"][0]) == wanted
    assert codes(command("convert", file, tmp_path / "out.xyz")) == wanted
    assert not registration_path(tmp_path / "out.xyz").exists()


@pytest.mark.parametrize(
    "options", [FrameOptions(crs="EPSG:32632"), FrameOptions(up="y"), FrameOptions(unit="ft")]
)
def test_a_frame_that_contradicts_the_registration_is_reported(
    case: Case, options: FrameOptions
) -> None:
    local = case.folder / "local.xyz"
    out = case.folder / "local_placed.xyz"
    local.write_text(case.model.read_text())
    command("register", local, "--pairs", case.pairs, "-o", out)
    with desk(case.folder / "a.vom") as project:
        added = project.add_model(out, options)
        if options.crs is not None:
            # The local frame becomes that of the map that is stated.
            assert added.model.registration is not None
            assert added.model.frame.crs == options.crs
        else:
            assert added.model.registration is None
            assert "registration.other-frame" in codes({"warnings": added.warnings})


def test_crs_different_from_the_registration_is_reported(case: Case) -> None:
    with desk(case.folder / "a.vom") as project:
        added = project.add_model(case.out, FrameOptions(crs="EPSG:32632"))
    assert added.model.registration is None
    assert "registration.other-frame" in codes({"warnings": added.warnings})


# --- a fit to another model -----------------------------------------------------------------------
def test_project_fit_keeps_the_scale_error_and_adds_the_reference_error(
    tmp_path: Path,
) -> None:
    from tests.registration.rock_faces import sampled
    from vomstudio.geometry.frames import Frame
    from vomstudio.project import edits

    rng = np.random.default_rng(1)
    for name in ("own.xyz", "reference.xyz"):
        np.savetxt(tmp_path / name, sampled(3_000, rng, 0.01, 9.0), fmt="%.4f")
    spread = np.diag([*np.radians([0.1, 0.2, 0.3]) ** 2, 4e-6, 1e-4, 1e-4, 1e-4])
    rows = tuple(map(tuple, spread.tolist()))
    before = Registration(
        "r", "r", "gps", Frame("local"), scale_error=2e-3, covariance=rows, centre=(4.0, 0.0, 4.0)
    )
    with desk(tmp_path / "reference.vom") as project:
        theirs = project.add_model(tmp_path / "reference.xyz").model
        project.session.apply(edits.set_registration(project.session.records, before, [theirs.id]))
        reference, cache = project.find_model(None), project.project.cache
        _export_model(
            ModelExport(
                tmp_path / "reference.xyz",
                cache,
                reference.to_world,
                None,
                tmp_path / "registered.xyz",
                reference.frame.axes,
                reference.registration,
            ),
            SilentProgress(),
        )
    with desk(tmp_path / "own.vom") as project:
        own = project.add_model(tmp_path / "own.xyz").model
        project.session.apply(edits.set_registration(project.session.records, before, [own.id]))
        own = project.find_model(None)
        reference_file = str(tmp_path / "registered.xyz")
        placed = project.register(own, Observations(reference=reference_file)).result.placed
        after = project.find_model(None).registration
    assert after is not None
    assert after.scale_error == pytest.approx(2e-3, rel=0.01)
    # The tilt is that of the reference and that of the fit.
    east = np.sqrt(after.rotation_covariance()[0, 0])  # type: ignore[index]
    assert east > np.radians(0.1)
    assert east == pytest.approx(
        np.hypot(np.radians(0.1), np.sqrt(placed.covariance[0][0])), rel=1e-6
    )
    assert "registration.reference-error" in codes({"warnings": placed.warnings})
