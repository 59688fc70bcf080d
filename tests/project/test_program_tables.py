"""Tables and XML of other programs: written by hand as their source code writes them."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from tests.project.test_foreign_features import MODEL, ORIGIN, POINTS, read
from tests.samples import ZIGZAG
from vomstudio.geology.orientation import Plane
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_feature

pytestmark = pytest.mark.filterwarnings("ignore:Measured:UserWarning")


def own_plane() -> tuple[float, float]:
    """Dip direction and dip of the zigzag."""
    trace = Trace("t", "", "joint", "m1", MODEL.content_hash, tuple(map(tuple, POINTS.tolist())))
    plane = measure_feature(trace, MODEL).plane
    assert plane is not None
    return plane.dip_direction_deg, plane.dip_deg


# --- tables of points -------------------------------------------------------------------------
def rows(points: np.ndarray, *words: str, delimiter: str = ",") -> str:
    return "".join(
        delimiter.join([*(f"{value:.3f}" for value in point), *words]) + "\n" for point in points
    )


def test_a_column_groups_the_points_of_traces(tmp_path: Path) -> None:
    path = tmp_path / "picks.csv"
    path.write_text(
        "x,y,z,trace,type,set,notes\n"
        + rows(POINTS, "A", "fault", "S1", "sharp")
        + rows(POINTS + 2.0, "B", "Joint", "", "")
    )
    found = read(path)
    first, second = found.features
    assert isinstance(first, Trace)
    assert (first.name, first.type_id, first.set_name, first.notes) == ("A", "fault", "S1", "sharp")
    assert (second.name, second.type_id, second.set_name) == ("B", "joint", "")
    assert np.array(second.vertices) == pytest.approx(POINTS + 2.0, abs=1e-3)
    assert found.warnings == ()


@pytest.mark.parametrize("delimiter", ["\t", " ", ";"])
def test_table_without_header_has_trace_names_in_fourth_column(
    tmp_path: Path, delimiter: str
) -> None:
    path = tmp_path / "sticks.txt"
    path.write_text(
        rows(POINTS, "1", delimiter=delimiter) + rows(POINTS + 2.0, "2", delimiter=delimiter)
    )
    found = read(path)
    assert [len(feature.vertices) for feature in found.features] == [5, 5]
    assert [feature.name for feature in found.features] == ["", ""]


def test_blank_lines_separate_objects_in_move_tables(tmp_path: Path) -> None:
    """As described in Move2FracPaq.m (github.com/DaveHealy-github/FracPaQ): columns X, Y and Z
    separated by tabs, and "Insert line break between objects"."""
    path = tmp_path / "horizon.dat"
    path.write_text(rows(POINTS, delimiter="\t") + "\n" + rows(POINTS + 2.0, delimiter="\t"))
    found = read(path)
    first, second = found.features
    assert np.array(first.vertices) == pytest.approx(POINTS, abs=1e-3)
    assert np.array(second.vertices) == pytest.approx(POINTS + 2.0, abs=1e-3)


def test_ungrouped_points_are_rejected(tmp_path: Path) -> None:
    path = tmp_path / "cloud.txt"
    path.write_text(rows(POINTS, delimiter=" "))
    with refused("import.no-trace-column"):
        read(path)


def test_coordinates_are_converted_from_the_crs_of_the_table(tmp_path: Path) -> None:
    from pyproj import Transformer

    other = Transformer.from_crs("EPSG:32633", "EPSG:32632", always_xy=True)
    points = np.column_stack([*other.transform(*POINTS[:, :2].T), POINTS[:, 2]])
    path = tmp_path / "picks.csv"
    path.write_text("# CRS: EPSG:32632\nx,y,z,trace\n" + rows(points, "A"))
    found = read(path)
    assert "frame.reprojected" in [finding.code for finding in found.warnings]
    assert np.array(found.features[0].vertices) == pytest.approx(POINTS, abs=2e-3)


def test_fracpaq_traces_without_heights_are_rejected(tmp_path: Path) -> None:
    """Rows x1 y1 x2 y2 ... with tabs, as readTraces.m of FracPaQ reads them."""
    path = tmp_path / "traces.txt"
    path.write_text("1.0\t2.0\t3.0\t4.5\n1.0\t2.0\t3.0\t4.0\t5.0\t7.0\n")
    with refused("import.nothing-usable") as error:
        read(path)
    assert "no heights" in error.value.message


# --- CloudCompare Compass -----------------------------------------------------------------------
# ccCompassExport.cpp in plugins/core/Standard/qCompass of github.com/CloudCompare/CloudCompare.
TRACES_HEADER = "Name,Trace_id,Point_id,Start_x,Start_y,Start_z,End_x,End_y,End_z,Cost,Cost_Mode\n"
PLANES_HEADER = "Name,Strike,Dip,Dip_Dir,Cx,Cy,Cz,Nx,Ny,Nz,Sample_Radius,RMS,Gx,Gy,Gz,Length\n"
LINES_HEADER = "Name,Sx,Sy,Sz,Ex,Ey,Ez,Trend,Plunge,Length\n"


def segments(points: np.ndarray, name: str, number: int) -> str:
    return "".join(
        ",".join([name, str(number), str(i), *(f"{v:.12f}" for v in (*start, *end)), "42", "4"])
        + "\n"
        for i, (start, end) in enumerate(itertools.pairwise(points))
    )


def test_compass_traces_are_joined_from_segments(tmp_path: Path) -> None:
    path = tmp_path / "c_traces.csv"
    broken = segments(POINTS, "cliff.Dykes.Trace", 9).splitlines(keepends=True)
    path.write_text(
        TRACES_HEADER
        + segments(POINTS, "cliff.Joint.Trace", 7)
        + segments(POINTS + 2.0, "cliff.Dykes.margin", 8)
        + broken[0]
        + broken[3]
    )
    found = read(path)
    first, second = found.features
    assert np.array(first.vertices) == pytest.approx(POINTS)
    assert (first.name, first.type_id, first.notes) == ("", "joint", "cliff.Joint.Trace")
    assert (second.name, second.type_id) == ("margin", "contact")
    assert [(name, reason.code) for name, reason in found.skipped] == [
        ("cliff.Dykes.Trace", "import.gaps")
    ]


def test_compass_planes_keep_orientation_and_global_position(tmp_path: Path) -> None:
    """A plane of another tool has no length, and its radius and RMS are unknown."""
    path = tmp_path / "c_planes.csv"
    local = "1.5,2.5,3.5,0.0,0.5,0.866"
    path.write_text(
        PLANES_HEADER
        + f"cliff.Bedding.30/000,270,30,0,{local},0.5,0.01,372412.5,4709822.5,616.5,2.5\n"
        + f"cliff.Plane,90,60,180,{local},NA,UNK,372413.5,4709823.5,617.5\n"
        + f"cliff.bad,90,,180,{local},NA,UNK,372413.5,4709823.5,617.5\n"
    )
    found = read(path)
    first, second = found.features
    assert isinstance(first, Reading)
    assert (first.azimuth_deg, first.inclination_deg, first.type_id) == (0.0, 30.0, "bedding")
    assert first.position == (372412.5, 4709822.5, 616.5)
    assert first.source == "c_planes.csv"
    assert (second.name, second.azimuth_deg, second.inclination_deg) == ("Plane", 180.0, 60.0)
    assert [(name, reason.code) for name, reason in found.skipped] == [
        ("cliff.bad", "import.no-orientation")
    ]


def test_compass_lineations_become_lines_and_thicknesses_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "c_lineations.csv"
    ends = ",".join(f"{value:.6f}" for value in (*POINTS[0], *POINTS[4]))
    path.write_text(LINES_HEADER + f"cliff.4.5 on 26->073,{ends},73.3,26.0,4.5\n")
    (line,) = read(path).features
    assert isinstance(line, Lineation)
    assert (line.name, line.type_id) == ("", "lineation")
    assert np.array(line.vertices) == pytest.approx(POINTS[[0, 4]], abs=1e-5)
    path.write_text(LINES_HEADER.replace("Length", "Thickness") + f"T,{ends},73.3,26.0,4.5\n")
    with refused("import.nothing-usable", name="T"):
        read(path)


def compass_xml(dip_direction: float, dip: float, clouds: str) -> str:
    lists = "".join(
        f"<{axis}>{','.join(f'{value:f}' for value in column)}</{axis}>"
        for axis, column in zip("xyz", np.array(ZIGZAG).T, strict=True)
    )
    ends = "".join(
        f"<{end}{axis}>{value}</{end}{axis}>"
        for end, point in (("E", POINTS[4]), ("S", POINTS[0]))
        for axis, value in zip("xyz", point, strict=True)
    )
    plane = (
        "<Cx>1</Cx><Cy>2</Cy><Cz>3</Cz>"
        f"<Dip>{dip}</Dip><DipDir>{dip_direction}</DipDir><Strike>0</Strike>"
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<CONTAINER name="project.bin" id="1">
    {clouds}
    <GEO_OBJECT name="Dyke 3" id="4"><ccCompassType>GeoObject</ccCompassType>
        <CONTAINER name="Upper Boundary" id="5">
            <TRACE name="Trace" id="6"><ccCompassType>Trace</ccCompassType>
                <POINTS count="5" normals="False">{lists}<cost>1,1,1,1,0</cost></POINTS>
                <PLANE name="30/000" id="7">{plane}<Length>2</Length></PLANE>
            </TRACE>
        </CONTAINER>
    </GEO_OBJECT>
    <GEO_OBJECT name="Bedding" id="8">
        <PLANE name="30/000" id="9">{plane}</PLANE>
        <LINEATION name="4.5 on 26-&gt;073" id="10">{ends}<Trend>73</Trend></LINEATION>
        <THICKNESS name="T" id="11">{ends}</THICKNESS>
    </GEO_OBJECT>
</CONTAINER>
"""


