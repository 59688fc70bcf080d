"""Drawings and their sidecars, of which a few lines unfold without end or hold no sense."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.drawings import read_lines
from tests.messages import by_code, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import InputError
from vomstudio.io.gis.dxf_blocks import MAX_EXPANDED_ENTITIES
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.gis.svg_lines import read_svg
from vomstudio.products.ortho.back_projection import read_drawing, read_sidecar

LINE = "0\nLINE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n1\n21\n2\n31\n0\n"
READERS: list[Callable[[Path], Any]] = [read_gis_lines, read_lines]


# --- DXF ----------------------------------------------------------------------------------------
def block(name: str, inside: str) -> str:
    place = "10\n0\n20\n0\n30\n0\n"
    return f"0\nBLOCK\n8\n0\n2\n{name}\n70\n0\n{place}3\n{name}\n{inside}0\nENDBLK\n8\n0\n"


def insert(name: str, more: str = "") -> str:
    return f"0\nINSERT\n8\n0\n2\n{name}\n10\n0\n20\n0\n30\n0\n{more}"


def dxf(path: Path, blocks: str, entities: str, end: str = "\n") -> Path:
    text = (
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n0\nENDSEC\n"
        "0\nSECTION\n2\nTABLES\n0\nENDSEC\n"
        f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n"
        f"0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
    path.write_bytes(text.replace("\n", end).encode())
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("read", READERS)
def test_nested_blocks_are_counted_before_expansion(
    tmp_path: Path, read: Callable[[Path], Any], end: str
) -> None:
    nested = "".join(block(f"B{k}", insert(f"b{k + 1}") * 10) for k in range(9))
    path = dxf(tmp_path / "a.dxf", nested + block("B9", LINE), insert("B0"), end)
    begun = time.process_time()
    with refused("drawing.nested-blocks", count="1e+09") as refusal:
        read(path)
    assert refusal.value.file == str(path)
    assert time.process_time() - begun < 2


@pytest.mark.parametrize(
    ("blocks", "entities"),
    [
        (block("B", LINE), insert("B", "70\n30000\n71\n30000\n44\n1\n45\n1\n")),
        (block("B", LINE * 2000), insert("B") * 2000),
        (block("B", insert("B") + LINE), insert("B")),
        (block("B", insert("C")) + block("C", insert("B") + LINE), insert("B")),
    ],
    ids=["a grid", "many in many", "itself", "each other"],
)
def test_other_unbounded_block_expansions_are_rejected(
    tmp_path: Path, blocks: str, entities: str
) -> None:
    with refused("drawing.nested-blocks"):
        read_gis_lines(dxf(tmp_path / "a.dxf", blocks, entities))


def test_ordinary_nested_blocks_are_expanded(tmp_path: Path) -> None:
    """A value of 0, 2 or 70 is no code, whatever follows it."""
    odd = "0\nLINE\n8\n2\n62\n70\n10\n0\n20\n2\n30\n0\n11\n1\n21\n2\n31\n70\n"
    places = insert("TREE") * 30 + insert("TREE", "70\n3\n71\n2\n44\n9\n45\n9\n")
    path = dxf(
        tmp_path / "a.dxf", block("TWIG", odd) + block("TREE", LINE + insert("TWIG")), places
    )
    assert len(read_gis_lines(path).lines) == 2 * (30 + 3 * 2)
    assert MAX_EXPANDED_ENTITIES > 2 * 36


# --- SVG ----------------------------------------------------------------------------------------
def svg(path: Path, body: str) -> Path:
    path.write_text(f'<svg width="100" height="80" viewBox="0 0 100 80">{body}</svg>')
    return path


@pytest.mark.parametrize(
    "words",
    first_in_default_tier([" l 1 1", " a 9 9 0 1 1 3 3", " c 1 1 2 3 3 3", " s 1 2 3 3"], 1),
)
def test_svg_path_with_too_many_parts_is_rejected_quickly(tmp_path: Path, words: str) -> None:
    path = svg(tmp_path / "a.svg", f'<path d="M 1 1{words * 500_000}"/>')
    begun = time.process_time()
    with refused("file.too-many-parts", limit=500_000, file=path):
        read_svg(path)
    assert time.process_time() - begun < 5


def test_svg_numbers_that_overflow_are_rejected(tmp_path: Path) -> None:
    path = svg(tmp_path / "a.svg", '<path d="M 1 1 a 1e300 1e300 0 1 1 3e200 3"/>')
    with refused("file.damaged", format="SVG", file=path):
        read_svg(path)
    turned = "scale(1e300) " * 3
    path = svg(tmp_path / "b.svg", f'<g transform="{turned}"><path d="M 0 0 L 9 9"/></g>')
    with pytest.raises(InputError):
        read_drawing(path, read_sidecar(sidecar(tmp_path)))


def test_svg_curves_match_their_formulas(tmp_path: Path) -> None:
    """Bernstein's polynomials, and an arc of a circle about its centre."""
    path = svg(
        tmp_path / "a.svg",
        '<path d="M 0 0 C 0 8 8 8 8 0"/><path d="M 0 0 Q 4 8 8 0"/>'
        '<path d="M 10 0 A 5 5 0 0 1 20 0"/>',
    )
    cubic, square, arc = (line.points for line in read_svg(path).lines)
    t = np.arange(17) / 16
    x = 24 * t**2 * (1 - t) + 8 * t**3
    y = 24 * (t * (1 - t) ** 2 + t**2 * (1 - t))
    np.testing.assert_allclose(cubic, np.column_stack([x, y]), atol=1e-12)
    np.testing.assert_allclose(square, np.column_stack([8 * t, 16 * t * (1 - t)]), atol=1e-12)
    np.testing.assert_allclose(np.hypot(*(arc - [15, 0]).T), 5, atol=1e-12)
    assert arc[-1].tolist() == [20, 0]


