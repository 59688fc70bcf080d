"""Ground control written by other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import InputError, UsageError
from vomstudio.io.control.control_files import (
    agreed_crs,
    find_control,
    find_program_control,
    marks_path,
    read_control,
    read_crs,
    read_marks,
)
from vomstudio.io.control.formats.opendronemap import read_odm
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder


def written(folder: Path, text: str | bytes, name: str = "control.xml") -> Path:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def micmac(*points: str) -> str:
    return f"<?xml version='1.0'?>\n<DicoAppuisFlottant>{''.join(points)}</DicoAppuisFlottant>"


def point(name: str, place: str, error: str = "") -> str:
    stated = f"<Incertitude>{error}</Incertitude>" if error else ""
    return f"\n<OneAppuisDAF><Pt>{place}</Pt>\n<NamePt>{name}</NamePt>{stated}</OneAppuisDAF>"


def marked(*marks: str, photo: str = "a.jpg") -> str:
    return (
        "<SetOfMesureAppuisFlottants><MesureAppuiFlottant1Im>"
        f"\n<NameIm>{photo}</NameIm>{''.join(marks)}"
        "</MesureAppuiFlottant1Im></SetOfMesureAppuisFlottants>"
    )


def mark(name: str, pixel: str) -> str:
    return f"\n<OneMesureAF1I><NamePt>{name}</NamePt>\n<PtIm>{pixel}</PtIm></OneMesureAF1I>"


# --- MicMac ------------------------------------------------------------------------------------
def test_the_points_and_marks_of_saint_martin_are_read(data_dir: Path) -> None:
    points = read_control(data_dir / "saint_martin" / "Ground-Pts3D.xml")
    assert len(points) == 9
    by_name = {p.label: p for p in points}
    assert by_name["Stone-6"].position == (
        0.150697933447584281,
        1.10818337179321613,
        0.773464897817899177,
    )
    # 1 1 1 is a weight: not an error of a metre.
    assert all(p.sigma_m is None and not p.check for p in points)
    marks = read_marks(data_dir / "saint_martin" / "GroundMeasure.xml")
    assert len(marks) == 19
    assert Mark("Grille", "IMGP4167.JPG", 322.076097286495724, 766.811866179541425) in marks
    photos = {label: {m.photo for m in marks if m.label == label} for label in by_name}
    # README of the data: six of the nine are marked in two or more photos.
    assert sum(len(names) >= 2 for names in photos.values()) == 6


def test_stated_error_is_per_coordinate(tmp_path: Path) -> None:
    path = written(tmp_path, micmac(point("A", "1 2 3", "0.03 0.04 0.05"), point("B", "4 5 6")))
    a, b = read_control(path)
    assert a.sigma_m == pytest.approx(np.sqrt((0.03**2 + 0.04**2 + 0.05**2) / 3))
    assert b == ControlPoint("B", (4.0, 5.0, 6.0))


def test_xml_comments_cdata_and_entities_are_decoded(tmp_path: Path) -> None:
    text = micmac(point("<!-- of the mast --><![CDATA[A & B]]>", "1 <!-- east --> 2 &#51;"))
    assert read_control(written(tmp_path, text)) == [ControlPoint("A & B", (1.0, 2.0, 3.0))]


def test_nested_elements_of_newer_versions_are_found(tmp_path: Path) -> None:
    text = f"<Global>{marked(mark('A', '1.5 2.5'), photo='dir/a.jpg')}</Global>"
    assert read_marks(written(tmp_path, text)) == [Mark("A", "dir/a.jpg", 1.5, 2.5)]


BOMB = (
    '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    "<DicoAppuisFlottant>&b;</DicoAppuisFlottant>"
)
UNFOLDING = "<!DOCTYPE x [<!ENTITY a0 'aaaaaaaaaa'>"
for _k in range(1, 12):
    UNFOLDING += f"<!ENTITY a{_k} '{f'&a{_k - 1};' * 10}'>"
UNFOLDING += "]><x y='&a11;'/>"


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        (
            micmac(point("A", "1 2")),
            "file.number-count",
            {"line": 3, "field": "Pt", "count": 2, "needed": 3},
        ),
        (
            micmac(point("A", "1 2 east")),
            "table.not-a-number",
            {"line": 3, "field": "Pt", "cell": "east"},
        ),
        (micmac(point("A", "1 2 nan")), "table.not-a-number", {"cell": "nan"}),
        (micmac(point("A", "")), "table.value-missing", {"line": 3, "field": "Pt"}),
        (micmac(point("", "1 2 3")), "table.value-missing", {"line": 4, "field": "NamePt"}),
        (
            micmac("\n<OneAppuisDAF><NamePt>A</NamePt></OneAppuisDAF>"),
            "file.missing-element",
            {"name": "Pt"},
        ),
        (
            micmac(point("A", "1 2 3"), point("A", "1 2 4")),
            "table.repeated-label",
            {"label": "A", "first_line": 3},
        ),
        (micmac(point("A", "1 2 3", "0.1 -1 0.1")), "table.not-positive", {"field": "Incertitude"}),
        (micmac(), "control.no-points", {}),
        (micmac(point("A", "1 2 3"))[:-30], "file.damaged", {"format": "XML"}),
        (marked(mark("A", "1 2")), "control.only-marks", {}),
        ("<html><body>404</body></html>", "control.no-points", {"field": "html"}),
        (BOMB, "file.declares-entity", {}),
        (BOMB.replace("&b;", ""), "file.declares-entity", {"name": "a"}),
        (
            '<!DOCTYPE x [<!ENTITY a SYSTEM "/etc/passwd">]><x>&a;</x>',
            "file.declares-entity",
            {"name": "a"},
        ),
        (UNFOLDING, "file.damaged", {"format": "XML"}),
        ("<a>" * 200 + "</a>" * 200, "file.too-many-parts", {}),
        (
            "<a>\n" * 65 + "</a>" * 65,
            "file.too-many-parts",
            {"line": 65, "field": "a", "limit": 64},
        ),
        ("<a>" * 64 + "</a>" * 64, "control.no-points", {}),
        ("<a>" * 100_000 + "</a>" * 100_000, "file.damaged", {"format": "XML"}),
        ("<?xml version='1.0' encoding='klingon'?><a/>", "file.damaged", {"format": "XML"}),
        (b"<a>\xff\xfe\x00</a>", "file.damaged", {"format": "XML"}),
        ("<", "file.damaged", {"format": "XML"}),
    ],
)
def test_xml_errors_are_reported_with_line_and_element(
    tmp_path: Path, text: str | bytes, code: str, values: dict[str, object]
) -> None:
    path = written(tmp_path, text)
    with refused(code, file=path, **values):
        read_control(path)


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        (marked(mark("A", "1")), "file.number-count", {"field": "PtIm", "count": 1, "needed": 2}),
        (
            marked(mark("A", "1 2"), mark("A", "1 2")),
            "control.mark-repeated",
            {"label": "A", "photo": "a.jpg", "first_line": 3},
        ),
        (marked(mark("A", "1 2"), photo=""), "table.value-missing", {"field": "NameIm"}),
        (marked(), "control.no-marks", {}),
        (micmac(point("A", "1 2 3")), "control.only-points", {}),
    ],
)
def test_mark_errors_are_reported(
    tmp_path: Path, text: str, code: str, values: dict[str, object]
) -> None:
    with refused(code, **values):
        read_marks(written(tmp_path, text))


# --- OpenDroneMap ------------------------------------------------------------------------------
ROWS = (
    "500000 5000000 100 10 20 a.jpg nail\n"
    "500000 5000000 100 30.5 40 b.jpg nail\n"
    "500010 5000000 101 5 6 a.jpg tree extra\n"
)


@pytest.mark.parametrize("label", ["", " G1"])
def test_opendronemap_photo_names_may_contain_spaces(tmp_path: Path, label: str) -> None:
    rows = f"1 2 3 10 20 north face/DJI 0001.JPG{label}\n1 2 3 11 21 b.jpg{label}\n"
    path = written(tmp_path, f"EPSG:32633\n{rows}", "gcp_list.txt")
    marks = read_odm(path).marks
    assert [mark.photo for mark in marks] == ["north face/DJI 0001.JPG", "b.jpg"]
    assert {mark.label for mark in marks} == {label.strip() or "GCP1"}


@pytest.mark.parametrize(
    ("header", "crs"),
    [
        ("EPSG:32633", "EPSG:32633"),
        ("WGS84 UTM 33N", "EPSG:32633"),
        ("WGS84 UTM 19S", "EPSG:32719"),
        ("+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs", "EPSG:32633"),
        ("EPSG:32633+5773", "EPSG:32633"),
    ],
)
def test_opendronemap_list_gives_points_marks_and_crs(
    tmp_path: Path, header: str, crs: str
) -> None:
    path = written(tmp_path, f"{header}\n{ROWS}", "gcp_list.txt")
    assert read_control(path) == [
        ControlPoint("nail", (500000.0, 5000000.0, 100.0)),
        ControlPoint("tree", (500010.0, 5000000.0, 101.0)),
    ]
    assert read_marks(path) == [
        Mark("nail", "a.jpg", 10.0, 20.0),
        Mark("nail", "b.jpg", 30.5, 40.0),
        Mark("tree", "a.jpg", 5.0, 6.0),
    ]
    assert read_crs(path) == crs
    assert marks_path(path) == path


@pytest.mark.parametrize("before", ["# of the drone\n", "\n", "# a\n\n# b\n", "#\n" * 20_000])
def test_a_list_may_begin_with_comments_and_blank_lines(tmp_path: Path, before: str) -> None:
    path = written(tmp_path, f"{before}EPSG:32633\n{ROWS}", "gcp_list.txt")
    assert [p.label for p in read_control(path)] == ["nail", "tree"]
    assert read_crs(path) == "EPSG:32633"
    assert find_control(tmp_path) == (path, path)


def test_unlabelled_marks_at_one_position_are_one_point(tmp_path: Path) -> None:
    text = "EPSG:32633\n\n1 2 3 10 20 a.jpg\n4 5 6 1 1 a.jpg\n1 2 3 30 40 b.jpg\n"
    path = written(tmp_path, text, "gcp_list.txt")
    assert [(p.label, p.position[0]) for p in read_control(path)] == [("GCP1", 1.0), ("GCP2", 4.0)]
    assert [(m.label, m.photo) for m in read_marks(path)] == [
        ("GCP1", "a.jpg"),
        ("GCP2", "a.jpg"),
        ("GCP1", "b.jpg"),
    ]


def test_tab_separated_names_may_contain_spaces(tmp_path: Path) -> None:
    text = "EPSG:32633\n1\t2\t3\t10\t20\tmy photo.jpg\tthe nail\n"
    path = written(tmp_path, text, "gcp_list.txt")
    assert read_marks(path) == [Mark("the nail", "my photo.jpg", 10.0, 20.0)]


def test_degrees_become_metres_of_their_utm_zone(tmp_path: Path) -> None:
    # On the central meridian of zone 33 the easting is 500 km by definition; northings from the
    # equator to 45 degrees are 4 982 950.400 m (the meridian arc of WGS 84, 4 984 944.378 m,
    # times 0.9996).
    path = written(tmp_path, "EPSG:4326\n15 45 243 1 2 a.jpg\n", "gcp_list.txt")
    (only,) = read_control(path)
    np.testing.assert_allclose(only.position, (500000.0, 4984944.378 * 0.9996, 243.0), atol=0.01)
    assert read_crs(path) == "EPSG:32633"


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("EPSG:32633\n1 2 3 4 5\n", "table.column-count", {"line": 2, "count": 5}),
        (
            "EPSG:32633\n1 2 x 4 5 a.jpg\n",
            "table.not-a-number",
            {"line": 2, "field": "z", "cell": "x"},
        ),
        (
            "EPSG:32633\n1 2 3 4 5 a.jpg p\n1 2 9 4 5 b.jpg p\n",
            "control.other-coordinates",
            {"label": "p", "first_line": 2},
        ),
        (
            "EPSG:32633\n1 2 3 4 5 a.jpg p\n1 2 3 4 5 a.jpg p\n",
            "control.mark-repeated",
            {"photo": "a.jpg", "first_line": 2},
        ),
        ("EPSG:32633\n", "control.no-points", {}),
        ("EPSG:999999\n1 2 3 4 5 a.jpg\n", "frame.unknown-crs", {"crs": "EPSG:999999"}),
        ("WGS84 UTM 99N\n1 2 3 4 5 a.jpg\n", "frame.unknown-crs", {"crs": "WGS84 UTM 99N"}),
        ("EPSG:2229\n1 2 3 4 5 a.jpg\n", "frame.not-in-metres", {}),
        ("EPSG:4326\n500 4500 3 4 5 a.jpg\n", "control.not-on-earth", {}),
        ("EPSG:4326\n-200 45 3 4 5 a.jpg p\n", "control.not-on-earth", {"label": "p"}),
        (
            "EPSG:4326\n15 45 3 4 5 a.jpg\n181 45 3 4 5 a.jpg p\n",
            "control.not-on-earth",
            {"label": "p"},
        ),
        ("+proj=rubbish +zone=2\n1 2 3 4 5 a.jpg\n", "frame.unknown-crs", {}),
    ],
)
def test_list_errors_are_reported(
    tmp_path: Path, text: str, code: str, values: dict[str, object]
) -> None:
    path = written(tmp_path, text, "gcp_list.txt")
    with refused(code, file=path, **values):
        read_control(path)


def test_crs_of_list_cannot_be_overridden(tmp_path: Path) -> None:
    path = written(tmp_path, f"EPSG:32633\n{ROWS}", "gcp_list.txt")
    assert agreed_crs(path, None) == "EPSG:32633"
    assert agreed_crs(path, "32633") == "EPSG:32633"
    with refused("frame.other-crs", UsageError, stated="EPSG:32633"):
        agreed_crs(path, "EPSG:32632")


def test_a_table_may_state_its_crs_in_a_comment(tmp_path: Path) -> None:
    table = "label,x,y,z\nA,1,2,3\n"
    for comment in ("# EPSG:32633: x east", "# CRS: epsg:32633", "#EPSG:32633"):
        assert read_crs(written(tmp_path, f"{comment}\n{table}", "a.csv")) == "EPSG:32633"
    for comment in ("# measured like EPSG:32633", "# nothing", ""):
        assert read_crs(written(tmp_path, f"{comment}\n{table}", "a.csv")) is None
    with pytest.raises(InputError) as refused:
        read_crs(written(tmp_path, f"# levelled\n# EPSG:999999\n{table}", "a.csv"))
    assert (refused.value.code, refused.value.values["crs"]) == (
        "frame.crs-unreadable",
        "EPSG:999999",
    )


@pytest.mark.parametrize("code", ["4326", "4979"])
def test_table_in_degrees_is_rejected(tmp_path: Path, code: str) -> None:
    path = written(tmp_path, f"# levelled\n# EPSG:{code}\nlabel,x,y,z\nA,15,45,3\n", "a.csv")
    for asked in (None, "EPSG:32633"):
        with refused("frame.not-projected", field="CRS"):
            agreed_crs(path, asked)


# --- Metashape ---------------------------------------------------------------------------------
METASHAPE = """<?xml version="1.0"?>
<document version="1.5.0"><chunk label="Chunk 1" enabled="true">
<sensors/><cameras><camera id="7" label="IMG_1"/><group><camera id="8" label="IMG_2.JPG"/></group>
</cameras>
<markers><marker id="0" label="A"><reference x="1" y="2" z="3" sx="0.02" sy="0.02" sz="0.02"/>
</marker><marker id="1" label="B"><reference x="4" y="5" z="6" enabled="false"/></marker>
<marker id="2" label="loose"/></markers>
<frames><frame id="0"><markers>
<marker marker_id="0"><location camera_id="7" pinned="true" x="10" y="20"/>
<location camera_id="8" pinned="false" x="1" y="1"/></marker>
<marker marker_id="2"><location camera_id="8" x="30.5" y="40"/></marker>
</markers></frame></frames>
<reference>EPSG::32633</reference></chunk></document>
"""


def test_markers_of_metashape_are_read(tmp_path: Path) -> None:
    path = written(tmp_path, METASHAPE.replace("::", ":"))
    assert read_control(path) == [
        ControlPoint("A", (1.0, 2.0, 3.0), pytest.approx(0.02)),
        ControlPoint("B", (4.0, 5.0, 6.0), None, True),
    ]
    # What the program guessed itself is no mark.
    assert read_marks(path) == [Mark("A", "IMG_1", 10, 20), Mark("loose", "IMG_2.JPG", 30.5, 40)]
    assert read_crs(path) == "EPSG:32633"
    assert marks_path(path) == path


@pytest.mark.parametrize(
    ("stated", "crs"), [("<reference>EPSG:32634</reference>", "EPSG:32634"), ("", None)]
)
def test_crs_is_taken_from_the_chunk_with_markers(
    tmp_path: Path, stated: str, crs: str | None
) -> None:
    marker = '<marker id="0" label="A"><reference x="1" y="2" z="3"/></marker>'
    text = (
        '<document><chunks><chunk label="a"><reference>EPSG:32633</reference></chunk>'
        f'<chunk label="b"><markers>{marker}</markers>{stated}</chunk></chunks></document>'
    )
    assert read_crs(written(tmp_path, text)) == crs


@pytest.mark.parametrize(
    ("old", "new", "code", "values"),
    [
        (
            'x="1" y="2"',
            'x="one" y="2"',
            "table.not-a-number",
            {"field": "reference, x", "cell": "one"},
        ),
        ('y="2" z="3"', 'y="2"', "file.missing-element", {"field": "reference", "name": "z"}),
        ('label="B"', 'label="A"', "table.repeated-label", {"label": "A", "first_line": 5}),
        ("markers>", "lost>", "control.no-chunk", {}),
    ],
)
def test_marker_errors_are_reported(
    tmp_path: Path, old: str, new: str, code: str, values: dict[str, object]
) -> None:
    with refused(code, **values):
        read_control(written(tmp_path, METASHAPE.replace("::", ":").replace(old, new)))


def test_mark_in_unknown_camera_is_reported(tmp_path: Path) -> None:
    text = METASHAPE.replace('camera_id="7"', 'camera_id="9"')
    with refused("control.unknown-key", name="camera_id", key="9"):
        read_marks(written(tmp_path, text))


# --- names and places --------------------------------------------------------------------------
def test_photos_are_matched_by_file_name_and_without_extension() -> None:
    find = photo_finder(["left/a.JPG", "right/a.JPG", "left/b.jpg", "c.tif", "c.jpg"])
    assert find("right/a.JPG") == 1
    assert find("a.JPG") is None, "of two photos"
    assert find("elsewhere/B.JPG") == 2
    assert find("b") == 2
    assert find("c") is None
    assert find("b.tif") is None


def test_control_beside_photos_is_found_only_with_its_marks(tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    written(tmp_path, "label,x,y,z\n", "control.csv")
    assert find_control(photos) is None
    written(tmp_path, "label,photo,x,y\n", "marks.csv")
    assert find_control(photos) == (tmp_path / "control.csv", tmp_path / "marks.csv")
    listed = written(photos, f"EPSG:32633\n{ROWS}", "gcp_list.txt")
    assert find_control(photos) == (listed, listed)


POINTS_OF_MICMAC = """<?xml version="1.0" ?>
<DicoAppuisFlottant><OneAppuisDAF><Pt>1 2 3</Pt><NamePt>A</NamePt>
<Incertitude>1 1 1</Incertitude></OneAppuisDAF></DicoAppuisFlottant>"""
MARKS_OF_MICMAC = """<?xml version="1.0" ?>
<SetOfMesureAppuisFlottants><MesureAppuiFlottant1Im><NameIm>a.jpg</NameIm><OneMesureAF1I>
<NamePt>A</NamePt><PtIm>10 20</PtIm></OneMesureAF1I></MesureAppuiFlottant1Im>
</SetOfMesureAppuisFlottants>"""


def test_micmac_control_beside_photos_is_found_by_content(tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    assert find_program_control(photos) is None
    points = written(tmp_path, POINTS_OF_MICMAC, "Ground-Pts3D.xml")
    assert find_program_control(photos) is None, "points without marks place nothing"
    marks = written(tmp_path, MARKS_OF_MICMAC, "GroundMeasure.xml")
    written(tmp_path, "<camera/>", "AutoCal.xml")
    assert find_program_control(photos) == (points, marks)
    assert [p.label for p in read_control(points)] == ["A"]
    written(tmp_path, POINTS_OF_MICMAC, "older.xml")
    assert find_program_control(photos) is None, "of two files nobody knows which is meant"


def test_swapped_longitude_and_latitude_are_reported(tmp_path: Path) -> None:
    """A list of OpenDroneMap in degrees; beyond 90 degrees by itself, else by the CRS asked for."""
    far = "EPSG:4326\n47.5 -122.2 30 100 200 a.jpg p1\n47.6 -122.3 31 110 210 b.jpg p2\n"
    with pytest.raises(InputError) as refused:
        read_control(written(tmp_path, far, "gcp_list.txt"))
    assert refused.value.code == "control.swapped-degrees"
    polar = "EPSG:4326\n15 -95 3 4 5 a.jpg p\n"
    with pytest.raises(InputError) as refused:
        read_control(written(tmp_path, polar, "gcp_list.txt"))
    assert refused.value.code == "control.swapped-degrees"
    assert (refused.value.values["longitude"], refused.value.values["latitude"]) == (15.0, -95.0)
    near = "EPSG:4326\n46.1 13.2 30 100 200 a.jpg p1\n46.2 13.3 31 110 210 b.jpg p2\n"
    path = written(tmp_path, near, "gcp_list.txt")
    with pytest.raises(InputError) as refused:
        agreed_crs(path, "EPSG:32633")
    assert refused.value.code == "control.swapped-degrees"
