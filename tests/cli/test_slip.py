"""`vomstudio slip` and `vs.slip`, with what exports of a project write."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas
import pytest

import vomstudio as vs
from tests.messages import by_code
from vomstudio.core.errors import InputError
from vomstudio.geology.faults.kinematics import fault_movements
from vomstudio.geology.orientation import Plane, slip_from_rake
from vomstudio.io.gate.orientation_files import read_slips
from vomstudio.project.exports.export import export_project

SPECIMEN = Path(__file__).parents[1] / "specimens" / "schema1.vom"
TABLE = "strike,dip,trend,plunge,sense\n0,45,90,45,N\n180,45,270,45,N\n"


@pytest.fixture(scope="module")
def specimen(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("slips") / "a.vom"
    shutil.copytree(SPECIMEN, folder)
    return folder


@pytest.mark.parametrize("format_", ["faultkin", "csv", "wintensor"])
def test_exported_slips_are_read_back_with_every_sense(specimen, tmp_path, format_) -> None:
    made = export_project(specimen, "faultkin", tmp_path / "f.txt")
    export_project(specimen, format_, tmp_path / "x.txt", force=True)
    back = read_slips(tmp_path / "x.txt")
    assert len(back) == len(made.rows)
    assert {r["slip_sense"] for r in made.rows} == {"normal", "reverse", "sinistral", "dextral"}
    for i, row in enumerate(made.rows):
        plane = Plane(back.dip_direction_deg[i], back.dip_deg[i])
        true = Plane(row["on_plane_dip_direction_deg"], row["on_plane_dip_deg"])
        assert slip_from_rake(plane, back.slip_rake_deg[i]).vector() == pytest.approx(
            slip_from_rake(true, row["slip_rake_deg"]).vector(), abs=1e-6
        )


def test_conjugate_normal_faults_give_vertical_shortening(run, write) -> None:
    ran = run("slip", write(TABLE), "--json")
    assert ran.code == 0
    axes = ran.json["kinematic_axes"]
    assert axes["shortening"]["plunge_deg"] == pytest.approx(90.0)
    assert axes["extension"]["trend_deg"] % 180 == pytest.approx(90.0)
    assert axes["extension"]["confidence95_deg"] is None
    assert [f["slip"]["plunge_deg"] for f in ran.json["faults"]] == pytest.approx([45.0, 45.0])
    assert ran.json["right_dihedra"]["compression"]["share"] == 1.0


def test_rake_may_state_the_end_of_strike(write) -> None:
    head = "strike,dip,rake,sense\n"
    for cell, slip in (("60NE", -60.0), ("60N", -60.0), ("60SW", -120.0), ("60 S", -120.0)):
        found = read_slips(write(head + f"20,50,{cell},N\n"))
        assert found.slip_rake_deg.tolist() == [slip], cell
    with pytest.raises(vs.errors.InputError) as refused:
        read_slips(write(head + "20,50,60SE,N\n"))
    assert refused.value.line == 2


def test_sense_words_and_letters_are_equivalent(write) -> None:
    head = "strike,dip,rake,sense\n"
    for row in ("N", "normal", "NL", "NS"):
        found = read_slips(write(head + f"20,50,60,{row}\n"))
        assert found.slip_rake_deg.tolist() == [-60.0], row
    for row in ("R", "T", "I", "reverse", "TR", "thrust"):
        found = read_slips(write(head + f"20,50,60,{row}\n"))
        assert found.slip_rake_deg.tolist() == [120.0], row


def test_letter_r_is_right_lateral_with_faultkin_letters(write) -> None:
    """T, N, R, L: thrust, normal, right, left. Beside N, S and D it is reverse."""
    head = "strike,dip,rake,sense\n20,50,90,T\n" + "20,50,10,{}\n" * 2
    found = read_slips(write(head.format("L", "R")))
    assert found.slip_rake_deg.tolist() == [90.0, -10.0, 170.0]
    assert "slip.right-lateral" in by_code(found.warnings)
    found = read_slips(write(head.replace(",T", ",N").format("S", "R")))
    assert found.slip_rake_deg.tolist() == [-90.0, -10.0, 170.0]
    found = read_slips(write("strike,dip,rake,sense\n20,50,60,T\n20,50,60,R\n"))
    # Downward to the left at 60 degrees: dextral is up, as the thrust.
    assert found.slip_rake_deg.tolist() == [120.0, 120.0]
    found = read_slips(write("strike,dip,rake,sense\n20,50,120,T\n20,50,120,R\n"))
    # Downward to the right: dextral is down, where a thrust is up.
    assert found.slip_rake_deg.tolist() == [60.0, -120.0]


def test_t_tecto_sense_numbers_are_read(write) -> None:
    """1 reverse, 2 normal, 3 dextral, 4 sinistral; other numbers are refused."""
    head = "strike,dip,rake,sense\n"
    found = read_slips(write(head + "20,50,90,1\n20,50,90,2\n20,50,0,3\n20,50,0,4\n"))
    dextral, sinistral = found.slip_rake_deg[2:] % 360
    assert found.slip_rake_deg[:2].tolist() == [90.0, -90.0]
    assert (dextral, sinistral) == (180.0, 0.0)
    assert "slip.numbered-senses" in by_code(found.warnings)
    with pytest.raises(InputError):
        read_slips(write(head + "20,50,90,1\n20,50,90,5\n"))


def test_sense_contradicting_striae_is_refused_with_line(run, write) -> None:
    ran = run("slip", write("strike,dip,rake,sense\n20,50,60,NR\n"))
    assert ran.code == 2
    assert "line 2" in ran.said
    assert "contradicts" in ran.said


@pytest.mark.parametrize(
    ("table", "code", "words"),
    [
        ("trend,plunge,sense\n1,2,N\n", "slip.missing-columns", "strike"),
        ("strike,dip,sense\n1,2,N\n", "slip.missing-columns", "striae"),
        ("strike,dip,rake\n1,2,3\n", "slip.missing-columns", "sense"),
        ("strike,dip,rake,sense\n1,95,3,N\n", None, "95"),
        ("strike,dip,rake,sense\n1,45,3,up\n", "table.unknown-word", "up"),
        ("strike,dip,rake,sense\n1,45,,N\n", "table.no-valid-rows", "slip"),
    ],
)
def test_incomplete_slip_tables_are_refused(run, write, table, code, words) -> None:
    ran = run("slip", write(table), "--json")
    assert ran.code == 2
    assert code is None or ran.json["error"]["code"] == code
    assert words in ran.json["error"]["message"]


def test_rows_without_sense_are_left_out_and_reported(run, write) -> None:
    ran = run("slip", write(TABLE + "10,50,,,N\n10,50,90,50,X\n"), "--json")
    assert ran.json["n"] == 2
    assert ran.json["dropped_lines"] == [4, 5]


def test_striae_off_their_plane_are_reported(run, write) -> None:
    ran = run("slip", write("strike,dip,trend,plunge,sense\n0,45,90,10,N\n"), "--json")
    off = by_code(ran.json["warnings"])["slip.off-plane"]
    assert (off["count"], off["angle_deg"]) == (1, 10)


def test_python_function_matches_command_output(run, write) -> None:
    path = write(TABLE)
    from_file, from_frame = vs.slip(path), vs.slip(pandas.read_csv(path))
    assert from_file.to_dict() == from_frame.to_dict()
    printed = run("slip", path, "--json").json
    assert from_file.to_dict()["kinematic_axes"] == printed["kinematic_axes"]


def test_five_thousand_faults_are_processed() -> None:
    generator = np.random.default_rng(1)
    n = 5000
    frame = pandas.DataFrame(
        {
            "strike": generator.uniform(0, 360, n),
            "dip": generator.uniform(5, 85, n),
            "rake": generator.uniform(5, 175, n),
            "sense": generator.choice(["N", "R"], n),
        }
    )
    assert vs.slip(frame).n == n


def test_arrows_of_normal_faults_point_outward_and_the_picture_names_the_axes(
    run, write, tmp_path: Path
) -> None:
    import xml.etree.ElementTree as ElementTree

    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    from vomstudio.geology.faults.table_slip import table_slip
    from vomstudio.products.net.slip_figure import draw_slip

    path, target = write(TABLE), tmp_path / "s.svg"
    assert run("slip", path, "--plot", target, "--json").json["image"] == str(target)
    said = " ".join(ElementTree.parse(target).getroot().itertext())
    assert "2 faults" in said
    assert "P axes" in said
    table = read_slips(path)
    left, _ = draw_slip(Figure((7, 5)), table, table_slip(table))
    (heads,) = [c for c in left.collections if isinstance(c, PolyCollection)]
    arrows = [path.vertices for path in heads.get_paths()]
    assert len(arrows) == 2
    for head, *wings in (arrow[:3] for arrow in arrows):
        tail = np.mean(wings, axis=0)
        assert np.linalg.norm(head) > np.linalg.norm(tail)


@pytest.mark.parametrize("strike", [0.0, 45.0, 179.0, 180.0, 200.0, 270.0, 359.0])
@pytest.mark.parametrize("sense", ["S", "D"])
def test_rake_on_vertical_plane_is_measured_from_stated_strike(
    write, strike: float, sense: str
) -> None:
    """As on a plane that is hardly less steep; the movement of one wall is that of the other turned
    round."""
    for column, value in (("rake", 30.0), ("slip_rake", -150.0)):
        steep, upright = (
            read_slips(write(f"strike,dip,{column},sense\n{strike},{dip},{value},{sense}\n"))
            for dip in (89.99, 90)
        )
        ways, walls = [], []
        for table in (steep, upright):
            normals, slips = fault_movements(
                table.dip_direction_deg, table.dip_deg, table.slip_rake_deg
            )
            ways.append(slips[0])
            walls.append(normals[0])
        # The dyad of normal and slip is the movement, whichever wall is told.
        np.testing.assert_allclose(
            np.outer(walls[0], ways[0]), np.outer(walls[1], ways[1]), atol=1e-3
        )


@pytest.mark.parametrize("dip_direction", [0.0, 77.0, 200.0])
def test_directed_rake_on_horizontal_plane_is_measured_from_stated_strike(
    write, dip_direction: float
) -> None:
    ways = []
    for dip in (0.0005, 0):
        text = f"dip_direction,dip,slip_rake\n{dip_direction},{dip},-60\n"
        table = read_slips(write(text))
        ways.append(
            fault_movements(table.dip_direction_deg, table.dip_deg, table.slip_rake_deg)[1][0]
        )
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-4)


def test_azimuth_option_applies_to_table_without_header(run, write) -> None:
    """The order of OpenStereo: dip direction, dip, trend, plunge, sense."""
    path = write("90\t60\t90\t60\t2\n270\t62\t270\t62\t2\n", "faults.txt")
    asked = run("slip", path, "--json")
    assert (asked.code, asked.json["error"]["code"]) == (2, "orientation.ambiguous-azimuth")
    read = run("slip", path, "--azimuth", "dipdir", "--json").json
    assert [fault["dip_direction_deg"] for fault in read["faults"]] == [90.0, 270.0]
    columns = "1=dip_direction,2=dip,3=trend,4=plunge,5=sense"
    assert run("slip", path, "--columns", columns, "--json").json["faults"] == read["faults"]
    assert vs.slip(path, azimuth="dipdir").to_dict()["faults"] == read["faults"]