def cloud(x: float = -ORIGIN[0]) -> str:
    return (
        '<CLOUD name="cliff" id="2"><GLOBAL_SCALE>1.000000</GLOBAL_SCALE>'
        f"<GLOBAL_X>{x:f}</GLOBAL_X><GLOBAL_Y>{-ORIGIN[1]:f}</GLOBAL_Y>"
        f"<GLOBAL_Z>{-ORIGIN[2]:f}</GLOBAL_Z></CLOUD>"
    )


def test_compass_tree_becomes_traces_planes_and_lines(tmp_path: Path) -> None:
    path = tmp_path / "compass.xml"
    path.write_text(compass_xml(*own_plane(), cloud()))
    found = read(path)
    trace, plane, line = found.features
    assert isinstance(trace, Trace)
    assert np.array(trace.vertices) == pytest.approx(POINTS)
    assert (trace.set_name, trace.type_id) == ("Dyke 3", "contact")
    assert trace.notes == "project.bin.Dyke 3.Upper Boundary.Trace"
    assert isinstance(plane, Reading)
    assert (plane.type_id, plane.set_name) == ("bedding", "")
    assert plane.position == pytest.approx(tuple(ORIGIN + [1, 2, 3]))
    assert (plane.azimuth_deg, plane.inclination_deg) == pytest.approx(own_plane())
    assert isinstance(line, Lineation)
    assert np.array(line.vertices) == pytest.approx(POINTS[[0, 4]])
    assert [(name, reason.code) for name, reason in found.skipped] == [
        ("T", "import.no-counterpart")
    ]
    assert found.warnings == ()


