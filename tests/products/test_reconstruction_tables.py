"""The tables and the drawing of the page about a reconstruction, read back number by number."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from html import escape, unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver

from tests.messages import shown_codes, shown_values
from tests.products.test_reconstruction_report import result
from vomstudio.products.report.reconstruction import FRAME_NAMES, LABELS, write_report
from vomstudio.registration import summary

Row = tuple[str, list[str]]
Pages = Callable[..., str]


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pages:
    """Writes a page without its drawing, which takes the time, and reads it."""
    monkeypatch.setattr(FigureCanvasSVG, "print_svg", lambda *_: None)

    def output(**more: Any) -> str:
        write_report(tmp_path / "r.html", result(**more))
        return (tmp_path / "r.html").read_text("utf-8")

    return output


def tables(html: str, heading: str) -> list[list[Row]]:
    """(class, cells) of every row of the tables under a heading."""
    part = html.split(f"<h2>{heading}</h2>")[1].split("<h2>")[0]
    return [
        [
            (
                (re.findall(r'class="(.*?)"', attributes) or [""])[0],
                [unescape(cell) for cell in re.findall(r"<t[hd]>(.*?)</t[hd]>", row)],
            )
            for attributes, row in re.findall(r"<tr(.*?)>(.*?)</tr>", table)
        ]
        for table in re.findall(r"<table>(.*?)</table>", part, re.DOTALL)
    ]


def by_code(rows: list[Row]) -> dict[str, str]:
    """The facts of a registration in a table, by their codes."""
    codes = {name: code for code, name in summary.FACT_NAMES.items()}
    return {codes[cells[0]]: cells[1] for _, cells in rows if cells[0] in codes}


def photo(name: str, error: float | None, **more: Any) -> dict[str, Any]:
    row = {
        "name": name,
        "width": 6000,
        "height": 4000,
        "camera": "Maker 24 mm",
        "tie_points": 1234,
        "error_px": error,
        "placed": error is not None,
        "gsd_m": 0.00345,
        "exposure": 1.256,
        "residual_m": 2.345,
    }
    return row | more


def test_weak_photos_and_twice_the_typical_error_are_highlighted(page: Pages) -> None:
    """The typical one is the median of those that are placed: 0.4 pixels."""
    rows = [
        photo("a", 0.3, position_error95_m=0.01234, rotation_error95_deg=0.0456),
        photo("b", 0.4),
        photo("c", 0.8),
        photo("d", 0.81),
        photo("e", 0.2, is_weak=True),
        photo("f", None, gsd_m=None, exposure=float("nan"), residual_m=None, camera=None),
    ]
    ((head, *body),) = tables(page(photo_rows=rows, scaled=True), "Photos")
    assert head[1] == [
        "photo",
        "size",
        "camera",
        "tie points",
        "error, px",
        "GSD, m",
        "exposure gain",
        "GPS residual, m",
        "position ± (95 %), m",
        "rotation ± (95 %), °",
    ]
    assert [kind for kind, _ in body] == ["", "", "", "out", "out", "out"]
    assert body[0][1] == [
        "a",
        "6000 × 4000",
        "Maker 24 mm",
        "1,234",
        "0.30",
        "0.0034",
        "1.26",
        "2.35",
        "0.0123",
        "0.046",
    ]
    assert body[5][1] == ["f", "6000 × 4000", "unknown", "not aligned", *6 * ["–"]]
    ((head, *_),) = tables(page(photo_rows=rows), "Photos")
    assert "GSD, units" in head[1]
    lost = [photo("f", None)]
    ((_, only),) = tables(page(photo_rows=lost), "Photos")
    assert only[0] == "out"


def test_camera_tables_show_fixed_and_estimated_values_with_errors(page: Pages) -> None:
    camera = {
        "camera": "Maker <24>",
        "model": "OPENCV",
        "width": 6000,
        "height": 4000,
        "photos": 12,
        "rule": "focal length & distortion refined",
        "names": ["f", "cx", "k1"],
        "params": [4123.456789, 3000.0, -0.0123456789],
        "sigma": [1.234, 0.0, None],
        "free": ["f", "k1"],
        "correlation": [[1.0, -0.256], [-0.256, 1.0]],
    }
    html = page(calibration=[camera, camera | {"camera": None, "correlation": []}])
    first, correlation, second = tables(html, "Cameras")
    assert first == [
        ("", ["parameter", "value", "standard error"]),
        ("", ["f", "4123.46", "± 1.2"]),
        ("", ["cx", "3000", "fixed"]),
        ("", ["k1", "-0.0123457", "unknown"]),
    ]
    assert [cells for _, cells in correlation] == [
        ["", "f", "k1"],
        ["f", "+1.00", "-0.26"],
        ["k1", "-0.26", "+1.00"],
    ]
    assert second == first
    text = unescape(html)
    assert "<h3>Maker <24></h3>" in text
    assert "<h3>unknown camera</h3>" in text
    assert f"OPENCV, 6000 × 4000, 12 photos. {camera['rule']}" in text
    assert text.count("<p>Correlation</p>") == 1


@pytest.mark.full
def test_points_are_listed_with_their_residuals(page: Pages) -> None:
    def point(label: str, role: str, residual: list[float] | None, px: float | None) -> Any:
        return {
            "label": label,
            "role": role,
            "photos": 7,
            "residual_m": residual,
            "residual_px": px,
        }

    points = [
        point("A", "control", [0.0012, -0.0034, 0.0], 0.456),
        point("B", "check", [1.0, 2.0, -3.0], 1.0),
        point("C", "left out", [9.0, 9.0, 9.0], 20.0),
        point("D", "unseen", None, None),
    ]
    facts, listed = tables(
        page(registration={"method": "ground control points", "points": points}), "Registration"
    )
    assert by_code(facts) == {"method": summary.METHOD_NAMES["control"]}
    assert listed == [
        ("", ["point", "used as", "photos", "east, m", "north, m", "up, m", "error, px"]),
        ("", ["A", "control", "7", "0.001", "-0.003", "0.000", "0.46"]),
        ("", ["B", "check", "7", "1.000", "2.000", "-3.000", "1.00"]),
        ("out", ["C", "left out", "7", "9.000", "9.000", "9.000", "20.00"]),
        ("out", ["D", "unseen", "7", "–", "–", "–", "–"]),
    ]
    report = {"method": "camera positions (GPS)", "points": []}
    (alone,) = tables(page(registration=report), "Registration")
    assert by_code(alone) == {"method": summary.METHOD_NAMES["gps"]}
    assert {"reconstruct.local-frame", "reconstruct.register-later"} <= shown_codes(
        unescape(page())
    )
    assert "no positions" in page()


def test_facts_are_formatted_by_their_type(page: Pages) -> None:
    model = {
        "texel": 0.0123456,
        "faces": 1234567,
        "closed": False,
        "coloured": True,
        "nothing": None,
        "sides": {"left": 2, "right": 0.25},
        "name": "x <y>",
    }
    ((_, *rows),) = tables(page(model=model, scaled=True), "Model")
    assert [cells for _, cells in rows] == [
        [LABELS["texel"].format(unit="m"), "0.01235"],
        [LABELS["faces"], "1,234,567"],
        ["closed", "no"],
        ["coloured", "yes"],
        ["sides, left", "2"],
        ["sides, right", "0.25"],
        ["name", "x <y>"],
    ]


def test_times_have_a_total_and_memory_a_unit(page: Pages) -> None:
    html = page(seconds={"alignment": 12.34, "cloud": 100.06}, peak_memory_mb=12345.6)
    times, settings = tables(html, "Time, memory, settings")
    assert [cells for _, cells in times[1:]] == [
        ["alignment", "12.3 s"],
        ["fusion", "100.1 s"],
        ["total", "112.4 s"],
        ["peak memory", "12,346 MB"],
    ]
    assert [cells for _, cells in settings[1:]] == [["quality", "low"], ["pycolmap", "4"]]


def test_summary_states_counts_and_the_frame(page: Pages) -> None:
    def summarize_registration(html: str) -> str:
        return html.split("<p>")[1].split("</p>")[0]

    more = {"registered": 9, "photos": 12, "reprojection_error_px": 0.456, "tie_points": 12345}
    text = summarize_registration(page(**more))
    aligned = {"registered": "9", "photos": "12", "error_px": "0.46"}
    assert shown_values(text, "reconstruction.aligned") == aligned
    tie_points = {"tie_points": "12,345", "in_three": "1,100"}
    assert shown_values(text, "reconstruction.tie-points") == tie_points
    size = {"points": "50,000", "faces": "4,000"}
    for html, frame in (
        (text, FRAME_NAMES["arbitrary"]),
        (summarize_registration(page(scaled=True)), FRAME_NAMES["scaled"]),
        (summarize_registration(page(scaled=True, frame="EPSG:32615")), "EPSG:32615"),
    ):
        assert shown_values(html, "reconstruction.size") == size | {"frame": frame}


def test_findings_and_advice_are_listed_only_if_present(page: Pages) -> None:
    def survey(html: str) -> str:
        return html.split("<h2>Survey</h2>")[1].split("<h2>")[0]

    bare = {"verdict": "sound & good", "findings": [], "next_time": []}
    verdict = "<p>sound &amp; good</p>"
    assert survey(page(survey=bare)) == verdict
    findings = [{"message": "few <oblique>"}, {"message": "dark"}]
    listed = f"{verdict}<ul><li>{escape('few <oblique>')}</li><li>dark</li></ul>"
    assert survey(page(survey=bare | {"findings": findings})) == listed
    advice = f"{verdict}<p>Next time:</p><ul><li>closer</li></ul>"
    assert survey(page(survey=bare | {"next_time": ["closer"]})) == advice


@pytest.mark.parametrize(("scaled", "unit"), [(True, "m"), (False, "model units")])
def test_the_drawing_shows_cameras_and_points_from_above_and_from_the_south(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scaled: bool, unit: str
) -> None:
    figures: list[Figure] = []

    def kept(canvas: FigureCanvasSVG, file: Any) -> None:
        figures.append(canvas.figure)
        file.write(b"<svg>drawn</svg>")

    monkeypatch.setattr(FigureCanvasSVG, "print_svg", kept)
    rng = np.random.default_rng(0)
    points, at, looks = (rng.normal(size=(n, 3)) for n in (30, 4, 4))
    for cloud in (points, points[:0]):
        drawing = {"points": cloud.tolist(), "at": at.tolist(), "looks": looks.tolist()}
        write_report(tmp_path / "r.html", result(scaled=scaled, drawing=drawing))
        html = (tmp_path / "r.html").read_text("utf-8")
        (data,) = re.findall(r"base64,([^\"]*)", html)
        assert base64.b64decode(data) == b"<svg>drawn</svg>"
        for axes, (i, j), title in zip(
            figures.pop().axes, ((0, 1), (0, 2)), ("from above", "from the south"), strict=True
        ):
            assert axes.get_title() == title
            assert axes.get_xlabel() == f"{'xyz'[i]}, {unit}"
            assert axes.get_ylabel() == f"{'xyz'[j]}, {unit}"
            assert axes.get_aspect() == 1.0
            shown = [np.asarray(line.get_xydata()) for line in axes.lines]
            expected = [c[:, [i, j]] for c in (cloud, at) if len(c)]
            assert len(shown) == len(expected)
            for one, other in zip(shown, expected, strict=True):
                assert one == pytest.approx(other)
            (arrows,) = [c for c in axes.collections if isinstance(c, Quiver)]
            assert np.asarray(arrows.XY) == pytest.approx(at[:, [i, j]])
            assert np.column_stack([arrows.U, arrows.V]) == pytest.approx(looks[:, [i, j]])


def test_drawing_is_as_wide_as_the_page_and_readable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Shrunk to the page's column its words would be too small; a narrow one leaves white beside
    it. Arrows and dots are seen, and hide little of what is under them."""
    figures: list[Figure] = []
    monkeypatch.setattr(
        FigureCanvasSVG, "print_svg", lambda canvas, _: figures.append(canvas.figure)
    )
    rng = np.random.default_rng(0)
    drawing = {name: rng.normal(size=(30, 3)).tolist() for name in ("points", "at", "looks")}
    write_report(tmp_path / "r.html", result(drawing=drawing))
    (figure,) = figures
    FigureCanvasAgg(figure)
    html = (tmp_path / "r.html").read_text("utf-8")
    ((letter, column),) = re.findall(r"body { font: (\d+)px.*?max-width: (\d+)em", html)
    css_px = 96.0
    width = figure.get_size_inches()[0] * css_px
    assert 0.9 < width / (float(letter) * float(column)) <= 1.0
    figure.draw_without_rendering()
    for axes in figure.axes:
        box = axes.get_window_extent()
        assert 1.0 < box.width / box.height < 1.5
        words = [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.get_xticklabels()]
        for text in words:
            assert 0.8 * float(letter) < text.get_fontsize() / 72.0 * css_px < 1.2 * float(letter)
        mm = 25.4 * box.width / figure.dpi
        (arrows,) = [c for c in axes.collections if isinstance(c, Quiver)]
        assert 0.3 < float(arrows.width) * mm < 0.6
        assert arrows.scale is not None
        assert 4.0 < mm / arrows.scale < 8.0
        dots = axes.lines[-1].get_markersize() * 25.4 / 72.0
        assert 0.8 < dots < 1.6
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    assert boxes[0] is not None
    assert boxes[1] is not None
    assert not boxes[0].overlaps(boxes[1])


