"""The page about a reconstruction says what was found, in units, and nothing that is not known."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path
from typing import Any

import pytest

from vomstudio.core.findings import Finding
from vomstudio.products.report.reconstruction import FRAME_NAMES, LABELS, write_report
from vomstudio.registration.summary import FACT_NAMES


def result(**more: Any) -> dict[str, Any]:
    photo = {
        "name": "a<b>.jpg",
        "width": 600,
        "height": 400,
        "camera": None,
        "tie_points": 900,
        "error_px": 0.31,
        "placed": True,
        "gsd_m": 0.0123,
        "exposure": 1.0,
        "residual_m": None,
    }
    return {
        "folder": "x/cliff",
        "registered": 1,
        "photos": 1,
        "reprojection_error_px": 0.31,
        "tie_points": 1200,
        "tie_points_of_3": 1100,
        "dense_points": 50000,
        "faces": 4000,
        "frame": "local",
        "scaled": False,
        "warnings": ["look & see"],
        "drawing": {"points": [[0.0, 0.0, 0.0]], "at": [[1.0, 2.0, 3.0]], "looks": [[0, 1, 0]]},
        "survey": {"verdict": "sound", "findings": [], "next_time": []},
        "photo_rows": [photo],
        "calibration": [],
        "registration": {"refused": "no positions"},
        "model": {"texel": 0.02, "share_of_the_surface_that_no_photo_sees": 0.1},
        "seconds": {"alignment": 1.0, "cloud": 2.5},
        "peak_memory_mb": 800.0,
        "settings": {"quality": "low"},
        "versions": {"pycolmap": "4"},
    } | more


def page(tmp_path: Path, **more: Any) -> str:
    write_report(tmp_path / "r.html", result(**more))
    return (tmp_path / "r.html").read_text("utf-8")


def test_warnings_may_be_sentences_or_findings(tmp_path: Path) -> None:
    finding = Finding("photo.angles-not-measured", photos=3, photo="a<b>.jpg")
    text = page(tmp_path, warnings=["look & see", finding.to_dict()])
    assert escape("look & see") in text
    assert escape(finding.message) in text


def test_names_are_escaped_as_text(tmp_path: Path) -> None:
    text = page(tmp_path)
    assert "a&lt;b&gt;.jpg" in text
    assert "a<b>" not in text
    assert escape("look & see") in text


def test_model_without_scale_has_no_metres(tmp_path: Path) -> None:
    text = page(tmp_path)
    assert FRAME_NAMES["arbitrary"] in text
    assert LABELS["texel"].format(unit="units") in text


def test_local_control_points_give_scale_and_errors_with_units(
    tmp_path: Path,
) -> None:
    turn = {"about_up": 0.02, "about_east": 0.05, "about_north": 0.03}
    registration = {
        "method": "ground control points",
        "rms_check_m": 0.011,
        "adjusted_together_with_the_cameras": True,
        "rotation_error_deg": turn,
    }
    text = page(tmp_path, scaled=True, registration=registration)
    assert FRAME_NAMES["arbitrary"] not in text
    assert LABELS["texel"].format(unit="m") in text
    cells = re.findall("<td>(.*?)</td>", text)
    for code, value in (("rms-check", "0.011 m"), ("turned-about-east", "± 0.098°")):
        assert cells[cells.index(FACT_NAMES[code]) + 1] == value


@pytest.mark.parametrize("text", ["http://", "https://", "<script"])
def test_report_page_is_a_single_self_contained_file(tmp_path: Path, text: str) -> None:
    # SVG names its namespaces and matplotlib its maker; nothing is fetched.
    bare = re.sub(r"data:image[^\"]*", "", page(tmp_path))
    assert text not in bare