# --- sidecars -----------------------------------------------------------------------------------
def sidecar(folder: Path, **changed: Any) -> Path:
    facts = {
        "pixel_to_world": np.eye(4).tolist(),
        "geotransform": [1, 0, 0, 0, -1, 80],
        "width": 100,
        "height": 80,
        "plane_coordinates": None,
        "crs": "EPSG:32633",
        "picture_id": "a",
    }
    path = folder / "s.json"
    path.write_text(json.dumps({**facts, **changed}))
    return path


def test_sidecars_with_invalid_values_are_rejected_by_name(tmp_path: Path) -> None:
    assert read_sidecar(sidecar(tmp_path)).width == 100
    for odd in (
        {"width": float("inf")},
        {"geotransform": [10**400, 0, 0, 0, 1, 0]},
        {"geotransform": [0] * 6},
        {"pixel_to_world": np.zeros((4, 4)).tolist()},
        {"width": 10**300},
        {"pixel_to_world": [[float("nan")] * 4] * 4},
    ):
        path = sidecar(tmp_path, **odd)
        with pytest.raises(InputError) as refusal:
            read_sidecar(path)
        assert refusal.value.file == str(path)
    path.write_text("[" * 200_000)
    with refused("sidecar.other-file"):
        read_sidecar(path)
    assert read_sidecar(sidecar(tmp_path, crs=[1], content_hash={})).crs is None


def test_shapes_with_nan_coordinates_are_skipped_and_counted(tmp_path: Path) -> None:
    odd = LINE.replace("10\n0", "10\nnan")
    lines, warnings = read_drawing(
        dxf(tmp_path / "a.dxf", "", LINE * 3 + odd), read_sidecar(sidecar(tmp_path))
    )
    assert all(np.isfinite(line.points).all() for line in lines)
    assert len(lines) == 3
    assert by_code(warnings)["drawing.invalid-shapes"] == {"count": 1}
    with refused("drawing.no-traces"):
        read_drawing(dxf(tmp_path / "b.dxf", "", odd), read_sidecar(sidecar(tmp_path)))


@pytest.mark.parametrize("numbers", ["2" * 3000, "1 " * 3000, "1,1,0,1" * 2000])
def test_ambiguous_arc_numbers_are_rejected_quickly(tmp_path: Path, numbers: str) -> None:
    path = svg(tmp_path / "a.svg", f'<path d="M 1 1 a{numbers}"/>')
    begun = time.process_time()
    with refused("file.damaged", format="SVG", file=path):
        read_svg(path)
    assert time.process_time() - begun < 5


@pytest.mark.parametrize("style", ["a" * 3_000_000, "/*" * 1_500_000, ".a{}" * 700_000])
def test_malicious_style_sheets_are_parsed_quickly(tmp_path: Path, style: str) -> None:
    path = svg(tmp_path / "a.svg", f'<style>{style}</style><path class="a" d="M 1 1 L 2 2"/>')
    begun = time.process_time()
    assert len(read_svg(path).lines) == 1
    assert time.process_time() - begun < 5


# --- GeoJSON ------------------------------------------------------------------------------------
@pytest.mark.parametrize("read", first_in_default_tier(READERS))
def test_too_many_distinct_property_names_are_rejected(
    tmp_path: Path, read: Callable[[Path], Any]
) -> None:
    """Two megabytes would be a table of 400 million cells."""
    shapes = [
        {
            "type": "Feature",
            "properties": {f"p{k}": 1},
            "geometry": {"type": "LineString", "coordinates": [[1, 2], [3, 4]]},
        }
        for k in range(20_000)
    ]
    path = tmp_path / "a.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": shapes}))
    with refused("file.too-many-parts", limit=2000, file=path):
        read(path)


@pytest.mark.parametrize("path", ["M 0 0 L 9 9 z 5 5", "M1 1h4v4Z7,7 8,8", "m0 0 1 1z.5"])
def test_number_after_closepath_is_rejected(path: str, tmp_path: Path) -> None:
    # SVG 1.1, 8.3.1: a command follows closepath, or nothing does.
    drawing = tmp_path / "a.svg"
    drawing.write_text(f'<svg xmlns="http://www.w3.org/2000/svg"><path d="{path}"/></svg>')
    done = threading.Event()

    def read() -> None:
        with refused("file.damaged", format="SVG"):
            read_svg(drawing)
        done.set()

    threading.Thread(target=read, daemon=True).start()
    assert done.wait(5)


@pytest.mark.parametrize("place", ["20\n1e+20\n", "0\nENDSEC\n", "9\n$ACADVER\n"])
@pytest.mark.parametrize("count", [1, 8, 5000])
def test_null_bytes_inside_a_drawing_are_rejected(place: str, count: int, tmp_path: Path) -> None:
    # GDAL 3.11 reads some of these without end.
    path = dxf(tmp_path / "a.dxf", "", LINE)
    text = path.read_text()
    if place not in text:
        text = text.replace("9\n$ACADVER", f"9\n$EXTMIN\n10\n1e+20\n{place}9\n$ACADVER")
    at = text.index(place) + len(place) - 1
    path.write_bytes(text[:at].encode() + b"\0" * count + text[at:].encode())
    for read in READERS:
        with refused("file.blank", byte=at + 1) as refusal:
            read(path)
        assert refusal.value.file == str(path)


def test_null_bytes_after_the_end_of_a_drawing_are_ignored(tmp_path: Path) -> None:
    path = dxf(tmp_path / "a.dxf", "", LINE)
    path.write_bytes(path.read_bytes() + bytes(4096))
    assert len(read_gis_lines(path).lines) == 1