def test_a_page_does_not_grow_with_the_number_of_tie_points(tmp_path: Path) -> None:
    """They are thousands; in the drawing they are a picture, and not a mark each."""
    rng = np.random.default_rng(0)
    at = {"at": [[1.0, 2.0, 3.0]], "looks": [[0, 1, 0]]}
    sizes = []
    for n in (500, 20_000):
        drawing = {"points": rng.normal(size=(n, 3)).tolist(), **at}
        write_report(tmp_path / "r.html", result(drawing=drawing))
        sizes.append((tmp_path / "r.html").stat().st_size)
    assert sizes[1] < sizes[0] + 100_000


@pytest.mark.full
def test_registration_section_reports_its_errors(
    page: Pages, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Turned about north by 0.5 degrees (1 sigma) at most: 0.98 at 95 %."""
    covariance = np.diag([*(np.radians([0.2, 0.5, 0.1]) ** 2), 0.001**2, 0.0, 0.0, 0.0])
    points = [
        {
            "label": f"G{i}",
            "role": "check" if i == 3 else "control",
            "photos": 4,
            "residual_m": [0.01, 0.0, -0.02],
            "residual_px": 0.4,
            "surveyed": [10.0 * i, 5.0 * i * i, 3.0],
        }
        for i in range(4)
    ]
    registration = {
        "method": "ground control points",
        "crs": "EPSG:32633",
        "rms_control_m": 0.022,
        "rms_check_m": 0.031,
        "scale_error": 0.001,
        "rotation_error_deg": {"about_up": 0.1, "about_east": 0.2, "about_north": 0.5},
        "covariance": covariance.tolist(),
        "centre": [0.0, 0.0, 0.0],
        "points": points,
        "warnings": ["Look at G2."],
    }
    drawn: list[Figure] = []
    monkeypatch.setattr(FigureCanvasSVG, "print_svg", lambda canvas, _: drawn.append(canvas.figure))
    html = page(registration=registration, frame="EPSG:32633", scaled=True)
    rows, listed = tables(html, "Registration")
    assert [cells[0] for _, cells in listed[1:]] == ["G0", "G1", "G2", "G3"]
    report = by_code(rows)
    assert report["method"] == summary.METHOD_NAMES["control"]
    assert (report["control-points"], report["check-points"]) == ("3", "1")
    assert (report["rms-control"], report["rms-check"]) == ("0.022 m", "0.031 m")
    assert report["turned-about-north"] == "± 0.98°"
    assert report["weakest-axis"].endswith("/00 ± 0.98°")
    assert report["scale"] == "± 0.2 %"
    part = html.split("<h2>Registration</h2>")[1].split("<h2>")[0]
    assert "Look at G2." in part
    assert {"control.no-redundancy", "registration.weakest-axis"} <= shown_codes(part)
    # The map of residuals with the weakest axis, which is north; what was refused has none.
    assert "<img " in part
    above = drawn[-1].axes[0]
    (axis,) = [line for line in above.lines if line.get_linestyle() == "--"]
    assert np.ptp(np.asarray(axis.get_xydata()), axis=0) == pytest.approx([0.0, 1.1 * 45.0])
    refused = page().split("<h2>Registration</h2>")[1].split("<h2>")[0]
    assert "reconstruct.register-later" in shown_codes(unescape(refused))
    assert "<img " not in refused