def test_a_plane_that_differs_from_its_trace_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "compass.xml"
    azimuth, dip = own_plane()
    path.write_text(compass_xml(azimuth, dip + 20.0, cloud()))
    (finding,) = read(path).warnings
    assert (finding.code, finding.values["count"]) == ("import.orientations-differ", 1)
    assert float(finding.values["angle"]) == pytest.approx(20.0, abs=0.06)


def test_clouds_with_different_shifts_leave_positions_unknown(tmp_path: Path) -> None:
    path = tmp_path / "compass.xml"
    path.write_text(compass_xml(*own_plane(), cloud() + cloud(-5.0)))
    found = read(path)
    assert [type(feature) for feature in found.features] == [Lineation]
    assert [reason.code for _, reason in found.skipped] == [
        "import.several-shifts",
        "import.several-shifts",
        "import.no-counterpart",
    ]


# --- CloudCompare Facets ------------------------------------------------------------------------
# qFacets::ExecuteExportFacetsInfo in plugins/core/Standard/qFacets; its stream writes six digits.
FACETS_HEADER = (
    "Index; CenterX; CenterY; CenterZ; GlobalCenterX; GlobalCenterY; GlobalCenterZ; NormalX;"
    " NormalY; NormalZ; RMS; Horiz_ext; Vert_ext; Surf_ext; Surface; Dip dir.; Dip; Family ind.;"
    " Subfamily ind.; \n"
)


def test_facets_become_planes_with_their_family_as_set(tmp_path: Path) -> None:
    path = tmp_path / "facets.csv"
    path.write_text(
        FACETS_HEADER
        + "1;1.5;2.5;3.5;1.5;2.5;3.5;0;0.5;0.866;0.01;2;1;2;1.8;0;30;2;0;\n"
        + "2;1.5;2.5;3.5;1.5;2.5;3.5;0;0.5;0.866;0.01;2;1;2;1.8;210.5;80.25;-1;-1;\n"
    )
    found = read(path)
    first, second = found.features
    assert isinstance(first, Reading)
    assert (first.azimuth_deg, first.inclination_deg) == (0.0, 30.0)
    assert (first.position, first.set_name) == ((1.5, 2.5, 3.5), "2")
    assert (second.azimuth_deg, second.inclination_deg, second.set_name) == (210.5, 80.25, "")
    assert found.warnings == ()


def test_rounded_positions_of_facets_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "facets.csv"
    path.write_text(
        FACETS_HEADER
        + "1;1.5;2.5;3.5;372413;4.70982e+06;616.5;0;0.5;0.866;0.01;2;1;2;1.8;0;30;2;0;\n"
    )
    found = read(path)
    assert found.features[0].position == (372413.0, 4709820.0, 616.5)
    (finding,) = found.warnings
    assert (finding.code, finding.values["rounding"]) == ("import.coordinates-rounded", "5")


# --- PRo3D --------------------------------------------------------------------------------------
# AttitudeExport, CSVExport and GeoJSONExport in src/PRo3D.Base/Annotation/Exporters of
# github.com/pro3d-space/PRo3D.
PRO3D_COLUMNS = (
    *("key", "geometry", "projection", "semantic", "color", "thickness", "points", "height"),
    *("heightDelta", "length", "wayLength", "dipAngle", "dipAzimuth", "strikeAzimuth", "rake"),
    *("manualDip", "trueThickness", "bearing", "slope", "verticalDelta", "verticalThickness"),
    *("horizontalDelta", "errorAvg", "errorMin", "errorMax", "errorStd", "sumOfSquares"),
    *("minAngularError", "maxAngularError", "text", "groupName", "surfaceName", "x", "y", "z"),
)


def test_pro3d_annotations_become_traces(tmp_path: Path) -> None:
    path = tmp_path / "attitude.json"
    centre = POINTS.mean(axis=0)
    azimuth, dip = own_plane()
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Plane(azimuth, dip).normal().tolist()]
    annotation = {
        "uid": "c99be640",
        "name": "bed 3",
        "axes": axes,
        "hyperbolic_axes": [1.0, 0.5, None],
        "max_angular_error": 2.5,
        "min_angular_error": 0.5,
        "center": centre.tolist(),
        "strike": azimuth - 90.0,
        "dip": dip,
        "rake": 1.0,
        "disabled": False,
        "centered_array": (POINTS - centre).tolist(),
    }
    without_points = {"uid": "3a2324ee", "axes": axes, "center": centre.tolist()}
    path.write_text(json.dumps([annotation, without_points]))
    found = read(path)
    (trace,) = found.features
    assert isinstance(trace, Trace)
    assert trace.name == "bed 3"
    assert np.array(trace.vertices) == pytest.approx(POINTS)
    assert [(n, reason.code) for n, reason in found.skipped] == [("3a2324ee", "import.no-points")]
    assert found.warnings == ()


def test_pro3d_table_rows_become_planes_at_annotation_centres(tmp_path: Path) -> None:
    path = tmp_path / "annotations.csv"
    cells = dict.fromkeys(PRO3D_COLUMNS, "0")
    cells |= {"key": "c99be640", "geometry": "DnS", "text": "bed 3", "groupName": "bedding"}
    cells |= {"dipAngle": "30.5", "dipAzimuth": "135.25", "surfaceName": "cliff"}
    cells |= dict(zip("xyz", map(str, POINTS[0]), strict=True))
    line = {**cells, "text": "edge", "dipAngle": "NaN", "dipAzimuth": "NaN"}
    quoted = [
        [f'"{cell}"' for cell in row] for row in (PRO3D_COLUMNS, cells.values(), line.values())
    ]
    path.write_text("".join(",".join(row) + "\n" for row in quoted))
    found = read(path)
    (plane,) = found.features
    assert isinstance(plane, Reading)
    assert (plane.azimuth_deg, plane.inclination_deg) == (135.25, 30.5)
    assert (plane.name, plane.type_id) == ("bed 3", "bedding")
    assert plane.position == tuple(POINTS[0].tolist())
    assert [(n, reason.code) for n, reason in found.skipped] == [("edge", "import.no-orientation")]


def test_pro3d_geometries_become_traces(tmp_path: Path) -> None:
    """A collection of geometries without attributes; polylines are MultiLineStrings."""
    from pyproj import Transformer

    to_degrees = Transformer.from_crs("EPSG:32633", "EPSG:4326", always_xy=True)
    lines = [
        np.column_stack([*to_degrees.transform(*line[:, :2].T), line[:, 2]]).tolist()
        for line in (POINTS, POINTS + 3.0)
    ]
    geometries = [{"type": "MultiLineString", "coordinates": [line]} for line in lines]
    path = tmp_path / "annotations.json"
    path.write_text(json.dumps({"type": "GeometryCollection", "geometries": geometries}))
    first, second = read(path).features
    assert np.array(first.vertices) == pytest.approx(POINTS, abs=1e-3)
    assert np.array(second.vertices) == pytest.approx(POINTS + 3.0, abs=1e-3)
